//! Pieces of a solid as the search sees them: surface triangles and caps.
//!
//! A piece is `solid ∩ half-spaces`. Its surface triangles come from the
//! solid; each cut leaves a *cap*, kept as directed segments on the cutting
//! plane and never triangulated. Together they are a closed signed chain, so
//! volumes follow from the divergence theorem, and the end points of all
//! segments hold every extreme point, corners inside the solid included.

mod border;
mod half;
mod split;
#[cfg(test)]
mod tests;

use assetpipe_geometry::{Mesh, Plane};
use glam::DVec3;

/// The planar region a cut left open, by its border.
#[derive(Clone, Debug)]
pub struct Cap {
    /// The plane it lies on; the piece is *below*.
    pub plane: Plane,
    /// Directed border segments, counter-clockwise seen from above.
    pub border: Vec<[u32; 2]>,
}

/// A closed signed chain of surface triangles and caps.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Surface triangles, outward.
    pub triangles: Vec<[u32; 3]>,
    /// What the cuts left open.
    pub caps: Vec<Cap>,
}

impl From<&Mesh> for Piece {
    fn from(mesh: &Mesh) -> Self {
        Piece {
            points: mesh.vertices.clone(),
            triangles: mesh.triangles.clone(),
            caps: Vec::new(),
        }
    }
}

impl Piece {
    /// Bounding box as (low, high); (0, 0) when empty.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let Some(&first) = self.points.first() else {
            return (DVec3::ZERO, DVec3::ZERO);
        };
        self.points
            .iter()
            .fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// Every directed edge (u, v) with u < v of triangles and borders: each
    /// undirected edge of the closed chain once.
    pub fn edges(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let triangles = self
            .triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
        let caps = self
            .caps
            .iter()
            .flat_map(|c| c.border.iter().map(|s| (s[0], s[1])));
        triangles.chain(caps).filter(|&(u, v)| u < v)
    }

    /// Signed volume.
    pub fn volume(&self) -> f64 {
        let Some(&o) = self.points.first() else {
            return 0.0;
        };
        let at = |v: u32| self.points[v as usize] - o;
        let mut six = 0.0;
        for t in &self.triangles {
            six += at(t[0]).dot(at(t[1]).cross(at(t[2])));
        }
        for cap in &self.caps {
            let Some(first) = cap.border.first() else {
                continue;
            };
            let apex = at(first[0]);
            for s in &cap.border {
                six += apex.dot(at(s[0]).cross(at(s[1])));
            }
        }
        six / 6.0
    }
}

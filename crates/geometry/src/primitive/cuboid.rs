//! Boxes.

use glam::{DMat3, DVec2, DVec3};

use super::axes::candidates;
use super::slack::Faces;
use super::{extent, margin, Fit};
use crate::hull::convex_hull_2d;
use crate::mesh::Mesh;

/// A box in any orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Its centre.
    pub centre: DVec3,
    /// Its directions: a rotation, the columns are unit vectors.
    pub axes: DMat3,
    /// Half its lengths along them.
    pub half: DVec3,
}

impl Cuboid {
    /// Whether `p` is inside or on the surface, up to rounding.
    pub fn contains(&self, p: DVec3) -> bool {
        let local = self.axes.transpose() * (p - self.centre);
        local.abs().cmple(self.half).all()
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        8.0 * self.half.element_product()
    }

    /// Its eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            self.centre + self.axes * (self.half * DVec3::new(sign(0), sign(1), sign(2)))
        })
    }

    /// The box along the columns of a rotation around points.
    fn around(points: &[DVec3], axes: DMat3) -> Self {
        let extents = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| extent(points, axis));
        let middle = extents.map(|(low, high)| low * 0.5 + high * 0.5);
        let half = extents.map(|(low, high)| (high - low) * 0.5);
        Self {
            centre: axes * DVec3::from(middle),
            axes,
            half: DVec3::from(half),
        }
    }
}

/// A box of small volume around a convex hull; nothing for an empty mesh.
///
/// Tried are the boxes along the mesh's axes and, for each of the faces'
/// main directions and the principal axes, the smallest that is flush with
/// it: its other sides follow an edge of the outline (Freeman and Shapira,
/// *Determining the minimum-area encasing rectangle*, 1975). The slack is
/// exact: it is attained at a corner.
pub fn fit_box(hull: &Mesh) -> Option<Fit<Cuboid>> {
    if hull.triangles.is_empty() {
        return None;
    }
    let points = &hull.vertices;
    let mut best = Cuboid::around(points, DMat3::IDENTITY);
    for direction in candidates(hull) {
        let (u, v) = direction.any_orthonormal_pair();
        let outline: Vec<DVec2> = points
            .iter()
            .map(|p| DVec2::new(u.dot(*p), v.dot(*p)))
            .collect();
        let side = narrowest(&convex_hull_2d(&outline));
        let first = (u * side.x + v * side.y).normalize();
        let axes = DMat3::from_cols(direction, first, direction.cross(first));
        let next = Cuboid::around(points, axes);
        // Boxes as good as along the axes are not worth turning.
        if next.volume() < best.volume() * (1.0 - 1e-9) {
            best = next;
        }
    }
    best.half += margin(hull);
    let faces = Faces::of(hull);
    let slack = best.corners().map(|corner| faces.signed_distance(corner));
    Some(Fit {
        shape: best,
        slack: slack.into_iter().fold(0.0, f64::max),
    })
}

/// The direction of the side of a convex polygon that has the smallest
/// rectangle along it.
fn narrowest(polygon: &[DVec2]) -> DVec2 {
    let n = polygon.len();
    let mut best = (f64::INFINITY, DVec2::X);
    // Rotating calipers: the farthest points only ever move on.
    let (mut right, mut top, mut left) = (1, 1, 1);
    for i in 0..n {
        let side = polygon[(i + 1) % n] - polygon[i];
        let Some(along) = side.try_normalize() else {
            continue;
        };
        let across = along.perp();
        let climb = |start: usize, direction: DVec2| {
            let mut at = start;
            while direction.dot(polygon[(at + 1) % n]) > direction.dot(polygon[at % n]) {
                at += 1;
            }
            at
        };
        right = climb(right.max(i + 1), along);
        top = climb(top.max(right), across);
        left = climb(left.max(top), -along);
        let width = along.dot(polygon[right % n] - polygon[left % n]);
        let height = across.dot(polygon[top % n] - polygon[i]);
        if width * height < best.0 {
            best = (width * height, along);
        }
    }
    best.1
}

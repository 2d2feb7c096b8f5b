//! Parts: pieces of the solid with their stand-ins and hulls.

use assetpipe_geometry::hull::{convex_hull, HullError};
use assetpipe_geometry::{Mesh, Plane};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::candidates::notch::{self, Notch};
use crate::search::piece::Piece;

/// A connected piece of the solid, on its way to a hull.
#[derive(Clone, Debug)]
pub struct Part {
    /// The exact piece.
    pub piece: Piece,
    /// Stand-ins for the search, coarsest first.
    pub levels: Vec<Piece>,
    /// Its reflex edges.
    pub notches: Vec<Notch>,
    /// Its convex hull.
    pub hull: Mesh,
}

impl Part {
    /// A part with its hull; `None` if it has no volume at all (all points in
    /// one plane), so that its neighbours hold every point of it.
    ///
    /// # Errors
    /// Hull errors other than flatness.
    pub fn new(
        piece: Piece,
        levels: Vec<Piece>,
        notches: Vec<Notch>,
    ) -> Result<Option<Part>, HullError> {
        match convex_hull(&piece.points) {
            Ok(hull) => Ok(Some(Part {
                piece,
                levels,
                notches,
                hull,
            })),
            Err(HullError::Degenerate { .. } | HullError::Empty) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Cut by a plane into connected parts.
    ///
    /// # Errors
    /// See [`Part::new`].
    pub fn split(&self, plane: Plane) -> Result<Vec<Part>, HullError> {
        let (whole, levels): (_, Vec<(Piece, Piece)>) = rayon::join(
            || self.piece.split(plane),
            || self.levels.par_iter().map(|l| l.split(plane)).collect(),
        );
        let (levels_below, levels_above) = levels.into_iter().unzip();
        let notches = notch::split(&self.notches, &plane);
        let (below, above) = rayon::join(
            || connected_parts(whole.0, levels_below, &notches.0),
            || connected_parts(whole.1, levels_above, &notches.1),
        );
        let mut parts = below?;
        parts.extend(above?);
        Ok(parts)
    }

    /// The coarsest stand-in with enough surface.
    pub fn stand_in(&self, fewest: usize) -> &Piece {
        self.levels
            .iter()
            .find(|l| l.triangles.len() >= fewest)
            .unwrap_or(&self.piece)
    }
}

/// One part for each connected component, each with the stand-ins' components
/// and reflex edges that belong to it.
///
/// # Errors
/// See [`Part::new`].
pub fn connected_parts(
    piece: Piece,
    levels: Vec<Piece>,
    notches: &[Notch],
) -> Result<Vec<Part>, HullError> {
    let components = components(piece);
    if components.len() == 1 {
        return Ok(components
            .into_iter()
            .map(|p| Part::new(p, levels.clone(), notches.to_vec()))
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .flatten()
            .collect());
    }
    let boxes: Vec<(DVec3, DVec3)> = components.iter().map(Piece::bounds).collect();
    let mut shares: Vec<Vec<Piece>> = vec![Vec::new(); components.len()];
    for level in levels {
        let mut found: Vec<Option<Piece>> = vec![None; components.len()];
        for stand_in in self::components(level) {
            let (lo, hi) = stand_in.bounds();
            let misfit = |b: &(DVec3, DVec3)| (b.0 - lo).abs().max((b.1 - hi).abs()).max_element();
            let Some(best) =
                (0..boxes.len()).min_by(|&i, &j| misfit(&boxes[i]).total_cmp(&misfit(&boxes[j])))
            else {
                continue;
            };
            let size = (boxes[best].1 - boxes[best].0).max_element();
            if misfit(&boxes[best]) < 0.05 * size {
                found[best] = Some(stand_in);
            }
        }
        for (share, piece) in shares.iter_mut().zip(found) {
            share.extend(piece);
        }
    }
    let mut parts = Vec::new();
    for ((piece, levels), bounds) in components.into_iter().zip(shares).zip(boxes) {
        parts.extend(Part::new(piece, levels, notch::within(notches, bounds))?);
    }
    Ok(parts)
}

/// Disjoint sets.
pub(crate) struct Union(Vec<u32>);

impl Union {
    /// Of `count` elements, each by itself.
    pub(crate) fn new(count: usize) -> Self {
        Union((0..count as u32).collect())
    }

    /// The smallest element of a set.
    pub(crate) fn root(&mut self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            self.0[v as usize] = self.0[self.0[v as usize] as usize];
            v = self.0[v as usize];
        }
        v
    }

    /// Make two sets one.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller index stays the root: the order of components is fixed.
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// The connected components of a piece. Border loops of a cap that lie inside
/// one another are connected through the cap.
pub fn components(piece: Piece) -> Vec<Piece> {
    let mut sets = Union::new(piece.points.len());
    for t in &piece.triangles {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    for cap in &piece.caps {
        for s in &cap.border {
            sets.join(s[0], s[1]);
        }
    }
    for cap in &piece.caps {
        join_nested(&piece, cap, &mut sets);
    }
    let roots: Vec<u32> = (0..piece.points.len() as u32)
        .map(|v| sets.root(v))
        .collect();
    let mut used: Vec<u32> = piece
        .triangles
        .iter()
        .map(|t| roots[t[0] as usize])
        .collect();
    used.extend(
        piece
            .caps
            .iter()
            .flat_map(|c| c.border.iter().map(|s| roots[s[0] as usize])),
    );
    used.sort_unstable();
    used.dedup();
    if used.len() <= 1 {
        return vec![piece];
    }
    let mut solids: Vec<Piece> = used
        .iter()
        .map(|&root| extract(&piece, &roots, root))
        .collect();
    // A component of negative volume is a void: it stays with what encloses it.
    let volumes: Vec<f64> = solids.iter().map(Piece::volume).collect();
    let mut owner: Vec<usize> = (0..solids.len()).collect();
    for (i, &volume) in volumes.iter().enumerate() {
        if volume >= 0.0 {
            continue;
        }
        let (lo, hi) = solids[i].bounds();
        let around = (0..solids.len())
            .filter(|&j| {
                let (l, h) = solids[j].bounds();
                volumes[j] > 0.0 && l.cmple(lo).all() && h.cmpge(hi).all()
            })
            .min_by(|&a, &b| volumes[a].total_cmp(&volumes[b]));
        owner[i] = around.unwrap_or(i);
    }
    for i in (0..solids.len()).rev() {
        if owner[i] != i {
            let void = std::mem::take(&mut solids[i]);
            append(&mut solids[owner[i]], &void);
        }
    }
    solids
        .into_iter()
        .enumerate()
        .filter(|(i, _)| owner[*i] == *i)
        .map(|(_, s)| s)
        .collect()
}

fn extract(piece: &Piece, roots: &[u32], root: u32) -> Piece {
    let mut index = vec![u32::MAX; piece.points.len()];
    let mut part = Piece::default();
    let mut place = |v: u32, points: &mut Vec<DVec3>| {
        let slot = &mut index[v as usize];
        if *slot == u32::MAX {
            *slot = points.len() as u32;
            points.push(piece.points[v as usize]);
        }
        *slot
    };
    for t in &piece.triangles {
        if roots[t[0] as usize] == root {
            let t = t.map(|v| place(v, &mut part.points));
            part.triangles.push(t);
        }
    }
    for cap in &piece.caps {
        let border: Vec<[u32; 2]> = cap
            .border
            .iter()
            .filter(|s| roots[s[0] as usize] == root)
            .map(|s| s.map(|v| place(v, &mut part.points)))
            .collect();
        if !border.is_empty() {
            part.caps.push(crate::search::piece::Cap {
                plane: cap.plane,
                border,
            });
        }
    }
    part
}

/// Add another chain to a piece.
pub fn append(piece: &mut Piece, other: &Piece) {
    let shift = piece.points.len() as u32;
    piece.points.extend(&other.points);
    piece
        .triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
    for cap in &other.caps {
        let border = cap.border.iter().map(|s| s.map(|v| v + shift)).collect();
        piece.caps.push(crate::search::piece::Cap {
            plane: cap.plane,
            border,
        });
    }
}

/// Join components whose loops on one cap are outline and hole.
fn join_nested(piece: &Piece, cap: &crate::search::piece::Cap, sets: &mut Union) {
    let mut roots: Vec<u32> = cap.border.iter().map(|s| sets.root(s[0])).collect();
    let of = roots.clone();
    roots.sort_unstable();
    roots.dedup();
    if roots.len() < 2 {
        return;
    }
    let (u, v) = cap
        .plane
        .normal
        .any_orthogonal_vector()
        .normalize()
        .into_pair(cap.plane.normal);
    let flat = |i: u32| {
        let p = piece.points[i as usize];
        DVec2::new(u.dot(p), v.dot(p))
    };
    let loops: Vec<(u32, Vec<[DVec2; 2]>)> = roots
        .iter()
        .map(|&root| {
            let segments = cap
                .border
                .iter()
                .zip(&of)
                .filter(|(_, r)| **r == root)
                .map(|(s, _)| s.map(flat))
                .collect();
            (root, segments)
        })
        .collect();
    for (i, (root, segments)) in loops.iter().enumerate() {
        let origin = segments[0][0];
        let area: f64 = segments
            .iter()
            .map(|[a, b]| (*a - origin).perp_dot(*b - origin))
            .sum();
        if area >= 0.0 {
            continue;
        }
        let inside = |outline: &[[DVec2; 2]]| {
            let mut winding = 0;
            for [a, b] in outline {
                let side = (*b - *a).perp_dot(origin - *a);
                if a.y <= origin.y && b.y > origin.y && side > 0.0 {
                    winding += 1;
                } else if b.y <= origin.y && a.y > origin.y && side < 0.0 {
                    winding -= 1;
                }
            }
            winding != 0
        };
        for (j, (other, outline)) in loops.iter().enumerate() {
            if i != j && inside(outline) {
                sets.join(*root, *other);
            }
        }
    }
}

trait Pair {
    fn into_pair(self, normal: DVec3) -> (DVec3, DVec3);
}

impl Pair for DVec3 {
    /// (u, v) such that (u, v, normal) is right-handed.
    fn into_pair(self, normal: DVec3) -> (DVec3, DVec3) {
        (self, normal.cross(self).normalize())
    }
}

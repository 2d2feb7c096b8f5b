//! Fewer vertices, outward only.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::circumscribe::circumscribe;
use super::program::{minimise, Constraint};
use super::growing::Growing;
use super::{convex_hull, HullError};
use crate::distance::Triangle;
use crate::mesh::Mesh;
use crate::tolerance::Rounding;

/// Why there is no simpler polytope around a hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimplifyError {
    /// No solid has so few vertices.
    #[error("no convex solid has {max_vertices} vertices; at least 4 are needed")]
    TooFew {
        /// What was asked for.
        max_vertices: usize,
    },
    /// The vertices have no hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}

/// A convex polytope of at most `max_vertices` vertices that contains the
/// convex hull of `hull`'s vertices, and not much more.
///
/// Exact: no vertex of `hull` is strictly outside of a face of the result.
/// Greedy: the edge whose collapse reaches least far outward is replaced by
/// the point beyond all faces around it that adds the least volume (a linear
/// program; Sander et al., *Silhouette clipping*, 2000, §3.1, call such a
/// sequence progressive hulls). Where no edge can be collapsed, or few
/// vertices of many are wanted, the polytope grows from a box by supporting
/// planes instead. A hull that has no more vertices comes back as it is (in
/// canonical form).
///
/// # Errors
/// [`SimplifyError`] for fewer than four vertices or flat input.
pub fn simplify_outward(hull: &Mesh, max_vertices: usize) -> Result<Mesh, SimplifyError> {
    if max_vertices < 4 {
        return Err(SimplifyError::TooFew { max_vertices });
    }
    let hull = convex_hull(&hull.vertices)?;
    if hull.vertices.len() <= max_vertices {
        return Ok(hull);
    }
    match collapse(&hull, max_vertices)? {
        Some(simpler) => Ok(simpler),
        None => Ok(circumscribe(&hull, max_vertices)?),
    }
}

/// Collapses edges until the count is met; nothing if no edge is left to collapse.
fn collapse(hull: &Mesh, max_vertices: usize) -> Result<Option<Mesh>, HullError> {
    let rounding = Rounding::of(hull);
    let (low, high) = crate::properties::bounds(hull).unwrap_or_default();
    // Every collapse adds one point and removes at least two.
    let reach = (high - low).max_element();
    let mut growing = Growing::new(&hull.vertices, 2.0 * reach)?;
    let mut stars = vec![0; 2 * hull.vertices.len()];
    let mut state = Collapse { reach, lift: 16.0 * rounding.crossing(), queue: BinaryHeap::new() };
    for (a, b) in growing.edges() {
        state.consider(&growing, &stars, a, b);
    }
    while growing.vertex_count() > max_vertices {
        let Some(candidate) = state.queue.pop() else {
            return Ok(None);
        };
        let (a, b) = candidate.edge;
        let is_current = stars[a as usize] + stars[b as usize] == candidate.age
            && growing.is_vertex(a)
            && growing.is_vertex(b);
        if !is_current {
            continue;
        }
        let Some(added) = growing.replace(a, b, candidate.point) else {
            continue;
        };
        let neighbours = growing.neighbours(added);
        for &n in &neighbours {
            stars[n as usize] += 1;
        }
        // The neighbours' stars have changed, so all their edges have.
        let mut changed: Vec<(u32, u32)> = neighbours
            .iter()
            .flat_map(|&n| growing.neighbours(n).into_iter().map(move |m| (n.min(m), n.max(m))))
            .collect();
        changed.sort_unstable();
        changed.dedup();
        for (a, b) in changed {
            state.consider(&growing, &stars, a, b);
        }
    }
    Ok(Some(growing.finish()))
}

struct Collapse {
    /// How far a new point may lie from its edge.
    reach: f64,
    /// How far beyond the faces a new point must lie for the signs to be certain.
    lift: f64,
    queue: BinaryHeap<Candidate>,
}

impl Collapse {
    /// Prices the collapse of an edge.
    fn consider(&mut self, growing: &Growing, stars: &[u32], a: u32, b: u32) {
        let faces = growing.faces_around(a, b);
        let base = growing.at(a);
        let mut objective = DVec3::ZERO;
        let mut constraints = Vec::with_capacity(faces.len());
        for corners in &faces {
            let [p, q, r] = corners.map(|c| c - base);
            let normal = (q - p).cross(r - p);
            objective += normal;
            let Some(normal) = normal.try_normalize() else { continue };
            constraints.push(Constraint { normal, offset: normal.dot(p) + self.lift });
        }
        let Some(point) = minimise(objective, &mut constraints, self.reach) else {
            return;
        };
        let point = base + point;
        let distance2 = faces
            .iter()
            .map(|corners| Triangle::new(*corners).distance2(point))
            .fold(f64::INFINITY, f64::min);
        if distance2 < self.reach * self.reach {
            let age = stars[a as usize] + stars[b as usize];
            self.queue.push(Candidate { distance2, edge: (a, b), age, point });
        }
    }
}

/// A collapse: smaller reach first, then smaller indices.
struct Candidate {
    distance2: f64,
    edge: (u32, u32),
    /// Changes of the stars at both ends when it was priced.
    age: u32,
    point: DVec3,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let ascending = self.distance2.total_cmp(&other.distance2);
        ascending.then(self.edge.cmp(&other.edge)).then(self.age.cmp(&other.age)).reverse()
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

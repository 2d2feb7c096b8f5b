//! Distance to a solid: zero inside, distance to its surface outside.

use glam::DVec3;

use crate::bvh::{Bvh, Nearest, Side};
use crate::Mesh;

/// Share of the bounding-box diagonal that covers every rounding error of a
/// distance query and of the cell arithmetic built on it: triangles count as
/// slivers from 1e-3 on, so directions are good to about 1e-12, and four
/// digits are spare.
const ROUNDING: f64 = 1e-9;

/// Coordinates far from the origin carry the rounding of their own size.
const ROUNDING_AT_COORDINATES: f64 = 64.0 * f64::EPSILON;

/// A solid prepared for distance queries. Built once, shared by everything
/// that is measured against it.
#[derive(Clone, Debug)]
pub struct SolidIndex {
    bvh: Bvh,
    slack: f64,
}

impl SolidIndex {
    /// Index a closed surface, wound outward (cavities inward).
    pub fn new(mesh: &Mesh) -> SolidIndex {
        let bvh = Bvh::new(mesh);
        let bounds = bvh.bounds();
        let slack = if bvh.is_empty() {
            0.0
        } else {
            ROUNDING * bounds.diagonal()
                + ROUNDING_AT_COORDINATES * bounds.lo.abs().max(bounds.hi.abs()).max_element()
        };
        SolidIndex { bvh, slack }
    }

    /// The triangles.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Allowance, in the unit of the mesh, for all rounding in bounds derived
    /// from this index: a computed upper bound plus `slack`, and a lower bound
    /// minus `slack`, are true.
    pub fn slack(&self) -> f64 {
        self.slack
    }

    /// Whether `q` belongs to the (closed) solid. Exact but for points of the
    /// surface, which may be answered either way.
    pub fn contains(&self, q: DVec3) -> bool {
        self.bvh.side(q) != Side::Outside
    }

    /// The nearest surface triangle; `None` only for an empty solid.
    pub fn surface(&self, q: DVec3) -> Option<Nearest> {
        self.bvh.nearest(q, f64::INFINITY)
    }

    /// d(q, solid): zero inside, else the distance to the surface. Within
    /// [`SolidIndex::slack`] of the true value. Infinite for an empty solid.
    pub fn distance(&self, q: DVec3) -> f64 {
        if self.contains(q) {
            return 0.0;
        }
        self.surface(q)
            .map_or(f64::INFINITY, |n| n.distance2.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    #[test]
    fn zero_inside_and_the_surface_outside() {
        let corners: Vec<DVec3> = (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect();
        let index = SolidIndex::new(&convex_hull(&corners).unwrap());
        assert_eq!(index.distance(DVec3::splat(0.5)), 0.0);
        assert_eq!(index.distance(DVec3::new(0.5, 0.5, 3.0)), 2.0);
        assert_eq!(index.distance(DVec3::splat(2.0)), 3.0f64.sqrt());
        assert_eq!(index.distance(DVec3::new(1.0, 1.0, 1.0)), 0.0);
        assert!(index.slack() > 0.0 && index.slack() < 1e-8);
    }

    #[test]
    fn nothing_is_infinitely_far() {
        let index = SolidIndex::new(&Mesh::default());
        assert_eq!(index.distance(DVec3::ZERO), f64::INFINITY);
        assert_eq!(index.slack(), 0.0);
    }
}

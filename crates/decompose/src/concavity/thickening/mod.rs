//! Thickening: sup over the points q of a hull of d(q, solid), how far the hull
//! reaches into free space.
//!
//! The one-sided bound that §4.1 of Wei et al. 2022 asks for: a position farther
//! than ε from the solid stays free. Found by branch and bound over boxes that
//! cover the hull, on two facts: d(·, solid) is 1-Lipschitz, and the distance
//! to one triangle is convex, so over a box it is largest at a corner.

mod cell;
mod decide;

pub use decide::decide;

use assetpipe_geometry::DVec3;

use super::Interval;

/// The answer to "is the thickening at most ε?".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// Proved: the interval's upper bound is at most ε.
    Within(Interval),
    /// Refuted: `witness` is a point of the hull at least `lower` > ε away from
    /// the solid.
    Beyond {
        /// The point.
        witness: DVec3,
        /// A lower bound of its distance.
        lower: f64,
    },
    /// Neither within the limits: what is known. Not to be accepted.
    Unproven(Interval),
}

impl Decision {
    /// Whether the bound is proved.
    pub fn is_within(&self) -> bool {
        matches!(self, Decision::Within(_))
    }
}

//! Thickening: sup over the points q of a hull of d(q, solid), how far the hull
//! reaches into free space.
//!
//! The one-sided bound that §4.1 of Wei et al. 2022 asks for: a position farther
//! than ε from the solid stays free. Found by branch and bound over boxes cut by
//! the hull's half-spaces, on three facts:
//!
//! 1. The signed distance to a solid is 1-Lipschitz: from the centre of a cell
//!    it grows by at most the cell's radius ([`search`]).
//! 2. The distance to one triangle is convex, so over a cell it is largest at a
//!    corner, and so is every weighted mean of such distances ([`mixture`]).
//! 3. A cell that no surface enters and that holds a point of the solid belongs
//!    to it ([`enclosed`]).
//!
//! The first prunes what is far from the answer at almost no cost, the second
//! converges with the square of the cell size where the answer is, the third
//! settles cells whose faces lie on the surface.

mod cell;
mod enclosed;
mod mixture;
mod search;
#[cfg(test)]
mod tests;

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::{DVec3, Mesh};

use super::{Gap, Interval, Limits};
use search::{Goal, Search};

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

    /// What is known of the true value either way; the upper end is infinite
    /// after a refutation.
    pub fn interval(&self) -> Interval {
        match *self {
            Decision::Within(interval) | Decision::Unproven(interval) => interval,
            Decision::Beyond { lower, .. } => Interval {
                lower,
                upper: f64::INFINITY,
            },
        }
    }
}

/// Decide whether every point of `hull` (a convex mesh as returned by
/// `convex_hull`) is within `epsilon` of the solid.
///
/// `Within` is proved for all points, `Beyond` names one that is farther.
/// `Unproven` only if the limits end the work or the thickening equals ε to a
/// thousandth.
pub fn decide(solid: &SolidIndex, hull: &Mesh, epsilon: f64, limits: &Limits) -> Decision {
    let mut search = Search::new(solid, hull, Goal::Decide { epsilon });
    let interval = search.run(limits);
    match search.witness() {
        Some((witness, lower)) if lower > epsilon => Decision::Beyond { witness, lower },
        _ if interval.upper <= epsilon => Decision::Within(interval),
        _ => Decision::Unproven(interval),
    }
}

/// The thickening of `hull` (a convex mesh as returned by `convex_hull`), to
/// within `gap` or as close as the limits permit.
pub fn bounds(solid: &SolidIndex, hull: &Mesh, gap: Gap, limits: &Limits) -> Interval {
    Search::new(solid, hull, Goal::Measure { gap }).run(limits)
}

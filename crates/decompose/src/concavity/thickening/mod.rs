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
//!    corner, and so is every weighted mean of such distances ([`mixture`](super::mixture)).
//! 3. A cell that no surface enters and that holds a point of the solid belongs
//!    to it ([`enclosed`]).
//!
//! The first prunes what is far from the answer at almost no cost, the second
//! converges with the square of the cell size where the answer is, the third
//! settles cells whose faces lie on the surface.

mod cell;
mod enclosed;
mod search;
#[cfg(test)]
mod tests;

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::Mesh;

pub use super::decision::Decision;
use super::goal::Goal;
use super::{Gap, Interval, Limits};
use search::Search;

/// Decide whether every point of `hull` (a convex mesh as returned by
/// `convex_hull`) is within `epsilon` of the solid.
///
/// `Within` is proved for all points, `Beyond` names one that is farther.
/// `Unproven` only if the limits end the work or the thickening equals ε to a
/// thousandth.
pub fn decide(solid: &SolidIndex, hull: &Mesh, epsilon: f64, limits: &Limits) -> Decision {
    let mut search = Search::new(solid, hull, Goal::Decide { epsilon });
    let interval = search.run(limits);
    Decision::from(epsilon, interval, search.witness())
}

/// The thickening of `hull` (a convex mesh as returned by `convex_hull`), to
/// within `gap` or as close as the limits permit.
pub fn bounds(solid: &SolidIndex, hull: &Mesh, gap: Gap, limits: &Limits) -> Interval {
    bounds_above(solid, hull, 0.0, gap, limits)
}

/// The larger one of the thickening of `hull` and `known`, as [`bounds`]: a
/// lower bound known before spares the work below it.
pub fn bounds_above(
    solid: &SolidIndex,
    hull: &Mesh,
    known: f64,
    gap: Gap,
    limits: &Limits,
) -> Interval {
    let mut search = Search::new(solid, hull, Goal::Measure { gap });
    search.rise_to(known);
    search.run(limits)
}

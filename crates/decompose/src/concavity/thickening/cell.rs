//! Boxes that cover the hull.

use std::ops::Range;

use assetpipe_geometry::bvh::Bounds;
use assetpipe_geometry::distance::HalfSpace;
use assetpipe_geometry::DVec3;

/// What is known about the side of a cell's centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Unknown,
    Inside,
    Outside,
}

/// A box with the half-spaces of the hull that cut it (indices into a shared
/// list) and what was measured at its centre.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub bounds: Bounds,
    pub planes: Range<usize>,
    /// Nearest triangle to the centre, its distance, and the centre.
    pub slot: u32,
    pub distance: f64,
    pub centre: DVec3,
    pub side: Side,
    /// Upper bound of d(q, solid) over the cell.
    pub upper: f64,
}

/// Shrink `bounds` to what the half-spaces leave of it and collect those that
/// still cut it; `None` if nothing is left.
///
/// One pass of interval propagation: along axis k a point of the box can be at
/// most (offset − smallest value) / `|normal_k|` away from its lowest side.
pub(super) fn contract(
    mut bounds: Bounds,
    spaces: &[HalfSpace],
    inherited: impl Iterator<Item = u32>,
    list: &mut Vec<u32>,
) -> Option<(Bounds, Range<usize>)> {
    let start = list.len();
    for index in inherited {
        let HalfSpace { normal, offset } = spaces[index as usize];
        let centre = (bounds.lo + bounds.hi) * 0.5;
        let half = (bounds.hi - bounds.lo) * 0.5;
        let middle = normal.dot(centre);
        let spread = normal.abs().dot(half);
        if middle - spread > offset {
            list.truncate(start);
            return None;
        }
        if middle + spread <= offset {
            continue;
        }
        list.push(index);
        let room = offset - (middle - spread);
        for axis in 0..3 {
            let n = normal[axis];
            if room < 2.0 * half[axis] * n.abs() {
                let reach = room / n.abs();
                if n > 0.0 {
                    bounds.hi[axis] = bounds.hi[axis].min(bounds.lo[axis] + reach);
                } else {
                    bounds.lo[axis] = bounds.lo[axis].max(bounds.hi[axis] - reach);
                }
            }
        }
    }
    Some((bounds, start..list.len()))
}

//! Boxes cut by half-spaces.

use std::ops::Range;

use assetpipe_geometry::bvh::Bounds;
use assetpipe_geometry::distance::HalfSpace;
use assetpipe_geometry::DVec3;

/// Shrink `bounds` to what the half-spaces leave of it and collect those that
/// still cut it; `None` if nothing is left.
///
/// One pass of interval propagation: along axis k a point of the box can be at
/// most (offset − smallest value) / `|normal_k|` away from its lowest side.
pub(super) fn contract(
    mut bounds: Bounds,
    spaces: &[HalfSpace],
    inherited: Range<usize>,
    list: &mut Vec<u32>,
) -> Option<(Bounds, Range<usize>)> {
    let start = list.len();
    for at in inherited {
        let index = list[at];
        let HalfSpace { normal, offset } = spaces[index as usize];
        let middle = normal.dot(bounds.centre());
        let half = (bounds.hi - bounds.lo) * 0.5;
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

/// The eight corners of a box.
fn box_corners(bounds: &Bounds) -> [DVec3; 8] {
    let pick = |bit: bool, lo: f64, hi: f64| if bit { hi } else { lo };
    std::array::from_fn(|k| {
        DVec3::new(
            pick(k & 1 != 0, bounds.lo.x, bounds.hi.x),
            pick(k & 2 != 0, bounds.lo.y, bounds.hi.y),
            pick(k & 4 != 0, bounds.lo.z, bounds.hi.z),
        )
    })
}

/// A corner of a cell with the set of planes that meet there: bits 0 to 5 are
/// the sides of the box, the others half-spaces.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec3,
    planes: u64,
}

/// Half-spaces that a cell may be cut with: the bits of the set.
const CUTS: usize = 58;

/// A box cut by half-spaces, and corners whose convex hull holds it.
#[derive(Clone, Debug)]
pub(super) struct Polytope {
    pub bounds: Bounds,
    pub spaces: Vec<HalfSpace>,
    pub corners: Vec<DVec3>,
    kept: Vec<Corner>,
    removed: Vec<(Corner, f64)>,
    values: Vec<f64>,
}

impl Default for Polytope {
    fn default() -> Self {
        Polytope {
            bounds: Bounds::EMPTY,
            spaces: Vec::new(),
            corners: Vec::new(),
            kept: Vec::new(),
            removed: Vec::new(),
            values: Vec::new(),
        }
    }
}

impl Polytope {
    /// Find the corners of `bounds` cut by `spaces`, each moved outward by
    /// `margin` so that the corners' hull holds the cell in spite of rounding: a
    /// crossing computed on an edge lies beyond the unmoved plane. Leaving out
    /// half-spaces beyond [`CUTS`] only makes it larger.
    ///
    /// Every corner is seen as the meeting of three planes (a plane through a
    /// corner passes on one side of it), so two corners are joined by an edge
    /// just when they share two. Corners beyond a moved plane by less than
    /// `margin` stay, so that the several triangles of one flat facet cut once.
    pub fn set(&mut self, bounds: Bounds, spaces: impl Iterator<Item = HalfSpace>, margin: f64) {
        self.bounds = bounds;
        self.spaces.clear();
        self.spaces.extend(spaces);
        self.kept.clear();
        self.kept.extend(
            box_corners(&bounds)
                .into_iter()
                .enumerate()
                .map(|(k, at)| Corner {
                    at,
                    planes: 1 << (k & 1) | 4 << (k >> 1 & 1) | 16 << (k >> 2),
                }),
        );
        for (index, space) in self.spaces.iter().take(CUTS).enumerate() {
            let bit = 64u64 << index;
            self.values.clear();
            self.values.extend(
                self.kept
                    .iter()
                    .map(|c| space.normal.dot(c.at) - space.offset - margin),
            );
            if self.values.iter().all(|v| *v <= margin) {
                continue;
            }
            cut(
                &mut self.kept,
                &mut self.removed,
                &mut self.values,
                margin,
                bit,
            );
        }
        self.corners.clear();
        self.corners.extend(self.kept.iter().map(|c| c.at));
    }
}

/// Replace the corners with values above `margin` by the crossings on the edges
/// to them.
fn cut(
    kept: &mut Vec<Corner>,
    removed: &mut Vec<(Corner, f64)>,
    values: &mut [f64],
    margin: f64,
    bit: u64,
) {
    removed.clear();
    let mut inside = 0;
    for k in 0..kept.len() {
        if values[k] > margin {
            removed.push((kept[k], values[k]));
        } else {
            kept[inside] = kept[k];
            values[inside] = values[k];
            inside += 1;
        }
    }
    kept.truncate(inside);
    for k in 0..inside {
        for (far, beyond) in removed.iter() {
            let shared = kept[k].planes & far.planes;
            if shared & shared.wrapping_sub(1) != 0 {
                let share = (values[k] / (values[k] - beyond)).max(0.0);
                kept.push(Corner {
                    at: kept[k].at + (far.at - kept[k].at) * share,
                    planes: shared | bit,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_cut_cube() {
        let cube = Bounds {
            lo: DVec3::ZERO,
            hi: DVec3::ONE,
        };
        let normal = DVec3::ONE.normalize();
        let mut cell = Polytope::default();
        // Through the middle: a regular hexagon and four corners below it.
        let middle = HalfSpace {
            normal,
            offset: normal.dot(DVec3::splat(0.5)),
        };
        cell.set(cube, [middle].into_iter(), 0.0);
        assert_eq!(cell.corners.len(), 10);
        assert!(cell.corners.iter().all(|p| p.element_sum() <= 1.5 + 1e-12));
        // Through the three neighbours of a corner: they stay, it goes.
        let tip = HalfSpace {
            normal,
            offset: normal.dot(DVec3::X),
        };
        cell.set(cube, [tip, middle].into_iter(), 1e-9);
        assert!(cell.corners.iter().all(|p| p.element_sum() <= 1.0 + 1e-8));
        for expected in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            assert!(cell.corners.iter().any(|p| p.distance(expected) < 1e-8));
        }
    }
}

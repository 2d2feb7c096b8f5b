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

/// The largest of `normal · p` over the points p of a box.
pub(super) fn highest(normal: DVec3, bounds: &Bounds) -> f64 {
    let half = (bounds.hi - bounds.lo) * 0.5;
    normal.dot(bounds.centre()) + normal.abs().dot(half)
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

/// Half-spaces that a cell can be cut with: the bits of the set.
pub(super) const CUTS: usize = 58;

/// A cell of at most 64 planes has fewer corners than this (2 · 64 − 4). Planes that
/// almost coincide can make many more, each pair of corners on either side one; then
/// the cell is left as it is, which only makes it larger.
const CORNERS: usize = 124;

/// A box cut by half-spaces, and corners whose convex hull holds it.
#[derive(Clone, Debug)]
pub(super) struct Polytope {
    pub bounds: Bounds,
    pub spaces: Vec<HalfSpace>,
    pub corners: Vec<DVec3>,
    kept: Vec<Corner>,
    removed: Vec<(Corner, f64)>,
    values: Vec<f64>,
    order: Vec<(f64, usize)>,
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
            order: Vec::new(),
        }
    }
}

impl Polytope {
    /// The cell of a box and all half-spaces that cut it.
    pub fn set(&mut self, bounds: Bounds, spaces: impl Iterator<Item = HalfSpace>) {
        self.bounds = bounds;
        self.spaces.clear();
        self.spaces.extend(spaces);
        let room = |s: &HalfSpace| s.offset - highest(s.normal, &bounds);
        self.order.clear();
        self.order
            .extend(self.spaces.iter().enumerate().map(|(k, s)| (room(s), k)));
        self.order
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Find the corners of the box cut by the `most` half-spaces that take most
    /// of it, each moved outward by `margin` so that the corners' hull holds the
    /// cell in spite of rounding: a crossing computed on an edge lies beyond the
    /// unmoved plane. Leaving out half-spaces only makes it larger.
    ///
    /// Every corner is seen as the meeting of three planes (a plane through a
    /// corner passes on one side of it), so two corners are joined by an edge
    /// just when they share two. Corners beyond a moved plane by less than
    /// `margin` stay, so that the several triangles of one flat facet cut once.
    pub fn find_corners(&mut self, most: usize, margin: f64) {
        self.kept.clear();
        self.kept.extend(
            box_corners(&self.bounds)
                .into_iter()
                .enumerate()
                .map(|(k, at)| Corner {
                    at,
                    planes: 1 << (k & 1) | 4 << (k >> 1 & 1) | 16 << (k >> 2),
                }),
        );
        for (index, (_, k)) in self.order.iter().take(most.min(CUTS)).enumerate() {
            if self.kept.len() > CORNERS {
                break;
            }
            let space = &self.spaces[*k];
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

    /// The lower facet of a real part, turned: its triangles are not quite in one plane,
    /// and each cut once multiplied the corners, until memory was full.
    #[test]
    #[allow(
        clippy::unreadable_literal,
        reason = "a table of numbers as they were found"
    )]
    fn planes_that_almost_coincide_do_not_multiply_corners() {
        let cell_box = Bounds {
            lo: DVec3::new(0.380_882_885, 0.217_479_177, -0.153_926_274_533_257_75),
            hi: DVec3::new(0.414_779_947, 0.268_546_065, -0.097_121_388),
        };
        #[rustfmt::skip]
        let facet = [
            [-4.65002e-09, -2.88097e-08, 0.15392626606063817],
            [8.26785e-09, 1.89368e-07, 0.15392632919799143],
            [2.13234e-08, 1.61967e-07, 0.1539263263615881],
            [3.09015e-08, 1.39388e-07, 0.1539263236149623],
            [3.79797e-08, 1.20453e-07, 0.15392632098048228],
            [4.32178e-08, 1.04337e-07, 0.15392631846526814],
            [4.70766e-08, 9.04342e-08, 0.153926316066583],
            [4.98824e-08, 7.82995e-08, 0.15392631377787314],
            [5.18706e-08, 6.75986e-08, 0.15392631159093412],
            [5.32145e-08, 5.80738e-08, 0.1539263094966],
            [5.40434e-08, 4.95215e-08, 0.15392630748502104],
            [5.44545e-08, 4.17843e-08, 0.15392630554761214],
            [5.45216e-08, 3.47343e-08, 0.15392630367558166],
            [5.43015e-08, 2.82675e-08, 0.15392630186064346],
            [5.38375e-08, 2.23002e-08, 0.15392630009541286],
            [5.33053e-08, 1.79287e-08, 0.15392629873546876],
            [1.09891e-07, 3.48522e-07, 0.15392641340247287],
            [1.47050e-07, 3.55012e-07, 0.15392642969635556],
            [1.88846e-07, 3.62774e-07, 0.15392644826534804],
            [2.37143e-07, 3.72240e-07, 0.15392646998270587],
            [2.94703e-07, 3.84062e-07, 0.15392649614867973],
            [3.65871e-07, 3.99281e-07, 0.15392652881571933],
            [4.57984e-07, 4.19664e-07, 0.15392657145577718],
            [5.84429e-07, 4.48447e-07, 0.15392663040929302],
            [7.72774e-07, 4.92314e-07, 0.1539267187434372],
            [1.06288e-06, 5.61087e-07, 0.1539268554368071],
        ];
        let spaces = facet.map(|[x, y, offset]: [f64; 3]| HalfSpace {
            normal: DVec3::new(x, y, -(1.0 - x * x - y * y).sqrt()),
            offset,
        });
        let mut cell = Polytope::default();
        cell.set(cell_box, spaces.into_iter());
        cell.find_corners(CUTS, 2e-10);
        assert!(cell.corners.len() < 1000, "{}", cell.corners.len());
        // The upper corners are far from all of it.
        for (x, y) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let pick = |k: i32, lo: f64, hi: f64| if k == 0 { lo } else { hi };
            let expected = DVec3::new(
                pick(x, cell_box.lo.x, cell_box.hi.x),
                pick(y, cell_box.lo.y, cell_box.hi.y),
                cell_box.hi.z,
            );
            assert!(cell.corners.iter().any(|p| p.distance(expected) < 1e-8));
        }
    }

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
        cell.set(cube, [middle].into_iter());
        cell.find_corners(CUTS, 0.0);
        assert_eq!(cell.corners.len(), 10);
        assert!(cell.corners.iter().all(|p| p.element_sum() <= 1.5 + 1e-12));
        // Through the three neighbours of a corner: they stay, it goes.
        let tip = HalfSpace {
            normal,
            offset: normal.dot(DVec3::X),
        };
        cell.set(cube, [tip, middle].into_iter());
        cell.find_corners(CUTS, 1e-9);
        assert!(cell.corners.iter().all(|p| p.element_sum() <= 1.0 + 1e-8));
        for expected in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            assert!(cell.corners.iter().any(|p| p.distance(expected) < 1e-8));
        }
    }
}

//! Acceptance: is the thickening at most ε?

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use assetpipe_geometry::bvh::{Bounds, Nearest};
use assetpipe_geometry::distance::{ConvexBody, SolidIndex, Triangle};
use assetpipe_geometry::{DVec3, Mesh};

use super::cell::{contract, Cell, Side};
use super::{Decision, Interval};
use crate::concavity::Limits;

/// Cells smaller than this share of ε are not split further: the question is
/// then closer than the answer is worth.
const FLOOR: f64 = 1e-3;

/// Decide whether every point of `hull` (a convex mesh as returned by
/// `convex_hull`) is within `epsilon` of the solid.
///
/// `Within` is proved for all points, `Beyond` names one that is farther.
/// `Unproven` only if the limits end the work or the thickening equals ε to a
/// thousandth.
pub fn decide(solid: &SolidIndex, hull: &Mesh, epsilon: f64, limits: &Limits) -> Decision {
    Search::new(solid, hull, epsilon).run(limits)
}

struct Ranked(Cell);

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Ranked {}
impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> Ordering {
        // Every cell owns a distinct range or box, and equal keys of equal
        // cells are interchangeable, so the order of pops is deterministic.
        self.0
            .upper
            .total_cmp(&other.0.upper)
            .then(self.0.planes.start.cmp(&other.0.planes.start))
    }
}

struct Search<'a> {
    solid: &'a SolidIndex,
    body: ConvexBody<'a>,
    /// ε minus what rounding may hide.
    within: f64,
    /// ε plus what rounding may feign.
    beyond: f64,
    floor: f64,
    planes: Vec<u32>,
    queue: BinaryHeap<Ranked>,
    /// Largest upper bound of a cell that was accepted.
    accepted: f64,
    lower: f64,
    examined: usize,
    witness: Option<(DVec3, f64)>,
}

impl<'a> Search<'a> {
    fn new(solid: &'a SolidIndex, hull: &'a Mesh, epsilon: f64) -> Self {
        Search {
            solid,
            body: ConvexBody::new(hull),
            within: epsilon - solid.slack(),
            beyond: epsilon + solid.slack(),
            floor: FLOOR * epsilon,
            planes: Vec::new(),
            queue: BinaryHeap::new(),
            accepted: 0.0,
            lower: 0.0,
            examined: 0,
            witness: None,
        }
    }

    fn run(mut self, limits: &Limits) -> Decision {
        let slack = self.solid.slack();
        let all: Vec<u32> = (0..self.body.half_spaces().len() as u32).collect();
        self.examine(self.body.bounds(), &all, None);
        while self.witness.is_none() {
            let Some(Ranked(cell)) = self.queue.pop() else {
                return Decision::Within(Interval {
                    lower: self.lower,
                    upper: self.accepted + slack,
                });
            };
            let size = cell.bounds.hi - cell.bounds.lo;
            if limits.reached(self.examined) || size.length() * 0.5 <= self.floor {
                return Decision::Unproven(Interval {
                    lower: self.lower,
                    upper: cell.upper.max(self.accepted) + slack,
                });
            }
            let axis = if size.x >= size.y && size.x >= size.z {
                0
            } else if size.y >= size.z {
                1
            } else {
                2
            };
            let middle = cell.bounds.centre()[axis];
            let inherited: Vec<u32> = self.planes[cell.planes.clone()].to_vec();
            let (mut low, mut high) = (cell.bounds, cell.bounds);
            low.hi[axis] = middle;
            high.lo[axis] = middle;
            for half in [low, high] {
                self.examine(half, &inherited, Some(&cell));
            }
        }
        let (witness, lower) = self.witness.unwrap_or((DVec3::ZERO, 0.0));
        Decision::Beyond { witness, lower }
    }

    /// Bound one box; queue it if it is neither empty nor within ε.
    fn examine(&mut self, bounds: Bounds, inherited: &[u32], parent: Option<&Cell>) {
        let Some((bounds, planes)) = contract(
            bounds,
            self.body.half_spaces(),
            inherited.iter().copied(),
            &mut self.planes,
        ) else {
            return;
        };
        self.examined += 1;
        let centre = bounds.centre();
        let radius = (bounds.hi - centre).length();
        let enough = self.within - radius;
        let nearest = self.nearest(centre, enough, parent);
        let distance = nearest.distance2.sqrt();
        if distance <= enough {
            self.accept(distance + radius);
            return;
        }
        let mut side = Side::Unknown;
        if radius - distance <= self.within || distance > self.within {
            side = self.side(centre, parent);
            if side == Side::Inside && radius - distance <= self.within {
                self.accept(radius - distance);
                return;
            }
            if side == Side::Outside && distance > self.beyond {
                self.probe(centre, distance, &planes);
            }
        }
        let mut upper = match side {
            Side::Inside => radius - distance,
            _ => radius + distance,
        };
        if distance <= self.within {
            let triangle = self.solid.bvh().triangle(nearest.slot);
            let corner = farthest_corner(triangle, &bounds, self.within);
            upper = upper.min(corner);
            if upper <= self.within {
                self.accept(upper);
                return;
            }
        }
        if let Some(parent) = parent {
            upper = upper.min(parent.upper);
        }
        self.queue.push(Ranked(Cell {
            bounds,
            planes,
            slot: nearest.slot,
            distance,
            centre,
            side,
            upper,
        }));
    }

    fn accept(&mut self, upper: f64) {
        self.accepted = self.accepted.max(upper);
    }

    /// The nearest triangle, looked for only as far as the parent's is.
    fn nearest(&self, q: DVec3, enough: f64, parent: Option<&Cell>) -> Nearest {
        let enough2 = if enough > 0.0 { enough * enough } else { -1.0 };
        let bvh = self.solid.bvh();
        let known = parent.map_or(
            Nearest {
                slot: 0,
                distance2: f64::INFINITY,
            },
            |p| Nearest {
                slot: p.slot,
                distance2: bvh.triangle(p.slot).distance2(q),
            },
        );
        if known.distance2 <= enough2 {
            return known;
        }
        bvh.nearest_until(q, known.distance2, enough2)
            .unwrap_or(known)
    }

    /// The side of `q`, inherited where no surface lies between.
    fn side(&self, q: DVec3, parent: Option<&Cell>) -> Side {
        if let Some(parent) = parent {
            if parent.side != Side::Unknown
                && q.distance(parent.centre) + self.solid.slack() < parent.distance
            {
                return parent.side;
            }
        }
        if self.solid.contains(q) {
            Side::Inside
        } else {
            Side::Outside
        }
    }

    /// Pull `q`, at `distance` outside the solid, into the hull, and keep it if
    /// it is still beyond ε there.
    fn probe(&mut self, q: DVec3, distance: f64, planes: &std::ops::Range<usize>) {
        let inner = self.body.centre();
        let mut keep = 1.0f64;
        for index in &self.planes[planes.clone()] {
            let space = self.body.half_spaces()[*index as usize];
            let (at, limit) = (space.normal.dot(q), space.offset - self.solid.slack());
            if at > limit {
                let depth = limit - space.normal.dot(inner);
                keep = keep.min((depth / (at - space.normal.dot(inner))).max(0.0));
            }
        }
        let point = inner + (q - inner) * keep;
        let lower = distance - point.distance(q) - self.solid.slack();
        if lower > self.lower {
            self.lower = lower;
            if lower > self.beyond {
                self.witness = Some((point, lower));
            }
        }
    }
}

/// Largest distance of the box's corners, hence of all its points, to one
/// triangle; infinite as soon as it exceeds `limit`.
fn farthest_corner(triangle: &Triangle, bounds: &Bounds, limit: f64) -> f64 {
    let limit2 = limit * limit;
    let mut most = 0.0f64;
    for k in 0..8 {
        let pick = |bit: usize, lo: f64, hi: f64| if k >> bit & 1 == 0 { lo } else { hi };
        let corner = DVec3::new(
            pick(0, bounds.lo.x, bounds.hi.x),
            pick(1, bounds.lo.y, bounds.hi.y),
            pick(2, bounds.lo.z, bounds.hi.z),
        );
        most = most.max(triangle.distance2(corner));
        if most > limit2 {
            return f64::INFINITY;
        }
    }
    most.sqrt()
}

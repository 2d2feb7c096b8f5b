//! Branch and bound over the cells of a hull.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use assetpipe_geometry::bvh::{Bounds, Nearest};
use assetpipe_geometry::distance::{ConvexBody, SolidIndex};
use assetpipe_geometry::{DVec3, Mesh};

use super::cell::{contract, Polytope};
use super::enclosed::is_free_of_surface;
use crate::concavity::goal::{self, Goal};
use crate::concavity::{mixture, Interval, Limits};

/// A cell with a larger radius than this share of the target is split before
/// its corners are looked at, unless its nearest triangle is as large as it is.
const COARSE: f64 = 0.5;
/// A cell cut by more half-spaces is split before it is asked whether the solid
/// encloses it.
const ENCLOSING: usize = 12;
/// The same for a cell without a point at this share of its size from its sides.
const SHARP: f64 = 1e-5;
/// Share of the solid's rounding allowance by which planes are moved.
const MARGIN: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Unknown,
    Inside,
    Outside,
}

/// A part of the hull whose bound is above the target.
struct Cell {
    bounds: Bounds,
    /// Half-spaces that cut it, in `Search::planes`.
    planes: Range<usize>,
    centre: DVec3,
    /// Nearest triangle to the centre and its distance.
    slot: u32,
    distance: f64,
    side: Side,
    upper: f64,
    /// Order of creation: makes the order of the queue total.
    serial: usize,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper
            .total_cmp(&other.upper)
            .then(other.serial.cmp(&self.serial))
    }
}

pub(super) struct Search<'a> {
    solid: &'a SolidIndex,
    body: ConvexBody<'a>,
    goal: Goal,
    /// Allowance for rounding, taken off lower bounds and added to upper ones.
    slack: f64,
    planes: Vec<u32>,
    queue: BinaryHeap<Cell>,
    /// Largest bound of a cell that was done with.
    settled: f64,
    lower: f64,
    witness: Option<DVec3>,
    examined: usize,
    cell: Polytope,
    scratch: Scratch,
}

/// Buffers of [`Search::mix`].
#[derive(Default)]
struct Scratch {
    rows: Vec<Vec<f64>>,
    slots: Vec<u32>,
    tableau: mixture::Tableau,
}

impl<'a> Search<'a> {
    pub(super) fn new(solid: &'a SolidIndex, hull: &'a Mesh, goal: Goal) -> Self {
        Search {
            solid,
            body: ConvexBody::new(hull),
            goal,
            slack: solid.slack(),
            planes: Vec::new(),
            queue: BinaryHeap::new(),
            settled: 0.0,
            lower: 0.0,
            witness: None,
            examined: 0,
            cell: Polytope::default(),
            scratch: Scratch::default(),
        }
    }

    /// The farthest point found and the lower bound of its distance.
    pub(super) fn witness(&self) -> Option<(DVec3, f64)> {
        self.witness.map(|w| (w, self.lower))
    }

    pub(super) fn run(&mut self, limits: &Limits) -> Interval {
        if self.solid.bvh().is_empty() {
            return Interval::exactly(f64::INFINITY);
        }
        self.planes = (0..self.body.half_spaces().len() as u32).collect();
        self.examine(self.body.bounds(), 0..self.planes.len(), None);
        while let Some(cell) = self.queue.pop() {
            if cell.upper <= self.target() {
                self.settle(cell.upper);
                continue;
            }
            let size = cell.bounds.hi - cell.bounds.lo;
            if self.goal.is_settled(self.lower) || limits.reached(self.examined) {
                self.settle(cell.upper);
                break;
            }
            let axis = longest(size);
            let middle = cell.bounds.centre()[axis];
            let (mut low, mut high) = (cell.bounds, cell.bounds);
            low.hi[axis] = middle;
            high.lo[axis] = middle;
            for half in [low, high] {
                self.examine(half, cell.planes.clone(), Some(&cell));
            }
        }
        self.verify();
        Interval {
            lower: self.lower,
            upper: self.settled + self.slack,
        }
    }

    /// Make sure that the witness belongs to the hull, by exact signs: rounding
    /// may have left it just outside, so step towards the middle until it does.
    fn verify(&mut self) {
        let Some(found) = self.witness else { return };
        let middle = self.body.centre();
        for step in [0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-6] {
            let point = found + (middle - found) * step;
            if self.body.contains(point) {
                self.lower -= point.distance(found);
                self.witness = Some(point);
                return;
            }
        }
        self.lower = 0.0;
        self.witness = None;
    }

    /// Cells with at most this bound are done with.
    fn target(&self) -> f64 {
        self.goal.target(self.lower, self.slack)
    }

    fn settle(&mut self, upper: f64) {
        self.settled = self.settled.max(upper);
    }

    /// Bound what `inherited` half-spaces leave of a box, and settle or queue it.
    fn examine(&mut self, bounds: Bounds, inherited: Range<usize>, parent: Option<&Cell>) {
        let Some((bounds, planes)) =
            contract(bounds, self.body.half_spaces(), inherited, &mut self.planes)
        else {
            return;
        };
        self.examined += 1;
        let centre = bounds.centre();
        let radius = (bounds.hi - centre).length();
        let target = self.target();
        let enough = target - radius;
        let enough2 = if enough > 0.0 { enough * enough } else { -1.0 };
        let nearest = self.nearest(centre, enough2, parent);
        let distance = nearest.distance2.sqrt();
        // From here on `distance` is the least one: the search did not stop early.
        if nearest.distance2 <= enough2 {
            return self.settle(distance + radius);
        }
        let mut upper = parent.map_or(f64::INFINITY, |p| p.upper);
        let mut side = Side::Unknown;
        if radius - distance <= target || distance > target {
            side = self.side(centre, parent);
        }
        match side {
            Side::Inside => upper = upper.min((radius - distance).max(0.0)),
            Side::Outside if distance > self.lower => self.probe(centre, distance, &planes),
            _ => {}
        }
        if side != Side::Inside {
            upper = upper.min(distance + radius);
        }
        if upper > target {
            upper = upper.min(self.look_closer(&bounds, &planes, radius, side, nearest.slot));
        }
        if upper <= target {
            return self.settle(upper);
        }
        self.queue.push(Cell {
            bounds,
            planes,
            centre,
            slot: nearest.slot,
            distance,
            side,
            upper,
            serial: self.examined,
        });
    }

    /// The nearest triangle to `q`, or any not farther than `sqrt(enough2)`; the
    /// parent's is the first guess.
    fn nearest(&self, q: DVec3, enough2: f64, parent: Option<&Cell>) -> Nearest {
        let bvh = self.solid.bvh();
        let guess = parent.map_or(0, |p| p.slot);
        let known = Nearest {
            slot: guess,
            distance2: bvh.triangle(guess).distance2(q),
        };
        if known.distance2 <= enough2 {
            return known;
        }
        bvh.nearest_until(q, known.distance2, enough2)
            .unwrap_or(known)
    }

    /// The side of `q`, taken from the parent where no surface lies between.
    fn side(&self, q: DVec3, parent: Option<&Cell>) -> Side {
        if let Some(parent) = parent {
            if parent.side != Side::Unknown
                && q.distance(parent.centre) + self.slack < parent.distance
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

    /// Raise the lower bound with `q`, at `distance` outside the solid, after
    /// pulling it into the hull.
    fn probe(&mut self, q: DVec3, distance: f64, planes: &Range<usize>) {
        let point = self.pull(q, planes);
        let lower = distance - point.distance(q) - self.slack;
        if lower > self.lower {
            self.lower = lower;
            self.witness = Some(point);
        }
    }

    /// The point of the hull on the way from `q` to the middle that is nearest
    /// to `q`, where only the half-spaces in `planes` may be broken at `q`.
    fn pull(&self, q: DVec3, planes: &Range<usize>) -> DVec3 {
        let inner = self.body.centre();
        let mut keep = 1.0f64;
        for index in &self.planes[planes.clone()] {
            let space = self.body.half_spaces()[*index as usize];
            let (at, limit) = (space.normal.dot(q), space.offset - MARGIN * self.slack);
            if at > limit {
                let from = space.normal.dot(inner);
                keep = keep.min(((limit - from) / (at - from)).max(0.0));
            }
        }
        if keep < 1.0 {
            inner + (q - inner) * keep
        } else {
            q
        }
    }

    /// The bounds that need the cell's corners, where they may help.
    fn look_closer(
        &mut self,
        bounds: &Bounds,
        planes: &Range<usize>,
        radius: f64,
        side: Side,
        slot: u32,
    ) -> f64 {
        let target = self.target();
        // The centre of the box need not belong to the cell.
        let may_be_inside =
            side != Side::Outside || self.pull(bounds.centre(), planes) != bounds.centre();
        let may_be_enclosed = may_be_inside && radius > target && planes.len() <= ENCLOSING;
        let may_be_near = radius <= COARSE * target
            || self.solid.bvh().triangle(slot).bounds().diagonal() >= radius;
        if !may_be_enclosed && !may_be_near {
            return f64::INFINITY;
        }
        let mut cell = std::mem::take(&mut self.cell);
        let spaces = self.planes[planes.clone()].iter();
        cell.set(
            *bounds,
            spaces.map(|i| self.body.half_spaces()[*i as usize]),
            MARGIN * self.slack,
        );
        let mut upper = f64::INFINITY;
        if cell.corners.is_empty() {
            upper = 0.0;
        } else if may_be_enclosed {
            upper = self.enclosed(&cell);
        }
        if upper > target && may_be_near {
            upper = self.mix(&cell.corners, slot, planes);
        }
        self.cell = cell;
        upper
    }

    /// The width of a rim, at most the target, such that all of the cell but the
    /// rim belongs to the solid; infinite if there is none.
    ///
    /// Let m be a point of the cell, `room` away from all its sides, and no
    /// corner farther from m than `reach`. If no surface enters the cell with
    /// its sides moved inward by δ, and m is inside, the cell shrunk towards m by
    /// 1 − δ/room belongs to the solid, and shrinking moved no point by more
    /// than δ · reach / room.
    fn enclosed(&mut self, cell: &Polytope) -> f64 {
        let target = self.target();
        let middle = cell.corners.iter().sum::<DVec3>() / cell.corners.len() as f64;
        let middle = middle.clamp(cell.bounds.lo, cell.bounds.hi);
        let to_box = (middle - cell.bounds.lo).min(cell.bounds.hi - middle);
        let reach = cell
            .corners
            .iter()
            .fold(0.0f64, |r, c| r.max(c.distance(middle)));
        let room = cell
            .spaces
            .iter()
            .map(|s| s.offset - s.normal.dot(middle))
            .fold(to_box.min_element(), f64::min);
        if room <= SHARP * reach {
            return f64::INFINITY;
        }
        // As good as nothing, if that is true; else what is just good enough.
        let rims = [goal::NOTHING * self.slack, target];
        let rim = rims
            .into_iter()
            .find(|rim| is_free_of_surface(self.solid.bvh(), cell, rim * room / reach));
        match rim {
            Some(rim) if self.solid.contains(middle) => rim,
            _ => f64::INFINITY,
        }
    }

    /// Mix triangles, starting with `slot`, each next one nearest to the corner
    /// that is worst for all so far.
    fn mix(&mut self, points: &[DVec3], slot: u32, planes: &Range<usize>) -> f64 {
        let target = self.target();
        let mut rows = std::mem::take(&mut self.scratch.rows);
        let mut tableau = std::mem::take(&mut self.scratch.tableau);
        let mut slots = std::mem::take(&mut self.scratch.slots);
        slots.clear();
        let mut next = slot;
        let mut upper = f64::INFINITY;
        while slots.len() < mixture::MOST {
            let triangle = self.solid.bvh().triangle(next);
            if rows.len() <= slots.len() {
                rows.push(Vec::new());
            }
            let row = &mut rows[slots.len()];
            row.clear();
            row.extend(points.iter().map(|p| triangle.distance2(*p).sqrt()));
            slots.push(next);
            let bound = mixture::upper_bound(&rows[..slots.len()], &mut tableau);
            upper = upper.min(bound);
            if upper <= target {
                break;
            }
            // The corner that no triangle so far is near to.
            let mut worst = (f64::NEG_INFINITY, 0);
            for i in 0..points.len() {
                let best = rows[..slots.len()]
                    .iter()
                    .fold(f64::INFINITY, |b, r| b.min(r[i]));
                if best > worst.0 {
                    worst = (best, i);
                }
            }
            let q = points[worst.1];
            let Some(nearest) = self.solid.bvh().nearest(q, f64::INFINITY) else {
                break;
            };
            let distance = nearest.distance2.sqrt();
            if distance > target.max(self.lower) && self.side(q, None) == Side::Outside {
                self.probe(q, distance, planes);
            }
            if slots.contains(&nearest.slot) {
                break;
            }
            next = nearest.slot;
        }
        self.scratch.rows = rows;
        self.scratch.tableau = tableau;
        self.scratch.slots = slots;
        upper
    }
}

fn longest(size: DVec3) -> usize {
    if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    }
}

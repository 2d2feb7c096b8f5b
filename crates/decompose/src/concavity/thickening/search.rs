//! Branch and bound over the cells of a hull.

mod closer;

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::ops::Range;

use assetpipe_geometry::bvh::{Bounds, Nearest};
use assetpipe_geometry::distance::{ConvexBody, HalfSpace, SolidIndex};
use assetpipe_geometry::{DVec3, Mesh};

use super::cell::{contract, Polytope};
use super::enclosed::Inner;
use crate::concavity::goal::Goal;
use crate::concavity::{mixture, Interval, Limits};

/// By how much the cosine of a half-space along an axis may be off.
const FLAT: f64 = 1e-12;
/// Share of the solid's rounding allowance by which planes are moved.
const MARGIN: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Unknown,
    Inside,
    Outside,
}

/// A part of the hull whose bound is above the target.
#[derive(Clone)]
struct Cell {
    bounds: Bounds,
    /// Half-spaces that cut it, in `Search::planes`.
    planes: Range<usize>,
    centre: DVec3,
    /// A triangle near the centre.
    slot: u32,
    /// One that keeps the solid from enclosing the cell, if such is known.
    blocker: u32,
    /// Distance from the centre to the surface, where the search for it ran to
    /// the end and the side is known; else zero.
    clear: f64,
    side: Side,
    /// The nearest cell above, itself included, whose centre is inside.
    ball: Option<usize>,
    /// The one above that.
    outer: Option<usize>,
    upper: f64,
    /// How often the hull's box was split.
    level: usize,
}

/// A bound as the key of the queue.
#[derive(Clone, Copy, PartialEq)]
struct Key(f64);

impl Eq for Key {}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Key {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

pub(super) struct Search<'a> {
    solid: &'a SolidIndex,
    body: ConvexBody<'a>,
    goal: Goal,
    /// Allowance for rounding, taken off lower bounds and added to upper ones.
    slack: f64,
    planes: Vec<u32>,
    cells: Vec<Cell>,
    /// Cells still to be split, by bound.
    queue: BinaryHeap<(Key, Reverse<usize>)>,
    /// Largest bound of a cell that was done with.
    settled: f64,
    lower: f64,
    /// What the lower bound was at the start.
    known: f64,
    witness: Option<DVec3>,
    examined: usize,
    /// Half-spaces along the axes: boxes end at them, so that they cut none.
    flats: Vec<HalfSpace>,
    cell: Polytope,
    wide: Polytope,
    inner: Inner,
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
        let body = ConvexBody::new(hull);
        let is_flat = |s: &&HalfSpace| s.normal.abs().max_element() >= 1.0 - FLAT;
        let flats = body.half_spaces().iter().filter(is_flat).copied();
        Search {
            solid,
            flats: flats.collect(),
            body,
            goal,
            slack: solid.slack(),
            planes: Vec::new(),
            cells: Vec::new(),
            queue: BinaryHeap::new(),
            settled: 0.0,
            lower: 0.0,
            known: 0.0,
            witness: None,
            examined: 0,
            cell: Polytope::default(),
            wide: Polytope::default(),
            inner: Inner::default(),
            scratch: Scratch::default(),
        }
    }

    /// The farthest point found and the lower bound of its distance.
    pub(super) fn witness(&self) -> Option<(DVec3, f64)> {
        self.witness.map(|w| (w, self.lower))
    }

    /// Look for what is above `known` only.
    pub(super) fn rise_to(&mut self, known: f64) {
        self.known = known;
        self.lower = known;
    }

    pub(super) fn run(&mut self, limits: &Limits) -> Interval {
        if self.solid.bvh().is_empty() {
            return Interval::exactly(f64::INFINITY);
        }
        self.planes = (0..self.body.half_spaces().len() as u32).collect();
        self.examine(self.body.bounds(), 0..self.planes.len(), None);
        while let Some((_, Reverse(index))) = self.queue.pop() {
            let cell = self.cells[index].clone();
            if cell.upper <= self.target() {
                self.settle(cell.upper);
                continue;
            }
            if self.goal.is_settled(self.lower) || limits.reached(self.examined) {
                self.settle(cell.upper);
                break;
            }
            let axis = longest(cell.bounds.hi - cell.bounds.lo);
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
            upper: (self.settled + self.slack).max(self.lower),
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
                self.lower = (self.lower - point.distance(found)).max(self.known);
                self.witness = Some(point);
                return;
            }
        }
        self.lower = self.known;
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
        let target = self.target();
        let in_ball = self.in_balls(&bounds, parent);
        if in_ball <= target {
            return self.settle(in_ball);
        }
        let centre = bounds.centre();
        let radius = (bounds.hi - centre).length();
        // Near enough that the cell is settled; or, for a large one, so near
        // that looking on settles nothing.
        let enough = (target - radius).max((radius - target).min(target));
        let enough2 = enough * enough;
        let nearest = self.nearest(centre, enough2, parent);
        let distance = nearest.distance2.sqrt();
        let is_least = nearest.distance2 > enough2;
        if !is_least && radius <= target {
            return self.settle(distance + radius);
        }
        let mut cell = Cell {
            upper: parent.map_or(f64::INFINITY, |p| p.upper).min(in_ball),
            ball: parent.and_then(|p| p.ball),
            outer: parent.and_then(|p| p.outer),
            slot: nearest.slot,
            blocker: parent.map_or(nearest.slot, |p| p.blocker),
            side: Side::Unknown,
            level: parent.map_or(0, |p| p.level + 1),
            clear: 0.0,
            bounds,
            planes,
            centre,
        };
        if is_least && (radius - distance <= target || distance > target) {
            cell.side = self.side(centre, parent);
            cell.clear = distance;
        }
        match cell.side {
            Side::Inside => {
                cell.upper = cell.upper.min((radius - distance).max(0.0));
                (cell.ball, cell.outer) = (Some(self.cells.len()), cell.ball);
            }
            Side::Outside if distance > self.lower => {
                self.probe(centre, distance, &cell.planes);
            }
            _ => {}
        }
        if cell.side != Side::Inside {
            cell.upper = cell.upper.min(distance + radius);
        }
        if cell.upper > target {
            cell.upper = cell.upper.min(self.look_closer(&mut cell, radius));
        }
        if cell.upper <= target {
            return self.settle(cell.upper);
        }
        self.queue
            .push((Key(cell.upper), Reverse(self.cells.len())));
        self.cells.push(cell);
    }

    /// A bound from balls inside the solid about the centres of cells above.
    fn in_balls(&self, bounds: &Bounds, parent: Option<&Cell>) -> f64 {
        let Some(parent) = parent else {
            return f64::INFINITY;
        };
        [parent.ball, parent.outer]
            .into_iter()
            .flatten()
            .map(|index| {
                let ball = &self.cells[index];
                let farthest = (bounds.lo - ball.centre)
                    .abs()
                    .max((bounds.hi - ball.centre).abs());
                (farthest.length() - ball.clear).max(0.0)
            })
            .fold(f64::INFINITY, f64::min)
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
            if parent.side != Side::Unknown && q.distance(parent.centre) + self.slack < parent.clear
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

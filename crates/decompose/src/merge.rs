//! §6.5: put parts together again where the proof allows it.

use std::sync::{Arc, PoisonError, RwLock};

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use crate::ahead::{in_turn, shared_out, Ahead, Dropped, Order, Pair, Turns};
use crate::between::Tips;
use crate::concavity::{Decision, Interval, Limits};
use crate::even;
use crate::judge::Judge;
use crate::search::piece::Piece;
use crate::settings::{MergeOrder, Metric};

/// A hull with what is proved about it.
#[derive(Clone, Debug)]
pub struct Proved {
    /// The hull.
    pub hull: Mesh,
    /// Its thickening.
    pub thickening: Interval,
    /// Which leaves it covers.
    pub members: Vec<u32>,
}

/// Volume of a closed mesh.
pub fn volume(mesh: &Mesh) -> f64 {
    let Some(&o) = mesh.vertices.first() else {
        return 0.0;
    };
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| p - o);
            a.dot(b.cross(c))
        })
        .sum::<f64>()
        / 6.0
}

/// Bounding box as (low, high).
pub fn bounds(mesh: &Mesh) -> (DVec3, DVec3) {
    mesh.vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        })
}

/// Planes of a hull's faces: `normal · x ≤ offset` inside.
pub fn half_spaces(hull: &Mesh) -> Vec<(DVec3, f64)> {
    (0..hull.triangles.len())
        .map(|t| {
            let [a, b, c] = hull.corners(t);
            let n = (b - a).cross(c - a);
            (n, n.dot(a))
        })
        .collect()
}

/// A joined hull is kept until its turn if so many vertices are enough for one like it for each pair
/// that waits; else it is made again.
const KEPT: usize = 1 << 20;

/// Merge pairs, cheapest added volume first, for as long as a merged hull is
/// proved to stay within ε. `witnesses` are known points farther than ε from
/// the solid: a hull that holds one needs no proof to be refused.
///
/// Whether a joined hull may stand depends on its two hulls alone. So with several threads the
/// next pairs are proved ahead of their turn, and the merges are those of one thread.
pub fn merge(
    judge: &Judge<'_>,
    parts: Vec<Proved>,
    pieces: &[Piece],
    order: MergeOrder,
    witnesses: &mut Vec<DVec3>,
) -> Vec<Proved> {
    let test = Test {
        judge,
        pieces,
        order,
        witnesses: RwLock::new(std::mem::take(witnesses)),
    };
    let slots: Vec<Arc<Slot>> = parts
        .into_par_iter()
        .map(|part| Arc::new(Slot::new(part)))
        .collect();
    let priced: Vec<(Turn, Mesh)> = (0..slots.len())
        .into_par_iter()
        .flat_map_iter(|j| (0..j).map(move |i| [i, j]))
        .filter_map(|[i, j]| test.price([(i as u32, &slots[i]), (j as u32, &slots[j])]))
        .collect();
    let mut merging = Merging {
        test: &test,
        slots,
        order: Order::new(Ahead::Any),
        unpriced: Vec::new(),
        pricing: 0,
    };
    merging.put(priced);
    let merged = in_turn(merging, |task| test.run(task));
    let left = (0u32..).zip(merged.slots);
    let left = left.filter(|(k, _)| !merged.order.is_gone(*k));
    let left = left.map(|(_, slot)| Arc::unwrap_or_clone(slot).proved);
    let left = left.collect();
    *witnesses = test
        .witnesses
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    left
}

/// A hull that still stands, with what is asked of it again and again.
#[derive(Clone)]
struct Slot {
    proved: Proved,
    volume: f64,
    bounds: (DVec3, DVec3),
    tips: Tips,
}

impl Slot {
    fn new(proved: Proved) -> Slot {
        Slot {
            volume: volume(&proved.hull),
            bounds: bounds(&proved.hull),
            tips: Tips::of(&proved.hull),
            proved,
        }
    }
}

/// The bits of the price of a pair of slots, and the pair.
type Turn = (u64, u32, u32);

impl Pair for Turn {
    fn pair(&self) -> [u32; 2] {
        [self.1, self.2]
    }
}

/// What is worked on by itself.
enum Task {
    /// Whether the hull of a pair, if it was kept, may stand for these parts.
    Decide(Turn, [Arc<Slot>; 2], Option<Mesh>, Dropped),
    /// Price the pairs of the first slot with the others.
    Price(Vec<(u32, Arc<Slot>)>),
}

/// What came of it.
enum Done {
    /// The hull that may stand.
    Decided(Turn, Option<Proved>),
    Priced(Vec<(Turn, Mesh)>),
}

/// What is asked about pairs.
struct Test<'a> {
    judge: &'a Judge<'a>,
    pieces: &'a [Piece],
    order: MergeOrder,
    witnesses: RwLock<Vec<DVec3>>,
}

impl Test<'_> {
    fn run(&self, task: Task) -> Done {
        match task {
            Task::Decide(turn, pair, hull, dropped) => {
                Done::Decided(turn, self.decide(&pair, hull, &dropped))
            }
            Task::Price(slots) => {
                let Some(((new, slot), others)) = slots.split_first() else {
                    return Done::Priced(Vec::new());
                };
                let others = others.iter();
                let priced =
                    others.filter_map(|(i, other)| self.price([(*i, other), (*new, slot)]));
                Done::Priced(priced.collect())
            }
        }
    }

    /// The turn of a pair and its hull, unless it is seen at once that it may not stand.
    fn price(&self, [(i, a), (j, b)]: [(u32, &Arc<Slot>); 2]) -> Option<(Turn, Mesh)> {
        let gap = (a.bounds.0 - b.bounds.1)
            .max(b.bounds.0 - a.bounds.1)
            .max(DVec3::ZERO);
        let Judge { solid, epsilon, .. } = *self.judge;
        if gap.length() > 2.0 * epsilon
            || a.tips.reach_beyond(&b.tips, solid, epsilon)
            || (self.judge.limits.cancelled)()
        {
            return None;
        }
        let hull = joined(a, b)?;
        if self.is_refused(&hull) {
            return None;
        }
        let added = (volume(&hull) - a.volume - b.volume).max(0.0);
        let key = match self.order {
            MergeOrder::Added => added,
            MergeOrder::Relative => added / (a.volume + b.volume),
            MergeOrder::Smallest => added + a.volume.min(b.volume),
        };
        Some(((even::weight(even::length(key)).to_bits(), i, j), hull))
    }

    /// The hull of a pair, if it may stand.
    fn decide(
        &self,
        pair: &[Arc<Slot>; 2],
        hull: Option<Mesh>,
        dropped: &Dropped,
    ) -> Option<Proved> {
        let hull = hull.or_else(|| joined(&pair[0], &pair[1]))?;
        if self.is_refused(&hull) {
            return None;
        }
        let mut members = pair
            .each_ref()
            .map(|slot| &slot.proved.members[..])
            .concat();
        members.sort_unstable();
        let own: Vec<&Piece> = members.iter().map(|&m| &self.pieces[m as usize]).collect();
        let cancelled = || (self.judge.limits.cancelled)() || dropped.is_dropped();
        let limits = Limits {
            cancelled: &cancelled,
            ..*self.judge.limits
        };
        let judge = Judge {
            limits: &limits,
            ..*self.judge
        };
        match judge.decide(&hull, &own) {
            Decision::Within(thickening) => Some(Proved {
                hull,
                thickening,
                members,
            }),
            Decision::Beyond { witness, .. } if judge.metric == Metric::Thickening => {
                let mut witnesses = self
                    .witnesses
                    .write()
                    .unwrap_or_else(PoisonError::into_inner);
                witnesses.push(witness);
                None
            }
            _ => None,
        }
    }

    /// Whether a hull holds a witness.
    fn is_refused(&self, hull: &Mesh) -> bool {
        let witnesses = self
            .witnesses
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        holds_any(hull, &witnesses)
    }
}

/// Slots, and pairs of them in the order of their turns.
struct Merging<'a> {
    test: &'a Test<'a>,
    /// Those too that are gone.
    slots: Vec<Arc<Slot>>,
    /// With hulls that are kept, and those that may stand.
    order: Order<Turn, Option<Mesh>, Option<Proved>>,
    /// Slots that are still to be priced with the first.
    unpriced: Vec<Vec<(u32, Arc<Slot>)>>,
    /// How many of these come before anything has its turn.
    pricing: usize,
}

impl Turns for Merging<'_> {
    type Task = Task;
    type Done = Done;

    fn next(&mut self) -> Option<Task> {
        if (self.test.judge.limits.cancelled)() {
            return None;
        }
        while self.pricing == 0 {
            let Some((turn, found)) = self.order.settle() else {
                break;
            };
            if let Some(proved) = found {
                self.merge(turn, proved);
            }
        }
        if let Some(slots) = self.unpriced.pop() {
            return Some(Task::Price(slots));
        }
        let (turn, hull, dropped) = self.order.ask()?;
        let pair = turn.pair().map(|k| self.slots[k as usize].clone());
        Some(Task::Decide(turn, pair, hull, dropped))
    }

    fn take(&mut self, done: Done) {
        match done {
            Done::Decided(turn, found) => self.order.answer(turn, found),
            Done::Priced(pairs) => {
                self.pricing -= 1;
                self.put(pairs);
            }
        }
    }
}

impl Merging<'_> {
    /// Let pairs wait for their turn.
    fn put(&mut self, pairs: Vec<(Turn, Mesh)>) {
        for (turn, hull) in pairs {
            let kept = self.order.len() * hull.vertices.len() < KEPT;
            self.order.push(turn, kept.then_some(hull));
        }
    }

    /// Let the hull of a pair stand for both.
    fn merge(&mut self, turn: Turn, proved: Proved) {
        self.order.retire(&turn);
        let new = Arc::new(Slot::new(proved));
        let others: Vec<(u32, Arc<Slot>)> = (0u32..)
            .zip(&self.slots)
            .filter(|(k, _)| !self.order.is_gone(*k))
            .map(|(k, slot)| (k, slot.clone()))
            .collect();
        self.unpriced = shared_out(&(self.slots.len() as u32, new.clone()), &others);
        self.pricing = self.unpriced.len();
        self.slots.push(new);
    }
}

fn joined(a: &Slot, b: &Slot) -> Option<Mesh> {
    let both = [a, b].into_iter();
    let points: Vec<DVec3> = both
        .flat_map(|slot| slot.proved.hull.vertices.iter().copied())
        .collect();
    convex_hull(&points).ok()
}

fn holds_any(hull: &Mesh, witnesses: &[DVec3]) -> bool {
    let (lo, hi) = bounds(hull);
    let planes = half_spaces(hull);
    witnesses.iter().any(|w| {
        w.cmpge(lo).all() && w.cmple(hi).all() && planes.iter().all(|(n, o)| n.dot(*w) < *o)
    })
}

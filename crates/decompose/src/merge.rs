//! §6.5: put parts together again where the proof allows it.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use crate::ahead::ahead;
use crate::between::Tips;
use crate::concavity::{Decision, Interval};
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

/// Vertices of joined hulls that are kept until their turn; beyond that they are made again.
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
    let mut merging = Merging {
        judge,
        pieces,
        order,
        slots: parts.into_par_iter().map(Slot::new).map(Some).collect(),
        queue: BinaryHeap::new(),
        known: BTreeMap::new(),
        kept: 0,
        witnesses,
    };
    merging.run();
    let left = merging.slots.into_iter().flatten();
    left.map(|slot| slot.proved).collect()
}

/// A hull that still stands, with what is asked of it again and again.
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

/// A pair whose turn it may be.
struct Candidate {
    turn: Turn,
    hull: Mesh,
    /// Whether the hull may stand, where that was looked at ahead of its turn.
    decision: Option<Decision>,
}

struct Merging<'a> {
    judge: &'a Judge<'a>,
    pieces: &'a [Piece],
    order: MergeOrder,
    slots: Vec<Option<Slot>>,
    queue: BinaryHeap<Reverse<Turn>>,
    /// Hulls of pairs in the queue, and what was decided about them.
    known: BTreeMap<(u32, u32), (Mesh, Option<Decision>)>,
    /// Vertices in `known`.
    kept: usize,
    witnesses: &'a mut Vec<DVec3>,
}

impl Merging<'_> {
    fn run(&mut self) {
        let this = &*self;
        let priced: Vec<Candidate> = (0..self.slots.len() as u32)
            .into_par_iter()
            .flat_map_iter(|j| (0..j).filter_map(move |i| this.price(i, j)))
            .collect();
        self.put(priced);
        loop {
            let mut next = self.take(1 + ahead());
            if next.is_empty() || (self.judge.limits.cancelled)() {
                return;
            }
            let this = &*self;
            next.par_iter_mut()
                .with_max_len(1)
                .filter(|c| c.decision.is_none())
                .for_each(|c| c.decision = this.decide(c));
            self.settle(next);
        }
    }

    fn slot(&self, i: u32) -> Option<&Slot> {
        self.slots[i as usize].as_ref()
    }

    /// A pair as a candidate, unless it is seen at once that its hull may not stand.
    fn price(&self, i: u32, j: u32) -> Option<Candidate> {
        let (a, b) = (self.slot(i)?, self.slot(j)?);
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
        if holds_any(&hull, self.witnesses) {
            return None;
        }
        let added = (volume(&hull) - a.volume - b.volume).max(0.0);
        let key = match self.order {
            MergeOrder::Added => added,
            MergeOrder::Relative => added / (a.volume + b.volume),
            MergeOrder::Smallest => added + a.volume.min(b.volume),
        };
        Some(Candidate {
            turn: (even::weight(even::length(key)).to_bits(), i, j),
            hull,
            decision: None,
        })
    }

    /// Let candidates wait for their turn.
    fn put(&mut self, candidates: Vec<Candidate>) {
        for candidate in candidates {
            let (_, i, j) = candidate.turn;
            self.queue.push(Reverse(candidate.turn));
            if self.kept < KEPT || candidate.decision.is_some() {
                self.kept += candidate.hull.vertices.len();
                let known = (candidate.hull, candidate.decision);
                self.known.insert((i, j), known);
            }
        }
    }

    /// The next candidates whose slots both stand: `count` that are not decided yet, or up to one
    /// that may be merged.
    fn take(&mut self, count: usize) -> Vec<Candidate> {
        let mut next = Vec::new();
        let mut undecided = 0;
        while undecided < count {
            let Some(Reverse(turn)) = self.queue.pop() else {
                break;
            };
            let (_, i, j) = turn;
            let known = self.known.remove(&(i, j));
            self.kept -= known.as_ref().map_or(0, |k| k.0.vertices.len());
            let (Some(a), Some(b)) = (self.slot(i), self.slot(j)) else {
                continue;
            };
            let Some((hull, decision)) = known.or_else(|| Some((joined(a, b)?, None))) else {
                continue;
            };
            undecided += usize::from(decision.is_none());
            let merges = matches!(decision, Some(Decision::Within(_)));
            next.push(Candidate {
                turn,
                hull,
                decision,
            });
            if merges {
                break;
            }
        }
        next
    }

    /// Whether a candidate's hull may stand; `None` if a witness says no.
    fn decide(&self, candidate: &Candidate) -> Option<Decision> {
        if holds_any(&candidate.hull, self.witnesses) {
            return None;
        }
        let own: Vec<&Piece> = self
            .members(candidate.turn)
            .iter()
            .map(|&m| &self.pieces[m as usize])
            .collect();
        Some(self.judge.decide(&candidate.hull, &own))
    }

    /// The parts that a joined hull covers.
    fn members(&self, (_, i, j): Turn) -> Vec<u32> {
        let both = [i, j].into_iter().filter_map(|k| self.slot(k));
        let mut members: Vec<u32> = both
            .flat_map(|slot| slot.proved.members.iter().copied())
            .collect();
        members.sort_unstable();
        members
    }

    /// Merge the first of these that may; the others wait again for what comes before them.
    fn settle(&mut self, candidates: Vec<Candidate>) {
        let mut candidates = candidates.into_iter();
        while let Some(Candidate {
            turn,
            hull,
            decision,
        }) = candidates.next()
        {
            match decision {
                Some(Decision::Within(thickening)) => {
                    let members = self.members(turn);
                    let (_, i, j) = turn;
                    self.slots[i as usize] = None;
                    self.slots[j as usize] = None;
                    let new = self.slots.len() as u32;
                    self.slots.push(Some(Slot::new(Proved {
                        hull,
                        thickening,
                        members,
                    })));
                    let this = &*self;
                    let others = (0..new).into_par_iter();
                    let priced = others.filter_map(|other| this.price(other, new)).collect();
                    self.put(priced);
                    self.put(candidates.collect());
                    return;
                }
                Some(Decision::Beyond { witness, .. })
                    if self.judge.metric == Metric::Thickening =>
                {
                    self.witnesses.push(witness);
                }
                _ => {}
            }
        }
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

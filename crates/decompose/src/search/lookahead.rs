//! One step and two steps ahead.

use std::cell::RefCell;

use glam::DVec3;
use rayon::prelude::*;

use super::piece::Piece;
use super::trial::{sweep, Basis, Forbidden, Scratch, Side, Sweep};
use super::value::Value;
use crate::settings::{Policy, SearchSettings};
use assetpipe_geometry::Plane;

/// What a policy looks at.
pub struct Question<'a> {
    /// The part, as coarse as the search wants it.
    pub piece: &'a Piece,
    /// Samples of forbidden space in its hull.
    pub forbidden: &'a [Forbidden],
    /// Directions of candidate cuts.
    pub directions: &'a [Basis],
    /// Offsets beside the grid, for each direction, increasing.
    pub extra: &'a [Vec<f64>],
    /// The same for the second cut.
    pub extra_second: &'a [Vec<f64>],
    /// The tolerance.
    pub epsilon: f64,
    /// Parameters.
    pub settings: &'a SearchSettings,
}

/// A chosen cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Index into the directions.
    pub direction: usize,
    /// Height of the plane.
    pub offset: f64,
    /// Its value; smaller is better.
    pub value: f64,
}

/// Extent of points along a direction.
pub fn extent(points: &[DVec3], w: DVec3) -> (f64, f64) {
    points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
            let z = w.dot(*p);
            (lo.min(z), hi.max(z))
        })
}

/// `count` inner points of an interval, with `extra` ones sorted in.
fn grid(lo: f64, hi: f64, count: usize, extra: &[f64]) -> Vec<f64> {
    let step = (hi - lo) / (count + 1) as f64;
    let margin = (hi - lo) * 1e-4;
    let mut offsets: Vec<f64> = extra
        .iter()
        .copied()
        .filter(|&t| t > lo + margin && t < hi - margin)
        .collect();
    for i in 1..=count {
        let t = lo + step * i as f64;
        if extra.iter().all(|&e| (e - t).abs() > 0.1 * step) {
            offsets.push(t);
        }
    }
    offsets.sort_by(f64::total_cmp);
    offsets.dedup();
    offsets
}

/// A first cut with what it costs.
struct First {
    direction: usize,
    trial: usize,
    below: f64,
    above: f64,
    value: f64,
}

/// A first cut looked at two steps deep.
struct Expanded {
    choice: Choice,
    /// Direction and offset of the best second cut.
    second: Option<(usize, f64)>,
    /// Lowest and highest offset refinement may move the first cut to.
    spacing: (f64, f64),
}

/// Search one piece.
pub struct Lookahead<'a> {
    question: &'a Question<'a>,
    value: Value,
}

thread_local! {
    /// Memory of the sweeps, one a thread.
    static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::default());
}

/// [`sweep`] with this thread's memory.
fn sweep_here(
    piece: &Piece,
    edges: &[(u32, u32)],
    basis: &Basis,
    offsets: &[f64],
    forbidden: &[Forbidden],
    slack: f64,
) -> Sweep {
    SCRATCH
        .with_borrow_mut(|scratch| sweep(piece, edges, basis, offsets, forbidden, slack, scratch))
}

impl<'a> Lookahead<'a> {
    /// Prepare.
    pub fn new(question: &'a Question<'a>) -> Self {
        let value = Value::new(question.settings, question.epsilon);
        Lookahead { question, value }
    }

    fn sweeps(
        &self,
        piece: &Piece,
        forbidden: &[Forbidden],
        count: usize,
        extra: &[Vec<f64>],
    ) -> Vec<Sweep> {
        let q = self.question;
        let edges: Vec<(u32, u32)> = piece.edges().collect();
        let extents: Vec<(f64, f64)> = q
            .directions
            .iter()
            .map(|b| extent(&piece.points, b.w))
            .collect();
        let thin = |(lo, hi): (f64, f64)| hi - lo < q.settings.thinnest * q.epsilon;
        let all_thin = extents.iter().all(|&e| thin(e));
        q.directions
            .iter()
            .enumerate()
            .map(|(d, basis)| {
                let (lo, hi) = extents[d];
                let number = if thin((lo, hi)) && !all_thin {
                    0
                } else {
                    count
                };
                let offsets = grid(lo, hi, number, &extra[d]);
                if offsets.is_empty() {
                    return Sweep::default();
                }
                sweep_here(
                    piece,
                    &edges,
                    basis,
                    &offsets,
                    forbidden,
                    q.settings.section * q.epsilon,
                )
            })
            .collect()
    }

    /// The best cut, or `None` if there is no candidate.
    pub fn choose(&self) -> Option<Choice> {
        let q = self.question;
        let sweeps = self.sweeps(q.piece, q.forbidden, q.settings.planes, q.extra);
        let mut firsts: Vec<First> = Vec::new();
        for (direction, sweep) in sweeps.iter().enumerate() {
            for (trial, t) in sweep.trials.iter().enumerate() {
                if empty(&t.below) || empty(&t.above) {
                    continue;
                }
                let (below, above) = (self.value.cost(&t.below), self.value.cost(&t.above));
                firsts.push(First {
                    direction,
                    trial,
                    below,
                    above,
                    value: self.value.join(below, above),
                });
            }
        }
        firsts.sort_by(|a, b| {
            a.value
                .total_cmp(&b.value)
                .then(a.direction.cmp(&b.direction))
                .then(a.trial.cmp(&b.trial))
        });
        let choice = |f: &First, value: f64| Choice {
            direction: f.direction,
            offset: sweeps[f.direction].trials[f.trial].offset,
            value,
        };
        if q.settings.policy == Policy::Greedy {
            let best = firsts.first()?;
            let spacing = spacing(&sweeps[best.direction], best.trial);
            return Some(self.refine(choice(best, best.value), None, spacing));
        }
        let expanded: Vec<Expanded> = promising(&firsts, q.settings.expand, q.settings.quota)
            .into_par_iter()
            .map(|first| {
                let below_is_worse = first.below >= first.above;
                let (child, forbidden) = child(q, &sweeps[first.direction], first, below_is_worse);
                let other = first.below.min(first.above);
                let second = self.second(&child, &forbidden, other);
                let (step, value) =
                    second.map_or((None, first.value), |(d, t, v)| (Some((d, t)), v));
                Expanded {
                    choice: choice(first, first.value + value),
                    second: step,
                    spacing: spacing(&sweeps[first.direction], first.trial),
                }
            })
            .collect();
        // The first of equals: the order is that of the first step.
        let best = expanded.into_iter().reduce(|a, b| {
            if b.choice.value < a.choice.value {
                b
            } else {
                a
            }
        });
        let best = best?;
        Some(self.refine(best.choice, best.second, best.spacing))
    }

    /// The best cut of a child: (direction, offset, value with the other part).
    fn second(
        &self,
        child: &Piece,
        forbidden: &[Forbidden],
        other: f64,
    ) -> Option<(usize, f64, f64)> {
        let count = self.question.settings.second;
        let sweeps = self.sweeps(child, forbidden, count, self.question.extra_second);
        let mut best: Option<(usize, f64, f64)> = None;
        for (direction, sweep) in sweeps.iter().enumerate() {
            for t in &sweep.trials {
                let parts = self
                    .value
                    .join(self.value.cost(&t.below), self.value.cost(&t.above));
                let value = self.value.join(other, parts);
                if best.is_none_or(|b| value < b.2) {
                    best = Some((direction, t.offset, value));
                }
            }
        }
        best
    }

    /// §6.5: move the first plane within its spacing while the second stays.
    fn refine(&self, choice: Choice, second: Option<(usize, f64)>, spacing: (f64, f64)) -> Choice {
        let q = self.question;
        let basis = &q.directions[choice.direction];
        // A plane on a flat face is exact already.
        if q.settings.refine == 0 || q.extra[choice.direction].contains(&choice.offset) {
            return choice;
        }
        let (from, to) = spacing;
        let count = q.settings.refine;
        let step = (to - from) / (count + 1) as f64;
        let offsets: Vec<f64> = (1..=count).map(|i| from + step * i as f64).collect();
        let edges: Vec<(u32, u32)> = q.piece.edges().collect();
        let slack = q.settings.section * q.epsilon;
        let result = sweep_here(q.piece, &edges, basis, &offsets, q.forbidden, slack);
        let mut best = choice;
        for (trial, t) in result.trials.iter().enumerate() {
            if empty(&t.below) || empty(&t.above) {
                continue;
            }
            let (below, above) = (self.value.cost(&t.below), self.value.cost(&t.above));
            let mut value = self.value.join(below, above);
            if let Some((direction, offset)) = second {
                if value > best.value {
                    continue;
                }
                let first = First {
                    direction: choice.direction,
                    trial,
                    below,
                    above,
                    value,
                };
                let (piece, forbidden) = child(q, &result, &first, below >= above);
                let edges: Vec<(u32, u32)> = piece.edges().collect();
                let basis = &q.directions[direction];
                let next = sweep_here(&piece, &edges, basis, &[offset], &forbidden, slack);
                let t = &next.trials[0];
                let parts = self
                    .value
                    .join(self.value.cost(&t.below), self.value.cost(&t.above));
                value += self.value.join(below.min(above), parts);
            }
            if value < best.value {
                best = Choice {
                    offset: t.offset,
                    value,
                    ..choice
                };
            }
        }
        best
    }
}

/// The first cuts to look at further: the best `quota` of each direction, then
/// the best of all. Directions often tie at the first step (a ring cut across
/// or along its axis), and only the second step tells them apart.
fn promising(sorted: &[First], expand: usize, quota: usize) -> Vec<&First> {
    let mut taken = vec![0usize; 1 + sorted.iter().map(|f| f.direction).max().unwrap_or(0)];
    let mut chosen = vec![false; sorted.len()];
    let mut count = 0;
    for (i, first) in sorted.iter().enumerate() {
        if taken[first.direction] < quota && count < expand {
            taken[first.direction] += 1;
            chosen[i] = true;
            count += 1;
        }
    }
    for slot in &mut chosen {
        if !*slot && count < expand {
            *slot = true;
            count += 1;
        }
    }
    sorted
        .iter()
        .zip(chosen)
        .filter(|(_, c)| *c)
        .map(|(f, _)| f)
        .collect()
}

fn empty(side: &Side) -> bool {
    side.hull <= 1e-15 || side.part <= 1e-15
}

/// The offsets on either side of a trial.
fn spacing(sweep: &Sweep, trial: usize) -> (f64, f64) {
    let at = |i: usize| sweep.trials[i].offset;
    let here = at(trial);
    let last = sweep.trials.len() - 1;
    let down = if trial > 0 {
        here - at(trial - 1)
    } else {
        f64::INFINITY
    };
    let up = if trial < last {
        at(trial + 1) - here
    } else {
        f64::INFINITY
    };
    let (down, up) = if down.is_finite() || up.is_finite() {
        (down.min(up), up.min(down))
    } else {
        (0.0, 0.0)
    };
    (here - down, here + up)
}

/// One side of a first cut, with the forbidden samples its hull holds.
fn child(
    q: &Question<'_>,
    sweep: &Sweep,
    first: &First,
    want_below: bool,
) -> (Piece, Vec<Forbidden>) {
    let plane = Plane {
        normal: q.directions[first.direction].w,
        offset: sweep.trials[first.trial].offset,
    };
    let (below, above) = q.piece.split(plane);
    let k = first.trial as u32;
    let held = |i: usize| {
        if want_below {
            sweep.enters_below[i] <= k
        } else {
            sweep.leaves_above[i] > k
        }
    };
    let forbidden = q
        .forbidden
        .iter()
        .enumerate()
        .filter(|(i, _)| held(*i))
        .map(|(_, f)| *f)
        .collect();
    (if want_below { below } else { above }, forbidden)
}

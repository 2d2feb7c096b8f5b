//! Two steps ahead: the best first cuts, each with its best second cut.

use rayon::prelude::*;

use super::policy::{Choice, Policy, Question};
use super::price::{choice, empty, finer, halves, price, price_all, spacing, Half};
use super::sweep::Sweep;
use super::value::Value;

/// The policy.
pub struct Lookahead;

impl Policy for Lookahead {
    fn choose(&self, question: &Question<'_>) -> Option<Choice> {
        Search {
            q: question,
            value: Value::new(question.settings, question.epsilon).of(question.piece),
        }
        .run()
    }
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

/// One search.
struct Search<'a> {
    q: &'a Question<'a>,
    value: Value,
}

impl Search<'_> {
    fn run(&self) -> Option<Choice> {
        let q = self.q;
        let sweeps = price_all(q, q.piece, q.forbidden, q.settings.planes, q.extra);
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
            let (v, w) = (self.value.even(a.value), self.value.even(b.value));
            v.total_cmp(&w)
                .then(a.direction.cmp(&b.direction))
                .then(a.trial.cmp(&b.trial))
        });
        // Single planes come on top, so that they take no place from the grid's.
        let expand = q.settings.expand + q.directions.len() - q.gridded;
        let expanded: Vec<Expanded> = promising(&firsts, expand, q.settings.quota)
            .into_par_iter()
            .map(|first| {
                let sweep = &sweeps[first.direction];
                let worse = self.worse(sweep, first);
                let second = self.second(&worse, first.below.min(first.above));
                let (step, value) =
                    second.map_or((None, first.value), |(d, t, v)| (Some((d, t)), v));
                let trial = &sweep.trials[first.trial];
                Expanded {
                    choice: choice(first.direction, trial, first.value + value),
                    second: step,
                    spacing: spacing(sweep, first.trial),
                }
            })
            .collect();
        // The first of equals: the order is that of the first step.
        let best = expanded.into_iter().reduce(|a, b| {
            if self.value.even(b.choice.value) < self.value.even(a.choice.value) {
                b
            } else {
                a
            }
        })?;
        Some(self.refine(&best))
    }

    /// The worse side of a first cut.
    fn worse(&self, sweep: &Sweep, first: &First) -> Half {
        let basis = &self.q.directions[first.direction];
        let (below, above) = halves(self.q.piece, self.q.forbidden, basis, sweep, first.trial);
        // The lower of equals.
        if self.value.even(first.below) >= self.value.even(first.above) {
            below
        } else {
            above
        }
    }

    /// The best cut of a half: (direction, offset, value with the other half).
    fn second(&self, half: &Half, other: f64) -> Option<(usize, f64, f64)> {
        let q = self.q;
        let sweeps = price_all(
            q,
            &half.piece,
            &half.forbidden,
            q.settings.second,
            q.extra_second,
        );
        let mut best: Option<(usize, f64, f64)> = None;
        for (direction, sweep) in sweeps.iter().enumerate() {
            for t in &sweep.trials {
                let parts = self
                    .value
                    .join(self.value.cost(&t.below), self.value.cost(&t.above));
                let value = self.value.join(other, parts);
                if best.is_none_or(|b| self.value.even(value) < self.value.even(b.2)) {
                    best = Some((direction, t.offset, value));
                }
            }
        }
        best
    }

    /// §6.5: move the first plane within its spacing while the second stays.
    fn refine(&self, found: &Expanded) -> Choice {
        let q = self.q;
        let direction = found.choice.direction;
        let offsets = finer(q, &found.choice, found.spacing);
        if offsets.is_empty() {
            return found.choice;
        }
        let edges: Vec<(u32, u32)> = q.piece.edges().collect();
        let basis = &q.directions[direction];
        let result = price(q, q.piece, &edges, basis, &offsets, q.forbidden);
        let mut best = found.choice;
        for (trial, t) in result.trials.iter().enumerate() {
            if empty(&t.below) || empty(&t.above) {
                continue;
            }
            let (below, above) = (self.value.cost(&t.below), self.value.cost(&t.above));
            let mut value = self.value.join(below, above);
            if let Some((second, offset)) = found.second {
                if value > best.value {
                    continue;
                }
                let first = First {
                    direction,
                    trial,
                    below,
                    above,
                    value,
                };
                let half = self.worse(&result, &first);
                let edges: Vec<(u32, u32)> = half.piece.edges().collect();
                let basis = &q.directions[second];
                let next = price(q, &half.piece, &edges, basis, &[offset], &half.forbidden);
                let t = &next.trials[0];
                let parts = self
                    .value
                    .join(self.value.cost(&t.below), self.value.cost(&t.above));
                value += self.value.join(below.min(above), parts);
            }
            if self.value.even(value) < self.value.even(best.value) {
                best = choice(direction, t, value);
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

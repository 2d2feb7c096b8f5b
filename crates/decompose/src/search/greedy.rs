//! One step ahead: the cut with the best value by itself (Eq. 7 of Wei et al. 2022 with
//! `norm=worst`).

use super::policy::{Choice, Policy, Question};
use super::price::{choice, empty, finer, price, price_all, spacing};
use super::value::Value;
use crate::even;

/// What comes first: the least value, of equals the cut through the middle of the volume.
fn rank(choice: &Choice, value: &Value) -> (f64, f64) {
    let uneven = (choice.below.part - choice.above.part).abs();
    (value.even(choice.value), even::weight(uneven))
}

/// The first of the best.
fn best<T>(found: impl Iterator<Item = T>, rank: impl Fn(&T) -> (f64, f64)) -> Option<T> {
    found
        .map(|one| (rank(&one), one))
        .reduce(|a, b| if b.0 < a.0 { b } else { a })
        .map(|ranked| ranked.1)
}

/// The policy.
pub struct Greedy;

impl Policy for Greedy {
    fn choose(&self, q: &Question<'_>) -> Option<Choice> {
        let value = Value::new(q.settings, q.epsilon).of(q.piece);
        let sweeps = price_all(q, q.piece, q.forbidden, q.settings.planes, q.extra);
        let mut found: Vec<(Choice, (f64, f64))> = Vec::new();
        for (direction, sweep) in sweeps.iter().enumerate() {
            for (trial, t) in sweep.trials.iter().enumerate() {
                if empty(&t.below) || empty(&t.above) {
                    continue;
                }
                let v = value.join(value.cost(&t.below), value.cost(&t.above));
                found.push((choice(direction, t, v), spacing(sweep, trial)));
            }
        }
        let (chosen, spacing) = best(found.into_iter(), |f| rank(&f.0, &value))?;
        let edges: Vec<(u32, u32)> = q.piece.edges().collect();
        let offsets = finer(q, &chosen, spacing);
        let basis = &q.directions[chosen.direction];
        // The plane itself is the first of equals.
        let mut found = vec![chosen];
        for t in &price(q, q.piece, &edges, basis, &offsets, q.forbidden).trials {
            if !empty(&t.below) && !empty(&t.above) {
                let v = value.join(value.cost(&t.below), value.cost(&t.above));
                found.push(choice(chosen.direction, t, v));
            }
        }
        best(found.into_iter(), |c| rank(c, &value))
    }
}

//! One step ahead: the cut with the best value by itself (Eq. 7 of Wei et al. 2022 with
//! `norm=worst`).

use super::policy::{Choice, Policy, Question};
use super::price::{choice, empty, finer, price, price_all, spacing};
use super::value::Value;

/// The policy.
pub struct Greedy;

impl Policy for Greedy {
    fn choose(&self, q: &Question<'_>) -> Option<Choice> {
        let value = Value::new(q.settings, q.epsilon);
        let sweeps = price_all(q, q.piece, q.forbidden, q.settings.planes, q.extra);
        let mut best: Option<(Choice, (f64, f64))> = None;
        for (direction, sweep) in sweeps.iter().enumerate() {
            for (trial, t) in sweep.trials.iter().enumerate() {
                if empty(&t.below) || empty(&t.above) {
                    continue;
                }
                let v = value.join(value.cost(&t.below), value.cost(&t.above));
                if best.as_ref().is_none_or(|b| v < b.0.value) {
                    best = Some((choice(direction, t, v), spacing(sweep, trial)));
                }
            }
        }
        let (mut best, spacing) = best?;
        let edges: Vec<(u32, u32)> = q.piece.edges().collect();
        let offsets = finer(q, &best, spacing);
        let basis = &q.directions[best.direction];
        for t in &price(q, q.piece, &edges, basis, &offsets, q.forbidden).trials {
            let v = value.join(value.cost(&t.below), value.cost(&t.above));
            if !empty(&t.below) && !empty(&t.above) && v < best.value {
                best = choice(best.direction, t, v);
            }
        }
        Some(best)
    }
}

//! What a cut is worth.

use super::sweep::Side;
use crate::settings::{Norm, SearchSettings};

/// Puts the parts of a trial together to one number; smaller is better.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    norm: Norm,
    excess: f64,
    undone: f64,
    /// 1/ε³.
    unit: f64,
}

impl Value {
    /// For a tolerance.
    pub fn new(settings: &SearchSettings, epsilon: f64) -> Self {
        Value {
            norm: settings.norm,
            excess: settings.excess,
            undone: settings.undone,
            unit: 1.0 / (epsilon * epsilon * epsilon),
        }
    }

    /// Like [`Value::new`], but every cost is a radius and several count as the worst: what
    /// Eq. 8 and Eq. 9 are written for.
    pub fn radius(settings: &SearchSettings, epsilon: f64) -> Self {
        Value {
            norm: Norm::Worst,
            ..Value::new(settings, epsilon)
        }
    }

    /// The cost of one part: a radius as in Eq. 5 for `Norm::Worst`.
    pub fn cost(&self, side: &Side) -> f64 {
        let volume = (side.forbidden + self.excess * (side.hull - side.part).max(0.0)) * self.unit;
        let undone = if side.forbidden > 0.0 {
            self.undone
        } else {
            0.0
        };
        undone
            + match self.norm {
                Norm::Worst => libm::cbrt(volume * (0.75 / std::f64::consts::PI)),
                Norm::Sum(power) => libm::pow(volume, power),
            }
    }

    /// The cost of several parts.
    pub fn join(&self, a: f64, b: f64) -> f64 {
        match self.norm {
            Norm::Worst => a.max(b),
            Norm::Sum(_) => a + b,
        }
    }
}

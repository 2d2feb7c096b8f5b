//! What a cut is worth.

use glam::Vec3Swizzles;

use super::piece::Piece;
use super::sweep::Side;
use crate::even;
use crate::settings::{Norm, SearchSettings};

/// Volumes are compared in steps of so much times a part's surface: ten times what jitter does.
const GRAIN: f64 = 1e-6;

/// Puts the parts of a trial together to one number; smaller is better.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    norm: Norm,
    excess: f64,
    undone: f64,
    /// 1/ε³.
    unit: f64,
    /// Steps in which volumes are compared.
    grain: f64,
}

impl Value {
    /// For a tolerance.
    pub fn new(settings: &SearchSettings, epsilon: f64) -> Self {
        Value {
            norm: settings.norm,
            excess: settings.excess,
            undone: settings.undone,
            unit: 1.0 / (epsilon * epsilon * epsilon),
            grain: GRAIN,
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

    /// The same for cuts of a piece.
    #[must_use]
    pub fn of(self, piece: &Piece) -> Self {
        let (lo, hi) = piece.bounds();
        let size = hi - lo;
        let surface = 2.0 * size.dot(size.zxy());
        Value {
            grain: even::weight(GRAIN * self.excess * surface).max(f64::MIN_POSITIVE),
            ..self
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

    /// A value as it is compared with others: on a lattice, so that what jitter and rounding make
    /// of equal cuts are equals.
    pub fn even(&self, value: f64) -> f64 {
        let volume = match self.norm {
            Norm::Worst => value.max(0.0).powi(3),
            Norm::Sum(power) => libm::pow(value.max(0.0), 1.0 / power),
        };
        libm::round(volume / (self.unit * self.grain))
    }

    /// The cost of several parts.
    pub fn join(&self, a: f64, b: f64) -> f64 {
        match self.norm {
            Norm::Worst => a.max(b),
            Norm::Sum(_) => a + b,
        }
    }
}

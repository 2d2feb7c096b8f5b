//! Answers to "is it at most ε?".

use assetpipe_geometry::DVec3;

use super::Interval;

/// The answer to "is the distance at most ε?".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// Proved: the interval's upper bound is at most ε.
    Within(Interval),
    /// Refuted: the distance at `witness` is at least `lower` > ε.
    Beyond {
        /// The point.
        witness: DVec3,
        /// A lower bound of its distance.
        lower: f64,
    },
    /// Neither within the limits: what is known. Not to be accepted.
    Unproven(Interval),
}

impl Decision {
    pub(super) fn from(epsilon: f64, known: Interval, witness: Option<(DVec3, f64)>) -> Decision {
        match witness {
            Some((witness, lower)) if lower > epsilon => Decision::Beyond { witness, lower },
            _ if known.upper <= epsilon => Decision::Within(known),
            _ => Decision::Unproven(known),
        }
    }

    /// Whether the bound is proved.
    pub fn is_within(&self) -> bool {
        matches!(self, Decision::Within(_))
    }

    /// What is known of the true value; the upper end is infinite after a
    /// refutation.
    pub fn interval(&self) -> Interval {
        match *self {
            Decision::Within(interval) | Decision::Unproven(interval) => interval,
            Decision::Beyond { lower, .. } => Interval {
                lower,
                upper: f64::INFINITY,
            },
        }
    }
}

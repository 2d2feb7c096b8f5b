//! What a branch and bound is for.

use super::Gap;

/// Bounds below this multiple of the rounding allowance are as good as zero.
const NOTHING: f64 = 10.0;
/// A decision is not worth more work once the value is known to be this close
/// to ε, as a share.
const CLOSE: f64 = 1e-3;

/// What the search is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// Find out whether the value is above ε.
    Decide {
        /// ε.
        epsilon: f64,
    },
    /// Close the interval to this gap.
    Measure {
        /// How wide it may be.
        gap: Gap,
    },
}

impl Goal {
    /// Bounds up to this value need no more work, `lower` being known and
    /// `slack` being added to every upper bound in the end.
    pub(super) fn target(&self, lower: f64, slack: f64) -> f64 {
        match self {
            Goal::Decide { epsilon } => epsilon - slack,
            Goal::Measure { gap } => (gap.upper(lower) - slack).max(NOTHING * slack),
        }
    }

    /// Whether `lower` alone ends the search: ε is exceeded or as good as reached.
    pub(super) fn is_settled(&self, lower: f64) -> bool {
        match self {
            Goal::Decide { epsilon } => lower > (1.0 - CLOSE) * epsilon,
            Goal::Measure { .. } => false,
        }
    }
}

//! Progress out, cancellation in.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::DecomposeError;

/// Share of the work that is done when all parts are proved, when they are merged, and when the
/// hulls are finished: about what they take of the time.
pub(crate) const CUT: f64 = 0.4;
pub(crate) const MERGED: f64 = 0.55;
pub(crate) const FINISHED: f64 = 0.95;

/// Shared between a computation and whoever watches it.
#[derive(Debug, Default)]
pub struct Control {
    cancelled: AtomicBool,
    /// Share done, as bits of an `f64`.
    done: AtomicU64,
}

impl Control {
    /// Ask the computation to stop.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Go on unless it was asked to stop.
    ///
    /// # Errors
    /// [`DecomposeError::Cancelled`].
    pub(crate) fn go_on(&self) -> Result<(), DecomposeError> {
        if self.is_cancelled() {
            return Err(DecomposeError::Cancelled);
        }
        Ok(())
    }

    /// Share done so far, 0 to 1.
    pub fn progress(&self) -> f64 {
        f64::from_bits(self.done.load(Ordering::Relaxed))
    }

    pub(crate) fn report(&self, share: f64) {
        // Several searches may report; the share never goes back. Bits of
        // positive numbers are ordered as the numbers are.
        self.done
            .fetch_max(share.clamp(0.0, 1.0).to_bits(), Ordering::Relaxed);
    }
}

//! Acceptance by proof.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::Mesh;

use crate::close::close;
use crate::concavity::{thickening, wei, Decision, Gap, Interval, Limits};
use crate::error::DecomposeError;
use crate::search::piece::Piece;
use crate::settings::Metric;

/// Decides whether a hull may stand for pieces of the solid.
#[derive(Clone, Copy)]
pub struct Judge<'a> {
    /// The whole solid.
    pub solid: &'a SolidIndex,
    /// What is held below the tolerance.
    pub metric: Metric,
    /// The tolerance, working length.
    pub epsilon: f64,
    /// Limits of each proof.
    pub limits: &'a Limits<'a>,
}

impl Judge<'_> {
    /// Go on unless the work was asked to stop.
    ///
    /// # Errors
    /// [`DecomposeError::Cancelled`].
    pub fn go_on(&self) -> Result<(), DecomposeError> {
        if (self.limits.cancelled)() {
            return Err(DecomposeError::Cancelled);
        }
        Ok(())
    }

    /// `Within` holds the thickening towards the whole solid, which is never
    /// above the concavity towards the part.
    pub fn decide(&self, hull: &Mesh, pieces: &[&Piece]) -> Decision {
        let thick = thickening::decide(self.solid, hull, self.epsilon, self.limits);
        if self.metric == Metric::Thickening || !thick.is_within() {
            return thick;
        }
        let part = SolidIndex::new(&close(pieces));
        match wei::decide(&part, hull, self.epsilon, self.limits) {
            Decision::Within(_) => thick,
            other => other,
        }
    }

    /// Eq. 4 of a hull towards its part; at least `known`, a lower bound of the
    /// hull's thickening.
    pub fn concavity(
        &self,
        hull: &Mesh,
        pieces: &[&Piece],
        known: f64,
        gap: Gap,
        limits: &Limits<'_>,
    ) -> Interval {
        let part = SolidIndex::new(&close(pieces));
        wei::value_above(&part, hull, known, gap, limits)
    }
}

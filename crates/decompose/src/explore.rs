//! Several ways to cut a part, each followed to its end.
//!
//! Policies disagree most where it matters most, at the first cuts, and which of them was right
//! is known when the parts are hulls. So the first generations of cuts are tried in several
//! ways, and each part keeps the way that ends with the fewest hulls. Halves are independent:
//! two ways at three generations choose from far more than eight trees, at the price of eight.

use std::sync::Mutex;

use assetpipe_geometry::Plane;
use rayon::prelude::*;

use crate::control::{Control, CUT};
use crate::engine::{finish, run, Cover};
use crate::error::DecomposeError;
use crate::even;
use crate::judge::Judge;
use crate::merge::volume;
use crate::settings::SearchSettings;
use crate::step::{step, Open, Step};

/// Planes closer than this share of ε are the same way to cut.
const SAME: f64 = 0.25;

/// Follows the ways of a solid's parts.
pub struct Explorer<'a> {
    judge: &'a Judge<'a>,
    settings: &'a SearchSettings,
    control: &'a Control,
    /// Share of all ways that were followed to their end.
    followed: Mutex<f64>,
}

impl<'a> Explorer<'a> {
    /// Nothing followed yet.
    pub fn new(judge: &'a Judge<'a>, settings: &'a SearchSettings, control: &'a Control) -> Self {
        Explorer {
            judge,
            settings,
            control,
            followed: Mutex::new(0.0),
        }
    }

    /// The best cover of a part, `generation` cuts after its component. `share` of all work
    /// is behind it.
    ///
    /// # Errors
    /// [`DecomposeError`].
    pub fn cover(
        &self,
        open: Open,
        generation: usize,
        share: f64,
    ) -> Result<Cover, DecomposeError> {
        let ways = self.settings.ways.get(generation).copied().unwrap_or(1);
        if ways <= 1 {
            let found = run(self.judge, vec![open], self.settings, &|_| {})?;
            self.report(share);
            return finish(self.judge, found, self.settings);
        }
        let steps: Vec<Step> = (0..ways)
            .into_par_iter()
            .map(|k| step(self.judge, open.clone(), &self.settings.way(k)))
            .collect::<Result<_, _>>()?;
        let mut cuts: Vec<(Plane, Step)> = Vec::new();
        for step in steps {
            let Step::Cut { plane, .. } = step else {
                self.report(share);
                return Ok(Cover::of(step));
            };
            let known = |c: &(Plane, Step)| {
                c.0.normal == plane.normal
                    && (c.0.offset - plane.offset).abs() < SAME * self.judge.epsilon
            };
            if !cuts.iter().any(known) {
                cuts.push((plane, step));
            }
        }
        let share = share / cuts.len() as f64;
        let covers: Vec<Cover> = cuts
            .into_par_iter()
            .map(|(_, step)| self.follow(step, generation, share))
            .collect::<Result<_, _>>()?;
        fewest(covers)
    }

    /// The best cover after a step.
    fn follow(
        &self,
        mut step: Step,
        generation: usize,
        share: f64,
    ) -> Result<Cover, DecomposeError> {
        let children = match &mut step {
            Step::Cut { children, .. } => std::mem::take(children),
            Step::Done { .. } => Vec::new(),
        };
        let volume: f64 = children.iter().map(|c| c.0.piece.volume()).sum();
        let found: Vec<Cover> = children
            .into_par_iter()
            .map(|child| {
                let share = share * (child.0.piece.volume() / volume);
                self.cover(child, generation + 1, share)
            })
            .collect::<Result<_, _>>()?;
        let mut cover = Cover::of(step);
        for more in found {
            cover.add(more);
        }
        finish(self.judge, cover, self.settings)
    }

    fn report(&self, share: f64) {
        if let Ok(mut followed) = self.followed.lock() {
            *followed += share;
            self.control.report(CUT * *followed);
        }
    }
}

/// The cover with the fewest hulls, of these the tightest.
///
/// # Errors
/// If there is none.
pub fn fewest(covers: Vec<Cover>) -> Result<Cover, DecomposeError> {
    let size = |cover: &Cover| {
        let volumes = cover.hulls.iter().map(|h| volume(&h.hull));
        even::weight(volumes.sum::<f64>())
    };
    covers
        .into_iter()
        .map(|cover| (cover.hulls.len(), size(&cover), cover))
        .reduce(|a, b| if (b.0, b.1) < (a.0, a.1) { b } else { a })
        .map(|best| best.2)
        .ok_or_else(|| DecomposeError::Internal("no cover was made".into()))
}

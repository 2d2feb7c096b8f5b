//! Pricing candidate cuts of a piece in all directions: what every policy does first.

use std::cell::RefCell;

use assetpipe_geometry::Plane;
use glam::DVec3;
use rayon::prelude::*;

use super::piece::Piece;
use super::policy::{Choice, Question};
use super::sweep::{sweep, Basis, Forbidden, Scratch, Side, Sweep, Trial};

/// Extent of points along a direction.
pub fn extent(points: &[DVec3], w: DVec3) -> (f64, f64) {
    points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
            let z = w.dot(*p);
            (lo.min(z), hi.max(z))
        })
}

/// `count` inner points of an interval, with `extra` ones sorted in.
fn grid(lo: f64, hi: f64, count: usize, extra: &[f64]) -> Vec<f64> {
    let step = (hi - lo) / (count + 1) as f64;
    let margin = (hi - lo) * 1e-4;
    let mut offsets: Vec<f64> = extra
        .iter()
        .copied()
        .filter(|&t| t > lo + margin && t < hi - margin)
        .collect();
    for i in 1..=count {
        let t = lo + step * i as f64;
        if extra.iter().all(|&e| (e - t).abs() > 0.1 * step) {
            offsets.push(t);
        }
    }
    offsets.sort_by(f64::total_cmp);
    offsets.dedup();
    offsets
}

thread_local! {
    /// Memory of the sweeps, one a thread.
    static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::default());
}

/// [`sweep`] with this thread's memory.
pub fn price(
    q: &Question<'_>,
    piece: &Piece,
    edges: &[(u32, u32)],
    basis: &Basis,
    offsets: &[f64],
    forbidden: &[Forbidden],
) -> Sweep {
    let slack = q.settings.section * q.epsilon;
    SCRATCH
        .with_borrow_mut(|scratch| sweep(piece, edges, basis, offsets, forbidden, slack, scratch))
}

/// Price a grid of `count` planes and the `extra` offsets in every direction; extents that
/// are thin against ε get no grid unless all are.
pub fn price_all(
    q: &Question<'_>,
    piece: &Piece,
    forbidden: &[Forbidden],
    count: usize,
    extra: &[Vec<f64>],
) -> Vec<Sweep> {
    let edges: Vec<(u32, u32)> = piece.edges().collect();
    let extents: Vec<(f64, f64)> = q
        .directions
        .iter()
        .map(|b| extent(&piece.points, b.w))
        .collect();
    let thin = |(lo, hi): (f64, f64)| hi - lo < q.settings.thinnest * q.epsilon;
    let all_thin = extents[..q.gridded].iter().all(|&e| thin(e));
    q.directions
        .par_iter()
        .enumerate()
        .map(|(d, basis)| {
            let (lo, hi) = extents[d];
            let none = d >= q.gridded || (thin((lo, hi)) && !all_thin);
            let offsets = grid(lo, hi, if none { 0 } else { count }, &extra[d]);
            if offsets.is_empty() {
                return Sweep::default();
            }
            price(q, piece, &edges, basis, &offsets, forbidden)
        })
        .collect()
}

/// Whether there is nothing on one side.
pub fn empty(side: &Side) -> bool {
    side.hull <= 1e-15 || side.part <= 1e-15
}

/// A trial as a choice.
pub fn choice(direction: usize, trial: &Trial, value: f64) -> Choice {
    Choice {
        direction,
        offset: trial.offset,
        value,
        below: trial.below,
        above: trial.above,
    }
}

/// The offsets within which a trial may be moved.
pub fn spacing(sweep: &Sweep, trial: usize) -> (f64, f64) {
    let at = |i: usize| sweep.trials[i].offset;
    let here = at(trial);
    let last = sweep.trials.len() - 1;
    let down = if trial > 0 {
        here - at(trial - 1)
    } else {
        f64::INFINITY
    };
    let up = if trial < last {
        at(trial + 1) - here
    } else {
        f64::INFINITY
    };
    let (down, up) = if down.is_finite() || up.is_finite() {
        (down.min(up), up.min(down))
    } else {
        (0.0, 0.0)
    };
    (here - down, here + up)
}

/// Offsets at which refinement (§6.5) tries a chosen plane; none for a plane on a flat face,
/// which is exact already.
pub fn finer(q: &Question<'_>, choice: &Choice, (from, to): (f64, f64)) -> Vec<f64> {
    if q.extra[choice.direction].contains(&choice.offset) {
        return Vec::new();
    }
    let count = q.settings.refine;
    let step = (to - from) / (count + 1) as f64;
    (1..=count).map(|i| from + step * i as f64).collect()
}

/// A piece with the forbidden samples in its hull.
pub struct Half {
    /// The piece.
    pub piece: Piece,
    /// The samples.
    pub forbidden: Vec<Forbidden>,
}

/// Both sides of a trial, (below, above).
pub fn halves(
    piece: &Piece,
    forbidden: &[Forbidden],
    basis: &Basis,
    sweep: &Sweep,
    trial: usize,
) -> (Half, Half) {
    let (below, above) = piece.split(Plane {
        normal: basis.w,
        offset: sweep.trials[trial].offset,
    });
    let k = trial as u32;
    let held = |inside: &dyn Fn(usize) -> bool| -> Vec<Forbidden> {
        forbidden
            .iter()
            .enumerate()
            .filter(|(i, _)| inside(*i))
            .map(|(_, f)| *f)
            .collect()
    };
    (
        Half {
            piece: below,
            forbidden: held(&|i| sweep.enters_below[i] <= k),
        },
        Half {
            piece: above,
            forbidden: held(&|i| sweep.leaves_above[i] > k),
        },
    )
}

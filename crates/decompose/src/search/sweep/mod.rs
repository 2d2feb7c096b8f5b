//! Pricing all parallel cuts of one direction in one forward and one backward
//! pass, without making any of them.
//!
//! For a plane at height t the volume below follows from the divergence
//! theorem with the field (0, 0, z − t): it vanishes on the cut itself, so no
//! cap is needed, and over a triangle the integral is a cubic in t. The hulls
//! grow point by point along the direction (`hull`); what crosses a
//! plane enters as the convex hull of the section. Points of the section lie
//! inside the hull of every later plane, so they are inserted for good.

mod basis;
mod hull;
mod jitter;
mod section;
#[cfg(test)]
mod tests;
mod trial;
mod volume;

use glam::{DVec2, DVec3};

pub use self::basis::Basis;
use self::hull::SweepHull;
use self::jitter::jittered;
use self::section::sections;
pub use self::trial::{Forbidden, Side, Sweep, Trial};
use self::volume::volumes_below;
use super::piece::Piece;
use crate::even;

/// Memory reused between sweeps.
#[derive(Default)]
pub struct Scratch {
    hull: SweepHull,
    local: Vec<DVec3>,
    samples: Vec<DVec3>,
    low: Vec<f64>,
    high: Vec<f64>,
    order: Vec<u32>,
    sections: Vec<Vec<DVec2>>,
    outline: Vec<DVec2>,
    inserted: Vec<bool>,
    witness: Vec<u32>,
}

/// Vertices this close to a plane count as on it: stand-ins of a flat face are
/// flat to rounding only.
const ON: f64 = 1e-6;

/// Price cuts at `offsets` (increasing) along `basis.w`.
///
/// `slack` is the distance by which section outlines may be simplified.
pub fn sweep(
    piece: &Piece,
    edges: &[(u32, u32)],
    basis: &Basis,
    offsets: &[f64],
    forbidden: &[Forbidden],
    slack: f64,
    scratch: &mut Scratch,
) -> Sweep {
    let count = offsets.len();
    scratch.local.clear();
    scratch
        .local
        .extend(piece.points.iter().map(|&p| even::point(basis.local(p))));
    scratch.samples.clear();
    scratch
        .samples
        .extend(forbidden.iter().map(|f| even::point(basis.local(f.point))));
    let exact = offsets;
    let offsets: &[f64] = &exact.iter().map(|&t| even::length(t)).collect::<Vec<f64>>();
    let volumes = volumes_below(piece, &scratch.local, offsets);
    let total = volumes[count];
    sections(edges, offsets, slack, scratch);

    let mut result = Sweep {
        trials: exact
            .iter()
            .zip(&volumes)
            .map(|(&offset, &part)| Trial {
                offset,
                below: Side {
                    part,
                    ..Side::default()
                },
                above: Side {
                    part: total - part,
                    ..Side::default()
                },
            })
            .collect(),
        enters_below: vec![count as u32; forbidden.len()],
        leaves_above: vec![0; forbidden.len()],
    };
    pass(offsets, forbidden, scratch, &mut result, false);
    pass(offsets, forbidden, scratch, &mut result, true);
    result
}

/// One pass over all planes: from below, or mirrored from above.
fn pass(
    offsets: &[f64],
    forbidden: &[Forbidden],
    scratch: &mut Scratch,
    result: &mut Sweep,
    mirrored: bool,
) {
    let Scratch {
        hull,
        local,
        samples,
        low,
        high,
        order,
        sections,
        inserted,
        witness,
        ..
    } = scratch;
    let sign = if mirrored { -1.0 } else { 1.0 };
    // The mirror image of the hull has the same volume: both passes go upwards.
    let flip = |p: DVec3| DVec3::new(p.x, p.y, sign * p.z);
    hull.clear();
    inserted.clear();
    inserted.resize(local.len(), false);
    witness.clear();
    witness.resize(forbidden.len(), u32::MAX);
    let reach = |v: u32| {
        if mirrored {
            -high[v as usize]
        } else {
            low[v as usize]
        }
    };
    let position = |rank: usize| {
        if mirrored {
            order.len() - 1 - rank
        } else {
            rank
        }
    };

    let mut next = 0;
    let mut held = 0.0;
    for step in 0..offsets.len() {
        let k = if mirrored {
            offsets.len() - 1 - step
        } else {
            step
        };
        let t = sign * offsets[k];
        let mut ahead = next;
        while ahead < order.len() {
            let v = order[position(ahead)];
            let z = sign * local[v as usize].z;
            if z > t + ON {
                break;
            }
            // A vertex on the plane belongs to this side only if something of
            // this side hangs on it; a flat face seen from outside does not.
            let belongs = z < t - ON || reach(v) < t - ON;
            if belongs && !inserted[v as usize] {
                inserted[v as usize] = true;
                hull.insert(flip(jittered(local[v as usize])));
            }
            ahead += 1;
            if z < t - ON {
                next = ahead;
            }
        }
        for p in &sections[k] {
            hull.insert(flip(jittered(p.extend(offsets[k]))));
        }
        for (i, sample) in forbidden.iter().enumerate() {
            let known = if mirrored {
                result.leaves_above[i] != 0
            } else {
                (result.enters_below[i] as usize) < offsets.len()
            };
            if known || sign * samples[i].z > t + ON {
                continue;
            }
            if hull.contains(flip(samples[i]), sample.depth, &mut witness[i]) {
                held += sample.weight;
                if mirrored {
                    result.leaves_above[i] = k as u32 + 1;
                } else {
                    result.enters_below[i] = k as u32;
                }
            }
        }
        let trial = &mut result.trials[k];
        let side = if mirrored {
            &mut trial.above
        } else {
            &mut trial.below
        };
        side.hull = hull.volume();
        side.forbidden = held;
    }
}

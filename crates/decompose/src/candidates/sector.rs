//! Planes through an axis: how rings, tubes, bores and arcs want to be cut.
//!
//! Where a hollow wall goes through a part from end to end, the forbidden space is what the wall
//! encloses, and no cut across the wall changes the number of pieces along it. The fewest are
//! stretches of equal sagitta (see [`chain`](super::chain)); every first cut or two of a search
//! looks as good as another, so the division is foreseen from the section instead: the plane
//! leaves as few stretches as possible on both sides together, and halves them.

use glam::{DVec2, DVec3};

use super::chain::Chain;
use super::section::outlines;
use crate::search::piece::Piece;
use crate::search::sweep::{Basis, Forbidden};
use assetpipe_geometry::Plane;

/// Heights of the sections, as shares of the part's extent.
const HEIGHTS: [f64; 5] = [0.5, 0.1, 0.9, 0.3, 0.7];
/// Share of the tolerance that a stretch may use: the rest is the proof's.
const USED: f64 = 0.995;
/// The wall must enclose this share of the part's forbidden space.
const SHARE: f64 = 0.8;
/// Most stretches of a chain.
const MOST: usize = 64;

/// The plane along `basis.w` that divides the wall, and the share of forbidden space that it
/// encloses; `None` if no wall explains the part.
pub fn plane(
    piece: &Piece,
    basis: &Basis,
    (lo, hi): (f64, f64),
    forbidden: &[Forbidden],
    epsilon: f64,
) -> Option<(Plane, f64)> {
    let tolerance = USED * epsilon;
    let mut walls: Vec<(f64, Chain, Vec<f64>)> = Vec::with_capacity(HEIGHTS.len());
    for share in HEIGHTS {
        let height = lo + share * (hi - lo);
        let chain = outlines(piece, basis, height)
            .iter()
            .flat_map(Chain::of)
            .max_by(|a, b| a.hollow().total_cmp(&b.hollow()))?;
        let stretches = chain.stretches(tolerance, MOST)?;
        if stretches.len() < 3 {
            return None;
        }
        walls.push((height, chain, stretches));
    }
    let (mut held, mut all) = (0.0, 0.0);
    for sample in forbidden {
        all += sample.weight;
        let p = DVec2::new(basis.u.dot(sample.point), basis.v.dot(sample.point));
        let h = basis.w.dot(sample.point);
        let nearest = walls
            .iter()
            .min_by(|a, b| (a.0 - h).abs().total_cmp(&(b.0 - h).abs()))?;
        if nearest.1.holds(p) {
            held += sample.weight;
        }
    }
    if held < SHARE * all || all == 0.0 {
        return None;
    }
    let (_, chain, stretches) = walls.into_iter().rev().max_by_key(|wall| wall.2.len())?;
    let (normal, offset) = divide(&chain, &stretches, tolerance)?;
    let normal: DVec3 = basis.u * normal.x + basis.v * normal.y;
    Some((Plane { normal, offset }, held / all))
}

/// The best line through two ends of stretches, or across the chain at one of them.
fn divide(chain: &Chain, ends: &[f64], tolerance: f64) -> Option<(DVec2, f64)> {
    let point = |i: usize| chain.at(ends[i]);
    let last = ends.len() - 1;
    let closed = point(0).distance(point(last)) < 1e-9;
    let mut lines: Vec<(DVec2, DVec2)> = Vec::new();
    for i in 1..last {
        lines.push((point(i + 1) - point(i - 1), point(i)));
    }
    for i in 0..last + usize::from(!closed) {
        for j in i + 1..last + usize::from(!closed) {
            lines.push((-(point(j) - point(i)).perp(), point(i)));
        }
    }
    let mut best: Option<((usize, usize), DVec2, f64)> = None;
    for (across, through) in lines {
        let normal = across.normalize_or_zero();
        let offset = normal.dot(through);
        // What rounding moves the ends by must not cost a stretch.
        let Some(count) = chain.remaining(normal, offset, tolerance * 1.002) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| count < b.0) {
            best = Some((count, normal, offset));
        }
    }
    best.map(|(_, normal, offset)| (normal, offset))
}

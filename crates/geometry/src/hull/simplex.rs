//! Four points that span space, or the proof that there are none.

use glam::DVec3;

use super::HullError;
use crate::predicates::{collinear, orient3d};

/// Indices of four affinely independent points, spread far apart, with the
/// fourth strictly below the triangle of the first three.
pub(super) fn spanning(points: &[DVec3]) -> Result<[usize; 4], HullError> {
    let (a, b) = farthest_pair(points)?;
    let along = points[b] - points[a];
    let degenerate = |witness: Vec<usize>| HullError::Degenerate {
        dimension: witness.len() - 1,
        witness,
    };
    let c = farthest(points, |p| along.cross(p - points[a]).length_squared())
        .filter(|&c| !collinear(points[a], points[b], points[c]))
        // Rounding or overflow hid the direction: look for any that is exact.
        .or_else(|| {
            points
                .iter()
                .position(|&p| !collinear(points[a], points[b], p))
        })
        .ok_or_else(|| degenerate(vec![a, b]))?;
    let normal = along.cross(points[c] - points[a]);
    let side = |p: DVec3| orient3d(points[a], points[b], points[c], p);
    let d = farthest(points, |p| normal.dot(p - points[a]).abs())
        .filter(|&d| side(points[d]).is_ne())
        .or_else(|| points.iter().position(|&p| side(p).is_ne()))
        .ok_or_else(|| degenerate(vec![a, b, c]))?;
    Ok(if side(points[d]).is_lt() {
        [a, b, c, d]
    } else {
        [a, c, b, d]
    })
}

/// Of the extreme points along the axes, two that are far apart.
fn farthest_pair(points: &[DVec3]) -> Result<(usize, usize), HullError> {
    let mut low = [0; 3];
    let mut high = [0; 3];
    for (i, &p) in points.iter().enumerate() {
        for axis in 0..3 {
            if p[axis] < points[low[axis]][axis] {
                low[axis] = i;
            }
            if p[axis] > points[high[axis]][axis] {
                high[axis] = i;
            }
        }
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        let (a, b) = (low[axis], high[axis]);
        // Halved, so that no finite input overflows.
        let spread = points[b][axis] * 0.5 - points[a][axis] * 0.5;
        if points[a] != points[b] && best.is_none_or(|(most, ..)| spread > most) {
            best = Some((spread, a, b));
        }
    }
    best.map(|(_, a, b)| (a, b))
        .ok_or_else(|| HullError::Degenerate {
            dimension: 0,
            witness: vec![0],
        })
}

fn farthest(points: &[DVec3], measure: impl Fn(DVec3) -> f64) -> Option<usize> {
    let mut best = None;
    let mut most = 0.0;
    for (i, &p) in points.iter().enumerate() {
        let value = measure(p);
        if value > most {
            most = value;
            best = Some(i);
        }
    }
    best
}

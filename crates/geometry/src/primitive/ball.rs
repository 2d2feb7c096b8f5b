//! The smallest ball around points.

use glam::DVec3;

use crate::sample::Random;

/// Points this much (relatively) outside are rounding.
const GRACE: f64 = 1e-13;

/// Centre and radius of the smallest ball around `points`, up to rounding in
/// the centre; the radius is the largest distance. Zero for no points.
///
/// Welzl, *Smallest enclosing disks (balls and ellipsoids)*, 1991: expected
/// O(n), in a random order with a fixed seed. For points in a plane it is the
/// smallest disk.
pub(super) fn smallest_ball(points: &[DVec3]) -> (DVec3, f64) {
    let mut shuffled = points.to_vec();
    Random::new(points.len() as u64).shuffle(&mut shuffled);
    let Some(&first) = shuffled.first() else {
        return (DVec3::ZERO, 0.0);
    };
    let ball = enclose(&shuffled, &mut Vec::with_capacity(4));
    let centre = ball.map_or(first, |ball| ball.0);
    let radius = points
        .iter()
        .map(|p| p.distance(centre))
        .fold(0.0, f64::max);
    (centre, radius)
}

/// The smallest ball around `points` with `support` on its boundary, as
/// centre and squared radius.
fn enclose(points: &[DVec3], support: &mut Vec<DVec3>) -> Option<(DVec3, f64)> {
    let mut ball = through(support);
    if support.len() == 4 {
        return ball;
    }
    for (i, &p) in points.iter().enumerate() {
        let is_outside =
            |(centre, radius2): (DVec3, f64)| p.distance_squared(centre) > radius2 * (1.0 + GRACE);
        if ball.is_none_or(is_outside) {
            support.push(p);
            // Where the support is degenerate, the ball before is as good.
            ball = enclose(&points[..i], support).or(ball);
            support.pop();
        }
    }
    ball
}

/// The smallest ball through all of up to four points, unless they are
/// affinely dependent.
fn through(support: &[DVec3]) -> Option<(DVec3, f64)> {
    let (&base, others) = support.split_first()?;
    let q: Vec<DVec3> = others.iter().map(|p| *p - base).collect();
    let k = q.len();
    // The centre base + Σ λ q has equal distances: Σ_j (q_i · q_j) λ_j = |q_i|² / 2.
    let mut rows = [[0.0; 4]; 3];
    for i in 0..k {
        for j in 0..k {
            rows[i][j] = q[i].dot(q[j]);
        }
        rows[i][3] = q[i].length_squared() / 2.0;
    }
    let scale = (0..k).map(|i| rows[i][i]).fold(0.0, f64::max);
    for column in 0..k {
        let pivot =
            (column..k).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))?;
        rows.swap(column, pivot);
        if rows[column][column].abs() <= 1e-14 * scale {
            return None;
        }
        let eliminated = rows[column];
        for (row, values) in rows.iter_mut().enumerate().take(k) {
            if row != column {
                let factor = values[column] / eliminated[column];
                for (value, other) in values.iter_mut().zip(eliminated) {
                    *value -= factor * other;
                }
            }
        }
    }
    let offset: DVec3 = (0..k).map(|i| q[i] * (rows[i][3] / rows[i][i])).sum();
    Some((base + offset, offset.length_squared()))
}

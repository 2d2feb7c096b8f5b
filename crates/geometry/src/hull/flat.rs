//! Convex hulls in the plane.

use glam::DVec2;

use crate::predicates::orient2d;

/// The extreme points of finite `points`, counter-clockwise from the
/// lexicographically least; every turn is strictly left, exactly. Fewer than
/// three for points on a line. O(n log n).
///
/// Andrew, *Another efficient algorithm for convex hulls in two dimensions*, 1979.
pub fn convex_hull_2d(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted: Vec<DVec2> = points.iter().map(|p| *p + DVec2::ZERO).collect();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull = chain(sorted.iter().copied());
    let upper = chain(sorted.iter().rev().copied());
    // Each chain ends where the other begins.
    hull.pop();
    hull.extend(upper);
    hull.pop();
    hull
}

/// The right-hand boundary along `points`, which are in order.
fn chain(points: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut chain: Vec<DVec2> = Vec::new();
    for p in points {
        while let [.., a, b] = chain[..] {
            if orient2d(a, b, p).is_gt() {
                break;
            }
            chain.pop();
        }
        chain.push(p);
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Random;

    #[test]
    fn extreme_points_and_only_these() {
        let mut random = Random::new(51);
        for round in 0..200 {
            let size = 2 + round % 7;
            let points: Vec<DVec2> = (0..3 + round)
                .map(|_| DVec2::new(f64::from(random.below(size)), f64::from(random.below(size))))
                .collect();
            let hull = convex_hull_2d(&points);
            for i in 0..hull.len() {
                let (a, b) = (hull[i], hull[(i + 1) % hull.len()]);
                if hull.len() > 2 {
                    assert!(points.iter().all(|p| orient2d(a, b, *p).is_ge()));
                    let c = hull[(i + 2) % hull.len()];
                    assert!(orient2d(a, b, c).is_gt());
                } else {
                    assert!(points.iter().all(|p| orient2d(a, b, *p).is_eq()));
                }
            }
        }
        assert!(convex_hull_2d(&[]).is_empty());
    }
}

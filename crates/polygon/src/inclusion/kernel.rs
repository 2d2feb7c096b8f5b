//! The kernel of a star-shaped polygon and the distance to it (§5.2).

use crate::point::{convex_hull, distance_to_segment, orient};
use crate::Point;

/// The points that see the whole polygon `ring` (counter-clockwise): the hull
/// cut by the half-planes of all edges that are not on it (Proposition 3).
/// Empty if there are none, or if they have no area.
pub fn kernel(ring: &[Point]) -> Vec<Point> {
    let mut kernel = convex_hull(ring);
    let n = ring.len();
    for k in 0..n {
        let (a, b) = (ring[k], ring[(k + 1) % n]);
        if kernel.iter().any(|&q| orient(a, b, q) < 0.0) {
            kernel = clip(&kernel, a, b);
            if kernel.len() < 3 {
                return Vec::new();
            }
        }
    }
    kernel
}

/// The part of a convex polygon left of the line `a b`.
fn clip(polygon: &[Point], a: Point, b: Point) -> Vec<Point> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let n = polygon.len();
    for k in 0..n {
        let (p, q) = (polygon[k], polygon[(k + 1) % n]);
        let (side_p, side_q) = (orient(a, b, p), orient(a, b, q));
        if side_p >= 0.0 {
            kept.push(p);
        }
        if (side_p > 0.0 && side_q < 0.0) || (side_p < 0.0 && side_q > 0.0) {
            let t = side_p / (side_p - side_q);
            kept.push(Point::new(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)));
        }
    }
    kept.dedup();
    if kept.len() > 1 && kept.first() == kept.last() {
        kept.pop();
    }
    kept
}

/// For each vertex of `ring` its distance to `kernel` and the kernel edge
/// nearest to it, by one walk around both (Proposition 5, Corollary 6): O(n).
pub fn distance_to_kernel(ring: &[Point], kernel: &[Point]) -> Vec<(f64, usize)> {
    let m = kernel.len();
    let to_edge = |q: Point, j: usize| distance_to_segment(q, kernel[j], kernel[(j + 1) % m]);
    let Some(&first) = ring.first() else {
        return Vec::new();
    };
    let mut j = (0..m).fold(0, |best, j| {
        if to_edge(first, j) < to_edge(first, best) {
            j
        } else {
            best
        }
    });
    ring.iter()
        .map(|&q| {
            let mut here = to_edge(q, j);
            for _ in 0..m {
                // on the bisector both are as near; the walk goes on to the later edge
                let next = to_edge(q, (j + 1) % m);
                if here < next {
                    break;
                }
                if here == next && to_edge(q, (j + 2) % m) > next {
                    break;
                }
                j = (j + 1) % m;
                here = next;
            }
            (here, j)
        })
        .collect()
}

//! Which corners of a boundary lie on the convex hull of their part.
//!
//! A boundary visits the points of its hull in hull order, so the hull of a
//! chain falls apart at any hull point into the hulls of its two halves
//! (quickhull on index ranges). Points exactly on a hull edge count as hull
//! points: their concavity is zero and they end a pocket.

use crate::boundary::Boundary;
use crate::point::orient;

/// Sets `on_hull` for the corners of `chain`, whose first and last corner are
/// hull points at different places. All other hull points of the part between
/// them, in boundary order, are in the chain.
pub(crate) fn mark_chain(boundary: &Boundary, chain: &[u32], on_hull: &mut [bool]) {
    let n = chain.len();
    let at = |k: usize| boundary.point(chain[k]);
    let mut found = vec![0];
    let mut ranges = vec![(0, n - 1)];
    while let Some((i, j)) = ranges.pop() {
        let (a, b) = (at(i), at(j));
        let mut farthest = (0.0, j);
        for k in i + 1..j {
            let turn = orient(a, b, at(k));
            if turn < farthest.0 {
                farthest = (turn, k);
            }
        }
        if farthest.1 == j {
            // ranges are left to right, so hull indices come out ascending
            found.push(j);
        } else {
            ranges.push((farthest.1, j));
            ranges.push((i, farthest.1));
        }
    }
    // `orient` is exact in sign, not in size: the farthest may not be extreme
    let mut extreme: Vec<usize> = Vec::with_capacity(found.len());
    for k in found {
        while let [.., a, b] = extreme[..] {
            if orient(at(a), at(b), at(k)) > 0.0 {
                break;
            }
            extreme.pop();
        }
        extreme.push(k);
    }
    for &corner in &chain[1..n - 1] {
        on_hull[corner as usize] = false;
    }
    for pair in extreme.windows(2) {
        let (a, b) = (at(pair[0]), at(pair[1]));
        on_hull[chain[pair[0]] as usize] = true;
        on_hull[chain[pair[1]] as usize] = true;
        for k in pair[0] + 1..pair[1] {
            if orient(a, b, at(k)) == 0.0 {
                on_hull[chain[k] as usize] = true;
            }
        }
    }
}

/// Sets `on_hull` for all corners of a closed `ring`; returns it turned so
/// that it begins at a hull corner.
pub(crate) fn mark_ring(boundary: &Boundary, mut ring: Vec<u32>, on_hull: &mut [bool]) -> Vec<u32> {
    let lexicographic = |a: &u32, b: &u32| {
        let (p, q) = (boundary.point(*a), boundary.point(*b));
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.cmp(b))
    };
    let extreme = |order: Option<(usize, &u32)>| order.map_or(0, |(k, _)| k);
    let low = extreme(
        ring.iter()
            .enumerate()
            .min_by(|a, b| lexicographic(a.1, b.1)),
    );
    ring.rotate_left(low);
    let high = extreme(
        ring.iter()
            .enumerate()
            .max_by(|a, b| lexicographic(a.1, b.1)),
    );
    ring.push(ring[0]);
    mark_chain(boundary, &ring[..=high], on_hull);
    mark_chain(boundary, &ring[high..], on_hull);
    ring.pop();
    ring
}

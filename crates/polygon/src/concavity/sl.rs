//! Straight-line concavity (§5.1.1).

use crate::boundary::Boundary;
use crate::point::distance_to_segment;

pub(super) fn measure(boundary: &Boundary, chain: &[u32], concavity: &mut [f64]) {
    let (start, end) = (chain[0], chain[chain.len() - 1]);
    let (a, b) = (boundary.point(start), boundary.point(end));
    for &corner in &chain[1..chain.len() - 1] {
        concavity[corner as usize] = distance_to_segment(boundary.point(corner), a, b);
    }
}

//! When straight-line concavity can hide a feature (Observation 5.5).

use crate::boundary::Boundary;

/// Whether an edge of the pocket has an outward normal opposite to the
/// bridge's. Normals turn with their edges, so the edges are compared.
pub(super) fn hazard(boundary: &Boundary, chain: &[u32]) -> bool {
    let (a, b) = (
        boundary.point(chain[0]),
        boundary.point(chain[chain.len() - 1]),
    );
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    if dx == 0.0 && dy == 0.0 {
        return true;
    }
    chain.windows(2).any(|edge| {
        let (p, q) = (boundary.point(edge[0]), boundary.point(edge[1]));
        (q.x - p.x) * dx + (q.y - p.y) * dy < 0.0
    })
}

//! Antipodal pair by the principal axis (§5.2.2, Eq. 4).

use crate::boundary::Boundary;

/// The extreme corners along the eigenvector of the larger eigenvalue of the
/// covariance of the hole's vertices.
pub(super) fn ends(boundary: &Boundary, ring: &[u32]) -> [u32; 2] {
    let n = ring.len() as f64;
    let points = || ring.iter().map(|&c| boundary.point(c));
    let (mx, my) = points().fold((0.0, 0.0), |m, p| (m.0 + p.x / n, m.1 + p.y / n));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points() {
        let (dx, dy) = (p.x - mx, p.y - my);
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    // larger eigenvalue λ of [[xx, xy], [xy, yy]]; its vector from the better row
    let half = (xx - yy) / 2.0;
    let root = (half * half + xy * xy).sqrt();
    let (ax, ay) = if half >= 0.0 {
        (half + root, xy)
    } else {
        (xy, root - half)
    };
    let (ax, ay) = if ax == 0.0 && ay == 0.0 {
        (1.0, 0.0)
    } else {
        (ax, ay)
    };
    let along = |c: u32| {
        let p = boundary.point(c);
        (p.x - mx) * ax + (p.y - my) * ay
    };
    let (mut low, mut high) = (ring[0], ring[0]);
    for &corner in ring {
        if along(corner) < along(low) {
            low = corner;
        }
        if along(corner) > along(high) {
            high = corner;
        }
    }
    [low, high]
}

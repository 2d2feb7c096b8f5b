//! Volumes of pieces that are never made.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::plane::Plane;
use crate::properties::{bounds, six_fold_volume};

/// The volume of what [`split`](super::split) would put below the plane, up
/// to rounding. With the apex of all tetrahedra on the plane the cap adds
/// nothing, so it is neither built nor missed: O(n), no memory. Rounding moves
/// the section off the plane, which counts with the section's length times its
/// distance from the apex.
///
/// Zero for a mesh without triangles or a plane without a direction.
pub fn volume_below(mesh: &Mesh, plane: &Plane) -> f64 {
    let plane = plane.scaled();
    let (Some((low, high)), Some(unit)) = (bounds(mesh), plane.normal.try_normalize()) else {
        return 0.0;
    };
    // The point of the plane nearest to the middle.
    let middle = low * 0.5 + high * 0.5;
    let apex = middle - unit * (plane.evaluate(middle) / plane.normal.length());
    let six_fold: f64 = mesh
        .faces()
        .map(|corners| six_fold_below(corners.map(|p| p - apex), plane.normal))
        .sum();
    six_fold / 6.0
}

/// Six times the signed volume between the origin and the part of a triangle
/// where `normal · x < 0`.
fn six_fold_below(corners: [DVec3; 3], normal: DVec3) -> f64 {
    let heights = corners.map(|p| normal.dot(p));
    if heights.iter().all(|h| *h >= 0.0) {
        return 0.0;
    }
    let whole = six_fold_volume(corners);
    if heights.iter().all(|h| *h <= 0.0) {
        return whole;
    }
    // A triangle cut off at a corner has the product of both edges' shares of
    // the area, and the same distance from the origin.
    let below = heights.iter().filter(|h| **h < 0.0).count();
    let share = |lone: usize| {
        let [h, i, j] = [0, 1, 2].map(|step| heights[(lone + step) % 3]);
        h / (h - i) * (h / (h - j))
    };
    let is_lone = |h: &f64| (*h < 0.0) == (below == 1);
    match heights.iter().position(is_lone) {
        Some(lone) if below == 1 => whole * share(lone),
        Some(lone) => whole * (1.0 - share(lone)),
        None => whole,
    }
}

//! Capsules.

use glam::DVec3;

use super::axes::candidates;
use super::cylinder::smallest_disk;
use super::slack::Faces;
use super::{margin, Fit};
use crate::mesh::Mesh;

/// All points within a radius of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The ends of the segment.
    pub ends: [DVec3; 2],
    /// The radius.
    pub radius: f64,
}

impl Capsule {
    /// Whether `p` is inside or on the surface, up to rounding.
    pub fn contains(&self, p: DVec3) -> bool {
        let [a, b] = self.ends;
        let along = b - a;
        let t = (p - a).dot(along) / along.length_squared();
        let t = if t.is_finite() {
            t.clamp(0.0, 1.0)
        } else {
            0.0
        };
        p.distance(a + along * t) <= self.radius
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        let [a, b] = self.ends;
        let area = std::f64::consts::PI * self.radius * self.radius;
        area * (a.distance(b) + 4.0 / 3.0 * self.radius)
    }
}

/// A capsule of small volume around a convex hull: for each of the hull's
/// main directions the one with the least radius, as short as it can be.
/// Nothing for an empty mesh.
///
/// The slack is exact: radius + the larger of the ends' signed distances.
pub fn fit_capsule(hull: &Mesh) -> Option<Fit<Capsule>> {
    if hull.triangles.is_empty() {
        return None;
    }
    let shape = candidates(hull)
        .into_iter()
        .map(|axis| around(&hull.vertices, axis))
        .min_by(|a, b| a.volume().total_cmp(&b.volume()))?;
    let shape = Capsule {
        radius: shape.radius + margin(hull),
        ..shape
    };
    let faces = Faces::of(hull);
    let [a, b] = shape.ends.map(|end| faces.signed_distance(end));
    Some(Fit {
        shape,
        slack: shape.radius + a.max(b),
    })
}

fn around(points: &[DVec3], axis: DVec3) -> Capsule {
    let (middle, radius) = smallest_disk(points, axis);
    // Each point must be within the cap's ball beyond the end.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &p in points {
        let along = axis.dot(p);
        let off2 = (p - middle - axis * along).length_squared();
        let reach = (radius * radius - off2).max(0.0).sqrt();
        low = low.min(along + reach);
        high = high.max(along - reach);
    }
    if low > high {
        let both = low * 0.5 + high * 0.5;
        (low, high) = (both, both);
    }
    Capsule {
        ends: [low, high].map(|t| middle + axis * t),
        radius,
    }
}

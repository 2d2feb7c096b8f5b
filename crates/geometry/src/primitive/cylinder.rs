//! Cylinders.

use glam::DVec3;

use super::axes::candidates;
use super::ball::smallest_ball;
use super::slack::Faces;
use super::{extent, margin, Fit};
use crate::mesh::Mesh;

/// A cylinder with flat ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Its centre.
    pub centre: DVec3,
    /// Its unit direction.
    pub axis: DVec3,
    /// Its radius.
    pub radius: f64,
    /// Half its height.
    pub half_height: f64,
}

impl Cylinder {
    /// Whether `p` is inside or on the surface, up to rounding.
    pub fn contains(&self, p: DVec3) -> bool {
        let local = p - self.centre;
        let along = self.axis.dot(local);
        along.abs() <= self.half_height && (local - self.axis * along).length() <= self.radius
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        2.0 * std::f64::consts::PI * self.radius * self.radius * self.half_height
    }
}

/// A cylinder of small volume around a convex hull: for each of the hull's
/// main directions the smallest along it. Nothing for an empty mesh.
///
/// The slack is attained on a rim; it is bounded there to 1e-3 of
/// itself or 1e-6 of the radius.
pub fn fit_cylinder(hull: &Mesh) -> Option<Fit<Cylinder>> {
    if hull.triangles.is_empty() {
        return None;
    }
    let shape = candidates(hull)
        .into_iter()
        .map(|axis| around(&hull.vertices, axis))
        .min_by(|a, b| a.volume().total_cmp(&b.volume()))?;
    let margin = margin(hull);
    let shape = Cylinder {
        radius: shape.radius + margin,
        half_height: shape.half_height + margin,
        ..shape
    };
    let faces = Faces::of(hull);
    let (u, v) = shape.axis.any_orthonormal_pair();
    let (u, v) = (u * shape.radius, v * shape.radius);
    let rough = 1e-2 * shape.radius;
    let rim = |sign: f64, accuracy: f64| {
        let centre = shape.centre + shape.axis * (sign * shape.half_height);
        faces.largest_on_circle(centre, u, v, accuracy)
    };
    let scale = rim(1.0, rough).max(rim(-1.0, rough)) - rough;
    let accuracy = (1e-3 * scale).max(1e-6 * shape.radius);
    Some(Fit {
        shape,
        slack: rim(1.0, accuracy).max(rim(-1.0, accuracy)),
    })
}

fn around(points: &[DVec3], axis: DVec3) -> Cylinder {
    let (low, high) = extent(points, axis);
    let (middle, radius) = smallest_disk(points, axis);
    Cylinder {
        centre: middle + axis * (low * 0.5 + high * 0.5),
        axis,
        radius,
        half_height: (high - low) * 0.5,
    }
}

/// The smallest disk around points seen along an axis: its centre in the
/// plane through the origin, and its radius.
pub(super) fn smallest_disk(points: &[DVec3], axis: DVec3) -> (DVec3, f64) {
    let flat: Vec<DVec3> = points.iter().map(|p| *p - axis * axis.dot(*p)).collect();
    smallest_ball(&flat)
}

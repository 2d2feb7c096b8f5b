//! Spheres.

use glam::DVec3;

use super::ball::smallest_ball;
use super::slack::Faces;
use super::{margin, Fit};
use crate::mesh::Mesh;

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl Sphere {
    /// Whether `p` is inside or on the surface, up to rounding.
    pub fn contains(&self, p: DVec3) -> bool {
        p.distance(self.centre) <= self.radius
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius * self.radius * self.radius
    }
}

/// The smallest sphere around a convex hull; nothing for an empty mesh.
///
/// The slack is exact: radius + signed distance of the centre from the hull.
pub fn fit_sphere(hull: &Mesh) -> Option<Fit<Sphere>> {
    if hull.triangles.is_empty() {
        return None;
    }
    let (centre, radius) = smallest_ball(&hull.vertices);
    let radius = radius + margin(hull);
    let slack = radius + Faces::of(hull).signed_distance(centre);
    Some(Fit {
        shape: Sphere { centre, radius },
        slack,
    })
}

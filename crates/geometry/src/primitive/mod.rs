//! Simple shapes around convex solids: what physics engines are fastest with.
//!
//! Every fit encloses the hull's vertices with a margin for rounding, and its
//! *slack* bounds how far it sticks out: the largest distance from a point of
//! the shape to the hull. For a convex shape K around a hull H that is
//! max over unit n of `h_K(n) − h_H(n)`, the difference of support functions.

mod axes;
mod ball;
mod capsule;
mod cuboid;
mod cylinder;
mod slack;
mod sphere;
#[cfg(test)]
mod tests;

pub use capsule::{fit_capsule, Capsule};
pub use cuboid::{fit_box, Cuboid};
pub use cylinder::{fit_cylinder, Cylinder};
pub use sphere::{fit_sphere, Sphere};

use glam::DVec3;

use crate::mesh::Mesh;
use crate::tolerance::Rounding;

/// A shape around a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit<S> {
    /// The shape.
    pub shape: S,
    /// No point of the shape is farther than this from the hull (up to the
    /// rounding of the computation, below 1e-12 of the hull's size).
    pub slack: f64,
}

/// What an enclosing shape must keep free around the computed hull, so that
/// it encloses in any sensible order of evaluation.
fn margin(hull: &Mesh) -> f64 {
    4.0 * Rounding::of(hull).crossing()
}

/// Least and greatest of `direction · x` over the points.
fn extent(points: &[DVec3], direction: DVec3) -> (f64, f64) {
    points
        .iter()
        .map(|p| direction.dot(*p))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
            (low.min(t), high.max(t))
        })
}

//! Oriented planes.

use glam::DVec3;

/// The set of points with `normal · x = offset`. *Below* is `normal · x <
/// offset`. The normal need not have unit length: exactness matters more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Direction in which *above* lies.
    pub normal: DVec3,
    /// Value of `normal · x` on the plane.
    pub offset: f64,
}

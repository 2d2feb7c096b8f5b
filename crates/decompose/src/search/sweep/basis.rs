//! The frame in which parallel planes are swept.

use glam::DVec3;

/// A right-handed orthonormal basis; planes are swept along `w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// First direction in the plane.
    pub u: DVec3,
    /// Second direction in the plane.
    pub v: DVec3,
    /// The plane's normal.
    pub w: DVec3,
}

impl Basis {
    /// The coordinate axis 0, 1 or 2 as sweep direction.
    pub fn axis(axis: usize) -> Self {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        Basis {
            u: axes[(axis + 1) % 3],
            v: axes[(axis + 2) % 3],
            w: axes[axis % 3],
        }
    }

    /// A basis whose sweep direction is the unit vector `w`.
    pub fn along(w: DVec3) -> Self {
        for axis in 0..3 {
            if w == Basis::axis(axis).w {
                return Basis::axis(axis);
            }
        }
        let (u, v) = w.any_orthonormal_pair();
        let (u, v) = if u.cross(v).dot(w) > 0.0 {
            (u, v)
        } else {
            (v, u)
        };
        Basis { u, v, w }
    }

    pub(super) fn local(&self, p: DVec3) -> DVec3 {
        DVec3::new(self.u.dot(p), self.v.dot(p), self.w.dot(p))
    }
}

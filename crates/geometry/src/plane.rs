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

impl Plane {
    /// The plane on which coordinate `axis` (0, 1, 2) equals `value`, above towards larger values.
    pub fn axis_aligned(axis: usize, value: f64) -> Self {
        Self {
            normal: DVec3::AXES[axis],
            offset: value,
        }
    }

    /// The same points with above and below exchanged.
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
        }
    }

    /// The coordinate this plane fixes, with the normal's component along it,
    /// if the other two components are zero.
    pub fn axis(&self) -> Option<(usize, f64)> {
        let n = self.normal;
        match (n.x != 0.0, n.y != 0.0, n.z != 0.0) {
            (true, false, false) => Some((0, n.x)),
            (false, true, false) => Some((1, n.y)),
            (false, false, true) => Some((2, n.z)),
            _ => None,
        }
    }

    /// The same plane with its normal's largest component in [1/2, 1),
    /// exactly (by a power of two), so that [`evaluate`](Self::evaluate)
    /// neither overflows nor vanishes for points of ordinary size.
    #[must_use]
    pub fn scaled(&self) -> Self {
        let (_, exponent) = libm::frexp(self.normal.abs().max_element());
        // In two steps, either of which is in range.
        let steps = [-exponent / 2, -exponent - -exponent / 2].map(|e| libm::ldexp(1.0, e));
        Self {
            normal: self.normal * steps[0] * steps[1],
            offset: self.offset * steps[0] * steps[1],
        }
    }

    /// `normal · x - offset`, rounded. Its sign is decided by
    /// [`predicates::side`](crate::predicates::side).
    pub fn evaluate(&self, x: DVec3) -> f64 {
        self.normal.dot(x) - self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_changes_neither_direction_nor_place() {
        for size in [f64::MIN_POSITIVE, 5e-324, 1e-200, 0.7, 3.0, 1e300, f64::MAX] {
            let plane = Plane {
                normal: DVec3::new(0.0, size, -size),
                offset: size,
            };
            let scaled = plane.scaled();
            let expected = scaled.normal.y;
            assert!((0.5..1.0).contains(&expected), "{size}: {scaled:?}");
            assert_eq!(scaled.normal, DVec3::new(0.0, expected, -expected));
            assert_eq!(scaled.offset, expected);
        }
    }
}

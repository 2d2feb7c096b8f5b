//! The growing body: an ellipsoid, which is a ball in its own coordinates.

use assetpipe_geometry::bvh::Bounds;
use assetpipe_geometry::properties::mass_properties;
use assetpipe_geometry::Mesh;
use glam::{DMat3, DVec3};

/// A centre and a metric: the body of size t is `|metric · (x − centre)| ≤ t`.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Where it grows from.
    pub centre: DVec3,
    metric: DMat3,
    shape: DMat3,
}

impl Body {
    /// A ball.
    pub fn ball(centre: DVec3) -> Body {
        Body {
            centre,
            metric: DMat3::IDENTITY,
            shape: DMat3::IDENTITY,
        }
    }

    /// The ellipsoid with the centroid and the second moments of a polytope;
    /// `None` for one without volume. Scaled so that its largest half axis is
    /// of the order of one.
    pub fn of(polytope: &Mesh) -> Option<Body> {
        let mass = mass_properties(polytope);
        let inertia = mass.inertia;
        let half_trace = 0.5 * (inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z);
        let moments = DMat3::from_diagonal(DVec3::splat(half_trace)) - inertia;
        let largest = moments.x_axis.x.max(moments.y_axis.y).max(moments.z_axis.z);
        if !(mass.volume > 0.0 && largest > 0.0) {
            return None;
        }
        // moments = shape · shapeᵀ (Cholesky); the metric is the inverse of the shape.
        let m = moments * (1.0 / largest);
        let l11 = m.x_axis.x.sqrt();
        let (l21, l31) = (m.x_axis.y / l11, m.x_axis.z / l11);
        let l22 = (m.y_axis.y - l21 * l21).sqrt();
        let l32 = (m.y_axis.z - l31 * l21) / l22;
        let l33 = (m.z_axis.z - l31 * l31 - l32 * l32).sqrt();
        // Thinner than this, inverting it would cost all digits.
        if !(l11 > 1e-6 && l22 > 1e-6 && l33 > 1e-6 && mass.centroid.is_finite()) {
            return None;
        }
        let shape = DMat3::from_cols(
            DVec3::new(l11, l21, l31),
            DVec3::new(0.0, l22, l32),
            DVec3::new(0.0, 0.0, l33),
        );
        Some(Body {
            centre: mass.centroid,
            metric: shape.inverse(),
            shape,
        })
    }

    /// A point in the body's own coordinates.
    pub fn own(&self, x: DVec3) -> DVec3 {
        self.metric * (x - self.centre)
    }

    /// A point from the body's own coordinates.
    pub fn outer(&self, y: DVec3) -> DVec3 {
        self.centre + self.shape * y
    }

    /// How fast `normal · y` grows with x along the plane's normal: what a
    /// length across the plane becomes in own coordinates.
    pub fn stretch(&self, normal: DVec3) -> f64 {
        (self.metric.transpose() * normal).length()
    }

    /// A box in own coordinates around a box.
    pub fn own_bounds(&self, bounds: &Bounds) -> Bounds {
        let centre = self.own(bounds.centre());
        let half = 0.5 * (bounds.hi - bounds.lo);
        let m = self.metric;
        let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
        Bounds {
            lo: centre - reach,
            hi: centre + reach,
        }
    }
}

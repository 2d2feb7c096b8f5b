//! Certified intervals.

/// `[lower, upper]`, in the unit of the mesh, which provably holds the true
/// value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Not above the true value.
    pub lower: f64,
    /// Not below the true value.
    pub upper: f64,
}

impl Interval {
    /// The interval of one exactly known value.
    pub fn exactly(value: f64) -> Interval {
        Interval {
            lower: value,
            upper: value,
        }
    }

    /// The maximum of two values known by their intervals.
    #[must_use]
    pub fn max(self, other: Interval) -> Interval {
        Interval {
            lower: self.lower.max(other.lower),
            upper: self.upper.max(other.upper),
        }
    }

    /// Whether `value` is in it.
    pub fn holds(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }
}

/// How wide an interval may be: `upper` at most `(1 + relative) · lower + absolute`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Share of the lower bound.
    pub relative: f64,
    /// In the unit of the mesh.
    pub absolute: f64,
}

impl Gap {
    /// The largest upper end that is near enough to `lower`.
    pub fn upper(&self, lower: f64) -> f64 {
        lower * (1.0 + self.relative) + self.absolute
    }
}

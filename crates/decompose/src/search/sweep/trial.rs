//! What is known of trial cuts.

use glam::DVec3;

/// A sample of what no hull may contain.
#[derive(Clone, Copy, Debug)]
pub struct Forbidden {
    /// Where.
    pub point: DVec3,
    /// The volume it stands for.
    pub weight: f64,
    /// A hull contains it only if it is this deep inside.
    pub depth: f64,
}

/// What one side of a trial cut would be.
#[derive(Clone, Copy, Debug, Default)]
pub struct Side {
    /// Volume of the part.
    pub part: f64,
    /// Volume of its hull.
    pub hull: f64,
    /// Forbidden volume in its hull.
    pub forbidden: f64,
}

/// One trial cut.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Height of the plane along the basis' `w`.
    pub offset: f64,
    /// The part with smaller heights.
    pub below: Side,
    /// The part with larger heights.
    pub above: Side,
}

/// All trial cuts of one direction.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    /// By increasing offset.
    pub trials: Vec<Trial>,
    /// For each forbidden sample the first trial whose hull below holds it.
    pub enters_below: Vec<u32>,
    /// For each forbidden sample, one past the last trial whose hull above
    /// holds it.
    pub leaves_above: Vec<u32>,
}

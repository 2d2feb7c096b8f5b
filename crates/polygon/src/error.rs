//! What may be wrong with an outline or a call, and where.

use crate::Point;

/// Why an outline was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OutlineError {
    /// A coordinate is not a finite number, or its magnitude is beyond what
    /// exact predicates can hold (1e-142 to 1e100).
    #[error("ring {ring}, vertex {vertex}: coordinate is not finite or out of range")]
    Coordinate {
        /// Index of the ring, 0 is the outer boundary.
        ring: usize,
        /// Index of the vertex in its ring.
        vertex: usize,
    },
    /// Two edges cross: the outline bounds no region.
    #[error(
        "ring {ring}: the edge from ({}, {}) to ({}, {}) crosses the edge from ({}, {}) to ({}, {})",
        edge[0].x, edge[0].y, edge[1].x, edge[1].y, other[0].x, other[0].y, other[1].x, other[1].y
    )]
    Crossing {
        /// Index of the ring of the first edge.
        ring: usize,
        /// The edge that crosses an earlier one.
        edge: [Point; 2],
        /// The earlier edge.
        other: [Point; 2],
    },
    /// Nothing is left after duplicate and collinear vertices are taken away.
    #[error("the outline encloses no area")]
    NoArea,
    /// More vertices than a 32-bit index can name.
    #[error("the outline has {0} vertices, more than 2^30")]
    TooLarge(usize),
    /// A parameter is outside its range.
    #[error("{name} must be {wanted}, got {got}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// What would be right.
        wanted: &'static str,
        /// What was given.
        got: f64,
    },
}

//! What can go wrong.

/// Why a solid was not decomposed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DecomposeError {
    /// No triangles.
    #[error("the mesh has no triangles")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("vertex {index} is not finite")]
    NotFinite {
        /// The first such vertex.
        index: usize,
    },
    /// The surface is not closed and consistently oriented.
    #[error("the mesh is no closed solid: edge ({from}, {to}) is left open or used in one sense twice ({count} such edges)")]
    NotClosed {
        /// Start of the first such edge.
        from: u32,
        /// Its end.
        to: u32,
        /// How many there are.
        count: usize,
    },
    /// The mesh encloses no volume.
    #[error("the mesh encloses no volume: its vertices span {dimension} dimensions, or its volume is rounding")]
    Flat {
        /// Dimension of the span of its vertices.
        dimension: usize,
    },
    /// The tolerance is not a positive, finite number.
    #[error("the tolerance must be a positive, finite length, not {epsilon}")]
    Tolerance {
        /// What was given.
        epsilon: f64,
    },
    /// More parts than allowed.
    #[error("more than {limit} parts are needed at this tolerance")]
    TooManyParts {
        /// The limit.
        limit: usize,
    },
    /// The ball is too small for the size of the mesh.
    #[error("a reach of {radius} is too small for this mesh: at least {least} is needed")]
    Reach {
        /// What was given.
        radius: f64,
        /// What would do.
        least: f64,
    },
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// A fault of ours.
    #[error("internal fault: {0}")]
    Internal(String),
}

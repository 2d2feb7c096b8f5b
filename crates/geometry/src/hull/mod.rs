//! Convex hulls, exactly: what encloses is proved by exact predicates.

mod circumscribe;
mod facets;
mod flat;
mod growing;
mod program;
mod quickhull;
mod simplex;
mod simplify;
#[cfg(test)]
mod tests;
mod validate;

use glam::DVec3;

pub use flat::convex_hull_2d;
pub use quickhull::Builder;
pub use simplify::{simplify_outward, simplify_within, simplify_within_room, SimplifyError};
pub use validate::{check_convex, ConvexityDefect};

use crate::mesh::Mesh;

/// Why points have no three-dimensional hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// No points.
    #[error("no points to enclose")]
    Empty,
    /// More points than indices.
    #[error("{count} points are more than a mesh can index")]
    TooMany {
        /// How many points were given.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {index} is not finite: {point:?}")]
    NotFinite {
        /// Index of the first such point.
        index: usize,
        /// The point.
        point: DVec3,
    },
    /// All points lie in a point, on a line or on a plane.
    #[error("the points span {dimension} dimensions, not three (witness points {witness:?})")]
    Degenerate {
        /// Dimension of the affine span: 0, 1 or 2.
        dimension: usize,
        /// Indices of `dimension + 1` points that span it.
        witness: Vec<usize>,
    },
}

/// The convex hull of `points` as a closed mesh, outward faces counter-clockwise.
///
/// Exact: no input point lies strictly outside any face plane under
/// [`orient3d`](crate::predicates::orient3d). Minimal: every vertex is an
/// extreme point; coplanar faces form one convex polygon, triangulated as a
/// fan from its first vertex. Canonical: vertices are ascending by (x, y, z)
/// and equal to input points (negative zero is written as zero), triangles
/// start at their least index and are ascending, so the result does not
/// depend on the order or the multiplicity of the input. Expected time is
/// O(n log n).
///
/// Quickhull (Barber, Dobkin, Huhdanpaa, *The Quickhull Algorithm for Convex
/// Hulls*, 1996) with exact orientation in place of its thick facets.
///
/// # Errors
/// [`HullError`] when the points are none, not finite, or span no volume.
pub fn convex_hull(points: &[DVec3]) -> Result<Mesh, HullError> {
    Builder::default().hull(points)
}

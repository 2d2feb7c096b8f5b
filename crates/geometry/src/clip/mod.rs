//! Cutting solids by planes.

mod components;
mod section;
mod separate;
mod split;
mod subdivide;
#[cfg(test)]
mod tests;
mod volume;

use glam::DVec3;

pub use components::{components, label_components};
pub use separate::separate;
pub use split::{split, Split};
pub use subdivide::subdivide;
pub use volume::volume_below;

/// Why a mesh cannot be cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClipError {
    /// The plane has a zero normal or a number that is not finite.
    #[error("not a plane: normal {normal:?}, offset {offset}")]
    NotAPlane {
        /// The plane's normal.
        normal: DVec3,
        /// The plane's offset.
        offset: f64,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names a vertex that does not exist")]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
    },
    /// A used vertex has a coordinate that is not finite.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// The surface is open where the plane meets it.
    #[error("the mesh is not closed near {near:?}")]
    NotClosed {
        /// A point of the section at which as many edges do not end as start.
        near: DVec3,
    },
}

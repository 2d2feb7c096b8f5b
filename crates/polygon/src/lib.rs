//! The plane: approximate convex decomposition of polygons (Lien & Amato
//! 2006) and convex sets inside them (Chassery & Coeurjolly 2005).
//!
//! No I/O, no printing, no Python. Every sign of orientation is exact
//! (`point`); cuts are diagonals between input vertices, so parts share them
//! to the bit and their union is the input.

mod arrangement;
mod boundary;
mod concavity;
mod decompose;
mod error;
mod geodesic;
mod hierarchy;
mod holes;
mod hull;
pub mod inclusion;
mod point;
mod resolve;
mod triangulate;
mod visibility;

pub use concavity::Measure;
pub use decompose::{decompose, Parameters};
pub use error::OutlineError;
pub use hierarchy::{Hierarchy, Part};
pub use holes::HoleAxis;
pub use point::{convex_hull, orient, signed_area, Point};
pub use resolve::DiagonalWeights;
pub use visibility::notch_visibility;

//! Distances from points to triangles, solids and convex bodies, with a stated
//! allowance for rounding.

mod convex;
mod solid;
mod triangle;

pub use convex::{ConvexBody, HalfSpace};
pub use solid::SolidIndex;
pub use triangle::Triangle;

//! Solids, planes, hulls, cuts and distances: pure geometry.
//!
//! No I/O, no printing, no Python. Signs of orientation are decided exactly
//! (`predicates`); every epsilon lives in `tolerance` and scales with the mesh.

pub mod bvh;
pub mod clip;
pub mod crossing;
pub mod distance;
pub mod hull;
pub mod mesh;
pub mod planar;
pub mod plane;
pub mod predicates;
pub mod primitive;
pub mod properties;
pub mod sample;
pub mod tolerance;

pub use glam::DVec3;
pub use mesh::Mesh;
pub use plane::Plane;

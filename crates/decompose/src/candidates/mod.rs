//! Where cuts may go, beyond the uniform grid.

pub mod flat_faces;
pub mod frame;

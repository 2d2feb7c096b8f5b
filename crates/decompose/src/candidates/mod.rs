//! Where to cut: frames and planes that are not a grid.

pub mod chain;
pub mod flat_faces;
pub mod frame;
pub mod section;
pub mod sector;

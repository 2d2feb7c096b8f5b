//! Where to cut: frames and planes that are not a grid.

pub mod chain;
pub mod eigen;
pub mod flat_faces;
pub mod frame;
pub mod notch;
pub mod revolution;
pub mod section;
pub mod sector;

//! How far a hull is from what it stands for, always as a certified interval.

mod interval;
mod limits;
pub mod thickening;

pub use interval::Interval;
pub use limits::Limits;

//! How far a hull is from what it stands for, always as a certified interval.

mod interval;
mod limits;
#[cfg(test)]
mod shapes;
pub mod thickening;

pub use interval::{Gap, Interval};
pub use limits::Limits;

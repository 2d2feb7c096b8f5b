//! How far a hull is from what it stands for, always as a certified interval.

pub mod certify;
pub mod coverage;
mod decision;
mod depth;
mod goal;
mod interval;
mod limits;
mod mixture;
mod patches;
pub mod thickening;
pub mod wei;

pub use decision::Decision;
pub use interval::{Gap, Interval};
pub use limits::Limits;

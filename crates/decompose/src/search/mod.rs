//! The search for cuts.

pub mod lookahead;
pub mod piece;
pub mod sweep_hull;
pub mod trial;
mod value;

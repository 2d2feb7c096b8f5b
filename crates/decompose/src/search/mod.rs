//! The search for cuts.

pub mod greedy;
pub mod lookahead;
pub mod mcts;
pub mod piece;
pub mod policy;
pub mod price;
pub mod sweep;
mod value;

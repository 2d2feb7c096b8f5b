//! Collision-aware approximate convex decomposition of solids.

pub mod adopt;
mod ahead;
pub mod between;
pub mod budget;
pub mod buried;
pub mod candidates;
pub mod canonical;
pub mod close;
pub mod cluster;
pub mod concavity;
pub mod control;
pub mod convex;
pub mod decomposition;
pub mod engine;
pub mod error;
pub mod even;
pub mod explore;
pub mod finish;
pub mod forbidden;
pub mod hierarchy;
pub mod inner;
pub mod judge;
pub mod merge;
pub mod orientation;
pub mod part;
pub mod prismatic;
pub mod progress;
pub mod proxy;
pub mod reach;
pub mod search;
pub mod settings;
#[cfg(test)]
mod shapes;
pub mod slivers;
pub mod step;
pub mod working;

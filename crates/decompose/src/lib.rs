//! Collision-aware approximate convex decomposition of solids.

pub mod budget;
pub mod candidates;
pub mod canonical;
pub mod close;
pub mod concavity;
pub mod control;
pub mod convex;
pub mod decomposition;
pub mod engine;
pub mod error;
pub mod explore;
pub mod finish;
pub mod forbidden;
pub mod hierarchy;
pub mod inner;
pub mod judge;
pub mod merge;
pub mod part;
pub mod prismatic;
pub mod progress;
pub mod proxy;
pub mod reach;
pub mod search;
pub mod settings;
pub mod slivers;
pub mod working;

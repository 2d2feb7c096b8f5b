//! Regions of the plane, triangulated: what closes a cut.
//!
//! A region is given by its boundary, a *cycle*: directed edges with whole
//! multiplicities, as many ending as starting at every point. Loops may be
//! nested, touch, overlap or cross; a point belongs to the region as often as
//! the cycle winds around it.

mod constraint;
mod crossing;
mod delaunay;
mod fill;
#[cfg(test)]
mod tests;

pub use fill::{fill, Edge, Filling};

//! Convex polytopes inside a solid: the other side of its hulls.
//!
//! Contact with such a polytope proves contact with the solid, as distance
//! from the outer hulls proves freedom. The idea is the kernel dilation of
//! Chassery & Coeurjolly 2005 (§5.3) carried to three dimensions: a body grows
//! around a point inside; where it meets the surface a plane stops it there,
//! and the order of meeting is the order of the planes (`grow`).
//!
//! *Proved* is one thing only, by exact predicates on the polytope as it is
//! handed out (`proof`): its interior meets no triangle of the surface and one
//! of its points is inside, so all of it is. Where bodies grow (`seeds`), their
//! metric, how many are kept (`cover`) and their size are heuristics.

mod body;
mod cover;
mod grow;
mod proof;
mod seeds;
#[cfg(test)]
mod tests;
mod thin;

pub use cover::{inner_polytopes, InnerPolytope, InnerSettings};
pub use proof::is_inside;

//! Collision-aware approximate convex decomposition of solids.

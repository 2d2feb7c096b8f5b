//! Approximate convex decomposition of polygons, and convex sets inside them.

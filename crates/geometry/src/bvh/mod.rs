//! A bounding-volume hierarchy over triangles, in flat arrays.
//!
//! Built once for a solid and shared by all its parts. Deterministic: the same
//! triangles give the same tree and every query the same answer.

mod build;
mod closest;
mod crossings;
#[cfg(test)]
mod tests;
mod wide;

pub use closest::Nearest;
pub use crossings::Side;

use std::ops::Range;

use glam::DVec3;

use crate::distance::Triangle;
use crate::Mesh;

/// No traversal is deeper than this: the build splits at the median once a
/// branch has used up half of it.
const DEPTH: usize = 64;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub lo: DVec3,
    /// Largest coordinates.
    pub hi: DVec3,
}

impl Bounds {
    /// The box of nothing: the neutral element of [`Bounds::join`].
    pub const EMPTY: Bounds = Bounds {
        lo: DVec3::INFINITY,
        hi: DVec3::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        points.into_iter().fold(Bounds::EMPTY, |b, p| Bounds {
            lo: b.lo.min(p),
            hi: b.hi.max(p),
        })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn join(self, other: Bounds) -> Bounds {
        Bounds {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

    /// The middle.
    pub fn centre(&self) -> DVec3 {
        (self.lo + self.hi) * 0.5
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        (self.hi - self.lo).length()
    }

    /// Whether the boxes have a point in common.
    #[inline]
    pub fn overlaps(&self, other: &Bounds) -> bool {
        self.lo.cmple(other.hi).all() && other.lo.cmple(self.hi).all()
    }

    /// Squared distance from `q` to the box, zero inside.
    #[inline]
    pub fn distance2(&self, q: DVec3) -> f64 {
        (self.lo - q)
            .max(q - self.hi)
            .max(DVec3::ZERO)
            .length_squared()
    }
}

/// A node: a leaf holds triangles `first .. first + count`; an inner node
/// (`count` = 0) has its left child next to it and its right child at `first`.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    first: u32,
    count: u32,
}

/// What a node holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Branch {
    /// Slots of triangles.
    Leaf(Range<u32>),
    /// Two nodes.
    Fork([u32; 2]),
}

/// The hierarchy, with its own copy of the triangles in traversal order.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    wide: wide::Wide,
    triangles: Vec<Triangle>,
    original: Vec<u32>,
}

impl Bvh {
    /// Build over all triangles of `mesh`.
    pub fn new(mesh: &Mesh) -> Bvh {
        build::build(mesh)
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there is no triangle at all.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |n| n.bounds)
    }

    /// The box around node `index`; the root, if there is one, has index 0.
    pub fn node_bounds(&self, index: u32) -> Bounds {
        self.nodes[index as usize].bounds
    }

    /// What node `index` holds.
    pub fn branch(&self, index: u32) -> Branch {
        let node = &self.nodes[index as usize];
        if node.count > 0 {
            Branch::Leaf(node.first..node.first + node.count)
        } else {
            Branch::Fork([index + 1, node.first])
        }
    }

    /// Triangle `slot`, in traversal order.
    #[inline]
    pub fn triangle(&self, slot: u32) -> &Triangle {
        &self.triangles[slot as usize]
    }

    /// The index in the mesh of triangle `slot`.
    pub fn original(&self, slot: u32) -> u32 {
        self.original[slot as usize]
    }

    /// The slots of all triangles whose bounding box passes `keep`, pruned by
    /// `keep` on every box above them; `visit` returns `false` to stop.
    pub fn for_each(&self, keep: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(u32) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; DEPTH];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let at = stack[top] as usize;
            let node = &self.nodes[at];
            if !keep(&node.bounds) {
                continue;
            }
            if node.count > 0 {
                for slot in node.first..node.first + node.count {
                    if keep(&self.triangles[slot as usize].bounds()) && !visit(slot) {
                        return;
                    }
                }
            } else {
                stack[top] = node.first;
                stack[top + 1] = at as u32 + 1;
                top += 2;
            }
        }
    }
}

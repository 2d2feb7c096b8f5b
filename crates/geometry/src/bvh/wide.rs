//! The hierarchy four boxes at a time, for nearest-triangle queries.
//!
//! Two levels of the binary tree in one node, its boxes in single precision, so
//! that one vector instruction looks at four of them. Boxes only rule out: a
//! query is widened by more than all rounding here, so none is ruled out that
//! double precision would not, and distances to triangles stay what they are.

use glam::{DVec3, Vec4};

use super::{Bounds, Node};

/// Levels are half of the binary tree's, and each leaves three boxes for later.
pub(super) const STACK: usize = 3 * super::DEPTH / 2;

/// Stands for no child.
const NONE: u32 = u32::MAX;
/// Marks a child as triangles: the first slot times four and the number less one.
const LEAF: u32 = 1 << 31;
/// Coordinates are below 1 in size: more than the rounding of a box, of a query
/// and of their difference together, for a query as far out as 1.
const ROUNDING: f32 = 1.0 / (1 << 22) as f32;
/// More than the rounding of a squared distance, as a share.
const ROUNDING_SQUARED: f64 = 1.0 / (1 << 20) as f64;
/// Queries farther out, in sizes of the hierarchy, count as no farther.
const FAR: f64 = 1e15;

/// Up to four boxes and what they hold.
#[derive(Clone, Copy, Debug)]
struct Four {
    lo: [Vec4; 3],
    hi: [Vec4; 3],
    children: [u32; 4],
}

/// What a box holds.
pub(super) enum Child {
    /// Another node.
    Node(u32),
    /// Slots of triangles.
    Triangles { first: u32, count: u32 },
}

impl Child {
    pub(super) fn from(code: u32) -> Child {
        if code & LEAF == 0 {
            Child::Node(code)
        } else {
            Child::Triangles {
                first: (code & !LEAF) >> 2,
                count: (code & 3) + 1,
            }
        }
    }
}

/// The wide hierarchy.
#[derive(Clone, Debug)]
pub(super) struct Wide {
    nodes: Vec<Four>,
    centre: DVec3,
    /// Brings the hierarchy to size one.
    scale: f64,
}

/// A query point in the hierarchy's own measure.
pub(super) struct Query {
    /// Coordinates and the same moved towards larger and smaller ones by all rounding.
    above: [Vec4; 3],
    below: [Vec4; 3],
}

impl Wide {
    pub(super) fn new(nodes: &[Node]) -> Wide {
        let bounds = nodes.first().map_or(Bounds::EMPTY, |n| n.bounds);
        let half = (0.5 * (bounds.hi - bounds.lo)).max_element();
        let mut wide = Wide {
            nodes: Vec::with_capacity(nodes.len() / 3 + 1),
            centre: bounds.centre(),
            scale: if half > 0.0 { 1.0 / half } else { 1.0 },
        };
        if !nodes.is_empty() {
            wide.add(nodes, 0);
        }
        wide
    }

    /// Append the node for binary node `at` and all below it.
    fn add(&mut self, nodes: &[Node], at: u32) -> u32 {
        let index = self.nodes.len();
        let is_leaf = |i: u32| nodes[i as usize].count > 0;
        let fork = |i: u32| [i + 1, nodes[i as usize].first];
        let members: Vec<u32> = if is_leaf(at) {
            vec![at]
        } else {
            fork(at)
                .into_iter()
                .flat_map(|i| {
                    if is_leaf(i) {
                        vec![i]
                    } else {
                        fork(i).to_vec()
                    }
                })
                .collect()
        };
        let mut four = Four {
            lo: [Vec4::INFINITY; 3],
            hi: [Vec4::NEG_INFINITY; 3],
            children: [NONE; 4],
        };
        for (lane, member) in members.iter().enumerate() {
            let bounds = nodes[*member as usize].bounds;
            let lo = ((bounds.lo - self.centre) * self.scale).as_vec3();
            let hi = ((bounds.hi - self.centre) * self.scale).as_vec3();
            for axis in 0..3 {
                four.lo[axis][lane] = lo[axis];
                four.hi[axis][lane] = hi[axis];
            }
        }
        self.nodes.push(four);
        for (lane, member) in members.iter().enumerate() {
            let node = nodes[*member as usize];
            self.nodes[index].children[lane] = if node.count > 0 {
                LEAF | node.first << 2 | (node.count - 1)
            } else {
                self.add(nodes, *member)
            };
        }
        index as u32
    }

    pub(super) fn query(&self, q: DVec3) -> Query {
        let moved = ((q - self.centre) * self.scale).clamp(DVec3::splat(-FAR), DVec3::splat(FAR));
        let p = moved.as_vec3();
        let rounding = ROUNDING * (1.0 + p.abs().max_element());
        let lanes = |p: glam::Vec3| p.to_array().map(Vec4::splat);
        Query {
            above: lanes(p + rounding),
            below: lanes(p - rounding),
        }
    }

    /// Boxes at a larger [`Wide::distances2`] hold nothing within `sqrt(distance2)`.
    #[inline]
    pub(super) fn limit(&self, distance2: f64) -> f32 {
        (distance2 * (self.scale * self.scale) * (1.0 + ROUNDING_SQUARED)) as f32
    }

    /// Lower bounds of the squared distances to the boxes of a node, in the
    /// hierarchy's own measure, and what the boxes hold, nearest last.
    #[inline]
    pub(super) fn near(
        &self,
        node: u32,
        query: &Query,
        limit: f32,
        stack: &mut [(f32, u32); STACK],
        top: &mut usize,
    ) {
        let four = &self.nodes[node as usize];
        let mut sum = Vec4::ZERO;
        for axis in 0..3 {
            let gap = (four.lo[axis] - query.above[axis])
                .max(query.below[axis] - four.hi[axis])
                .max(Vec4::ZERO);
            sum += gap * gap;
        }
        let start = *top;
        for (d2, child) in sum.to_array().into_iter().zip(four.children) {
            if child == NONE || d2 > limit {
                continue;
            }
            let mut at = *top;
            while at > start && stack[at - 1].0 < d2 {
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at] = (d2, child);
            *top += 1;
        }
    }
}

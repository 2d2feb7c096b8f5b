//! Nearest-triangle queries.

use glam::DVec3;

use super::{Bvh, DEPTH};

/// The nearest triangle to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Slot of the triangle ([`Bvh::triangle`], [`Bvh::original`]).
    pub slot: u32,
    /// Squared distance.
    pub distance2: f64,
}

impl Bvh {
    /// The nearest triangle strictly nearer than `sqrt(bound2)`; `None` if
    /// there is none.
    pub fn nearest(&self, q: DVec3, bound2: f64) -> Option<Nearest> {
        self.nearest_until(q, bound2, f64::NEG_INFINITY)
    }

    /// As [`Bvh::nearest`], but content with the first triangle whose squared
    /// distance is at most `enough2`.
    pub fn nearest_until(&self, q: DVec3, bound2: f64, enough2: f64) -> Option<Nearest> {
        let root = self.nodes.first()?;
        let mut best = Nearest {
            slot: u32::MAX,
            distance2: bound2,
        };
        let mut stack = [(0.0f64, 0u32); DEPTH];
        let mut top = 0;
        let mut at = 0u32;
        let mut reach = root.bounds.distance2(q);
        loop {
            if reach < best.distance2 {
                let node = &self.nodes[at as usize];
                if node.count == 0 {
                    let (left, right) = (at + 1, node.first);
                    let l = self.nodes[left as usize].bounds.distance2(q);
                    let r = self.nodes[right as usize].bounds.distance2(q);
                    let (near, far) = if l <= r {
                        ((l, left), (r, right))
                    } else {
                        ((r, right), (l, left))
                    };
                    if far.0 < best.distance2 {
                        stack[top] = far;
                        top += 1;
                    }
                    (reach, at) = near;
                    continue;
                }
                for slot in node.first..node.first + node.count {
                    let d2 = self.triangles[slot as usize].distance2(q);
                    if d2 < best.distance2 {
                        best = Nearest {
                            slot,
                            distance2: d2,
                        };
                        if d2 <= enough2 {
                            return Some(best);
                        }
                    }
                }
            }
            if top == 0 {
                break;
            }
            top -= 1;
            (reach, at) = stack[top];
        }
        (best.slot != u32::MAX).then_some(best)
    }

    /// Whether any triangle is within `radius` of `q` (closed ball).
    pub fn any_within(&self, q: DVec3, radius: f64) -> bool {
        let r2 = radius * radius;
        // The slightly larger bound makes the strict comparison of `nearest` closed.
        self.nearest_until(q, r2 * (1.0 + f64::EPSILON) + f64::MIN_POSITIVE, r2)
            .is_some()
    }
}

//! Nearest-triangle queries.

use glam::DVec3;

use super::wide::{Child, STACK};
use super::Bvh;

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
        if self.is_empty() {
            return None;
        }
        let mut best = Nearest {
            slot: u32::MAX,
            distance2: bound2,
        };
        let wide = &self.wide;
        let query = wide.query(q);
        let mut limit = wide.limit(bound2);
        let mut stack = [(0.0f32, 0u32); STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (reach, code) = stack[top];
            if reach > limit {
                continue;
            }
            match Child::from(code) {
                Child::Node(node) => wide.near(node, &query, limit, &mut stack, &mut top),
                Child::Triangles { first, count } => {
                    for slot in first..first + count {
                        let distance2 = self.triangles[slot as usize].distance2(q);
                        if distance2 < best.distance2 {
                            best = Nearest { slot, distance2 };
                            if distance2 <= enough2 {
                                return Some(best);
                            }
                            limit = wide.limit(distance2);
                        }
                    }
                }
            }
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

//! Which side of a closed surface a point is on, exactly.
//!
//! The winding number of the surface around q is the signed number of
//! triangles that an axis-parallel ray from q crosses. Whether the ray passes a
//! triangle is decided by `orient2d` in the projection along the ray, with q
//! moved by the infinitesimal (ε, ε²) so that a ray through a vertex or an edge
//! crosses exactly one of the triangles around it (simulation of simplicity,
//! Edelsbrunner & Mücke 1990); on which side of q by `orient3d`. No tolerance
//! and no retry is involved, so the answer is right for every finite input.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::{Bvh, DEPTH};
use crate::predicates::{orient2d, orient3d};

/// Where a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Winding number at least one.
    Inside,
    /// On a triangle.
    On,
    /// Anywhere else.
    Outside,
}

impl Bvh {
    /// On which side of the surface `q` lies. The surface must be closed and
    /// wound outward; inner shells wound inward are cavities, and shells that
    /// overlap count as their union.
    pub fn side(&self, q: DVec3) -> Side {
        match self.winding_number(q) {
            None => Side::On,
            Some(w) if w >= 1 => Side::Inside,
            Some(_) => Side::Outside,
        }
    }

    /// How often the closed surface goes around `q`; `None` if `q` lies on it.
    pub fn winding_number(&self, q: DVec3) -> Option<i32> {
        let bounds = self.bounds();
        if self.is_empty() || bounds.distance2(q) > 0.0 {
            return Some(0);
        }
        // The shortest way out crosses the fewest triangles.
        let (up, down) = (bounds.hi - q, q - bounds.lo);
        let mut best = (f64::INFINITY, 0, 1);
        for axis in 0..3 {
            for (way, sign) in [(up[axis], 1), (down[axis], -1)] {
                if way < best.0 {
                    best = (way, axis, sign);
                }
            }
        }
        self.winding(q, best.1, best.2)
    }

    /// Winding number around `q` by the ray along `direction` (±1) of `axis`;
    /// `None` if `q` lies on a triangle that the ray meets.
    fn winding(&self, q: DVec3, axis: usize, direction: i32) -> Option<i32> {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut winding = 0;
        let mut stack = [0u32; DEPTH];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let at = stack[top] as usize;
            let node = &self.nodes[at];
            let b = &node.bounds;
            let behind = if direction > 0 {
                b.hi[axis] < q[axis]
            } else {
                b.lo[axis] > q[axis]
            };
            if behind || q[u] < b.lo[u] || q[u] > b.hi[u] || q[v] < b.lo[v] || q[v] > b.hi[v] {
                continue;
            }
            if node.count == 0 {
                stack[top] = node.first;
                stack[top + 1] = at as u32 + 1;
                top += 2;
                continue;
            }
            for slot in node.first..node.first + node.count {
                let corners = self.triangles[slot as usize].corners();
                let turn = projected_turn(corners, q, u, v);
                if turn == 0 {
                    continue;
                }
                let [a, b, c] = corners;
                // Behind the triangle (against its normal), seen along the
                // axis, is below it if it turns counter-clockwise.
                let ahead = match orient3d(a, b, c, q) {
                    Ordering::Equal => return None,
                    Ordering::Less => turn,
                    Ordering::Greater => -turn,
                };
                if ahead == direction {
                    winding += turn * direction;
                }
            }
        }
        Some(winding)
    }
}

/// +1 or −1 if `q`, moved by (ε, ε²), lies in the projection of the triangle
/// that turns that way; 0 if it does not.
fn projected_turn(corners: [DVec3; 3], q: DVec3, u: usize, v: usize) -> i32 {
    let [a, b, c] = corners;
    for k in [u, v] {
        let least = a[k].min(b[k]).min(c[k]);
        let most = a[k].max(b[k]).max(c[k]);
        if q[k] < least || q[k] > most {
            return 0;
        }
    }
    let first = edge_side(a, b, q, u, v);
    if first == 0 || edge_side(b, c, q, u, v) != first || edge_side(c, a, q, u, v) != first {
        return 0;
    }
    first
}

/// The side of the moved `q` against the directed edge from `s` to `t`; zero
/// only for an edge that projects to a point.
fn edge_side(s: DVec3, t: DVec3, q: DVec3, u: usize, v: usize) -> i32 {
    let at = |p: DVec3| DVec2::new(p[u], p[v]);
    // The determinant at q, then its derivatives by q_u and by q_v.
    let side = orient2d(at(s), at(t), at(q))
        .then_with(|| order(s[v], t[v]))
        .then_with(|| order(t[u], s[u]));
    side as i32
}

/// Numeric order, in which the two zeros are equal.
fn order(x: f64, y: f64) -> Ordering {
    x.partial_cmp(&y).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;

    fn cube() -> Mesh {
        let vertices = (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
            .collect();
        Mesh {
            vertices,
            triangles,
        }
    }

    #[test]
    fn rays_through_vertices_and_edges_cross_once() {
        let bvh = Bvh::new(&cube());
        let steps: Vec<f64> = (-4..=12).map(|k| f64::from(k) / 8.0).collect();
        for &x in &steps {
            for &y in &steps {
                for &z in &steps {
                    let q = DVec3::new(x, y, z);
                    let strictly = |t: f64| t > 0.0 && t < 1.0;
                    let outside = |t: f64| !(0.0..=1.0).contains(&t);
                    for axis in 0..3 {
                        for direction in [-1, 1] {
                            let winding = bvh.winding(q, axis, direction);
                            if strictly(x) && strictly(y) && strictly(z) {
                                assert_eq!(winding, Some(1), "{q} {axis} {direction}");
                            } else if outside(x) || outside(y) || outside(z) {
                                assert_eq!(winding, Some(0), "{q} {axis} {direction}");
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn cavities_are_outside_and_overlaps_inside() {
        let outer = cube();
        let inner = cube();
        let n = outer.vertices.len() as u32;
        let mut hollow = outer.clone();
        hollow
            .vertices
            .extend(inner.vertices.iter().map(|v| (*v + 1.0) / 3.0));
        hollow.triangles.extend(
            inner
                .triangles
                .iter()
                .map(|t| [t[0] + n, t[2] + n, t[1] + n]),
        );
        let bvh = Bvh::new(&hollow);
        assert_eq!(bvh.side(DVec3::splat(0.5)), Side::Outside);
        assert_eq!(bvh.side(DVec3::splat(0.2)), Side::Inside);
        let mut twice = outer.clone();
        twice
            .vertices
            .extend(inner.vertices.iter().map(|v| *v + 0.5));
        twice
            .triangles
            .extend(inner.triangles.iter().map(|t| t.map(|i| i + n)));
        let bvh = Bvh::new(&twice);
        assert_eq!(bvh.side(DVec3::splat(0.75)), Side::Inside);
        assert_eq!(bvh.side(DVec3::splat(1.25)), Side::Inside);
        assert_eq!(bvh.side(DVec3::new(1.25, 1.25, 0.25)), Side::Outside);
    }
}

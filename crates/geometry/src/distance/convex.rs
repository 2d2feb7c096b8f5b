//! A convex polytope as vertices and half-spaces.

use std::cmp::Ordering;

use glam::DVec3;

use crate::bvh::Bounds;
use crate::predicates::orient3d;
use crate::Mesh;

/// Facets with a smaller ratio of height to length get their offset from all
/// vertices: their normal is too uncertain for the short way.
const SLIVER: f64 = 1e-4;

/// A half-space `normal · x <= offset`, `normal` of unit length, which holds
/// the whole body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Outward unit normal.
    pub normal: DVec3,
    /// Largest value of `normal · x` on the body, rounded up.
    pub offset: f64,
}

/// A convex polytope prepared for containment and cutting: the convex hull of
/// `mesh`'s vertices, which must be the corners of an outward-wound, exactly
/// convex, closed surface such as `hull::convex_hull` returns.
#[derive(Clone, Debug)]
pub struct ConvexBody<'a> {
    mesh: &'a Mesh,
    half_spaces: Vec<HalfSpace>,
    centre: DVec3,
    bounds: Bounds,
}

impl<'a> ConvexBody<'a> {
    /// Prepare `mesh`.
    pub fn new(mesh: &'a Mesh) -> ConvexBody<'a> {
        let bounds = Bounds::around(mesh.vertices.iter().copied());
        let centre = mesh.vertices.iter().sum::<DVec3>() / (mesh.vertices.len().max(1) as f64);
        let diagonal = bounds.diagonal();
        let magnitude = bounds.lo.abs().max(bounds.hi.abs()).max_element();
        let mut half_spaces: Vec<HalfSpace> = Vec::with_capacity(mesh.triangles.len());
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let (ab, ac) = (b - a, c - a);
            let cross = ab.cross(ac);
            let area = cross.length();
            if area == 0.0 {
                continue;
            }
            let normal = cross / area;
            // The computed normal differs from the facet's by at most about
            // 8 eps |ab||ac| / area; over the body's diagonal that lifts a
            // vertex by at most `tilt` above the plane through `a`.
            let condition = ab.length() * ac.length() / area;
            let longest2 = ab
                .length_squared()
                .max(ac.length_squared())
                .max((c - b).length_squared());
            let rounding = 8.0 * f64::EPSILON * magnitude;
            let offset = if area >= SLIVER * longest2 {
                let tilt = 16.0 * f64::EPSILON * condition * diagonal;
                normal.dot(a).max(normal.dot(b)).max(normal.dot(c)) + tilt + rounding
            } else {
                mesh.vertices
                    .iter()
                    .fold(f64::NEG_INFINITY, |o, v| o.max(normal.dot(*v)))
                    + rounding
            };
            let space = HalfSpace { normal, offset };
            // A polygonal facet is a fan of coplanar triangles next to each other.
            if half_spaces.last().is_none_or(|last| last.normal != normal) {
                half_spaces.push(space);
            }
        }
        ConvexBody {
            mesh,
            half_spaces,
            centre,
            bounds,
        }
    }

    /// The surface.
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// Half-spaces whose intersection holds the body.
    pub fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces
    }

    /// Mean of the vertices: a point of the body.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Bounding box.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether `q` belongs to the closed body, exactly.
    pub fn contains(&self, q: DVec3) -> bool {
        self.bounds.distance2(q) == 0.0
            && (0..self.mesh.triangles.len()).all(|t| {
                let [a, b, c] = self.mesh.corners(t);
                orient3d(a, b, c, q) != Ordering::Greater
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;
    use crate::sample::Random;

    #[test]
    fn half_spaces_hold_every_vertex_and_little_more() {
        let mut random = Random::new(2);
        for k in 0..60 {
            let flat = 0.1f64.powi(k % 12);
            let offset = DVec3::splat(if k % 3 == 0 { 1e4 } else { 0.0 });
            let points: Vec<DVec3> = (0..40)
                .map(|_| {
                    let mut next = || random.unit() * 2.0 - 1.0;
                    DVec3::new(next(), next(), next() * flat) + offset
                })
                .collect();
            let hull = convex_hull(&points).unwrap();
            let body = ConvexBody::new(&hull);
            let size = 1e-9 + 1e-12 * offset.length();
            for space in body.half_spaces() {
                let most = hull
                    .vertices
                    .iter()
                    .fold(f64::NEG_INFINITY, |m, v| m.max(space.normal.dot(*v)));
                assert!(most <= space.offset && space.offset <= most + size);
            }
            assert!(hull.vertices.iter().all(|v| body.contains(*v)));
            for v in &hull.vertices {
                assert!(!body.contains(*v + (*v - body.centre()) * 1e-6));
            }
        }
    }
}

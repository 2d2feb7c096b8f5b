//! The proof that a polytope is inside a solid, by exact predicates.

use std::cmp::Ordering;

use assetpipe_geometry::bvh::{Bounds, Side};
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::predicates::{collinear, orient3d};
use assetpipe_geometry::Mesh;
use glam::DVec3;

/// Whether the convex polytope `polytope`, as its floating-point vertices
/// stand, is wholly inside the closed solid. Exact; `false` also where that
/// is not shown.
///
/// Its interior is connected, so it is inside if one of its points is and no
/// triangle of the surface meets it. A triangle misses the interior exactly
/// if a plane separates the two, and then one does that is spanned by a face
/// of the polytope, by the triangle, or by an edge of one and a corner of the
/// other: all of them are tried with `orient3d`. `polytope` must be the output
/// of [`convex_hull`](assetpipe_geometry::hull::convex_hull).
pub fn is_inside(solid: &SolidIndex, polytope: &Mesh) -> bool {
    let centre = polytope.vertices.iter().sum::<DVec3>() / polytope.vertices.len() as f64;
    let holds_centre = polytope
        .faces()
        .all(|[a, b, c]| orient3d(a, b, c, centre).is_lt());
    if !holds_centre || solid.bvh().side(centre) != Side::Inside {
        return false;
    }
    let bounds = Bounds::around(polytope.vertices.iter().copied());
    let overlaps = |b: &Bounds| b.lo.cmple(bounds.hi).all() && b.hi.cmpge(bounds.lo).all();
    let mut free = true;
    let mut last = 0;
    solid.bvh().for_each(
        |b| overlaps(b) && !face_separates_box(polytope, b),
        |slot| {
            free = misses(polytope, solid.bvh().triangle(slot).corners(), &mut last);
            free
        },
    );
    free
}

/// Whether a face's plane has a box on its outer side, with room for rounding.
fn face_separates_box(polytope: &Mesh, bounds: &Bounds) -> bool {
    let (centre, half) = (bounds.centre(), 0.5 * (bounds.hi - bounds.lo));
    polytope.faces().any(|[a, b, c]| {
        let normal = (b - a).cross(c - a);
        let reach = normal.abs().dot(half);
        let height = normal.dot(centre - a);
        let size = normal.abs().dot((centre - a).abs()) + reach;
        height - reach > 1e-12 * size
    })
}

/// Whether the interior of a polytope misses a triangle. `last` is the face
/// that separated the triangle before: most likely this one too.
fn misses(polytope: &Mesh, triangle: [DVec3; 3], last: &mut usize) -> bool {
    let count = polytope.triangles.len();
    for k in 0..count {
        let face = (*last + k) % count;
        let [a, b, c] = polytope.corners(face);
        if triangle.iter().all(|&p| !orient3d(a, b, c, p).is_lt()) {
            *last = face;
            return true;
        }
    }
    if separates(triangle, &polytope.vertices, &[]) {
        return true;
    }
    let edges = |[a, b, c]: [DVec3; 3]| [(a, b), (b, c), (c, a)];
    for (u, v) in polytope.faces().flat_map(edges) {
        for w in triangle {
            if separates([u, v, w], &polytope.vertices, &triangle) {
                return true;
            }
        }
    }
    for (u, v) in edges(triangle) {
        for &w in &polytope.vertices {
            if separates([u, v, w], &polytope.vertices, &triangle) {
                return true;
            }
        }
    }
    false
}

/// Whether the plane through three points has all of `these` on one closed
/// side and all of `those` on the other.
fn separates(plane: [DVec3; 3], these: &[DVec3], those: &[DVec3]) -> bool {
    let [a, b, c] = plane;
    if collinear(a, b, c) {
        return false;
    }
    let all =
        |points: &[DVec3], wrong: Ordering| points.iter().all(|&p| orient3d(a, b, c, p) != wrong);
    (all(these, Ordering::Greater) && all(those, Ordering::Less))
        || (all(these, Ordering::Less) && all(those, Ordering::Greater))
}

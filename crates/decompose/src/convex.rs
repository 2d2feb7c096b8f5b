//! Surfaces that are convex already.

use std::cmp::Ordering;

use assetpipe_geometry::predicates::{orient2d, orient3d};
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::edges::{by_edge, half_edges, opposite};
use crate::merge::volume;

/// Whether a mesh has as many vertices and faces as a sphere all vertices of which are
/// used (Euler).
pub fn is_like_a_sphere(mesh: &Mesh) -> bool {
    mesh.triangles.len() >= 4 && 2 * mesh.vertices.len() == mesh.triangles.len() + 4
}

/// Whether a mesh is the boundary of its own hull, every vertex a corner and every
/// edge strictly convex, found without a hull by exact predicates. `false` also when it
/// is not clear: flat edges are left to [`is_convex`].
///
/// If every triangle faces away from one point and a ray from there meets one
/// triangle, the surface is seen from there as a sphere is, once all over; a
/// star-shaped body whose every edge is convex is convex (Tietze and Nakajima).
pub fn is_strictly_convex(mesh: &Mesh) -> bool {
    if !is_like_a_sphere(mesh) {
        return false;
    }
    let centre = mesh.vertices.iter().sum::<DVec3>() / mesh.vertices.len() as f64;
    let below = |[a, b, c]: [DVec3; 3], p: DVec3| orient3d(a, b, c, p) == below();
    let mut met = 0;
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        if !below(corners, centre) {
            return false;
        }
        let [a, b, c] = corners.map(DVec3::truncate);
        let q = centre.truncate();
        let sides = [orient2d(a, b, q), orient2d(b, c, q), orient2d(c, a, q)];
        if sides.iter().all(|s| *s == Ordering::Greater) {
            met += 1;
        } else if sides.iter().all(|s| *s != Ordering::Less) {
            return false;
        }
    }
    let edges = half_edges(mesh);
    met == 1
        && by_edge(&edges).all(|run| {
            run.len() == 2
                && run[0].3 != run[1].3
                && opposite(mesh, &run[1])
                    .is_some_and(|v| below(mesh.corners(run[0].2 as usize), v))
        })
}

/// Whether a closed mesh is exactly convex, given its hull: a single surface
/// whose every edge is convex or flat by exact predicates, and which does not
/// wind around more than once (its volume is its hull's).
pub fn is_convex(mesh: &Mesh, hull: &Mesh) -> bool {
    let whole = volume(hull);
    if (volume(mesh) - whole).abs() > 1e-9 * whole {
        return false;
    }
    let edges = half_edges(mesh);
    let mut runs = by_edge(&edges);
    runs.all(|run| {
        if run.len() != 2 {
            return false;
        }
        let [a, b, c] = mesh.corners(run[0].2 as usize);
        opposite(mesh, &run[1]).is_some_and(|v| below_or_on(orient3d(a, b, c, v)))
    })
}

/// `orient3d` of a counter-clockwise outward triangle and a point.
fn below_or_on(orientation: Ordering) -> bool {
    orientation != above()
}

/// What `orient3d` answers for a point above a counter-clockwise triangle.
fn above() -> Ordering {
    orient3d(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z)
}

/// What it answers for a point below.
fn below() -> Ordering {
    above().reverse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edges::check_closed;
    use assetpipe_geometry::hull::convex_hull;
    use assetpipe_geometry::sample::Random;

    fn cube() -> Vec<DVec3> {
        (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect()
    }

    #[test]
    fn a_cube_is_convex_and_a_dented_one_is_not() {
        let hull = convex_hull(&cube()).unwrap();
        assert!(is_convex(&hull, &hull));
        let mut dented = hull.clone();
        dented.vertices[0] = DVec3::splat(0.1);
        assert!(!is_convex(&dented, &convex_hull(&dented.vertices).unwrap()));
    }

    fn round(n: usize) -> Mesh {
        let mut random = Random::new(5);
        let points: Vec<DVec3> = (0..n).map(|_| random.on_sphere()).collect();
        convex_hull(&points).unwrap()
    }

    #[test]
    fn strictly_convex_without_a_hull() {
        assert!(is_strictly_convex(&round(4)));
        for n in [50, 200] {
            let ball = round(n);
            assert!(is_strictly_convex(&ball));
            // Each flaw by itself.
            let mut dented = ball.clone();
            dented.vertices[1] *= 0.3;
            assert!(!is_strictly_convex(&dented));
            let mut open = ball.clone();
            open.triangles.pop();
            assert!(!is_strictly_convex(&open));
            let mut flipped = ball.clone();
            for t in &mut flipped.triangles {
                t.swap(0, 1);
            }
            assert!(!is_strictly_convex(&flipped));
            let mut unused = ball.clone();
            unused.vertices.push(DVec3::ZERO);
            assert!(!is_strictly_convex(&unused));
            let mut twice = ball.clone();
            let n = ball.vertices.len() as u32;
            twice
                .vertices
                .extend(ball.vertices.iter().map(|v| *v * 2.0));
            twice
                .triangles
                .extend(ball.triangles.iter().map(|t| t.map(|i| i + n)));
            assert!(!is_strictly_convex(&twice));
        }
        // Flat edges: not for this way of looking.
        assert!(!is_strictly_convex(&convex_hull(&cube()).unwrap()));
    }

    #[test]
    fn a_double_cone_that_winds_twice_is_not_convex() {
        // Five points around an axis, taken in steps of two: closed, every edge convex,
        // every face seen from the middle, and the surface covers it twice.
        let mut mesh = Mesh::default();
        for k in 0..5 {
            let turn = std::f64::consts::TAU * 2.0 * f64::from(k) / 5.0;
            mesh.vertices
                .push(DVec3::new(libm::cos(turn), libm::sin(turn), 0.0));
        }
        // Off the axis, so that the ray from the middle meets no corner.
        mesh.vertices.push(DVec3::new(0.1, 0.07, 1.0));
        mesh.vertices.push(DVec3::new(-0.05, 0.02, -1.0));
        for k in 0..5 {
            mesh.triangles.push([k, (k + 1) % 5, 5]);
            mesh.triangles.push([(k + 1) % 5, k, 6]);
        }
        assert!(check_closed(&mesh).is_ok());
        assert!(!is_strictly_convex(&mesh));
        assert!(!is_convex(&mesh, &convex_hull(&mesh.vertices).unwrap()));
    }
}

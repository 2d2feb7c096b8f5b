//! Points on surfaces.

use glam::DVec3;

use super::Random;
use crate::mesh::Mesh;

/// A point on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is, up to rounding in its triangle's plane.
    pub position: DVec3,
    /// The triangle it is on.
    pub triangle: usize,
}

/// `count` points on the surface, uniform by area and stratified: every
/// stretch of the surface with a share of 1/`count` of the area (in the order
/// of triangles) gets one point. None if the area is zero or not finite.
///
/// In a triangle the point is uniform by the square-root law (Turk,
/// *Generating random points in triangles*, Graphics Gems, 1990).
pub fn surface(mesh: &Mesh, count: usize, seed: u64) -> Vec<SurfacePoint> {
    let mut total = 0.0;
    let cumulative: Vec<f64> = mesh
        .faces()
        .map(|[a, b, c]| {
            total += (b - a).cross(c - a).length();
            total
        })
        .collect();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let mut random = Random::new(seed);
    (0..count)
        .map(|i| {
            let wanted = total * ((i as f64 + random.unit()) / count as f64);
            let triangle = cumulative
                .partition_point(|sum| *sum <= wanted)
                .min(cumulative.len() - 1);
            let [a, b, c] = mesh.corners(triangle);
            let (s, t) = (random.unit().sqrt(), random.unit());
            SurfacePoint {
                position: a * (1.0 - s) + b * (s * (1.0 - t)) + c * (s * t),
                triangle,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        // A large triangle, one without area, a small one.
        Mesh {
            vertices: vec![
                DVec3::ZERO,
                3.0 * DVec3::X,
                3.0 * DVec3::Y,
                DVec3::Z,
                DVec3::X,
                DVec3::Y,
            ],
            triangles: vec![[0, 1, 2], [0, 1, 4], [0, 4, 5]],
        }
    }

    #[test]
    fn shares_follow_the_area() {
        let points = surface(&mesh(), 1000, 3);
        let on = |t: usize| points.iter().filter(|p| p.triangle == t).count();
        assert_eq!((on(0), on(1), on(2)), (900, 0, 100));
        let mean = points[..900].iter().map(|p| p.position).sum::<DVec3>() / 900.0;
        assert!((mean - DVec3::new(1.0, 1.0, 0.0)).length() < 0.1, "{mean}");
        assert!(points.iter().all(|p| p.position.min_element() >= 0.0));
    }

    #[test]
    fn a_seed_is_a_sample() {
        assert_eq!(surface(&mesh(), 50, 7), surface(&mesh(), 50, 7));
        assert_ne!(surface(&mesh(), 50, 7), surface(&mesh(), 50, 8));
        assert!(surface(&Mesh::default(), 5, 1).is_empty());
    }
}

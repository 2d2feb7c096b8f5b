//! Where bodies grow: points of the surface and the balls that touch it there.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::sample::surface;
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

/// A point of the surface with the largest ball inside that touches it there.
#[derive(Clone, Copy, Debug)]
pub struct Seed {
    /// On the surface.
    pub point: DVec3,
    /// The ball's centre, on the medial axis.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

/// Seeds on the surface, uniform by area, deepest first.
pub fn seeds(mesh: &Mesh, solid: &SolidIndex, count: usize) -> Vec<Seed> {
    let points = surface(mesh, count, 0);
    let mut found: Vec<Seed> = points
        .par_iter()
        .filter_map(|p| {
            let [a, b, c] = mesh.corners(p.triangle);
            let inward = -(b - a).cross(c - a).normalize_or_zero();
            let (centre, radius) = shrink(solid, p.position, inward)?;
            Some(Seed {
                point: p.position,
                centre,
                radius,
            })
        })
        .collect();
    // Stable, so that equal depths stay in the order of the surface.
    found.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    found
}

/// The largest ball inside that touches the surface at `point` (Ma, Bae & Choi,
/// *3D medial axis point approximation using nearest neighbors and the normal
/// field*, 2012): start too large, shrink to the nearest surface until none is nearer.
fn shrink(solid: &SolidIndex, point: DVec3, inward: DVec3) -> Option<(DVec3, f64)> {
    if inward == DVec3::ZERO {
        return None;
    }
    let size = solid.bvh().bounds().diagonal();
    let mut radius = 0.5 * size;
    for _ in 0..100 {
        let centre = point + inward * radius;
        let nearest = solid.surface(centre)?;
        let touch = solid.bvh().triangle(nearest.slot).closest(centre);
        let away = touch - point;
        if away.length() <= solid.slack() {
            break;
        }
        let depth = 2.0 * away.dot(inward);
        let smaller = away.length_squared() / depth;
        radius = if depth <= 0.0 {
            0.5 * radius
        } else if smaller < radius * (1.0 - 1e-3) {
            smaller
        } else {
            break;
        };
        if radius < 1e-7 * size {
            return None;
        }
    }
    // A little inside the ball: its centre must be off the surface for certain.
    let centre = point + inward * radius;
    solid.contains(centre).then_some((centre, radius))
}

//! Samples of the space that no hull may contain: farther than ε from the
//! solid. They make the search foresee what the proof will reject; they never
//! accept anything.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::search::trial::Forbidden;

/// Samples on a grid of about `count` cells over the hull's bounding box.
pub fn sample(solid: &SolidIndex, hull: &Mesh, epsilon: f64, count: usize) -> Vec<Forbidden> {
    let Some(&first) = hull.vertices.first() else {
        return Vec::new();
    };
    let (lo, hi) = hull
        .vertices
        .iter()
        .fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let size = hi - lo;
    let cell = libm::cbrt(size.x * size.y * size.z / count as f64).max(size.max_element() * 1e-3);
    let number = (size / cell).ceil().max(DVec3::ONE);
    let step = size / number;
    let weight = step.x * step.y * step.z;
    let planes: Vec<(DVec3, f64)> = (0..hull.triangles.len())
        .map(|t| {
            let [a, b, c] = hull.corners(t);
            let n = (b - a).cross(c - a);
            (n, n.dot(a))
        })
        .collect();
    let mut samples = Vec::new();
    for i in 0..number.x as usize {
        for j in 0..number.y as usize {
            let x = lo.x + (i as f64 + 0.5) * step.x;
            let y = lo.y + (j as f64 + 0.5) * step.y;
            // The hull's part of this column.
            let (mut from, mut to) = (lo.z, hi.z);
            for &(n, offset) in &planes {
                let room = offset - n.x * x - n.y * y;
                if n.z > 0.0 {
                    to = to.min(room / n.z);
                } else if n.z < 0.0 {
                    from = from.max(room / n.z);
                } else if room < 0.0 {
                    to = f64::NEG_INFINITY;
                }
            }
            let mut k = ((from - lo.z) / step.z - 0.5).ceil().max(0.0);
            while k < number.z {
                let z = lo.z + (k + 0.5) * step.z;
                if z > to {
                    break;
                }
                let point = DVec3::new(x, y, z);
                // The distance is 1-Lipschitz: what holds here holds for a
                // stretch of the column.
                let distance = solid
                    .surface(point)
                    .map_or(f64::INFINITY, |n| n.distance2.sqrt());
                let (free, stretch) = if distance <= epsilon {
                    (false, epsilon - distance)
                } else if solid.contains(point) {
                    (false, distance)
                } else {
                    (true, distance - epsilon)
                };
                let skip = (stretch / step.z).floor().max(0.0);
                if free {
                    let mut s = 0.0;
                    while s <= skip && z + s * step.z <= to {
                        samples.push(Forbidden {
                            point: DVec3::new(x, y, z + s * step.z),
                            weight,
                        });
                        s += 1.0;
                    }
                }
                k += skip + 1.0;
            }
        }
    }
    samples
}

//! Samples of the space that no hull may contain: farther than ε from the
//! solid. They make the search foresee what the proof will reject; they never
//! accept anything.

use assetpipe_geometry::distance::{ConvexBody, SolidIndex};
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use crate::search::sweep::Forbidden;

/// What is equal but for so much is equal: samples on faces of the hull are inside, distances of
/// the tolerance are beyond it.
const EVEN: f64 = 1e-6;

/// Samples on a grid of about `count` cells over the hull's bounding box.
pub fn sample(solid: &SolidIndex, hull: &Mesh, epsilon: f64, count: usize) -> Vec<Forbidden> {
    let Some(&first) = hull.vertices.first() else {
        return Vec::new();
    };
    if solid.bvh().is_empty() {
        return Vec::new();
    }
    let (lo, hi) = hull
        .vertices
        .iter()
        .fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let size = hi - lo;
    let cell = libm::cbrt(size.x * size.y * size.z / count as f64).max(size.max_element() * 1e-3);
    let number = (size / cell - EVEN).ceil().max(DVec3::ONE);
    let grid = Grid {
        solid,
        epsilon: epsilon * (1.0 - EVEN),
        lo,
        hi,
        number,
        step: size / number,
        planes: ConvexBody::new(hull)
            .half_spaces()
            .iter()
            .map(|s| (s.normal, s.offset + EVEN))
            .collect(),
    };
    let layers: Vec<Vec<Forbidden>> = (0..number.x as usize)
        .into_par_iter()
        .map(|i| grid.layer(i))
        .collect();
    layers.concat()
}

/// Cells over a hull's bounding box.
struct Grid<'a> {
    solid: &'a SolidIndex,
    epsilon: f64,
    lo: DVec3,
    hi: DVec3,
    /// How many cells along each axis, whole numbers.
    number: DVec3,
    step: DVec3,
    /// Of the hull.
    planes: Vec<(DVec3, f64)>,
}

impl Grid<'_> {
    /// The samples of all columns with one x.
    fn layer(&self, i: usize) -> Vec<Forbidden> {
        let mut samples = Vec::new();
        let mut near = 0;
        let x = self.lo.x + (i as f64 + 0.5) * self.step.x;
        for j in 0..self.number.y as usize {
            let y = self.lo.y + (j as f64 + 0.5) * self.step.y;
            self.column(x, y, &mut near, &mut samples);
        }
        samples
    }

    /// Add the samples of one column. The search for the nearest triangle begins at `near`, the
    /// one of the point before.
    fn column(&self, x: f64, y: f64, near: &mut u32, samples: &mut Vec<Forbidden>) {
        let step = self.step.z;
        let weight = self.step.x * self.step.y * step;
        let (from, to) = self.inside(x, y);
        let mut k = ((from - self.lo.z) / step - 0.5).ceil().max(0.0);
        while k < self.number.z {
            let z = self.lo.z + (k + 0.5) * step;
            if z > to {
                break;
            }
            let point = DVec3::new(x, y, z);
            // The distance is 1-Lipschitz: what holds here holds for a
            // stretch of the column.
            let distance = self.distance(point, near);
            let (free, stretch) = if distance <= self.epsilon {
                (false, self.epsilon - distance)
            } else if self.solid.contains(point) {
                (false, distance)
            } else {
                (true, distance - self.epsilon)
            };
            let skip = (stretch / step).floor().max(0.0);
            if free {
                let mut s = 0.0;
                while s <= skip && z + s * step <= to {
                    samples.push(Forbidden {
                        point: DVec3::new(x, y, z + s * step),
                        weight,
                        depth: 0.0,
                    });
                    s += 1.0;
                }
            }
            k += skip + 1.0;
        }
    }

    /// Lowest and highest z of the hull's part of a column.
    fn inside(&self, x: f64, y: f64) -> (f64, f64) {
        let (mut from, mut to) = (self.lo.z, self.hi.z);
        for &(n, offset) in &self.planes {
            let room = offset - n.x * x - n.y * y;
            if n.z > 0.0 {
                to = to.min(room / n.z);
            } else if n.z < 0.0 {
                from = from.max(room / n.z);
            } else if room < 0.0 {
                to = f64::NEG_INFINITY;
            }
        }
        (from, to)
    }

    /// Distance to the surface.
    fn distance(&self, point: DVec3, near: &mut u32) -> f64 {
        let bvh = self.solid.bvh();
        let known = bvh.triangle(*near).distance2(point);
        let distance2 = bvh.nearest(point, known).map_or(known, |nearer| {
            *near = nearer.slot;
            nearer.distance2
        });
        distance2.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;
    use assetpipe_geometry::hull::convex_hull;
    use glam::DMat3;

    /// Where rounding put points of a side beside its plane, the hull has faces as high as that, whose
    /// normals are noise.
    #[test]
    fn faces_without_direction_hide_no_sample() {
        let grid = |i: u32| f64::from(i % 7) / 3.0 - 1.0;
        let side = (0..49).map(|i| (grid(i), grid(i / 7)));
        let points: Vec<DVec3> = side
            .flat_map(|(u, v)| [(u, v, -1.0), (u, v, 1.0), (u, -1.0, v), (u, 1.0, v)])
            .map(|(x, y, z)| DVec3::new(x, y, z))
            .collect();
        let solid = SolidIndex::new(&cuboid(DVec3::splat(-0.01), DVec3::splat(0.01)));
        for k in 0..30 {
            let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), f64::from(k));
            let turned: Vec<DVec3> = points.iter().map(|&p| turn * p).collect();
            let hull = convex_hull(&turned).unwrap();
            let samples = sample(&solid, &hull, 0.05, 2000);
            let weight: f64 = samples.iter().map(|s| s.weight).sum();
            assert!((weight - 8.0).abs() < 0.4, "{k}: {weight}");
        }
    }
}

//! Every epsilon of this crate, scaled by what it is compared with.
//!
//! Signs of orientation are exact and need none. What is left are positions
//! that had to be rounded and sums over them.

use glam::DVec3;

use crate::mesh::Mesh;

/// Bounds of rounding for coordinates of a given size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    magnitude: f64,
    extent: f64,
}

impl Rounding {
    /// For the used vertices of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let Some((low, high)) = crate::properties::bounds(mesh) else {
            return Self {
                magnitude: 0.0,
                extent: 0.0,
            };
        };
        Self::of_box(low, high)
    }

    /// For points in the box between two corners.
    pub fn of_box(low: DVec3, high: DVec3) -> Self {
        Self {
            magnitude: low.abs().max(high.abs()).max_element(),
            extent: (high - low).max_element(),
        }
    }

    /// The largest absolute coordinate.
    pub fn magnitude(&self) -> f64 {
        self.magnitude
    }

    /// How far a crossing point computed by [`clip::split`](crate::clip::split)
    /// may lie from its edge.
    ///
    /// Along the edge the point may slide as far as the cut is ill-posed; off
    /// the edge there are three roundings a coordinate (difference, product,
    /// sum), each of at most half an ulp of the largest coordinate or extent.
    pub fn crossing(&self) -> f64 {
        3.0 * f64::EPSILON * (self.magnitude + self.extent)
    }

    /// How much the computed volume of `mesh` may be off whose vertices are
    /// off by [`crossing`](Self::crossing). The computed volumes of the pieces
    /// of a cut add up to the solid's within the sum of the three bounds.
    ///
    /// Every vertex may lift the faces around it, and sums round once a term.
    /// Faces count with the product of their shorter edges, which is what the
    /// rounding of a cross product is relative to, and no narrower than a crossing.
    pub fn volume(&self, mesh: &Mesh) -> f64 {
        let narrowest = 2.0 * self.crossing();
        let spread: f64 = mesh
            .faces()
            .map(|[a, b, c]| {
                let mut lengths = [a.distance(b), b.distance(c), c.distance(a)];
                lengths.sort_by(f64::total_cmp);
                lengths[0].max(narrowest) * lengths[1].max(narrowest)
            })
            .sum();
        let terms = (mesh.triangles.len() as f64).sqrt();
        spread * (self.crossing() + terms * f64::EPSILON * self.extent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::split;
    use crate::hull::convex_hull;
    use crate::plane::Plane;
    use crate::properties::volume;
    use crate::sample::Random;

    /// The worst measured error must use the bounds: at most them, and not a
    /// two-hundredth of them.
    #[test]
    fn bounds_hold_and_are_not_empty_words() {
        let mut random = Random::new(31);
        let (mut worst_crossing, mut worst_volume) = (0f64, 0f64);
        for round in 0..200 {
            let shift = [0.0, 1.0, 100.0][round % 3];
            let points: Vec<DVec3> = (0..40).map(|_| random.in_cube() + shift).collect();
            let hull = convex_hull(&points).unwrap();
            let rounding = Rounding::of(&hull);
            let normal = random.on_sphere();
            let plane = Plane {
                normal,
                offset: normal.dot(DVec3::splat(shift)),
            };
            let parts = split(&hull, &plane).unwrap();
            let pieces = [parts.below, parts.above];
            let sum: f64 = pieces.iter().flatten().map(volume).sum();
            let bounds = [Some(&hull), pieces[0].as_ref(), pieces[1].as_ref()];
            let allowed: f64 = bounds
                .into_iter()
                .flatten()
                .map(|m| rounding.volume(m))
                .sum();
            worst_volume = worst_volume.max((sum - volume(&hull)).abs() / allowed);
            for piece in pieces.iter().flatten() {
                for &p in &piece.vertices {
                    if !hull.vertices.contains(&p) {
                        let off = hull
                            .faces()
                            .flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)])
                            .map(|(a, b)| distance_to_line(p, a, b))
                            .fold(f64::INFINITY, f64::min);
                        worst_crossing = worst_crossing.max(off / rounding.crossing());
                    }
                }
            }
        }
        assert!((0.01..=1.0).contains(&worst_crossing), "{worst_crossing}");
        assert!((0.005..=1.0).contains(&worst_volume), "{worst_volume}");
    }

    fn distance_to_line(p: DVec3, a: DVec3, b: DVec3) -> f64 {
        let direction = (b - a).normalize();
        (p - a).reject_from_normalized(direction).length()
    }
}

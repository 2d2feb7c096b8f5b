//! Distances from a hull, inside and outside.

use glam::DVec3;

use crate::distance::Triangle;
use crate::mesh::Mesh;

/// A hull's faces, ready to be asked.
pub(super) struct Faces {
    triangles: Vec<Triangle>,
    /// Unit normals and offsets.
    planes: Vec<(DVec3, f64)>,
}

impl Faces {
    pub(super) fn of(hull: &Mesh) -> Self {
        let planes = hull.faces().filter_map(|[a, b, c]| {
            let normal = (b - a).cross(c - a).try_normalize()?;
            let offset = normal.dot(a).max(normal.dot(b)).max(normal.dot(c));
            Some((normal, offset))
        });
        Self {
            planes: planes.collect(),
            triangles: hull.faces().map(Triangle::new).collect(),
        }
    }

    /// How far `p` is outside of the hull; inside, minus the least distance
    /// to a face's plane: the maximum over unit n of n · p − h(n).
    pub(super) fn signed_distance(&self, p: DVec3) -> f64 {
        let height = self
            .planes
            .iter()
            .map(|(normal, offset)| normal.dot(p) - offset)
            .fold(f64::NEG_INFINITY, f64::max);
        if height <= 0.0 {
            height
        } else {
            self.distance(p)
        }
    }

    /// How far `p` is from the hull's surface.
    fn distance(&self, p: DVec3) -> f64 {
        let squares = self.triangles.iter().map(|t| t.distance2(p));
        squares.fold(f64::INFINITY, f64::min).sqrt()
    }

    /// An upper bound, at most `accuracy` too large, of the largest signed
    /// distance over the circle `centre + u cos + v sin`. The distance is
    /// convex, so over an arc it is at most that of the arc's ends or of the
    /// point where the tangents at the ends meet; arcs are halved until that
    /// decides.
    pub(super) fn largest_on_circle(
        &self,
        centre: DVec3,
        u: DVec3,
        v: DVec3,
        accuracy: f64,
    ) -> f64 {
        let at = |turn: f64, scale: f64| {
            let angle = std::f64::consts::TAU * turn;
            let offset = u * libm::cos(angle) + v * libm::sin(angle);
            self.signed_distance(centre + offset * scale)
        };
        let tangents = |width: f64| 1.0 / libm::cos(std::f64::consts::PI * width);
        let ends = (0..8).map(|i| at((f64::from(i) + 0.5) / 8.0, 1.0));
        let mut lower = ends.fold(f64::NEG_INFINITY, f64::max);
        let mut upper = lower;
        let mut arcs: Vec<(f64, f64)> = (0..8).map(|i| (f64::from(i) / 8.0, 1.0 / 8.0)).collect();
        while let Some((middle, width)) = arcs.pop() {
            let bound = at(middle, tangents(width));
            // Narrower arcs differ from their tangents by rounding only.
            if bound <= lower + accuracy || width < 1e-8 {
                upper = upper.max(bound);
                continue;
            }
            lower = lower.max(at(middle, 1.0));
            arcs.extend([-0.25, 0.25].map(|side| (middle + side * width, width / 2.0)));
        }
        upper.max(lower)
    }
}

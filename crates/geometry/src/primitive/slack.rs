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

    /// An upper bound, at most `accuracy` too large, of the largest distance
    /// from the hull over the circle `centre + u cos + v sin`, by halving
    /// arcs: the distance changes by no more than one goes.
    pub(super) fn largest_on_circle(
        &self,
        centre: DVec3,
        u: DVec3,
        v: DVec3,
        accuracy: f64,
    ) -> f64 {
        let radius = u.length().max(v.length());
        let at = |turn: f64| {
            let angle = std::f64::consts::TAU * turn;
            let p = centre + u * libm::cos(angle) + v * libm::sin(angle);
            self.signed_distance(p)
        };
        let half_length = |width: f64| std::f64::consts::PI * radius * width;
        let first: Vec<(f64, f64)> = (0..16).map(|i| (f64::from(i) / 16.0, 1.0 / 16.0)).collect();
        let mut arcs: Vec<(f64, f64, f64)> = first
            .into_iter()
            .map(|(turn, width)| (turn, width, at(turn)))
            .collect();
        let mut lower = arcs
            .iter()
            .map(|arc| arc.2)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut upper = lower;
        while let Some((turn, width, value)) = arcs.pop() {
            let bound = value + half_length(width);
            if bound <= lower + accuracy || half_length(width) <= accuracy / 16.0 {
                upper = upper.max(bound);
                continue;
            }
            for side in [-0.25, 0.25] {
                let middle = turn + side * width;
                let value = at(middle);
                lower = lower.max(value);
                arcs.push((middle, width / 2.0, value));
            }
        }
        upper
    }
}

//! Point to triangle.

use glam::DVec3;

use crate::bvh::Bounds;

/// Below this ratio of height to length the region tests of the general case
/// lose their digits, and the edges are asked one by one as well.
const SLIVER: f64 = 1e-3;

/// A triangle, ready for distance queries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    a: DVec3,
    b: DVec3,
    c: DVec3,
    sliver: bool,
}

impl Triangle {
    /// From its corners.
    pub fn new(corners: [DVec3; 3]) -> Triangle {
        let [a, b, c] = corners;
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let longest2 = ab
            .length_squared()
            .max(ac.length_squared())
            .max(bc.length_squared());
        let sliver = ab.cross(ac).length_squared() <= (SLIVER * longest2) * (SLIVER * longest2);
        Triangle { a, b, c, sliver }
    }

    /// The corners.
    #[inline]
    pub fn corners(&self) -> [DVec3; 3] {
        [self.a, self.b, self.c]
    }

    /// Bounding box.
    #[inline]
    pub fn bounds(&self) -> Bounds {
        Bounds {
            lo: self.a.min(self.b).min(self.c),
            hi: self.a.max(self.b).max(self.c),
        }
    }

    /// Squared distance from `q`. Always the distance to a point *of* the
    /// triangle, so never below the true distance by more than rounding.
    #[inline]
    pub fn distance2(&self, q: DVec3) -> f64 {
        (self.closest(q) - q).length_squared()
    }

    /// Distance of `q` from the triangle's plane, good to about 1e-12 of its distance from the
    /// corners; 0 for a sliver, whose plane rounding may turn.
    #[inline]
    pub fn height(&self, q: DVec3) -> f64 {
        if self.sliver {
            return 0.0;
        }
        let normal = (self.b - self.a).cross(self.c - self.a);
        normal.dot(q - self.a).abs() / normal.length()
    }

    /// The point of the triangle nearest to `q` (Ericson 2005, §5.1.5).
    #[inline]
    pub fn closest(&self, q: DVec3) -> DVec3 {
        let p = self.closest_by_regions(q);
        if self.sliver {
            self.nearest_with_edges(q, p)
        } else {
            p
        }
    }

    #[inline]
    fn closest_by_regions(&self, q: DVec3) -> DVec3 {
        let (a, b, c) = (self.a, self.b, self.c);
        let (ab, ac, aq) = (b - a, c - a, q - a);
        let d1 = ab.dot(aq);
        let d2 = ac.dot(aq);
        if d1 <= 0.0 && d2 <= 0.0 {
            return a;
        }
        let bq = q - b;
        let d3 = ab.dot(bq);
        let d4 = ac.dot(bq);
        if d3 >= 0.0 && d4 <= d3 {
            return b;
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return a + ab * (d1 / (d1 - d3));
        }
        let cq = q - c;
        let d5 = ab.dot(cq);
        let d6 = ac.dot(cq);
        if d6 >= 0.0 && d5 <= d6 {
            return c;
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return a + ac * (d2 / (d2 - d6));
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && (d4 - d3) >= 0.0 && (d5 - d6) >= 0.0 {
            return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
        }
        let scale = 1.0 / (va + vb + vc);
        a + ab * (vb * scale) + ac * (vc * scale)
    }

    /// The foot of `q`, by its share of the longest edge and of the height over it, each
    /// drawn into the triangle: what it returns is of the triangle however thin that is.
    fn foot(&self, q: DVec3) -> DVec3 {
        let (a, b, c) = (self.a, self.b, self.c);
        let edges = [(a, b, c), (b, c, a), (c, a, b)];
        let length2 = |e: &(DVec3, DVec3, DVec3)| e.0.distance_squared(e.1);
        let (s, t, apex) = edges.into_iter().fold(edges[0], |best, e| {
            if length2(&e) > length2(&best) {
                e
            } else {
                best
            }
        });
        let along = t - s;
        let share = |p: DVec3| along.dot(p - s) / along.length_squared();
        let top = share(apex);
        let height = apex - s - along * top;
        let up = (q - s - along * share(q)).dot(height) / height.length_squared();
        let up = up.clamp(0.0, 1.0);
        // Without area this is 0/0, and NaN loses.
        s + along * share(q).max(top * up).min(1.0 - (1.0 - top) * up) + height * up
    }

    #[cold]
    fn nearest_with_edges(&self, q: DVec3, first: DVec3) -> DVec3 {
        let mut best = (f64::INFINITY, self.a);
        let edges = [(self.a, self.b), (self.b, self.c), (self.c, self.a)];
        let on_edges = edges.map(|(s, t)| closest_on_segment(s, t, q));
        for p in on_edges.into_iter().chain([first, self.foot(q)]) {
            let d2 = (p - q).length_squared();
            // A triangle without area gives 0/0 in the general case; NaN loses here.
            if d2 < best.0 {
                best = (d2, p);
            }
        }
        best.1
    }
}

fn closest_on_segment(s: DVec3, t: DVec3, q: DVec3) -> DVec3 {
    let st = t - s;
    let length2 = st.length_squared();
    if length2 == 0.0 {
        return s;
    }
    s + st * (st.dot(q - s) / length2).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Random;

    /// The least over a fine grid of the triangle.
    fn on_grid(corners: [DVec3; 3], q: DVec3) -> f64 {
        const STEPS: usize = 200;
        let [a, b, c] = corners;
        let mut least = f64::INFINITY;
        for i in 0..=STEPS {
            for j in 0..=STEPS - i {
                let (u, v) = (i as f64 / STEPS as f64, j as f64 / STEPS as f64);
                least = least.min((a + (b - a) * u + (c - a) * v).distance_squared(q));
            }
        }
        least.sqrt()
    }

    #[test]
    fn as_near_as_a_fine_grid() {
        let mut random = Random::new(1);
        let mut point = move || {
            let mut next = || random.unit() * 2.0 - 1.0;
            DVec3::new(next(), next(), next())
        };
        for k in 0..200 {
            let (a, mut b, mut c) = (point(), point(), point());
            if k % 2 == 0 {
                // A sliver, down to a few ulps wide.
                let width = 0.1f64.powi(k % 17);
                c = a + (b - a) * 0.3 + (c - a) * width;
            }
            if k % 20 == 0 {
                b = a;
            }
            let q = point() * 2.0;
            let triangle = Triangle::new([a, b, c]);
            let found = triangle.distance2(q).sqrt();
            let grid = on_grid([a, b, c], q);
            assert!(found <= grid + 1e-12, "{k} {found} {grid}");
            assert!(grid - found <= 2e-2, "{k} {found} {grid}");
            let p = triangle.closest(q);
            assert!(on_grid([a, b, c], p) <= 2e-2);
        }
    }

    #[test]
    fn corners_edges_and_inside() {
        let triangle = Triangle::new([DVec3::ZERO, DVec3::X, DVec3::Y]);
        for (q, expected) in [
            (DVec3::new(-1.0, -1.0, 0.0), DVec3::ZERO),
            (DVec3::new(2.0, -1.0, 5.0), DVec3::X),
            (DVec3::new(0.25, 0.25, 3.0), DVec3::new(0.25, 0.25, 0.0)),
            (DVec3::new(0.5, -2.0, 0.0), DVec3::new(0.5, 0.0, 0.0)),
            (DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.5, 0.5, 0.0)),
        ] {
            assert_eq!(triangle.closest(q), expected);
        }
    }
}

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::{collinear, incircle, orient2d, orient3d, side, wide};
use crate::plane::Plane;
use crate::sample::Random;

/// Coordinates near a small grid.
struct Near(Random);

impl Near {
    /// A coordinate near a small grid, so that degenerate cases abound.
    fn coordinate(&mut self, scale: f64) -> f64 {
        let base = f64::from(self.0.below(5)) - 2.0;
        let nudge = match self.0.below(12) {
            0 => f64::EPSILON * (f64::from(self.0.below(5)) - 2.0),
            _ => 0.0,
        };
        (base / 3.0 + nudge) * scale
    }

    fn point(&mut self, scale: f64) -> DVec3 {
        DVec3::new(
            self.coordinate(scale),
            self.coordinate(scale),
            self.coordinate(scale),
        )
    }
}

#[test]
fn filters_and_expansions_agree_with_integers_near_degeneracy() {
    let mut random = Near(Random::new(7));
    let mut zeros = 0;
    for _ in 0..20_000 {
        let [a, b, c, d] = [(); 4].map(|()| random.point(1.0));
        let expected = wide::orient3d(a, b, c, d);
        zeros += usize::from(expected.is_eq());
        assert_eq!(orient3d(a, b, c, d), expected, "{a:?} {b:?} {c:?} {d:?}");
        let [p, q, r] = [a, b, c].map(|v| DVec2::new(v.x, v.y));
        assert_eq!(orient2d(p, q, r), wide::orient2d(p, q, r));
        let s = DVec2::new(d.x, d.y);
        assert_eq!(incircle(p, q, r, s), wide::incircle(p, q, r, s));
        let plane = Plane {
            normal: a,
            offset: a.dot(b) + (c.x - d.x) * f64::EPSILON,
        };
        assert_eq!(side(&plane, b), wide::side(&plane, b), "{plane:?} {b:?}");
    }
    assert!(
        zeros > 1000,
        "the grid must produce exact degeneracies, found {zeros}"
    );
}

#[test]
fn signs_do_not_depend_on_scale_even_where_products_overflow_or_vanish() {
    for exponent in [-900, -600, -300, -60, 0, 60, 300, 600, 1000] {
        let scale = 2f64.powi(exponent);
        let mut random = Near(Random::new(11));
        for _ in 0..400 {
            let [a, b, c, d] = [(); 4].map(|()| random.point(1.0));
            let expected = orient3d(a, b, c, d);
            let scaled = orient3d(a * scale, b * scale, c * scale, d * scale);
            assert_eq!(scaled, expected, "scale 2^{exponent}");
            let flat = [a, b, c, d].map(|p| DVec2::new(p.x, p.y));
            let [p, q, r, s] = flat.map(|p| p * scale);
            let circle = incircle(flat[0], flat[1], flat[2], flat[3]);
            assert_eq!(incircle(p, q, r, s), circle, "scale 2^{exponent}");
            let plane = Plane {
                normal: a,
                offset: a.dot(b),
            };
            let larger = Plane {
                normal: a,
                offset: plane.offset * scale,
            };
            assert_eq!(
                side(&larger, b * scale),
                side(&plane, b),
                "scale 2^{exponent}"
            );
        }
    }
}

#[test]
fn an_outward_triangle_sees_outer_points_as_greater() {
    let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::Y);
    assert_eq!(orient3d(a, b, c, DVec3::Z), Ordering::Greater);
    assert_eq!(orient3d(a, b, c, -DVec3::Z), Ordering::Less);
    assert_eq!(
        orient3d(a, b, c, DVec3::new(5.0, -3.0, 0.0)),
        Ordering::Equal
    );
    assert_eq!(
        orient3d(a, b, c, DVec3::new(5.0, -3.0, f64::MIN_POSITIVE)),
        Ordering::Greater
    );
}

#[test]
fn an_axis_plane_is_a_plain_comparison() {
    let next_up = 0.1f64.next_up();
    for (normal, flip) in [(DVec3::X, false), (-DVec3::X, true)] {
        let plane = Plane {
            normal,
            offset: if flip { -0.1 } else { 0.1 },
        };
        let sides = [0.1f64.next_down(), 0.1, next_up].map(|x| {
            let sign = side(&plane, DVec3::new(x, 1e300, -1e300));
            if flip {
                sign.reverse()
            } else {
                sign
            }
        });
        assert_eq!(sides, [Ordering::Less, Ordering::Equal, Ordering::Greater]);
    }
}

#[test]
fn collinear_points_are_recognised_exactly() {
    let a = DVec3::new(1.0, 2.0, 3.0);
    let step = DVec3::new(0.25, -0.5, 0.125);
    assert!(collinear(a, a + step, a + 5.0 * step));
    assert!(collinear(a, a, step));
    let off = DVec3::new(a.x, a.y.next_up(), a.z);
    assert!(!collinear(off, a + step, a + 5.0 * step));
}

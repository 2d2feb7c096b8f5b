use assetpipe_geometry::bvh::Bounds;
use assetpipe_geometry::distance::{ConvexBody, SolidIndex, Triangle};
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::{DVec3, Mesh};

use super::*;
use crate::shapes;

const CLOSE: Gap = Gap {
    relative: 0.005,
    absolute: 0.0,
};

fn hull_of(mesh: &Mesh) -> Mesh {
    convex_hull(&mesh.vertices).unwrap()
}

fn measure(mesh: &Mesh) -> Interval {
    bounds(
        &SolidIndex::new(mesh),
        &hull_of(mesh),
        CLOSE,
        &Limits::default(),
    )
}

/// Every way a mesh may lie in space, with the factor on its lengths.
fn placements(mesh: &Mesh) -> Vec<(Mesh, f64)> {
    let far = DVec3::new(1000.0, -700.0, 300.0);
    vec![
        (mesh.clone(), 1.0),
        (shapes::turned(mesh), 1.0),
        (
            shapes::placed(&shapes::turned(mesh), 1e-3, DVec3::ZERO),
            1e-3,
        ),
        (shapes::placed(&shapes::turned(mesh), 1e3, DVec3::ZERO), 1e3),
        (shapes::placed(mesh, 1.0, far), 1.0),
        (shapes::placed(&shapes::turned(mesh), 0.1, far), 0.1),
    ]
}

fn assert_value(mesh: &Mesh, expected: f64) {
    for (placed, scale) in placements(mesh) {
        let interval = measure(&placed);
        let truth = expected * scale;
        assert!(interval.holds(truth), "{interval:?} {truth}");
        assert!(
            interval.upper <= interval.lower * 1.005 + 1e-7 * scale,
            "{interval:?}"
        );
    }
}

#[test]
fn corner_of_an_ell() {
    assert_value(&shapes::ell(), 0.5);
}

#[test]
fn middle_of_a_hole() {
    assert_value(&shapes::plate_with_hole(0.75), 0.75);
    assert_value(&shapes::plate_with_hole(0.05), 0.05);
}

#[test]
fn centre_of_a_void() {
    // The void's octahedron has its centre 1/2/√3 away from every face.
    let inner = shapes::placed(&shapes::reversed(&shapes::ball(0)), 0.5, DVec3::ZERO);
    let hollow = shapes::both(&shapes::ball(3), &inner);
    assert_value(&hollow, 0.5 / 3.0f64.sqrt());
}

#[test]
fn a_convex_solid_has_none() {
    for mesh in [
        shapes::cuboid(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.1)),
        shapes::ball(3),
    ] {
        for (placed, scale) in placements(&mesh) {
            let interval = measure(&placed);
            assert_eq!(interval.lower, 0.0);
            assert!(
                interval.upper <= 1e-7 * scale,
                "{interval:?} {scale} {}",
                placed.vertices[0]
            );
        }
    }
}

#[test]
fn slot_between_two_walls() {
    // The farthest points fill a whole plane in the middle of the slot.
    let wall = |x: f64| shapes::cuboid(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 0.1, 3.0, 2.0));
    assert_value(&shapes::both(&wall(0.0), &wall(0.5)), 0.2);
}

/// The largest distance among points of a grid over the hull, by looking at
/// every triangle and adding up solid angles.
fn sampled(solid: &Mesh, hull: &Mesh, steps: usize) -> f64 {
    let body = ConvexBody::new(hull);
    let Bounds { lo, hi } = body.bounds();
    let mut most = 0.0f64;
    for k in 0..steps * steps * steps {
        let cell = DVec3::new(
            (k % steps) as f64,
            (k / steps % steps) as f64,
            (k / steps / steps) as f64,
        );
        let q = lo + (hi - lo) * (cell + 0.37) / steps as f64;
        if body.contains(q) && solid_angle(solid, q) < std::f64::consts::TAU {
            let nearest = (0..solid.triangles.len())
                .map(|t| Triangle::new(solid.corners(t)).distance2(q))
                .fold(f64::INFINITY, f64::min);
            most = most.max(nearest.sqrt());
        }
    }
    most
}

/// 4π inside, 0 outside (Van Oosterom & Strackee 1983).
fn solid_angle(solid: &Mesh, q: DVec3) -> f64 {
    (0..solid.triangles.len())
        .map(|t| {
            let [a, b, c] = solid.corners(t).map(|v| v - q);
            let (x, y, z) = (a.length(), b.length(), c.length());
            let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            2.0 * libm::atan2(a.dot(b.cross(c)), below)
        })
        .sum()
}

#[test]
fn never_below_a_dense_sample() {
    let opening = shapes::plate_with_hole(1.9);
    let shell = {
        // A ball whose void reaches the outside through one missing face pair.
        let mut shell = shapes::both(
            &shapes::ball(2),
            &shapes::placed(&shapes::reversed(&shapes::ball(2)), 0.9, DVec3::ZERO),
        );
        let outer = shell.triangles[0];
        let n = shell.triangles.len() / 2;
        let inner = shell.triangles[n];
        shell.triangles.retain(|t| *t != outer && *t != inner);
        for k in 0..3 {
            // `inner` is reversed: its corners are outer's 0, 2, 1.
            let twin = [inner[0], inner[2], inner[1]];
            let (a, b) = (outer[k], outer[(k + 1) % 3]);
            let (c, d) = (twin[(k + 1) % 3], twin[k]);
            shell.triangles.extend([[a, b, c], [a, c, d]]);
        }
        shell
    };
    for mesh in [
        shapes::turned(&shapes::torus(0.3, 24, 12)),
        shapes::turned(&shapes::ell()),
        shapes::turned(&opening),
        shapes::turned(&shell),
    ] {
        let hull = hull_of(&mesh);
        let interval = measure(&mesh);
        let sample = sampled(&mesh, &hull, 24);
        assert!(sample <= interval.upper, "{sample} {interval:?}");
        assert!(sample >= 0.8 * interval.lower, "{sample} {interval:?}");
        assert!(
            interval.upper <= interval.lower * 1.005 + 1e-7,
            "{interval:?}"
        );
    }
}

#[test]
fn decisions_agree_with_the_interval() {
    let mesh = shapes::turned(&shapes::torus(0.3, 40, 20));
    let (index, hull) = (SolidIndex::new(&mesh), hull_of(&mesh));
    let interval = bounds(&index, &hull, CLOSE, &Limits::default());
    for k in 1..60 {
        let epsilon = 0.02 * f64::from(k);
        match decide(&index, &hull, epsilon, &Limits::default()) {
            Decision::Within(found) => {
                assert!(epsilon >= interval.lower);
                assert!(found.upper <= epsilon && found.lower <= interval.upper);
            }
            Decision::Beyond { witness, lower } => {
                assert!(epsilon <= interval.upper);
                assert!(lower > epsilon && lower <= index.distance(witness));
                assert!(ConvexBody::new(&hull).contains(witness));
            }
            Decision::Unproven(found) => {
                assert!(
                    found.upper > epsilon && found.lower >= 0.998 * epsilon,
                    "{found:?}"
                );
            }
        }
    }
}

#[test]
fn limits_widen_and_never_lie() {
    let mesh = shapes::turned(&shapes::torus(0.3, 40, 20));
    let (index, hull) = (SolidIndex::new(&mesh), hull_of(&mesh));
    let best = bounds(&index, &hull, CLOSE, &Limits::default());
    let mut last = f64::INFINITY;
    for cells in [1, 10, 100, 1000, 10_000] {
        let short = bounds(&index, &hull, CLOSE, &Limits::cells(cells));
        assert!(short.lower <= best.upper && short.upper >= best.lower);
        assert!(short.upper <= last);
        last = short.upper;
    }
    let cancelled = Limits {
        cells: usize::MAX,
        cancelled: &|| true,
    };
    let stopped = bounds(&index, &hull, CLOSE, &cancelled);
    assert!(stopped.upper >= best.lower && stopped.upper.is_finite());
}

#[test]
fn nothing_to_be_near_to_is_infinitely_far() {
    let cube = shapes::cuboid(DVec3::ZERO, DVec3::ONE);
    let index = SolidIndex::new(&Mesh::default());
    let interval = bounds(&index, &cube, CLOSE, &Limits::default());
    assert_eq!(interval, Interval::exactly(f64::INFINITY));
    assert!(!decide(&index, &cube, 1.0, &Limits::default()).is_within());
}

/// A bar with a shallow dent along it: all surface is near to the hull, but hardly any point of the
/// hull is farther from it than others. Plain, boxes end at the hull's upper side; turned, it is
/// oblique to them.
#[test]
fn a_shallow_dent_needs_few_cells() {
    let depth = 1e-4;
    let left = vec![(-1.0, -1.0), (0.0, -1.0), (0.0, -depth), (-1.0, 0.0)];
    let right = vec![(0.0, -1.0), (2.0, -1.0), (2.0, 0.0), (0.0, -depth)];
    let bar = shapes::prism(&[left, right], -3.0, 3.0);
    for solid in [bar.clone(), shapes::turned(&bar)] {
        let index = SolidIndex::new(&solid);
        let found = bounds(&index, &hull_of(&solid), CLOSE, &Limits::cells(3000));
        let truth = depth / f64::hypot(1.0, depth / 2.0);
        assert!(found.holds(truth) && found.upper < 1.5 * truth, "{found:?}");
    }
}

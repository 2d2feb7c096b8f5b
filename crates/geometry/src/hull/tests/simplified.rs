//! Simplified hulls: exact enclosure, the count, and how much they grow.

use glam::DVec3;

use super::check;
use crate::distance::Triangle;
use crate::hull::circumscribe::contains;
use crate::hull::{
    convex_hull, simplify_outward, simplify_within, simplify_within_room, SimplifyError,
};
use crate::mesh::Mesh;
use crate::properties::volume;
use crate::sample::Random;

fn simplified(hull: &Mesh, max_vertices: usize) -> f64 {
    let simple = simplify_outward(hull, max_vertices).unwrap();
    check(&simple.vertices, &simple);
    assert!(simple.vertices.len() <= max_vertices);
    assert!(
        contains(&simple, hull).unwrap(),
        "{max_vertices} vertices do not enclose"
    );
    volume(&simple) / volume(hull)
}

fn ball(n: usize, seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    let points: Vec<DVec3> = (0..n).map(|_| random.on_sphere()).collect();
    convex_hull(&points).unwrap()
}

fn prism(sides: u32) -> Mesh {
    let points: Vec<DVec3> = (0..sides)
        .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(sides))
        .flat_map(|a| [-1.0, 1.0].map(|z| DVec3::new(libm::cos(a), libm::sin(a), z)))
        .collect();
    convex_hull(&points).unwrap()
}

#[test]
fn balls_in_every_number() {
    for (n, seed) in [(20, 1), (100, 2), (400, 3)] {
        let hull = ball(n, seed);
        let mut last = f64::INFINITY;
        for max in [4, 5, 6, 7, 8, 12, 16, 32, 64, 128, n - 1, n, n + 1] {
            let growth = simplified(&hull, max);
            if max >= 8 {
                assert!(
                    growth <= 1.05 * last,
                    "{n} to {max}: {growth}, fewer gave {last}"
                );
                last = growth;
            }
        }
        assert_eq!(last, 1.0);
    }
    assert!(simplified(&ball(400, 3), 64) < 1.09);
    assert!(simplified(&ball(400, 3), 32) < 1.2);
}

#[test]
fn one_vertex_fewer_costs_little() {
    let hull = ball(100, 5);
    assert!(simplified(&hull, 99) < 1.001);
    assert!(simplified(&hull, 90) < 1.01);
}

#[test]
fn prisms_become_prisms_with_fewer_sides() {
    // A polygon of n sides around a circle has n/π tan(π/n) of its area.
    let around = |n: f64| n / std::f64::consts::PI * libm::tan(std::f64::consts::PI / n);
    let hull = prism(128);
    for sides in [8, 16, 32] {
        let growth = simplified(&hull, 2 * sides);
        assert!(
            growth < 1.0 + 2.5 * (around(sides as f64) - 1.0),
            "{sides}: {growth}"
        );
    }
}

#[test]
fn boxes_and_tetrahedra_where_no_edge_can_collapse() {
    let cube = prism(4);
    for max in 4..9 {
        simplified(&cube, max);
    }
}

#[test]
fn plates_needles_and_distant_hulls() {
    let hull = ball(150, 6);
    for stretch in [
        DVec3::new(1.0, 1.0, 1e-6),
        DVec3::new(1.0, 1e-6, 1e-6),
        DVec3::splat(1e-6),
    ] {
        for shift in [0.0, 1e4 * stretch.max_element()] {
            let vertices: Vec<DVec3> = hull.vertices.iter().map(|v| *v * stretch + shift).collect();
            let flat = convex_hull(&vertices).unwrap();
            for max in [4, 8, 20, 64] {
                simplified(&flat, max);
            }
        }
    }
}

#[test]
fn a_reach_is_kept_and_used() {
    for (hull, few) in [(ball(300, 7), 180), (prism(200), 50)] {
        for reach in [0.0, 1e-6, 0.02] {
            let simple = simplify_within(&hull, reach).unwrap();
            assert!(contains(&simple, &hull).unwrap());
            let faces: Vec<Triangle> = hull.faces().map(Triangle::new).collect();
            for v in &simple.vertices {
                let distance2 = faces
                    .iter()
                    .map(|t| t.distance2(*v))
                    .fold(f64::INFINITY, f64::min);
                assert!(distance2.sqrt() <= reach + 1e-15, "{distance2}");
            }
            assert!(
                reach < 0.01 || simple.vertices.len() < few,
                "{}",
                simple.vertices.len()
            );
        }
        assert_eq!(simplify_within(&hull, 0.0).unwrap(), hull);
    }
}

#[test]
fn no_point_rises_above_a_face_by_more_than_its_room() {
    // None on one side of the ball, up to 0.05 on the other.
    let hull = ball(300, 7);
    let room = |[a, b, c]: [DVec3; 3]| ((a + b + c).x / 60.0).clamp(0.0, 0.05);
    let simple = simplify_within_room(&hull, &room).unwrap();
    assert!(contains(&simple, &hull).unwrap());
    for corners in hull.faces() {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        let heights = simple.vertices.iter().map(|v| normal.dot(*v - a));
        let highest = heights.fold(f64::NEG_INFINITY, f64::max);
        assert!(highest <= room(corners) + 1e-12, "{highest}");
    }
    let kept = |side: f64| {
        let left = simple.vertices.iter().filter(|v| v.x * side > 0.3).count();
        let all = hull.vertices.iter().filter(|v| v.x * side > 0.3).count();
        left as f64 / all as f64
    };
    assert!(kept(-1.0) == 1.0, "{}", kept(-1.0));
    assert!(kept(1.0) < 0.6, "{}", kept(1.0));
}

#[test]
fn three_vertices_are_too_few() {
    assert_eq!(
        simplify_outward(&prism(5), 3),
        Err(SimplifyError::TooFew { max_vertices: 3 })
    );
}

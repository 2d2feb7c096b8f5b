use assetpipe_geometry::bvh::Side;
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use super::cover::{inner_polytopes, InnerSettings};
use super::proof::is_inside;
use crate::control::Control;
use crate::shapes::{cuboid, reversed, together};

#[test]
fn touching_from_inside_is_inside_and_a_last_digit_beyond_is_not() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let solid = SolidIndex::new(&cube);
    assert!(is_inside(&solid, &cube));
    let mut beyond = cube.clone();
    let top = beyond.vertices.iter().position(|&v| v == DVec3::ONE);
    let top = top.unwrap();
    beyond.vertices[top].z += f64::EPSILON;
    let beyond = convex_hull(&beyond.vertices).unwrap();
    assert!(!is_inside(&solid, &beyond));
}

#[test]
fn around_beside_and_across_are_not_inside() {
    let solid = SolidIndex::new(&cuboid(DVec3::ZERO, DVec3::ONE));
    for (lo, hi) in [(-1.0, 2.0), (1.0, 2.0), (3.0, 4.0), (0.5, 1.5)] {
        let polytope = cuboid(DVec3::splat(lo), DVec3::splat(hi));
        assert!(!is_inside(&solid, &polytope), "{lo} {hi}");
    }
}

#[test]
fn a_cavity_in_the_middle_of_a_polytope_is_noticed() {
    let outer = cuboid(DVec3::ZERO, DVec3::ONE);
    let cavity = reversed(&cuboid(DVec3::splat(0.6), DVec3::splat(0.7)));
    let solid = SolidIndex::new(&together(&[outer, cavity]));
    assert!(!is_inside(
        &solid,
        &cuboid(DVec3::splat(0.1), DVec3::splat(0.9))
    ));
    assert!(is_inside(
        &solid,
        &cuboid(DVec3::splat(0.1), DVec3::splat(0.6))
    ));
}

/// The separating planes that are tried are all there are: on random pairs the
/// answer is that of a linear program solved by brute force sampling.
#[test]
fn a_triangle_across_an_edge_is_told_from_one_beside_it() {
    let polytope = cuboid(DVec3::ZERO, DVec3::ONE);
    let mut random = Random::new(5);
    let (mut apart, mut across) = (0, 0);
    for _ in 0..400 {
        let corner = || DVec3::new(1.0, 1.0, 0.5);
        let triangle: Vec<DVec3> = (0..3).map(|_| corner() + random.in_cube() * 0.6).collect();
        // A thin tetrahedron stands for the triangle: the solid's surface.
        let normal = (triangle[1] - triangle[0])
            .cross(triangle[2] - triangle[0])
            .normalize();
        let mut corners = triangle.clone();
        corners.push((triangle[0] + triangle[1] + triangle[2]) / 3.0 + normal * 1e-7);
        let shell = reversed(&convex_hull(&corners).unwrap());
        let around = cuboid(DVec3::splat(-5.0), DVec3::splat(5.0));
        let solid = SolidIndex::new(&together(&[around, shell]));
        let mut meets = false;
        for i in 0..60 {
            for j in 0..60 - i {
                let (s, t) = (f64::from(i) / 59.0, f64::from(j) / 59.0);
                let p =
                    triangle[0] + (triangle[1] - triangle[0]) * s + (triangle[2] - triangle[0]) * t;
                meets |= p.cmpgt(DVec3::ZERO).all() && p.cmplt(DVec3::ONE).all();
            }
        }
        let inside = is_inside(&solid, &polytope);
        if meets {
            across += 1;
            assert!(!inside, "{triangle:?}");
        } else if inside {
            apart += 1;
        }
    }
    assert!(apart > 40 && across > 100, "{apart} {across}");
}

#[test]
fn every_point_of_every_polytope_is_in_the_solid() {
    let mut random = Random::new(11);
    for round in 0..12 {
        let flat = [1.0, 0.02, 1e-4][round % 3];
        let mut shells: Vec<Mesh> = (0..3)
            .map(|_| {
                let points: Vec<DVec3> = (0..30)
                    .map(|_| random.in_cube() * DVec3::new(1.0, 1.0, flat))
                    .collect();
                convex_hull(&points).unwrap()
            })
            .collect();
        let hole: Vec<DVec3> = (0..12)
            .map(|_| random.in_cube() * DVec3::new(0.2, 0.2, 0.2 * flat))
            .collect();
        shells.push(reversed(&convex_hull(&hole).unwrap()));
        let mesh = together(&shells);
        let settings = InnerSettings {
            gap: 0.02,
            most: 50,
            most_vertices: 32,
            samples: 300,
        };
        let (found, _) = inner_polytopes(&mesh, &settings, &Control::default()).unwrap();
        assert!(!found.is_empty(), "{round}");
        let solid = SolidIndex::new(&mesh);
        for polytope in &found {
            assert!(polytope.mesh.vertices.len() <= 32);
            let corners = &polytope.mesh.vertices;
            let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
            for _ in 0..200 {
                let mut pick = || corners[random.below(corners.len() as u32) as usize];
                let (a, b, c) = (pick(), pick(), pick());
                let (s, t) = (random.unit(), random.unit());
                let p = centre + (a + (b - a) * s + (c - b) * (s * t) - centre) * (1.0 - 1e-9);
                assert_ne!(solid.bvh().side(p), Side::Outside, "{round} {p}");
            }
        }
    }
}

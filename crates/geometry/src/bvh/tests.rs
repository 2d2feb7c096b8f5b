use glam::DVec3;

use super::{Bounds, Branch, Bvh};
use crate::distance::Triangle;
use crate::sample::Random;
use crate::Mesh;

/// Triangles of all sizes and shapes, among them slivers, points and repeated ones.
fn soup(count: usize, seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    let mut point = move |scale: f64| {
        let mut next = || (random.unit() - 0.5) * scale;
        DVec3::new(next(), next(), next())
    };
    let mut mesh = Mesh::default();
    for k in 0..count {
        let a = point(2.0);
        let (b, c) = match k % 5 {
            0 => (a + point(0.1), a + point(0.1)),
            1 => (a + point(1.0), a + point(1.0)),
            2 => {
                let along = point(1.0);
                (a + along, a + along * 0.5 + point(1e-9))
            }
            3 => (a, a),
            _ => (point(2.0), point(2.0)),
        };
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend([a, b, c]);
        mesh.triangles.push([first, first + 1, first + 2]);
        if k % 7 == 0 {
            mesh.triangles.push([first, first + 1, first + 2]);
        }
    }
    mesh
}

fn points(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    let mut next = move || (random.unit() - 0.5) * 4.0;
    (0..count)
        .map(|_| DVec3::new(next(), next(), next()))
        .collect()
}

#[test]
fn nearest_agrees_with_looking_at_every_triangle() {
    for count in [1, 3, 4, 5, 100, 1000] {
        let mesh = soup(count, 7);
        let bvh = Bvh::new(&mesh);
        assert_eq!(bvh.len(), mesh.triangles.len());
        for q in points(200, 11) {
            let expected = (0..mesh.triangles.len())
                .map(|t| Triangle::new(mesh.corners(t)).distance2(q))
                .fold(f64::INFINITY, f64::min);
            let found = bvh.nearest(q, f64::INFINITY).unwrap();
            assert_eq!(found.distance2, expected);
            let corners = mesh.corners(bvh.original(found.slot) as usize);
            assert_eq!(Triangle::new(corners).distance2(q), expected);
            let radius = expected.sqrt();
            assert!(bvh.any_within(q, radius * (1.0 + 1e-12)));
            assert!(radius == 0.0 || !bvh.any_within(q, radius * (1.0 - 1e-12)));
            assert!(bvh.nearest(q, expected).is_none());
        }
    }
}

/// Boxes of single precision must not rule out what is nearest, wherever the mesh
/// lies, however large it is and however far away it is asked from.
#[test]
fn nearest_in_every_place_and_size() {
    let near = soup(300, 23);
    for (scale, offset) in [
        (1.0, 0.0),
        (1.0, 1e9),
        (1e-7, 1.0),
        (1e-30, 0.0),
        (1e30, 0.0),
        (1e-170, 0.0),
        (1e150, 0.0),
    ] {
        let mesh = Mesh {
            vertices: near.vertices.iter().map(|v| *v * scale + offset).collect(),
            triangles: near.triangles.clone(),
        };
        let bvh = Bvh::new(&mesh);
        for (k, q) in points(80, 29).into_iter().enumerate() {
            let away = [1.0, 10.0, 1e6, 1e-6][k % 4];
            let q = q * scale * away + offset;
            let expected = (0..mesh.triangles.len())
                .map(|t| Triangle::new(mesh.corners(t)).distance2(q))
                .fold(f64::INFINITY, f64::min);
            let found = bvh.nearest(q, f64::INFINITY).map(|n| n.distance2);
            assert_eq!(
                found.unwrap_or(f64::INFINITY),
                expected,
                "{scale} {offset} {q}"
            );
        }
    }
}

#[test]
fn an_early_answer_is_near_enough() {
    let bvh = Bvh::new(&soup(1000, 3));
    for q in points(200, 5) {
        let least = bvh.nearest(q, f64::INFINITY).unwrap().distance2;
        let found = bvh.nearest_until(q, f64::INFINITY, least * 4.0).unwrap();
        assert!(found.distance2 <= least * 4.0 || found.distance2 == least);
    }
}

#[test]
fn every_triangle_is_in_one_leaf_inside_all_boxes_above() {
    let mesh = soup(500, 13);
    let bvh = Bvh::new(&mesh);
    let mut seen = vec![0; bvh.len()];
    let mut stack = vec![(0, bvh.bounds())];
    while let Some((index, around)) = stack.pop() {
        let bounds = bvh.node_bounds(index);
        assert_eq!(bounds.join(around), around);
        match bvh.branch(index) {
            Branch::Fork(children) => stack.extend(children.map(|c| (c, bounds))),
            Branch::Leaf(slots) => {
                for slot in slots {
                    seen[slot as usize] += 1;
                    let inside = bvh.triangle(slot).bounds();
                    assert_eq!(inside.join(bounds), bounds);
                }
            }
        }
    }
    assert!(seen.iter().all(|s| *s == 1));
}

#[test]
fn visits_just_the_boxes_that_pass() {
    let mesh = soup(500, 17);
    let bvh = Bvh::new(&mesh);
    let window = Bounds {
        lo: DVec3::splat(-0.3),
        hi: DVec3::splat(0.2),
    };
    let meets = |b: &Bounds| b.lo.cmple(window.hi).all() && window.lo.cmple(b.hi).all();
    let mut found = Vec::new();
    bvh.for_each(meets, |slot| {
        found.push(bvh.original(slot));
        true
    });
    found.sort_unstable();
    let expected: Vec<u32> = (0..mesh.triangles.len())
        .filter(|t| meets(&Bounds::around(mesh.corners(*t))))
        .map(|t| t as u32)
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn many_triangles_in_one_place_stay_within_the_depth() {
    let mesh = Mesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]; 5000],
    };
    let bvh = Bvh::new(&mesh);
    let found = bvh.nearest(DVec3::Z, f64::INFINITY).unwrap();
    assert_eq!(found.distance2, 1.0);
}

#[test]
fn nothing_is_near_to_nothing() {
    let bvh = Bvh::new(&Mesh::default());
    assert!(bvh.nearest(DVec3::ZERO, f64::INFINITY).is_none());
    assert!(!bvh.any_within(DVec3::ZERO, 1.0));
    assert_eq!(bvh.side(DVec3::ZERO), super::Side::Outside);
}

use assetpipe_geometry::Plane;
use glam::DVec3;

use super::Piece;
use crate::shapes::cuboid;

/// A box [0,1]³ with a square hole [1/4,3/4]² through it along z.
fn frame() -> Piece {
    let mut points = Vec::new();
    for z in [0.0, 1.0] {
        for (lo, hi) in [(0.0, 1.0), (0.25, 0.75)] {
            for (x, y) in [(lo, lo), (hi, lo), (hi, hi), (lo, hi)] {
                points.push(DVec3::new(x, y, z));
            }
        }
    }
    let mut triangles = Vec::new();
    let mut quad = |a: u32, b: u32, c: u32, d: u32| {
        triangles.push([a, b, c]);
        triangles.push([a, c, d]);
    };
    for i in 0..4 {
        let j = (i + 1) % 4;
        quad(i, j, j + 8, i + 8); // outer wall
        quad(j + 4, i + 4, i + 12, j + 12); // hole wall
        quad(j, i, i + 4, j + 4); // bottom
        quad(i + 8, j + 8, j + 12, i + 12); // top
    }
    Piece {
        points,
        triangles,
        caps: Vec::new(),
    }
}

fn plane(n: [f64; 3], offset: f64) -> Plane {
    Plane {
        normal: DVec3::from_array(n),
        offset,
    }
}

#[test]
fn volumes_add_up_through_many_generations() {
    let whole = frame();
    assert!((whole.volume() - 0.75).abs() < 1e-12);
    let cuts = [
        plane([0.0, 0.0, 1.0], 0.4),
        plane([1.0, 0.0, 0.0], 0.5),
        plane([0.0, 1.0, 0.0], 0.25), // through faces of the hole
        plane([1.0, 0.5, 0.25], 0.6),
        plane([0.0, 0.0, 1.0], 0.2),
    ];
    let mut pieces = vec![whole];
    for cut in cuts {
        let mut next = Vec::new();
        for piece in &pieces {
            let (a, b) = piece.split(cut);
            assert!((a.volume() + b.volume() - piece.volume()).abs() < 1e-12);
            next.extend([a, b]);
        }
        pieces = next;
    }
    let sum: f64 = pieces.iter().map(Piece::volume).sum();
    assert!((sum - 0.75).abs() < 1e-12);
    assert!(pieces.iter().all(|p| p.volume() > -1e-12));
}

#[test]
fn a_corner_inside_the_solid_is_kept() {
    let cube = {
        let (_, part) = frame().split(plane([1.0, 0.0, 0.0], 0.75));
        part // a solid wall [3/4,1]×[0,1]²
    };
    let (a, _) = cube.split(plane([0.0, 1.0, 0.0], 0.5));
    let (a, _) = a.split(plane([0.0, 0.0, 1.0], 0.5));
    let (a, _) = a.split(plane([1.0, 0.0, 0.0], 0.875));
    assert!((a.volume() - 0.125 * 0.25).abs() < 1e-12);
    let corner = DVec3::new(0.875, 0.5, 0.5);
    assert!(a.points.iter().any(|p| p.distance(corner) < 1e-12));
}

#[test]
fn an_uneven_face_stays_whole_on_its_own_side() {
    // Turned, with noise as of single precision.
    let lower = frame();
    let turn = glam::DMat3::from_rotation_y(0.4) * glam::DMat3::from_rotation_x(0.7);
    let noise = |i: usize| 1e-7 * libm::sin(12.9 * i as f64 + 1.0);
    let noisy = Piece {
        points: lower
            .points
            .iter()
            .enumerate()
            .map(|(i, p)| turn * (*p + DVec3::splat(noise(i))))
            .collect(),
        ..lower
    };
    let normal = turn * DVec3::Z;
    let (below, above) = noisy.split(Plane {
        normal,
        offset: normal.dot(turn * DVec3::Z),
    });
    assert!((below.volume() - noisy.volume()).abs() < 1e-15);
    assert!(above.triangles.is_empty() && above.caps.is_empty());
    assert_eq!(below.points.len(), noisy.points.len());
    assert!(below.caps.is_empty());
}

#[test]
fn a_cut_on_a_flat_face_leaves_that_face_to_its_own_side() {
    // The plane z = 1 touches the top from outside: nothing is above.
    let (below, above) = frame().split(plane([0.0, 0.0, 1.0], 1.0));
    assert!((below.volume() - 0.75).abs() < 1e-12);
    assert!(above.points.is_empty() && above.triangles.is_empty());
}

/// Heights that have no exact binary fraction, so that products with them round.
#[test]
fn points_of_a_cut_are_in_its_plane_and_in_the_faces_of_their_edges() {
    let whole = Piece::from(&cuboid(
        DVec3::new(-0.1, -0.7, 0.3),
        DVec3::new(1.0 / 3.0, 0.9, 1.1),
    ));
    let heights: Vec<f64> = (1..30).map(|k| f64::from(k) / 31.0).collect();
    for axis in 0..3 {
        let (lo, hi) = whole.bounds();
        for share in &heights {
            let height = lo[axis] + share * (hi - lo)[axis];
            let (below, above) = whole.split(Plane::axis_aligned(axis, height));
            for half in [&below, &above] {
                let known = |x: f64, k: usize| x == lo[k] || x == hi[k];
                for p in &half.points {
                    assert!(known(p[axis], axis) || p[axis] == height);
                    assert!((0..3).any(|k| k != axis && known(p[k], k)), "{p:?}");
                }
            }
            // So a cut in one of those faces leaves no film beyond it.
            for other in (0..3).filter(|&k| k != axis) {
                let (_, beyond) = below.split(Plane::axis_aligned(other, hi[other]));
                assert!(beyond.points.is_empty() && beyond.triangles.is_empty());
            }
        }
    }
}

//! Hulls against the definition: exact containment, convexity and minimality.

mod simplified;

use glam::DVec3;

use super::{convex_hull, Builder, HullError};
use crate::mesh::Mesh;
use crate::predicates::{collinear, orient3d};
use crate::sample::Random;

/// Containment, closedness, minimality: everything a hull must be.
fn check(points: &[DVec3], hull: &Mesh) {
    let faces: Vec<[DVec3; 3]> = (0..hull.triangles.len()).map(|t| hull.corners(t)).collect();
    for &[a, b, c] in &faces {
        assert!(!collinear(a, b, c), "degenerate face");
        for &p in points {
            assert!(orient3d(a, b, c, p).is_le(), "{p:?} is outside of a face");
        }
    }
    // Closed: each directed edge once, its reverse once; Euler: a sphere.
    let mut edges: Vec<(u32, u32)> = hull
        .triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .collect();
    edges.sort_unstable();
    let mut twins: Vec<_> = edges.iter().map(|&(a, b)| (b, a)).collect();
    twins.sort_unstable();
    assert_eq!(edges, twins, "not closed");
    edges.dedup();
    assert_eq!(edges.len(), twins.len(), "an edge occurs twice");
    assert_eq!(
        hull.vertices.len() + hull.triangles.len(),
        edges.len() / 2 + 2
    );
    // Minimal: around each vertex at least three distinct planes.
    for (v, &apex) in hull.vertices.iter().enumerate() {
        assert!(points.contains(&apex), "not an input point");
        let around: Vec<[DVec3; 3]> = (0..faces.len())
            .filter(|&t| hull.triangles[t].contains(&(v as u32)))
            .map(|t| faces[t])
            .collect();
        let mut planes: Vec<[DVec3; 3]> = Vec::new();
        for &[a, b, c] in &around {
            let same = |q: &[DVec3; 3]| {
                [a, b, c]
                    .iter()
                    .all(|&p| orient3d(q[0], q[1], q[2], p).is_eq())
            };
            if !planes.iter().any(same) {
                planes.push([a, b, c]);
            }
        }
        assert!(planes.len() >= 3, "vertex {apex:?} is not extreme");
    }
}

/// Checks the hull and that order and repetition of the input do not matter.
fn hull_of(points: &[DVec3]) -> Mesh {
    let hull = convex_hull(points).unwrap();
    check(points, &hull);
    let mut random = Random::new(99);
    let mut shuffled = points.to_vec();
    shuffled
        .extend((0..points.len() / 3).map(|_| points[random.below(points.len() as u32) as usize]));
    random.shuffle(&mut shuffled);
    assert_eq!(
        convex_hull(&shuffled).unwrap(),
        hull,
        "depends on the order"
    );
    assert_eq!(
        convex_hull(&hull.vertices).unwrap(),
        hull,
        "is not its own hull"
    );
    hull
}

fn grid(n: i32) -> Vec<DVec3> {
    let range = || (0..n).map(f64::from);
    range()
        .flat_map(|x| range().flat_map(move |y| range().map(move |z| DVec3::new(x, y, z))))
        .collect()
}

#[test]
fn a_grid_has_the_hull_of_a_box() {
    for n in [2, 3, 6] {
        let hull = hull_of(&grid(n));
        assert_eq!((hull.vertices.len(), hull.triangles.len()), (8, 12));
    }
}

#[test]
fn a_rotated_grid_is_enclosed_exactly_though_rounding_bends_its_faces() {
    let rotation = glam::DQuat::from_xyzw(0.1, 0.3, -0.2, 0.9).normalize();
    let points: Vec<DVec3> = grid(5).iter().map(|p| rotation * (*p * 0.1)).collect();
    hull_of(&points);
}

#[test]
fn scattered_points_in_many_sizes() {
    let mut random = Random::new(1);
    for n in [4, 5, 6, 8, 13, 40, 150] {
        for _ in 0..10 {
            let inside: Vec<DVec3> = (0..n).map(|_| random.in_cube()).collect();
            hull_of(&inside);
            let on_sphere: Vec<DVec3> = (0..n).map(|_| random.on_sphere()).collect();
            hull_of(&on_sphere);
        }
    }
}

#[test]
fn integer_crowds_full_of_coplanar_and_collinear_points() {
    let mut random = Random::new(2);
    for side in [2, 3, 5, 9] {
        for n in [8, 20, 80] {
            for _ in 0..12 {
                let mut pick = || f64::from(random.below(side));
                let points: Vec<DVec3> =
                    (0..n).map(|_| DVec3::new(pick(), pick(), pick())).collect();
                match convex_hull(&points) {
                    Ok(_) => drop(hull_of(&points)),
                    Err(error) => assert!(matches!(error, HullError::Degenerate { .. })),
                }
            }
        }
    }
}

#[test]
fn cospherical_integer_points() {
    // All integer points at distance 9 from the origin.
    let points: Vec<DVec3> = grid(19)
        .into_iter()
        .map(|p| p - 9.0)
        .filter(|p| p.length_squared() == 81.0)
        .collect();
    assert_eq!(points.len(), 102);
    assert_eq!(hull_of(&points).vertices.len(), 102);
}

#[test]
fn prisms_keep_their_outline_and_lose_everything_else() {
    for sides in [3u32, 8, 64, 257] {
        let mut points = Vec::new();
        for i in 0..sides {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(sides);
            let (y, x) = (libm::sin(angle), libm::cos(angle));
            for z in [0.0, 0.25, 1.0] {
                points.push(DVec3::new(x, y, z));
                points.push(DVec3::new(x * 0.5, y * 0.5, z));
            }
        }
        let hull = hull_of(&points);
        assert_eq!(hull.vertices.len(), 2 * sides as usize);
    }
}

#[test]
fn needles_plates_and_distant_points() {
    let mut random = Random::new(3);
    for stretch in [
        DVec3::new(1.0, 1e-6, 1e-6),
        DVec3::new(1.0, 1.0, 1e-12),
        DVec3::new(1.0, 1e-15, 1e-15),
        DVec3::new(1e-300, 1.0, 1e200),
    ] {
        for shift in [DVec3::ZERO, DVec3::splat(1e4)] {
            let points: Vec<DVec3> = (0..60)
                .map(|_| random.on_sphere() * stretch + shift)
                .collect();
            match convex_hull(&points) {
                Ok(_) => drop(hull_of(&points)),
                Err(error) => assert!(matches!(error, HullError::Degenerate { .. })),
            }
        }
    }
}

#[test]
fn a_plate_one_ulp_thick_has_a_hull() {
    let mut points: Vec<DVec3> = grid(6).into_iter().filter(|p| p.z == 0.0).collect();
    for p in &mut points {
        p.z = 1.0;
    }
    points.push(DVec3::new(2.5, 2.5, 1f64.next_up()));
    let hull = hull_of(&points);
    assert_eq!(hull.vertices.len(), 5);
}

#[test]
fn what_has_no_volume_is_named_with_a_witness() {
    let line: Vec<DVec3> = (0..9)
        .map(|i| DVec3::new(1.0, 2.0, 4.0) * f64::from(i))
        .collect();
    let plane: Vec<DVec3> = grid(4)
        .into_iter()
        .map(|p| DVec3::new(p.x, p.y, p.x + p.y))
        .collect();
    let cases = [(vec![DVec3::ONE; 3], 0), (line, 1), (plane, 2)];
    for (points, expected) in cases {
        let Err(HullError::Degenerate { dimension, witness }) = convex_hull(&points) else {
            panic!("{points:?} has no volume");
        };
        assert_eq!(dimension, expected);
        assert_eq!(witness.len(), dimension + 1);
        if dimension == 2 {
            assert!(!collinear(
                points[witness[0]],
                points[witness[1]],
                points[witness[2]]
            ));
        }
    }
    assert_eq!(convex_hull(&[]), Err(HullError::Empty));
    let mut points = grid(2);
    points[3].y = f64::NAN;
    assert!(matches!(
        convex_hull(&points),
        Err(HullError::NotFinite { index: 3, .. })
    ));
    points[3].y = f64::NEG_INFINITY;
    assert!(matches!(
        convex_hull(&points),
        Err(HullError::NotFinite { index: 3, .. })
    ));
}

#[test]
fn negative_zero_is_zero() {
    let mut points = grid(2);
    points.extend(grid(2).into_iter().map(|p| p * DVec3::new(1.0, 1.0, -1.0)));
    let hull = convex_hull(&points).unwrap();
    assert!(hull
        .vertices
        .iter()
        .flat_map(DVec3::to_array)
        .all(|x| x.to_bits() != 1 << 63));
}

#[test]
fn a_builder_used_again_gives_the_same_bytes() {
    let mut random = Random::new(4);
    let mut builder = Builder::default();
    for n in [500, 10, 80, 300, 4] {
        let points: Vec<DVec3> = (0..n).map(|_| random.in_cube()).collect();
        let again = builder.hull(&points).unwrap();
        assert_eq!(again, convex_hull(&points).unwrap());
        let six_fold: f64 = (0..again.triangles.len())
            .map(|t| again.corners(t))
            .map(|[a, b, c]| a.dot(b.cross(c)))
            .sum();
        let volume = builder.volume(&points).unwrap();
        assert!((six_fold / 6.0 - volume).abs() < 1e-13 * volume);
    }
}

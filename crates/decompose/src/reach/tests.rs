use super::*;
use crate::edges::check_closed;
use crate::merge::volume;
use crate::shapes::{cuboid, reversed, together};
use glam::DVec3;

/// Two plates with a gap between them.
fn plates(gap: f64) -> Mesh {
    let half = DVec3::new(5.0, 5.0, 0.5);
    let middle = DVec3::Z * (0.5 + 0.5 * gap);
    together(&[
        cuboid(middle - half, middle + half),
        cuboid(-middle - half, -middle + half),
    ])
}

/// How deep pockets between the plates lie in balls that touch both rims, whose centres
/// are that far outside of the plates' outline, at most.
fn reached_between_plates(pockets: &Mesh, gap: f64, radius: f64) -> f64 {
    let rim = 5.0 + (radius * radius - 0.25 * gap * gap).sqrt();
    pockets
        .vertices
        .iter()
        .filter(|p| p.z.abs() < 0.5 * gap)
        .map(|p| radius - (rim - p.x.abs().max(p.y.abs())).hypot(p.z))
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_gap_that_the_ball_cannot_enter_is_a_pocket_and_only_what_it_cannot_touch() {
    let found = search(&plates(1.0), 1.0, 400_000, &Control::default()).unwrap();
    check_closed(&found.pockets).unwrap();
    assert_eq!(found.count, 1);
    let reached = reached_between_plates(&found.pockets, 1.0, 1.0);
    assert!(reached <= 1e-9 && reached > -0.2, "{reached}");
    // Nearly all of the gap's 10 × 10 × 1 is closed.
    let within: f64 = volume(&found.pockets);
    assert!(within > 75.0, "{within}");
}

#[test]
fn a_gap_that_the_ball_enters_stays_open() {
    let found = search(&plates(2.2), 1.0, 400_000, &Control::default()).unwrap();
    assert_eq!(found.count, 0);
    assert!(found.pockets.triangles.is_empty());
}

#[test]
fn a_gap_between_lattice_points_is_closed_too() {
    let gap = 0.01;
    let found = search(&plates(gap), 1.0, 400_000, &Control::default()).unwrap();
    assert_eq!(found.count, 1);
    assert!(reached_between_plates(&found.pockets, gap, 1.0) <= 1e-9);
    let index = SolidIndex::new(&found.pockets);
    let mut inside = 0;
    for i in -40..=40 {
        for j in -40..=40 {
            let p = DVec3::new(f64::from(i) * 0.11, f64::from(j) * 0.11, 0.0);
            inside += u32::from(index.contains(p));
        }
    }
    // All of the middle 8.8 × 8.8 but what the margin may leave at its rim.
    assert!(inside >= 78 * 78, "{inside} of {}", 81 * 81);
}

#[test]
fn a_sealed_void_is_a_pocket_however_large() {
    let mesh = together(&[
        cuboid(DVec3::splat(-4.0), DVec3::splat(4.0)),
        reversed(&cuboid(DVec3::splat(-3.0), DVec3::splat(3.0))),
    ]);
    let found = search(&mesh, 1.0, 400_000, &Control::default()).unwrap();
    assert_eq!(found.count, 1);
    assert!(volume(&found.pockets) > 216.0);
    let farthest = found.pockets.vertices.iter().map(|p| p.abs().max_element());
    assert!(farthest.fold(0.0, f64::max) < 4.0);
}

#[test]
fn a_convex_solid_has_none() {
    let mesh = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 1.0));
    let found = search(&mesh, 0.3, 100_000, &Control::default()).unwrap();
    assert_eq!(found.count, 0);
}

#[test]
fn a_radius_that_needs_too_many_points_is_refused_with_one_that_does_not() {
    let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
    let found = unreachable(&mesh, 1e-4, 1, &Control::default());
    let Err(DecomposeError::Reach { least, .. }) = found else {
        panic!("not refused");
    };
    let bounds = SolidIndex::new(&mesh).bvh().bounds();
    let points = |radius: f64| Lattice::points(&bounds, radius, 0.5 * radius);
    assert!(points(least) <= POINTS && points(0.8 * least) > POINTS);
}

#[test]
fn no_pocket_point_lies_within_a_ball_that_came_from_outside() {
    // A block with a blind square hole, 1 wide and 3 deep; balls of radius 0.6 dip into its mouth.
    let half = 0.5;
    let walls = [
        cuboid(DVec3::new(-3.0, -3.0, -2.0), DVec3::new(-half, 3.0, 2.0)),
        cuboid(DVec3::new(half, -3.0, -2.0), DVec3::new(3.0, 3.0, 2.0)),
        cuboid(DVec3::new(-half, -3.0, -2.0), DVec3::new(half, -half, 2.0)),
        cuboid(DVec3::new(-half, half, -2.0), DVec3::new(half, 3.0, 2.0)),
        cuboid(DVec3::new(-half, -half, -2.0), DVec3::new(half, half, -1.0)),
    ];
    let radius = 0.6;
    let found = search(&together(&walls), radius, 1_000_000, &Control::default()).unwrap();
    assert_eq!(found.count, 1);
    // The lowest ball rests on the four edges of the mouth.
    let centre = DVec3::new(0.0, 0.0, 2.0 + (radius * radius - half * half).sqrt());
    for p in &found.pockets.vertices {
        assert!(p.distance(centre) >= radius - 1e-9, "{p}");
        assert!(p.z < 2.0);
    }
    assert!(volume(&found.pockets) > 2.0);
}

//! Fits: enclosure, recovery of what the shape was made from, honest slack.

use glam::{DQuat, DVec3};

use super::{fit_box, fit_capsule, fit_cylinder, fit_sphere};
use crate::distance::Triangle;
use crate::hull::convex_hull;
use crate::mesh::Mesh;
use crate::sample::Random;

fn turn() -> DQuat {
    DQuat::from_xyzw(0.2, -0.4, 0.1, 0.8).normalize()
}

fn hull(points: impl Iterator<Item = DVec3>) -> Mesh {
    let place = |p| turn() * p + DVec3::new(0.5, -2.0, 1.0);
    convex_hull(&points.map(place).collect::<Vec<_>>()).unwrap()
}

fn ring(n: u32, radius: f64, z: f64) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |i| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        DVec3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
    })
}

fn distance(hull: &Mesh, p: DVec3) -> f64 {
    let squares = hull.faces().map(|f| Triangle::new(f).distance2(p));
    squares.fold(f64::INFINITY, f64::min).sqrt()
}

#[test]
fn a_box_is_its_own_box() {
    let brick = hull((0..8).map(|i| {
        DVec3::new(
            f64::from(i & 1),
            2.0 * f64::from(i >> 1 & 1),
            5.0 * f64::from(i >> 2),
        )
    }));
    let fit = fit_box(&brick).unwrap();
    assert!((fit.shape.volume() - 10.0).abs() < 1e-12);
    assert!(fit.slack < 1e-12, "{}", fit.slack);
    assert!(brick.vertices.iter().all(|v| fit.shape.contains(*v)));
}

#[test]
fn a_prism_is_a_cylinder_with_its_sagitta_as_slack() {
    let sides = 48;
    let prism = hull(ring(sides, 1.0, 0.0).chain(ring(sides, 1.0, 3.0)));
    let fit = fit_cylinder(&prism).unwrap();
    assert!(prism.vertices.iter().all(|v| fit.shape.contains(*v)));
    assert!((fit.shape.radius - 1.0).abs() < 1e-12);
    assert!((fit.shape.half_height - 1.5).abs() < 1e-12);
    let sagitta = 1.0 - libm::cos(std::f64::consts::PI / f64::from(sides));
    assert!(
        (fit.slack / sagitta - 1.0).abs() < 2e-3,
        "{} {sagitta}",
        fit.slack
    );
}

#[test]
fn rounded_rods_and_balls() {
    let dome = |sign: f64| {
        (0..12).flat_map(move |k| {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / 12.0;
            ring(24, libm::cos(angle), sign * (2.0 + libm::sin(angle)))
        })
    };
    let rod = hull(dome(1.0).chain(dome(-1.0)));
    let fit = fit_capsule(&rod).unwrap();
    assert!(rod.vertices.iter().all(|v| fit.shape.contains(*v)));
    assert!((fit.shape.radius - 1.0).abs() < 1e-9);
    assert!((fit.shape.ends[0].distance(fit.shape.ends[1]) - 4.0).abs() < 1e-6);
    assert!(fit.slack < 0.02, "{}", fit.slack);

    let mut random = Random::new(61);
    let ball = hull((0..2000).map(|_| random.on_sphere()));
    let fit = fit_sphere(&ball).unwrap();
    assert!(ball.vertices.iter().all(|v| fit.shape.contains(*v)));
    assert!((fit.shape.radius - 1.0).abs() < 1e-9);
    assert!(fit.slack < 0.02, "{}", fit.slack);
}

/// Every fit encloses every hull, and no point of a shape is farther from the
/// hull than the slack, while some are nearly as far.
#[test]
fn slack_is_the_largest_distance() {
    let mut random = Random::new(62);
    for round in 0..12 {
        let stretch = DVec3::new(1.0, 1.0 + f64::from(round % 3), 0.3 + f64::from(round % 4));
        let body = hull((0..20 + round).map(|_| random.in_cube() * stretch));
        let cuboid = fit_box(&body).unwrap();
        let sphere = fit_sphere(&body).unwrap();
        let capsule = fit_capsule(&body).unwrap();
        let cylinder = fit_cylinder(&body).unwrap();
        for v in &body.vertices {
            assert!(cuboid.shape.contains(*v) && sphere.shape.contains(*v));
            assert!(capsule.shape.contains(*v) && cylinder.shape.contains(*v));
        }
        let (mut worst, size) = ([0f64; 4], 10.0);
        for _ in 0..1000 {
            let d = random.on_sphere();
            // The farthest points of each shape in a direction.
            let on_box = cuboid.shape.axes
                * (cuboid.shape.half * (cuboid.shape.axes.transpose() * d).signum());
            let end = capsule.shape.ends[usize::from(random.below(2) == 1)];
            let axis = cylinder.shape.axis;
            let flat = (d - axis * axis.dot(d)).normalize();
            let on_cylinder = axis * (cylinder.shape.half_height * axis.dot(d).signum())
                + flat * cylinder.shape.radius;
            let points = [
                (cuboid.shape.centre + on_box, cuboid.slack),
                (sphere.shape.centre + d * sphere.shape.radius, sphere.slack),
                (end + d * capsule.shape.radius, capsule.slack),
                (cylinder.shape.centre + on_cylinder, cylinder.slack),
            ];
            for (worst, (p, slack)) in worst.iter_mut().zip(points) {
                let distance = distance(&body, p);
                assert!(distance <= slack + 1e-12 * size, "{distance} > {slack}");
                *worst = worst.max(distance / slack);
            }
        }
        assert!(worst.iter().all(|w| *w > 0.85), "{worst:?}");
    }
}

#[test]
fn nothing_fits_around_nothing() {
    let nothing = Mesh::default();
    assert!(fit_box(&nothing).is_none() && fit_sphere(&nothing).is_none());
    assert!(fit_capsule(&nothing).is_none() && fit_cylinder(&nothing).is_none());
}

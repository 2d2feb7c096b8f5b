//! Random points against random solids: distances and sides as brute force finds them.
//!
//! `ASSETPIPE_CASES` says which solids are drawn, as in `random_cuts`; each is asked about
//! `POINTS` points. The brute force shares no code with what it judges.
#![allow(clippy::panic, clippy::unwrap_used)]

mod solids;

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::properties::diagonal;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::{DVec3, Mesh};
use solids::{cases, solid};

const POINTS: usize = 25;

fn to_segment(q: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let length2 = along.length_squared();
    let share = if length2 > 0.0 {
        ((q - a).dot(along) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + along * share).distance(q)
}

/// To the edges, and to the plane where the foot lies between them.
fn to_triangle(q: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let edges = to_segment(q, a, b)
        .min(to_segment(q, b, c))
        .min(to_segment(q, c, a));
    let normal = (b - a).cross(c - a);
    if normal == DVec3::ZERO {
        return edges;
    }
    let within = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| (*to - *from).cross(q - *from).dot(normal) >= 0.0);
    if within {
        edges.min(normal.normalize().dot(q - a).abs())
    } else {
        edges
    }
}

/// How often the surface winds around a point, by solid angles (Van Oosterom & Strackee 1983).
fn winding(q: DVec3, mesh: &Mesh) -> f64 {
    let angle = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|p| p - q);
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * libm::atan2(a.dot(b.cross(c)), below)
    };
    (0..mesh.triangles.len()).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Around the box, near the surface, straight above a vertex, or between two vertices.
fn point(random: &mut Random, mesh: &Mesh) -> DVec3 {
    let mut vertex = || mesh.vertices[random.below(mesh.vertices.len() as u32) as usize];
    let (a, b) = (vertex(), vertex());
    let size = diagonal(mesh);
    match random.below(4) {
        0 => a + random.in_cube() * size,
        1 => a + random.in_cube() * size * 1e-6,
        2 => a + DVec3::AXES[random.below(3) as usize] * size * (random.unit() - 0.5),
        _ => a.lerp(b, random.unit()),
    }
}

#[test]
fn random_distances_agree_with_every_triangle() {
    let (mut asked, mut unsure) = (0, 0);
    for number in cases(400) {
        let mut random = Random::new(number ^ 0xD157);
        let mesh = solid(&mut random);
        if mesh.triangles.is_empty() {
            continue;
        }
        let index = SolidIndex::new(&mesh);
        for _ in 0..POINTS {
            let q = point(&mut random, &mesh);
            let expected = (0..mesh.triangles.len())
                .map(|t| to_triangle(q, mesh.corners(t)))
                .fold(f64::INFINITY, f64::min);
            let found = index.surface(q).unwrap().distance2.sqrt();
            assert!(
                (found - expected).abs() <= index.slack(),
                "case {number}: {found:e} from the surface at {q}, not {expected:e}"
            );
            asked += 1;
            if expected <= index.slack() {
                continue;
            }
            // Solid angles of stretched triangles lose digits: then nobody knows better. A tube
            // may run through itself, which counts as inside too.
            let turns = winding(q, &mesh);
            if (turns - turns.round()).abs() > 0.05 {
                unsure += 1;
                continue;
            }
            assert_eq!(
                index.contains(q),
                turns.round() > 0.0,
                "case {number}: winding {turns} at {q}"
            );
            let outside = if turns.round() > 0.0 { 0.0 } else { expected };
            assert!(
                (index.distance(q) - outside).abs() <= index.slack(),
                "case {number}: {} at {q}, not {outside}",
                index.distance(q)
            );
        }
    }
    println!("{asked} points, {unsure} with unsure solid angles");
    assert!(50 * unsure <= asked, "{unsure}");
    assert!(asked > cases(400).count(), "{asked}");
}

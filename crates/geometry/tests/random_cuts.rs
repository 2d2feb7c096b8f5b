//! Random cuts of random solids: pieces are closed 2-manifolds that add up.
//!
//! `ASSETPIPE_CASES` says which cases are drawn: `5000` or `5000..9000` (default
//! 1000). Case `k` is always the same, and a failure names it.
#![allow(clippy::panic, clippy::unwrap_used)]

mod solids;

use assetpipe_geometry::clip::{components, split, volume_below};
use assetpipe_geometry::mesh::check_manifold;
use assetpipe_geometry::predicates::side;
use assetpipe_geometry::properties::{diagonal, volume};
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::tolerance::Rounding;
use assetpipe_geometry::{DVec3, Mesh, Plane};
use solids::{cases, solid};

/// Through vertices, edges, faces, nearly through them, or anywhere.
fn plane(random: &mut Random, mesh: &Mesh) -> Plane {
    let mut vertex = || mesh.vertices[random.below(mesh.vertices.len() as u32) as usize];
    let [a, b, c] = [(); 3].map(|()| vertex());
    let axis = random.below(3) as usize;
    match random.below(6) {
        0 => Plane::axis_aligned(axis, a[axis]),
        1 => Plane::axis_aligned(axis, a[axis] * 0.5 + b[axis] * 0.5),
        2 => Plane::axis_aligned(axis, a[axis] * (1.0 + f64::EPSILON)),
        3 | 4 => {
            let normal = (b - a).cross(c - a);
            Plane {
                normal,
                offset: normal.dot(a),
            }
        }
        _ => {
            let normal = random.on_sphere();
            Plane {
                normal,
                offset: normal.dot(a.lerp(b, random.unit())),
            }
        }
    }
}

#[test]
fn random_cuts_of_random_solids() {
    let mut cuts = 0;
    for number in cases(1000) {
        let mut random = Random::new(number ^ 0xC07);
        let whole = solid(&mut random);
        if whole.triangles.is_empty() {
            continue;
        }
        check_manifold(&whole).unwrap_or_else(|e| panic!("case {number}: {e}"));
        let mut pieces = vec![whole];
        for _ in 0..=random.below(4) {
            let chosen = random.below(pieces.len() as u32) as usize;
            let piece = pieces.swap_remove(chosen);
            let plane = plane(&mut random, &piece);
            if plane.normal == DVec3::ZERO || !plane.normal.is_finite() {
                break;
            }
            let result = split(&piece, &plane).unwrap_or_else(|e| panic!("case {number}: {e}"));
            assert!(!result.is_fan, "case {number}: a fan");
            cuts += 1;
            check_pieces(
                number,
                &piece,
                &plane,
                [result.below.as_ref(), result.above.as_ref()],
            );
            let both = [result.below, result.above].into_iter().flatten();
            pieces.extend(both.flat_map(|piece| components(&piece)));
        }
    }
    println!("{cuts} cuts");
    assert!(cuts > cases(1000).count() / 2, "{cuts}");
}

fn check_pieces(number: u64, whole: &Mesh, plane: &Plane, pieces: [Option<&Mesh>; 2]) {
    let plane = &plane.scaled();
    let rounding = Rounding::of(whole);
    let meshes = [Some(whole), pieces[0], pieces[1]];
    let allowed: f64 = meshes.iter().flatten().map(|m| rounding.volume(m)).sum();
    let volumes = pieces.map(|piece| piece.map_or(0.0, volume));
    let difference = (volumes[0] + volumes[1] - volume(whole)).abs();
    assert!(
        difference <= allowed,
        "case {number}: volumes differ by {difference:e} > {allowed:e}"
    );
    let below = volume_below(whole, plane);
    // Without a cap, the section's rounding counts with its length and lever.
    let allowed = allowed + 4.0 * rounding.crossing() * diagonal(whole).powi(2);
    let difference = (below - volumes[0]).abs();
    assert!(
        difference <= allowed,
        "case {number}: {below} below, not {}",
        volumes[0]
    );
    let slack = 8.0 * rounding.crossing() + 1e-15 * diagonal(whole);
    for (piece, sign) in pieces.iter().zip([1.0, -1.0]) {
        let Some(piece) = piece else { continue };
        check_manifold(piece).unwrap_or_else(|e| panic!("case {number}: {e}"));
        for &v in &piece.vertices {
            if plane.axis().is_some_and(|(_, normal)| normal.abs() == 1.0) {
                let outside = f64::from(side(plane, v) as i8) == sign;
                assert!(!outside, "case {number}: {v} is on the wrong side");
            } else {
                let height = plane.evaluate(v) * sign / plane.normal.length();
                assert!(height <= slack, "case {number}: {v} is {height:e} outside");
            }
        }
    }
}

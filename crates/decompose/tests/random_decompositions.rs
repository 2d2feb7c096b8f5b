//! Random solids decomposed: hulls convex and around their parts by exact signs, bounds within
//! the tolerance and around what samples show, volumes of parts adding up.
//!
//! `ASSETPIPE_CASES` says which cases are drawn: `5000` or `5000..9000` (default 80). Case
//! `k` is always the same, and a failure names it.
#![allow(clippy::panic, clippy::unwrap_used)]

#[path = "../../geometry/tests/solids/mod.rs"]
mod solids;

use std::cmp::Ordering;

use assetpipe_decompose::control::Control;
use assetpipe_decompose::decomposition::{decompose, parts};
use assetpipe_decompose::edges::check_closed;
use assetpipe_decompose::error::DecomposeError;
use assetpipe_decompose::settings::{Metric, SearchSettings};
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::predicates::orient3d;
use assetpipe_geometry::properties::{area, bounds, diagonal, volume};
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::{DVec3, Mesh};
use solids::{cases, solid};

/// What `orient3d` answers for a point above a counter-clockwise triangle.
fn above() -> Ordering {
    orient3d(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z)
}

fn holds(hull: &Mesh, q: DVec3) -> bool {
    (0..hull.triangles.len()).all(|t| {
        let [a, b, c] = hull.corners(t);
        orient3d(a, b, c, q) != above()
    })
}

fn settings(random: &mut Random) -> SearchSettings {
    let mut settings = SearchSettings::default();
    let mut set = |key, value| settings.set(key, value).unwrap();
    // Small budgets: other paths of the search, and less time.
    set("expand", "4");
    set("planes", "8");
    set("second", "4");
    set("samples", "300");
    if random.below(4) == 0 {
        settings.metric = Metric::Concavity;
    }
    if random.below(6) == 0 {
        settings.most_vertices = 12;
    }
    settings
}

#[test]
fn random_decompositions_keep_their_promises() {
    let (mut made, mut hulls) = (0, 0);
    for number in cases(80) {
        let mut random = Random::new(number ^ 0xDEC0);
        let mesh = solid(&mut random);
        if mesh.triangles.is_empty() || mesh.triangles.len() > 400 {
            continue;
        }
        let epsilon = diagonal(&mesh) * [0.01, 0.03, 0.1, 0.3][random.below(4) as usize];
        let settings = settings(&mut random);
        let result = match decompose(&mesh, epsilon, &settings, 1, &Control::default()) {
            Ok(result) => result,
            // A tube that runs through itself may enclose as much backwards.
            Err(DecomposeError::Flat { .. }) => continue,
            Err(error) => panic!("case {number}: {error}"),
        };
        let groups = parts(&mesh, epsilon, &settings, 1, &Control::default()).unwrap();
        made += 1;
        hulls += result.leaves;
        assert_eq!(groups.len(), result.leaves, "case {number}");
        let index = SolidIndex::new(&mesh);
        for (place, hull) in result.hulls.iter().enumerate() {
            let thick = hull.thickening;
            assert!(
                0.0 <= thick.lower && thick.lower <= thick.upper,
                "case {number}: {thick:?}"
            );
            if place < result.leaves {
                let held = match settings.metric {
                    Metric::Thickening => thick,
                    Metric::Concavity => hull.concavity.unwrap(),
                };
                let budgeted = settings.most_vertices > 0;
                assert!(
                    budgeted || held.upper <= epsilon * (1.0 + 1e-9),
                    "case {number}: {held:?} beyond {epsilon}"
                );
            }
            for &v in &hull.mesh.vertices {
                assert!(
                    holds(&hull.mesh, v),
                    "case {number}: hull {place} is not convex"
                );
            }
            for _ in 0..20 {
                let mut corner =
                    || hull.mesh.vertices[random.below(hull.mesh.vertices.len() as u32) as usize];
                let (a, b, c) = (corner(), corner(), corner());
                let q = a.lerp(b, random.unit()).lerp(c, random.unit());
                assert!(
                    index.distance(q) <= thick.upper + index.slack(),
                    "case {number}: {} at {q}, beyond {thick:?}",
                    index.distance(q)
                );
            }
            if let Some([a, b]) = hull.children {
                for child in [a, b] {
                    let child = &result.hulls[child as usize];
                    assert!(
                        settings.most_vertices > 0
                            || child.mesh.vertices.iter().all(|&v| holds(&hull.mesh, v)),
                        "case {number}: hull {place} does not hold its child"
                    );
                }
            }
        }
        check_parts(
            number,
            &mesh,
            &groups,
            &result.hulls[..result.leaves]
                .iter()
                .map(|h| &h.mesh)
                .collect::<Vec<_>>(),
        );
    }
    println!("{made} decompositions, {hulls} hulls");
    assert!(3 * made >= cases(80).count(), "{made}");
}

fn check_parts(number: u64, mesh: &Mesh, groups: &[Vec<Mesh>], hulls: &[&Mesh]) {
    let mut total = 0.0;
    for (group, hull) in groups.iter().zip(hulls) {
        for part in group {
            check_closed(part).unwrap_or_else(|e| panic!("case {number}: {e}"));
            total += volume(part);
            for &v in part.triangles.iter().flatten() {
                let v = part.vertices[v as usize];
                assert!(
                    holds(hull, v),
                    "case {number}: {v} of a part is outside of its hull"
                );
            }
        }
    }
    let (lo, hi) = bounds(mesh).unwrap();
    let coordinate = lo.abs().max(hi.abs()).max_element();
    let allowed = 1e-12 * volume(mesh) + area(mesh) * 64.0 * f64::EPSILON * coordinate;
    let whole = volume(mesh);
    assert!(
        (total - whole).abs() <= allowed,
        "case {number}: parts hold {total:e}, not {whole:e} (allowed {allowed:e})"
    );
}

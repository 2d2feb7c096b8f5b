//! Theorem 1 of Wei et al. 2022 on the parts of whole decompositions:
//! `√2 · max(H_b, R_v) ≥ max(H_b, H_i)`.
#![allow(clippy::unwrap_used)]

use assetpipe_decompose::concavity::{wei, Gap, Limits};
use assetpipe_decompose::control::Control;
use assetpipe_decompose::decomposition::parts;
use assetpipe_decompose::settings::SearchSettings;
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::{DVec3, Mesh};

/// A ring whose thickness waves along and around it.
fn wavy_ring(seed: u64) -> Mesh {
    const AROUND: usize = 36;
    const ACROSS: usize = 14;
    let mut random = Random::new(seed);
    let mut next = |from: f64, to: f64| from + (to - from) * random.unit();
    let (thin, wave, swirl) = (next(0.15, 0.5), next(0.05, 0.35), next(1.0, 5.0).round());
    let turn = |k: usize, of: usize| std::f64::consts::TAU * k as f64 / of as f64;
    let vertices = (0..AROUND * ACROSS)
        .map(|k| {
            let (u, v) = (turn(k / ACROSS, AROUND), turn(k % ACROSS, ACROSS));
            let r = thin * (1.0 + wave * libm::sin(swirl * u) + wave * libm::cos(2.0 * v + u));
            let ring = 1.0 + r * libm::cos(v);
            DVec3::new(ring * libm::cos(u), ring * libm::sin(u), r * libm::sin(v))
        })
        .collect();
    let index = |i: usize, j: usize| (i % AROUND * ACROSS + j % ACROSS) as u32;
    let triangles = (0..AROUND * ACROSS)
        .flat_map(|k| {
            let (i, j) = (k / ACROSS, k % ACROSS);
            let (a, b) = (index(i, j), index(i + 1, j));
            let (c, d) = (index(i + 1, j + 1), index(i, j + 1));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Mesh {
        vertices,
        triangles,
    }
}

#[test]
fn theorem_1_on_every_part() {
    let gap = Gap {
        relative: 0.02,
        absolute: 1e-4,
    };
    let (mut checked, mut hollow) = (0, 0);
    for seed in 0..3 {
        let solid = wavy_ring(seed);
        let found = parts(
            &solid,
            0.06,
            &SearchSettings::default(),
            1,
            &Control::default(),
        );
        for part in found.unwrap().iter().flatten() {
            let hull = convex_hull(&part.vertices).unwrap();
            let index = SolidIndex::new(part);
            let concavity = wei::bounds(&index, &hull, gap, &Limits::default());
            let radius = wei::volume_radius(part, &hull);
            let surrogate = 2.0f64.sqrt() * concavity.boundary.max(radius).upper;
            assert!(surrogate >= concavity.value().lower, "{seed} {concavity:?}");
            let bound = wei::interior_bound(concavity.boundary, radius);
            assert!(bound >= concavity.interior.lower, "{seed} {concavity:?}");
            // One number for both is the same as its terms.
            let value = wei::value_above(&index, &hull, 0.0, gap, &Limits::default());
            assert!(value.lower <= concavity.value().upper, "{value:?}");
            assert!(value.upper >= concavity.value().lower, "{value:?}");
            checked += 1;
            hollow += usize::from(concavity.interior.lower > 0.01);
        }
    }
    assert!(checked >= 12 && hollow >= 6, "{checked} {hollow}");
}

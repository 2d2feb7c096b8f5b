//! Theorem 1 of Wei et al. 2022 on the parts of whole decompositions:
//! `√2 · max(H_b, R_v) ≥ max(H_b, H_i)`.
#![allow(clippy::unwrap_used)]

mod rings;

use assetpipe_decompose::concavity::{wei, Gap, Limits};
use assetpipe_decompose::control::Control;
use assetpipe_decompose::decomposition::parts;
use assetpipe_decompose::settings::SearchSettings;
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::Mesh;
use rings::ring;

/// A ring whose thickness waves along and around it.
fn wavy_ring(seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    let mut next = |from: f64, to: f64| from + (to - from) * random.unit();
    let (thin, wave, swirl) = (next(0.15, 0.5), next(0.05, 0.35), next(1.0, 5.0).round());
    ring(36, 14, |u, v| {
        thin * (1.0 + wave * libm::sin(swirl * u) + wave * libm::cos(2.0 * v + u))
    })
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

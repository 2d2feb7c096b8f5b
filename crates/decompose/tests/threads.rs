//! The number of threads changes no bit of a result.
#![allow(clippy::unwrap_used)]

mod rings;

use assetpipe_decompose::control::Control;
use assetpipe_decompose::decomposition::decompose;
use assetpipe_decompose::settings::{Metric, SearchSettings};
use assetpipe_geometry::{DVec3, Mesh};
use rings::ring;

/// A ring with bumps: `around` by `across` cells.
fn bumpy_ring(around: usize, across: usize) -> Mesh {
    ring(around, across, |u, v| {
        0.35 + 0.08 * libm::sin(5.0 * u) * libm::cos(3.0 * v)
    })
}

/// All numbers of a result, coarser levels included.
fn bits(mesh: &Mesh, epsilon: f64, settings: &SearchSettings, threads: usize) -> Vec<u64> {
    let found = decompose(mesh, epsilon, settings, threads, &Control::default()).unwrap();
    assert!(found.leaves > 4, "{}", found.leaves);
    let mut all = vec![found.leaves as u64];
    for hull in &found.hulls {
        let points = hull.mesh.vertices.iter().flat_map(DVec3::to_array);
        all.extend(points.map(f64::to_bits));
        let corners = hull.mesh.triangles.iter().flatten();
        all.extend(corners.map(|&v| u64::from(v)));
        let bounds = std::iter::once(hull.thickening).chain(hull.concavity);
        all.extend(bounds.flat_map(|b| [b.lower.to_bits(), b.upper.to_bits()]));
        let children = hull.children.into_iter().flatten();
        all.extend(children.map(u64::from));
    }
    all
}

#[test]
fn one_two_and_eight_threads_give_the_same_bits() {
    // More faces than are clustered before they are collapsed, with a finest stand-in of 400.
    let mesh = bumpy_ring(96, 48);
    let balanced = SearchSettings {
        ladder: vec![400, 200],
        ..SearchSettings::default()
    };
    let towards_the_part = SearchSettings {
        metric: Metric::Concavity,
        ..balanced.clone()
    };
    for settings in [balanced, towards_the_part] {
        let one = bits(&mesh, 0.05, &settings, 1);
        for threads in [2, 8] {
            assert!(one == bits(&mesh, 0.05, &settings, threads), "{threads}");
        }
    }
}

#[test]
fn several_ways_give_the_same_bits() {
    let mesh = bumpy_ring(48, 16);
    let best = SearchSettings {
        ways: vec![2, 2],
        ..SearchSettings::default()
    };
    let one = bits(&mesh, 0.1, &best, 1);
    assert!(one == bits(&mesh, 0.1, &best, 8));
}

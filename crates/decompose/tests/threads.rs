//! The number of threads changes no bit of a result.
#![allow(clippy::unwrap_used)]

use assetpipe_decompose::control::Control;
use assetpipe_decompose::decomposition::decompose;
use assetpipe_decompose::settings::{Metric, SearchSettings};
use assetpipe_geometry::{DVec3, Mesh};

/// A ring with bumps: `around` by `across` cells.
fn bumpy_ring(around: u32, across: u32) -> Mesh {
    let turn = |k: u32, n: u32| std::f64::consts::TAU * f64::from(k) / f64::from(n);
    let mut mesh = Mesh::default();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (turn(i, around), turn(j, across));
            let radius = 0.35 + 0.08 * libm::sin(5.0 * a) * libm::cos(3.0 * b);
            let out = 1.0 + radius * libm::cos(b);
            mesh.vertices.push(DVec3::new(
                out * libm::cos(a),
                out * libm::sin(a),
                radius * libm::sin(b),
            ));
        }
    }
    let at = |i: u32, j: u32| i % around * across + j % across;
    for i in 0..around {
        for j in 0..across {
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    mesh
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

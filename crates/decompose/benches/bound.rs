//! Time of certified bounds: a decision, an interval, and Eq. 4 of Wei et al. 2022.
#![allow(missing_docs)]

use std::hint::black_box;

use assetpipe_decompose::concavity::{thickening, wei, Gap, Limits};
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::{DVec3, Mesh};
use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};

/// A ring of about 2 n² triangles, radii 1 and 0.3.
fn ring(n: usize) -> Mesh {
    let turn = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
    let vertices = (0..n * n)
        .map(|k| {
            let (u, v) = (turn(k / n), turn(k % n));
            let ring = 1.0 + 0.3 * libm::cos(v);
            DVec3::new(ring * libm::cos(u), ring * libm::sin(u), 0.3 * libm::sin(v))
        })
        .collect();
    let index = |i: usize, j: usize| (i % n * n + j % n) as u32;
    let triangles = (0..n * n)
        .flat_map(|k| {
            let (i, j) = (k / n, k % n);
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

fn bounds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bound");
    let limits = Limits::default();
    let gap = Gap {
        relative: 0.05,
        absolute: 1e-3,
    };
    for n in [16, 64, 256] {
        let mesh = ring(n);
        let index = SolidIndex::new(&mesh);
        // A fifth of the ring: it thickens by about 0.1.
        let slice: Vec<DVec3> = mesh.vertices[..n * n.div_ceil(5)].to_vec();
        let Ok(hull) = convex_hull(&slice) else {
            continue;
        };
        for (name, epsilon) in [("within", 0.3), ("beyond", 0.02)] {
            group.bench_function(BenchmarkId::new(name, 2 * n * n), |b| {
                b.iter(|| black_box(thickening::decide(&index, &hull, epsilon, &limits)));
            });
        }
        group.bench_function(BenchmarkId::new("thickening", 2 * n * n), |b| {
            b.iter(|| black_box(thickening::bounds(&index, &hull, gap, &limits)));
        });
        if let Ok(whole) = convex_hull(&mesh.vertices) {
            group.bench_function(BenchmarkId::new("concavity", 2 * n * n), |b| {
                b.iter(|| black_box(wei::value_above(&index, &whole, 0.0, gap, &limits)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, bounds);
criterion_main!(benches);

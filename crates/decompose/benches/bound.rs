//! Time of certified bounds: a decision, an interval, and Eq. 4 of Wei et al. 2022.
#![allow(missing_docs)]

#[path = "../tests/rings/mod.rs"]
mod rings;

use std::hint::black_box;

use assetpipe_decompose::concavity::{thickening, wei, Gap, Limits};
use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::DVec3;
use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};
use rings::ring;

fn bounds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bound");
    let limits = Limits::default();
    let gap = Gap {
        relative: 0.05,
        absolute: 1e-3,
    };
    for n in [16, 64, 256] {
        // About 2 n² triangles, radii 1 and 0.3.
        let mesh = ring(n, n, |_, _| 0.3);
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

//! Time of hierarchies over triangles: building, nearest triangles, sides.
#![allow(missing_docs)]

use std::hint::black_box;

use assetpipe_geometry::bvh::Bvh;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::DVec3;
use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};

fn queries(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bvh");
    for n in [100, 1_000, 10_000, 100_000] {
        let mut random = Random::new(1);
        let points: Vec<DVec3> = (0..n / 2 + 2).map(|_| random.on_sphere()).collect();
        let Ok(sphere) = convex_hull(&points) else {
            continue;
        };
        group.bench_function(BenchmarkId::new("build", n), |b| {
            b.iter(|| black_box(Bvh::new(&sphere)));
        });
        let bvh = Bvh::new(&sphere);
        for (name, size) in [("near", 1.1), ("far", 10.0)] {
            let asked: Vec<DVec3> = (0..64).map(|_| random.on_sphere() * size).collect();
            let mut k = 0;
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| {
                    k = (k + 1) % asked.len();
                    black_box(bvh.nearest(asked[k], f64::INFINITY))
                });
            });
        }
        let asked: Vec<DVec3> = (0..64).map(|_| random.in_cube()).collect();
        let mut k = 0;
        group.bench_function(BenchmarkId::new("side", n), |b| {
            b.iter(|| {
                k = (k + 1) % asked.len();
                black_box(bvh.side(asked[k]))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, queries);
criterion_main!(benches);

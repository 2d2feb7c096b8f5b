//! Time of hulls over the number and kind of points.
#![allow(missing_docs)]

use std::hint::black_box;

use assetpipe_geometry::hull::{convex_hull, simplify_outward, Builder};
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::DVec3;
use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};

fn sphere(n: usize) -> Vec<DVec3> {
    let mut random = Random::new(1);
    (0..n).map(|_| random.on_sphere()).collect()
}

fn cube(n: usize) -> Vec<DVec3> {
    let mut random = Random::new(2);
    (0..n).map(|_| random.in_cube()).collect()
}

/// A square grid on each side of a box: everything coplanar.
fn plates(n: usize) -> Vec<DVec3> {
    let side = (n as f64 / 2.0).sqrt() as usize;
    (0..2 * side * side)
        .map(|i| [i % side, i / side % side, i / side / side].map(|x| x as f64))
        .map(DVec3::from)
        .collect()
}

fn hulls(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hull");
    for (name, points) in [
        ("sphere", sphere as fn(usize) -> Vec<DVec3>),
        ("cube", cube),
        ("plates", plates),
    ] {
        for n in [100, 1_000, 10_000, 100_000] {
            let points = points(n);
            let mut builder = Builder::default();
            group.bench_with_input(BenchmarkId::new(name, n), &points, |b, points| {
                b.iter(|| black_box(builder.hull(points)));
            });
        }
    }
    let points = sphere(1_000);
    let mut builder = Builder::default();
    group.bench_function("volume of sphere/1000", |b| {
        b.iter(|| black_box(builder.volume(&points)));
    });
    if let Ok(hull) = convex_hull(&points) {
        group.bench_function("simplify sphere/1000 to 64", |b| {
            b.iter(|| black_box(simplify_outward(&hull, 64)));
        });
    }
    group.finish();
}

criterion_group!(benches, hulls);
criterion_main!(benches);

//! Time of cuts over the number of faces.
#![allow(missing_docs)]

use std::hint::black_box;

use assetpipe_geometry::clip::{split, volume_below};
use assetpipe_geometry::{DVec3, Mesh, Plane};
use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};

/// A torus of about `faces` triangles, four times as many around as across.
fn torus(faces: usize) -> Mesh {
    let across = ((faces as f64 / 8.0).sqrt() as u32).max(3);
    let around = 4 * across;
    let turn = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let mut mesh = Mesh::default();
    for i in 0..around {
        for j in 0..across {
            let (u, v) = (turn(i, around), turn(j, across));
            let r = 3.0 + libm::cos(v);
            let p = DVec3::new(r * libm::cos(u), r * libm::sin(u), libm::sin(v));
            mesh.vertices.push(p);
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn cuts(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("clip");
    group.sample_size(20);
    let oblique = Plane {
        normal: DVec3::new(0.3, 0.5, 0.2),
        offset: 0.1,
    };
    for faces in [1_000, 10_000, 100_000, 1_000_000] {
        let mesh = torus(faces);
        for (name, plane) in [
            ("axis", Plane::axis_aligned(0, 0.123)),
            ("through vertices", Plane::axis_aligned(2, 0.0)),
            ("oblique", oblique),
        ] {
            group.bench_with_input(BenchmarkId::new(name, faces), &mesh, |b, mesh| {
                b.iter(|| black_box(split(mesh, &plane)));
            });
        }
        group.bench_with_input(BenchmarkId::new("volume", faces), &mesh, |b, mesh| {
            b.iter(|| black_box(volume_below(mesh, &oblique)));
        });
    }
    group.finish();
}

criterion_group!(benches, cuts);
criterion_main!(benches);

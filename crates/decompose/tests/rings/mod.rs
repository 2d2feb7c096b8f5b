//! Rings around z whose tube may be of any thickness: what tests and benchmarks take apart.

use assetpipe_geometry::{DVec3, Mesh};

/// A ring of radius 1 in `around` by `across` quads; `tube` gives the tube's radius at the angles
/// around the ring and across the tube.
pub fn ring(around: usize, across: usize, tube: impl Fn(f64, f64) -> f64) -> Mesh {
    let turn = |k: usize, of: usize| std::f64::consts::TAU * k as f64 / of as f64;
    let vertices = (0..around * across)
        .map(|k| {
            let (u, v) = (turn(k / across, around), turn(k % across, across));
            let r = tube(u, v);
            let out = 1.0 + r * libm::cos(v);
            DVec3::new(out * libm::cos(u), out * libm::sin(u), r * libm::sin(v))
        })
        .collect();
    let index = |i: usize, j: usize| (i % around * across + j % across) as u32;
    let triangles = (0..around * across)
        .flat_map(|k| {
            let (i, j) = (k / across, k % across);
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

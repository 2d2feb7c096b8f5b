//! The surface around chosen lattice points, cut through tetrahedra.

use assetpipe_geometry::Mesh;
use glam::DVec3;

use super::lattice::Lattice;

/// The six tetrahedra of a cube: corners on the way from the lowest to the
/// highest, one axis at a time (Kuhn's subdivision). Neighbouring cubes agree on
/// their common faces, so the surface is closed.
const WAYS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// An edge of the lattice that the surface cuts, smaller index first.
type Edge = (usize, usize);

/// Where the value, linear in every tetrahedron, is zero; chosen points have positive
/// values, all others negative ones. Outward from the chosen points.
pub(super) fn surface(lattice: &Lattice, chosen: &[bool], value: impl Fn(usize) -> f64) -> Mesh {
    let mut triangles: Vec<[Edge; 3]> = Vec::new();
    for cube in cubes(lattice, chosen) {
        let low = lattice.at(cube);
        for way in WAYS {
            let mut at = low;
            let mut corners = [cube; 4];
            for (corner, axis) in corners[1..].iter_mut().zip(way) {
                at[axis] += 1;
                *corner = lattice.index(at);
            }
            cut(lattice, chosen, corners, &mut triangles);
        }
    }
    let mut edges: Vec<Edge> = triangles.iter().flatten().copied().collect();
    edges.sort_unstable();
    edges.dedup();
    let vertices = edges.iter().map(|&(a, b)| {
        let [p, q] = [a, b].map(|k| lattice.position(lattice.at(k)));
        let (u, v) = (value(a), value(b));
        p.lerp(q, u / (u - v))
    });
    Mesh {
        vertices: vertices.collect(),
        triangles: triangles
            .iter()
            .map(|t| t.map(|edge| edges.partition_point(|e| *e < edge) as u32))
            .collect(),
    }
}

/// The cubes, by their lowest corners, that have chosen and other corners. Chosen
/// points are never in the outermost layers.
fn cubes(lattice: &Lattice, chosen: &[bool]) -> Vec<usize> {
    let corners = |low: [usize; 3]| {
        (0..8usize).map(move |k| [0, 1, 2].map(|axis| low[axis] + (k >> axis & 1)))
    };
    let mut found: Vec<usize> = Vec::new();
    for (index, _) in chosen.iter().enumerate().filter(|(_, &is_in)| is_in) {
        let at = lattice.at(index);
        for k in 0..8usize {
            let low = [0, 1, 2].map(|axis| at[axis] - (k >> axis & 1));
            if corners(low).any(|c| !chosen[lattice.index(c)]) {
                found.push(lattice.index(low));
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// The triangles through one tetrahedron.
fn cut(lattice: &Lattice, chosen: &[bool], corners: [usize; 4], triangles: &mut Vec<[Edge; 3]>) {
    let (mut inside, mut outside) = (Vec::with_capacity(4), Vec::with_capacity(4));
    for corner in corners {
        if chosen[corner] {
            inside.push(corner);
        } else {
            outside.push(corner);
        }
    }
    let edge = |a: usize, b: usize| (a.min(b), a.max(b));
    let ring: Vec<Edge> = match (&inside[..], &outside[..]) {
        (&[a], &[p, q, r]) => vec![edge(a, p), edge(a, q), edge(a, r)],
        (&[a, b], &[p, q]) => vec![edge(a, p), edge(a, q), edge(b, q), edge(b, p)],
        (&[a, b, c], &[p]) => vec![edge(a, p), edge(b, p), edge(c, p)],
        _ => return,
    };
    // The middles of the cut edges span a plane of the same side.
    let middle = |e: Edge| -> DVec3 {
        let [p, q] = [e.0, e.1].map(|k| lattice.position(lattice.at(k)));
        (p + q) * 0.5
    };
    let [p, q, r] = [ring[0], ring[1], ring[2]].map(middle);
    let out = lattice.position(lattice.at(outside[0])) - lattice.position(lattice.at(inside[0]));
    let outward = (q - p).cross(r - p).dot(out) > 0.0;
    for k in 1..ring.len() - 1 {
        triangles.push(if outward {
            [ring[0], ring[k], ring[k + 1]]
        } else {
            [ring[0], ring[k + 1], ring[k]]
        });
    }
}

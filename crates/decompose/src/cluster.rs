//! Large meshes made smaller in one pass: the vertices of a cell that are connected inside it
//! become one (Rossignac & Borrel 1993), where the quadric error of their faces is least
//! (Lindstrom 2000).
//!
//! Only connected ones: the two sides of a wall thinner than a cell stay apart. Any map of
//! vertices maps a closed chain to a closed chain.

use assetpipe_geometry::Mesh;
use glam::{DVec3, UVec3};

use crate::control::Control;
use crate::error::DecomposeError;
use crate::part::Union;
use crate::proxy::Quadric;

/// Cells that a surface of one cell's face in area goes through, about.
const CELLS: f64 = 2.0;
/// Triangles a vertex of a closed surface has, about (Euler).
const TRIANGLES: f64 = 2.0;
/// No cell is larger than this share of the longest side.
const LARGEST: f64 = 0.01;
/// Cells along the longest side at most.
const MOST: f64 = 65_536.0;

/// A mesh of about `triangles` triangles.
///
/// # Errors
/// [`DecomposeError::Cancelled`].
pub fn clustered_to(
    mesh: &Mesh,
    triangles: usize,
    control: &Control,
) -> Result<Mesh, DecomposeError> {
    let (lo, hi) = mesh
        .vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        });
    let longest = (hi - lo).max_element();
    let area: f64 = mesh
        .faces()
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .sum();
    control.go_on()?;
    let vertices = triangles as f64 / TRIANGLES;
    let size = (CELLS * area / vertices)
        .sqrt()
        .clamp(longest / MOST, LARGEST * longest);
    let cells: Vec<UVec3> = mesh
        .vertices
        .iter()
        .map(|&p| ((p - lo) / size).as_uvec3())
        .collect();
    let mut sets = Union::new(mesh.vertices.len());
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if cells[a as usize] == cells[b as usize] {
                sets.join(a, b);
            }
        }
    }
    control.go_on()?;
    // Clusters in the order of their first vertices, which are their roots.
    let mut cluster = vec![0u32; mesh.vertices.len()];
    let mut sums: Vec<(DVec3, f64)> = Vec::new();
    for v in 0..mesh.vertices.len() as u32 {
        let root = sets.root(v);
        if root == v {
            cluster[v as usize] = sums.len() as u32;
            sums.push((DVec3::ZERO, 0.0));
        } else {
            cluster[v as usize] = cluster[root as usize];
        }
        let sum = &mut sums[cluster[v as usize] as usize];
        sum.0 += mesh.vertices[v as usize];
        sum.1 += 1.0;
    }
    control.go_on()?;
    let mut quadrics = vec![Quadric::default(); sums.len()];
    let mut small = Mesh::default();
    for (t, corners) in mesh.faces().enumerate() {
        let quadric = Quadric::triangle(corners);
        let [a, b, c] = mesh.triangles[t].map(|v| cluster[v as usize]);
        for k in [a, b, c] {
            quadrics[k as usize].add(&quadric);
        }
        if a != b && b != c && c != a {
            small.triangles.push([a, b, c]);
        }
    }
    control.go_on()?;
    let place = |(quadric, (sum, count)): (&Quadric, &(DVec3, f64))| {
        let mean = *sum / *count;
        let best = quadric.minimum().filter(|p| p.distance(mean) < size);
        best.filter(|&p| quadric.at(p) < quadric.at(mean))
            .unwrap_or(mean)
    };
    small.vertices = quadrics.iter().zip(&sums).map(place).collect();
    Ok(small)
}

//! From triangles to facets: the one mesh that a hull has.

use glam::DVec3;

use super::quickhull::{order, Facet, NONE};
use crate::mesh::Mesh;

/// Memory reused between hulls.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Facet (group of coplanar triangles) per triangle.
    group: Vec<u32>,
    stack: Vec<u32>,
    /// How many facets meet, then the vertex of the result, per point.
    vertex: Vec<u32>,
    kept: Vec<u32>,
    polygon: Vec<u32>,
}

/// Merges coplanar triangles, drops what is not extreme, and writes the rest
/// in canonical order.
pub(super) fn canonical(points: &[DVec3], facets: &[Facet], scratch: &mut Scratch) -> Mesh {
    let alive = || (0..facets.len() as u32).filter(|&f| facets[f as usize].alive);
    let groups = merge(points, facets, scratch);

    // A vertex is extreme where at least three facets meet; where two meet it
    // is inside an edge. Each facet has one outgoing boundary edge there.
    let size = scratch.vertex.len().max(points.len());
    scratch.vertex.resize(size, 0);
    for f in alive() {
        for corner in facets[f as usize].corners {
            scratch.vertex[corner as usize] = 0;
        }
    }
    scratch.kept.clear();
    for f in alive() {
        for edge in 0..3 {
            if is_boundary(facets, &scratch.group, f, edge) {
                let corner = facets[f as usize].corners[edge];
                let meeting = &mut scratch.vertex[corner as usize];
                *meeting += 1;
                if *meeting == 3 {
                    scratch.kept.push(corner);
                }
            }
        }
    }
    let at = |v: u32| points[v as usize] + DVec3::ZERO;
    scratch.kept.sort_unstable_by(|&a, &b| order(at(a), at(b)));
    for f in alive() {
        for corner in facets[f as usize].corners {
            scratch.vertex[corner as usize] = NONE;
        }
    }
    for (new, &old) in scratch.kept.iter().enumerate() {
        scratch.vertex[old as usize] = new as u32;
    }

    let mut mesh = Mesh {
        vertices: scratch.kept.iter().map(|&v| at(v)).collect(),
        triangles: Vec::with_capacity(2 * scratch.kept.len()),
    };
    let mut done = vec![false; groups as usize];
    for f in alive() {
        let group = scratch.group[f as usize] as usize;
        if done[group] {
            continue;
        }
        let Some(edge) = (0..3).find(|&e| is_boundary(facets, &scratch.group, f, e)) else {
            continue;
        };
        done[group] = true;
        outline(facets, scratch, f, edge);
        fan(&mut scratch.polygon, &mut mesh.triangles);
    }
    mesh.triangles.sort_unstable();
    mesh
}

/// Labels coplanar neighbours alike; returns the number of labels.
fn merge(points: &[DVec3], facets: &[Facet], scratch: &mut Scratch) -> u32 {
    scratch.group.clear();
    scratch.group.resize(facets.len(), NONE);
    let mut groups = 0;
    for seed in 0..facets.len() as u32 {
        if !facets[seed as usize].alive || scratch.group[seed as usize] != NONE {
            continue;
        }
        scratch.group[seed as usize] = groups;
        scratch.stack.push(seed);
        while let Some(f) = scratch.stack.pop() {
            for other in facets[f as usize].across {
                if scratch.group[other as usize] == NONE && coplanar(points, facets, f, other) {
                    scratch.group[other as usize] = groups;
                    scratch.stack.push(other);
                }
            }
        }
        groups += 1;
    }
    groups
}

/// Whether a neighbour of triangle `f` lies in its plane.
fn coplanar(points: &[DVec3], facets: &[Facet], f: u32, neighbour: u32) -> bool {
    let f = &facets[f as usize];
    let apex = facets[neighbour as usize]
        .corners
        .into_iter()
        .find(|v| !f.corners.contains(v));
    apex.is_some_and(|apex| f.side(points, apex).1.is_eq())
}

fn is_boundary(facets: &[Facet], group: &[u32], f: u32, edge: usize) -> bool {
    group[facets[f as usize].across[edge] as usize] != group[f as usize]
}

/// Walks around the facet from boundary `edge` of triangle `f`, gathering extreme vertices.
fn outline(facets: &[Facet], scratch: &mut Scratch, f: u32, edge: usize) {
    scratch.polygon.clear();
    let (mut current, mut at) = (f, edge);
    loop {
        let vertex = scratch.vertex[facets[current as usize].corners[at] as usize];
        if vertex != NONE {
            scratch.polygon.push(vertex);
        }
        // Turn around the end of this edge until the facet's boundary comes again.
        at = (at + 1) % 3;
        while !is_boundary(facets, &scratch.group, current, at) {
            let end = facets[current as usize].corners[at];
            current = facets[current as usize].across[at];
            at = facets[current as usize]
                .corners
                .iter()
                .position(|&v| v == end)
                .unwrap_or(0);
        }
        if (current, at) == (f, edge) {
            return;
        }
    }
}

/// Triangulates a strictly convex polygon from its least vertex.
fn fan(polygon: &mut [u32], triangles: &mut Vec<[u32; 3]>) {
    let least = polygon
        .iter()
        .enumerate()
        .min_by_key(|(_, v)| **v)
        .map_or(0, |(i, _)| i);
    polygon.rotate_left(least);
    for pair in polygon.get(1..).unwrap_or_default().windows(2) {
        triangles.push([polygon[0], pair[0], pair[1]]);
    }
}

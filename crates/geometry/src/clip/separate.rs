//! From a closed surface that touches itself to a 2-manifold.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;
use crate::predicates::{orient2d, orient3d};

/// Doubles vertices so that every edge has two triangles and the triangles
/// around every vertex form one fan.
///
/// Where more than two triangles meet at an edge, those that bound the same
/// wedge of the solid are joined, so that bodies that only touch come apart.
/// An edge that one body uses twice is halved, so that its two places have
/// different vertices. Otherwise only vertex indices change, no positions.
#[must_use]
pub fn separate(mut mesh: Mesh) -> Mesh {
    let everywhere = vec![true; mesh.vertices.len()];
    separate_at(&mut mesh, &everywhere);
    mesh
}

/// As [`separate`], looking only at the vertices marked in `suspects`.
pub(super) fn separate_at(mesh: &mut Mesh, suspects: &[bool]) {
    let is_suspect = |v: u32| suspects[v as usize];
    let near: Vec<u32> = (0..mesh.triangles.len() as u32)
        .filter(|t| mesh.triangles[*t as usize].into_iter().any(is_suspect))
        .collect();
    let mut edges: Vec<HalfEdge> = Vec::with_capacity(3 * near.len());
    for (local, &t) in near.iter().enumerate() {
        let t = mesh.triangles[t as usize];
        for i in 0..3 {
            let (a, b, apex) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
            if is_suspect(a) || is_suspect(b) {
                let (low, high, forward) = if a < b { (a, b, true) } else { (b, a, false) };
                let first = 3 * local as u32;
                let (at_a, at_b) = (first + i as u32, first + (i as u32 + 1) % 3);
                let (at_low, at_high) = if forward { (at_a, at_b) } else { (at_b, at_a) };
                edges.push(HalfEdge {
                    low,
                    high,
                    forward,
                    apex,
                    at_low,
                    at_high,
                });
            }
        }
    }
    edges.sort_unstable_by_key(|e| (e.low, e.high, e.forward, e.at_low));
    let mut fans = Fans::new(3 * near.len());
    let mut crowded = Vec::new();
    for around in edges.chunk_by_mut(|a, b| (a.low, a.high) == (b.low, b.high)) {
        match around {
            [a, b] if a.forward != b.forward => fans.join(a, b),
            _ => {
                radially(&mesh.vertices, around);
                pair(around, &mut fans, &mut crowded);
            }
        }
    }
    rename(mesh, &near, suspects, &mut fans);
    halve(mesh, &near, &crowded);
}

/// Where a surface runs twice between the same two vertices, a vertex in the
/// middle of all but one of its edges tells them apart. `crowded` holds the
/// first corners of the two sides of such edges.
fn halve(mesh: &mut Mesh, near: &[u32], crowded: &[(u32, u32)]) {
    let mut middle: BTreeMap<u32, u32> = BTreeMap::new();
    let mut seen: BTreeSet<(u32, u32)> = BTreeSet::new();
    for &(p, q) in crowded {
        let t = mesh.triangles[near[p as usize / 3] as usize];
        let (a, b) = (t[p as usize % 3], t[(p as usize + 1) % 3]);
        if !seen.insert((a.min(b), a.max(b))) {
            let [x, y] = [a, b].map(|v| mesh.vertices[v as usize]);
            mesh.vertices.push(x * 0.5 + y * 0.5);
            let vertex = mesh.vertices.len() as u32 - 1;
            middle.extend([(p, vertex), (q, vertex)]);
        }
    }
    for (local, &t) in near.iter().enumerate() {
        let halves = [0, 1, 2].map(|i| middle.get(&(3 * local as u32 + i)).copied());
        let [a, b, c] = mesh.triangles[t as usize];
        let pieces: &[[u32; 3]] = match halves {
            [None, None, None] => continue,
            [Some(m), None, None] => &[[a, m, c], [m, b, c]],
            [None, Some(m), None] => &[[b, m, a], [m, c, a]],
            [None, None, Some(m)] => &[[c, m, b], [m, a, b]],
            [Some(m), Some(n), None] => &[[m, b, n], [a, m, c], [m, n, c]],
            [None, Some(m), Some(n)] => &[[m, c, n], [b, m, a], [m, n, a]],
            [Some(n), None, Some(m)] => &[[m, a, n], [c, m, b], [m, n, b]],
            [Some(l), Some(m), Some(n)] => &[[a, l, n], [l, b, m], [n, m, c], [l, m, n]],
        };
        mesh.triangles[t as usize] = pieces[0];
        mesh.triangles.extend_from_slice(&pieces[1..]);
    }
}

/// Gives each fan of triangles at a suspect its own vertex; the first keeps the old one.
fn rename(mesh: &mut Mesh, near: &[u32], suspects: &[bool], fans: &mut Fans) {
    let mut owner: Vec<u32> = vec![u32::MAX; suspects.len()];
    let mut vertex_of_fan: Vec<u32> = vec![u32::MAX; fans.parent.len()];
    for (local, &t) in near.iter().enumerate() {
        for i in 0..3 {
            let vertex = mesh.triangles[t as usize][i];
            if !suspects[vertex as usize] {
                continue;
            }
            let fan = fans.root(3 * local as u32 + i as u32) as usize;
            if vertex_of_fan[fan] == u32::MAX {
                vertex_of_fan[fan] = if owner[vertex as usize] == u32::MAX {
                    owner[vertex as usize] = fan as u32;
                    vertex
                } else {
                    mesh.vertices.push(mesh.vertices[vertex as usize]);
                    mesh.vertices.len() as u32 - 1
                };
            }
            mesh.triangles[t as usize][i] = vertex_of_fan[fan];
        }
    }
}

/// The side of a triangle along an edge.
struct HalfEdge {
    low: u32,
    high: u32,
    /// Whether the triangle runs from `low` to `high`.
    forward: bool,
    apex: u32,
    /// The triangle's corners (three per triangle, counted through) at the ends.
    at_low: u32,
    at_high: u32,
}

/// Sorts triangles counter-clockwise around their common edge, seen against
/// its direction; of equal ones those that close a wedge of solid come first.
fn radially(vertices: &[DVec3], around: &mut [HalfEdge]) {
    let Some(edge) = around.first() else { return };
    let (a, b) = (vertices[edge.low as usize], vertices[edge.high as usize]);
    let apex = |e: &HalfEdge| vertices[e.apex as usize];
    let Some((reference, axis, sign)) = around.iter().find_map(|e| {
        let (axis, sign) = flat_side(a, b, apex(e))?;
        Some((apex(e), axis, sign))
    }) else {
        return;
    };
    // Angle from the reference: 0, below 180°, 180°, above.
    let sector = |e: &HalfEdge| match orient3d(a, b, reference, apex(e)) {
        Ordering::Greater => 1,
        Ordering::Less => 3,
        Ordering::Equal if project(axis, a, b, apex(e)) == sign.reverse() => 2,
        Ordering::Equal => 0,
    };
    around.sort_by(|x, y| {
        let sectors = (sector(x), sector(y));
        let within = match sectors {
            (1, 1) | (3, 3) => orient3d(a, b, apex(x), apex(y)).reverse(),
            _ => Ordering::Equal,
        };
        let last = || y.forward.cmp(&x.forward).then(x.at_low.cmp(&y.at_low));
        sectors.0.cmp(&sectors.1).then(within).then_with(last)
    });
}

/// A coordinate plane in which `a`, `b`, `c` are not collinear, and how they turn there.
fn flat_side(a: DVec3, b: DVec3, c: DVec3) -> Option<(usize, Ordering)> {
    (0..3)
        .map(|axis| (axis, project(axis, a, b, c)))
        .find(|(_, sign)| sign.is_ne())
}

fn project(axis: usize, a: DVec3, b: DVec3, c: DVec3) -> Ordering {
    let drop = |p: DVec3| DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    orient2d(drop(a), drop(b), drop(c))
}

/// Joins each triangle that opens a wedge of solid (one running backward) to
/// the one that closes it.
fn pair(around: &[HalfEdge], fans: &mut Fans, crowded: &mut Vec<(u32, u32)>) {
    let mut open: Vec<usize> = Vec::new();
    let mut done = vec![false; around.len()];
    // Twice around: a wedge may contain the direction at which sorting began.
    for i in (0..around.len()).chain(0..around.len()) {
        if done[i] {
            continue;
        }
        if !around[i].forward {
            if !open.contains(&i) {
                open.push(i);
            }
        } else if let Some(first) = open.pop() {
            done[i] = true;
            done[first] = true;
            fans.join(&around[first], &around[i]);
            // The corners at which the two triangles' sides start.
            crowded.push((around[i].at_low, around[first].at_high));
        }
    }
}

/// Corners joined over edges (union-find, the least corner is the root).
struct Fans {
    parent: Vec<u32>,
}

impl Fans {
    fn new(corners: usize) -> Self {
        Self {
            parent: (0..corners as u32).collect(),
        }
    }

    fn root(&mut self, mut corner: u32) -> u32 {
        while self.parent[corner as usize] != corner {
            let grandparent = self.parent[self.parent[corner as usize] as usize];
            self.parent[corner as usize] = grandparent;
            corner = grandparent;
        }
        corner
    }

    fn join(&mut self, a: &HalfEdge, b: &HalfEdge) {
        for (p, q) in [(a.at_low, b.at_low), (a.at_high, b.at_high)] {
            let (p, q) = (self.root(p), self.root(q));
            self.parent[p.max(q) as usize] = p.min(q);
        }
    }
}

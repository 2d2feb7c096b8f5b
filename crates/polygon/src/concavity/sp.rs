//! Shortest-path concavity (§5.1.2).
//!
//! After holes are merged, or where an outline touches itself, a pocket
//! meets a vertex more than once: it is then several simple polygons that
//! hang together at single vertices or by slits. Whatever lies beyond such a
//! vertex is reached through it, so each polygon is measured by itself,
//! from the bridge or from the vertex at which it hangs.

use crate::boundary::Boundary;
use crate::geodesic;
use crate::Point;

/// A closed run of a chain between two visits of the same vertex.
pub(crate) struct Loop {
    /// Chain position at which the loop hangs.
    pub root: usize,
    /// Chain positions in order, without the root.
    pub inner: Vec<usize>,
}

/// Cuts chains into loops; keeps one mark per vertex between calls.
pub(crate) struct Loops {
    mark: Vec<u32>,
}

impl Loops {
    pub fn new(vertices: usize) -> Self {
        Self {
            mark: vec![0; vertices],
        }
    }

    /// Splits a sequence of vertices. Returns the positions of the simple
    /// path that remains, the loops, inner ones before those that hold them,
    /// and pairs `(position, first position)` of repeated visits.
    pub fn split(&mut self, vertices: &[u32]) -> (Vec<usize>, Vec<Loop>, Vec<(usize, usize)>) {
        let mut path: Vec<usize> = Vec::with_capacity(vertices.len());
        let mut loops = Vec::new();
        let mut repeats = Vec::new();
        for (k, &v) in vertices.iter().enumerate() {
            let seen = self.mark[v as usize] as usize;
            if seen == 0 {
                path.push(k);
                self.mark[v as usize] = path.len() as u32;
                continue;
            }
            let inner = path.split_off(seen);
            for &position in &inner {
                self.mark[vertices[position] as usize] = 0;
            }
            repeats.push((k, path[seen - 1]));
            if !inner.is_empty() {
                loops.push(Loop {
                    root: path[seen - 1],
                    inner,
                });
            }
        }
        for &position in &path {
            self.mark[vertices[position] as usize] = 0;
        }
        (path, loops, repeats)
    }
}

pub(super) fn measure(
    boundary: &Boundary,
    chain: &[u32],
    loops: &mut Loops,
    concavity: &mut [f64],
) {
    let vertices: Vec<u32> = chain.iter().map(|&c| boundary.vertex[c as usize]).collect();
    let point = |k: usize| boundary.points[vertices[k] as usize];
    let (path, loops, repeats) = loops.split(&vertices);
    let mut distance = vec![0.0; chain.len()];
    if path.len() > 2 {
        // the pocket lies right of its chain: backwards it is counter-clockwise
        let ring: Vec<Point> = path.iter().rev().map(|&k| point(k)).collect();
        for (&k, d) in path.iter().rev().zip(geodesic::from_closing_edge(&ring)) {
            distance[k] = d;
        }
    }
    for Loop { root, inner } in loops.iter().rev() {
        if inner.len() == 1 {
            distance[inner[0]] = distance[*root] + point(*root).distance(point(inner[0]));
            continue;
        }
        let order = || std::iter::once(root).chain(inner.iter().rev());
        let ring: Vec<Point> = order().map(|&k| point(k)).collect();
        for (&k, d) in order().zip(geodesic::from_first_vertex(&ring)).skip(1) {
            distance[k] = distance[*root] + d;
        }
    }
    for &(repeat, first) in repeats.iter().rev() {
        distance[repeat] = distance[first];
    }
    for (&corner, &d) in chain.iter().zip(&distance).skip(1).take(chain.len() - 2) {
        concavity[corner as usize] = d;
    }
}

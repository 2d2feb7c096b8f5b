//! Parts of an outline as closed pieces of the solid.

use std::collections::BTreeMap;

use assetpipe_geometry::{Mesh, Plane};
use assetpipe_polygon::{orient, Part};

use super::prism::{flat, Prism};
use crate::search::piece::{Cap, Piece};

/// One piece a part: its ends as caps, the solid's own walls, and new walls
/// above the diagonals, the same two triangles on both sides of each.
///
/// So the pieces add up to the solid as chains: every point of the solid is
/// wound around by one of them and thus in its hull. `None` if they do not.
pub fn pieces(mesh: &Mesh, prism: &Prism, parts: &[Part]) -> Option<Vec<Piece>> {
    let mut walls = prism.walls.clone();
    let mut diagonals: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    let pieces = parts
        .iter()
        .map(|part| {
            let mut builder = Builder::new(mesh, prism);
            for ring in std::iter::once(&part.outer).chain(&part.holes) {
                let corners = ring
                    .iter()
                    .map(|p| prism.corner(*p))
                    .collect::<Option<Vec<u32>>>()?;
                for (k, &a) in corners.iter().enumerate() {
                    let b = corners[(k + 1) % corners.len()];
                    let run = along(mesh, prism, a, b);
                    for pair in run.windows(2) {
                        let (from, to) = (pair[0], pair[1]);
                        builder.ends(from, to);
                        if prism.next.get(&from) == Some(&to) {
                            for t in walls.remove(&from)? {
                                builder.triangle(t);
                            }
                        } else {
                            let sense = if from < to { 1 } else { -1 };
                            *diagonals.entry((from.min(to), from.max(to))).or_default() += sense;
                            builder.diagonal(from, to);
                        }
                    }
                }
            }
            Some(builder.finish())
        })
        .collect::<Option<Vec<Piece>>>()?;
    let complete = walls.is_empty() && diagonals.values().all(|sum| *sum == 0);
    complete.then_some(pieces)
}

/// The corners from `a` to `b` along the outline where it runs straight
/// between them (parts leave out what is collinear), else just the two.
fn along(mesh: &Mesh, prism: &Prism, a: u32, b: u32) -> Vec<u32> {
    let at = |v: u32| flat(mesh, v, prism.axis);
    let mut run = vec![a];
    let mut last = a;
    while let Some(&then) = prism.next.get(&last) {
        run.push(then);
        if then == b {
            return run;
        }
        let between = |lo: f64, x: f64, hi: f64| lo.min(hi) <= x && x <= lo.max(hi);
        let (p, q, r) = (at(a), at(then), at(b));
        let straight = orient(p, q, r) == 0.0;
        if then == a || !straight || !between(p.x, q.x, r.x) || !between(p.y, q.y, r.y) {
            break;
        }
        last = then;
    }
    vec![a, b]
}

struct Builder<'a> {
    mesh: &'a Mesh,
    prism: &'a Prism,
    piece: Piece,
    index: BTreeMap<u32, u32>,
    lower: Vec<[u32; 2]>,
    upper: Vec<[u32; 2]>,
}

impl<'a> Builder<'a> {
    fn new(mesh: &'a Mesh, prism: &'a Prism) -> Self {
        Builder {
            mesh,
            prism,
            piece: Piece::default(),
            index: BTreeMap::new(),
            lower: Vec::new(),
            upper: Vec::new(),
        }
    }

    fn point(&mut self, vertex: u32) -> u32 {
        let points = &mut self.piece.points;
        *self.index.entry(vertex).or_insert_with(|| {
            points.push(self.mesh.vertices[vertex as usize]);
            points.len() as u32 - 1
        })
    }

    fn triangle(&mut self, t: [u32; 3]) {
        let t = t.map(|v| self.point(v));
        self.piece.triangles.push(t);
    }

    /// The borders of both ends along an edge.
    fn ends(&mut self, from: u32, to: u32) {
        let [a, b] = [self.point(from), self.point(to)];
        let [c, d] = [from, to].map(|v| self.point(self.prism.above[&v]));
        // Seen from outside each end is counter-clockwise.
        self.lower.push([b, a]);
        self.upper.push([c, d]);
    }

    /// A wall above a diagonal, split the same way whichever side it is seen from.
    fn diagonal(&mut self, from: u32, to: u32) {
        let [c, d] = [from, to].map(|v| self.prism.above[&v]);
        if from < to {
            self.triangle([from, to, c]);
            self.triangle([to, d, c]);
        } else {
            self.triangle([from, to, d]);
            self.triangle([from, d, c]);
        }
    }

    fn finish(mut self) -> Piece {
        let [low, high] = self.prism.ends;
        self.piece.caps = vec![
            Cap {
                plane: Plane::axis_aligned(self.prism.axis, low).flipped(),
                border: self.lower,
            },
            Cap {
                plane: Plane::axis_aligned(self.prism.axis, high),
                border: self.upper,
            },
        ];
        self.piece
    }
}

//! Boundaries as linked corners that a diagonal splits or joins in O(1),
//! and that can be taken back in reverse order.

use std::cmp::Ordering;

use crate::point::{in_corner, orient};
use crate::Point;

const NONE: u32 = u32::MAX;

/// A diagonal between corners `r` and `x`. Each of the two vertices then has
/// two corners: the old one and a new one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Diagonal {
    pub r: u32,
    pub x: u32,
    pub new_r: u32,
    pub new_x: u32,
}

/// Corners of all boundaries; a corner is one visit of a boundary walk to a
/// vertex. The interior lies left of `corner → next`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Boundary {
    pub points: Vec<Point>,
    pub vertex: Vec<u32>,
    pub next: Vec<u32>,
    pub previous: Vec<u32>,
    /// Per vertex its corners, counter-clockwise from the first one's next edge.
    at_vertex: Vec<Vec<u32>>,
}

impl Boundary {
    pub fn new(points: Vec<Point>) -> Self {
        Self {
            at_vertex: vec![Vec::new(); points.len()],
            points,
            ..Self::default()
        }
    }

    /// Adds a closed ring of vertices; returns its first corner.
    pub fn add_ring(&mut self, ring: &[u32]) -> u32 {
        let start = self.vertex.len() as u32;
        let n = ring.len() as u32;
        for (k, &v) in (0..n).zip(ring) {
            let corner = self.add_corner(v, start + (k + n - 1) % n, start + (k + 1) % n);
            self.at_vertex[v as usize].push(corner);
        }
        start
    }

    /// Puts the corners of each vertex in order; to be called after all rings are there.
    pub fn sort_corners(&mut self) {
        for v in 0..self.points.len() {
            let mut corners = std::mem::take(&mut self.at_vertex[v]);
            if corners.len() > 1 {
                let turn = Turn::about(self.points[v], self.point(self.next(corners[0])));
                corners.sort_by(|&a, &b| {
                    turn.compare(self.point(self.next(a)), self.point(self.next(b)))
                });
            }
            self.at_vertex[v] = corners;
        }
    }

    fn add_corner(&mut self, vertex: u32, previous: u32, next: u32) -> u32 {
        let corner = self.vertex.len() as u32;
        self.vertex.push(vertex);
        self.previous.push(previous);
        self.next.push(next);
        corner
    }

    /// Notes the corner `new` before or after `old`, its neighbour at the vertex.
    fn insert_beside(&mut self, old: u32, new: u32, after: usize) {
        let corners = &mut self.at_vertex[self.vertex[old as usize] as usize];
        let place = corners.iter().position(|&c| c == old).unwrap_or(0);
        corners.insert(place + after, new);
    }

    pub fn point(&self, corner: u32) -> Point {
        self.points[self.vertex[corner as usize] as usize]
    }

    pub fn next(&self, corner: u32) -> u32 {
        self.next[corner as usize]
    }

    pub fn previous(&self, corner: u32) -> u32 {
        self.previous[corner as usize]
    }

    /// Whether the interior angle exceeds 180° (a notch).
    pub fn is_notch(&self, corner: u32) -> bool {
        let [a, v, b] = [self.previous(corner), corner, self.next(corner)].map(|c| self.point(c));
        orient(a, v, b) < 0.0
    }

    /// The corners of the ring of `start`, beginning there.
    pub fn ring(&self, start: u32) -> Vec<u32> {
        let mut ring = vec![start];
        let mut corner = self.next(start);
        while corner != start {
            ring.push(corner);
            corner = self.next(corner);
        }
        ring
    }

    /// The corner at `vertex` whose interior contains the direction to `q`.
    pub fn facing(&self, vertex: u32, q: Point) -> Option<u32> {
        let corners = &self.at_vertex[vertex as usize];
        let first = *corners.first()?;
        let mut place = 0;
        if corners.len() > 1 {
            let turn = Turn::about(self.points[vertex as usize], self.point(self.next(first)));
            let begun = |&c: &u32| turn.compare(self.point(self.next(c)), q) != Ordering::Greater;
            place = corners.partition_point(begun).saturating_sub(1);
        }
        let corner = corners[place];
        let [a, v, b] = [self.previous(corner), corner, self.next(corner)].map(|c| self.point(c));
        in_corner(a, v, b, q).then_some(corner)
    }

    /// Links `r` and `x` by a diagonal. On one ring it splits it, the ring of
    /// `r → … → x` keeps the old corners; between two rings it joins them.
    pub fn link(&mut self, r: u32, x: u32) -> Diagonal {
        let (before_r, after_x) = (self.previous(r), self.next(x));
        let new_r = self.add_corner(self.vertex[r as usize], before_r, NONE);
        let new_x = self.add_corner(self.vertex[x as usize], new_r, after_x);
        self.next[new_r as usize] = new_x;
        self.next[before_r as usize] = new_r;
        self.previous[after_x as usize] = new_x;
        self.next[x as usize] = r;
        self.previous[r as usize] = x;
        // seen from a vertex, the interior runs from the next edge to the previous one
        self.insert_beside(r, new_r, 1);
        self.insert_beside(x, new_x, 0);
        Diagonal { r, x, new_r, new_x }
    }

    /// Takes a diagonal back; those laid after it within the same ring must
    /// have been taken back already.
    pub fn unlink(&mut self, diagonal: &Diagonal) {
        let Diagonal { r, x, new_r, new_x } = *diagonal;
        let (before_r, after_x) = (self.previous(new_r), self.next(new_x));
        self.previous[r as usize] = before_r;
        self.next[before_r as usize] = r;
        self.next[x as usize] = after_x;
        self.previous[after_x as usize] = x;
    }
}

/// Counter-clockwise order of directions about a point, from a first one.
struct Turn {
    centre: Point,
    first: Point,
}

impl Turn {
    fn about(centre: Point, first: Point) -> Self {
        Self { centre, first }
    }

    /// Whether `q` lies less than half a turn beyond the first direction.
    fn in_first_half(&self, q: Point) -> bool {
        let Self { centre, first } = *self;
        let side = orient(centre, first, q);
        side > 0.0
            || (side == 0.0
                && (q.x > centre.x) == (first.x > centre.x)
                && (q.y > centre.y) == (first.y > centre.y))
    }

    fn compare(&self, p: Point, q: Point) -> Ordering {
        let halves = self.in_first_half(q).cmp(&self.in_first_half(p));
        halves.then_with(|| 0.0_f64.total_cmp(&(orient(self.centre, p, q) + 0.0)))
    }
}

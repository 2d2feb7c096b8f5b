//! Delaunay triangulation by divide and conquer.
//!
//! Guibas and Stolfi, *Primitives for the Manipulation of General
//! Subdivisions and the Computation of Voronoi Diagrams*, 1985, §9, over
//! directed edges: edge `e` and its reverse `e ^ 1` lie side by side.

use glam::DVec2;

use crate::predicates::{incircle, orient2d};

/// No edge.
pub(super) const NONE: u32 = u32::MAX;

/// A triangulation of the convex hull of points.
pub(super) struct Triangulation<'a> {
    pub(super) points: &'a [DVec2],
    origin: Vec<u32>,
    /// The next edge with the same origin, counter-clockwise.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// How often the boundary runs along an edge; opposite for the reverse.
    pub(super) weight: Vec<i32>,
    /// An edge that starts at each point.
    pub(super) start: Vec<u32>,
    /// A directed edge with the unbounded face on its left.
    pub(super) outside: u32,
}

impl<'a> Triangulation<'a> {
    /// Triangulates all of `points`, given an `order` that is ascending by
    /// (x, y) and without equal points. Fewer than two points have no edges.
    pub(super) fn new(points: &'a [DVec2], order: &[u32]) -> Self {
        let mut this = Self {
            points,
            origin: Vec::with_capacity(6 * points.len()),
            next: Vec::with_capacity(6 * points.len()),
            previous: Vec::with_capacity(6 * points.len()),
            weight: Vec::new(),
            start: vec![NONE; points.len()],
            outside: NONE,
        };
        if order.len() >= 2 {
            let (left, _) = this.divide(order);
            this.outside = left ^ 1;
        }
        for edge in 0..this.origin.len() as u32 {
            if this.origin[edge as usize] != NONE {
                let point = this.origin[edge as usize];
                this.start[point as usize] = edge;
            }
        }
        this.weight = vec![0; this.origin.len()];
        this
    }

    /// All directed edges.
    pub(super) fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.origin.len() as u32).filter(|e| self.origin[*e as usize] != NONE)
    }

    pub(super) fn origin(&self, edge: u32) -> u32 {
        self.origin[edge as usize]
    }

    pub(super) fn end(&self, edge: u32) -> u32 {
        self.origin[(edge ^ 1) as usize]
    }

    /// Next edge around the origin, counter-clockwise.
    pub(super) fn around(&self, edge: u32) -> u32 {
        self.next[edge as usize]
    }

    fn back_around(&self, edge: u32) -> u32 {
        self.previous[edge as usize]
    }

    /// Next edge around the face on the left.
    pub(super) fn along(&self, edge: u32) -> u32 {
        self.previous[(edge ^ 1) as usize]
    }

    /// The point opposite `edge` in the triangle on its left.
    pub(super) fn apex(&self, edge: u32) -> u32 {
        self.end(self.along(edge))
    }

    pub(super) fn at(&self, point: u32) -> DVec2 {
        self.points[point as usize]
    }

    /// Whether `a`, `b`, `c` turn counter-clockwise.
    pub(super) fn turns_left(&self, a: u32, b: u32, c: u32) -> bool {
        orient2d(self.at(a), self.at(b), self.at(c)).is_gt()
    }

    /// Whether `d` is strictly inside the circle through `a`, `b`, `c` (counter-clockwise).
    pub(super) fn encircles(&self, a: u32, b: u32, c: u32, d: u32) -> bool {
        incircle(self.at(a), self.at(b), self.at(c), self.at(d)).is_gt()
    }

    /// Turns `edge` within the quadrilateral of its two triangles.
    pub(super) fn flip(&mut self, edge: u32) {
        let reverse = edge ^ 1;
        let (a, b) = (self.back_around(edge), self.back_around(reverse));
        for (half, stays) in [(edge, a), (reverse, b)] {
            let point = self.origin[half as usize];
            self.start[point as usize] = stays;
        }
        self.splice(edge, a);
        self.splice(reverse, b);
        self.splice(edge, self.along(a));
        self.splice(reverse, self.along(b));
        self.origin[edge as usize] = self.end(a);
        self.origin[reverse as usize] = self.end(b);
    }

    fn make(&mut self, from: u32, to: u32) -> u32 {
        let edge = self.origin.len() as u32;
        self.origin.extend([from, to]);
        self.next.extend([edge, edge + 1]);
        self.previous.extend([edge, edge + 1]);
        edge
    }

    /// Joins the rings around two origins, or parts one ring in two.
    fn splice(&mut self, a: u32, b: u32) {
        let (after_a, after_b) = (self.next[a as usize], self.next[b as usize]);
        self.next[a as usize] = after_b;
        self.next[b as usize] = after_a;
        self.previous[after_b as usize] = a;
        self.previous[after_a as usize] = b;
    }

    /// Adds the edge from the end of `a` to the origin of `b`, left of both.
    fn connect(&mut self, a: u32, b: u32) -> u32 {
        let edge = self.make(self.end(a), self.origin(b));
        self.splice(edge, self.along(a));
        self.splice(edge ^ 1, b);
        edge
    }

    fn remove(&mut self, edge: u32) {
        for half in [edge, edge ^ 1] {
            self.splice(half, self.back_around(half));
        }
        for half in [edge, edge ^ 1] {
            self.origin[half as usize] = NONE;
        }
    }

    /// Triangulates `order`; returns the counter-clockwise hull edge out of
    /// its first point and the clockwise one out of its last.
    fn divide(&mut self, order: &[u32]) -> (u32, u32) {
        match *order {
            [a, b] => {
                let edge = self.make(a, b);
                (edge, edge ^ 1)
            }
            [a, b, c] => {
                let first = self.make(a, b);
                let second = self.make(b, c);
                self.splice(first ^ 1, second);
                if self.turns_left(a, b, c) {
                    self.connect(second, first);
                    (first, second ^ 1)
                } else if self.turns_left(a, c, b) {
                    let third = self.connect(second, first);
                    (third ^ 1, third)
                } else {
                    (first, second ^ 1)
                }
            }
            _ => {
                let (left, right) = order.split_at(order.len() / 2);
                let left = self.divide(left);
                let right = self.divide(right);
                self.merge(left, right)
            }
        }
    }

    fn merge(&mut self, left: (u32, u32), right: (u32, u32)) -> (u32, u32) {
        let (mut left_out, mut left_in) = left;
        let (mut right_in, mut right_out) = right;
        // The lower common tangent.
        loop {
            if self.turns_left(
                self.origin(right_in),
                self.origin(left_in),
                self.end(left_in),
            ) {
                left_in = self.along(left_in);
            } else if self.turns_left(
                self.origin(left_in),
                self.end(right_in),
                self.origin(right_in),
            ) {
                right_in = self.around(right_in ^ 1);
            } else {
                break;
            }
        }
        let mut base = self.connect(right_in ^ 1, left_in);
        if self.origin(left_in) == self.origin(left_out) {
            left_out = base ^ 1;
        }
        if self.origin(right_in) == self.origin(right_out) {
            right_out = base;
        }
        // The seam, from below.
        loop {
            let (a, b) = (self.end(base), self.origin(base));
            let above = |this: &Self, edge: u32| this.turns_left(this.end(edge), a, b);
            let mut l = self.around(base ^ 1);
            if above(self, l) {
                while self.encircles(a, b, self.end(l), self.end(self.around(l))) {
                    let following = self.around(l);
                    self.remove(l);
                    l = following;
                }
            }
            let mut r = self.back_around(base);
            if above(self, r) {
                while self.encircles(a, b, self.end(r), self.end(self.back_around(r))) {
                    let following = self.back_around(r);
                    self.remove(r);
                    r = following;
                }
            }
            let (from_left, from_right) = (above(self, l), above(self, r));
            if !from_left && !from_right {
                return (left_out, right_out);
            }
            let choose_right = !from_left
                || from_right
                    && self.encircles(self.end(l), self.origin(l), self.origin(r), self.end(r));
            base = if choose_right {
                self.connect(r, base ^ 1)
            } else {
                self.connect(base ^ 1, l ^ 1)
            };
        }
    }
}

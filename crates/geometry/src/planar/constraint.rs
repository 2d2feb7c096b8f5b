//! Forcing segments into a triangulation.
//!
//! Sloan, *A fast algorithm for generating constrained Delaunay
//! triangulations*, 1993: edges that cross the segment are flipped away.
//! Every decision is exact, so a segment either appears or the obstacle is
//! named.

use std::cmp::Ordering;
use std::collections::VecDeque;

use super::delaunay::{Triangulation, NONE};
use crate::predicates::orient2d;

/// What stands in the way of a segment.
pub(super) enum Obstacle {
    /// The segment passes exactly through this point.
    Point(u32),
    /// The segment crosses an edge that is part of the boundary.
    Edge(u32, u32),
    /// The flips did not end: a bug or arithmetic out of range.
    Stuck,
}

impl Triangulation<'_> {
    /// Makes `from → to` an edge and adds `weight` to it. Edges that turned
    /// are put into `turned`.
    pub(super) fn force(
        &mut self,
        from: u32,
        to: u32,
        weight: i32,
        turned: &mut Vec<u32>,
    ) -> Result<(), Obstacle> {
        let edge = match self.find(from, to)? {
            Toward::Edge(edge) => edge,
            Toward::Across(first) => {
                let crossing = self.crossed(from, to, first)?;
                self.clear(from, to, crossing, turned)?
            }
        };
        self.weight[edge as usize] += weight;
        self.weight[(edge ^ 1) as usize] -= weight;
        Ok(())
    }

    /// Looks from a point along a segment.
    fn find(&self, from: u32, to: u32) -> Result<Toward, Obstacle> {
        let (a, b) = (self.at(from), self.at(to));
        let first = self.start[from as usize];
        if first == NONE {
            return Err(Obstacle::Stuck);
        }
        let mut edge = first;
        loop {
            let end = self.end(edge);
            if end == to {
                return Ok(Toward::Edge(edge));
            }
            let c = self.at(end);
            match orient2d(a, c, b) {
                Ordering::Equal
                    if (a.x, a.y) < (c.x, c.y) && (a.x, a.y) < (b.x, b.y)
                        || (a.x, a.y) > (c.x, c.y) && (a.x, a.y) > (b.x, b.y) =>
                {
                    return Err(Obstacle::Point(end));
                }
                Ordering::Greater => {
                    let following = self.end(self.around(edge));
                    if orient2d(a, self.at(following), b).is_lt() {
                        return Ok(Toward::Across(self.along(edge)));
                    }
                }
                _ => {}
            }
            edge = self.around(edge);
            if edge == first {
                return Err(Obstacle::Stuck);
            }
        }
    }

    /// The edges between `from` and `to`, each running from right to left.
    fn crossed(&self, from: u32, to: u32, first: u32) -> Result<VecDeque<u32>, Obstacle> {
        let (a, b) = (self.at(from), self.at(to));
        let mut crossing = VecDeque::new();
        let mut edge = first;
        loop {
            if self.weight[edge as usize] != 0 {
                return Err(Obstacle::Edge(self.origin(edge), self.end(edge)));
            }
            crossing.push_back(edge);
            let beyond = self.along(edge ^ 1);
            let apex = self.end(beyond);
            if apex == to {
                return Ok(crossing);
            }
            edge = match orient2d(a, b, self.at(apex)) {
                Ordering::Equal => return Err(Obstacle::Point(apex)),
                Ordering::Greater => beyond,
                Ordering::Less => self.along(beyond),
            };
        }
    }

    /// Flips edges until none crosses the segment; returns the segment's edge.
    fn clear(
        &mut self,
        from: u32,
        to: u32,
        mut crossing: VecDeque<u32>,
        turned: &mut Vec<u32>,
    ) -> Result<u32, Obstacle> {
        let mut patience = 64 + 8 * crossing.len() * crossing.len();
        while let Some(edge) = crossing.pop_front() {
            if !self.is_flippable(edge) {
                crossing.push_back(edge);
                patience -= 1;
                if patience == 0 {
                    return Err(Obstacle::Stuck);
                }
                continue;
            }
            self.flip(edge);
            turned.push(edge);
            let (p, q) = (self.origin(edge), self.end(edge));
            if [p, q] == [from, to] {
                return Ok(edge);
            }
            if [q, p] == [from, to] {
                return Ok(edge ^ 1);
            }
            let (a, b) = (self.at(from), self.at(to));
            let sides = (orient2d(a, b, self.at(p)), orient2d(a, b, self.at(q)));
            if sides.0 != sides.1 && sides.0.is_ne() && sides.1.is_ne() {
                crossing.push_back(edge);
            }
        }
        Err(Obstacle::Stuck)
    }

    /// Whether the two triangles at `edge` form a strictly convex quadrilateral.
    fn is_flippable(&self, edge: u32) -> bool {
        let (l, r) = (self.apex(edge), self.apex(edge ^ 1));
        self.turns_left(r, self.end(edge), l) && self.turns_left(l, self.origin(edge), r)
    }

    /// Lawson's flips from the `suspects` on, until every edge that is free
    /// to turn is locally Delaunay.
    pub(super) fn legalise(&mut self, mut suspects: Vec<u32>) {
        let outer = self.outer();
        // With exact predicates the flips end by themselves.
        let mut patience = 16 * (outer.len() + suspects.len());
        while let Some(edge) = suspects.pop() {
            let hull = outer[edge as usize] || outer[(edge ^ 1) as usize];
            if hull || self.weight[edge as usize] != 0 || !self.is_flippable(edge) {
                continue;
            }
            let (a, b) = (self.origin(edge), self.end(edge));
            if self.encircles(a, b, self.apex(edge), self.apex(edge ^ 1)) {
                if patience == 0 {
                    return;
                }
                patience -= 1;
                self.flip(edge);
                for half in [edge, edge ^ 1] {
                    let first = self.along(half);
                    suspects.extend([first, self.along(first)]);
                }
            }
        }
    }

    /// Which directed edges have the unbounded face on their left.
    pub(super) fn outer(&self) -> Vec<bool> {
        let mut outer = vec![false; self.weight.len()];
        let mut edge = self.outside;
        while edge != NONE && !outer[edge as usize] {
            outer[edge as usize] = true;
            edge = self.along(edge);
        }
        outer
    }
}

/// What lies at a point in the direction of another.
enum Toward {
    /// The edge that leads there.
    Edge(u32),
    /// The first edge in between, from right to left.
    Across(u32),
}

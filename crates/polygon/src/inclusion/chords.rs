//! A polygon as a ring of links that chords cut, and cuts that can be undone.

use crate::Point;

/// A line through a reflex vertex; what lies left of it is kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub through: Point,
    pub direction: (f64, f64),
}

impl Chord {
    pub fn side(&self, q: Point) -> f64 {
        self.direction.0 * (q.y - self.through.y) - self.direction.1 * (q.x - self.through.x)
    }

    fn meet(&self, p: Point, q: Point) -> Point {
        let (side_p, side_q) = (self.side(p), self.side(q));
        let t = if side_p == side_q {
            0.0
        } else {
            (side_p / (side_p - side_q)).clamp(0.0, 1.0)
        };
        Point::new(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y))
    }
}

/// What a cut replaced.
pub(super) struct Cut {
    pub removed_area: f64,
    before: usize,
    after: usize,
    old_next: usize,
    old_previous: usize,
    links: usize,
}

pub(super) struct Links {
    pub points: Vec<Point>,
    next: Vec<usize>,
    previous: Vec<usize>,
    there: Vec<bool>,
    /// Points nearer than this are one: an edge of a few ulp has no direction.
    same: f64,
}

impl Links {
    pub fn new(ring: &[Point]) -> Self {
        let n = ring.len();
        let extent = ring.iter().map(|p| p.distance(ring[0])).fold(0.0, f64::max);
        Self {
            same: 1e-13 * extent,
            points: ring.to_vec(),
            next: (0..n).map(|k| (k + 1) % n).collect(),
            previous: (0..n).map(|k| (k + n - 1) % n).collect(),
            there: vec![true; n],
        }
    }

    pub fn next(&self, k: usize) -> usize {
        self.next[k]
    }

    pub fn previous(&self, k: usize) -> usize {
        self.previous[k]
    }

    /// Whether the vertex has not been cut off.
    pub fn is_there(&self, k: usize) -> bool {
        self.there[k]
    }

    /// Cuts off what the chord through vertex `r` separates, scanning from `r`
    /// in both directions (Fig. 15). `None` if it is no chord there or leaves nothing.
    pub fn cut(&mut self, r: usize, chord: &Chord) -> Option<Cut> {
        let side = |k: usize| chord.side(self.points[k]);
        // an edge that lies on the chord's line may come out a rounding to its left
        let (after, before) = (self.next[r], self.previous[r]);
        if side(after) > 0.0 || side(before) > 0.0 {
            return None;
        }
        let scan = |step: &[usize]| {
            let mut k = step[r];
            while side(k) < 0.0 && k != r {
                k = step[k];
            }
            (k != r).then_some(k)
        };
        let (after, before) = (scan(&self.next)?, scan(&self.previous)?);
        if after == before {
            return None;
        }
        let end = |kept: usize, last: usize| {
            if last == r {
                self.points[r]
            } else {
                chord.meet(self.points[last], self.points[kept])
            }
        };
        let start = end(before, self.next[before]);
        let stop = end(after, self.previous[after]);
        let mut removed_area = 0.0;
        let mut add = |p: Point, q: Point| {
            let c = chord.through;
            removed_area += ((p.x - c.x) * (q.y - c.y) - (q.x - c.x) * (p.y - c.y)) / 2.0;
        };
        let mut here = start;
        let mut k = self.next[before];
        while k != after {
            add(here, self.points[k]);
            here = self.points[k];
            self.there[k] = false;
            k = self.next[k];
        }
        add(here, stop);
        let cut = Cut {
            removed_area,
            before,
            after,
            old_next: self.next[before],
            old_previous: self.previous[after],
            links: self.points.len(),
        };
        let mut last = before;
        for q in [start, stop] {
            let merges = |k: usize| q.distance(self.points[k]) <= self.same;
            if merges(last) || merges(after) {
                continue;
            }
            let new = self.points.len();
            self.points.push(q);
            self.there.push(true);
            self.next.push(after);
            self.previous.push(last);
            self.next[last] = new;
            last = new;
        }
        self.next[last] = after;
        self.previous[after] = last;
        Some(cut)
    }

    /// Takes back the latest cut.
    pub fn undo(&mut self, cut: &Cut) {
        self.points.truncate(cut.links);
        self.next.truncate(cut.links);
        self.previous.truncate(cut.links);
        self.there.truncate(cut.links);
        self.next[cut.before] = cut.old_next;
        self.previous[cut.after] = cut.old_previous;
        let mut k = cut.old_next;
        while k != cut.after {
            self.there[k] = true;
            k = self.next[k];
        }
    }

    /// The vertices left, from any one that is still there.
    pub fn ring(&self) -> Vec<usize> {
        let Some(start) = (0..self.points.len()).rev().find(|&k| self.is_there(k)) else {
            return Vec::new();
        };
        let mut ring = vec![start];
        let mut k = self.next[start];
        while k != start && ring.len() <= self.points.len() {
            ring.push(k);
            k = self.next[k];
        }
        ring
    }
}

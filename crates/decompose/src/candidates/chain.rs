//! Reflex chains: the hollow sides of a section, and how few convex pieces can line them.
//!
//! A convex piece that lines a stretch of a hollow wall reaches over it as far as the chord of
//! the stretch does: the sagitta. So the fewest pieces along a wall are the fewest chords that
//! stay within the tolerance of it, which going on greedily finds (min-# polygonal
//! approximation; for a circle of radius r, chords of 2 acos(1 − ε/r)).

use glam::DVec2;

use super::section::Outline;
use crate::even;

/// Turns to the left up to this (sine) do not end a chain: noise of straight walls.
const STRAIGHT: f64 = 0.01;
/// Sharper turns (cosine, 65°) are corners with faces of their own, not a curved wall.
const SMOOTH: f64 = 0.42;
/// Chords end this exactly, as a share of an edge.
const FINE: f64 = 1e-6;

/// Chords that end so close to a vertex, as a share of an edge, end there.
const VERTEX: f64 = 1e-5;

/// A stretch of an outline along which the solid is hollow.
#[derive(Clone, Debug)]
pub struct Chain {
    points: Vec<DVec2>,
    /// Share of the sagitta at each point that is distance from the wall: less than one for
    /// walls that lean.
    upright: Vec<f64>,
    /// Whether it is a whole hole; the last point then precedes the first.
    closed: bool,
}

impl Chain {
    /// The smooth reflex chains of an outline.
    pub fn of(outline: &Outline) -> Vec<Chain> {
        let n = outline.len();
        let edge =
            |i: usize| (outline[(i + 1) % n].point - outline[i % n].point).normalize_or_zero();
        // (convex, sharp) of the turn at each corner.
        let turns: Vec<(bool, bool)> = (0..n)
            .map(|i| {
                let (a, b) = (edge(i + n - 1), edge(i));
                let left = a.perp_dot(b);
                (left > STRAIGHT, a.dot(b) < SMOOTH && left < 0.0)
            })
            .collect();
        let upright = |i: usize| outline[i % n].upright.max(outline[(i + n - 1) % n].upright);
        let chain = |from: usize, count: usize, closed: bool| Chain {
            points: (from..from + count).map(|i| outline[i % n].point).collect(),
            upright: (from..from + count).map(upright).collect(),
            closed,
        };
        let Some(first) = turns.iter().position(|t| t.0) else {
            let sharp = turns.iter().any(|t| t.1);
            return if sharp {
                Vec::new()
            } else {
                vec![chain(0, n, true)]
            };
        };
        let mut found = Vec::new();
        let mut from = first;
        let mut sharp = false;
        for i in first + 1..=first + n {
            let (convex, corner) = turns[i % n];
            if convex {
                if i - from >= 2 && !sharp {
                    found.push(chain(from, i - from + 1, false));
                }
                (from, sharp) = (i, false);
            } else {
                sharp |= corner;
            }
        }
        found
    }

    /// Number of edges: positions along the chain run from 0 to this.
    fn length(&self) -> f64 {
        (self.points.len() - usize::from(!self.closed)) as f64
    }

    fn vertex(&self, i: usize) -> DVec2 {
        self.points[i % self.points.len()]
    }

    /// The point at a position.
    pub fn at(&self, s: f64) -> DVec2 {
        let i = s.floor() as usize;
        let last = self.points.len() - 1;
        if !self.closed && i >= last {
            return self.points[last];
        }
        self.vertex(i).lerp(self.vertex(i + 1), s - s.floor())
    }

    /// Whether the chord from one position to a later one stays within `tolerance`.
    fn spans(&self, from: f64, to: f64, tolerance: f64) -> bool {
        let (a, b) = (self.at(from), self.at(to));
        let chord = b - a;
        let length = chord.length();
        let (first, last) = (from.floor() as usize + 1, to.ceil() as usize);
        if last <= first {
            return true;
        }
        // A chord seen from behind by its ends would cut the corner of more than a half turn.
        let ahead = (self.vertex(first) - a).dot(chord) >= 0.0
            && (b - self.vertex(last - 1)).dot(chord) >= 0.0;
        ahead
            && (first..last).all(|i| {
                let n = self.points.len();
                chord.perp_dot(self.vertex(i) - a).abs() * self.upright[i % n] <= tolerance * length
            })
    }

    /// A farthest position up to `end` that one chord reaches: strides double while chords
    /// stay within `tolerance` and halve from the first that does not, so that finely divided
    /// walls cost little more than coarse ones.
    fn reach(&self, from: f64, end: f64, tolerance: f64) -> f64 {
        let (mut good, mut stride) = (from, 1.0);
        let mut bad = loop {
            let next = (good.floor() + stride).min(end);
            if !self.spans(from, next, tolerance) {
                break next;
            }
            if next >= end {
                return end;
            }
            (good, stride) = (next, 2.0 * stride);
        };
        while bad - good > FINE {
            let mid = 0.5 * (good + bad);
            if self.spans(from, mid, tolerance) {
                good = mid;
            } else {
                bad = mid;
            }
        }
        // A cut beside a vertex would leave an edge too short to have a direction.
        let vertex = good.round();
        if (vertex - good).abs() <= VERTEX && vertex > from {
            vertex
        } else {
            good
        }
    }

    /// Ends of the fewest chords from one position to another; `None` beyond `most`.
    fn chords(&self, from: f64, to: f64, tolerance: f64, most: usize) -> Option<Vec<f64>> {
        let mut ends = vec![from];
        let mut at = from;
        while at < to {
            if ends.len() > most {
                return None;
            }
            let next = self.reach(at, to, tolerance);
            if next <= at {
                return None;
            }
            ends.push(next);
            at = next;
        }
        Some(ends)
    }

    /// Positions that divide the chain into the fewest stretches within `tolerance`, both ends
    /// included, with the largest sagitta as small as that number allows; `None` beyond `most`.
    pub fn stretches(&self, tolerance: f64, most: usize) -> Option<Vec<f64>> {
        let start = if self.closed { self.outermost() } else { 0.0 };
        let end = start + self.length();
        let mut best = self.chords(start, end, tolerance, most)?;
        let (mut lo, mut hi) = (0.0, tolerance);
        for _ in 0..16 {
            let mid = 0.5 * (lo + hi);
            match self.chords(start, end, mid, best.len() - 1) {
                Some(found) if found.len() <= best.len() => {
                    best = found;
                    hi = mid;
                }
                _ => lo = mid,
            }
        }
        Some(best)
    }

    /// Where a whole hole is widest along the first coordinate.
    fn outermost(&self) -> f64 {
        let wide = |i: usize| even::length(self.points[i].x);
        let wider = |a: &usize, b: &usize| wide(*a).total_cmp(&wide(*b));
        (0..self.points.len()).rev().max_by(wider).unwrap_or(0) as f64
    }

    /// How many stretches remain in all, and in the worst piece, when the line
    /// {x : normal · x = offset} cuts the chain.
    pub fn remaining(&self, normal: DVec2, offset: f64, tolerance: f64) -> Option<(usize, usize)> {
        const MOST: usize = 256;
        let edges = self.length() as usize;
        let height = |i: usize| normal.dot(self.vertex(i)) - offset;
        let mut cuts: Vec<f64> = (0..edges)
            .filter_map(|i| {
                let (a, b) = (height(i), height(i + 1));
                ((a < 0.0) != (b < 0.0)).then(|| i as f64 + a / (a - b))
            })
            .collect();
        if self.closed {
            let first = *cuts.first()?;
            cuts.push(first + self.length());
        } else {
            cuts.insert(0, 0.0);
            cuts.push(self.length());
        }
        let (mut sum, mut worst) = (0, 0);
        for pair in cuts.windows(2) {
            let count = self.chords(pair[0], pair[1], tolerance, MOST)?.len() - 1;
            sum += count;
            worst = worst.max(count);
        }
        Some((sum, worst))
    }

    /// Area between the chain and its chord, or of the hole.
    pub fn hollow(&self) -> f64 {
        let n = self.points.len();
        let sum: f64 = (0..n)
            .map(|i| self.points[i].perp_dot(self.vertex(i + 1)))
            .sum();
        even::weight(0.5 * sum.abs())
    }

    /// Whether a point lies in the hollow.
    pub fn holds(&self, p: DVec2) -> bool {
        let n = self.points.len();
        let mut inside = false;
        for i in 0..n {
            let (a, b) = (self.points[i], self.vertex(i + 1));
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) {
                inside = !inside;
            }
        }
        inside
    }
}

#[cfg(test)]
mod tests {
    use super::super::section::Corner;
    use super::*;

    fn outline(points: impl Iterator<Item = DVec2>) -> Outline {
        let corner = |point| Corner {
            point,
            upright: 1.0,
            surface: true,
        };
        points.map(corner).collect()
    }

    fn arc(radius: f64, from: f64, to: f64, edges: usize) -> impl Iterator<Item = DVec2> {
        (0..=edges).map(move |i| {
            let angle = from + (to - from) * i as f64 / edges as f64;
            DVec2::new(libm::cos(angle), libm::sin(angle)) * radius
        })
    }

    const TURN: f64 = 2.0 * std::f64::consts::PI;

    #[test]
    fn a_round_hole_takes_chords_of_equal_sagitta() {
        for (radius, expected) in [(0.95, 10), (0.8, 9), (0.5, 7)] {
            // A hole runs clockwise.
            let hole = outline(arc(radius, TURN, 0.0, 256).take(256));
            let chains = Chain::of(&hole);
            assert_eq!(chains.len(), 1);
            let ends = chains[0].stretches(0.05, 64).unwrap();
            assert_eq!(ends.len() - 1, expected);
            let longest = ends.windows(2).map(|e| e[1] - e[0]).fold(0.0, f64::max);
            assert!(longest < 1.02 * 256.0 / expected as f64, "{ends:?}");
        }
    }

    #[test]
    fn outer_walls_are_no_chains_and_sharp_corners_none() {
        assert!(Chain::of(&outline(arc(1.0, 0.0, TURN, 64).take(64))).is_empty());
        let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)];
        let square = square.map(|(x, y)| DVec2::new(x, y));
        assert!(Chain::of(&outline(square.into_iter())).is_empty());
    }

    #[test]
    fn half_a_ring_is_one_open_chain() {
        let half = TURN / 2.0;
        let ring = outline(arc(1.0, 0.0, half, 64).chain(arc(0.5, half, 0.0, 64)));
        let chains = Chain::of(&ring);
        assert_eq!(chains.len(), 1);
        let ends = chains[0].stretches(0.05, 64).unwrap();
        assert_eq!(ends.len() - 1, 4);
        // The plane x = 0 halves it; one through a quarter of it leaves a stretch more.
        assert_eq!(chains[0].remaining(DVec2::X, 0.0, 0.05), Some((4, 2)));
        assert_eq!(chains[0].remaining(DVec2::X, 0.3, 0.05), Some((5, 3)));
        assert!(chains[0].holds(DVec2::new(0.0, 0.2)) && !chains[0].holds(DVec2::new(0.0, 0.7)));
    }
}

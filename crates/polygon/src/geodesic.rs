//! Shortest paths inside a simple polygon from a segment on its boundary or
//! from a vertex, to all vertices: the funnel walk of Guibas et al. 1987.
//!
//! Algorithm 5.1 of Lien & Amato splits the pocket into three and grows two
//! visibility trees, one from either end of the bridge. The same lengths come
//! from *one* tree when its root is the point at infinity behind the bridge:
//! a path from there runs down perpendicular to the bridge, or, where no
//! perpendicular is free, bends about an end of it. The two bridge ends are
//! the walls of the strip along which the parallel rays come in.

use crate::point::orient;
use crate::triangulate::triangulate;
use crate::Point;

/// The source behind the bridge, at infinity.
const BEHIND: u32 = u32::MAX;

/// Distances of all vertices of the counter-clockwise simple polygon `ring`
/// to its closing edge (last → first), within the polygon.
pub(crate) fn from_closing_edge(ring: &[Point]) -> Vec<f64> {
    let n = ring.len();
    let mut walk = Funnel::new(ring);
    walk.distance[0] = 0.0;
    walk.distance[n - 1] = 0.0;
    walk.run(&[n as u32 - 1, BEHIND, 0], 1);
    walk.distance
}

/// Distances of all vertices of the counter-clockwise simple polygon `ring`
/// to its first vertex, within the polygon.
pub(crate) fn from_first_vertex(ring: &[Point]) -> Vec<f64> {
    let n = ring.len();
    let mut walk = Funnel::new(ring);
    walk.distance[0] = 0.0;
    walk.distance[1] = ring[0].distance(ring[1]);
    walk.distance[n - 1] = ring[0].distance(ring[n - 1]);
    walk.run(&[n as u32 - 1, 0], 1);
    walk.distance
}

/// The funnel of a chord lies in `cells[left..=right]`: the path from the
/// source to the chord's left end backwards, the cusp at `cusp`, the path to
/// its right end. Both halves of a split reuse the same cells; the one cell
/// that a half overwrites is put back when it is done.
struct Funnel<'a> {
    ring: &'a [Point],
    distance: Vec<f64>,
    cells: Vec<u32>,
}

enum Step {
    Enter {
        chord: usize,
        low: u32,
        high: u32,
        left: usize,
        right: usize,
        cusp: usize,
        cell: usize,
        vertex: u32,
    },
    Restore {
        cell: usize,
        vertex: u32,
    },
}

impl<'a> Funnel<'a> {
    fn new(ring: &'a [Point]) -> Self {
        Self {
            ring,
            distance: vec![f64::INFINITY; ring.len()],
            cells: vec![0; 2 * ring.len() + 4],
        }
    }

    fn run(&mut self, start: &[u32], cusp: usize) {
        let n = self.ring.len();
        let tree = triangulate(self.ring);
        let base = n;
        self.cells[base..base + start.len()].copy_from_slice(start);
        let mut steps = vec![Step::Enter {
            chord: tree.longest(0),
            low: 0,
            high: n as u32 - 1,
            left: base,
            right: base + start.len() - 1,
            cusp: base + cusp,
            cell: base,
            vertex: start[0],
        }];
        while let Some(step) = steps.pop() {
            let (chord, low, high, left, right, cusp) = match step {
                Step::Restore { cell, vertex } => {
                    self.cells[cell] = vertex;
                    continue;
                }
                Step::Enter {
                    chord,
                    low,
                    high,
                    left,
                    right,
                    cusp,
                    cell,
                    vertex,
                } => {
                    let old = self.cells[cell];
                    self.cells[cell] = vertex;
                    steps.push(Step::Restore { cell, vertex: old });
                    (chord, low, high, left, right, cusp)
                }
            };
            let apex = tree.apex(chord);
            let touch = self.tangent(left, right, cusp, apex);
            self.distance[apex as usize] = self.length(self.cells[touch], apex);
            if apex > low + 1 {
                steps.push(Step::Enter {
                    chord: chord + 1,
                    low,
                    high: apex,
                    left: touch - 1,
                    right,
                    cusp: cusp.max(touch),
                    cell: touch - 1,
                    vertex: apex,
                });
            }
            if high > apex + 1 {
                steps.push(Step::Enter {
                    chord: tree.longest(apex),
                    low: apex,
                    high,
                    left,
                    right: touch + 1,
                    cusp: cusp.min(touch),
                    cell: touch + 1,
                    vertex: apex,
                });
            }
        }
    }

    /// The cell after which the shortest path leaves the funnel for `w`.
    fn tangent(&self, left: usize, right: usize, cusp: usize, w: u32) -> usize {
        let bends_left = |k: usize| self.turn(self.cells[k + 1], self.cells[k], w) > 0.0;
        let bends_right = |k: usize| self.turn(self.cells[k - 1], self.cells[k], w) < 0.0;
        if cusp > left && bends_left(cusp - 1) {
            // the smallest k in left..cusp that bends
            let (mut low, mut high) = (left, cusp - 1);
            while low < high {
                let middle = usize::midpoint(low, high);
                if bends_left(middle) {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            low
        } else if cusp < right && bends_right(cusp + 1) {
            let (mut low, mut high) = (cusp + 1, right);
            while low < high {
                let middle = usize::midpoint(low, high + 1);
                if bends_right(middle) {
                    low = middle;
                } else {
                    high = middle - 1;
                }
            }
            low
        } else {
            cusp
        }
    }

    fn turn(&self, from: u32, via: u32, to: u32) -> f64 {
        let (b, c) = (self.ring[via as usize], self.ring[to as usize]);
        if from == BEHIND {
            let (dx, dy) = self.bridge();
            -((c.x - b.x) * dx + (c.y - b.y) * dy)
        } else {
            orient(self.ring[from as usize], b, c)
        }
    }

    fn length(&self, from: u32, to: u32) -> f64 {
        let q = self.ring[to as usize];
        if from == BEHIND {
            let start = self.ring[self.ring.len() - 1];
            let (dx, dy) = self.bridge();
            ((q.y - start.y) * dx - (q.x - start.x) * dy).abs() / (dx * dx + dy * dy).sqrt()
        } else {
            self.distance[from as usize] + self.ring[from as usize].distance(q)
        }
    }

    fn bridge(&self) -> (f64, f64) {
        let (start, end) = (self.ring[self.ring.len() - 1], self.ring[0]);
        (end.x - start.x, end.y - start.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point::distance_to_segment;

    /// Oracle: Dijkstra over the visibility graph, every pair tested against every edge.
    fn brute_force(ring: &[Point], to_edge: bool) -> Vec<f64> {
        let n = ring.len();
        let free = |a: Point, b: Point| {
            let crossed = (0..n).any(|k| {
                let (c, d) = (ring[k], ring[(k + 1) % n]);
                orient(a, b, c) * orient(a, b, d) < 0.0 && orient(c, d, a) * orient(c, d, b) < 0.0
            });
            let middle = Point::new(f64::midpoint(a.x, b.x), f64::midpoint(a.y, b.y));
            !crossed && inside(ring, middle)
        };
        let mut distance = vec![f64::INFINITY; n];
        distance[0] = 0.0;
        if to_edge {
            let (s, e) = (ring[n - 1], ring[0]);
            distance[n - 1] = 0.0;
            for k in 1..n - 1 {
                let (dx, dy) = (e.x - s.x, e.y - s.y);
                let t = (((ring[k].x - s.x) * dx + (ring[k].y - s.y) * dy) / (dx * dx + dy * dy))
                    .clamp(0.0, 1.0);
                let foot = Point::new(s.x + t * dx, s.y + t * dy);
                let pulled = Point::new(
                    foot.x + 1e-9 * (ring[k].x - foot.x),
                    foot.y + 1e-9 * (ring[k].y - foot.y),
                );
                if free(pulled, ring[k]) {
                    distance[k] = distance_to_segment(ring[k], s, e);
                }
            }
        }
        for _ in 0..n {
            for a in 0..n {
                for b in 0..n {
                    let neighbours = (a + 1) % n == b || (b + 1) % n == a;
                    if a != b && (neighbours || free(ring[a], ring[b])) {
                        distance[b] = distance[b].min(distance[a] + ring[a].distance(ring[b]));
                    }
                }
            }
        }
        distance
    }

    fn inside(ring: &[Point], q: Point) -> bool {
        let n = ring.len();
        (0..n).fold(false, |odd, k| {
            let (a, b) = (ring[k], ring[(k + 1) % n]);
            if (a.y > q.y) == (b.y > q.y) {
                return odd;
            }
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            odd != (orient(low, high, q) > 0.0)
        })
    }

    /// A star-shaped random polygon folded into a spiral: many bends.
    fn winding(seed: u64, n: usize) -> Vec<Point> {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut outer = Vec::new();
        let mut inner = Vec::new();
        for k in 0..n {
            let t = k as f64 * 0.5;
            let r = 1.0 + 0.35 * t;
            let (a, b) = (r + 0.9 * random(), r + 1.1 + 0.9 * random());
            inner.push(Point::new(a * libm::cos(t), a * libm::sin(t)));
            outer.push(Point::new(b * libm::cos(t), b * libm::sin(t)));
        }
        inner.reverse();
        outer.extend(inner);
        outer
    }

    #[test]
    fn lemma_5_2_shortest_paths_equal_the_visibility_graph() {
        for seed in 1..30 {
            let ring = winding(seed, 6 + (seed as usize % 9));
            for turn in [0, 3, ring.len() / 2] {
                let mut ring = ring.clone();
                ring.rotate_left(turn);
                for (fast, slow) in [
                    (from_first_vertex(&ring), brute_force(&ring, false)),
                    (from_closing_edge(&ring), brute_force(&ring, true)),
                ] {
                    for (k, (a, b)) in fast.iter().zip(&slow).enumerate() {
                        assert!(
                            (a - b).abs() < 1e-6,
                            "seed {seed} turn {turn} vertex {k}: {a} {b}"
                        );
                    }
                }
            }
        }
    }
}

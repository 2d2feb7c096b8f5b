//! A baseline for benchmarks only: the minimum number of convex parts of a
//! simple polygon without Steiner points (Keil & Snoeyink 1998), by dynamic
//! programming over diagonals at notches.
//!
//! Reads `x y` lines from standard input; prints the number of parts and the
//! seconds it took, after reading.

use std::io::Read;
use std::time::Instant;

use assetpipe_polygon::{notch_visibility, orient, Point};

const INFINITE: u32 = u32::MAX / 4;

/// The best decompositions of the polygon `i … k` cut off by diagonal `(i, k)`:
/// how many diagonals they need, and the narrowest pairs of edges at its ends.
#[derive(Clone, Default)]
struct State {
    visible: bool,
    weight: u32,
    /// From narrow at `i` to narrow at `k`.
    pairs: std::collections::VecDeque<(u32, u32)>,
}

struct Table {
    points: Vec<Point>,
    reflex: Vec<bool>,
    states: Vec<State>,
}

impl Table {
    fn at(&mut self, i: usize, k: usize) -> &mut State {
        let n = self.points.len();
        &mut self.states[i * n + k]
    }

    fn turns_right(&self, a: usize, b: usize, c: usize) -> bool {
        orient(self.points[a], self.points[b], self.points[c]) < 0.0
    }

    fn offer(&mut self, i: usize, k: usize, weight: u32, pair: (usize, usize)) {
        let state = self.at(i, k);
        let pair = (pair.0 as u32, pair.1 as u32);
        if weight > state.weight {
            return;
        }
        if weight < state.weight {
            state.weight = weight;
            state.pairs.clear();
        } else {
            if state.pairs.front().is_some_and(|front| pair.0 <= front.0) {
                return;
            }
            while state.pairs.front().is_some_and(|front| front.1 >= pair.1) {
                state.pairs.pop_front();
            }
        }
        state.pairs.push_front(pair);
    }

    /// Triangle `i j k` where `i` may be a notch.
    fn type_a(&mut self, i: usize, j: usize, k: usize) {
        if !self.at(i, j).visible {
            return;
        }
        let mut top = j;
        let mut weight = self.at(i, j).weight;
        if k - j > 1 {
            if !self.at(j, k).visible {
                return;
            }
            weight += self.at(j, k).weight + 1;
        }
        if j - i > 1 {
            let pairs = std::mem::take(&mut self.at(i, j).pairs);
            let last = pairs
                .iter()
                .rev()
                .take_while(|p| !self.turns_right(p.1 as usize, j, k))
                .last()
                .copied();
            match last {
                Some(pair) if !self.turns_right(k, i, pair.0 as usize) => top = pair.0 as usize,
                _ => weight += 1,
            }
            self.at(i, j).pairs = pairs;
        }
        self.offer(i, k, weight, (top, j));
    }

    /// Triangle `i j k` where `k` is a notch and `i` is not.
    fn type_b(&mut self, i: usize, j: usize, k: usize) {
        if !self.at(j, k).visible {
            return;
        }
        let mut top = j;
        let mut weight = self.at(j, k).weight;
        if j - i > 1 {
            if !self.at(i, j).visible {
                return;
            }
            weight += self.at(i, j).weight + 1;
        }
        if k - j > 1 {
            let pairs = std::mem::take(&mut self.at(j, k).pairs);
            let last = pairs
                .iter()
                .take_while(|p| !self.turns_right(i, j, p.0 as usize))
                .last()
                .copied();
            match last {
                Some(pair) if !self.turns_right(pair.1 as usize, k, i) => top = pair.1 as usize,
                _ => weight += 1,
            }
            self.at(j, k).pairs = pairs;
        }
        self.offer(i, k, weight, (j, top));
    }
}

fn minimum_parts(ring: &[Point]) -> Result<u32, assetpipe_polygon::OutlineError> {
    let (mut points, mut seen) = notch_visibility(ring)?;
    let n = points.len();
    // the whole polygon is cut off by the edge before vertex 0, which must be a notch
    let Some(first) = seen.iter().position(|others| !others.is_empty()) else {
        return Ok(1);
    };
    points.rotate_left(first);
    seen.rotate_left(first);
    for other in seen.iter_mut().flatten() {
        *other = (*other + (n - first) as u32) % n as u32;
    }
    let reflex: Vec<bool> = (0..n)
        .map(|k| orient(points[(k + n - 1) % n], points[k], points[(k + 1) % n]) < 0.0)
        .collect();
    let empty = State {
        weight: INFINITE,
        ..State::default()
    };
    let mut table = Table {
        points,
        reflex,
        states: vec![empty; n * n],
    };
    for (a, others) in seen.iter().enumerate() {
        for &b in others {
            let (i, k) = (a.min(b as usize), a.max(b as usize));
            table.at(i, k).visible = true;
        }
    }
    for i in 0..n - 1 {
        let edge = table.at(i, i + 1);
        edge.visible = true;
        edge.weight = 0;
    }
    for i in 0..n - 2 {
        let state = table.at(i, i + 2);
        if state.visible {
            state.weight = 0;
            state.pairs.push_back((i as u32 + 1, i as u32 + 1));
        }
    }
    table.at(0, n - 1).visible = true;
    for gap in 3..n {
        for i in 0..n - gap {
            let k = i + gap;
            if !table.reflex[i] || !table.at(i, k).visible {
                continue;
            }
            if table.reflex[k] {
                (i + 1..k).for_each(|j| table.type_a(i, j, k));
            } else {
                for j in i + 1..k - 1 {
                    if table.reflex[j] {
                        table.type_a(i, j, k);
                    }
                }
                table.type_a(i, k - 1, k);
            }
        }
        for k in gap..n {
            let i = k - gap;
            if !table.reflex[k] || table.reflex[i] || !table.at(i, k).visible {
                continue;
            }
            table.type_b(i, i + 1, k);
            for j in i + 2..k {
                if table.reflex[j] {
                    table.type_b(i, j, k);
                }
            }
        }
    }
    Ok(table.at(0, n - 1).weight + 1)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let ring: Vec<Point> = numbers
        .chunks_exact(2)
        .map(|c| Point::new(c[0], c[1]))
        .collect();
    let start = Instant::now();
    let parts = minimum_parts(&ring)?;
    println!("{parts} {:.6}", start.elapsed().as_secs_f64());
    Ok(())
}

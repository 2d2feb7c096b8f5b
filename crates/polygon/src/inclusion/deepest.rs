//! The point of an outline that is farthest from its boundary.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::point::distance_to_segment;
use crate::Point;

/// Distance evaluations, each over all edges, at most this many edges in all.
const BUDGET: usize = 100_000_000;

struct Cell {
    centre: Point,
    half: f64,
    depth: f64,
    reach: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.reach.total_cmp(&other.reach))
            .then(other.centre.x.total_cmp(&self.centre.x))
            .then(other.centre.y.total_cmp(&self.centre.y))
    }
}

/// Branch and bound over squares, to 1 % of the best depth or the budget.
/// `None` when no point inside was met.
pub(super) fn deepest_point(rings: &[Vec<Point>]) -> Option<Point> {
    let points = || rings.iter().flatten();
    let least = |f: fn(&Point) -> f64| points().map(f).fold(f64::INFINITY, f64::min);
    let most = |f: fn(&Point) -> f64| points().map(f).fold(f64::NEG_INFINITY, f64::max);
    let (x0, x1) = (least(|p| p.x), most(|p| p.x));
    let (y0, y1) = (least(|p| p.y), most(|p| p.y));
    let half = (x1 - x0).min(y1 - y0) / 2.0;
    if !half.is_finite() || half <= 0.0 {
        return None;
    }
    let cell = |x: f64, y: f64, half: f64| {
        let centre = Point::new(x, y);
        let depth = depth(rings, centre);
        Cell {
            centre,
            half,
            depth,
            reach: depth + half * std::f64::consts::SQRT_2,
        }
    };
    let mut queue = BinaryHeap::new();
    let columns = (((x1 - x0) / (2.0 * half)).ceil() as usize).clamp(1, 64);
    let rows = (((y1 - y0) / (2.0 * half)).ceil() as usize).clamp(1, 64);
    let half = ((x1 - x0) / (2.0 * columns as f64)).max((y1 - y0) / (2.0 * rows as f64));
    for i in 0..columns {
        for j in 0..rows {
            let x = x0 + half * (2 * i + 1) as f64;
            queue.push(cell(x, y0 + half * (2 * j + 1) as f64, half));
        }
    }
    let mut best: Option<(f64, Point)> = None;
    let count: usize = rings.iter().map(Vec::len).sum();
    let mut left = (BUDGET / count.max(1)).max(64);
    while let Some(top) = queue.pop() {
        let deepest = best.map_or(0.0, |b| b.0);
        if top.reach <= deepest * 1.01 || left < 4 {
            break;
        }
        if top.depth > deepest {
            best = Some((top.depth, top.centre));
        }
        let h = top.half / 2.0;
        for (sx, sy) in [(-h, -h), (h, -h), (-h, h), (h, h)] {
            queue.push(cell(top.centre.x + sx, top.centre.y + sy, h));
        }
        left -= 4;
    }
    best.map(|b| b.1)
}

/// Distance to the boundary, negative outside (even-odd).
fn depth(rings: &[Vec<Point>], q: Point) -> f64 {
    let mut inside = false;
    let mut nearest = f64::INFINITY;
    for ring in rings {
        let Some(&last) = ring.last() else {
            continue;
        };
        let mut a = last;
        for &b in ring {
            nearest = nearest.min(distance_to_segment(q, a, b));
            if (a.y > q.y) != (b.y > q.y) {
                let x = a.x + (q.y - a.y) / (b.y - a.y) * (b.x - a.x);
                inside ^= q.x < x;
            }
            a = b;
        }
    }
    if inside {
        nearest
    } else {
        -nearest
    }
}

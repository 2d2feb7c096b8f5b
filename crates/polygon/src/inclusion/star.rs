//! The maximum-area convex subset of a star-shaped polygon, approximately:
//! the kernel grows, and each reflex vertex it reaches gets the chord that
//! costs least area (§5.1). O(k·n) for k reflex vertices.

use super::chords::{Chord, Links};
use super::kernel::{distance_to_kernel, kernel};
use crate::point::orient;
use crate::Point;

/// A convex subset and the kernel it grew from.
#[derive(Clone, Debug)]
pub struct ConvexSubset {
    /// Counter-clockwise.
    pub polygon: Vec<Point>,
    /// The kernel; a subset of the optimum (Theorem 4) and of `polygon`.
    pub kernel: Vec<Point>,
}

/// A convex subset of large area of the polygon `ring`, counter-clockwise and
/// simple. `None` if it is not star-shaped with a kernel that has area.
pub fn convex_subset_of_star(ring: &[Point]) -> Option<ConvexSubset> {
    let kernel = kernel(ring);
    (kernel.len() > 2).then(|| grow(ring, kernel))
}

/// The same where `eye` is known to see all of `ring`, however small the kernel.
pub(super) fn convex_subset_about(ring: &[Point], eye: Point) -> Option<ConvexSubset> {
    if ring.len() < 3 {
        return None;
    }
    let kernel = kernel(ring);
    let kernel = if kernel.len() > 2 { kernel } else { vec![eye] };
    Some(grow(ring, kernel))
}

fn grow(ring: &[Point], kernel: Vec<Point>) -> ConvexSubset {
    let mut links = Links::new(ring);
    let distances = distance_to_kernel(ring, &kernel);
    let is_reflex = |links: &Links, k: usize| {
        links.is_there(k)
            && orient(
                links.points[links.previous(k)],
                links.points[k],
                links.points[links.next(k)],
            ) < 0.0
    };
    let mut order: Vec<usize> = (0..ring.len()).filter(|&k| is_reflex(&links, k)).collect();
    order.sort_by(|&a, &b| distances[a].0.total_cmp(&distances[b].0).then(a.cmp(&b)));
    let tangent: Vec<Option<(f64, f64)>> = (0..ring.len())
        .map(|k| wavefront(ring[k], &kernel, distances[k].1))
        .collect();
    let mut queue = order.into_iter().peekable();
    while let Some(r1) = queue.next() {
        if !is_reflex(&links, r1) {
            continue;
        }
        while queue.peek().is_some_and(|&k| !is_reflex(&links, k)) {
            queue.next();
        }
        let r2 = queue.peek().copied();
        let mut best: Option<(f64, Chord, bool)> = None;
        let mut offer = |area: f64, chord: Chord, double: bool| {
            if best.as_ref().is_none_or(|b| area < b.0) {
                best = Some((area, chord, double));
            }
        };
        for chord in chords(&links, r1, tangent[r1]) {
            let Some(first) = links.cut(r1, &chord) else {
                continue;
            };
            let mut second = 0.0;
            if let Some(r2) = r2.filter(|&k| is_reflex(&links, k)) {
                second = f64::INFINITY;
                for chord in chords(&links, r2, tangent[r2]) {
                    if let Some(cut) = links.cut(r2, &chord) {
                        second = second.min(cut.removed_area);
                        links.undo(&cut);
                    }
                }
            }
            offer(first.removed_area + second, chord, false);
            links.undo(&first);
        }
        if let Some(r2) = r2 {
            let chord = through_both(ring[r1], ring[r2], kernel[0]);
            if let Some(first) = links.cut(r1, &chord) {
                if let Some(second) = links.cut(r2, &chord) {
                    offer(first.removed_area + second.removed_area, chord, true);
                    links.undo(&second);
                } else if !is_reflex(&links, r2) {
                    offer(first.removed_area, chord, false);
                }
                links.undo(&first);
            }
        }
        if let Some((_, chord, double)) = best {
            links.cut(r1, &chord);
            if let (true, Some(r2)) = (double, r2) {
                links.cut(r2, &chord);
            }
        }
    }
    let polygon = links.ring().into_iter().map(|k| links.points[k]).collect();
    ConvexSubset {
        polygon: convexified(polygon),
        kernel,
    }
}

/// The extremal chords along the two edges at `r` and the single-pivot one.
fn chords(links: &Links, r: usize, tangent: Option<(f64, f64)>) -> impl Iterator<Item = Chord> {
    let through = links.points[r];
    let (p, q) = (links.points[links.previous(r)], links.points[links.next(r)]);
    let extremal = [
        (through.x - p.x, through.y - p.y),
        (q.x - through.x, q.y - through.y),
    ];
    extremal
        .into_iter()
        .chain(tangent)
        .map(move |direction| Chord { through, direction })
}

/// The double-pivot chord, directed so that the kernel is left of it.
fn through_both(r1: Point, r2: Point, inside: Point) -> Chord {
    let chord = Chord {
        through: r1,
        direction: (r2.x - r1.x, r2.y - r1.y),
    };
    if chord.side(inside) >= 0.0 {
        chord
    } else {
        Chord {
            through: r1,
            direction: (r1.x - r2.x, r1.y - r2.y),
        }
    }
}

/// The direction at `r` of the wavefront of the growing kernel, kernel on the
/// left (Fig. 14); `edge` is the kernel edge nearest to `r`.
fn wavefront(r: Point, kernel: &[Point], edge: usize) -> Option<(f64, f64)> {
    let m = kernel.len();
    let (a, b) = (kernel[edge], kernel[(edge + 1) % m]);
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let along = (r.x - a.x) * dx + (r.y - a.y) * dy;
    let squared = dx * dx + dy * dy;
    if along > 0.0 && along < squared {
        return Some((dx, dy));
    }
    let corner = if along <= 0.0 { edge } else { (edge + 1) % m };
    let v = kernel[corner];
    let (nx, ny) = (v.x - r.x, v.y - r.y);
    if nx != 0.0 || ny != 0.0 {
        return Some((ny, -nx));
    }
    // on a kernel vertex: the mean of the slopes of its two edges
    let unit = |p: Point, q: Point| {
        let length = p.distance(q);
        ((q.x - p.x) / length, (q.y - p.y) / length)
    };
    if m < 2 {
        return None;
    }
    let (before, after) = (kernel[(corner + m - 1) % m], kernel[(corner + 1) % m]);
    let (e1, e2) = (unit(before, v), unit(v, after));
    Some((e1.0 + e2.0, e1.1 + e2.1))
}

/// Removes the vertices that rounding has left reflex by an ulp: each becomes
/// the chord along the edge before it.
fn convexified(polygon: Vec<Point>) -> Vec<Point> {
    let mut links = Links::new(&polygon);
    if polygon.len() < 3 {
        return polygon;
    }
    let mut pending: Vec<usize> = (0..polygon.len()).rev().collect();
    // a cut may leave a corner reflex by the rounding of its own ends
    let mut patience = 8 * polygon.len();
    while let Some(k) = pending.pop() {
        if patience == 0 {
            break;
        }
        patience -= 1;
        if !links.is_there(k) {
            continue;
        }
        let (p, q) = (links.previous(k), links.next(k));
        if p == q || orient(links.points[p], links.points[k], links.points[q]) >= 0.0 {
            continue;
        }
        let best = chords(&links, k, None)
            .filter_map(|chord| {
                let cut = links.cut(k, &chord)?;
                links.undo(&cut);
                Some((cut.removed_area, chord))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, chord)) = best {
            let known = links.points.len();
            links.cut(k, &chord);
            pending.extend(known..links.points.len());
            pending.extend([p, q]);
        }
    }
    links.ring().into_iter().map(|k| links.points[k]).collect()
}

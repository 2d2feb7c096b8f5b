//! Triangulation of a simple polygon in O(n log n): a sweep cuts it into
//! x-monotone pieces, each of which falls apart in linear time.
//! (de Berg et al., Computational Geometry, ch. 3.) Signs are exact.

use crate::point::orient;
use crate::Point;

/// A triangulation as a binary tree over chords: the chord `(low, high)` has
/// its triangle's third corner `apex` with `low < apex < high`, and the two
/// other sides are its children. The root chord is `(0, n - 1)`.
pub(crate) struct ChordTree {
    /// Per vertex `low`, where its chords begin in `chords`.
    first: Vec<u32>,
    /// `(high, apex)` sorted by `low`, then by falling `high`.
    chords: Vec<(u32, u32)>,
}

impl ChordTree {
    /// The index of chord `(low, high)`, which must be the longest of `low`.
    pub fn longest(&self, low: u32) -> usize {
        self.first[low as usize] as usize
    }

    /// The third corner of the triangle at chord number `chord`.
    pub fn apex(&self, chord: usize) -> u32 {
        self.chords[chord].1
    }
}

/// Triangulates the polygon with vertices `ring`, counter-clockwise, strictly
/// simple, at least three.
pub(crate) fn triangulate(ring: &[Point]) -> ChordTree {
    let n = ring.len();
    let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(n.saturating_sub(2));
    if n == 3 {
        triangles.push([0, 1, 2]);
    } else {
        let mut diagonals = monotone_diagonals(ring);
        monotone_pieces(n, &mut diagonals, |piece| {
            triangulate_monotone(ring, piece, &mut triangles);
        });
    }
    debug_assert_eq!(triangles.len(), n - 2);
    let mut first = vec![0_u32; n + 1];
    for t in &triangles {
        first[t[0] as usize + 1] += 1;
    }
    for k in 0..n {
        first[k + 1] += first[k];
    }
    let mut slot = first.clone();
    let mut chords = vec![(0, 0); triangles.len()];
    for [low, apex, high] in triangles {
        let at = &mut slot[low as usize];
        chords[*at as usize] = (high, apex);
        *at += 1;
    }
    for k in 0..n {
        let (from, to) = (first[k] as usize, first[k + 1] as usize);
        if to - from > 1 {
            chords[from..to].sort_unstable_by(|a, b| b.cmp(a));
        }
    }
    ChordTree { first, chords }
}

/// An edge that crosses the sweep line with the interior above it.
struct Below {
    from: u32,
    to: u32,
    helper: u32,
    helper_merges: bool,
}

/// Diagonals `(low, high)` that cut the polygon into x-monotone pieces.
fn monotone_diagonals(ring: &[Point]) -> Vec<(u32, u32)> {
    let n = ring.len();
    let mut order: Vec<u32> = (0..n as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (ring[a as usize], ring[b as usize]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
    });
    let mut diagonals = Vec::new();
    let mut status: Vec<Below> = Vec::new();
    for v in order {
        let here = ring[v as usize];
        let previous = (v + n as u32 - 1) % n as u32;
        let next = (v + 1) % n as u32;
        let (p, q) = (ring[previous as usize], ring[next as usize]);
        // number of status edges strictly below the vertex
        let rank = status.partition_point(|edge| {
            orient(ring[edge.from as usize], ring[edge.to as usize], here) > 0.0
        });
        let mut add = |a: u32, b: u32| diagonals.push((a.min(b), a.max(b)));
        match (p.precedes(here), q.precedes(here)) {
            (false, false) => {
                let splits = orient(p, here, q) < 0.0;
                if splits && rank > 0 {
                    let below = &mut status[rank - 1];
                    add(v, below.helper);
                    below.helper = v;
                    below.helper_merges = false;
                }
                let edge = Below {
                    from: v,
                    to: next,
                    helper: v,
                    helper_merges: false,
                };
                status.insert(rank, edge);
            }
            (true, true) => {
                let ended = status.remove(rank.min(status.len() - 1));
                if ended.helper_merges {
                    add(v, ended.helper);
                }
                let merges = orient(p, here, q) < 0.0;
                if merges && rank > 0 {
                    let below = &mut status[rank - 1];
                    if below.helper_merges {
                        add(v, below.helper);
                    }
                    below.helper = v;
                    below.helper_merges = true;
                }
            }
            (true, false) => {
                let last = status.len() - 1;
                let edge = &mut status[rank.min(last)];
                if edge.helper_merges {
                    add(v, edge.helper);
                }
                *edge = Below {
                    from: v,
                    to: next,
                    helper: v,
                    helper_merges: false,
                };
            }
            (false, true) => {
                if rank > 0 {
                    let below = &mut status[rank - 1];
                    if below.helper_merges {
                        add(v, below.helper);
                    }
                    below.helper = v;
                    below.helper_merges = false;
                }
            }
        }
    }
    diagonals
}

/// Calls `piece` with the ascending vertices of every region between chords.
fn monotone_pieces(n: usize, diagonals: &mut Vec<(u32, u32)>, mut piece: impl FnMut(&[u32])) {
    // by low vertex, longest first: the next entry of a list is the next chord inside
    diagonals.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.cmp(&a.1)));
    diagonals.dedup();
    let mut first = vec![0_usize; n + 1];
    for d in diagonals.iter() {
        first[d.0 as usize + 1] += 1;
    }
    for k in 0..n {
        first[k + 1] += first[k];
    }
    let mut region = Vec::new();
    let mut gather = |low: u32, high: u32, skip: usize| {
        region.clear();
        region.push(low);
        let mut at = low;
        let mut chord = skip;
        while at != high {
            let longest = diagonals[chord..first[at as usize + 1]].first();
            at = longest.map_or(at + 1, |d| d.1);
            region.push(at);
            chord = first[at as usize];
        }
        piece(&region);
    };
    gather(0, n as u32 - 1, 0);
    for (k, d) in diagonals.iter().enumerate() {
        gather(d.0, d.1, k + 1);
    }
}

fn triangulate_monotone(ring: &[Point], piece: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let m = piece.len();
    let at = |k: usize| ring[piece[k] as usize];
    let mut emit = |a: usize, b: usize, c: usize| {
        let mut t = [piece[a], piece[b], piece[c]];
        t.sort_unstable();
        triangles.push(t);
    };
    if m == 3 {
        emit(0, 1, 2);
        return;
    }
    let (mut low, mut high) = (0, 0);
    for k in 1..m {
        if at(k).precedes(at(low)) {
            low = k;
        }
        if at(high).precedes(at(k)) {
            high = k;
        }
    }
    // merge the lower chain (low → high, ascending) with the upper one
    let (mut lower, mut upper) = ((low + 1) % m, (low + m - 1) % m);
    let mut stack: Vec<(usize, bool)> = vec![(low, true)];
    for step in 1..m {
        let take_lower = if step == m - 1 {
            // the last vertex closes against the chain not on the stack's top
            !stack[stack.len() - 1].1
        } else if lower == high {
            false
        } else if upper == high {
            true
        } else {
            at(lower).precedes(at(upper))
        };
        let v = if step == m - 1 {
            high
        } else if take_lower {
            let v = lower;
            lower = (lower + 1) % m;
            v
        } else {
            let v = upper;
            upper = (upper + m - 1) % m;
            v
        };
        let top = stack[stack.len() - 1];
        if step > 1 && top.1 != take_lower {
            for pair in stack.windows(2) {
                emit(v, pair[0].0, pair[1].0);
            }
            stack.clear();
            stack.push(top);
        } else {
            while stack.len() > 1 {
                let (b, a) = (stack[stack.len() - 1].0, stack[stack.len() - 2].0);
                let turn = orient(at(a), at(b), at(v));
                if (take_lower && turn > 0.0) || (!take_lower && turn < 0.0) {
                    emit(v, a, b);
                    stack.pop();
                } else {
                    break;
                }
            }
        }
        stack.push((v, take_lower));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point::signed_area;

    fn area_of(ring: &[Point]) -> f64 {
        let tree = triangulate(ring);
        assert_eq!(tree.chords.len(), ring.len() - 2);
        let mut total = 0.0;
        for low in 0..ring.len() {
            for k in tree.first[low]..tree.first[low + 1] {
                let (high, apex) = tree.chords[k as usize];
                let doubled = orient(ring[low], ring[apex as usize], ring[high as usize]);
                assert!(doubled >= 0.0, "flipped triangle");
                total += doubled / 2.0;
            }
        }
        total
    }

    #[test]
    fn combs_spirals_and_stars_are_covered_once() {
        let mut comb = vec![Point::new(0.0, -1.0), Point::new(40.0, -1.0)];
        for k in (0..40).rev() {
            comb.push(Point::new(f64::from(k) + 0.75, 9.0 + f64::from(k % 3)));
            comb.push(Point::new(f64::from(k) + 0.5, 0.0));
        }
        let mut star: Vec<Point> = Vec::new();
        let mut spiral: Vec<Point> = Vec::new();
        for k in 0..60 {
            let t = f64::from(k) * std::f64::consts::TAU / 60.0;
            let r = if k % 2 == 0 {
                1.0
            } else {
                0.2 + f64::from(k) / 100.0
            };
            star.push(Point::new(r * libm::cos(t), r * libm::sin(t)));
            let t = f64::from(k) * 0.35;
            spiral.push(Point::new(
                (1.0 + t) * libm::cos(t),
                (1.0 + t) * libm::sin(t),
            ));
        }
        for k in (0..60).rev() {
            let t = f64::from(k) * 0.35;
            spiral.push(Point::new(
                (3.0 + t) * libm::cos(t),
                (3.0 + t) * libm::sin(t),
            ));
        }
        spiral.reverse();
        for ring in [comb, star, spiral] {
            for turn in 0..ring.len() {
                let mut turned = ring.clone();
                turned.rotate_left(turn);
                let exact = signed_area(&ring);
                assert!((area_of(&turned) - exact).abs() < 1e-9 * exact.abs());
            }
        }
    }
}

//! Where boundary edges cross.

use std::cmp::Ordering;

use glam::DVec2;

/// Ends this many ulps of the largest coordinate away from another segment are on it.
const NEAR: f64 = 8.0 * f64::EPSILON;
/// After this many rounds of new crossings, ends snap from farther and farther.
const PATIENCE: u32 = 16;

/// Points where boundary edges cross, old ones where these are near enough.
pub(super) struct Crossings<'a> {
    points: &'a [DVec2],
    order: &'a [u32],
    near: f64,
    added: Vec<DVec2>,
}

impl<'a> Crossings<'a> {
    /// `order` is ascending by [`compare`].
    pub(super) fn new(points: &'a [DVec2], order: &'a [u32], round: u32) -> Self {
        let largest = order
            .iter()
            .map(|p| points[*p as usize].abs().max_element())
            .fold(0.0, f64::max);
        let widened = f64::from(1u32 << round.saturating_sub(PATIENCE).min(31));
        Self {
            points,
            order,
            near: NEAR * widened * largest,
            added: Vec::new(),
        }
    }

    /// Points that were added, numbered after the old ones.
    pub(super) fn into_added(self) -> Vec<DVec2> {
        self.added
    }

    /// The point, old or new, at which two crossing segments meet.
    ///
    /// An end that is on the other segment but for rounding is taken as it
    /// is. Otherwise nearly parallel segments, rounded where they cross, would
    /// cross again an ulp further on, and again.
    pub(super) fn between(&mut self, first: [u32; 2], second: [u32; 2]) -> u32 {
        let [a, b] = first.map(|p| self.points[p as usize]);
        let [c, d] = second.map(|p| self.points[p as usize]);
        let ends = [
            (first[0], distance(a, c, d)),
            (first[1], distance(b, c, d)),
            (second[0], distance(c, a, b)),
            (second[1], distance(d, a, b)),
        ];
        let nearest = ends
            .into_iter()
            .filter(|(_, distance)| *distance <= self.near)
            .min_by(|p, q| p.1.total_cmp(&q.1));
        match nearest {
            Some((end, _)) => end,
            None => self.index(meet([a, b], [c, d])),
        }
    }

    /// The index of a position, added if it is new.
    fn index(&mut self, position: DVec2) -> u32 {
        let points = self.points;
        let found = self
            .order
            .binary_search_by(|&p| compare(points[p as usize], position));
        if let Ok(index) = found {
            return self.order[index];
        }
        let known = self.added.iter().position(|p| *p == position);
        let new = known.unwrap_or_else(|| {
            self.added.push(position);
            self.added.len() - 1
        });
        (points.len() + new) as u32
    }
}

/// Ascending by (x, y).
pub(super) fn compare(a: DVec2, b: DVec2) -> Ordering {
    // Adding zero makes both zeros one.
    (a.x + 0.0)
        .total_cmp(&(b.x + 0.0))
        .then((a.y + 0.0).total_cmp(&(b.y + 0.0)))
}

/// Where two segments cross, rounded within the boxes of both.
fn meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> DVec2 {
    let (u, v) = (b - a, d - c);
    // Brought to size one, or products might overflow or vanish.
    let size = u.abs().max_element();
    let along = ((c - a) / size).perp_dot(v / v.abs().max_element());
    let t = along / (u / size).perp_dot(v / v.abs().max_element());
    let t = if t.is_finite() {
        t.clamp(0.0, 1.0)
    } else {
        0.5
    };
    let low = a.min(b).max(c.min(d));
    let high = a.max(b).min(c.max(d));
    (a + u * t).max(low).min(high)
}

/// The distance of `p` from the line through `a` and `b`; infinite outside of
/// the box of these two.
///
/// A segment is only ever divided at points of its box, which makes both
/// halves strictly shorter (by the sum of extents): no chain of divisions
/// comes back to where it was.
fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let in_box = p == p.clamp(a.min(b), a.max(b)) && p != a && p != b;
    match (b - a).try_normalize() {
        Some(along) if in_box => along.perp_dot(p - a).abs(),
        _ => f64::INFINITY,
    }
}

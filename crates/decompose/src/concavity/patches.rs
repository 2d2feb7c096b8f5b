//! The largest distance of the points of some triangles to a set.
//!
//! Branch and bound over triangles cut in two at their longest edge. The set is
//! a union of convex ones, so the bounds of [`mixture`] hold.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use assetpipe_geometry::DVec3;

use super::goal::Goal;
use super::{mixture, Interval, Limits};

/// A union of convex sets.
pub(super) trait Union {
    /// The member nearest to `q`, and its distance; `guess` is one that may be
    /// near.
    fn nearest(&self, q: DVec3, guess: u32) -> (u32, f64);
    /// Distance to one member: a convex function of `q`.
    fn distance(&self, member: u32, q: DVec3) -> f64;
}

/// The result: the interval, and the farthest point found with the lower bound
/// of its distance.
pub(super) struct Found {
    pub interval: Interval,
    pub witness: Option<(DVec3, f64)>,
}

struct Patch {
    corners: [DVec3; 3],
    guess: u32,
    upper: f64,
    serial: usize,
}

impl PartialEq for Patch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Patch {}
impl PartialOrd for Patch {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Patch {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper
            .total_cmp(&other.upper)
            .then(other.serial.cmp(&self.serial))
    }
}

/// The largest distance to `union` over all points of `triangles`. At least
/// `known`, which spares the work below it: the interval is that of the maximum
/// of both.
pub(super) fn farthest(
    union: &impl Union,
    triangles: impl Iterator<Item = [DVec3; 3]>,
    known: f64,
    slack: f64,
    goal: Goal,
    limits: &Limits,
) -> Found {
    let mut search = Search {
        union,
        goal,
        slack,
        queue: BinaryHeap::new(),
        settled: 0.0,
        lower: known,
        witness: None,
        examined: 0,
        rows: Vec::new(),
        tableau: mixture::Tableau::default(),
    };
    for corners in triangles {
        search.examine(corners, 0, f64::INFINITY);
    }
    while let Some(patch) = search.queue.pop() {
        if patch.upper <= search.target() {
            search.settled = search.settled.max(patch.upper);
            continue;
        }
        if search.goal.is_settled(search.lower) || limits.reached(search.examined) {
            search.settled = search.settled.max(patch.upper);
            break;
        }
        for half in halves(patch.corners) {
            search.examine(half, patch.guess, patch.upper);
        }
    }
    Found {
        interval: Interval {
            lower: search.lower,
            upper: (search.settled + slack).max(search.lower),
        },
        witness: search.witness.map(|w| (w, search.lower)),
    }
}

struct Search<'a, U> {
    union: &'a U,
    goal: Goal,
    slack: f64,
    queue: BinaryHeap<Patch>,
    settled: f64,
    lower: f64,
    witness: Option<DVec3>,
    examined: usize,
    rows: Vec<Vec<f64>>,
    tableau: mixture::Tableau,
}

impl<U: Union> Search<'_, U> {
    fn target(&self) -> f64 {
        self.goal.target(self.lower, self.slack)
    }

    /// Distance at a point of the domain: also a lower bound of the result.
    fn probe(&mut self, q: DVec3, guess: u32) -> (u32, f64) {
        let (member, distance) = self.union.nearest(q, guess);
        if distance - self.slack > self.lower {
            self.lower = distance - self.slack;
            self.witness = Some(q);
        }
        (member, distance)
    }

    fn examine(&mut self, corners: [DVec3; 3], guess: u32, above: f64) {
        self.examined += 1;
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        let (first, distance) = self.probe(centre, guess);
        let radius = corners
            .iter()
            .fold(0.0f64, |r, c| r.max(c.distance(centre)));
        let mut upper = above.min(distance + radius);
        let target = self.target();
        let mut members = [first; mixture::MOST];
        let mut count = 0;
        while upper > target && count < mixture::MOST {
            let member = members[count];
            if self.rows.len() <= count {
                self.rows.push(Vec::new());
            }
            let row = &mut self.rows[count];
            row.clear();
            row.extend(corners.iter().map(|c| self.union.distance(member, *c)));
            count += 1;
            upper = upper.min(mixture::upper_bound(&self.rows[..count], &mut self.tableau));
            if upper <= target || count == mixture::MOST {
                break;
            }
            let rows = &self.rows[..count];
            let nearest = |i: usize| rows.iter().fold(f64::INFINITY, |d, r| d.min(r[i]));
            let worst = (0..3)
                .max_by(|a, b| nearest(*a).total_cmp(&nearest(*b)))
                .unwrap_or(0);
            let (next, _) = self.probe(corners[worst], member);
            if members[..count].contains(&next) {
                break;
            }
            members[count] = next;
        }
        if upper <= self.target() {
            self.settled = self.settled.max(upper);
            return;
        }
        self.queue.push(Patch {
            corners,
            guess: first,
            upper,
            serial: self.examined,
        });
    }
}

/// Cut at the middle of the longest edge.
fn halves([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 2] {
    let (ab, bc, ca) = (
        a.distance_squared(b),
        b.distance_squared(c),
        c.distance_squared(a),
    );
    let (a, b, c) = if ab >= bc && ab >= ca {
        (a, b, c)
    } else if bc >= ca {
        (b, c, a)
    } else {
        (c, a, b)
    };
    let m = (a + b) * 0.5;
    [[a, m, c], [m, b, c]]
}

//! How deep below the surface of its hull the surface of a part lies.
//!
//! Inside a convex polytope the distance to its boundary is the least distance
//! to the planes of its faces: a minimum of linear functions. Over a box of the
//! part's hierarchy it is bounded by any one of them; over a triangle its
//! maximum is a linear program, solved exactly with the few planes that matter.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

use assetpipe_geometry::bvh::{Branch, Bvh};
use assetpipe_geometry::distance::{ConvexBody, HalfSpace};
use assetpipe_geometry::DVec3;

use super::goal::Goal;
use super::patches::Found;
use super::{mixture, Interval, Limits};

/// Planes brought into one linear program at most; each round adds one.
const ROUNDS: usize = 32;

/// sup over the points of `surface` of the distance to the boundary of `body`,
/// which holds them all. At least `known`, which spares the work below it: the
/// interval is that of the maximum of both.
pub(super) fn deepest(
    surface: &Bvh,
    body: &ConvexBody,
    known: f64,
    slack: f64,
    goal: Goal,
    limits: &Limits,
) -> Found {
    let mut search = Search {
        surface,
        spaces: body.half_spaces(),
        goal,
        slack,
        planes: (0..body.half_spaces().len() as u32).collect(),
        queue: BinaryHeap::new(),
        settled: 0.0,
        lower: known,
        witness: None,
        examined: 0,
        rows: Vec::new(),
        tableau: mixture::Tableau::default(),
    };
    if !surface.is_empty() {
        search.examine(0, 0..search.planes.len());
    }
    while let Some(node) = search.queue.pop() {
        if node.upper <= search.target() {
            search.settled = search.settled.max(node.upper);
            continue;
        }
        if search.goal.is_settled(search.lower) || limits.reached(search.examined) {
            search.settled = search.settled.max(node.upper);
            break;
        }
        match surface.branch(node.index) {
            Branch::Fork(children) => {
                for child in children {
                    search.examine(child, node.planes.clone());
                }
            }
            Branch::Leaf(slots) => {
                for slot in slots {
                    search.triangle(slot, node.planes.clone());
                }
            }
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

struct Node {
    index: u32,
    planes: Range<usize>,
    upper: f64,
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Node {}
impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Node {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper
            .total_cmp(&other.upper)
            .then(other.index.cmp(&self.index))
    }
}

struct Search<'a> {
    surface: &'a Bvh,
    spaces: &'a [HalfSpace],
    goal: Goal,
    slack: f64,
    /// Lists of the half-spaces that can be nearest somewhere in a node.
    planes: Vec<u32>,
    queue: BinaryHeap<Node>,
    settled: f64,
    lower: f64,
    witness: Option<DVec3>,
    examined: usize,
    rows: Vec<Vec<f64>>,
    tableau: mixture::Tableau,
}

impl Search<'_> {
    fn target(&self) -> f64 {
        self.goal.target(self.lower, self.slack)
    }

    fn examine(&mut self, index: u32, planes: Range<usize>) {
        self.examined += 1;
        let bounds = self.surface.node_bounds(index);
        let (centre, half) = (bounds.centre(), (bounds.hi - bounds.lo) * 0.5);
        let depths = |space: &HalfSpace| {
            let middle = space.offset - space.normal.dot(centre);
            let spread = space.normal.abs().dot(half);
            (middle - spread, middle + spread)
        };
        let upper = self.planes[planes.clone()]
            .iter()
            .map(|p| depths(&self.spaces[*p as usize]).1)
            .fold(f64::INFINITY, f64::min);
        if upper <= self.target() {
            self.settled = self.settled.max(upper);
            return;
        }
        let start = self.planes.len();
        for at in planes {
            let plane = self.planes[at];
            if depths(&self.spaces[plane as usize]).0 <= upper {
                self.planes.push(plane);
            }
        }
        self.queue.push(Node {
            index,
            planes: start..self.planes.len(),
            upper,
        });
    }

    /// The half-space nearest to `q` and its distance, a lower bound of the
    /// result if `q` is of the surface.
    fn nearest(&self, q: DVec3, planes: &Range<usize>) -> (u32, f64) {
        self.planes[planes.clone()]
            .iter()
            .map(|p| {
                let space = &self.spaces[*p as usize];
                (*p, space.offset - space.normal.dot(q))
            })
            .fold((u32::MAX, f64::INFINITY), |best, next| {
                if next.1 < best.1 {
                    next
                } else {
                    best
                }
            })
    }

    /// max over the triangle of min over the half-spaces, exactly: add the
    /// half-space that the solution so far breaks most until none is broken.
    fn triangle(&mut self, slot: u32, planes: Range<usize>) {
        let corners = self.surface.triangle(slot).corners();
        let mut chosen = [u32::MAX; mixture::MOST];
        let mut count = 0;
        let mut point = (corners[0] + corners[1] + corners[2]) / 3.0;
        let mut upper = f64::INFINITY;
        for _ in 0..ROUNDS {
            self.examined += 1;
            let (plane, depth) = self.nearest(point, &planes);
            if depth - self.slack > self.lower {
                self.lower = depth - self.slack;
                self.witness = Some(point);
            }
            let finished = upper <= self.target() || chosen[..count].contains(&plane);
            if finished || plane == u32::MAX {
                break;
            }
            if count == mixture::MOST {
                count = self.drop_idle(&mut chosen);
            }
            if self.rows.len() <= count {
                self.rows.push(Vec::new());
            }
            let space = self.spaces[plane as usize];
            self.rows[count].clear();
            self.rows[count].extend(corners.map(|c| space.offset - space.normal.dot(c)));
            chosen[count] = plane;
            count += 1;
            let rows = &self.rows[..count];
            upper = upper.min(mixture::upper_bound(rows, &mut self.tableau));
            point = self.solution(corners, count);
        }
        self.settled = self.settled.max(upper);
    }

    /// The point of the triangle that solves the game just played.
    fn solution(&mut self, corners: [DVec3; 3], count: usize) -> DVec3 {
        let rows = &self.rows[..count];
        let scale = rows.iter().flatten().fold(0.0f64, |s, f| s.max(f.abs()));
        self.tableau.solve(rows, scale.max(f64::MIN_POSITIVE));
        let mut weights = [0.0; 3];
        self.tableau.corner_weights(count, &mut weights);
        let total: f64 = weights.iter().sum();
        if total > 0.0 {
            (corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]) / total
        } else {
            (corners[0] + corners[1] + corners[2]) / 3.0
        }
    }

    /// Keep the half-spaces with weight in the solution (three at most).
    fn drop_idle(&mut self, chosen: &mut [u32; mixture::MOST]) -> usize {
        let weights = self.tableau.row_weights(mixture::MOST);
        let mut kept = 0;
        for (j, weight) in weights.into_iter().enumerate() {
            if weight > 0.0 && kept < 3 {
                chosen.swap(kept, j);
                self.rows.swap(kept, j);
                kept += 1;
            }
        }
        kept.max(1)
    }
}

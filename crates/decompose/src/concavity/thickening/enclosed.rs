//! Cells that belong to the solid but for a rim along their sides.

use std::ops::Range;

use assetpipe_geometry::bvh::{Branch, Bvh};
use assetpipe_geometry::distance::{HalfSpace, SolidIndex, Triangle};
use assetpipe_geometry::DVec3;

use super::cell::Polytope;

/// Steps of the projection onto the inner part of a cell.
const STEPS: usize = 12;

/// Half-spaces held against boxes in one look at most.
const WORK: usize = 20_000;

/// Why no inner part is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blocked {
    /// This triangle reaches too deep into it.
    By(u32),
    /// Too much work, corners too sharp, or free space.
    Unclear,
}

/// Looks at the surface inside a cell, and the inner part of the cell that is
/// found to be solid.
#[derive(Default)]
pub(super) struct Inner {
    /// The half-spaces that cut the cell, then the sides of its box.
    sides: Vec<HalfSpace>,
    /// How many of them are half-spaces.
    cuts: usize,
    /// How far the half-spaces are moved inward, and the sides of the box.
    depth: f64,
    margin: f64,
    /// A point of the inner part.
    middle: DVec3,
    /// Per node on the stack: the sides that can be near to what is in it.
    near: Vec<u32>,
    stack: Vec<(u32, usize, usize)>,
}

impl Inner {
    /// Find the part of a cell, its half-spaces moved inward by as little as
    /// possible and not more than `most`, that belongs to the solid as a whole.
    ///
    /// If all surface inside the cell is at most δ below one or the other of its
    /// half-spaces, then what is left with these moved inward by δ is all solid
    /// or all free. Surface on the sides of the box is forgiven if it is not
    /// more than `margin` inside.
    pub(super) fn find(
        &mut self,
        solid: &SolidIndex,
        cell: &Polytope,
        most: f64,
        margin: f64,
        suspects: [u32; 2],
    ) -> Result<(), Blocked> {
        self.cuts = cell.spaces.len();
        self.margin = margin;
        self.sides.clear();
        self.sides.extend_from_slice(&cell.spaces);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            self.sides.push(HalfSpace {
                normal: axis,
                offset: axis.dot(cell.bounds.hi),
            });
            self.sides.push(HalfSpace {
                normal: -axis,
                offset: -axis.dot(cell.bounds.lo),
            });
        }
        self.near.clear();
        self.near.extend(0..self.sides.len() as u32);
        let corners = &cell.corners;
        for suspect in suspects {
            let triangle = solid.bvh().triangle(suspect);
            if self.depth_of(triangle, 0..self.near.len(), corners) > most {
                return Err(Blocked::By(suspect));
            }
        }
        self.depth = self.deepest(solid.bvh(), corners, most)?;
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        self.middle = middle;
        // Not on the sides, where it might lie on the surface of free space.
        self.middle = self.project(middle, margin).ok_or(Blocked::Unclear)?;
        if self.holds(self.middle, margin) && solid.contains(self.middle) {
            Ok(())
        } else {
            Err(Blocked::Unclear)
        }
    }

    /// An upper bound of the distance from `q` to the inner part, sharper only
    /// while it is above `enough`.
    pub(super) fn distance(&self, q: DVec3, enough: f64) -> f64 {
        let straight = self
            .toward_middle(q, 0.0)
            .unwrap_or(self.middle)
            .distance(q);
        if straight <= enough {
            return straight;
        }
        self.project(q, 0.0)
            .map_or(straight, |p| p.distance(q).min(straight))
    }

    /// How far the half-spaces are moved inward.
    pub(super) fn depth(&self) -> f64 {
        self.depth
    }

    fn is_cut(&self, side: u32) -> bool {
        (side as usize) < self.cuts
    }

    /// How deep below the sides the surface inside the cell reaches.
    fn deepest(&mut self, bvh: &Bvh, corners: &[DVec3], most: f64) -> Result<f64, Blocked> {
        self.stack.clear();
        self.stack.push((0, 0, self.sides.len()));
        let (mut deepest, mut work) = (0.0f64, 0);
        while let Some((node, start, end)) = self.stack.pop() {
            work += end - start;
            if work > WORK {
                return Err(Blocked::Unclear);
            }
            // Lists of nodes already done with lie behind.
            self.near.truncate(end);
            let bounds = bvh.node_bounds(node);
            let (centre, half) = (bounds.centre(), (bounds.hi - bounds.lo) * 0.5);
            let first = self.near.len();
            let mut outside = false;
            for at in start..end {
                let side = self.near[at];
                let HalfSpace { normal, offset } = self.sides[side as usize];
                let depth = offset - normal.dot(centre);
                let spread = normal.abs().dot(half);
                let forgiven = if self.is_cut(side) {
                    deepest
                } else {
                    self.margin
                };
                if depth + spread <= forgiven {
                    outside = true;
                    break;
                }
                if depth - spread <= if self.is_cut(side) { most } else { self.margin } {
                    self.near.push(side);
                }
            }
            if outside {
                continue;
            }
            let last = self.near.len();
            match bvh.branch(node) {
                Branch::Fork(children) => {
                    self.stack.extend(children.map(|c| (c, first, last)));
                }
                Branch::Leaf(slots) => {
                    for slot in slots {
                        let depth = self.depth_of(bvh.triangle(slot), first..last, corners);
                        deepest = deepest.max(depth);
                        if deepest > most {
                            return Err(Blocked::By(slot));
                        }
                    }
                }
            }
        }
        Ok(deepest)
    }

    /// The least depth of what the box holds of a triangle below one side; zero if its own
    /// plane keeps it off.
    fn depth_of(&self, triangle: &Triangle, near: Range<usize>, corners: &[DVec3]) -> f64 {
        let [a, b, c] = triangle.corners();
        let depth = self.depth_below(&[a, b, c], near.clone());
        if depth <= 0.0 {
            return 0.0;
        }
        // The normal of a sliver may be anything, so its own corners count too.
        let normal = (b - a).cross(c - a);
        let (second, third) = (normal.dot(b - a), normal.dot(c - a));
        let own = (second.min(third).min(0.0), second.max(third).max(0.0));
        let cell = corners.iter().map(|corner| normal.dot(*corner - a)).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, most), height| (least.min(height), most.max(height)),
        );
        if cell.0 >= own.1 || cell.1 <= own.0 {
            return 0.0;
        }
        // Only what is inside the box counts.
        let (lo, hi) = self.grown_box();
        if [a, b, c]
            .iter()
            .all(|p| p.cmpge(lo).all() && p.cmple(hi).all())
        {
            return depth;
        }
        let inside = within([a, b, c], lo, hi);
        depth.min(self.depth_below(&inside, near))
    }

    /// The box, grown by the margin.
    fn grown_box(&self) -> (DVec3, DVec3) {
        let side = |k: usize| self.sides[self.cuts + k].offset + self.margin;
        let (lo, hi) = (
            DVec3::new(side(1), side(3), side(5)),
            DVec3::new(side(0), side(2), side(4)),
        );
        (-lo, hi)
    }

    /// The least depth of all points below one side.
    fn depth_below(&self, points: &[DVec3], near: Range<usize>) -> f64 {
        self.near[near]
            .iter()
            .map(|side| {
                let HalfSpace { normal, offset } = self.sides[*side as usize];
                let lowest = points.iter().map(|p| normal.dot(*p));
                let depth = offset - lowest.fold(f64::INFINITY, f64::min);
                if self.is_cut(*side) {
                    depth
                } else if depth <= self.margin {
                    0.0
                } else {
                    f64::INFINITY
                }
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether `p` is in the inner part, `extra` away from its sides.
    fn holds(&self, p: DVec3, extra: f64) -> bool {
        self.sides
            .iter()
            .enumerate()
            .all(|(k, side)| side.normal.dot(p) <= side.offset - self.inward(k) - 0.5 * extra)
    }

    /// How far the sides are moved inward.
    fn inward(&self, side: usize) -> f64 {
        if side < self.cuts {
            self.depth
        } else {
            self.margin
        }
    }

    /// A point of the inner part near to `q` and `extra` away from its sides:
    /// projections onto the side broken most, then a step towards the middle.
    fn project(&self, q: DVec3, extra: f64) -> Option<DVec3> {
        let mut p = q;
        for _ in 0..STEPS {
            let mut worst = (0.0, DVec3::ZERO);
            for (k, side) in self.sides.iter().enumerate() {
                let broken = side.normal.dot(p) - side.offset + self.inward(k) + extra;
                if broken > worst.0 {
                    worst = (broken, side.normal);
                }
            }
            if worst.0 <= 0.0 {
                return Some(p);
            }
            p -= worst.1 * worst.0;
        }
        self.toward_middle(p, extra)
    }

    /// The first point of the inner part on the way from `p` to the middle.
    fn toward_middle(&self, p: DVec3, extra: f64) -> Option<DVec3> {
        let mut step = 0.0f64;
        for (k, side) in self.sides.iter().enumerate() {
            let limit = side.offset - self.inward(k) - extra;
            let at = side.normal.dot(p);
            if at > limit {
                let to = side.normal.dot(self.middle);
                if to >= limit {
                    return None;
                }
                step = step.max((at - limit) / (at - to));
            }
        }
        Some(p + (self.middle - p) * step)
    }
}

/// The part of a triangle inside a box (Sutherland & Hodgman 1974).
fn within(corners: [DVec3; 3], lo: DVec3, hi: DVec3) -> Vec<DVec3> {
    let mut points = corners.to_vec();
    for axis in 0..3 {
        for (sign, limit) in [(1.0, hi[axis]), (-1.0, -lo[axis])] {
            let beyond = |p: DVec3| sign * p[axis] - limit;
            let mut kept = Vec::with_capacity(points.len() + 1);
            for (i, &p) in points.iter().enumerate() {
                let next = points[(i + 1) % points.len()];
                let (here, there) = (beyond(p), beyond(next));
                if here <= 0.0 {
                    kept.push(p);
                }
                if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                    kept.push(p.lerp(next, here / (here - there)));
                }
            }
            points = kept;
        }
    }
    points
}

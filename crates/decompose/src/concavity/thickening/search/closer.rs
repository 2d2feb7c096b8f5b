//! A closer look at one cell: what needs its corners.

use std::ops::Range;

use assetpipe_geometry::bvh::Bounds;
use assetpipe_geometry::distance::HalfSpace;
use assetpipe_geometry::DVec3;

use super::super::cell::{highest, Polytope, CUTS};
use super::super::enclosed::Blocked;
use super::{Cell, Search, Side, MARGIN};
use crate::concavity::goal::Goal;
use crate::concavity::mixture;

/// A cell with a larger radius than this share of the target is split before
/// its corners are looked at, unless its nearest triangle is as large as it is.
const COARSE: f64 = 0.5;
/// Cells with a radius of so many targets or less are not asked whether the
/// solid encloses them: a triangle nearby does as well.
const ROOMY: f64 = 2.0;
/// Every how many splits larger cells are asked: each has halved every side.
const SPLITS: usize = 3;
/// Half-spaces that a cell is cut with at first.
const FEW_CUTS: usize = 6;
/// Bounds that are to be so close are worth a second look at a cell.
const FINE: f64 = 0.02;
/// Then the surface in a cell may be so many targets deep.
const DEEPER: f64 = 3.0;
/// How many depths wider the second look at a cell is.
const WIDER: f64 = 2.0;
/// Stands for the inner part of a cell where triangles have numbers.
const INNER: u32 = u32::MAX;

impl Search<'_> {
    /// The bounds that need the cell's corners, where they may help.
    pub(super) fn look_closer(&mut self, seen: &mut Cell, radius: f64) -> f64 {
        let target = self.target();
        let planes = seen.planes.clone();
        // The centre of the box need not belong to the cell.
        let may_be_inside =
            seen.side != Side::Outside || self.pull(seen.centre, &planes) != seen.centre;
        let may_be_enclosed = may_be_inside && radius > ROOMY * target && seen.level % SPLITS == 0;
        let may_be_near = radius <= COARSE * target
            || self.solid.bvh().triangle(seen.slot).bounds().diagonal() >= radius;
        if !may_be_enclosed && !may_be_near {
            return f64::INFINITY;
        }
        let margin = MARGIN * self.slack;
        // Surface that is too deep to settle the cell still bounds it.
        let is_fine = matches!(self.goal, Goal::Measure { gap } if gap.relative < FINE);
        let most = if is_fine { DEEPER * target } else { target };
        let mut cell = std::mem::take(&mut self.cell);
        let touches = |s: &&HalfSpace| highest(s.normal, &seen.bounds) > s.offset - self.slack;
        let cuts = self.planes[planes.clone()].iter();
        let cuts = cuts.map(|i| self.body.half_spaces()[*i as usize]);
        let flats = self.flats.iter().filter(touches).copied();
        cell.set(seen.bounds, cuts.chain(flats));
        cell.find_corners(FEW_CUTS, margin);
        let mut has_inner = false;
        if may_be_enclosed && !cell.corners.is_empty() {
            let suspects = [seen.slot, seen.blocker];
            match self.inner.find(self.solid, &cell, most, margin, suspects) {
                Ok(()) => has_inner = true,
                Err(Blocked::By(slot)) => seen.blocker = slot,
                Err(Blocked::Unclear) => {}
            }
            if has_inner && cell.spaces.len() > FEW_CUTS {
                cell.find_corners(CUTS, margin);
            }
        }
        let mut upper = if cell.corners.is_empty() {
            0.0
        } else if has_inner || may_be_near {
            let first = if has_inner { INNER } else { seen.slot };
            self.mix(&cell.corners, first, &planes)
        } else {
            f64::INFINITY
        };
        if has_inner && upper > target && is_fine {
            upper = upper.min(self.wider(seen, &cell, most));
        }
        self.cell = cell;
        upper
    }

    /// The bound by the inner part of a larger cell: where half-spaces are oblique to the box, the
    /// nearest point of what is solid lies beyond its sides.
    fn wider(&mut self, seen: &Cell, cell: &Polytope, most: f64) -> f64 {
        let margin = MARGIN * self.slack;
        let more = DVec3::splat(self.inner.depth() * WIDER);
        let bounds = Bounds {
            lo: seen.bounds.lo - more,
            hi: seen.bounds.hi + more,
        };
        let cuts = |s: &&HalfSpace| highest(s.normal, &bounds) > s.offset;
        let mut wide = std::mem::take(&mut self.wide);
        wide.set(bounds, self.body.half_spaces().iter().filter(cuts).copied());
        wide.find_corners(FEW_CUTS, margin);
        let suspects = [seen.slot, seen.blocker];
        let found = !wide.corners.is_empty()
            && (self.inner.find(self.solid, &wide, most, margin, suspects)).is_ok();
        self.wide = wide;
        if found {
            self.mix(&cell.corners, INNER, &seen.planes)
        } else {
            f64::INFINITY
        }
    }

    /// Distance from `q` to a convex part of the solid: a triangle or what
    /// `self.inner` holds.
    fn distance(&self, part: u32, q: DVec3) -> f64 {
        if part == INNER {
            self.inner.distance(q, self.target())
        } else {
            self.solid.bvh().triangle(part).distance2(q).sqrt()
        }
    }

    /// Mix triangles, starting with `slot`, each next one nearest to the corner
    /// that is worst for all so far.
    fn mix(&mut self, points: &[DVec3], slot: u32, planes: &Range<usize>) -> f64 {
        let target = self.target();
        let mut rows = std::mem::take(&mut self.scratch.rows);
        let mut tableau = std::mem::take(&mut self.scratch.tableau);
        let mut slots = std::mem::take(&mut self.scratch.slots);
        slots.clear();
        let mut next = slot;
        let mut upper = f64::INFINITY;
        while slots.len() < mixture::MOST {
            if rows.len() <= slots.len() {
                rows.push(Vec::new());
            }
            let row = &mut rows[slots.len()];
            row.clear();
            row.extend(points.iter().map(|p| self.distance(next, *p)));
            slots.push(next);
            // The corner that no triangle so far is near to.
            let mut worst = (f64::NEG_INFINITY, 0);
            for i in 0..points.len() {
                let best = rows[..slots.len()]
                    .iter()
                    .fold(f64::INFINITY, |b, r| b.min(r[i]));
                if best > worst.0 {
                    worst = (best, i);
                }
            }
            // No mixture is below what it is at that corner.
            if worst.0 <= target {
                let bound = mixture::upper_bound(&rows[..slots.len()], &mut tableau);
                upper = upper.min(bound);
                if upper <= target {
                    break;
                }
            }
            let q = points[worst.1];
            let Some(nearest) = self.solid.bvh().nearest(q, f64::INFINITY) else {
                break;
            };
            let distance = nearest.distance2.sqrt();
            if distance > target.max(self.lower) && self.side(q, None) == Side::Outside {
                self.probe(q, distance, planes);
            }
            if slots.contains(&nearest.slot) {
                break;
            }
            next = nearest.slot;
        }
        self.scratch.rows = rows;
        self.scratch.tableau = tableau;
        self.scratch.slots = slots;
        upper
    }
}

//! Quickhull over triangles, with every decision exact.
//!
//! Points that are coplanar with a facet are not outside of it, so coplanar
//! facets appear and disappear together and the visible region of a point is
//! always a disc: no facet is ever degenerate, no point is ever lost. What is
//! coplanar is merged at the end, in [`super::facets`].

use std::cmp::Ordering;
use std::collections::VecDeque;

use glam::DVec3;

use super::{facets, simplex, HullError};
use crate::mesh::Mesh;
use crate::predicates::orient3d;

/// The end of a list, or no facet.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle of the growing hull and the points waiting outside of it.
#[derive(Clone, Debug)]
pub(super) struct Facet {
    /// Corners, counter-clockwise from outside.
    pub(super) corners: [u32; 3],
    /// Facets across the edges from corner `i` to corner `i + 1`.
    pub(super) across: [u32; 3],
    /// Whether the facet still belongs to the hull.
    pub(super) alive: bool,
    origin: DVec3,
    normal: DVec3,
    /// What rounding can add to `normal · (p - origin)` for any input point.
    doubt: f64,
    /// First of the points that wait outside.
    waiting: u32,
    /// The one farthest outside, and how far.
    farthest: u32,
    height: f64,
    /// The last point asked for, and whether it sees this facet.
    asked: u32,
    seen: bool,
}

impl Facet {
    /// How far a point is from the plane (in units of the normal, rounded),
    /// and on which side, exactly.
    #[inline]
    pub(super) fn side(&self, points: &[DVec3], point: u32) -> (f64, Ordering) {
        let p = points[point as usize];
        let height = self.normal.dot(p - self.origin);
        let side = if height > self.doubt {
            Ordering::Greater
        } else if height < -self.doubt {
            Ordering::Less
        } else {
            let [a, b, c] = self.corners.map(|v| points[v as usize]);
            orient3d(a, b, c, p)
        };
        (height, side)
    }
}

/// Builds hulls, keeping its memory between them: thousands of small hulls
/// cost no allocation but their result. Results do not depend on what was
/// built before.
#[derive(Debug, Default)]
pub struct Builder {
    pub(super) facets: Vec<Facet>,
    pub(super) free: Vec<u32>,
    /// Next point waiting outside the same facet, per point.
    next: Vec<u32>,
    /// New facet that starts at a horizon vertex, per point.
    starting: Vec<u32>,
    pending: VecDeque<u32>,
    pub(super) visible: Vec<u32>,
    /// Edges between what a point sees and what it does not: start, end, facet behind, its edge.
    horizon: Vec<(u32, u32, u32, u8)>,
    pub(super) fresh: Vec<u32>,
    polygons: facets::Scratch,
}

impl Builder {
    /// As [`convex_hull`](super::convex_hull).
    ///
    /// # Errors
    /// As [`convex_hull`](super::convex_hull).
    pub fn hull(&mut self, points: &[DVec3]) -> Result<Mesh, HullError> {
        let extent = check(points)?;
        self.grow(points, extent)?;
        Ok(self.canonical(points))
    }

    /// The volume of the convex hull, without making its mesh.
    ///
    /// # Errors
    /// As [`convex_hull`](super::convex_hull).
    pub fn volume(&mut self, points: &[DVec3]) -> Result<f64, HullError> {
        let extent = check(points)?;
        self.grow(points, extent)?;
        let at = |i: u32| points[i as usize];
        let Some(apex) = self
            .facets
            .iter()
            .find(|f| f.alive)
            .map(|f| at(f.corners[0]))
        else {
            return Ok(0.0);
        };
        let six_fold: f64 = self
            .facets
            .iter()
            .filter(|f| f.alive)
            .map(|f| f.normal.dot(f.origin - apex))
            .sum();
        Ok(six_fold / 6.0)
    }

    /// Prepares for points up to this number. Memory is never cleared: entries
    /// are written before they are read.
    pub(super) fn make_room(&mut self, points: usize) {
        let size = self.next.len().max(points);
        self.next.resize(size, NONE);
        self.starting.resize(size, NONE);
    }

    /// The hull that has been grown, as a mesh.
    pub(super) fn canonical(&mut self, points: &[DVec3]) -> Mesh {
        facets::canonical(points, &self.facets, &mut self.polygons)
    }

    /// Grows the hull of points whose coordinates differ by at most `extent`.
    pub(super) fn grow(&mut self, points: &[DVec3], extent: DVec3) -> Result<(), HullError> {
        let start = simplex::spanning(points)?;
        self.facets.clear();
        self.free.clear();
        self.pending.clear();
        self.make_room(points.len());
        let mut work = Work {
            points,
            extent,
            builder: self,
        };
        work.begin(start);
        // Oldest facet first: refining everywhere alike keeps visible regions small.
        while let Some(facet) = work.builder.pending.pop_front() {
            let f = &work.builder.facets[facet as usize];
            if f.alive && f.waiting != NONE {
                work.add(facet);
            }
        }
        Ok(())
    }
}

/// Extent of finite points per axis.
pub(super) fn check(points: &[DVec3]) -> Result<DVec3, HullError> {
    let Some(&first) = points.first() else {
        return Err(HullError::Empty);
    };
    if points.len() >= NONE as usize {
        return Err(HullError::TooMany {
            count: points.len(),
        });
    }
    let (mut low, mut high) = (first, first);
    // NaN slips through minima and maxima but not through this sum of zeros.
    let mut poison = DVec3::ZERO;
    for &p in points {
        low = low.min(p);
        high = high.max(p);
        poison += p * 0.0;
    }
    if poison != DVec3::ZERO {
        if let Some(index) = points.iter().position(|p| !p.is_finite()) {
            return Err(HullError::NotFinite {
                index,
                point: points[index],
            });
        }
    }
    Ok(high - low)
}

/// A builder at work on its points.
pub(super) struct Work<'a> {
    pub(super) points: &'a [DVec3],
    /// Largest difference of coordinates between points.
    pub(super) extent: DVec3,
    pub(super) builder: &'a mut Builder,
}

impl Work<'_> {
    fn at(&self, point: u32) -> DVec3 {
        self.points[point as usize]
    }

    fn begin(&mut self, [a, b, c, d]: [usize; 4]) {
        let [a, b, c, d] = [a, b, c, d].map(|i| i as u32);
        // `d` is below `a b c`.
        self.create([a, b, c], [3, 1, 2]);
        self.create([c, b, d], [0, 3, 2]);
        self.create([a, c, d], [0, 1, 3]);
        self.create([b, a, d], [0, 2, 1]);
        for point in 0..self.points.len() as u32 {
            for facet in 0..4 {
                if let Some(height) = self.height(facet, point) {
                    self.wait(facet, point, height);
                    break;
                }
            }
        }
        self.builder.pending.extend(0..4);
    }

    fn create(&mut self, corners: [u32; 3], across: [u32; 3]) -> u32 {
        let [a, b, c] = corners.map(|v| self.at(v));
        let (u, v) = (b - a, c - a);
        let (left, right) = (
            DVec3::new(u.y * v.z, u.z * v.x, u.x * v.y),
            DVec3::new(u.z * v.y, u.x * v.z, u.y * v.x),
        );
        // Every term of the determinant passes at most seven roundings
        // (differences, products, sums); ten leave room for second order.
        // The last summand covers underflow.
        let doubt = 5.0 * f64::EPSILON * (left.abs() + right.abs()).dot(self.extent)
            + 1e-300 * (1.0 + self.extent.element_sum());
        let facet = Facet {
            corners,
            across,
            alive: true,
            origin: a,
            normal: left - right,
            doubt,
            waiting: NONE,
            farthest: NONE,
            height: f64::NEG_INFINITY,
            asked: NONE,
            seen: false,
        };
        if let Some(slot) = self.builder.free.pop() {
            self.builder.facets[slot as usize] = facet;
            slot
        } else {
            self.builder.facets.push(facet);
            self.builder.facets.len() as u32 - 1
        }
    }

    /// How far `point` is outside of `facet` (in units of the facet's
    /// normal, rounded), or nothing if it is not strictly outside.
    #[inline]
    pub(super) fn height(&self, facet: u32, point: u32) -> Option<f64> {
        let f = &self.builder.facets[facet as usize];
        let (height, side) = f.side(self.points, point);
        side.is_gt().then_some(height)
    }

    fn wait(&mut self, facet: u32, point: u32, height: f64) {
        let f = &self.builder.facets[facet as usize];
        // Of equally high points the lexicographically last is extreme; one
        // inside a coplanar crowd would be added in vain.
        let farther = f.farthest == NONE
            || height > f.height
            || (height == f.height && order(self.at(point), self.at(f.farthest)).is_gt());
        let f = &mut self.builder.facets[facet as usize];
        self.builder.next[point as usize] = f.waiting;
        f.waiting = point;
        if farther {
            f.farthest = point;
            f.height = height;
        }
    }

    /// Adds the point farthest outside of `facet` to the hull.
    fn add(&mut self, facet: u32) {
        let eye = self.builder.facets[facet as usize].farthest;
        self.see(facet, eye);
        self.cone(eye);
        let visible = std::mem::take(&mut self.builder.visible);
        for &hidden in &visible {
            let mut point = self.builder.facets[hidden as usize].waiting;
            while point != NONE {
                let next = self.builder.next[point as usize];
                if point != eye {
                    self.settle(point);
                }
                point = next;
            }
        }
        self.builder.free.extend_from_slice(&visible);
        self.builder.visible = visible;
        let Builder {
            pending,
            fresh,
            facets,
            ..
        } = &mut *self.builder;
        pending.extend(
            fresh
                .iter()
                .filter(|f| facets[**f as usize].waiting != NONE),
        );
    }

    /// Gathers the facets that `eye` sees, from `first` on, and their horizon.
    pub(super) fn see(&mut self, first: u32, eye: u32) {
        self.builder.visible.clear();
        self.builder.horizon.clear();
        let f = &mut self.builder.facets[first as usize];
        f.asked = eye;
        f.seen = true;
        self.builder.visible.push(first);
        let mut done = 0;
        while done < self.builder.visible.len() {
            let current = self.builder.visible[done];
            done += 1;
            let (corners, across) = {
                let f = &mut self.builder.facets[current as usize];
                f.alive = false;
                (f.corners, f.across)
            };
            for edge in 0..3 {
                let other = across[edge];
                if self.builder.facets[other as usize].asked != eye {
                    let seen = self.height(other, eye).is_some();
                    let f = &mut self.builder.facets[other as usize];
                    f.asked = eye;
                    f.seen = seen;
                    if seen {
                        self.builder.visible.push(other);
                    }
                }
                let f = &self.builder.facets[other as usize];
                if !f.seen {
                    let back = f.across.iter().position(|&x| x == current).unwrap_or(0);
                    let (start, end) = (corners[edge], corners[(edge + 1) % 3]);
                    self.builder.horizon.push((start, end, other, back as u8));
                }
            }
        }
    }

    /// Replaces what `eye` sees by the cone from it to the horizon.
    pub(super) fn cone(&mut self, eye: u32) {
        self.builder.fresh.clear();
        let horizon = std::mem::take(&mut self.builder.horizon);
        for &(start, end, behind, back) in &horizon {
            let facet = self.create([start, end, eye], [behind, NONE, NONE]);
            self.builder.facets[behind as usize].across[usize::from(back)] = facet;
            self.builder.starting[start as usize] = facet;
            self.builder.fresh.push(facet);
        }
        for &(start, end, ..) in &horizon {
            let facet = self.builder.starting[start as usize];
            let following = self.builder.starting[end as usize];
            self.builder.facets[facet as usize].across[1] = following;
            self.builder.facets[following as usize].across[2] = facet;
        }
        self.builder.horizon = horizon;
    }

    /// Lets `point` wait outside one of the new facets, or drops it: outside
    /// of none it is inside the hull (a line from it to the facet it waited at
    /// leaves the hull through a new facet).
    fn settle(&mut self, point: u32) {
        for i in 0..self.builder.fresh.len() {
            let facet = self.builder.fresh[i];
            if let Some(height) = self.height(facet, point) {
                self.wait(facet, point, height);
                return;
            }
        }
    }
}

/// Lexicographic by (x, y, z).
pub(super) fn order(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp(&b.x)
        .then(a.y.total_cmp(&b.y))
        .then(a.z.total_cmp(&b.z))
}

//! A convex hull that grows point by point along a sweep direction.
//!
//! Made for *scoring* trial cuts, where millions of hulls are priced and none
//! is kept. Callers jitter their points by a few 1e-7 so that coplanar input does
//! not occur. What rounding leaves open exact signs decide: a horizon that is no
//! simple cycle would leave a corner out of the hull, and make its cut too cheap.
//! Hulls that leave the engine come from `assetpipe_geometry::hull`.
//!
//! Points come sorted along the sweep direction, so a new point is always
//! outside and always sees a face at the point before it: the visible region
//! is found without conflict lists, in amortised constant time. The volume is
//! a by-product of the visibility tests (a tetrahedron a visible face).

use std::cmp::Ordering;

use assetpipe_geometry::predicates::orient3d;
use glam::DVec3;

const NONE: u32 = u32::MAX;
/// How far rounding may move the height of a point above a face, times two of the face's sides and
/// the largest coordinate: about 60 roundings.
const ROUNDING: f64 = 100.0 * f64::EPSILON;
/// Samples so far outside count as inside: grids meet faces, and neither rounding nor jitter is to
/// decide on which side.
const ON: f64 = 2e-6;

#[derive(Clone, Copy)]
struct Face {
    /// Unnormalised outward normal.
    normal: DVec3,
    /// `normal · x` on the face.
    offset: f64,
    /// Of the normal.
    length: f64,
    /// How far heights, in the unit of the offset, may be off; for coordinates up to one.
    slack: f64,
    corners: [u32; 3],
    /// `neighbours[i]` lies across the edge from corner i to corner i + 1.
    neighbours: [u32; 3],
    alive: bool,
}

/// A growing hull; reuse one value for many sweeps to keep its memory.
#[derive(Default)]
pub struct SweepHull {
    points: Vec<DVec3>,
    faces: Vec<Face>,
    free: Vec<u32>,
    /// Faces at the newest vertex.
    newest: Vec<u32>,
    /// First points, until four of them span a tetrahedron.
    waiting: Vec<DVec3>,
    volume: f64,
    /// Largest coordinate.
    reach: f64,
    // scratch
    mark: Vec<u32>,
    round: u32,
    stack: Vec<u32>,
    visible: Vec<u32>,
    horizon: Vec<(u32, u32, u32)>,
    starts: Vec<u32>,
}

impl SweepHull {
    /// Forget all points.
    pub fn clear(&mut self) {
        self.points.clear();
        self.faces.clear();
        self.free.clear();
        self.newest.clear();
        self.waiting.clear();
        self.volume = 0.0;
        self.reach = 0.0;
        self.mark.clear();
        self.round = 0;
        self.starts.clear();
    }

    /// Volume of the hull so far.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Whether `q` lies inside, `depth` below all faces. `witness` remembers a face that
    /// separates, and makes the next question about the same point cheap.
    pub fn contains(&self, q: DVec3, depth: f64, witness: &mut u32) -> bool {
        if let Some(face) = self.faces.get(*witness as usize) {
            if face.alive && face.normal.dot(q) > face.offset + (ON - depth) * face.length {
                return false;
            }
        }
        for (index, face) in self.faces.iter().enumerate() {
            if face.alive && face.normal.dot(q) > face.offset + (ON - depth) * face.length {
                *witness = index as u32;
                return false;
            }
        }
        !self.faces.is_empty()
    }

    /// Add one point.
    pub fn insert(&mut self, p: DVec3) {
        self.reach = self.reach.max(p.abs().max_element());
        if self.faces.is_empty() {
            self.waiting.push(p);
            if self.waiting.len() >= 4 {
                self.start();
            }
        } else {
            self.grow(p);
        }
    }

    /// Look for a first tetrahedron among the waiting points.
    fn start(&mut self) {
        let w = &self.waiting;
        let (a, d) = (w[0], w[w.len() - 1]);
        // Farthest from a, then farthest from that line, then the newest point
        // if it is off the plane.
        let Some(b) = (1..w.len() - 1).max_by(|&i, &j| {
            let (i, j) = (w[i].distance_squared(a), w[j].distance_squared(a));
            i.total_cmp(&j)
        }) else {
            return;
        };
        let ab = w[b] - a;
        let Some(c) = (1..w.len() - 1).filter(|&i| i != b).max_by(|&i, &j| {
            let (i, j) = ((w[i] - a).cross(ab), (w[j] - a).cross(ab));
            i.length_squared().total_cmp(&j.length_squared())
        }) else {
            return;
        };
        let det = ab.cross(w[c] - a).dot(d - a);
        let side = orient3d(a, w[b], w[c], d);
        if side == Ordering::Equal {
            return;
        }
        let waiting = std::mem::take(&mut self.waiting);
        let (b, c) = if side == Ordering::Greater {
            (c, b)
        } else {
            (b, c)
        };
        self.points.extend([a, waiting[b], waiting[c], d]);
        self.starts.resize(4, NONE);
        for (corners, neighbours) in [
            ([0, 1, 2], [1, 2, 3]),
            ([0, 3, 1], [3, 2, 0]),
            ([1, 3, 2], [1, 3, 0]),
            ([0, 2, 3], [0, 2, 1]),
        ] {
            let face = self.face(corners, neighbours);
            self.faces.push(face);
            self.mark.push(0);
        }
        self.newest.extend([1, 2, 3]);
        self.volume = det.abs() / 6.0;
        for (i, &p) in waiting.iter().enumerate().take(waiting.len() - 1) {
            if i != 0 && i != b && i != c {
                self.grow(p);
            }
        }
        self.waiting = waiting;
        self.waiting.clear();
    }

    fn face(&self, corners: [u32; 3], neighbours: [u32; 3]) -> Face {
        let [a, b, c] = corners.map(|v| self.points[v as usize]);
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let (offset, length) = (normal.dot(a), normal.length());
        Face {
            normal,
            offset,
            length,
            slack: ROUNDING * ab.abs().max_element() * ac.abs().max_element(),
            corners,
            neighbours,
            alive: true,
        }
    }

    fn sees(&self, f: u32, p: DVec3) -> bool {
        let face = &self.faces[f as usize];
        let height = face.normal.dot(p) - face.offset;
        if height.abs() > face.slack * self.reach {
            return height > 0.0;
        }
        let [a, b, c] = face.corners.map(|v| self.points[v as usize]);
        orient3d(a, b, c, p) == Ordering::Greater
    }

    fn grow(&mut self, p: DVec3) {
        let near = self
            .newest
            .iter()
            .copied()
            .find(|&f| self.faces[f as usize].alive && self.sees(f, p));
        let seed = near.or_else(|| {
            (0..self.faces.len() as u32).find(|&f| self.faces[f as usize].alive && self.sees(f, p))
        });
        let Some(seed) = seed else { return };

        // The visible region, and its border counter-clockwise seen from p.
        self.round += 1;
        let round = self.round;
        self.visible.clear();
        self.horizon.clear();
        self.stack.clear();
        self.stack.push(seed);
        self.mark[seed as usize] = round;
        let mut grown = 0.0;
        while let Some(f) = self.stack.pop() {
            self.visible.push(f);
            let face = self.faces[f as usize];
            grown += face.normal.dot(p) - face.offset;
            for i in 0..3 {
                let g = face.neighbours[i];
                if self.mark[g as usize] == round {
                    continue;
                }
                if self.sees(g, p) {
                    self.mark[g as usize] = round;
                    self.stack.push(g);
                } else {
                    self.horizon
                        .push((face.corners[i], face.corners[(i + 1) % 3], g));
                }
            }
        }
        // Of a point that is on a line with an edge the border may be no simple cycle.
        let mut simple = self.horizon.len() >= 3;
        for &(a, _, _) in &self.horizon {
            simple &= self.starts[a as usize] == NONE;
            self.starts[a as usize] = 0;
        }
        for &(_, b, _) in &self.horizon {
            simple &= self.starts[b as usize] != NONE;
        }
        if !simple || self.visible.len() + self.free.len() >= self.faces.len() {
            for &(a, _, _) in &self.horizon {
                self.starts[a as usize] = NONE;
            }
            return;
        }

        self.volume += grown / 6.0;
        for &f in &self.visible {
            self.faces[f as usize].alive = false;
            self.free.push(f);
        }
        let vertex = self.points.len() as u32;
        self.points.push(p);
        self.starts.push(NONE);
        self.newest.clear();
        let horizon = std::mem::take(&mut self.horizon);
        for &(a, b, outer) in &horizon {
            let face = self.face([a, b, vertex], [outer, NONE, NONE]);
            let slot = if let Some(slot) = self.free.pop() {
                self.faces[slot as usize] = face;
                slot
            } else {
                self.faces.push(face);
                self.mark.push(0);
                self.faces.len() as u32 - 1
            };
            self.mark[slot as usize] = 0;
            self.starts[a as usize] = slot;
            self.newest.push(slot);
            let rim = &mut self.faces[outer as usize];
            for i in 0..3 {
                if rim.corners[i] == b && rim.corners[(i + 1) % 3] == a {
                    rim.neighbours[i] = slot;
                }
            }
        }
        for &(a, b, _) in &horizon {
            let (here, next) = (self.starts[a as usize], self.starts[b as usize]);
            self.faces[here as usize].neighbours[1] = next;
            self.faces[next as usize].neighbours[2] = here;
        }
        for &(a, _, _) in &horizon {
            self.starts[a as usize] = NONE;
        }
        self.horizon = horizon;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;

    fn noise(i: u64) -> f64 {
        let mut x = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x ^= x >> 31;
        x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x ^= x >> 29;
        (x >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn volume_of_a_jittered_box() {
        let mut points = Vec::new();
        for i in 0..4000u64 {
            let p = DVec3::new(noise(3 * i), noise(3 * i + 1), noise(3 * i + 2));
            // Push most points onto the six sides.
            let side = (i % 6) as usize;
            let mut q = p;
            q[side / 2] = (side % 2) as f64;
            points.push(q + 2e-7 * (p - 0.5));
        }
        points.sort_by(|a, b| a.z.total_cmp(&b.z));
        let mut hull = SweepHull::default();
        for &p in &points {
            hull.insert(p);
        }
        assert!((hull.volume() - 1.0).abs() < 0.01, "{}", hull.volume());
        let mut witness = NONE;
        assert!(hull.contains(DVec3::splat(0.5), 0.0, &mut witness));
        assert!(!hull.contains(DVec3::new(1.1, 0.5, 0.5), 0.0, &mut witness));
        assert!(!hull.contains(DVec3::new(1.1, 0.5, 0.5), 0.0, &mut witness));
        let inside = points
            .iter()
            .filter(|&&p| hull.contains(0.5 + (p - 0.5) * 0.999, 0.0, &mut witness))
            .count();
        assert_eq!(inside, points.len());
    }

    /// Sections are full of points beside vertices: faces are a billion times as long as wide.
    #[test]
    fn no_corner_is_left_out_where_points_crowd() {
        for round in 0..60u64 {
            let at = |i: u64| noise(1000 * round + i);
            let mut points = Vec::new();
            for i in 0..40 {
                let corner = DVec3::new(at(3 * i), at(3 * i + 1), at(3 * i + 2)).round();
                let side = corner.with_x(at(i + 300));
                for base in [corner, side] {
                    let p = base + 4e-7 * DVec3::new(at(i + 500), at(i + 600), at(i + 700));
                    points.extend([p, p + 1e-9 * DVec3::new(0.0, at(i + 800), 1.0)]);
                }
            }
            points.sort_by(|a, b| a.z.total_cmp(&b.z));
            let mut hull = SweepHull::default();
            for &p in &points {
                hull.insert(p);
            }
            let exact = crate::merge::volume(&convex_hull(&points).unwrap());
            let found = hull.volume();
            assert!((found - exact).abs() < 1e-9, "{round}: {found} {exact}");
        }
    }

    #[test]
    fn sphere_volume_against_the_closed_form() {
        let mut points: Vec<DVec3> = (0..20_000u64)
            .map(|i| {
                DVec3::new(
                    noise(3 * i) - 0.5,
                    noise(3 * i + 1) - 0.5,
                    noise(3 * i + 2) - 0.5,
                )
                .normalize()
            })
            .collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let mut hull = SweepHull::default();
        for &p in &points {
            hull.insert(p);
        }
        let ball = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((hull.volume() / ball - 1.0).abs() < 2e-3);
    }
}

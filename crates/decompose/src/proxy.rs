//! Coarser stand-ins of a solid for the search: edge collapse under quadric
//! error metrics (Garland & Heckbert 1997).
//!
//! A collapse maps a closed chain to a closed chain, so volumes of the stand-in
//! are well defined whatever the collapse does to its topology. Nothing that
//! leaves the engine is made from a stand-in.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use assetpipe_geometry::Mesh;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::cluster::clustered_to;
use crate::control::Control;
use crate::error::DecomposeError;
use crate::even;

/// Collapses between two looks at whether to go on: about a millisecond.
const PATIENCE: u32 = 256;
/// Meshes of more triangles than so many times the finest stand-in's are clustered first: edge
/// collapse goes through memory in no order, so its cost grows faster than its work.
const LARGE: usize = 16;

/// Costs that are equal but for so much are equal.
const EVEN: f64 = 1e-6;

/// A symmetric quadric: x·A·x − 2·b·x + c.
#[derive(Clone, Copy, Default)]
pub(crate) struct Quadric {
    a: [f64; 6],
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// Of a triangle's plane, weighted with its area.
    pub(crate) fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let area = normal.length();
        let mut quadric = Quadric::plane(
            normal.normalize_or_zero(),
            normal.normalize_or_zero().dot(a),
            area,
        );
        quadric.add(&Quadric::point((a + b + c) / 3.0, 1e-6 * area));
        quadric
    }

    fn plane(normal: DVec3, offset: f64, weight: f64) -> Self {
        let n = normal;
        Quadric {
            a: [
                n.x * n.x,
                n.x * n.y,
                n.x * n.z,
                n.y * n.y,
                n.y * n.z,
                n.z * n.z,
            ]
            .map(|x| x * weight),
            b: n * (offset * weight),
            c: offset * offset * weight,
        }
    }

    /// Distance to the point `p`, which keeps flat neighbourhoods well posed.
    fn point(p: DVec3, weight: f64) -> Self {
        Quadric {
            a: [weight, 0.0, 0.0, weight, 0.0, weight],
            b: p * weight,
            c: p.length_squared() * weight,
        }
    }

    pub(crate) fn add(&mut self, other: &Quadric) {
        for (x, y) in self.a.iter_mut().zip(&other.a) {
            *x += y;
        }
        self.b += other.b;
        self.c += other.c;
    }

    pub(crate) fn at(&self, p: DVec3) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let ap = DVec3::new(
            xx * p.x + xy * p.y + xz * p.z,
            xy * p.x + yy * p.y + yz * p.z,
            xz * p.x + yz * p.y + zz * p.z,
        );
        p.dot(ap) - 2.0 * p.dot(self.b) + self.c
    }

    pub(crate) fn minimum(&self) -> Option<DVec3> {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let m = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let trace = xx + yy + zz;
        let det = m.determinant();
        (det > 1e-12 * trace * trace * trace).then(|| m.inverse() * self.b)
    }
}

/// An edge waiting for its collapse, cheapest first: the bits of its cost, its
/// two vertices, and their stamps when it was queued.
type Waiting = Reverse<(u64, u32, u32, u32, u32)>;

struct Collapse {
    points: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    alive: Vec<bool>,
    around: Vec<Vec<u32>>,
    stamp: Vec<u32>,
    count: usize,
    queue: BinaryHeap<Waiting>,
}

impl Collapse {
    fn new(mesh: &Mesh) -> Self {
        let n = mesh.vertices.len();
        let mut around = vec![Vec::new(); n];
        let mut quadrics = vec![Quadric::default(); n];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let quadric = Quadric::triangle(mesh.corners(t).map(even::point));
            for &v in corners {
                around[v as usize].push(t as u32);
                quadrics[v as usize].add(&quadric);
            }
        }
        let mut state = Collapse {
            points: mesh.vertices.iter().map(|&p| even::point(p)).collect(),
            quadrics,
            triangles: mesh.triangles.clone(),
            alive: vec![true; mesh.triangles.len()],
            around,
            stamp: vec![0; n],
            count: mesh.triangles.len(),
            queue: BinaryHeap::new(),
        };
        let edges = mesh.triangles.par_iter().flat_map_iter(|t| {
            let edges = [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
            edges.into_iter().filter(|(u, v)| u < v)
        });
        let mut waiting: Vec<Waiting> = Vec::with_capacity(3 * mesh.triangles.len());
        waiting.par_extend(edges.map(|(u, v)| state.priced(u, v)));
        state.queue = waiting.into();
        state
    }

    fn target(&self, u: u32, v: u32) -> (DVec3, f64) {
        let mut q = self.quadrics[u as usize];
        q.add(&self.quadrics[v as usize]);
        let (a, b) = (self.points[u as usize], self.points[v as usize]);
        let middle = a.midpoint(b);
        let reach = 2.0 * a.distance(b);
        let best = q.minimum().filter(|p| p.distance(middle) < reach);
        let mut choice = (middle, q.at(middle));
        for p in [Some(a), Some(b), best].into_iter().flatten() {
            let cost = q.at(p);
            if cost < choice.1 * (1.0 - EVEN) {
                choice = (p, cost);
            }
        }
        (even::point(choice.0), even::weight(choice.1.max(0.0)))
    }

    fn priced(&self, u: u32, v: u32) -> Waiting {
        let (_, cost) = self.target(u, v);
        let stamp = |w: u32| self.stamp[w as usize];
        Reverse((cost.to_bits(), u, v, stamp(u), stamp(v)))
    }

    /// Whether moving `u` to `p` would turn over a triangle that stays.
    fn folds(&self, u: u32, v: u32, p: DVec3) -> bool {
        self.around[u as usize].iter().any(|&t| {
            let corners = self.triangles[t as usize];
            if !self.alive[t as usize] || corners.contains(&v) {
                return false;
            }
            let old = corners.map(|w| self.points[w as usize]);
            let new = corners.map(|w| if w == u { p } else { self.points[w as usize] });
            let before = (old[1] - old[0]).cross(old[2] - old[0]);
            let after = (new[1] - new[0]).cross(new[2] - new[0]);
            before.dot(after) < 0.0
        })
    }

    fn run(&mut self, target: usize, control: &Control) -> Result<(), DecomposeError> {
        let mut looked_at = 0u32;
        while self.count > target {
            looked_at += 1;
            if looked_at % PATIENCE == 0 {
                control.go_on()?;
            }
            let Some(Reverse((_, u, v, su, sv))) = self.queue.pop() else {
                break;
            };
            if self.stamp[u as usize] != su || self.stamp[v as usize] != sv {
                continue;
            }
            let (p, _) = self.target(u, v);
            if self.folds(u, v, p) || self.folds(v, u, p) {
                continue;
            }
            self.merge(u, v, p);
        }
        Ok(())
    }

    fn merge(&mut self, u: u32, v: u32, p: DVec3) {
        self.points[u as usize] = p;
        let other = self.quadrics[v as usize];
        self.quadrics[u as usize].add(&other);
        self.stamp[u as usize] += 1;
        self.stamp[v as usize] += 1;
        for t in std::mem::take(&mut self.around[v as usize]) {
            if !self.alive[t as usize] {
                continue;
            }
            let corners = &mut self.triangles[t as usize];
            if corners.contains(&u) {
                self.alive[t as usize] = false;
                self.count -= 1;
            } else {
                for w in corners.iter_mut().filter(|w| **w == v) {
                    *w = u;
                }
                self.around[u as usize].push(t);
            }
        }
        let mut ring: Vec<u32> = Vec::new();
        let alive = &self.alive;
        self.around[u as usize].retain(|&t| alive[t as usize]);
        for &t in &self.around[u as usize] {
            ring.extend(self.triangles[t as usize].iter().filter(|&&w| w != u));
        }
        ring.sort_unstable();
        ring.dedup();
        for w in ring {
            let priced = self.priced(u.min(w), u.max(w));
            self.queue.push(priced);
        }
    }

    fn snapshot(&self) -> Mesh {
        let mut index = vec![u32::MAX; self.points.len()];
        let mut mesh = Mesh::default();
        for (t, corners) in self.triangles.iter().enumerate() {
            if !self.alive[t] {
                continue;
            }
            let triangle = corners.map(|v| {
                let slot = &mut index[v as usize];
                if *slot == u32::MAX {
                    *slot = mesh.vertices.len() as u32;
                    mesh.vertices.push(self.points[v as usize]);
                }
                *slot
            });
            mesh.triangles.push(triangle);
        }
        mesh
    }
}

/// Stand-ins with about `sizes` triangles (decreasing), coarsest first; sizes
/// that the mesh does not clearly exceed are left out.
///
/// # Errors
/// [`DecomposeError::Cancelled`].
pub fn ladder(
    mesh: &Mesh,
    sizes: &[usize],
    control: &Control,
) -> Result<Vec<Mesh>, DecomposeError> {
    let wanted: Vec<usize> = sizes
        .iter()
        .copied()
        .filter(|&s| mesh.triangles.len() > s + s / 3)
        .collect();
    let Some(&finest) = wanted.first() else {
        return Ok(Vec::new());
    };
    let clustered;
    let mut mesh = mesh;
    if mesh.triangles.len() > LARGE * finest {
        clustered = clustered_to(mesh, LARGE / 2 * finest, control)?;
        mesh = &clustered;
    }
    let mut state = Collapse::new(mesh);
    let mut ladder = Vec::new();
    for size in wanted {
        state.run(size, control)?;
        ladder.push(state.snapshot());
    }
    ladder.reverse();
    Ok(ladder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::piece::Piece;

    fn sphere(n: u32) -> Mesh {
        // A subdivided octahedron's cousin: latitude and longitude.
        let mut mesh = Mesh::default();
        mesh.vertices.push(DVec3::Z);
        for i in 1..n {
            let theta = std::f64::consts::PI * f64::from(i) / f64::from(n);
            for j in 0..2 * n {
                let phi = std::f64::consts::PI * f64::from(j) / f64::from(n);
                mesh.vertices.push(DVec3::new(
                    libm::sin(theta) * libm::cos(phi),
                    libm::sin(theta) * libm::sin(phi),
                    libm::cos(theta),
                ));
            }
        }
        mesh.vertices.push(-DVec3::Z);
        let last = mesh.vertices.len() as u32 - 1;
        let at = |i: u32, j: u32| 1 + (i - 1) * 2 * n + j % (2 * n);
        for j in 0..2 * n {
            mesh.triangles.push([0, at(1, j), at(1, j + 1)]);
            mesh.triangles.push([last, at(n - 1, j + 1), at(n - 1, j)]);
            for i in 1..n - 1 {
                mesh.triangles
                    .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                mesh.triangles
                    .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        mesh
    }

    #[test]
    fn a_sphere_keeps_its_volume() {
        let mesh = sphere(40);
        let whole = Piece::from(&mesh).volume();
        let ladder = ladder(&mesh, &[1200, 300], &Control::default()).unwrap();
        assert_eq!(ladder.len(), 2);
        for (stand_in, size) in ladder.iter().zip([300, 1200]) {
            assert!(stand_in.triangles.len() <= size);
            let volume = Piece::from(stand_in).volume();
            assert!((volume / whole - 1.0).abs() < 0.02, "{volume} {whole}");
        }
    }

    #[test]
    fn large_meshes_are_clustered_first() {
        let mesh = sphere(120);
        let sizes = [1200, 300];
        assert!(mesh.triangles.len() > LARGE * sizes[0]);
        let whole = Piece::from(&mesh).volume();
        let ladder = ladder(&mesh, &sizes, &Control::default()).unwrap();
        assert_eq!(ladder.len(), 2);
        for stand_in in &ladder {
            let volume = Piece::from(stand_in).volume();
            assert!((volume / whole - 1.0).abs() < 0.02, "{volume} {whole}");
        }
        let cancelled = Control::default();
        cancelled.cancel();
        let stopped = super::ladder(&mesh, &sizes, &cancelled);
        assert!(matches!(stopped, Err(DecomposeError::Cancelled)));
    }

    #[test]
    fn small_meshes_need_no_stand_in() {
        let ladder = ladder(&sphere(6), &[1200, 300], &Control::default());
        assert!(ladder.unwrap().is_empty());
    }
}

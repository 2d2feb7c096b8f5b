//! The working copy: centred, scaled by a power of two to size one, and
//! turned into the frame of the cuts.
//!
//! Scaling by a power of two is exact; centring and turning round. So points
//! that are vertices of the input are given back as they came, by lookup, and
//! bounds are widened by what rounding may hide.

use assetpipe_geometry::Mesh;
use glam::{DMat3, DVec3};

use crate::candidates::frame::snap;

/// Moves points between the input and the working copy.
#[derive(Clone, Debug)]
pub struct Working {
    centre: DVec3,
    scale: f64,
    work_from_input: DMat3,
    /// Working positions of the input's vertices, sorted, with their positions.
    known: Vec<(DVec3, DVec3)>,
    rounding: f64,
}

fn order(a: &DVec3, b: &DVec3) -> std::cmp::Ordering {
    a.x.total_cmp(&b.x)
        .then(a.y.total_cmp(&b.y))
        .then(a.z.total_cmp(&b.z))
}

impl Working {
    /// The working copy of `mesh` in a frame given by its rotation.
    pub fn new(mesh: &Mesh, work_from_input: DMat3) -> (Working, Mesh) {
        let (lo, hi) = mesh
            .vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
                (lo.min(p), hi.max(p))
            });
        let centre = lo + 0.5 * (hi - lo);
        let half = (0.5 * (hi - lo)).max_element();
        // The power of two that brings half the longest side into (1/2, 1].
        let scale = libm::ldexp(1.0, -libm::frexp(half).1);
        let turned = work_from_input != DMat3::IDENTITY;
        let place = |p: DVec3| {
            let q = (p - centre) * scale;
            let q = if turned { work_from_input * q } else { q };
            // One zero, so that equal points have equal keys.
            q + DVec3::ZERO
        };
        let mut work = Mesh {
            vertices: mesh.vertices.iter().map(|&p| place(p)).collect(),
            triangles: mesh.triangles.clone(),
        };
        let moved = if turned { snap(&mut work) / scale } else { 0.0 };
        let mut known: Vec<(DVec3, DVec3)> = work
            .vertices
            .iter()
            .copied()
            .zip(mesh.vertices.iter().copied())
            .collect();
        known.sort_by(|a, b| order(&a.0, &b.0));
        let rounding = moved + 16.0 * f64::EPSILON * lo.abs().max(hi.abs()).max_element();
        (
            Working {
                centre,
                scale,
                work_from_input,
                known,
                rounding,
            },
            work,
        )
    }

    /// A working length from an input length.
    pub fn length(&self, input: f64) -> f64 {
        input * self.scale
    }

    /// An input length from a working length.
    pub fn input_length(&self, work: f64) -> f64 {
        work / self.scale
    }

    /// The working point of an input point.
    pub fn work(&self, input: DVec3) -> DVec3 {
        self.work_from_input * ((input - self.centre) * self.scale)
    }

    /// How far rounding between the copies may move a point, input length.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// The input point of a working point; exactly the input's own vertex
    /// where it is one.
    pub fn input(&self, work: DVec3) -> DVec3 {
        let key = work + DVec3::ZERO;
        match self.known.binary_search_by(|k| order(&k.0, &key)) {
            Ok(at) => self.known[at].1,
            Err(_) => self.work_from_input.transpose() * work / self.scale + self.centre,
        }
    }
}

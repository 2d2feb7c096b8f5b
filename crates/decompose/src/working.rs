//! The working copy: centred, of size one, turned into the frame of the cuts and into one
//! orientation.
//!
//! So a copy is the same, bit for bit, for mirror images and axes in another order, and the same
//! but for rounding for other scales and places. Centring, scaling and turning round; points
//! that are vertices of the input are given back as they came, by lookup, and bounds are widened
//! by what rounding may hide.

use assetpipe_geometry::Mesh;
use glam::{DMat3, DVec3};

use crate::candidates::frame::snap;
use crate::canonical::ordered;
use crate::merge::volume;
use crate::orientation::orientation;

/// Leading bits that a working length keeps: what scaling leaves of a length must not depend on
/// the scale.
const BITS: i32 = 30;

/// How far turning may round what was one coordinate apart, in the working copy (size one).
const TURNING: f64 = 64.0 * f64::EPSILON;
/// Likewise placing and scaling, as a share of the largest coordinate.
const PLACING: f64 = 4.0 * f64::EPSILON;

/// Moves points between the input and the working copy.
#[derive(Clone, Debug)]
pub struct Working {
    centre: DVec3,
    /// Half the longest side, input length.
    half: f64,
    work_from_input: DMat3,
    /// Working positions of the input's vertices, sorted, with their positions.
    known: Vec<(DVec3, DVec3)>,
    rounding: f64,
}

/// The order in which points are sorted to be found again.
pub fn order(a: &DVec3, b: &DVec3) -> std::cmp::Ordering {
    a.x.total_cmp(&b.x)
        .then(a.y.total_cmp(&b.y))
        .then(a.z.total_cmp(&b.z))
}

/// One zero, so that equal points have equal keys.
pub fn one_zero(p: DVec3) -> DVec3 {
    p + DVec3::ZERO
}

impl Working {
    /// The working copy of `mesh` in a frame given by its rotation.
    pub fn new(mesh: &Mesh, frame: DMat3) -> (Working, Mesh) {
        let (lo, hi) = mesh
            .vertices
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
                (lo.min(p), hi.max(p))
            });
        // Rounds alike for a mirror image.
        let centre = 0.5 * lo + 0.5 * hi;
        let half = (0.5 * (hi - lo)).max_element();
        let turned = |turn: DMat3| Mesh {
            vertices: mesh
                .vertices
                .iter()
                .map(|&p| turn * ((p - centre) / half))
                .collect(),
            triangles: mesh.triangles.clone(),
        };
        let work_from_input = orientation(&turned(frame)) * frame;
        let exact = turned(work_from_input);
        let mut copy = exact.clone();
        let turning = if frame == DMat3::IDENTITY {
            0.0
        } else {
            TURNING
        };
        let far = lo.abs().max(hi.abs()).max_element() / half;
        snap(&mut copy, turning + PLACING * far);
        if !is_whole(&copy, &exact) {
            copy = exact.clone();
        }
        let moved = (exact.vertices.iter().zip(&copy.vertices))
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f64::max);
        let mut known: Vec<(DVec3, DVec3)> = copy
            .vertices
            .iter()
            .map(|&p| one_zero(p))
            .zip(mesh.vertices.iter().copied())
            .collect();
        if work_from_input.determinant() < 0.0 {
            for t in &mut copy.triangles {
                t.swap(1, 2);
            }
        }
        let ((), ordered) = rayon::join(
            || known.sort_unstable_by(|a, b| order(&a.0, &b.0).then(order(&a.1, &b.1))),
            || ordered(&copy),
        );
        let rounding = moved * half + 16.0 * f64::EPSILON * lo.abs().max(hi.abs()).max_element();
        (
            Working {
                centre,
                half,
                work_from_input,
                known,
                rounding,
            },
            ordered,
        )
    }

    /// A working length from an input length: no longer, and by a billionth shorter at most.
    pub fn length(&self, input: f64) -> f64 {
        let exact = input / self.half;
        if !exact.is_normal() {
            return exact;
        }
        let (share, exponent) = libm::frexp(exact);
        libm::ldexp(libm::floor(libm::ldexp(share, BITS)), exponent - BITS)
    }

    /// An input length from a working length.
    pub fn input_length(&self, work: f64) -> f64 {
        work * self.half
    }

    /// The working point of an input point.
    pub fn work(&self, input: DVec3) -> DVec3 {
        self.work_from_input * ((input - self.centre) / self.half)
    }

    /// How far apart a point and its working copy may be, input length.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Whether the working copy is a mirror image.
    pub fn is_mirrored(&self) -> bool {
        self.work_from_input.determinant() < 0.0
    }

    /// The input point of a working point; the input's own vertex where it is one.
    pub fn input(&self, work: DVec3) -> DVec3 {
        match self.vertices_at(work) {
            [] => self.work_from_input.transpose() * work * self.half + self.centre,
            [first, ..] => first.1,
        }
    }

    /// All input points of a working point: every vertex of the input whose copy it is.
    pub fn inputs(&self, work: DVec3) -> impl Iterator<Item = DVec3> + '_ {
        let known = self.vertices_at(work);
        let other = known.is_empty().then(|| self.input(work));
        known.iter().map(|k| k.1).chain(other)
    }

    fn vertices_at(&self, work: DVec3) -> &[(DVec3, DVec3)] {
        let key = one_zero(work);
        let from = self
            .known
            .partition_point(|k| order(&k.0, &key) == std::cmp::Ordering::Less);
        let count = self.known[from..].iter().take_while(|k| k.0 == key).count();
        &self.known[from..from + count]
    }
}

/// Whether moving vertices a little left a solid as thin as the move what makes it one: its
/// vertices apart, and its volume.
fn is_whole(moved: &Mesh, exact: &Mesh) -> bool {
    let places = |mesh: &Mesh| {
        let mut points: Vec<DVec3> = mesh.vertices.iter().map(|&p| one_zero(p)).collect();
        points.sort_unstable_by(order);
        points.dedup();
        points.len()
    };
    let (before, after) = (volume(exact), volume(moved));
    if (after - before).abs() > 0.01 * before.abs() {
        return false;
    }
    let (after, before) = rayon::join(|| places(moved), || places(exact));
    after == before
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;
    use assetpipe_geometry::sample::Random;

    fn body() -> Mesh {
        let mut random = Random::new(3);
        let points: Vec<DVec3> = (0..40).map(|_| random.in_cube()).collect();
        convex_hull(&points).unwrap()
    }

    fn changed(mesh: &Mesh, change: impl Fn(DVec3) -> DVec3, mirrors: bool) -> Mesh {
        let order = |[a, b, c]: [u32; 3]| if mirrors { [a, c, b] } else { [a, b, c] };
        Mesh {
            vertices: mesh.vertices.iter().map(|&p| change(p)).collect(),
            triangles: mesh.triangles.iter().map(|&t| order(t)).collect(),
        }
    }

    #[test]
    fn mirrors_and_orders_of_axes_leave_the_copy() {
        let mesh = body();
        let (_, copy) = Working::new(&mesh, DMat3::IDENTITY);
        let images = [
            changed(&mesh, |p| p * 1024.0, false),
            changed(&mesh, |p| p * DVec3::new(-1.0, 1.0, 1.0), true),
            changed(&mesh, |p| p * DVec3::new(1.0, -1.0, -1.0), false),
            changed(&mesh, |p| DVec3::new(p.z, -p.x, -p.y), false),
        ];
        for image in images {
            assert_eq!(Working::new(&image, DMat3::IDENTITY).1, copy);
        }
        let smaller = changed(&mesh, |p| p * 3.7e-5 + DVec3::splat(1e-5), false);
        let (_, other) = Working::new(&smaller, DMat3::IDENTITY);
        assert_eq!(other.triangles, copy.triangles);
        let off = |(a, b): (&DVec3, &DVec3)| a.distance(*b);
        assert!(other
            .vertices
            .iter()
            .zip(&copy.vertices)
            .map(off)
            .all(|d| d < 1e-14));
    }

    #[test]
    fn points_come_back_as_they_went() {
        let mesh = changed(&body(), |p| p * DVec3::new(-0.02, 0.013, 0.3), true);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        for frame in [DMat3::IDENTITY, turn] {
            let (working, copy) = Working::new(&mesh, frame);
            let mut back: Vec<DVec3> = copy.vertices.iter().map(|&p| working.input(p)).collect();
            let mut given = mesh.vertices.clone();
            back.sort_by(order);
            given.sort_by(order);
            assert_eq!(back, given);
            for &p in &mesh.vertices {
                let beside = p + DVec3::new(1e-3, 2e-3, -1e-3);
                let off = working.input(working.work(beside)).distance(beside);
                assert!(off <= working.rounding());
            }
            let (own, made) = (volume(&mesh), volume(&copy) * working.half.powi(3));
            assert!((made - own).abs() < 1e-6 * own);
            assert!(made > 0.0);
        }
    }

    #[test]
    fn a_plate_thinner_than_snapping_keeps_its_sides_apart() {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        for thickness in [1e-7, 1e-9, 1e-11] {
            let corners: Vec<DVec3> = (0..8u32)
                .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
                .map(|p| turn * (p * DVec3::new(1.0, 0.7, thickness)))
                .collect();
            let plate = convex_hull(&corners).unwrap();
            let (working, copy) = Working::new(&plate, turn.transpose());
            let made = volume(&copy) * working.half.powi(3);
            assert!((made - volume(&plate)).abs() < 0.02 * volume(&plate));
            let all = copy.vertices.iter().flat_map(|&p| working.inputs(p));
            assert_eq!(all.count(), plate.vertices.len());
        }
    }
}

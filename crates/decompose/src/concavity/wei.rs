//! The concavity of Wei et al. 2022, *Approximate convex decomposition for 3D
//! meshes with collision-aware concavity and tree search*, §4: like for like
//! with `CoACD`, but certified.
//!
//! All functions take a *part* as the index of its closed surface and its hull
//! as returned by `convex_hull` of the part's vertices.

use assetpipe_geometry::distance::{ConvexBody, SolidIndex};
use assetpipe_geometry::{DVec3, Mesh};

use super::depth::deepest;
use super::goal::Goal;
use super::patches::{farthest, Union};
use super::{thickening, Decision, Gap, Interval, Limits};

/// The constant k of Eq. 6 that the authors use (appendix C).
pub const K: f64 = 0.3;

/// The distances between a part and its hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Concavity {
    /// `H_b`, Eq. 2.
    pub boundary: Interval,
    /// `H_i`, Eq. 3.
    pub interior: Interval,
}

impl Concavity {
    /// Eq. 4: `max(H_b, H_i)`.
    pub fn value(&self) -> Interval {
        self.boundary.max(self.interior)
    }
}

/// Eq. 4 with its two terms, each to within `gap` or as close as the limits
/// permit.
pub fn bounds(part: &SolidIndex, hull: &Mesh, gap: Gap, limits: &Limits) -> Concavity {
    Concavity {
        boundary: boundary(part, hull, gap, limits),
        interior: interior(part, hull, gap, limits),
    }
}

/// The larger one of Eq. 4 and `known`, a lower bound known before (the hull's
/// thickening towards a solid that holds the part is one): cheaper than its terms.
///
/// Of the two directions of `H_b` only part → hull matters: a point of the hull's
/// boundary that belongs to the part lies on the part's boundary too, so the
/// direction hull → part never exceeds `H_i`.
pub fn value_above(
    part: &SolidIndex,
    hull: &Mesh,
    known: f64,
    gap: Gap,
    limits: &Limits,
) -> Interval {
    let (body, goal) = (ConvexBody::new(hull), Goal::Measure { gap });
    let depth = deepest(part.bvh(), &body, known, part.slack(), goal, limits).interval;
    depth.max(thickening::bounds_above(
        part,
        hull,
        depth.lower,
        gap,
        limits,
    ))
}

/// Decide whether Eq. 4 is at most `epsilon`, by the two distances that
/// [`value_above`] needs.
pub fn decide(part: &SolidIndex, hull: &Mesh, epsilon: f64, limits: &Limits) -> Decision {
    let goal = Goal::Decide { epsilon };
    let depth = deepest(
        part.bvh(),
        &ConvexBody::new(hull),
        0.0,
        part.slack(),
        goal,
        limits,
    );
    let boundary = Decision::from(epsilon, depth.interval, depth.witness);
    let Decision::Within(boundary) = boundary else {
        return boundary;
    };
    match thickening::decide(part, hull, epsilon, limits) {
        Decision::Within(interior) => Decision::Within(boundary.max(interior)),
        Decision::Unproven(interior) => Decision::Unproven(boundary.max(interior)),
        beyond @ Decision::Beyond { .. } => beyond,
    }
}

/// Eq. 2, `H_b`: the Hausdorff distance between the boundaries of a part and of
/// its hull, all points of both taken instead of samples.
pub fn boundary(part: &SolidIndex, hull: &Mesh, gap: Gap, limits: &Limits) -> Interval {
    let goal = Goal::Measure { gap };
    let slack = part.slack();
    let depth = deepest(part.bvh(), &ConvexBody::new(hull), 0.0, slack, goal, limits).interval;
    let facets = (0..hull.triangles.len()).map(|t| hull.corners(t));
    let height = farthest(&Surface(part), facets, depth.lower, slack, goal, limits);
    depth.max(height.interval)
}

/// Eq. 3, `H_i`: the Hausdorff distance between a part and its hull as solids.
/// The part lies in its hull, so only the direction hull → part counts.
pub fn interior(part: &SolidIndex, hull: &Mesh, gap: Gap, limits: &Limits) -> Interval {
    thickening::bounds(part, hull, gap, limits)
}

/// Eq. 5, `R_v`: the radius of the ball with the volume of the hull less that of
/// the part.
pub fn volume_radius(part: &Mesh, hull: &Mesh) -> Interval {
    let (part, part_error) = volume(part);
    let (hull, hull_error) = volume(hull);
    let radius = |volume: f64| libm::cbrt(3.0 * volume.max(0.0) / (4.0 * std::f64::consts::PI));
    let error = part_error + hull_error;
    Interval {
        lower: radius(hull - part - error) * (1.0 - 4.0 * f64::EPSILON),
        upper: radius(hull - part + error) * (1.0 + 4.0 * f64::EPSILON),
    }
}

/// Eq. 6: `max(H_b, k R_v)`, the stand-in that the authors accept parts by.
pub fn stand_in(boundary: Interval, volume_radius: Interval, k: f64) -> Interval {
    boundary.max(Interval {
        lower: k * volume_radius.lower,
        upper: k * volume_radius.upper,
    })
}

/// An upper bound of `H_i`: the proof of Theorem 1 (appendix A, Eq. 17 and 18)
/// shows `H_i² ≤ R_v² + H_b²`.
pub fn interior_bound(boundary: Interval, volume_radius: Interval) -> f64 {
    libm::hypot(boundary.upper, volume_radius.upper)
}

/// The surface of a part as the union of its triangles.
struct Surface<'a>(&'a SolidIndex);

impl Union for Surface<'_> {
    fn nearest(&self, q: DVec3, guess: u32) -> (u32, f64) {
        let bvh = self.0.bvh();
        if bvh.is_empty() {
            return (guess, f64::INFINITY);
        }
        let known = bvh.triangle(guess).distance2(q);
        let found = bvh.nearest(q, known);
        found.map_or((guess, known.sqrt()), |n| (n.slot, n.distance2.sqrt()))
    }

    fn distance(&self, member: u32, q: DVec3) -> f64 {
        self.0.bvh().triangle(member).distance2(q).sqrt()
    }
}

/// The volume of a closed mesh and a bound of its rounding error: a sum of n
/// terms, each wrong by a few ulps of itself.
fn volume(mesh: &Mesh) -> (f64, f64) {
    let Some(apex) = mesh.vertices.first() else {
        return (0.0, 0.0);
    };
    let (mut sum, mut size) = (0.0, 0.0);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t).map(|v| v - *apex);
        sum += a.dot(b.cross(c)) / 6.0;
        size += a.length() * b.length() * c.length() / 6.0;
    }
    let terms = mesh.triangles.len() as f64 + 16.0;
    (sum, terms * f64::EPSILON * size)
}

#[cfg(test)]
mod tests {
    use assetpipe_geometry::hull::convex_hull;

    use super::*;
    use crate::shapes;

    const CLOSE: Gap = Gap {
        relative: 0.005,
        absolute: 0.0,
    };

    struct Case {
        mesh: Mesh,
        part: SolidIndex,
        hull: Mesh,
    }

    fn case(mesh: Mesh) -> Case {
        Case {
            part: SolidIndex::new(&mesh),
            hull: convex_hull(&mesh.vertices).unwrap(),
            mesh,
        }
    }

    fn cases() -> Vec<Case> {
        let void = shapes::placed(&shapes::reversed(&shapes::ball(2)), 0.7, DVec3::ZERO);
        [
            shapes::ell(),
            shapes::turned(&shapes::ell()),
            shapes::turned(&shapes::plate_with_hole(0.3)),
            shapes::turned(&shapes::plate_with_hole(1.8)),
            shapes::turned(&shapes::torus(0.3, 24, 12)),
            shapes::turned(&shapes::torus(0.9, 24, 12)),
            shapes::both(&shapes::ball(2), &void),
            shapes::turned(&shapes::cuboid(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.3))),
        ]
        .map(case)
        .into()
    }

    #[test]
    fn a_tall_ell() {
        let square = |x: f64, y: f64| vec![(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)];
        let squares = [square(0.0, 0.0), square(1.0, 0.0), square(0.0, 1.0)];
        let tall = shapes::prism(&squares, 0.0, 4.0);
        for mesh in [tall.clone(), shapes::turned(&tall)] {
            let Case { part, hull, .. } = case(mesh);
            // The inner edge lies √½ below the slanted face, whose middle line
            // is a half away from the walls.
            let found = bounds(&part, &hull, CLOSE, &Limits::default());
            assert!(found.boundary.holds(0.5f64.sqrt()), "{found:?}");
            assert!(found.interior.holds(0.5), "{found:?}");
            assert!(found.boundary.upper <= 1.005 * found.boundary.lower + 1e-7);
            assert!(found.interior.upper <= 1.005 * found.interior.lower + 1e-7);
        }
    }

    #[test]
    fn a_deep_narrow_hole() {
        // The green example of Figure 2: H_i is half the width, H_b half the depth
        // of a hole through and through.
        let Case { part, hull, .. } = case(shapes::turned(&shapes::plate_with_hole(0.05)));
        let found = bounds(&part, &hull, CLOSE, &Limits::default());
        assert!(found.interior.holds(0.05), "{found:?}");
        assert!(found.boundary.holds(0.5), "{found:?}");
    }

    #[test]
    fn never_below_samples_of_both_boundaries() {
        for Case { mesh, part, hull } in cases() {
            let found = boundary(&part, &hull, CLOSE, &Limits::default());
            let body = ConvexBody::new(&hull);
            let deepest = samples(&mesh)
                .map(|p| {
                    body.half_spaces()
                        .iter()
                        .fold(f64::INFINITY, |d, s| d.min(s.offset - s.normal.dot(p)))
                })
                .fold(0.0, f64::max);
            let highest = samples(&hull)
                .map(|q| part.surface(q).unwrap().distance2.sqrt())
                .fold(0.0, f64::max);
            let sampled = deepest.max(highest);
            assert!(sampled <= found.upper, "{sampled} {found:?}");
            assert!(sampled >= 0.9 * found.lower - 1e-9, "{sampled} {found:?}");
            assert!(found.upper <= 1.005 * found.lower + 1e-6, "{found:?}");
        }
    }

    /// Points spread over all triangles, corners included.
    fn samples(mesh: &Mesh) -> impl Iterator<Item = DVec3> + '_ {
        const STEPS: usize = 12;
        (0..mesh.triangles.len()).flat_map(|t| {
            let [a, b, c] = mesh.corners(t);
            (0..=STEPS).flat_map(move |i| {
                (0..=STEPS - i).map(move |j| {
                    let (u, v) = (i as f64 / STEPS as f64, j as f64 / STEPS as f64);
                    a + (b - a) * u + (c - a) * v
                })
            })
        })
    }

    #[test]
    fn theorem_1() {
        for Case { mesh, part, hull } in cases() {
            let found = bounds(&part, &hull, CLOSE, &Limits::default());
            let radius = volume_radius(&mesh, &hull);
            let largest = found.boundary.max(radius).upper;
            assert!(2.0f64.sqrt() * largest >= found.value().lower);
            assert!(interior_bound(found.boundary, radius) >= found.interior.lower);
            let stand_in = stand_in(found.boundary, radius, K);
            assert!(stand_in.lower >= found.boundary.lower);
        }
    }

    #[test]
    fn volume_of_the_difference() {
        // Half a unit cube is missing from the L's hull.
        let Case { mesh, hull, .. } = case(shapes::ell());
        let expected = libm::cbrt(3.0 * 0.5 / (4.0 * std::f64::consts::PI));
        let found = volume_radius(&mesh, &hull);
        assert!(found.holds(expected) && found.upper - found.lower < 1e-12);
        let cube = case(shapes::cuboid(DVec3::ZERO, DVec3::ONE));
        let none = volume_radius(&cube.mesh, &cube.hull);
        assert!(none.lower == 0.0 && none.upper < 1e-4);
    }

    #[test]
    fn decisions_agree_with_the_interval() {
        for Case { part, hull, .. } in cases() {
            let value = bounds(&part, &hull, CLOSE, &Limits::default()).value();
            for share in [0.3, 0.7, 0.98, 1.02, 1.5] {
                let epsilon = share * value.upper + 1e-6;
                match decide(&part, &hull, epsilon, &Limits::default()) {
                    Decision::Within(found) => {
                        assert!(epsilon >= value.lower && found.upper <= epsilon);
                    }
                    Decision::Beyond { lower, .. } => {
                        assert!(epsilon <= value.upper && lower > epsilon);
                        assert!(lower <= value.upper);
                    }
                    Decision::Unproven(found) => panic!("{found:?} {epsilon} {value:?}"),
                }
            }
        }
    }
}

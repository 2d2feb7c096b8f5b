//! How much of a solid's surface no hull covers.

use assetpipe_geometry::bvh::{Bounds, Bvh};
use assetpipe_geometry::distance::{ConvexBody, HalfSpace};
use assetpipe_geometry::{DVec3, Mesh};

use super::goal::Goal;
use super::patches::{farthest, Union};
use super::{Gap, Interval, Limits};

/// Share of the diagonal by which hulls are widened so that two that meet in a
/// face leave no crack of rounding.
const CRACK: f64 = 1e-10;
/// Multiple of that by which the result may be wrong.
const SLACK: f64 = 100.0;

/// sup over the points p of the surface of `solid` of d(p, union of `hulls`):
/// zero, up to rounding, if they cover it. Each hull as returned by
/// `convex_hull`; infinite if there is none.
///
/// What each hull covers of a triangle is cut off exactly; only what is left is
/// measured, by branch and bound.
pub fn uncovered(solid: &Mesh, hulls: &[Mesh], gap: Gap, limits: &Limits) -> Interval {
    if solid.triangles.is_empty() {
        return Interval::exactly(0.0);
    }
    if hulls.is_empty() {
        return Interval::exactly(f64::INFINITY);
    }
    let cover = Cover::new(solid, hulls);
    let mut left = Vec::new();
    for t in 0..solid.triangles.len() {
        if t % 64 == 0 && (limits.cancelled)() {
            return Interval {
                lower: 0.0,
                upper: cover.diagonal + farthest_apart(solid, hulls),
            };
        }
        cover.cut_off(solid.corners(t), &mut left);
    }
    let goal = Goal::Measure { gap };
    let pieces = left.iter().flat_map(|polygon| {
        (1..polygon.len() - 1).map(move |k| [polygon[0], polygon[k], polygon[k + 1]])
    });
    let found = farthest(&cover, pieces, 0.0, cover.slack, goal, limits).interval;
    Interval {
        lower: found.lower,
        upper: found.upper.max(cover.slack),
    }
}

/// No point of the one is farther from some point of the other.
fn farthest_apart(solid: &Mesh, hulls: &[Mesh]) -> f64 {
    let around = hulls.iter().fold(Bounds::EMPTY, |b, h| {
        b.join(Bounds::around(h.vertices.iter().copied()))
    });
    around
        .join(Bounds::around(solid.vertices.iter().copied()))
        .diagonal()
}

struct Member<'a> {
    body: ConvexBody<'a>,
    surface: Bvh,
    /// How far its half-spaces are widened for cutting; `None` for a hull so
    /// flat that this would mean another hull.
    crack: Option<f64>,
}

struct Cover<'a> {
    members: Vec<Member<'a>>,
    diagonal: f64,
    /// Allowance for widening and rounding.
    slack: f64,
}

impl<'a> Cover<'a> {
    fn new(solid: &Mesh, hulls: &'a [Mesh]) -> Cover<'a> {
        let bounds = hulls.iter().map(|h| &h.vertices).fold(
            Bounds::around(solid.vertices.iter().copied()),
            |b, vertices| b.join(Bounds::around(vertices.iter().copied())),
        );
        let diagonal = bounds.diagonal();
        let rounding = 16.0 * f64::EPSILON * bounds.lo.abs().max(bounds.hi.abs()).max_element();
        let crack = CRACK * diagonal + rounding;
        let slack = SLACK * crack;
        let members = hulls
            .iter()
            .map(|hull| {
                let body = ConvexBody::new(hull);
                let centre = body.centre();
                // A body widened by c at all its half-spaces lies in the body
                // enlarged about its centre by 1 + c / room.
                let room = body
                    .half_spaces()
                    .iter()
                    .map(|s| s.offset - s.normal.dot(centre))
                    .fold(f64::INFINITY, f64::min);
                let most = 0.5 * slack * room / body.bounds().diagonal();
                Member {
                    body,
                    surface: Bvh::new(hull),
                    crack: (most > rounding).then_some(crack.min(most)),
                }
            })
            .collect();
        Cover {
            members,
            diagonal,
            slack,
        }
    }

    /// Append to `left` what no hull covers of a triangle, as convex polygons.
    fn cut_off(&self, corners: [DVec3; 3], left: &mut Vec<Vec<DVec3>>) {
        let bounds = Bounds::around(corners);
        let near = |m: &Member| {
            let b = m.body.bounds();
            b.lo.cmple(bounds.hi + self.slack).all() && bounds.lo.cmple(b.hi + self.slack).all()
        };
        let members: Vec<(&[HalfSpace], f64)> = self
            .members
            .iter()
            .filter(|m| near(m))
            .filter_map(|m| Some((m.body.half_spaces(), m.crack?)))
            .collect();
        let whole = members.iter().any(|(spaces, crack)| {
            let within = |s: &HalfSpace, p: &DVec3| s.normal.dot(*p) <= s.offset + crack;
            spaces.iter().all(|s| corners.iter().all(|c| within(s, c)))
        });
        if whole {
            return;
        }
        let mut pieces = vec![corners.to_vec()];
        for (spaces, crack) in members {
            let mut next = Vec::new();
            for piece in pieces {
                subtract(piece, spaces, crack, &mut next);
            }
            pieces = next;
        }
        left.extend(pieces);
    }
}

/// What is outside a body of a convex polygon, as convex polygons.
fn subtract(polygon: Vec<DVec3>, spaces: &[HalfSpace], crack: f64, out: &mut Vec<Vec<DVec3>>) {
    let start = out.len();
    let mut inside = polygon.clone();
    for space in spaces {
        let (within, without) = split(&inside, space, crack);
        if without.len() >= 3 {
            out.push(without);
        }
        inside = within;
        if inside.len() < 3 {
            // Nothing is covered: the polygon stays in one piece.
            out.truncate(start);
            out.push(polygon);
            return;
        }
    }
}

/// The parts of a convex polygon on both sides of a half-space moved outward by
/// `margin`.
fn split(polygon: &[DVec3], space: &HalfSpace, margin: f64) -> (Vec<DVec3>, Vec<DVec3>) {
    let value = |p: DVec3| space.normal.dot(p) - space.offset - margin;
    let (mut within, mut without) = (Vec::new(), Vec::new());
    for k in 0..polygon.len() {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let (here, there) = (value(p), value(q));
        if here <= 0.0 {
            within.push(p);
        } else {
            without.push(p);
        }
        if (here <= 0.0) != (there <= 0.0) {
            let crossing = p + (q - p) * (here / (here - there));
            within.push(crossing);
            without.push(crossing);
        }
    }
    (within, without)
}

impl Union for Cover<'_> {
    fn nearest(&self, q: DVec3, guess: u32) -> (u32, f64) {
        let mut best = (guess, self.distance(guess, q));
        for (k, member) in self.members.iter().enumerate() {
            if best.1 == 0.0 {
                break;
            }
            if k as u32 != guess && member.body.bounds().distance2(q) < best.1 * best.1 {
                let distance = self.distance(k as u32, q);
                if distance < best.1 {
                    best = (k as u32, distance);
                }
            }
        }
        best
    }

    fn distance(&self, member: u32, q: DVec3) -> f64 {
        let Member { body, surface, .. } = &self.members[member as usize];
        let holds = body
            .half_spaces()
            .iter()
            .all(|s| s.normal.dot(q) <= s.offset);
        if holds {
            return 0.0;
        }
        surface
            .nearest(q, f64::INFINITY)
            .map_or(f64::INFINITY, |n| n.distance2.sqrt())
    }
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

    fn measure(solid: &Mesh, hulls: &[Mesh]) -> Interval {
        uncovered(solid, hulls, CLOSE, &Limits::default())
    }

    fn square_column(x: f64, y: f64, z: f64) -> Mesh {
        let (lo, hi) = (DVec3::new(x, y, 0.0), DVec3::new(x + 1.0, y + 1.0, z));
        convex_hull(&shapes::cuboid(lo, hi).vertices).unwrap()
    }

    fn turned_hull(mesh: &Mesh) -> Mesh {
        convex_hull(&shapes::turned(mesh).vertices).unwrap()
    }

    #[test]
    fn hulls_that_meet_leave_nothing() {
        let hulls = [
            square_column(0.0, 0.0, 1.0),
            square_column(1.0, 0.0, 1.0),
            square_column(0.0, 1.0, 1.0),
        ];
        let found = measure(&shapes::ell(), &hulls);
        assert!(found.lower == 0.0 && found.upper < 1e-6, "{found:?}");
        let turned = hulls.map(|h| turned_hull(&h));
        let found = measure(&shapes::turned(&shapes::ell()), &turned);
        assert!(found.lower == 0.0 && found.upper < 1e-6, "{found:?}");
    }

    #[test]
    fn a_missing_hull_is_found_and_measured() {
        let hulls = [square_column(0.0, 0.0, 1.0), square_column(1.0, 0.0, 1.0)];
        // The upper square's far edge is one away.
        let found = measure(&shapes::ell(), &hulls);
        assert!(
            found.holds(1.0) && found.upper < 1.005 * found.lower,
            "{found:?}"
        );
        let turned = hulls.map(|h| turned_hull(&h));
        let found = measure(&shapes::turned(&shapes::ell()), &turned);
        assert!(
            found.holds(1.0) && found.upper < 1.005 * found.lower,
            "{found:?}"
        );
    }

    #[test]
    fn a_hull_too_small_by_a_little() {
        let ball = shapes::ball(3);
        let smaller = convex_hull(&shapes::placed(&ball, 0.99, DVec3::ZERO).vertices).unwrap();
        let found = measure(&ball, &[smaller]);
        // The corners stand out most; the faces between them a little less.
        assert!(found.lower > 0.0095 && found.upper < 0.0101, "{found:?}");
    }

    #[test]
    fn no_hull_at_all() {
        let found = measure(&shapes::ell(), &[]);
        assert_eq!(found, Interval::exactly(f64::INFINITY));
    }

    #[test]
    fn cancelling_tells_nothing_false() {
        let hulls = [square_column(0.0, 0.0, 1.0)];
        let limits = Limits {
            cells: 10,
            cancelled: &|| true,
        };
        let found = uncovered(&shapes::ell(), &hulls, CLOSE, &limits);
        assert!(found.holds(2.0f64.sqrt()), "{found:?}");
    }
}

//! One body grows until planes stop it on all sides.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use assetpipe_geometry::bvh::{Bounds, Branch, Bvh};
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use super::body::Body;

/// Planes keep this share of their distance away from what they stop at, so
/// that rounding cannot carry the polytope across.
const AWAY: f64 = 1e-9;

/// A body stopped by more planes is given up.
const MOST_PLANES: usize = 4000;

/// A half-space `normal · y ≤ offset` in the body's own coordinates.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

/// What waits to be met: nodes of the hierarchy and clipped triangles.
enum Met {
    Node(u32),
    /// A triangle, what the planes leave of it, and how many of them that were.
    Triangle(u32, Vec<DVec3>, usize),
}

struct Waiting {
    distance: f64,
    order: u64,
    what: Met,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Waiting {}
impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance
            .total_cmp(&other.distance)
            .then(self.order.cmp(&other.order))
    }
}

/// Grow `body` within the bounds of the surface. Planes may stop it up to
/// `ease` before it touches (input length), which saves planes on curved
/// surfaces. `None` if it cannot grow: its centre is on the surface.
pub fn grow(surface: &Bvh, body: &Body, ease: f64) -> Option<Mesh> {
    let mut planes = around(&surface.bounds(), body)?;
    let mut queue = BinaryHeap::new();
    let mut order = 0;
    let mut wait = |queue: &mut BinaryHeap<Reverse<Waiting>>, distance: f64, what: Met| {
        order += 1;
        queue.push(Reverse(Waiting {
            distance,
            order,
            what,
        }));
    };
    wait(&mut queue, 0.0, Met::Node(0));
    while let Some(Reverse(next)) = queue.pop() {
        match next.what {
            Met::Node(index) => {
                if beyond(&planes, &body.own_bounds(&surface.node_bounds(index))) {
                    continue;
                }
                match surface.branch(index) {
                    Branch::Fork(children) => {
                        for child in children {
                            let bounds = body.own_bounds(&surface.node_bounds(child));
                            let distance = bounds.distance2(DVec3::ZERO).sqrt();
                            wait(&mut queue, distance.max(next.distance), Met::Node(child));
                        }
                    }
                    Branch::Leaf(slots) => {
                        for slot in slots {
                            let corners = surface.triangle(slot).corners().map(|p| body.own(p));
                            let mut polygon = corners.to_vec();
                            if cut(&mut polygon, &planes) {
                                let distance = nearest(&polygon, corners).distance;
                                let what = Met::Triangle(slot, polygon, planes.len());
                                wait(&mut queue, distance, what);
                            }
                        }
                    }
                }
            }
            Met::Triangle(slot, mut polygon, seen) => {
                if !cut(&mut polygon, &planes[seen..]) {
                    continue;
                }
                let corners = surface.triangle(slot).corners().map(|p| body.own(p));
                let met = nearest(&polygon, corners);
                if seen < planes.len() && met.distance > next.distance {
                    let what = Met::Triangle(slot, polygon, planes.len());
                    wait(&mut queue, met.distance, what);
                    continue;
                }
                planes.push(stop(&met, body, ease)?);
                if planes.len() > MOST_PLANES {
                    return None;
                }
            }
        }
    }
    polytope(&planes, body)
}

/// The planes of the surface's bounding box: nothing is outside of it.
fn around(bounds: &Bounds, body: &Body) -> Option<Vec<HalfSpace>> {
    let mut planes = Vec::with_capacity(64);
    for axis in 0..3 {
        for (normal, gap) in [
            (DVec3::AXES[axis], bounds.hi[axis] - body.centre[axis]),
            (-DVec3::AXES[axis], body.centre[axis] - bounds.lo[axis]),
        ] {
            // The plane through x = centre + gap · normal, seen from the body.
            let [p, q, r] = [
                normal * gap,
                normal * gap + DVec3::AXES[(axis + 1) % 3],
                normal * gap + DVec3::AXES[(axis + 2) % 3],
            ]
            .map(|x| body.own(body.centre + x));
            let across = (q - p).cross(r - p).normalize();
            let across = if across.dot(p) < 0.0 { -across } else { across };
            let offset = across.dot(p) * (1.0 - AWAY);
            if !(gap > 0.0 && offset > 0.0) {
                return None;
            }
            planes.push(HalfSpace {
                normal: across,
                offset,
            });
        }
    }
    Some(planes)
}

/// Whether a box lies wholly beyond one plane.
fn beyond(planes: &[HalfSpace], bounds: &Bounds) -> bool {
    let centre = bounds.centre();
    let half = 0.5 * (bounds.hi - bounds.lo);
    planes
        .iter()
        .any(|p| p.normal.dot(centre) - p.normal.abs().dot(half) >= p.offset)
}

/// Where the body meets a triangle.
struct Meeting {
    distance: f64,
    point: DVec3,
    /// Unit normal of the triangle away from the body, if met inside the face.
    face: Option<DVec3>,
    /// Diameter of what is left of the triangle.
    width: f64,
}

/// Cut a polygon by half-spaces; whether something is left.
fn cut(polygon: &mut Vec<DVec3>, planes: &[HalfSpace]) -> bool {
    // The latest planes are the ones that stopped at the neighbours.
    let all_beyond = |p: &HalfSpace| polygon.iter().all(|c| p.normal.dot(*c) >= p.offset);
    if planes.iter().rev().any(all_beyond) {
        return false;
    }
    let mut scratch = Vec::new();
    for plane in planes {
        clip(polygon, plane, &mut scratch);
        if polygon.is_empty() {
            return false;
        }
    }
    true
}

/// Keep what is strictly below the plane, and the border.
fn clip(polygon: &mut Vec<DVec3>, plane: &HalfSpace, scratch: &mut Vec<DVec3>) {
    let height = |p: DVec3| plane.normal.dot(p) - plane.offset;
    if polygon.iter().all(|p| height(*p) <= 0.0) {
        if polygon.iter().all(|p| height(*p) == 0.0) {
            polygon.clear();
        }
        return;
    }
    scratch.clear();
    let mut last = polygon[polygon.len() - 1];
    let mut last_height = height(last);
    for &p in polygon.iter() {
        let h = height(p);
        if (h < 0.0) != (last_height < 0.0) {
            let share = last_height / (last_height - h);
            scratch.push(last + (p - last) * share);
        }
        if h < 0.0 {
            scratch.push(p);
        }
        (last, last_height) = (p, h);
    }
    std::mem::swap(polygon, scratch);
}

/// Where the body meets what is left of a triangle.
fn nearest(polygon: &[DVec3], corners: [DVec3; 3]) -> Meeting {
    let [a, b, c] = corners;
    let cross = (b - a).cross(c - a);
    let area = cross.length();
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let width = polygon
        .iter()
        .map(|p| p.distance(polygon[0]))
        .fold(0.0, f64::max);
    if area > 1e-9 * longest * longest {
        let normal = cross / area;
        let height = normal.dot(a);
        let foot = normal * height;
        let inside = (0..polygon.len()).all(|i| {
            let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            normal.dot((q - p).cross(foot - p)) >= 0.0
        });
        if inside && height != 0.0 {
            return Meeting {
                distance: height.abs(),
                point: foot,
                face: Some(normal * height.signum()),
                width,
            };
        }
    }
    let mut best = (f64::INFINITY, a);
    for i in 0..polygon.len() {
        let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let along = q - p;
        let length2 = along.length_squared();
        let t = if length2 > 0.0 {
            (-p.dot(along) / length2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let point = p + along * t;
        let d2 = point.length_squared();
        if d2 < best.0 {
            best = (d2, point);
        }
    }
    Meeting {
        distance: best.0.sqrt(),
        point: best.1,
        face: None,
        width,
    }
}

/// The plane that stops the body at a meeting: the triangle's own where its
/// face is met, else the one that touches the body there.
fn stop(met: &Meeting, body: &Body, ease: f64) -> Option<HalfSpace> {
    if met.distance <= 0.0 || met.distance.is_nan() {
        return None;
    }
    let normal = met.face.unwrap_or_else(|| met.point / met.distance);
    let touch = normal.dot(met.point);
    // Large faces are met exactly; on fine ones the plane gives way for the neighbours.
    let eased = (ease * body.stretch(normal)).min(0.1 * touch);
    let eased = if met.width * met.width > 8.0 * eased * touch {
        0.0
    } else {
        eased
    };
    let offset = touch * (1.0 - AWAY) - eased;
    (offset > 0.0).then_some(HalfSpace { normal, offset })
}

/// The polytope of the planes: the dual of the hull of their poles.
fn polytope(planes: &[HalfSpace], body: &Body) -> Option<Mesh> {
    let poles: Vec<DVec3> = planes.iter().map(|p| p.normal / p.offset).collect();
    let dual = convex_hull(&poles).ok()?;
    let mut points = Vec::with_capacity(dual.triangles.len());
    for [a, b, c] in dual.faces() {
        let normal = (b - a).cross(c - a);
        let height = normal.dot(a);
        // Nearly coplanar poles of a fan have the corner from their neighbours.
        if height > 0.0 {
            let corner = normal / height;
            if planes
                .iter()
                .all(|p| p.normal.dot(corner) <= p.offset * (1.0 + 0.5 * AWAY))
            {
                points.push(body.outer(corner));
            }
        }
    }
    convex_hull(&points).ok()
}

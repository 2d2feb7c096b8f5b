//! What a boundary corner or a point sees: triangular expansion through the
//! constrained triangulation (Bungiu et al. 2014), all decisions exact.

use spade::{PositionInTriangulation, Triangulation as _};

use crate::arrangement::{arrange, handle, index, Edge, Triangulation};
use crate::boundary::Boundary;
use crate::point::{distance_to_segment, orient};
use crate::{OutlineError, Point};

/// A window through which the eye looks on: the far side of `edge`, between
/// the rays through `right` and `left`.
struct Window<'a> {
    edge: Edge<'a>,
    right: Point,
    left: Point,
}

fn place(
    edge_end: spade::handles::VertexHandle<'_, spade::Point2<f64>, (), spade::CdtEdge<()>, ()>,
) -> Point {
    let p = edge_end.position();
    Point::new(p.x, p.y)
}

/// Reports every vertex that a diagonal from `corner` can reach inside the
/// polygon. Windows for which `open(from, to)` is false are not looked through.
/// `seen(vertex, distance)` returns the distance beyond which vertices no
/// longer matter.
pub(crate) fn from_corner(
    cdt: &Triangulation,
    boundary: &Boundary,
    corner: u32,
    open: impl Fn(Point, Point) -> bool,
    mut seen: impl FnMut(u32, f64) -> f64,
) {
    let eye = boundary.point(corner);
    let this = handle(boundary.vertex[corner as usize]);
    let next = handle(boundary.vertex[boundary.next(corner) as usize]);
    let previous = boundary.vertex[boundary.previous(corner) as usize];
    let Some(first) = cdt.get_edge_from_neighbors(this, next) else {
        return;
    };
    let mut limit = f64::INFINITY;
    let mut stack = Vec::new();
    let mut spoke = first;
    loop {
        let far = spoke.next();
        stack.push(Window {
            edge: far,
            right: place(far.from()),
            left: place(far.to()),
        });
        spoke = spoke.prev().rev();
        // a corner of 360° returns to its first edge
        let end = index(spoke.to().fix()) == previous && spoke.is_constraint_edge();
        if end || spoke.fix() == first.fix() {
            break;
        }
        limit = limit.min(seen(
            index(spoke.to().fix()),
            eye.distance(place(spoke.to())),
        ));
    }
    while let Some(window) = stack.pop() {
        if window.edge.is_constraint_edge() {
            continue;
        }
        let (a, b) = (place(window.edge.from()), place(window.edge.to()));
        if !open(a, b) || distance_to_segment(eye, a, b) > limit {
            continue;
        }
        let beyond = window.edge.rev();
        let w = beyond.next().to();
        let at = place(w);
        let left_of_right = orient(eye, window.right, at) > 0.0;
        let right_of_left = orient(eye, window.left, at) < 0.0;
        if left_of_right && right_of_left {
            limit = limit.min(seen(index(w.fix()), eye.distance(at)));
        }
        if left_of_right {
            let left = if right_of_left { at } else { window.left };
            stack.push(Window {
                edge: beyond.next(),
                right: window.right,
                left,
            });
        }
        if right_of_left {
            let right = if left_of_right { at } else { window.right };
            stack.push(Window {
                edge: beyond.prev(),
                right,
                left: window.left,
            });
        }
    }
}

/// The region that `eye`, a point strictly inside the domain, sees:
/// counter-clockwise and star-shaped about `eye`. Window ends are rounded.
/// Empty when `eye` lies on a vertex or an edge or outside the triangulation.
pub(crate) fn from_point(cdt: &Triangulation, eye: Point) -> Vec<Point> {
    let PositionInTriangulation::OnFace(face) = cdt.locate(spade::Point2::new(eye.x, eye.y)) else {
        return Vec::new();
    };
    let mut region: Vec<Point> = Vec::new();
    // counter-clockwise: the stack holds later windows below earlier ones
    let mut stack: Vec<Window<'_>> = cdt
        .face(face)
        .adjacent_edges()
        .into_iter()
        .rev()
        .map(|edge| Window {
            edge,
            right: place(edge.from()),
            left: place(edge.to()),
        })
        .collect();
    while let Some(window) = stack.pop() {
        let (a, b) = (place(window.edge.from()), place(window.edge.to()));
        if window.edge.is_constraint_edge() {
            for ray in [window.right, window.left] {
                let hit = if ray == a || ray == b {
                    ray
                } else {
                    along_ray(eye, ray, a, b)
                };
                if region.last() != Some(&hit) {
                    region.push(hit);
                }
            }
            continue;
        }
        let beyond = window.edge.rev();
        let at = place(beyond.next().to());
        let left_of_right = orient(eye, window.right, at) > 0.0;
        let right_of_left = orient(eye, window.left, at) < 0.0;
        if right_of_left {
            let right = if left_of_right { at } else { window.right };
            stack.push(Window {
                edge: beyond.prev(),
                right,
                left: window.left,
            });
        }
        if left_of_right {
            let left = if right_of_left { at } else { window.left };
            stack.push(Window {
                edge: beyond.next(),
                right: window.right,
                left,
            });
        }
    }
    if region.len() > 1 && region.first() == region.last() {
        region.pop();
    }
    region
}

/// Where the ray from `eye` through `ray` meets the line `a b`.
fn along_ray(eye: Point, ray: Point, a: Point, b: Point) -> Point {
    let (da, db) = (orient(eye, ray, a), orient(eye, ray, b));
    let t = if da == db {
        0.0
    } else {
        (da / (da - db)).clamp(0.0, 1.0)
    };
    Point::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))
}

/// What every notch of a simple polygon sees: the polygon without redundant
/// vertices, counter-clockwise, and per vertex, if it is a notch, the
/// positions of the vertices that a diagonal or an edge joins to it.
///
/// # Errors
/// [`OutlineError`] when `ring` is no simple polygon's boundary.
pub fn notch_visibility(ring: &[Point]) -> Result<(Vec<Point>, Vec<Vec<u32>>), OutlineError> {
    let arrangement = arrange(&[ring.to_vec()])?;
    let mut boundary = Boundary::new(arrangement.points.clone());
    let start = boundary.add_ring(&arrangement.components[0].outer);
    boundary.sort_corners();
    let corners = boundary.ring(start);
    let mut seen = vec![Vec::new(); corners.len()];
    for (k, &corner) in corners.iter().enumerate() {
        if boundary.is_notch(corner) {
            let eye = boundary.point(corner);
            from_corner(
                &arrangement.cdt,
                &boundary,
                corner,
                |_, _| true,
                |vertex, _| {
                    // corners of the only ring are numbered along it
                    seen[k].extend(boundary.facing(vertex, eye));
                    f64::INFINITY
                },
            );
            seen[k].extend([boundary.previous(corner), boundary.next(corner)]);
        }
    }
    Ok((
        corners.into_iter().map(|c| boundary.point(c)).collect(),
        seen,
    ))
}

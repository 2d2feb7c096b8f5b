//! Where a plane meets a mesh: sides, crossing points, and one name for each
//! point of the section.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;
use crate::plane::Plane;
use crate::predicates::side;

/// The coordinates that a plane keeps when seen along its steepest axis, so
/// that the picture is counter-clockwise for an eye above. The picture of a
/// point on the plane determines the point.
#[derive(Clone, Copy)]
pub(super) struct View {
    axes: (usize, usize),
}

impl View {
    pub(super) fn of(plane: &Plane) -> Self {
        let steep = plane.normal.abs();
        let axis = if steep.x >= steep.y && steep.x >= steep.z {
            0
        } else if steep.y >= steep.z {
            1
        } else {
            2
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        Self {
            axes: if plane.normal[axis] > 0.0 {
                (u, v)
            } else {
                (v, u)
            },
        }
    }

    pub(super) fn project(self, p: DVec3) -> DVec2 {
        DVec2::new(p[self.axes.0], p[self.axes.1])
    }

    /// The point that is seen at `picture`, on the line from `a` to `b`
    /// (for what that line determines) or on an axis-aligned plane.
    pub(super) fn lift(self, plane: &Plane, picture: DVec2) -> DVec3 {
        let (u, v) = self.axes;
        let w = 3 - u - v;
        let mut p = DVec3::ZERO;
        p[u] = picture.x;
        p[v] = picture.y;
        let n = plane.normal;
        p[w] = (plane.offset - n[u] * picture.x - n[v] * picture.y) / n[w];
        p
    }
}

/// Which side of the plane each vertex is on, exactly.
pub(super) fn sides(mesh: &Mesh, plane: &Plane) -> Vec<Ordering> {
    mesh.vertices.iter().map(|&v| side(plane, v)).collect()
}

/// The point where the edge from `low` (below) to `high` (above) meets the
/// plane: inside the edge's box, and on the plane to the last bit if the
/// plane is axis-aligned.
pub(super) fn crossing(plane: &Plane, low: DVec3, high: DVec3) -> DVec3 {
    // The signs are known exactly; rounding must not contradict them.
    let below = (-plane.evaluate(low)).max(0.0);
    let above = plane.evaluate(high).max(0.0);
    let total = below + above;
    // From the nearer end, so that the error is relative to the way gone.
    let p = if !(total > 0.0 && total.is_finite()) {
        low * 0.5 + high * 0.5
    } else if below <= above {
        low + (high - low) * (below / total)
    } else {
        high + (low - high) * (above / total)
    };
    let mut p = p.max(low.min(high)).min(low.max(high));
    if let Some((axis, normal)) = plane.axis() {
        p[axis] = plane.offset / normal;
    }
    p
}

/// The points of a section: vertices on the plane and crossings of edges,
/// each picture once.
pub(super) struct Section {
    /// Positions, ascending by picture.
    pub(super) points: Vec<DVec3>,
    /// Their pictures.
    pub(super) pictures: Vec<DVec2>,
    /// Whether several vertices or crossings round to the point.
    pub(super) is_shared: Vec<bool>,
    /// Section point per vertex of the mesh (where it is on the plane).
    pub(super) of_vertex: Vec<u32>,
    /// Crossed edges as (vertex below, vertex above), ascending, with their section points.
    pub(super) crossed: Vec<(u32, u32)>,
    pub(super) of_crossed: Vec<u32>,
}

impl Section {
    pub(super) fn new(mesh: &Mesh, plane: &Plane, view: View, sides: &[Ordering]) -> Self {
        let crossed = crossed_edges(mesh, sides);
        let mut candidates: Vec<(DVec2, u32, DVec3)> = Vec::new();
        for (vertex, side) in sides.iter().enumerate() {
            if side.is_eq() {
                let p = mesh.vertices[vertex];
                candidates.push((view.project(p), vertex as u32, p));
            }
        }
        // Vertices come before crossings: theirs is the exact position.
        let vertices = mesh.vertices.len() as u32;
        for (i, &(low, high)) in crossed.iter().enumerate() {
            let p = crossing(
                plane,
                mesh.vertices[low as usize],
                mesh.vertices[high as usize],
            );
            candidates.push((view.project(p), vertices + i as u32, p));
        }
        let key = |p: DVec2| p + DVec2::ZERO;
        candidates.sort_unstable_by(|a, b| {
            let (p, q) = (key(a.0), key(b.0));
            p.x.total_cmp(&q.x)
                .then(p.y.total_cmp(&q.y))
                .then(a.1.cmp(&b.1))
        });
        let mut section = Self {
            points: Vec::new(),
            pictures: Vec::new(),
            is_shared: Vec::new(),
            of_vertex: vec![0; sides.len()],
            of_crossed: vec![0; crossed.len()],
            crossed,
        };
        for (picture, source, p) in candidates {
            let is_new = section.pictures.last() != Some(&picture);
            if is_new {
                section.pictures.push(picture);
                section.points.push(p);
                section.is_shared.push(false);
            }
            let point = section.points.len() as u32 - 1;
            section.is_shared[point as usize] |= !is_new;
            match source.checked_sub(vertices) {
                None => section.of_vertex[source as usize] = point,
                Some(i) => section.of_crossed[i as usize] = point,
            }
        }
        section
    }

    /// The point at which the edge between two vertices of opposite sides crosses.
    pub(super) fn on_edge(&self, low: u32, high: u32) -> u32 {
        // Every edge asked for was gathered from the same triangles.
        let index = self.crossed.binary_search(&(low, high)).unwrap_or(0);
        self.of_crossed[index]
    }
}

fn crossed_edges(mesh: &Mesh, sides: &[Ordering]) -> Vec<(u32, u32)> {
    let mut crossed = Vec::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            match (sides[a as usize], sides[b as usize]) {
                (Ordering::Less, Ordering::Greater) => crossed.push((a, b)),
                (Ordering::Greater, Ordering::Less) => crossed.push((b, a)),
                _ => {}
            }
        }
    }
    crossed.sort_unstable();
    crossed.dedup();
    crossed
}

//! Polytopes around a hull, grown by supporting planes.

use glam::{DMat3, DVec3};

use super::{convex_hull, HullError};
use crate::clip::split;
use crate::distance::Triangle;
use crate::mesh::Mesh;
use crate::plane::Plane;
use crate::tolerance::Rounding;

/// A polytope of at most `max_vertices` (at least four) vertices around
/// `hull`, exactly.
///
/// Begins with a box or a tetrahedron and cuts off the vertex that is
/// farthest from the hull by the supporting plane at the hull's nearest point
/// (the sandwich scheme of Kamenev, *A class of adaptive algorithms for
/// approximating convex bodies by polyhedra*, 1992), as long as the count allows.
pub(super) fn circumscribe(hull: &Mesh, max_vertices: usize) -> Result<Mesh, HullError> {
    let rounding = Rounding::of(hull);
    let margin = 4.0 * rounding.crossing();
    let mut around = convex_hull(&start(hull, max_vertices, margin))?;
    // Distances of the vertices of the polytope, none yet known.
    let mut heights = distances(hull, &around.vertices);
    loop {
        let mut order: Vec<usize> = (0..heights.len()).collect();
        order.sort_by(|&a, &b| heights[b].0.total_cmp(&heights[a].0));
        let cut = order.iter().find_map(|&v| {
            let (height, foot) = heights[v];
            if height <= 16.0 * margin {
                return None;
            }
            let normal = (around.vertices[v] - foot) / height;
            let offset = support(hull, normal) + margin;
            let below = split(&around, &Plane { normal, offset }).ok()?.below?;
            let next = convex_hull(&below.vertices).ok()?;
            (next.vertices.len() <= max_vertices).then_some(next)
        });
        let Some(next) = cut else { break };
        heights = next
            .vertices
            .iter()
            .map(|p| match around.vertices.iter().position(|q| q == p) {
                Some(known) => heights[known],
                None => distance(hull, *p),
            })
            .collect();
        around = next;
    }
    enclose(hull, &around)
}

/// The corners of a box along the axes, or of a tetrahedron if eight are too many.
fn start(hull: &Mesh, max_vertices: usize, margin: f64) -> Vec<DVec3> {
    if max_vertices >= 8 {
        let high = DVec3::AXES.map(|axis| support(hull, axis) + margin);
        let low = DVec3::AXES.map(|axis| -support(hull, -axis) - margin);
        return (0..8)
            .map(|corner| {
                let pick = |axis: usize| {
                    if corner >> axis & 1 == 1 {
                        high[axis]
                    } else {
                        low[axis]
                    }
                };
                DVec3::new(pick(0), pick(1), pick(2))
            })
            .collect();
    }
    let normals = [
        (1.0, 1.0, 1.0),
        (1.0, -1.0, -1.0),
        (-1.0, 1.0, -1.0),
        (-1.0, -1.0, 1.0),
    ]
    .map(DVec3::from);
    let offsets = normals.map(|n| support(hull, n) + 2.0 * margin);
    (0..4)
        .map(|left_out| {
            let [a, b, c] = [1, 2, 3].map(|step| (left_out + step) % 4);
            let rows = DMat3::from_cols(normals[a], normals[b], normals[c]).transpose();
            rows.inverse() * DVec3::new(offsets[a], offsets[b], offsets[c])
        })
        .collect()
}

/// Largest `normal · x` over the hull.
fn support(hull: &Mesh, normal: DVec3) -> f64 {
    hull.vertices
        .iter()
        .map(|v| normal.dot(*v))
        .fold(f64::NEG_INFINITY, f64::max)
}

fn distances(hull: &Mesh, points: &[DVec3]) -> Vec<(f64, DVec3)> {
    points.iter().map(|p| distance(hull, *p)).collect()
}

/// Distance of an outer point, and the hull's nearest point.
fn distance(hull: &Mesh, p: DVec3) -> (f64, DVec3) {
    let feet = hull
        .faces()
        .map(|corners| Triangle::new(corners).closest(p));
    feet.map(|foot| (foot.distance(p), foot))
        .fold((f64::INFINITY, p), |best, next| {
            if next.0 < best.0 {
                next
            } else {
                best
            }
        })
}

/// Widens `around` until it contains every vertex of `hull` exactly.
fn enclose(hull: &Mesh, around: &Mesh) -> Result<Mesh, HullError> {
    let centre = hull.vertices.iter().sum::<DVec3>() / hull.vertices.len() as f64;
    let mut widened = around.clone();
    let mut growth = f64::EPSILON;
    // Doubling reaches any size in fewer steps than an exponent has values.
    while !contains(&widened, hull)? {
        growth *= 2.0;
        let vertices: Vec<DVec3> = around
            .vertices
            .iter()
            .map(|v| *v + (*v - centre) * growth)
            .collect();
        widened = convex_hull(&vertices)?;
    }
    Ok(widened)
}

/// Whether a hull contains another: exactly if nothing of the other is extreme.
pub(super) fn contains(outer: &Mesh, inner: &Mesh) -> Result<bool, HullError> {
    let both: Vec<DVec3> = outer
        .vertices
        .iter()
        .chain(&inner.vertices)
        .copied()
        .collect();
    Ok(convex_hull(&both)?.vertices == outer.vertices)
}

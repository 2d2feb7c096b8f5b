//! Closed surfaces, and those that are convex already.

use std::cmp::Ordering;

use assetpipe_geometry::predicates::orient3d;
use assetpipe_geometry::Mesh;

use crate::error::DecomposeError;
use crate::merge::volume;

/// A half-edge: (smaller, larger vertex, triangle, runs from smaller to larger).
type HalfEdge = (u32, u32, u32, bool);

fn half_edges(mesh: &Mesh) -> Vec<HalfEdge> {
    let mut edges: Vec<HalfEdge> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, c) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (c[i], c[(i + 1) % 3]);
            edges.push((a.min(b), a.max(b), t as u32, a < b));
        }
    }
    edges.sort_unstable();
    edges
}

/// Check that every edge is used as often in one sense as in the other: the
/// surface is a closed chain. Edges of more than two triangles are fine.
///
/// # Errors
/// [`DecomposeError::NotClosed`] names the first edge that is not.
pub fn check_closed(mesh: &Mesh) -> Result<(), DecomposeError> {
    let edges = half_edges(mesh);
    let open: Vec<&[HalfEdge]> = edges
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .filter(|run| 2 * run.iter().filter(|e| e.3).count() != run.len())
        .collect();
    match open.first() {
        None => Ok(()),
        Some(run) => Err(DecomposeError::NotClosed {
            from: run[0].0,
            to: run[0].1,
            count: open.len(),
        }),
    }
}

/// Whether a closed mesh is exactly convex, given its hull: a single surface
/// whose every edge is convex or flat by exact predicates, and which does not
/// wind around more than once (its volume is its hull's).
pub fn is_convex(mesh: &Mesh, hull: &Mesh) -> bool {
    let whole = volume(hull);
    if (volume(mesh) - whole).abs() > 1e-9 * whole {
        return false;
    }
    let edges = half_edges(mesh);
    edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).all(|run| {
        if run.len() != 2 {
            return false;
        }
        let [a, b, c] = mesh.corners(run[0].2 as usize);
        let opposite = mesh.triangles[run[1].2 as usize]
            .iter()
            .copied()
            .find(|&v| v != run[0].0 && v != run[0].1);
        opposite.is_some_and(|v| below_or_on(orient3d(a, b, c, mesh.vertices[v as usize])))
    })
}

/// `orient3d` of a counter-clockwise outward triangle and a point.
fn below_or_on(orientation: Ordering) -> bool {
    orientation != above()
}

/// What `orient3d` answers for a point above a counter-clockwise triangle.
fn above() -> Ordering {
    use glam::DVec3;
    orient3d(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;
    use glam::DVec3;

    fn cube() -> Vec<DVec3> {
        (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect()
    }

    #[test]
    fn a_cube_is_convex_and_a_dented_one_is_not() {
        let hull = convex_hull(&cube()).unwrap();
        assert!(is_convex(&hull, &hull));
        let mut dented = hull.clone();
        dented.vertices[0] = DVec3::splat(0.1);
        assert!(!is_convex(&dented, &convex_hull(&dented.vertices).unwrap()));
    }

    #[test]
    fn an_open_edge_is_named() {
        let mut hull = convex_hull(&cube()).unwrap();
        hull.triangles.pop();
        assert!(matches!(
            check_closed(&hull),
            Err(DecomposeError::NotClosed { count: 3, .. })
        ));
    }
}

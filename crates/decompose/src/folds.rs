//! Folds without thickness: edges over which a surface runs and back in its own plane.
//!
//! The two layers enclose nothing between them; they are a flap beside the solid, or a slit in
//! it. A sharp edge with material between its faces is no fold, however thin it is.

use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::edges::{by_edge, half_edges, opposite, HalfEdge};

/// Material between two layers that is rounding, as a share of the unit.
const FLAT: f64 = 1e-13;
/// Air between two layers that is rounding, of coordinates in single precision.
const WIDE: f64 = 1e-7;
/// Slope between two layers above which they are no fold, however small.
const STEEP: f64 = 1e-3;

/// The folded edges of a surface, vertices in the order of the first of the two triangles whose
/// edge runs from the smaller to the larger.
pub fn folds(mesh: &Mesh, unit: f64) -> Vec<[u32; 2]> {
    by_edge(&half_edges(mesh))
        .filter(|edge| is_fold(mesh, edge, unit))
        .map(|edge| [edge[0].0, edge[0].1])
        .collect()
}

/// Whether the two triangles of an edge lie on one another with no material between.
pub fn is_fold(mesh: &Mesh, edge: &[HalfEdge], unit: f64) -> bool {
    let [one, two] = edge else { return false };
    let (with, against) = if one.3 { (one, two) } else { (two, one) };
    if !with.3 || against.3 {
        return false;
    }
    let (Some(c), Some(d)) = (opposite(mesh, with), opposite(mesh, against)) else {
        return false;
    };
    let [a, b] = [with.0, with.1].map(|v| mesh.vertices[v as usize]);
    lie_on_one_another(a, b, c, d, unit)
}

/// Whether the faces (a, b, c) and (b, a, d) lie on one another with no material between.
fn lie_on_one_another(a: DVec3, b: DVec3, c: DVec3, d: DVec3, unit: f64) -> bool {
    let along = b - a;
    let (upper, lower) = (along.cross(c - a), (d - a).cross(along));
    if upper.dot(lower) >= 0.0 {
        return false;
    }
    let (size, other) = (upper.length(), lower.length());
    let heights = [upper.dot(d - a) / size, lower.dot(c - a) / other];
    let most = (WIDE * unit).min(STEEP * size.min(other) / along.length());
    heights.iter().all(|h| (-FLAT * unit..=most).contains(h))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;

    /// A box whose upper side reaches beyond its edge at x = 1 and comes back: the middle of its
    /// diagonal, moved there in the plane of the side, or by `rise` above it.
    fn with_flap(size: f64, rise: f64) -> Mesh {
        let mut mesh = cuboid(DVec3::ZERO, DVec3::splat(size));
        let upper: Vec<usize> = (0..mesh.triangles.len())
            .filter(|&t| mesh.corners(t).iter().all(|p| p.z == size))
            .collect();
        let [one, two] = upper[..] else {
            panic!("two triangles")
        };
        let shared = |v: &u32| mesh.triangles[two].contains(v);
        let tip = mesh.vertices.len() as u32;
        let ends: Vec<u32> = mesh.triangles[one].iter().copied().filter(shared).collect();
        for t in [one, two] {
            let corners = mesh.triangles[t];
            let i = (0..3).find(|&i| !ends.contains(&corners[i])).unwrap();
            let [apex, p, q] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
            mesh.triangles[t] = [apex, p, tip];
            mesh.triangles.push([apex, tip, q]);
        }
        mesh.vertices.push(DVec3::new(2.0, 0.3, 1.0 + rise) * size);
        mesh
    }

    #[test]
    fn a_box_has_none_and_one_with_a_flap_has_whatever_its_size() {
        for size in [1e-6, 1.0, 1e6] {
            assert!(folds(&cuboid(DVec3::ZERO, DVec3::splat(size)), size).is_empty());
            assert!(!folds(&with_flap(size, 0.0), size).is_empty());
        }
    }

    #[test]
    fn thin_material_is_no_fold_and_air_as_thin_is_one() {
        // Beyond the edge the two layers are the upper and the lower side of what is between.
        let count = |rise: f64| folds(&with_flap(1.0, rise), 1.0).len();
        assert_eq!([1e-9, 1e-6].map(count), [0, 0]);
        assert_eq!([-1e-9, -1e-6].map(count), [2, 0]);
    }
}

//! Integrals over meshes: volume, mass properties, area, extent.
//!
//! Sums run in the order of triangles, from a point of the mesh, so results
//! are reproducible and do not lose digits far from the origin.

use glam::{DMat3, DVec3};

use crate::hull::{Builder, HullError};
use crate::mesh::Mesh;

/// The smallest axis-aligned box around the used vertices, as its least and
/// greatest corner; nothing for a mesh without triangles.
pub fn bounds(mesh: &Mesh) -> Option<(DVec3, DVec3)> {
    let mut used = mesh.faces().flatten();
    let first = used.next()?;
    Some(used.fold((first, first), |(low, high), p| (low.min(p), high.max(p))))
}

/// Length of the diagonal of [`bounds`]; zero for a mesh without triangles.
pub fn diagonal(mesh: &Mesh) -> f64 {
    bounds(mesh).map_or(0.0, |(low, high)| low.distance(high))
}

/// Surface area.
pub fn area(mesh: &Mesh) -> f64 {
    mesh.faces().map(|f| double_area(f).length()).sum::<f64>() / 2.0
}

/// Enclosed volume (of a closed mesh; negative if inside out): the sum of
/// signed tetrahedra.
pub fn volume(mesh: &Mesh) -> f64 {
    let apex = apex(mesh);
    mesh.faces()
        .map(|f| six_fold_volume(f.map(|p| p - apex)))
        .sum::<f64>()
        / 6.0
}

/// Volume, centre of mass and inertia of a body of unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Enclosed volume.
    pub volume: f64,
    /// Centre of mass; not a number if the volume is zero.
    pub centroid: DVec3,
    /// Inertia tensor about the centroid along the mesh's axes (length⁵).
    pub inertia: DMat3,
}

/// Integrates over the tetrahedra between the faces of a closed mesh and one
/// of its points: ∫ x xᵀ over a tetrahedron (0, a, b, c) is det(a, b, c)/120 ·
/// (a aᵀ + b bᵀ + c cᵀ + s sᵀ) with s = a + b + c (Blow and Binstock, *How to
/// find the inertia tensor (or other mass properties) of a 3D solid body
/// represented by a triangle mesh*, 2004).
pub fn mass_properties(mesh: &Mesh) -> MassProperties {
    let apex = apex(mesh);
    let mut volume = 0.0;
    let mut moment = DVec3::ZERO;
    let mut second = DMat3::ZERO;
    for face in mesh.faces() {
        let [a, b, c] = face.map(|p| p - apex);
        let determinant = six_fold_volume([a, b, c]);
        let sum = a + b + c;
        volume += determinant / 6.0;
        moment += sum * (determinant / 24.0);
        second += (square(a) + square(b) + square(c) + square(sum)) * (determinant / 120.0);
    }
    let centre = moment / volume;
    let covariance = second - square(centre) * volume;
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    MassProperties {
        volume,
        centroid: apex + centre,
        inertia: DMat3::from_diagonal(DVec3::splat(trace)) - covariance,
    }
}

/// How far the mesh is from convex by volume: 1 − volume / hull volume, zero
/// for a convex solid (up to rounding).
///
/// # Errors
/// [`HullError`] where the mesh has no hull.
pub fn convexity_defect(mesh: &Mesh) -> Result<f64, HullError> {
    let hull = Builder::default().volume(&mesh.vertices)?;
    Ok(1.0 - volume(mesh) / hull)
}

/// Six times the signed volume between a triangle and the origin, as height
/// times area: products of long position vectors would cancel.
pub(crate) fn six_fold_volume(corners: [DVec3; 3]) -> f64 {
    corners[0].dot(double_area(corners))
}

/// A triangle's normal, of twice its area, from its two shorter edges: the
/// product of long edges of a needle would cancel.
fn double_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (u, v, w) = (b - a, c - b, a - c);
    let lengths = [u, v, w].map(DVec3::length_squared);
    if lengths[0] >= lengths[1] && lengths[0] >= lengths[2] {
        v.cross(w)
    } else if lengths[1] >= lengths[2] {
        w.cross(u)
    } else {
        u.cross(v)
    }
}

fn square(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

fn apex(mesh: &Mesh) -> DVec3 {
    bounds(mesh).map_or(DVec3::ZERO, |(low, high)| low * 0.5 + high * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    fn brick(size: DVec3, centre: DVec3) -> Mesh {
        let corners: Vec<DVec3> = (0..8)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .map(|p| centre + (p - 0.5) * size)
            .collect();
        convex_hull(&corners).unwrap()
    }

    #[test]
    fn a_brick_has_the_textbook_values_also_far_away() {
        let size = DVec3::new(1.0, 2.0, 4.0);
        for centre in [DVec3::ZERO, DVec3::new(1e4, -2e4, 3e4)] {
            let mesh = brick(size, centre);
            let tolerance = 1e-15 * (1.0 + centre.length());
            assert!((area(&mesh) - 28.0).abs() < 100.0 * tolerance);
            assert!((volume(&mesh) - 8.0).abs() < 100.0 * tolerance);
            assert!((diagonal(&mesh) - 21f64.sqrt()).abs() < 100.0 * tolerance);
            let mass = mass_properties(&mesh);
            assert!((mass.centroid - centre).length() < 10.0 * tolerance);
            let expected = DVec3::new(20.0, 17.0, 5.0) * 8.0 / 12.0;
            let difference = mass.inertia - DMat3::from_diagonal(expected);
            let largest = difference
                .to_cols_array()
                .into_iter()
                .fold(0.0, |m: f64, x| m.max(x.abs()));
            assert!(largest < 1000.0 * tolerance, "{largest}");
        }
    }

    #[test]
    fn a_dent_is_a_defect_of_its_volume() {
        let mesh = brick(DVec3::ONE, DVec3::ZERO);
        assert!(convexity_defect(&mesh).unwrap().abs() < 1e-15);
        let mut dented = mesh.clone();
        dented.vertices.push(DVec3::ZERO);
        let centre = dented.vertices.len() as u32 - 1;
        let [a, b, c] = dented.triangles[0];
        dented
            .triangles
            .splice(0..1, [[a, b, centre], [b, c, centre], [c, a, centre]]);
        // The tetrahedron over half a face of a cube is a twelfth of it.
        let defect = convexity_defect(&dented).unwrap();
        assert!((defect - 1.0 / 12.0).abs() < 1e-15, "{defect}");
    }

    #[test]
    fn nothing_has_no_extent() {
        let nothing = Mesh::default();
        assert_eq!(bounds(&nothing), None);
        assert_eq!(
            (diagonal(&nothing), area(&nothing), volume(&nothing)),
            (0.0, 0.0, 0.0)
        );
        assert!(convexity_defect(&nothing).is_err());
    }
}

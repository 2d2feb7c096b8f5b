//! Directions along which a shape may lie.

use glam::{DMat3, DVec3};

use crate::mesh::Mesh;
use crate::properties::mass_properties;

/// How many face directions are worth trying.
const FACE_DIRECTIONS: usize = 32;
/// Normals that differ less are one direction.
const SAME_DIRECTION: f64 = 1e-4;

/// Unit directions: the mesh's axes, the principal axes of inertia, and the
/// normals with the largest area.
pub(super) fn candidates(hull: &Mesh) -> Vec<DVec3> {
    let mut directions = DVec3::AXES.to_vec();
    let principal = eigenvectors(mass_properties(hull).inertia);
    directions.extend(principal.into_iter().filter(|d| d.is_finite()));
    directions.extend(face_directions(hull));
    directions
}

/// Face normals (up to sign), those with the largest area first.
fn face_directions(hull: &Mesh) -> Vec<DVec3> {
    let mut normals: Vec<([i64; 3], DVec3)> = hull
        .faces()
        .map(|[a, b, c]| (b - a).cross(c - a))
        .filter_map(|area| {
            let unit = area.try_normalize()?;
            // One of the two opposite directions, the same for both.
            let sign = if unit.to_array() < [0.0; 3] {
                -1.0
            } else {
                1.0
            };
            let key = (unit * sign / SAME_DIRECTION)
                .round()
                .to_array()
                .map(|x| x as i64);
            Some((key, area * sign))
        })
        .collect();
    normals.sort_by_key(|(key, _)| *key);
    let mut sums: Vec<DVec3> = normals
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| same.iter().map(|(_, area)| *area).sum())
        .collect();
    sums.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    sums.truncate(FACE_DIRECTIONS);
    sums.iter().filter_map(|sum| sum.try_normalize()).collect()
}

/// Unit eigenvectors of a symmetric matrix by Jacobi's rotations (Golub and
/// Van Loan, *Matrix Computations*, §8.5).
fn eigenvectors(matrix: DMat3) -> [DVec3; 3] {
    let mut a = matrix;
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..32 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (app, aqq, apq) = (a.col(p)[p], a.col(q)[q], a.col(q)[p]);
            if apq == 0.0 {
                continue;
            }
            let tau = (aqq - app) / (2.0 * apq);
            let t = 1.0_f64.copysign(tau) / (tau.abs() + (1.0 + tau * tau).sqrt());
            let cosine = 1.0 / (1.0 + t * t).sqrt();
            let sine = t * cosine;
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = cosine;
            rotation.col_mut(q)[q] = cosine;
            rotation.col_mut(q)[p] = sine;
            rotation.col_mut(p)[q] = -sine;
            a = rotation.transpose() * a * rotation;
            vectors *= rotation;
        }
    }
    [vectors.x_axis, vectors.y_axis, vectors.z_axis].map(DVec3::normalize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_kept_by_their_matrix() {
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.1, 0.5, -0.3, 0.8).normalize());
        let matrix = turn * DMat3::from_diagonal(DVec3::new(1.0, 2.0, 5.0)) * turn.transpose();
        for v in eigenvectors(matrix) {
            let image = matrix * v;
            assert!((image - v * image.dot(v)).length() < 1e-14, "{v}");
        }
    }
}

//! The axis of a surface of revolution, from its normals.
//!
//! All normals of a surface of revolution meet its axis. A line with direction a and moment b
//! meets the normal n at p if a · (p × n) + b · n = 0, which is linear in (a, b): the axis is the
//! eigenvector of the smallest eigenvalue of a 6 × 6 matrix (a linear line complex; Pottmann and
//! Wallner, *Computational Line Geometry*, 2001, §7.1). Faces that do not belong to it are
//! weighed down over a few rounds.

use assetpipe_geometry::Mesh;
use glam::DVec3;

use super::eigen;

const ROUNDS: usize = 6;
/// Normals within this share of the size of the axis meet it.
const MEETS: f64 = 0.01;
/// So much of the area must meet the axis.
const SHARE: f64 = 0.7;
/// Eigenvalues closer than this to the smallest one leave the axis open: a sphere has many, and
/// so have the flat sides of a box.
const UNIQUE: f64 = 20.0;

/// The direction of the axis that most of the surface goes round; `None` if it goes round none
/// or round many.
pub fn axis(mesh: &Mesh) -> Option<DVec3> {
    let (lo, hi) = mesh
        .vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        });
    let centre = 0.5 * (lo + hi);
    let size = 0.5 * (hi - lo).length();
    if size <= 0.0 {
        return None;
    }
    let faces: Vec<([f64; 6], f64)> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| (p - centre) / size);
            let normal = (b - a).cross(c - a);
            let n = normal.normalize_or_zero();
            let moment = ((a + b + c) / 3.0).cross(n);
            let line = [moment.x, moment.y, moment.z, n.x, n.y, n.z];
            (line, normal.length())
        })
        .collect();
    let total: f64 = faces.iter().map(|f| f.1).sum();
    let mut weights: Vec<f64> = faces.iter().map(|f| f.1).collect();
    let mut found = None;
    for _ in 0..ROUNDS {
        let mut matrix = [[0.0; 6]; 6];
        for ((line, _), weight) in faces.iter().zip(&weights) {
            for i in 0..6 {
                for j in 0..6 {
                    matrix[i][j] += weight * line[i] * line[j];
                }
            }
        }
        let values = eigen::symmetric(matrix);
        let v = values[0].1;
        let direction = DVec3::new(v[0], v[1], v[2]);
        let length = direction.length();
        // No direction at all: a translation, not a rotation.
        if length < 0.1 {
            return None;
        }
        let miss = |line: &[f64; 6]| (0..6).map(|i| line[i] * v[i]).sum::<f64>().abs() / length;
        let meets: f64 = faces
            .iter()
            .filter(|f| miss(&f.0) < MEETS)
            .map(|f| f.1)
            .sum();
        let unique = values[1].0 > UNIQUE * values[0].0.max(1e-9 * total);
        found = (unique && meets > SHARE * total).then(|| direction / length);
        for ((line, area), weight) in faces.iter().zip(&mut weights) {
            let off = miss(line) / MEETS;
            *weight = area / (1.0 + off * off);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;
    use glam::DQuat;

    fn turned(profile: impl Fn(f64) -> f64) -> (Mesh, DVec3) {
        let turn = DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize();
        let mut points = Vec::new();
        for i in 0..=12 {
            let z = f64::from(i) / 6.0 - 1.0;
            for k in 0..40 {
                let angle = f64::from(k) * std::f64::consts::TAU / 40.0;
                let r = profile(z);
                points.push(turn * DVec3::new(r * libm::cos(angle), r * libm::sin(angle), z));
            }
        }
        (convex_hull(&points).unwrap(), turn * DVec3::Z)
    }

    #[test]
    fn an_egg_has_an_axis_and_a_ball_has_none() {
        let (egg, axis_of_egg) = turned(|z| 0.5 * (1.0 - 0.9 * z * z).sqrt() * (1.0 + 0.2 * z));
        let found = axis(&egg).unwrap();
        assert!(found.dot(axis_of_egg).abs() > 0.9999);
        let (ball, _) = turned(|z| (1.0 - z * z).max(0.0).sqrt());
        assert_eq!(axis(&ball), None);
    }
}

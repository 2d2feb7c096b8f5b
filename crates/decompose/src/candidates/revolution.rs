//! The axis of a surface of revolution, from its normals.
//!
//! All normals of a surface of revolution meet its axis. A line with direction a and moment b
//! meets the normal n at p if a · (p × n) + b · n = 0, which is linear in (a, b): the axis is the
//! eigenvector of the smallest eigenvalue of a 6 × 6 matrix (a linear line complex; Pottmann and
//! Wallner, *Computational Line Geometry*, 2001, §7.1). Faces that do not belong to it are
//! weighed down over a few rounds.

use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use super::eigen;

const ROUNDS: usize = 6;
/// Normals within this share of the size of the axis meet it; of large facets half a side, up to
/// the second.
const MEETS: (f64, f64) = (0.01, 0.03);
/// So much of the area must meet the axis.
const SHARE: f64 = 0.7;
/// Eigenvalues closer than this to the smallest one leave the axis open: a sphere has many, and
/// so have the flat sides of a box.
const UNIQUE: f64 = 20.0;
/// Of the area that meets the axis so much may meet the next best one too: a ball that lost a piece
/// has an axis through the piece, and many others.
const OTHER: f64 = 0.5;

/// An axis that most of a surface goes round.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its unit direction.
    pub direction: DVec3,
    /// For each triangle whether its normal meets the axis.
    pub meets: Vec<bool>,
}

/// The axis that most of the surface goes round; `None` if it goes round none or round many.
pub fn axis(mesh: &Mesh) -> Option<Axis> {
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
    // A line complex, an area and how far off the axis may be.
    let faces: Vec<([f64; 6], f64, f64)> = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| (p - centre) / size);
            let normal = (b - a).cross(c - a);
            let n = normal.normalize_or_zero();
            let moment = ((a + b + c) / 3.0).cross(n);
            let line = [moment.x, moment.y, moment.z, n.x, n.y, n.z];
            let longest = [b - a, c - b, a - c].map(DVec3::length);
            let half_side = 0.5 * longest.into_iter().fold(0.0, f64::max);
            (line, normal.length(), half_side.clamp(MEETS.0, MEETS.1))
        })
        .collect();
    let total: f64 = faces.iter().map(|f| f.1).sum();
    let mut weights: Vec<f64> = faces.iter().map(|f| f.1).collect();
    for round in 1..=ROUNDS {
        let mut matrix = [[0.0; 6]; 6];
        matrix.par_iter_mut().enumerate().for_each(|(i, row)| {
            for ((line, _, _), weight) in faces.iter().zip(&weights) {
                for (x, along) in row.iter_mut().zip(line) {
                    *x += weight * line[i] * along;
                }
            }
        });
        let values = eigen::symmetric(matrix);
        let v = values[0].1;
        let length = direction(&v).length();
        // No direction at all: a translation, not a rotation.
        if length < 0.1 {
            return None;
        }
        if round < ROUNDS {
            let weigh = |((line, area, room), weight): (&([f64; 6], f64, f64), &mut f64)| {
                let off = miss(line, &v) / room;
                *weight = area / (1.0 + off * off);
            };
            faces.par_iter().zip(&mut weights).for_each(weigh);
            continue;
        }
        let meets = |f: &([f64; 6], f64, f64), v: &[f64; 6]| miss(&f.0, v) < f.2;
        let share = |v: &[f64; 6]| -> f64 {
            let met = faces.iter().filter(|f| meets(f, v));
            met.map(|f| f.1).sum::<f64>() / total
        };
        let held = share(&v);
        let unique = values[1].0 > UNIQUE * values[0].0.max(1e-9 * total)
            && share(&values[1].1) < OTHER * held;
        return (unique && held > SHARE).then(|| Axis {
            direction: direction(&v) / length,
            meets: faces.iter().map(|f| meets(f, &v)).collect(),
        });
    }
    None
}

fn direction(v: &[f64; 6]) -> DVec3 {
    DVec3::new(v[0], v[1], v[2])
}

/// How far a line passes from an axis, as far as small angles go; infinite without a direction.
fn miss(line: &[f64; 6], v: &[f64; 6]) -> f64 {
    let product: f64 = line.iter().zip(v).map(|(a, b)| a * b).sum();
    product.abs() / direction(v).length()
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
        assert!(found.direction.dot(axis_of_egg).abs() > 0.9999);
        assert!(found.meets.iter().all(|&m| m));
        let (ball, _) = turned(|z| (1.0 - z * z).max(0.0).sqrt());
        assert_eq!(axis(&ball), None);
    }

    #[test]
    fn a_ball_that_lost_a_piece_has_none() {
        let (mut ball, _) = turned(|z| (1.0 - z * z).max(0.0).sqrt());
        let rest: Vec<[u32; 3]> = (0..ball.triangles.len())
            .filter(|&t| ball.corners(t).iter().any(|p| p.min_element() < 0.0))
            .map(|t| ball.triangles[t])
            .collect();
        assert!(rest.len() < ball.triangles.len());
        // Three quarters of disks, where the piece was.
        let first = ball.vertices.len() as u32;
        ball.vertices.push(DVec3::ZERO);
        for axis in 0..3 {
            for k in 0..=8 {
                let angle = f64::from(k) * std::f64::consts::TAU / 32.0;
                let (u, v) = (DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]);
                ball.vertices
                    .push(u * libm::cos(angle) + v * libm::sin(angle));
            }
        }
        ball.triangles = rest;
        for quarter in 0..3 {
            for k in 0..8 {
                let at = first + 1 + 9 * quarter + k;
                ball.triangles.push([first, at, at + 1]);
            }
        }
        assert_eq!(axis(&ball), None);
    }
}

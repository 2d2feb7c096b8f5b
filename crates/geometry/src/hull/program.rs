//! Linear programs in three variables.

use glam::{DVec2, DVec3};

use crate::sample::Random;

/// `normal · x >= offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
}

/// The point of |x|∞ ≤ `reach` that minimises `objective · x` under the
/// constraints, up to rounding; nothing if there is none. The constraints are
/// put in another order.
///
/// Seidel, *Small-dimensional linear programming and convex hulls made easy*,
/// 1991: expected O(n). The order is random with a fixed seed.
pub(super) fn minimise(
    objective: DVec3,
    constraints: &mut [Constraint],
    reach: f64,
) -> Option<DVec3> {
    Random::new(constraints.len() as u64).shuffle(constraints);
    let mut x = -reach * objective.signum();
    let mut flat: Vec<(DVec2, f64)> = Vec::with_capacity(constraints.len());
    for (i, last) in constraints.iter().enumerate() {
        let gap = last.offset - last.normal.dot(x);
        if gap <= 0.0 {
            continue;
        }
        // The optimum lies on the violated plane: o + s u + t v.
        let length = last.normal.length();
        if length == 0.0 {
            return None;
        }
        let n = last.normal / length;
        let o = n * (last.offset / length);
        let (u, v) = n.any_orthonormal_pair();
        let onto = |w: DVec3| DVec2::new(w.dot(u), w.dot(v));
        flat.clear();
        flat.extend(
            constraints[..i]
                .iter()
                .map(|c| (onto(c.normal), c.offset - c.normal.dot(o))),
        );
        let on = minimise_flat(onto(objective), &flat, 4.0 * reach)?;
        x = o + u * on.x + v * on.y;
    }
    Some(x)
}

fn minimise_flat(objective: DVec2, constraints: &[(DVec2, f64)], reach: f64) -> Option<DVec2> {
    let mut x = -reach * objective.signum();
    for (i, &(normal, offset)) in constraints.iter().enumerate() {
        if normal.dot(x) >= offset {
            continue;
        }
        let length = normal.length();
        if length == 0.0 {
            return None;
        }
        let n = normal / length;
        let o = n * (offset / length);
        let u = n.perp();
        let (mut low, mut high) = (-4.0 * reach, 4.0 * reach);
        for &(other, bound) in &constraints[..i] {
            let (slope, rest) = (other.dot(u), bound - other.dot(o));
            // Nearly parallel lines decide nothing that rounding could keep.
            if slope > f64::EPSILON {
                low = low.max(rest / slope);
            } else if slope < -f64::EPSILON {
                high = high.min(rest / slope);
            } else if rest > 1e-9 * reach {
                return None;
            }
        }
        if low > high {
            return None;
        }
        let s = if objective.dot(u) > 0.0 { low } else { high };
        x = o + u * s;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_of_a_cube_and_the_empty_set() {
        let at_least = |normal: DVec3, offset: f64| Constraint { normal, offset };
        let mut cube: Vec<Constraint> = DVec3::AXES
            .iter()
            .flat_map(|&axis| [at_least(axis, -1.0), at_least(-axis, -1.0)])
            .collect();
        let objective = DVec3::new(1.0, -2.0, 3.0);
        let x = minimise(objective, &mut cube, 100.0).unwrap();
        assert_eq!(x, DVec3::new(-1.0, 1.0, -1.0));
        cube.push(at_least(DVec3::X, 2.0));
        assert_eq!(minimise(objective, &mut cube, 100.0), None);
    }

    #[test]
    fn optima_agree_with_trying_all_triples() {
        let mut random = Random::new(41);
        for _ in 0..300 {
            // Half-spaces that leave a neighbourhood of a point free.
            let inside = random.in_cube();
            let mut constraints: Vec<Constraint> = (0..12)
                .map(|_| {
                    let normal = random.on_sphere();
                    Constraint {
                        normal,
                        offset: normal.dot(inside) - random.unit(),
                    }
                })
                .collect();
            let objective = random.on_sphere();
            let x = minimise(objective, &mut constraints, 1e3).unwrap();
            let slack = |p: DVec3| {
                constraints
                    .iter()
                    .map(|c| c.normal.dot(p) - c.offset)
                    .fold(f64::INFINITY, f64::min)
            };
            assert!(slack(x) > -1e-9);
            for i in 0..12 {
                for j in 0..i {
                    for k in 0..j {
                        let [a, b, c] = [i, j, k].map(|i| constraints[i]);
                        let matrix =
                            glam::DMat3::from_cols(a.normal, b.normal, c.normal).transpose();
                        let p = matrix.inverse() * DVec3::new(a.offset, b.offset, c.offset);
                        if p.is_finite() && p.abs().max_element() < 1e3 && slack(p) > -1e-9 {
                            assert!(objective.dot(x) < objective.dot(p) + 1e-6);
                        }
                    }
                }
            }
        }
    }
}

//! One orientation for a solid and its mirror images.
//!
//! Ties between cuts are broken by order, and order follows coordinates. So the working copy's
//! axes are sorted by extent and turned so that the solid has more of its volume at their low ends,
//! where ties go to. A solid that is the same both ways may have triangles that are not, so what its
//! moments do not tell apart those of its vertices do, or the way its edges wind; beyond that an axis
//! stays as it came.

use assetpipe_geometry::Mesh;
use glam::{DMat3, DVec3, Vec3Swizzles};

/// Moments, as shares of the volume times powers of half the size, below this are none: far above
/// rounding, far below what a tool leaves.
const NONE: f64 = 1e-6;

/// The signed permutation that brings a centred mesh of size about one into its orientation.
pub fn orientation(mesh: &Mesh) -> DMat3 {
    let (solid, vertices) = (Moments::of(mesh), Moments::of_vertices(mesh));
    let order = order(mesh, &solid, &vertices);
    let signs = signs(&solid, &vertices, helicity(mesh), order);
    let [x, y, z] = order.map(|axis| DVec3::AXES[axis] * signs[axis]);
    DMat3::from_cols(x, y, z).transpose()
}

/// The axes by extent, longest first; of equals the one along which more of the solid is far out,
/// then the one that is less the same both ways. What is alike in all that keeps its order.
fn order(mesh: &Mesh, solid: &Moments, vertices: &Moments) -> [usize; 3] {
    let reach = mesh
        .vertices
        .iter()
        .fold(DVec3::ZERO, |most, p| most.max(p.abs()));
    let measures = [
        reach,
        solid.second,
        solid.first.abs(),
        solid.third.abs(),
        vertices.second,
        vertices.first.abs(),
        vertices.third.abs(),
    ];
    let before = |a: usize, b: usize| {
        let telling = measures.iter().find(|m| (m[a] - m[b]).abs() > NONE);
        telling.is_some_and(|m| m[a] > m[b])
    };
    let mut order = [0, 1, 2];
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if before(order[j], order[i]) {
            order.swap(i, j);
        }
    }
    order
}

/// Moments of a solid about the origin, as shares of its volume, or of its vertices, as shares of
/// their number.
struct Moments {
    first: DVec3,
    second: DVec3,
    third: DVec3,
    /// Of yz, zx and xy.
    mixed: DVec3,
}

impl Moments {
    /// Exact for polyhedra: the integral of the k-th power of a linear form over a tetrahedron
    /// is its volume times 3! k! / (k + 3)! times the complete homogeneous polynomial of the
    /// form's values at the corners.
    fn of(mesh: &Mesh) -> Moments {
        let mut volume = 0.0;
        let mut moments = Moments {
            first: DVec3::ZERO,
            second: DVec3::ZERO,
            third: DVec3::ZERO,
            mixed: DVec3::ZERO,
        };
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let own = a.dot(b.cross(c));
            volume += own;
            moments.first += own / 4.0 * (a + b + c);
            let (e1, e2, e3) = (a + b + c, a * b + b * c + c * a, a * b * c);
            moments.second += own / 10.0 * (e1 * e1 - e2);
            moments.third += own / 20.0 * (e1 * e1 * e1 - 2.0 * e1 * e2 + e3);
            // Likewise for a product of two forms.
            let products: DVec3 = [a, b, c].iter().map(|p| p.yzx() * p.zxy()).sum();
            let crossed = e1.yzx() * e1.zxy() + products;
            moments.mixed += own / 20.0 * crossed;
        }
        let share = if volume == 0.0 { 0.0 } else { 1.0 / volume };
        Moments {
            first: moments.first * share,
            second: moments.second * share,
            third: moments.third * share,
            mixed: moments.mixed * share,
        }
    }

    fn of_vertices(mesh: &Mesh) -> Moments {
        let mean = |power: &dyn Fn(DVec3) -> DVec3| {
            let sum: DVec3 = mesh.vertices.iter().map(|&p| power(p)).sum();
            sum / mesh.vertices.len().max(1) as f64
        };
        Moments {
            first: mean(&|p| p),
            second: mean(&|p| p * p),
            third: mean(&|p| p * p * p),
            mixed: mean(&|p| p.yzx() * p.zxy()),
        }
    }

    /// The sense that makes an axis' first or third moment negative.
    fn sign(&self, axis: usize) -> Option<f64> {
        let telling = [self.first[axis], self.third[axis]];
        let found = telling.into_iter().find(|m| m.abs() > NONE);
        found.map(|m| -m.signum())
    }
}

/// How the edges wind about each axis, in the mean; negative in a mirror.
fn helicity(mesh: &Mesh) -> DVec3 {
    let edges = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let winding = |edge: [u32; 2]| {
        let [p, q] = edge.map(|v| mesh.vertices[v as usize]);
        p.cross(q) * (q - p)
    };
    edges.map(winding).sum::<DVec3>() / (3 * mesh.triangles.len().max(1)) as f64
}

/// The sense of the single axis that is still open with which edges wind to the right.
fn right(order: [usize; 3], signs: [f64; 3], winding: DVec3) -> Option<f64> {
    if signs.iter().filter(|sign| **sign == 0.0).count() > 1 {
        return None;
    }
    let telling = order.map(|axis| winding[axis]);
    let found = telling.into_iter().find(|h| h.abs() > NONE)?;
    let even = (order[0] + 1) % 3 == order[1];
    let settled: f64 = signs.into_iter().filter(|sign| *sign != 0.0).product();
    Some((if even { found } else { -found }).signum() * settled)
}

/// The sense of each axis: first or third moment of the solid negative; of those that are alike both
/// ways, so that the mixed moments with axes already settled, and then with one another, are positive;
/// of those that are still open, first or third moment of the vertices negative; and of a single one
/// that is left, so that edges wind to the right.
fn signs(solid: &Moments, vertices: &Moments, winding: DVec3, order: [usize; 3]) -> DVec3 {
    let mut signs = [0, 1, 2].map(|axis| solid.sign(axis).unwrap_or(0.0));
    let mixed = |a: usize, b: usize| {
        let both = [solid, vertices].map(|m| m.mixed[3 - a - b]);
        let telling = both.into_iter().find(|m| m.abs() > NONE);
        telling.map_or(0.0, f64::signum)
    };
    // Of an axis that is still open, the first other one that settles it; if there is none and its
    // vertices do not tell, it stays as it came and may settle others.
    for first in order {
        for axis in order {
            let others = order.into_iter().filter(|&other| other != axis);
            let mut found = others.map(|other| mixed(axis, other) * signs[other]);
            if signs[axis] == 0.0 {
                signs[axis] = found.find(|sign| *sign != 0.0).unwrap_or(0.0);
            }
        }
        if signs[first] == 0.0 {
            let told = vertices
                .sign(first)
                .or_else(|| right(order, signs, winding));
            signs[first] = told.unwrap_or(1.0);
        }
    }
    DVec3::from_array(signs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;
    use assetpipe_geometry::sample::Random;

    fn turned(mesh: &Mesh, turn: DMat3) -> Mesh {
        let flipped = turn.determinant() < 0.0;
        let order = |[a, b, c]: [u32; 3]| if flipped { [a, c, b] } else { [a, b, c] };
        Mesh {
            vertices: mesh.vertices.iter().map(|&p| turn * p).collect(),
            triangles: mesh.triangles.iter().map(|&t| order(t)).collect(),
        }
    }

    fn signed_permutations() -> Vec<DMat3> {
        let mut all = Vec::new();
        for order in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ] {
            for bits in 0..8u32 {
                let sign = |k: u32| if bits >> k & 1 == 0 { 1.0 } else { -1.0 };
                let [x, y, z] = order.map(|axis| DVec3::AXES[axis]);
                all.push(DMat3::from_cols(x * sign(0), y * sign(1), z * sign(2)));
            }
        }
        all
    }

    fn sorted(mesh: &Mesh) -> Vec<[f64; 3]> {
        let mut points: Vec<[f64; 3]> = mesh
            .vertices
            .iter()
            .map(|p| (*p + DVec3::ZERO).to_array())
            .collect();
        points.sort_by(|a, b| a.partial_cmp(b).unwrap());
        points
    }

    /// Both hulls in one orientation.
    fn alike(mesh: &Mesh) {
        let first = turned(mesh, orientation(mesh));
        for turn in signed_permutations() {
            let other = turned(mesh, turn);
            assert_eq!(sorted(&turned(&other, orientation(&other))), sorted(&first));
        }
    }

    #[test]
    fn all_mirror_images_have_one_orientation() {
        let mut random = Random::new(8);
        for _ in 0..20 {
            let points: Vec<DVec3> = (0..12)
                .map(|_| random.in_cube() * DVec3::new(0.4, 1.0, 0.7))
                .collect();
            alike(&convex_hull(&points).unwrap());
        }
    }

    #[test]
    fn what_is_the_same_about_a_point_has_too() {
        let mut random = Random::new(9);
        for _ in 0..20 {
            let points: Vec<DVec3> = (0..8)
                .map(|_| random.in_cube() * DVec3::new(0.4, 1.0, 0.7))
                .flat_map(|p| [p, -p])
                .collect();
            alike(&convex_hull(&points).unwrap());
        }
    }

    /// A brick with more vertices on some of its faces than on those across.
    #[test]
    fn what_only_its_triangles_tell_apart_has_too() {
        let mut random = Random::new(10);
        for _ in 0..20 {
            let size = DVec3::new(0.4, 1.0, 0.7);
            let corners: Vec<DVec3> = (0..8u32)
                .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
                .map(|p| (2.0 * p - 1.0) * size)
                .collect();
            let mut brick = convex_hull(&corners).unwrap();
            // A new vertex in the middle of an edge, and in both triangles at it.
            for _ in 0..3 {
                let t = random.below(brick.triangles.len() as u32) as usize;
                let [a, b, _] = brick.triangles[t];
                let middle = brick.vertices.len() as u32;
                let (p, q) = (brick.vertices[a as usize], brick.vertices[b as usize]);
                brick.vertices.push(p.lerp(q, 0.3));
                let halves = |t: [u32; 3]| -> Vec<[u32; 3]> {
                    let at = |i: usize| (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                    let edge = (0..3)
                        .map(at)
                        .find(|e| (e.0, e.1) == (a, b) || (e.1, e.0) == (a, b));
                    edge.map_or(vec![t], |(u, v, w)| vec![[u, middle, w], [middle, v, w]])
                };
                brick.triangles = brick.triangles.iter().flat_map(|&t| halves(t)).collect();
            }
            alike(&brick);
        }
    }

    /// A brick that is the same in every mirror but for the diagonals of two faces.
    #[test]
    fn what_only_its_edges_tell_apart_has_too() {
        let corners: Vec<DVec3> = (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .map(|p| (2.0 * p - 1.0) * DVec3::new(0.4, 1.0, 0.7))
            .collect();
        let mut brick = Mesh {
            vertices: corners,
            triangles: Vec::new(),
        };
        // Corners of the lower and upper side across x, counter-clockwise from outside.
        for [a, b, c, d] in [[0, 4, 6, 2], [3, 7, 5, 1]] {
            brick.triangles.extend([[a, b, c], [a, c, d]]);
        }
        // The other sides are fans about their middles.
        let sides: [[u32; 4]; 4] = [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for side in sides {
            let middle = brick.vertices.len() as u32;
            let sum: DVec3 = side.iter().map(|&v| brick.vertices[v as usize]).sum();
            brick.vertices.push(sum / 4.0);
            let ends = (0..4).map(|i| [side[i], side[(i + 1) % 4], middle]);
            brick.triangles.extend(ends);
        }
        assert!(crate::edges::check_closed(&brick).is_ok());
        let triangles = |mesh: &Mesh| {
            let mut all: Vec<[[f64; 3]; 3]> = (0..mesh.triangles.len())
                .map(|t| {
                    let mut corners = mesh.corners(t).map(|p| (p + DVec3::ZERO).to_array());
                    corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
                    corners
                })
                .collect();
            all.sort_by(|a, b| a.partial_cmp(b).unwrap());
            all
        };
        let first = triangles(&turned(&brick, orientation(&brick)));
        for turn in signed_permutations() {
            let other = turned(&brick, turn);
            assert_eq!(triangles(&turned(&other, orientation(&other))), first);
        }
    }

    #[test]
    fn a_moment_is_what_it_is() {
        let corners: Vec<DVec3> = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].to_vec();
        let found = Moments::of(&convex_hull(&corners).unwrap());
        // Integrals of x, x², x³ and xy over the simplex, times 6: 1/4, 2/5!, 3!/6! and 1/5! times 6.
        assert!((found.first - DVec3::splat(0.25)).length() < 1e-15);
        assert!((found.second - DVec3::splat(0.1)).length() < 1e-15);
        assert!((found.third - DVec3::splat(0.05)).length() < 1e-15);
        assert!((found.mixed - DVec3::splat(0.05)).length() < 1e-15);
    }
}

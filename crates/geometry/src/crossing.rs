//! Pairs of triangles that cross one another.

use glam::DVec3;

use crate::bvh::{Bounds, Bvh};
use crate::Mesh;

/// Six times the volume below which four points lie in a plane, for coordinates of one at most.
const FLAT: f64 = 1e-13;

/// Pairs of triangles that properly cross, the smaller index first, in order; `None` if the boxes
/// of more than `most` pairs overlap.
///
/// An edge of one must pass through the inside of the other: triangles that touch, share an edge
/// or overlap within one plane do not count. Those that share a vertex count if the edge opposite
/// to it does. `second` is where the triangles of a second surface begin: then only pairs of both
/// are looked for. Coordinates are of one at most.
pub fn crossing_pairs(surface: &Mesh, second: Option<usize>, most: usize) -> Option<Vec<[u32; 2]>> {
    let all = surface.triangles.len();
    let (held, asked) = second.map_or((all, 0), |at| (at.min(all), at));
    let tree = Bvh::new(&Mesh {
        vertices: surface.vertices.clone(),
        triangles: surface.triangles[..held].to_vec(),
    });
    let mut looked = 0;
    let mut found = Vec::new();
    for other in asked..all {
        let bounds = Bounds::around(surface.corners(other));
        tree.for_each(
            |node| bounds.overlaps(node),
            |slot| {
                let one = tree.original(slot);
                if (one as usize) < other {
                    looked += 1;
                    if cross(surface, one as usize, other) {
                        found.push([one, other as u32]);
                    }
                }
                looked <= most
            },
        );
        if looked > most {
            return None;
        }
    }
    found.sort_unstable();
    Some(found)
}

fn cross(surface: &Mesh, one: usize, other: usize) -> bool {
    let (a, b) = (surface.triangles[one], surface.triangles[other]);
    let of_a = a.map(|v| b.contains(&v));
    let of_b = b.map(|v| a.contains(&v));
    if of_a.iter().filter(|shared| **shared).count() > 1 {
        return false;
    }
    let (p, q) = (surface.corners(one), surface.corners(other));
    pierces(p, of_a, q) || pierces(q, of_b, p)
}

/// Whether an edge of a triangle, none of whose ends is shared, passes through the inside of
/// another one.
fn pierces(edges: [DVec3; 3], shared: [bool; 3], triangle: [DVec3; 3]) -> bool {
    let [p, q, r] = triangle;
    let side = edges.map(|corner| volume(corner, p, q, r));
    (0..3).any(|k| {
        let next = (k + 1) % 3;
        let (start, end) = (edges[k], edges[next]);
        !shared[k]
            && !shared[next]
            && ((side[k] > FLAT && side[next] < -FLAT) || (side[k] < -FLAT && side[next] > FLAT))
            && surrounds([(p, q), (q, r), (r, p)].map(|(x, y)| volume(start, end, x, y)))
    })
}

/// Whether a line passes all edges of a triangle on the same side.
fn surrounds(sides: [f64; 3]) -> bool {
    sides.iter().all(|side| *side > FLAT) || sides.iter().all(|side| *side < -FLAT)
}

/// Six times the signed volume of a tetrahedron.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    (b - a).cross(c - a).dot(d - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh {
            vertices: points.iter().map(|p| DVec3::from(*p)).collect(),
            triangles: triangles.to_vec(),
        }
    }

    const FLOOR: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn with(other: [[f64; 3]; 3]) -> Option<Vec<[u32; 2]>> {
        let points = [FLOOR, other].concat();
        crossing_pairs(&surface(&points, &[[0, 1, 2], [3, 4, 5]]), None, 9)
    }

    #[test]
    fn an_edge_through_the_inside_crosses() {
        let through = [[0.2, 0.2, -0.5], [0.2, 0.2, 0.5], [0.9, 0.9, 0.0]];
        assert_eq!(with(through), Some(vec![[0, 1]]));
    }

    #[test]
    fn to_touch_is_not_to_cross() {
        let on_it = [[0.2, 0.2, 0.0], [0.3, 0.2, 0.5], [0.2, 0.4, 0.5]];
        assert_eq!(with(on_it), Some(vec![]));
        let within_the_plane = [[0.1, 0.1, 0.0], [0.9, 0.1, 0.0], [0.1, 0.9, 0.0]];
        assert_eq!(with(within_the_plane), Some(vec![]));
        let over_an_edge = [[0.5, 0.0, -0.5], [0.5, 0.0, 0.5], [0.5, -0.5, 0.0]];
        assert_eq!(with(over_an_edge), Some(vec![]));
    }

    #[test]
    fn neighbours_cross_only_away_from_what_they_share() {
        let points = [
            FLOOR.as_slice(),
            &[[0.4, 0.1, -0.5], [0.1, 0.4, 0.5], [0.3, 0.3, 0.5]],
        ]
        .concat();
        let at_a_corner = surface(&points, &[[0, 1, 2], [0, 3, 5]]);
        assert_eq!(crossing_pairs(&at_a_corner, None, 9), Some(vec![[0, 1]]));
        let at_an_edge = surface(&points, &[[0, 1, 2], [0, 1, 4]]);
        assert_eq!(crossing_pairs(&at_an_edge, None, 9), Some(vec![]));
    }

    #[test]
    fn pairs_are_of_both_surfaces_where_there_are_two() {
        let points = [
            FLOOR.as_slice(),
            &[[0.2, 0.2, -0.5], [0.2, 0.2, 0.5], [0.9, 0.9, 0.0]],
        ]
        .concat();
        let twice = surface(&points, &[[0, 1, 2], [3, 4, 5], [0, 1, 2]]);
        assert_eq!(crossing_pairs(&twice, None, 9), Some(vec![[0, 1], [1, 2]]));
        assert_eq!(crossing_pairs(&twice, Some(2), 9), Some(vec![[1, 2]]));
        assert_eq!(crossing_pairs(&twice, Some(3), 9), Some(vec![]));
        assert_eq!(crossing_pairs(&twice, None, 1), None);
    }
}

//! Whether a mesh is convex, exactly.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use crate::clip::label_components;
use crate::mesh::{check_manifold, edges, Mesh, MeshDefect};
use crate::predicates::{orient2d, orient3d};

/// Why a mesh is not the surface of a convex solid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConvexityDefect {
    /// It is no closed 2-manifold.
    #[error(transparent)]
    Mesh(#[from] MeshDefect),
    /// The surface bends inward at an edge.
    #[error("triangles {first} and {second} bend inward at edge {from}–{to}")]
    Reflex {
        /// Lesser end of the edge.
        from: u32,
        /// Greater end of the edge.
        to: u32,
        /// The triangles that meet there.
        first: usize,
        /// The other one.
        second: usize,
    },
    /// A vertex lies strictly outside of a face.
    #[error("vertex {vertex} is outside of triangle {triangle}")]
    Outside {
        /// The vertex.
        vertex: u32,
        /// The triangle.
        triangle: usize,
    },
    /// The surface winds around its inside this often, not once.
    #[error("the surface winds {times} times around its inside")]
    Winding {
        /// How often.
        times: i64,
    },
    /// There is more than one surface.
    #[error("{count} separate surfaces")]
    Components {
        /// How many.
        count: usize,
    },
}

/// Checks, with exact predicates, that `mesh` is the outward boundary of a
/// convex solid. Flat edges are allowed, also vertices inside faces.
///
/// A connected closed surface that bends inward nowhere, is seen from its
/// centre everywhere from inside and winds around it once is convex
/// (Mehlhorn et al., *Checking geometric programs or verification of
/// geometric structures*, 1996, §2). Where the solid is so thin that rounding
/// puts the centre outside, every vertex is compared with every face.
///
/// # Errors
/// The first [`ConvexityDefect`]; reflex edges in the order of their ends.
pub fn check_convex(mesh: &Mesh) -> Result<(), ConvexityDefect> {
    check_manifold(mesh)?;
    let (count, _) = label_components(mesh);
    if count != 1 {
        return Err(ConvexityDefect::Components { count });
    }
    for sides in edges(mesh).chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
        let [first, second] = [sides[0].triangle(), sides[1].triangle()];
        let [a, b, c] = mesh.corners(first);
        let bends_inward = mesh
            .corners(second)
            .iter()
            .any(|&p| orient3d(a, b, c, p).is_gt());
        if bends_inward {
            return Err(ConvexityDefect::Reflex {
                from: sides[0].low,
                to: sides[0].high,
                first,
                second,
            });
        }
    }
    let centre = mesh.vertices.iter().sum::<DVec3>() / mesh.vertices.len() as f64;
    let is_inside = |[a, b, c]: [DVec3; 3]| orient3d(a, b, c, centre).is_lt();
    if mesh.faces().all(is_inside) {
        match winding_number(mesh, centre) {
            1 => Ok(()),
            times => Err(ConvexityDefect::Winding { times }),
        }
    } else {
        check_all(mesh)
    }
}

/// Compares every vertex with every face.
fn check_all(mesh: &Mesh) -> Result<(), ConvexityDefect> {
    for (triangle, [a, b, c]) in mesh.faces().enumerate() {
        let is_outside = |p: &DVec3| orient3d(a, b, c, *p).is_gt();
        if let Some(vertex) = mesh.vertices.iter().position(is_outside) {
            return Err(ConvexityDefect::Outside {
                vertex: vertex as u32,
                triangle,
            });
        }
    }
    Ok(())
}

/// How often a closed surface winds around a point that is not on it:
/// crossings of the ray towards +x, each edge and vertex counted for one of
/// the triangles that share it. Exact, O(n).
fn winding_number(mesh: &Mesh, point: DVec3) -> i64 {
    let flat = |p: DVec3| DVec2::new(p.y, p.z);
    let q = flat(point);
    let mut times = 0;
    for [a, b, c] in mesh.faces() {
        let [u, v, w] = [a, b, c].map(flat);
        // Crossings of the ray downward from `q` in the projection, by the
        // half-open rule in y, decide whether `q` is in the triangle.
        let crossings = [(u, v), (v, w), (w, u)].map(|(s, t)| {
            let upward = s.x <= q.x && q.x < t.x;
            let downward = t.x <= q.x && q.x < s.x;
            match orient2d(s, t, q) {
                Ordering::Greater if upward => 1,
                Ordering::Less if downward => -1,
                _ => 0,
            }
        });
        let covered: i64 = crossings.iter().sum();
        // In front of the point, the surface is crossed outward if the point
        // is on its inner side.
        if covered != 0 {
            match orient3d(a, b, c, point) {
                Ordering::Less if covered > 0 => times += 1,
                Ordering::Greater if covered < 0 => times -= 1,
                _ => {}
            }
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;
    use crate::sample::Random;

    fn star(points: u32, step: u32) -> Mesh {
        // A double cone over a star polygon.
        let mut vertices: Vec<DVec3> = (0..points)
            .map(|i| std::f64::consts::TAU * f64::from(i * step % points) / f64::from(points))
            .map(|a| DVec3::new(libm::cos(a), libm::sin(a), 0.0))
            .collect();
        vertices.extend([DVec3::Z, -DVec3::Z]);
        let triangles = (0..points)
            .flat_map(|i| {
                let j = (i + 1) % points;
                [[i, j, points], [j, i, points + 1]]
            })
            .collect();
        Mesh {
            vertices,
            triangles,
        }
    }

    #[test]
    fn hulls_are_convex() {
        let mut random = Random::new(21);
        for n in [4, 10, 300] {
            let points: Vec<DVec3> = (0..n).map(|_| random.in_cube()).collect();
            assert_eq!(check_convex(&convex_hull(&points).unwrap()), Ok(()));
        }
        assert_eq!(check_convex(&star(7, 1)), Ok(()));
    }

    #[test]
    fn the_thinnest_hull_is_convex_though_no_point_is_inside() {
        let points = [
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(4.0, 0.0, 1.0),
            DVec3::new(0.0, 4.0, 1.0),
            DVec3::new(1.0, 1.0, 1f64.next_up()),
        ];
        assert_eq!(check_convex(&convex_hull(&points).unwrap()), Ok(()));
    }

    #[test]
    fn a_dent_is_located() {
        let mut hull = star(8, 1);
        hull.vertices[3] *= 0.5;
        let Err(ConvexityDefect::Reflex { from, to, .. }) = check_convex(&hull) else {
            panic!("the dent was not found");
        };
        assert!(hull.vertices[from as usize].z != 0.0 || hull.vertices[to as usize].z != 0.0);
    }

    #[test]
    fn a_surface_that_bends_outward_everywhere_but_winds_twice_is_not_convex() {
        assert_eq!(
            check_convex(&star(5, 2)),
            Err(ConvexityDefect::Winding { times: 2 })
        );
    }

    #[test]
    fn inside_out_and_two_bodies_are_not_convex() {
        let mut turned = star(6, 1);
        for t in &mut turned.triangles {
            t.swap(1, 2);
        }
        assert!(matches!(
            check_convex(&turned),
            Err(ConvexityDefect::Reflex { .. })
        ));
        let mut two = star(6, 1);
        let far = two
            .vertices
            .iter()
            .map(|v| *v + 10.0)
            .collect::<Vec<DVec3>>();
        let shift = two.vertices.len() as u32;
        two.vertices.extend(far);
        let moved: Vec<[u32; 3]> = two.triangles.iter().map(|t| t.map(|v| v + shift)).collect();
        two.triangles.extend(moved);
        assert_eq!(
            check_convex(&two),
            Err(ConvexityDefect::Components { count: 2 })
        );
    }
}

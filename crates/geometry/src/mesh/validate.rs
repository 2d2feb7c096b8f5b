//! What makes a mesh a solid, checked; every failure is located.

use super::Mesh;

/// Why a mesh is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshDefect {
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count}")]
    NoSuchVertex {
        /// The triangle.
        triangle: usize,
        /// The index it names.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A vertex has a coordinate that is NaN or infinite.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle names a vertex twice.
    #[error("triangle {triangle} names vertex {vertex} twice")]
    Collapsed {
        /// The triangle.
        triangle: usize,
        /// The repeated vertex.
        vertex: u32,
    },
    /// An edge is not passed as often in one direction as in the other.
    #[error("edge {from}–{to} is passed {forward} times forward and {backward} times backward")]
    OpenEdge {
        /// Lesser end.
        from: u32,
        /// Greater end.
        to: u32,
        /// Triangles that run from `from` to `to`.
        forward: usize,
        /// Triangles that run from `to` to `from`.
        backward: usize,
    },
    /// More than two triangles meet at an edge.
    #[error("{count} triangles meet at edge {from}–{to}")]
    CrowdedEdge {
        /// Lesser end.
        from: u32,
        /// Greater end.
        to: u32,
        /// How many triangles.
        count: usize,
    },
    /// The triangles around a vertex form more than one fan.
    #[error("the triangles around vertex {vertex} form more than one fan")]
    PinchedVertex {
        /// The vertex.
        vertex: u32,
    },
    /// A vertex is used by no triangle.
    #[error("vertex {vertex} is used by no triangle")]
    UnusedVertex {
        /// The vertex.
        vertex: u32,
    },
}

/// Checks that indices exist, used vertices are finite and no triangle names
/// a vertex twice. O(n).
///
/// # Errors
/// The first [`MeshDefect`] in the order of triangles.
pub fn check_indices(mesh: &Mesh) -> Result<(), MeshDefect> {
    let count = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for &vertex in corners {
            match mesh.vertices.get(vertex as usize) {
                None => {
                    return Err(MeshDefect::NoSuchVertex {
                        triangle,
                        vertex,
                        count,
                    })
                }
                Some(p) if !p.is_finite() => {
                    return Err(MeshDefect::NotFinite {
                        vertex: vertex as usize,
                    })
                }
                Some(_) => {}
            }
        }
        let [a, b, c] = *corners;
        if a == b || a == c {
            return Err(MeshDefect::Collapsed {
                triangle,
                vertex: a,
            });
        }
        if b == c {
            return Err(MeshDefect::Collapsed {
                triangle,
                vertex: b,
            });
        }
    }
    Ok(())
}

/// Checks that the surface is closed and consistently oriented: every edge
/// is passed as often in one direction as in the other. Edges at which more
/// than two triangles meet are allowed. O(n log n).
///
/// # Errors
/// As [`check_indices`], then the open edge that is first by its ends.
pub fn check_closed(mesh: &Mesh) -> Result<(), MeshDefect> {
    check_indices(mesh)?;
    edges(mesh)
        .chunk_by(|a, b| (a.low, a.high) == (b.low, b.high))
        .try_for_each(check_balance)
}

/// Checks that the mesh is a closed 2-manifold: closed, two triangles at each
/// edge, one fan around each vertex, no unused vertex. O(n log n).
///
/// # Errors
/// As [`check_closed`], then what is not manifold, edges before vertices.
pub fn check_manifold(mesh: &Mesh) -> Result<(), MeshDefect> {
    check_closed(mesh)?;
    let edges = edges(mesh);
    // Joins the triangles' corners over edges: a fan is a class.
    let mut fans: Vec<u32> = (0..3 * mesh.triangles.len() as u32).collect();
    for around in edges.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
        let [a, b] = around else {
            return Err(MeshDefect::CrowdedEdge {
                from: around[0].low,
                to: around[0].high,
                count: around.len(),
            });
        };
        for (p, q) in [(a.at_low, b.at_low), (a.at_high, b.at_high)] {
            let (p, q) = (root(&mut fans, p), root(&mut fans, q));
            fans[p.max(q) as usize] = p.min(q);
        }
    }
    let mut fan_of_vertex = vec![u32::MAX; mesh.vertices.len()];
    for (corner, &vertex) in mesh.triangles.iter().flatten().enumerate() {
        let fan = root(&mut fans, corner as u32);
        let known = &mut fan_of_vertex[vertex as usize];
        if *known == u32::MAX {
            *known = fan;
        } else if *known != fan {
            return Err(MeshDefect::PinchedVertex { vertex });
        }
    }
    match fan_of_vertex.iter().position(|fan| *fan == u32::MAX) {
        Some(vertex) => Err(MeshDefect::UnusedVertex {
            vertex: vertex as u32,
        }),
        None => Ok(()),
    }
}

/// One side of a triangle, named by its ends in ascending order.
pub(crate) struct HalfEdge {
    pub(crate) low: u32,
    pub(crate) high: u32,
    /// Whether the triangle runs from `low` to `high`.
    pub(crate) forward: bool,
    /// The triangle's corners (three per triangle, counted through) at the ends.
    at_low: u32,
    at_high: u32,
}

impl HalfEdge {
    /// The triangle whose side this is.
    pub(crate) fn triangle(&self) -> usize {
        self.at_low as usize / 3
    }
}

/// All sides of all triangles, those of an edge next to each other.
pub(crate) fn edges(mesh: &Mesh) -> Vec<HalfEdge> {
    let mut edges = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (at_a, at_b) = ((3 * t + i) as u32, (3 * t + j) as u32);
            let (a, b) = (corners[i], corners[j]);
            edges.push(if a < b {
                HalfEdge {
                    low: a,
                    high: b,
                    forward: true,
                    at_low: at_a,
                    at_high: at_b,
                }
            } else {
                HalfEdge {
                    low: b,
                    high: a,
                    forward: false,
                    at_low: at_b,
                    at_high: at_a,
                }
            });
        }
    }
    edges.sort_unstable_by_key(|e| (e.low, e.high, e.at_low));
    edges
}

fn check_balance(around: &[HalfEdge]) -> Result<(), MeshDefect> {
    let forward = around.iter().filter(|e| e.forward).count();
    let backward = around.len() - forward;
    if forward == backward {
        return Ok(());
    }
    Err(MeshDefect::OpenEdge {
        from: around[0].low,
        to: around[0].high,
        forward,
        backward,
    })
}

fn root(parent: &mut [u32], mut item: u32) -> u32 {
    while parent[item as usize] != item {
        parent[item as usize] = parent[parent[item as usize] as usize];
        item = parent[item as usize];
    }
    item
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn tetrahedron() -> Mesh {
        Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        }
    }

    #[test]
    fn a_tetrahedron_is_a_manifold() {
        assert_eq!(check_manifold(&tetrahedron()), Ok(()));
    }

    #[test]
    fn every_defect_is_located() {
        let mut open = tetrahedron();
        open.triangles.pop();
        let defect = check_closed(&open);
        assert!(matches!(
            defect,
            Err(MeshDefect::OpenEdge { from: 0, to: 2, .. })
        ));

        let mut turned = tetrahedron();
        turned.triangles[1].swap(0, 1);
        assert!(matches!(
            check_closed(&turned),
            Err(MeshDefect::OpenEdge { .. })
        ));

        let mut wild = tetrahedron();
        wild.triangles[2][1] = 7;
        assert_eq!(
            check_indices(&wild),
            Err(MeshDefect::NoSuchVertex {
                triangle: 2,
                vertex: 7,
                count: 4
            })
        );

        let mut poisoned = tetrahedron();
        poisoned.vertices[3].y = f64::NAN;
        assert_eq!(
            check_indices(&poisoned),
            Err(MeshDefect::NotFinite { vertex: 3 })
        );

        let mut collapsed = tetrahedron();
        collapsed.triangles[0] = [0, 2, 2];
        assert_eq!(
            check_indices(&collapsed),
            Err(MeshDefect::Collapsed {
                triangle: 0,
                vertex: 2
            })
        );

        let mut unused = tetrahedron();
        unused.vertices.push(DVec3::ONE);
        assert_eq!(
            check_manifold(&unused),
            Err(MeshDefect::UnusedVertex { vertex: 4 })
        );
    }

    #[test]
    fn bodies_that_share_a_vertex_or_an_edge_are_closed_but_not_manifold() {
        let mut vertex = tetrahedron();
        let other = tetrahedron();
        vertex
            .vertices
            .extend(other.vertices[1..].iter().map(|v| -*v));
        let mirrored = |t: &[u32; 3]| [t[0], t[2], t[1]].map(|v| if v == 0 { 0 } else { v + 3 });
        vertex
            .triangles
            .extend(other.triangles.iter().map(mirrored));
        assert_eq!(check_closed(&vertex), Ok(()));
        assert_eq!(
            check_manifold(&vertex),
            Err(MeshDefect::PinchedVertex { vertex: 0 })
        );

        let mut edge = tetrahedron();
        edge.vertices.extend([-DVec3::Y, -DVec3::Z]);
        let renamed = |t: &[u32; 3]| {
            t.map(|v| match v {
                0 | 1 => v,
                _ => v + 2,
            })
        };
        edge.triangles.extend(other.triangles.iter().map(renamed));
        assert_eq!(check_closed(&edge), Ok(()));
        assert_eq!(
            check_manifold(&edge),
            Err(MeshDefect::CrowdedEdge {
                from: 0,
                to: 1,
                count: 4
            })
        );
    }
}

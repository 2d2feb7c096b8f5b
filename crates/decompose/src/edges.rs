//! The edges of a surface: what they say about it.

use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::error::DecomposeError;
use crate::folds::is_fold;
use crate::merge::bounds;
use crate::part::Union;

/// A half-edge: (smaller, larger vertex, triangle, runs from smaller to larger).
pub type HalfEdge = (u32, u32, u32, bool);

/// All half-edges in order: counted into the rows of their smaller vertices, which
/// are short.
pub fn half_edges(mesh: &Mesh) -> Vec<HalfEdge> {
    let all = || {
        mesh.triangles.iter().enumerate().flat_map(|(t, c)| {
            (0..3).map(move |i| {
                let (a, b) = (c[i], c[(i + 1) % 3]);
                (a.min(b), a.max(b), t as u32, a < b)
            })
        })
    };
    let mut next = vec![0usize; mesh.vertices.len() + 1];
    for edge in all() {
        next[edge.0 as usize + 1] += 1;
    }
    for v in 1..next.len() {
        next[v] += next[v - 1];
    }
    let mut edges = vec![(0, 0, 0, false); 3 * mesh.triangles.len()];
    for edge in all() {
        let at = &mut next[edge.0 as usize];
        edges[*at] = edge;
        *at += 1;
    }
    for row in edges.chunk_by_mut(|a, b| a.0 == b.0) {
        row.sort_unstable();
    }
    edges
}

/// The half-edges of each edge, of all in order.
pub fn by_edge(edges: &[HalfEdge]) -> impl Iterator<Item = &[HalfEdge]> {
    edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
}

/// Whether an edge is used as often in one sense as in the other.
fn is_balanced(edge: &[HalfEdge]) -> bool {
    2 * edge.iter().filter(|e| e.3).count() == edge.len()
}

/// Check that every edge is used as often in one sense as in the other: the
/// surface is a closed chain. Edges of more than two triangles are fine.
///
/// # Errors
/// [`DecomposeError::NotClosed`] names the first edge that is not.
pub fn check_closed(mesh: &Mesh) -> Result<(), DecomposeError> {
    let edges = half_edges(mesh);
    let open: Vec<&[HalfEdge]> = by_edge(&edges).filter(|e| !is_balanced(e)).collect();
    match open.first() {
        None => Ok(()),
        Some(run) => Err(DecomposeError::NotClosed {
            from: run[0].0,
            to: run[0].1,
            count: open.len(),
        }),
    }
}

/// What edges say about a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connections {
    /// Whether every edge is used as often in one sense as in the other.
    pub closed: bool,
    /// How many edges there are.
    pub edges: usize,
    /// The component of each triangle, over shared edges; they count up in the order of their
    /// first triangles.
    pub component: Vec<u32>,
    /// How many edges are folds without thickness.
    pub folds: usize,
}

/// How the triangles of a mesh are connected.
pub fn connections(mesh: &Mesh) -> Connections {
    let mut sets = Union::new(mesh.triangles.len());
    let (low, high) = bounds(mesh);
    let unit = (high - low).length();
    let (mut closed, mut edges, mut folds) = (true, 0, 0);
    for edge in by_edge(&half_edges(mesh)) {
        edges += 1;
        closed &= is_balanced(edge);
        folds += usize::from(is_fold(mesh, edge, unit));
        for pair in edge.windows(2) {
            sets.join(pair[0].2, pair[1].2);
        }
    }
    let mut count = 0;
    let mut component = vec![0; mesh.triangles.len()];
    for t in 0..component.len() {
        // The first triangle of a set is its root.
        let root = sets.root(t as u32) as usize;
        component[t] = if root == t {
            count += 1;
            count - 1
        } else {
            component[root]
        };
    }
    Connections {
        closed,
        edges,
        component,
        folds,
    }
}

/// The corner of a half-edge's triangle that is not on it.
pub fn opposite(mesh: &Mesh, edge: &HalfEdge) -> Option<DVec3> {
    mesh.triangles[edge.2 as usize]
        .iter()
        .find(|&&v| v != edge.0 && v != edge.1)
        .map(|&v| mesh.vertices[v as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;

    #[test]
    fn an_open_edge_is_named() {
        let mut hull = cuboid(DVec3::ZERO, DVec3::ONE);
        hull.triangles.pop();
        assert!(matches!(
            check_closed(&hull),
            Err(DecomposeError::NotClosed { count: 3, .. })
        ));
    }
}

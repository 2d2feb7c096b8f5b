//! Triangle meshes as plain values.

mod validate;

use glam::DVec3;

pub(crate) use validate::edges;
pub use validate::{check_closed, check_indices, check_manifold, MeshDefect};

/// A triangle mesh: vertices in one frame and one unit, triangles wound
/// counter-clockwise seen from outside. Closed 2-manifold where a function
/// says it needs a *solid*.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions.
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The corners of triangle `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    /// The corners of all triangles, in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = [DVec3; 3]> + '_ {
        self.triangles
            .iter()
            .map(|t| t.map(|v| self.vertices[v as usize]))
    }
}

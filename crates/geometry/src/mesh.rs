//! Triangle meshes as plain values.

use glam::DVec3;

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
}

//! Pieces that hang together.

use crate::mesh::Mesh;

/// The connected components of a surface (connected through common
/// vertices), in the order of their first triangles. Vertices and triangles
/// keep their relative order; vertices that no triangle uses are dropped.
///
/// A cavity is a component of its own, wound inside out.
pub fn components(mesh: &Mesh) -> Vec<Mesh> {
    let (count, labels) = label_components(mesh);
    if count == 1 && labels.iter().all(|label| *label == 0) {
        return vec![mesh.clone()];
    }
    let mut parts = vec![Mesh::default(); count];
    let mut index = vec![0; mesh.vertices.len()];
    for (vertex, &label) in labels.iter().enumerate() {
        if let Some(part) = parts.get_mut(label as usize) {
            index[vertex] = part.vertices.len() as u32;
            part.vertices.push(mesh.vertices[vertex]);
        }
    }
    for t in &mesh.triangles {
        let label = labels[t[0] as usize];
        parts[label as usize]
            .triangles
            .push(t.map(|v| index[v as usize]));
    }
    parts
}

/// The number of connected components, and for each vertex its component, in
/// the order of their first triangles (`u32::MAX` for a vertex of no triangle).
pub fn label_components(mesh: &Mesh) -> (usize, Vec<u32>) {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[0], t[2])] {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut label_of_root = vec![u32::MAX; parent.len()];
    let mut labels = vec![u32::MAX; parent.len()];
    let mut count = 0;
    for &vertex in mesh.triangles.iter().flatten() {
        let root = root(&mut parent, vertex) as usize;
        if label_of_root[root] == u32::MAX {
            label_of_root[root] = count;
            count += 1;
        }
        labels[vertex as usize] = label_of_root[root];
    }
    (count as usize, labels)
}

fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        parent[vertex as usize] = parent[parent[vertex as usize] as usize];
        vertex = parent[vertex as usize];
    }
    vertex
}

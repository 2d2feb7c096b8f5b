//! Solids to cut.

use glam::{DQuat, DVec3};

use crate::clip::separate;
use crate::mesh::Mesh;

/// The union of unit cubes at the given integer corners, as a 2-manifold.
pub fn voxels(cells: &[[i32; 3]]) -> Mesh {
    let mut sorted = cells.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let mut corners: Vec<[i32; 3]> = Vec::new();
    let mut quads: Vec<[[i32; 3]; 4]> = Vec::new();
    for &cell in &sorted {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [0, 1] {
                let mut beyond = cell;
                beyond[axis] += 2 * side - 1;
                if sorted.binary_search(&beyond).is_ok() {
                    continue;
                }
                let corner = |du: i32, dv: i32| {
                    let mut c = cell;
                    c[axis] += side;
                    c[u] += du;
                    c[v] += dv;
                    c
                };
                let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if side == 0 {
                    quad.reverse();
                }
                corners.extend(quad);
                quads.push(quad);
            }
        }
    }
    corners.sort_unstable();
    corners.dedup();
    let index = |c: &[i32; 3]| corners.binary_search(c).unwrap() as u32;
    let triangles = quads.iter().flat_map(|q| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| index(&q[i]));
        [[a, b, c], [a, c, d]]
    });
    separate(Mesh {
        triangles: triangles.collect(),
        vertices: corners
            .iter()
            .map(|c| DVec3::from(c.map(f64::from)))
            .collect(),
    })
}

/// All cells of a box for which `keep` holds.
pub fn cells(size: [i32; 3], keep: impl Fn(i32, i32, i32) -> bool) -> Vec<[i32; 3]> {
    let mut cells = Vec::new();
    for x in 0..size[0] {
        for y in 0..size[1] {
            for z in 0..size[2] {
                if keep(x, y, z) {
                    cells.push([x, y, z]);
                }
            }
        }
    }
    cells
}

/// A torus around the z axis.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> Mesh {
    let turn = |i: u32, n: u32| {
        let angle = std::f64::consts::TAU * f64::from(i % n) / f64::from(n);
        (libm::cos(angle), libm::sin(angle))
    };
    let mut mesh = Mesh::default();
    for i in 0..around {
        let (cu, su) = turn(i, around);
        for j in 0..across {
            let (cv, sv) = turn(j, across);
            let r = major + minor * cv;
            mesh.vertices.push(DVec3::new(r * cu, r * su, minor * sv));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

pub fn moved(mesh: &Mesh, f: impl Fn(DVec3) -> DVec3) -> Mesh {
    Mesh {
        vertices: mesh.vertices.iter().map(|&v| f(v)).collect(),
        triangles: mesh.triangles.clone(),
    }
}

pub fn skew() -> DQuat {
    DQuat::from_xyzw(0.11, 0.32, -0.23, 0.91).normalize()
}

/// Both surfaces as one mesh.
pub fn joined(a: &Mesh, b: &Mesh) -> Mesh {
    let shift = a.vertices.len() as u32;
    let mut mesh = a.clone();
    mesh.vertices.extend(&b.vertices);
    mesh.triangles
        .extend(b.triangles.iter().map(|t| t.map(|v| v + shift)));
    mesh
}

pub fn inside_out(mesh: &Mesh) -> Mesh {
    Mesh {
        vertices: mesh.vertices.clone(),
        triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
    }
}

//! Solids whose answers are known, for tests.

use assetpipe_geometry::{DVec3, Mesh};
use glam::{DMat3, DQuat};

/// A box between two corners.
pub fn cuboid(lo: DVec3, hi: DVec3) -> Mesh {
    prism(
        &[vec![(lo.x, lo.y), (hi.x, lo.y), (hi.x, hi.y), (lo.x, hi.y)]],
        lo.z,
        hi.z,
    )
}

/// Convex polygons (counter-clockwise) side by side, extruded; edges that two of
/// them share in opposite directions get no wall.
pub fn prism(polygons: &[Vec<(f64, f64)>], z0: f64, z1: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let mut index = |x: f64, y: f64, z: f64| {
        let p = DVec3::new(x, y, z);
        let found = mesh.vertices.iter().position(|v| *v == p);
        found.unwrap_or_else(|| {
            mesh.vertices.push(p);
            mesh.vertices.len() - 1
        }) as u32
    };
    let edges: Vec<_> = polygons
        .iter()
        .flat_map(|p| (0..p.len()).map(|k| (p[k], p[(k + 1) % p.len()])))
        .collect();
    let mut triangles = Vec::new();
    for polygon in polygons {
        let low: Vec<u32> = polygon.iter().map(|p| index(p.0, p.1, z0)).collect();
        let high: Vec<u32> = polygon.iter().map(|p| index(p.0, p.1, z1)).collect();
        for k in 1..polygon.len() - 1 {
            triangles.push([low[0], low[k + 1], low[k]]);
            triangles.push([high[0], high[k], high[k + 1]]);
        }
    }
    for &(s, t) in &edges {
        if !edges.contains(&(t, s)) {
            let [a, b] = [index(s.0, s.1, z0), index(t.0, t.1, z0)];
            let [c, d] = [index(t.0, t.1, z1), index(s.0, s.1, z1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.triangles = triangles;
    mesh
}

/// An L: two by two, less the upper right quarter, one high. Thickening 1/2.
pub fn ell() -> Mesh {
    let square = |x: f64, y: f64| vec![(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)];
    prism(
        &[square(0.0, 0.0), square(1.0, 0.0), square(0.0, 1.0)],
        0.0,
        1.0,
    )
}

/// A plate four by four, one high, with a square hole `2 a` wide. Thickening a.
pub fn plate_with_hole(a: f64) -> Mesh {
    let ring = [-2.0, -a, a, 2.0];
    let mut polygons = Vec::new();
    for i in 0..3 {
        for j in 0..3 {
            if (i, j) != (1, 1) {
                let (x0, x1, y0, y1) = (ring[i], ring[i + 1], ring[j], ring[j + 1]);
                polygons.push(vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1)]);
            }
        }
    }
    prism(&polygons, 0.0, 1.0)
}

/// A sphere of radius one about the origin as an octahedron split `n` times.
pub fn ball(n: usize) -> Mesh {
    let mut faces = Vec::new();
    for k in 0..8 {
        let sign = |bit: i32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let [x, y, z] = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        faces.push(if x.cross(y).dot(z) > 0.0 {
            [x, y, z]
        } else {
            [x, z, y]
        });
    }
    for _ in 0..n {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let m = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, m[0], m[2]], [m[0], b, m[1]], [m[2], m[1], c], m]
            })
            .collect();
    }
    weld(&faces)
}

/// A torus about the z axis: radii 1 and `r`, `n` by `m` quads.
pub fn torus(r: f64, n: usize, m: usize) -> Mesh {
    let at = |i: usize, j: usize| {
        let turn = |k: usize, of: usize| std::f64::consts::TAU * (k % of) as f64 / of as f64;
        let (u, v) = (turn(i, n), turn(j, m));
        let ring = 1.0 + r * libm::cos(v);
        DVec3::new(ring * libm::cos(u), ring * libm::sin(u), r * libm::sin(v))
    };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.push([quad[0], quad[1], quad[2]]);
            faces.push([quad[0], quad[2], quad[3]]);
        }
    }
    weld(&faces)
}

/// Surfaces put together as they are: shells may overlap or be cavities.
pub fn together(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let shift = all.vertices.len() as u32;
        all.vertices.extend(&mesh.vertices);
        all.triangles
            .extend(mesh.triangles.iter().map(|t| t.map(|v| v + shift)));
    }
    all
}

/// As [`together`], of two.
pub fn both(a: &Mesh, b: &Mesh) -> Mesh {
    together(&[a.clone(), b.clone()])
}

/// Inside out.
pub fn reversed(mesh: &Mesh) -> Mesh {
    Mesh {
        vertices: mesh.vertices.clone(),
        triangles: mesh.triangles.iter().map(|t| [t[0], t[2], t[1]]).collect(),
    }
}

/// Every vertex scaled, then moved.
pub fn placed(mesh: &Mesh, scale: f64, offset: DVec3) -> Mesh {
    Mesh {
        vertices: mesh.vertices.iter().map(|v| *v * scale + offset).collect(),
        triangles: mesh.triangles.clone(),
    }
}

/// Turned out of every axis.
pub fn turned(mesh: &Mesh) -> Mesh {
    // A fixed unit quaternion with unequal parts.
    let turn = DMat3::from_quat(DQuat::from_xyzw(0.1, 0.5, -0.3, 0.8).normalize());
    Mesh {
        vertices: mesh.vertices.iter().map(|v| turn * *v).collect(),
        triangles: mesh.triangles.clone(),
    }
}

fn weld(faces: &[[DVec3; 3]]) -> Mesh {
    let mut mesh = Mesh::default();
    for face in faces {
        let triangle = face.map(|p| {
            let found = mesh.vertices.iter().position(|v| v.distance(p) < 1e-9);
            found.unwrap_or_else(|| {
                mesh.vertices.push(p);
                mesh.vertices.len() - 1
            }) as u32
        });
        mesh.triangles.push(triangle);
    }
    mesh
}

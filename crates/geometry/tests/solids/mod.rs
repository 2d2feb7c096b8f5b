//! Random solids for the random drivers: unions of voxels, and knotted tubes.

use std::ops::Range;

use assetpipe_geometry::clip::separate;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::{DVec3, Mesh};
use glam::DQuat;

/// The cases that `ASSETPIPE_CASES` asks for, `5000` or `5000..9000`; else `0..default`.
pub fn cases(default: u64) -> Range<u64> {
    let wanted = std::env::var("ASSETPIPE_CASES").unwrap_or_default();
    let (first, end) = wanted.split_once("..").unwrap_or(("0", &wanted));
    first.parse().unwrap_or(0)..end.parse().unwrap_or(default)
}

/// A random union of unit cubes in a grid: holes, cavities, touching corners and edges.
fn voxels(random: &mut Random) -> Mesh {
    let size = 1 + random.below(4) as i32;
    let filled = 1 + random.below(4);
    let keep: Vec<bool> = (0..size * size * size)
        .map(|_| random.below(4) < filled)
        .collect();
    let is_solid = |c: [i32; 3]| {
        c.iter().all(|x| (0..size).contains(x))
            && keep[((c[0] * size + c[1]) * size + c[2]) as usize]
    };
    let width = size + 1;
    let index = |c: [i32; 3]| ((c[0] * width + c[1]) * width + c[2]) as u32;
    let mut triangles = Vec::new();
    for x in 0..size {
        for y in 0..size {
            for z in 0..size {
                let cell = [x, y, z];
                if !is_solid(cell) {
                    continue;
                }
                for axis in 0..3 {
                    for side in 0..2 {
                        let mut beyond = cell;
                        beyond[axis] += 2 * side - 1;
                        if is_solid(beyond) {
                            continue;
                        }
                        let corner = |du: i32, dv: i32| {
                            let mut c = cell;
                            c[axis] += side;
                            c[(axis + 1) % 3] += du;
                            c[(axis + 2) % 3] += dv;
                            index(c)
                        };
                        let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        if side == 0 {
                            quad.reverse();
                        }
                        let [a, b, c, d] = quad;
                        // Either diagonal.
                        if random.below(2) == 0 {
                            triangles.extend([[a, b, c], [a, c, d]]);
                        } else {
                            triangles.extend([[a, b, d], [b, c, d]]);
                        }
                    }
                }
            }
        }
    }
    let used: std::collections::BTreeSet<u32> = triangles.iter().flatten().copied().collect();
    let used: Vec<u32> = used.into_iter().collect();
    let position = |i: &u32| {
        let i = *i as i32;
        DVec3::from([i / (width * width), i / width % width, i % width].map(f64::from))
    };
    let rename = |v: u32| used.binary_search(&v).unwrap() as u32;
    separate(Mesh {
        vertices: used.iter().map(position).collect(),
        triangles: triangles.into_iter().map(|t| t.map(rename)).collect(),
    })
}

/// A tube around a closed random walk on a torus: knots, self-intersections.
fn tube(random: &mut Random) -> Mesh {
    let (along, around) = (6 + random.below(20), 3 + random.below(6));
    let (p, q) = (1 + random.below(3), 1 + random.below(4));
    let thickness = 0.05 + 0.4 * random.unit();
    let tau = std::f64::consts::TAU;
    let spine = |i: u32| {
        let t = tau * f64::from(i % along) / f64::from(along);
        let (a, b) = (t * f64::from(p), t * f64::from(q));
        let r = 2.0 + 0.7 * libm::cos(b);
        DVec3::new(r * libm::cos(a), r * libm::sin(a), 0.7 * libm::sin(b))
    };
    let mut mesh = Mesh::default();
    for i in 0..along {
        let forward = spine(i + 1) - spine(i + along - 1);
        let up = (spine(i) * DVec3::new(1.0, 1.0, 0.0)).normalize();
        let u = (up - forward * (up.dot(forward) / forward.length_squared())).normalize();
        let v = forward.normalize().cross(u);
        for j in 0..around {
            let angle = tau * f64::from(j) / f64::from(around);
            let offset = (u * libm::cos(angle) + v * libm::sin(angle)) * thickness;
            mesh.vertices.push(spine(i) + offset);
            let at = |i: u32, j: u32| (i % along) * around + j % around;
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    mesh
}

/// A random closed solid, turned, stretched, moved or neither.
pub fn solid(random: &mut Random) -> Mesh {
    let mut mesh = if random.below(3) == 0 {
        tube(random)
    } else {
        voxels(random)
    };
    match random.below(5) {
        0 => {
            let axis = random.on_sphere();
            let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, random.unit()).normalize();
            for p in &mut mesh.vertices {
                *p = turn * *p;
            }
        }
        1 => {
            let stretch = [(); 3].map(|()| 2f64.powi(random.below(30) as i32 - 15));
            for p in &mut mesh.vertices {
                *p *= DVec3::from(stretch);
            }
        }
        2 => {
            let shift = random.in_cube() * 1e4;
            for p in &mut mesh.vertices {
                *p += shift;
            }
        }
        _ => {}
    }
    mesh
}

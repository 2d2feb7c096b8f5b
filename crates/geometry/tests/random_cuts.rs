//! Random cuts of random solids: pieces are closed 2-manifolds that add up.
//!
//! `ASSETPIPE_CASES` says which cases are drawn: `5000` or `5000..9000` (default
//! 1000). Case `k` is always the same, and a failure names it.
#![allow(clippy::panic, clippy::unwrap_used)]

use std::ops::Range;

use assetpipe_geometry::clip::{components, separate, split, volume_below};
use assetpipe_geometry::mesh::check_manifold;
use assetpipe_geometry::predicates::side;
use assetpipe_geometry::properties::{diagonal, volume};
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::tolerance::Rounding;
use assetpipe_geometry::{DVec3, Mesh, Plane};
use glam::DQuat;

fn cases() -> Range<u64> {
    let wanted = std::env::var("ASSETPIPE_CASES").unwrap_or_default();
    let (first, end) = wanted.split_once("..").unwrap_or(("0", &wanted));
    first.parse().unwrap_or(0)..end.parse().unwrap_or(1000)
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

fn solid(random: &mut Random) -> Mesh {
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

/// Through vertices, edges, faces, nearly through them, or anywhere.
fn plane(random: &mut Random, mesh: &Mesh) -> Plane {
    let mut vertex = || mesh.vertices[random.below(mesh.vertices.len() as u32) as usize];
    let [a, b, c] = [(); 3].map(|()| vertex());
    let axis = random.below(3) as usize;
    match random.below(6) {
        0 => Plane::axis_aligned(axis, a[axis]),
        1 => Plane::axis_aligned(axis, a[axis] * 0.5 + b[axis] * 0.5),
        2 => Plane::axis_aligned(axis, a[axis] * (1.0 + f64::EPSILON)),
        3 | 4 => {
            let normal = (b - a).cross(c - a);
            Plane {
                normal,
                offset: normal.dot(a),
            }
        }
        _ => {
            let normal = random.on_sphere();
            Plane {
                normal,
                offset: normal.dot(a.lerp(b, random.unit())),
            }
        }
    }
}

#[test]
fn random_cuts_of_random_solids() {
    let mut cuts = 0;
    for number in cases() {
        let mut random = Random::new(number ^ 0xC07);
        let whole = solid(&mut random);
        if whole.triangles.is_empty() {
            continue;
        }
        check_manifold(&whole).unwrap_or_else(|e| panic!("case {number}: {e}"));
        let mut pieces = vec![whole];
        for _ in 0..=random.below(4) {
            let chosen = random.below(pieces.len() as u32) as usize;
            let piece = pieces.swap_remove(chosen);
            let plane = plane(&mut random, &piece);
            if plane.normal == DVec3::ZERO || !plane.normal.is_finite() {
                break;
            }
            let result = split(&piece, &plane).unwrap_or_else(|e| panic!("case {number}: {e}"));
            assert!(!result.is_fan, "case {number}: a fan");
            cuts += 1;
            check_pieces(
                number,
                &piece,
                &plane,
                [result.below.as_ref(), result.above.as_ref()],
            );
            let both = [result.below, result.above].into_iter().flatten();
            pieces.extend(both.flat_map(|piece| components(&piece)));
        }
    }
    assert!(cuts > cases().count() / 2, "{cuts}");
}

fn check_pieces(number: u64, whole: &Mesh, plane: &Plane, pieces: [Option<&Mesh>; 2]) {
    let plane = &plane.scaled();
    let rounding = Rounding::of(whole);
    let meshes = [Some(whole), pieces[0], pieces[1]];
    let allowed: f64 = meshes.iter().flatten().map(|m| rounding.volume(m)).sum();
    let volumes = pieces.map(|piece| piece.map_or(0.0, volume));
    let difference = (volumes[0] + volumes[1] - volume(whole)).abs();
    assert!(
        difference <= allowed,
        "case {number}: volumes differ by {difference:e} > {allowed:e}"
    );
    let below = volume_below(whole, plane);
    // Without a cap, the section's rounding counts with its length and lever.
    let allowed = allowed + 4.0 * rounding.crossing() * diagonal(whole).powi(2);
    let difference = (below - volumes[0]).abs();
    assert!(
        difference <= allowed,
        "case {number}: {below} below, not {}",
        volumes[0]
    );
    let slack = 8.0 * rounding.crossing() + 1e-15 * diagonal(whole);
    for (piece, sign) in pieces.iter().zip([1.0, -1.0]) {
        let Some(piece) = piece else { continue };
        check_manifold(piece).unwrap_or_else(|e| panic!("case {number}: {e}"));
        for &v in &piece.vertices {
            if plane.axis().is_some_and(|(_, normal)| normal.abs() == 1.0) {
                let outside = f64::from(side(plane, v) as i8) == sign;
                assert!(!outside, "case {number}: {v} is on the wrong side");
            } else {
                let height = plane.evaluate(v) * sign / plane.normal.length();
                assert!(height <= slack, "case {number}: {v} is {height:e} outside");
            }
        }
    }
}

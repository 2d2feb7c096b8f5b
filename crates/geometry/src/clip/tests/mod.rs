//! Pieces against what they must be: closed 2-manifolds on their side of the
//! plane that add up, with caps that face outward.

mod shapes;

use glam::DVec3;

use super::{components, split, ClipError};
use crate::hull::convex_hull;
use crate::mesh::Mesh;
use crate::plane::Plane;
use crate::predicates::side;
use crate::sample::Random;
use shapes::{cells, inside_out, joined, moved, skew, torus, voxels};

fn volume(mesh: &Mesh) -> f64 {
    let Some(&apex) = mesh.vertices.first() else {
        return 0.0;
    };
    let six_fold: f64 = (0..mesh.triangles.len())
        .map(|t| mesh.corners(t).map(|p| p - apex))
        .map(|[a, b, c]| a.dot(b.cross(c)))
        .sum();
    six_fold / 6.0
}

/// Every edge has its reverse once; the triangles at a vertex form one fan.
fn assert_manifold(mesh: &Mesh) {
    let mut edges: Vec<(u32, u32)> = mesh
        .triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .collect();
    edges.sort_unstable();
    assert!(
        edges.windows(2).all(|w| w[0] != w[1]),
        "an edge occurs twice"
    );
    assert!(
        edges
            .iter()
            .all(|&(a, b)| a != b && edges.binary_search(&(b, a)).is_ok()),
        "open"
    );
    for v in 0..mesh.vertices.len() as u32 {
        // The edges opposite the vertex must form a single cycle.
        let link: Vec<(u32, u32)> = mesh
            .triangles
            .iter()
            .filter_map(|t| {
                let i = t.iter().position(|&w| w == v)?;
                Some((t[(i + 1) % 3], t[(i + 2) % 3]))
            })
            .collect();
        assert!(!link.is_empty(), "vertex {v} is not used");
        let (mut at, mut steps) = (link[0].1, 1);
        while at != link[0].0 {
            at = link.iter().find(|e| e.0 == at).unwrap().1;
            steps += 1;
        }
        assert_eq!(steps, link.len(), "vertex {v} has two fans");
    }
}

/// Volume of the part of unit cubes below the plane, cube by cube from convex hulls.
fn voxel_volume_below(cells: &[[i32; 3]], place: impl Fn(DVec3) -> DVec3, plane: &Plane) -> f64 {
    let mut total = 0.0;
    for cell in cells {
        let corner = |i: usize| {
            let bit = |b: usize| f64::from(cell[b]) + ((i >> b) & 1) as f64;
            place(DVec3::new(bit(0), bit(1), bit(2)))
        };
        let values: Vec<f64> = (0..8).map(|i| plane.evaluate(corner(i))).collect();
        let mut points: Vec<DVec3> = (0..8).filter(|&i| values[i] <= 0.0).map(corner).collect();
        for i in 0..8 {
            for b in 0..3 {
                let j = i ^ (1 << b);
                if values[i] < 0.0 && values[j] > 0.0 {
                    let t = values[i] / (values[i] - values[j]);
                    points.push(corner(i).lerp(corner(j), t));
                }
            }
        }
        total += convex_hull(&points).map_or(0.0, |hull| volume(&hull));
    }
    total
}

/// Cuts and checks everything that holds for any solid; returns the volume below.
fn cut(mesh: &Mesh, plane: &Plane) -> f64 {
    let result = split(mesh, plane).unwrap();
    assert!(!result.is_fan);
    let extent = mesh
        .vertices
        .iter()
        .map(|v| v.abs().max_element())
        .fold(0.0, f64::max);
    let slack = 1e-14 * plane.normal.length() * extent;
    let mut volumes = [0.0; 2];
    for (i, (piece, facing)) in [(&result.below, 1.0), (&result.above, -1.0)]
        .into_iter()
        .enumerate()
    {
        let Some(piece) = piece else { continue };
        assert_manifold(piece);
        volumes[i] = volume(piece);
        assert!(volumes[i] > 0.0, "{plane:?}");
        for &v in &piece.vertices {
            if plane.axis().is_some() {
                assert_ne!(
                    f64::from(side(plane, v) as i8),
                    facing,
                    "a vertex on the wrong side"
                );
            } else {
                assert!(plane.evaluate(v) * facing <= slack);
            }
        }
        for t in 0..piece.triangles.len() {
            let [a, b, c] = piece.corners(t);
            if [a, b, c].iter().all(|&p| plane.evaluate(p).abs() <= slack) {
                let normal = (b - a).cross(c - a);
                // Slivers between rounded crossing points may face anywhere.
                let area = normal.dot(plane.normal) * facing;
                assert!(area >= -slack * extent, "inverted: {area:e}");
            }
        }
    }
    let (whole, parts) = (volume(mesh), volumes[0] + volumes[1]);
    assert!(
        (whole - parts).abs() <= 1e-12 * whole,
        "{whole} is not {parts}"
    );
    // The plane turned around gives the same pieces, exchanged.
    let turned = split(mesh, &plane.flipped()).unwrap();
    for (a, b) in [
        (&turned.below, &result.above),
        (&turned.above, &result.below),
    ] {
        assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            assert!((volume(a) - volume(b)).abs() <= 1e-12 * whole);
        }
    }
    volumes[0]
}

/// Planes through vertices, edges and faces of integer grids, and between.
fn planes() -> Vec<Plane> {
    let mut planes = Vec::new();
    for axis in 0..3 {
        for offset in [-1.0, 0.0, 0.3, 1.0, 1.5, 2.0, 3.0, 3.999_999, 4.0, 5.0] {
            planes.push(Plane::axis_aligned(axis, offset));
            planes.push(Plane::axis_aligned(axis, offset).flipped());
        }
    }
    for normal in [
        [1, 1, 0],
        [1, -1, 0],
        [1, 1, 1],
        [2, -1, 1],
        [-1, 3, 2],
        [0, 1, -1],
    ] {
        for offset in [0.0, 1.0, 2.0, 2.5, 4.0, 6.0] {
            planes.push(Plane {
                normal: DVec3::from(normal.map(f64::from)),
                offset,
            });
        }
    }
    planes
}

fn cut_voxels(cells: &[[i32; 3]]) {
    let mesh = voxels(cells);
    assert_manifold(&mesh);
    for plane in planes() {
        let expected = voxel_volume_below(cells, |p| p, &plane);
        let below = cut(&mesh, &plane);
        assert!(
            (below - expected).abs() < 1e-9,
            "{plane:?}: {below}, expected {expected}"
        );
    }
    let rotation = skew();
    let place = |p: DVec3| rotation * p * 0.37 + DVec3::new(0.1, -5.0, 3.0);
    let turned = moved(&mesh, place);
    for plane in planes().iter().step_by(3) {
        // The same plane in the rotated frame: nearly through vertices, edges and faces.
        let normal = rotation * plane.normal;
        let on = place(plane.normal * plane.offset / plane.normal.length_squared());
        let plane = Plane {
            normal,
            offset: normal.dot(on),
        };
        let expected = voxel_volume_below(cells, place, &plane);
        let result = split(&turned, &plane).unwrap();
        let below = result.below.as_ref().map_or(0.0, volume);
        assert!((below - expected).abs() < 1e-9);
        result
            .below
            .iter()
            .chain(&result.above)
            .for_each(assert_manifold);
    }
}

#[test]
fn boxes_are_cut_through_vertices_edges_and_faces() {
    cut_voxels(&cells([1, 1, 1], |_, _, _| true));
    cut_voxels(&cells([3, 4, 2], |_, _, _| true));
}

#[test]
fn frames_combs_and_grids_of_high_genus() {
    cut_voxels(&cells([5, 5, 1], |x, y, _| x % 2 == 0 || y % 2 == 0));
    cut_voxels(&cells([5, 3, 4], |x, _, z| z == 0 || x % 2 == 0));
    cut_voxels(&cells([5, 5, 5], |x, y, z| (x % 2 + y % 2 + z % 2) < 2));
}

#[test]
fn nested_shells_and_cavities() {
    let shell = |low: i32, high: i32| {
        move |x: i32, y: i32, z: i32| {
            let inside = |a: i32, b: i32| [x, y, z].iter().all(|c| (a..b).contains(c));
            inside(low, high) && !inside(low + 1, high - 1)
        }
    };
    cut_voxels(&cells([7, 7, 7], |x, y, z| {
        shell(0, 7)(x, y, z) || shell(2, 5)(x, y, z)
    }));
    cut_voxels(&cells([3, 3, 3], |x, y, z| [x, y, z] != [1, 1, 1]));
}

#[test]
fn bodies_that_touch_in_vertices_and_edges() {
    cut_voxels(&[[0, 0, 0], [1, 1, 0], [2, 2, 1], [1, 0, 1]]);
    cut_voxels(&cells([4, 4, 4], |x, y, z| (x + y + z) % 2 == 0));
}

#[test]
fn random_voxels() {
    let mut random = Random::new(8);
    for _ in 0..12 {
        let all = cells([4, 4, 4], |_, _, _| true);
        let some: Vec<_> = all.into_iter().filter(|_| random.below(2) == 0).collect();
        cut_voxels(&some);
    }
}

#[test]
fn tori_at_every_angle() {
    let torus = torus(3.0, 1.0, 24, 12);
    let mut random = Random::new(9);
    for _ in 0..60 {
        let normal = random.on_sphere();
        cut(
            &torus,
            &Plane {
                normal,
                offset: 4.0 * random.unit() - 2.0,
            },
        );
    }
    for axis in 0..3 {
        for offset in [-4.0, -3.0, -2.0, -1.0, 0.0, 0.5, 1.0, 2.0, 4.0] {
            cut(&torus, &Plane::axis_aligned(axis, offset));
        }
    }
}

#[test]
fn a_cavity_flush_with_the_plane_becomes_a_pit() {
    let outer = voxels(&cells([5, 5, 5], |_, _, _| true));
    let cavity = moved(&voxels(&cells([2, 2, 2], |_, _, _| true)), |p| p + 1.0);
    let solid = joined(&outer, &inside_out(&cavity));
    assert_eq!(cut(&solid, &Plane::axis_aligned(2, 3.0)), 75.0 - 8.0);
    assert_eq!(cut(&solid, &Plane::axis_aligned(2, 1.0)), 25.0);
    assert_eq!(cut(&solid, &Plane::axis_aligned(2, 2.0)), 50.0 - 4.0);
}

#[test]
fn repeated_cuts_keep_the_volume() {
    let mut random = Random::new(10);
    let solid = torus(3.0, 1.0, 40, 20);
    let mut pieces = vec![solid.clone()];
    for _ in 0..7 {
        let normal = random.on_sphere();
        let plane = Plane {
            normal,
            offset: random.unit() - 0.5,
        };
        pieces = pieces
            .iter()
            .flat_map(|piece| {
                let halves = split(piece, &plane).unwrap();
                [halves.below, halves.above].into_iter().flatten()
            })
            .collect();
    }
    pieces.iter().for_each(assert_manifold);
    let total: f64 = pieces.iter().map(volume).sum();
    let expected = volume(&solid);
    assert!(
        (total - expected).abs() < 1e-12 * expected,
        "{total} is not {expected}"
    );
}

#[test]
fn plates_and_needles_far_from_the_origin() {
    let mut random = Random::new(11);
    for stretch in [
        DVec3::new(1.0, 1.0, 1e-6),
        DVec3::new(1e-6, 1.0, 1e-6),
        DVec3::splat(1e-6),
    ] {
        for shift in [0.0, 1e4 * stretch.max_element()] {
            let place = |p: DVec3| p * stretch + shift;
            let solid = moved(&torus(3.0, 1.0, 16, 8), place);
            for _ in 0..20 {
                let normal = random.on_sphere() / stretch;
                let on = place(2.0 * random.in_cube());
                let result = split(
                    &solid,
                    &Plane {
                        normal,
                        offset: normal.dot(on),
                    },
                )
                .unwrap();
                for piece in result.below.iter().chain(&result.above) {
                    assert_manifold(piece);
                }
            }
        }
    }
}

#[test]
fn a_self_intersecting_solid_is_cut_as_a_chain() {
    let one = voxels(&cells([3, 3, 3], |_, _, _| true));
    let other = moved(&one, |p| p + DVec3::new(1.5, 1.0, 0.5));
    let both = joined(&one, &other);
    for plane in planes() {
        let result = split(&both, &plane).unwrap();
        let parts = [&result.below, &result.above];
        parts.iter().copied().flatten().for_each(assert_manifold);
        let total: f64 = parts.into_iter().flatten().map(volume).sum();
        assert!((total - 54.0).abs() < 1e-10);
        let expected = volume_below_convex(&one, &plane) + volume_below_convex(&other, &plane);
        let below = result.below.as_ref().map_or(0.0, volume);
        assert!(
            (below - expected).abs() < 1e-10,
            "{plane:?}: {below} is not {expected}"
        );
    }
}

fn volume_below_convex(mesh: &Mesh, plane: &Plane) -> f64 {
    split(mesh, plane)
        .unwrap()
        .below
        .as_ref()
        .map_or(0.0, volume)
}

#[test]
fn what_cannot_be_cut_is_said() {
    let mut mesh = voxels(&[[0, 0, 0]]);
    let plane = Plane::axis_aligned(0, 0.5);
    let zero = Plane {
        normal: DVec3::ZERO,
        offset: 1.0,
    };
    assert!(matches!(
        split(&mesh, &zero),
        Err(ClipError::NotAPlane { .. })
    ));
    let endless = Plane {
        normal: DVec3::X,
        offset: f64::NAN,
    };
    assert!(matches!(
        split(&mesh, &endless),
        Err(ClipError::NotAPlane { .. })
    ));
    mesh.triangles.pop();
    let open = (0..3).any(|axis| {
        matches!(
            split(&mesh, &Plane::axis_aligned(axis, 0.5)),
            Err(ClipError::NotClosed { .. })
        )
    });
    assert!(open);
    mesh.triangles.push([0, 1, 99]);
    assert_eq!(
        split(&mesh, &plane),
        Err(ClipError::NoSuchVertex { triangle: 11 })
    );
    mesh.triangles.pop();
    mesh.vertices[2].z = f64::INFINITY;
    assert_eq!(
        split(&mesh, &plane),
        Err(ClipError::NotFinite { vertex: 2 })
    );
    let nothing = split(&Mesh::default(), &plane).unwrap();
    assert!(nothing.below.is_none() && nothing.above.is_none());
}

#[test]
fn components_come_apart_in_order() {
    let a = voxels(&[[0, 0, 0]]);
    let b = voxels(&[[5, 0, 0], [5, 1, 0]]);
    let parts = components(&joined(&a, &b));
    assert_eq!(parts, vec![a.clone(), b]);
    assert_eq!(components(&a), vec![a]);
    assert!(components(&Mesh::default()).is_empty());
    // Touching voxels are separate bodies.
    assert_eq!(
        components(&voxels(&[[0, 0, 0], [1, 1, 0], [2, 2, 1]])).len(),
        3
    );
}

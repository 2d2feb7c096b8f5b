//! Pieces as closed meshes: caps triangulated, caps between pieces dissolved.
//!
//! Only metrics that look at the part itself need this; the search and the
//! thickening towards the whole solid do without.

use std::collections::BTreeMap;

use assetpipe_geometry::clip::subdivide;
use assetpipe_geometry::planar::{fill, Edge};
use assetpipe_geometry::{Mesh, Plane};
use glam::{DVec2, DVec3};

use crate::search::piece::Piece;

/// Bits by which points are the same.
fn key(p: DVec3) -> [u64; 3] {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// One of a plane and its flipped twin.
fn canonical(plane: &Plane) -> Plane {
    let n = plane.normal;
    let first = [n.x, n.y, n.z]
        .into_iter()
        .find(|x| *x != 0.0)
        .unwrap_or(1.0);
    if first < 0.0 {
        plane.flipped()
    } else {
        *plane
    }
}

/// The closed surface of a union of pieces of one solid.
///
/// Where two pieces meet at a cut their caps bound the same region in opposite
/// senses; the sum of both borders is the border of what is left open.
pub fn close(pieces: &[&Piece]) -> Mesh {
    closed(pieces).0
}

/// The vertices of the closed surface of a piece that are none of its points: where borders of
/// caps cross.
pub fn crossings(piece: &Piece) -> Vec<DVec3> {
    if piece.caps.is_empty() {
        return Vec::new();
    }
    let (mut mesh, own) = closed(&[piece]);
    mesh.vertices.split_off(own)
}

/// The closed surface, and how many of its vertices, from the first, are points of the pieces.
fn closed(pieces: &[&Piece]) -> (Mesh, usize) {
    // One index for each distinct position.
    let mut positions: Vec<([u64; 3], DVec3)> = pieces
        .iter()
        .flat_map(|p| p.points.iter().map(|&x| (key(x), x + DVec3::ZERO)))
        .collect();
    positions.sort_by_key(|a| a.0);
    positions.dedup_by(|a, b| a.0 == b.0);
    let index = |p: DVec3| {
        positions
            .binary_search_by(|x| x.0.cmp(&key(p)))
            .unwrap_or(0) as u32
    };
    let mut mesh = Mesh {
        vertices: positions.iter().map(|p| p.1).collect(),
        triangles: Vec::new(),
    };

    // (plane, start, end) of every border segment.
    let mut borders: Vec<(Plane, u32, u32)> = Vec::new();
    for piece in pieces {
        let to: Vec<u32> = piece.points.iter().map(|&p| index(p)).collect();
        mesh.triangles
            .extend(piece.triangles.iter().map(|t| t.map(|v| to[v as usize])));
        for cap in &piece.caps {
            let plane = canonical(&cap.plane);
            borders.extend(
                cap.border
                    .iter()
                    .map(|s| (plane, to[s[0] as usize], to[s[1] as usize])),
            );
        }
    }
    let bits = |p: &Plane| (key(p.normal), (p.offset + 0.0).to_bits());
    borders.sort_by(|a, b| {
        bits(&a.0)
            .cmp(&bits(&b.0))
            .then((a.1, a.2).cmp(&(b.1, b.2)))
    });
    let mut divided = BTreeMap::new();
    for run in borders.chunk_by(|a, b| bits(&a.0) == bits(&b.0)) {
        cap(&mut mesh, &run[0].0, run, &mut divided);
    }
    mesh.triangles
        .retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    (mesh, positions.len())
}

/// Edges (lesser index first) that run through another vertex, with that vertex.
type Divided = BTreeMap<(u32, u32), u32>;

/// Divisions of one border segment at most.
const DIVISIONS: usize = 1000;

/// A border segment by the parts that earlier caps have divided it into.
fn parts_of(segment: (u32, u32), divided: &Divided) -> Vec<(u32, u32)> {
    let (mut parts, mut open) = (Vec::new(), vec![segment]);
    while let Some((a, b)) = open.pop() {
        match divided.get(&(a.min(b), a.max(b))) {
            Some(&m) if parts.len() < DIVISIONS => open.extend([(m, b), (a, m)]),
            _ => parts.push((a, b)),
        }
    }
    parts
}

/// Fill what the border segments on one plane bound. Points that the filling puts on its
/// border go into the triangles on the other side of it too, or the surface would be open
/// along slits of one rounding.
fn cap(mesh: &mut Mesh, plane: &Plane, borders: &[(Plane, u32, u32)], divided: &mut Divided) {
    let mut net: Vec<(u32, u32, i32)> = borders
        .iter()
        .flat_map(|&(_, a, b)| parts_of((a, b), divided))
        .filter(|(a, b)| a != b)
        .map(|(a, b)| if a < b { (a, b, 1) } else { (b, a, -1) })
        .collect();
    net.sort_unstable();
    let mut used: Vec<u32> = Vec::new();
    let mut edges: Vec<(u32, u32, i32)> = Vec::new();
    for run in net.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let times: i32 = run.iter().map(|e| e.2).sum();
        if times != 0 {
            edges.push((run[0].0, run[0].1, times));
            used.extend([run[0].0, run[0].1]);
        }
    }
    used.sort_unstable();
    used.dedup();
    // Project along the normal's largest component; counter-clockwise stays so.
    let size = plane.normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if plane.normal[axis] < 0.0 {
        std::mem::swap(&mut u, &mut v);
    }
    let flat: Vec<DVec2> = used
        .iter()
        .map(|&i| {
            let p = mesh.vertices[i as usize];
            DVec2::new(p[u], p[v])
        })
        .collect();
    let place = |i: u32| used.binary_search(&i).unwrap_or(0) as u32;
    let edges: Vec<Edge> = edges
        .iter()
        .map(|&(a, b, n)| (place(a), place(b), n))
        .collect();
    let filling = fill(&flat, &edges);
    let mut to = used;
    for p in filling.crossings {
        let mut x = DVec3::ZERO;
        x[u] = p.x;
        x[v] = p.y;
        x[axis] =
            (plane.offset - plane.normal[u] * p.x - plane.normal[v] * p.y) / plane.normal[axis];
        to.push(mesh.vertices.len() as u32);
        mesh.vertices.push(x);
    }
    let new: Divided = filling
        .subdivided
        .iter()
        .map(|(&(a, b), &m)| {
            let (a, b) = (to[a as usize], to[b as usize]);
            ((a.min(b), a.max(b)), to[m as usize])
        })
        .collect();
    if !new.is_empty() {
        mesh.triangles = subdivide(&mesh.triangles, 0, &new);
        divided.extend(new);
    }
    mesh.triangles
        .extend(filling.triangles.iter().map(|t| t.map(|i| to[i as usize])));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edges::check_closed;
    use crate::merge::volume;
    use crate::shapes::cuboid;
    use assetpipe_geometry::hull::convex_hull;

    fn cube() -> Piece {
        Piece::from(&cuboid(DVec3::ZERO, DVec3::ONE))
    }

    #[test]
    fn halves_close_and_their_union_loses_the_cut() {
        let (low, high) = cube().split(Plane::axis_aligned(2, 0.25));
        for (half, share) in [(&low, 0.25), (&high, 0.75)] {
            let mesh = close(&[half]);
            assert!(check_closed(&mesh).is_ok());
            assert!((volume(&mesh) - share).abs() < 1e-12);
        }
        let whole = close(&[&low, &high]);
        assert!(check_closed(&whole).is_ok());
        assert!((volume(&whole) - 1.0).abs() < 1e-12);
        assert!(whole
            .triangles
            .iter()
            .all(|t| t.iter().any(|&v| whole.vertices[v as usize].z != 0.25)));
    }

    #[test]
    fn a_quarter_missing_leaves_its_two_walls() {
        let (low, high) = cube().split(Plane::axis_aligned(2, 0.5));
        let (a, b) = high.split(Plane::axis_aligned(0, 0.5));
        let most = close(&[&low, &a]);
        assert!((volume(&most) - 0.75).abs() < 1e-12);
        let all = close(&[&low, &a, &b]);
        assert!((volume(&all) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_corner_on_another_border_divides_both_sides_of_it() {
        let mut points: Vec<DVec3> = (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let cube = convex_hull(&points).unwrap();
        // A prism whose edge touches the middle of one side of the cube.
        points = [0.0, 1.0]
            .iter()
            .flat_map(|&z| [(1.0, 0.3), (2.0, 0.0), (2.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z)))
            .collect();
        let prism = convex_hull(&points).unwrap();
        let mut both = cube.clone();
        both.triangles.extend(
            prism
                .triangles
                .iter()
                .map(|t| t.map(|v| v + cube.vertices.len() as u32)),
        );
        both.vertices.extend(&prism.vertices);
        let (low, high) = Piece::from(&both).split(Plane::axis_aligned(2, 0.5));
        for half in [low, high] {
            let mesh = close(&[&half]);
            assert!(check_closed(&mesh).is_ok(), "{:?}", check_closed(&mesh));
            assert!((volume(&mesh) - 0.75).abs() < 1e-12);
        }
    }
}

//! Reflex edges and the planes that resolve several of them at once, in any direction.
//!
//! A reflex edge stops being one if a plane through it leaves at most a straight angle on both
//! sides: if the plane runs into the solid between the continuations of the edge's two faces
//! (Chazelle 1984, *Convex partitions of polyhedra*, §2). One plane may do that for many edges:
//! those around a face that others stand on, those along both sides of an arm, those of the curve
//! in which a tube enters a wall. Planes along the axes of the cuts have their grid; the others
//! are found here.

use assetpipe_geometry::{Mesh, Plane};
use glam::DVec3;

use crate::even;

/// Least sine of half the angle by which an edge is reflex: 20° in all.
const LEAST: f64 = 0.173;
/// Sine of the largest bend of a straight edge, and of faces along it.
const STRAIGHT: f64 = 1e-3;
/// Most edges that are looked at.
const MOST: usize = 400;
/// Most edges that offer planes, the heaviest ones.
const LEADING: usize = 16;
/// Edges so far from a plane, in ε, lie in it.
const COPLANAR: f64 = 0.05;
/// Ends so far from a cut are on it; working copies have extent ~1.
const ON: f64 = 1e-6;
/// Cosine from which a plane has the direction of an axis.
const PARALLEL: f64 = 0.999;

/// A straight reflex edge.
#[derive(Clone, Copy, Debug)]
pub struct Notch {
    ends: [DVec3; 2],
    /// Outward normals of its faces.
    normals: [DVec3; 2],
    /// Into the solid along the continuations of both faces, across the edge.
    cone: [DVec3; 2],
    /// Sine of half the angle by which it is reflex.
    depth: f64,
}

impl Notch {
    fn along(&self) -> DVec3 {
        self.ends[1] - self.ends[0]
    }

    fn weight(&self) -> f64 {
        even::weight(self.along().length() * self.depth)
    }

    /// Whether a plane within `slack` of both ends leaves no notch.
    fn resolved(&self, plane: &Plane, slack: f64) -> bool {
        let off = |p: DVec3| (plane.normal.dot(p) - plane.offset).abs();
        if off(self.ends[0]) > slack || off(self.ends[1]) > slack {
            return false;
        }
        let into = plane.normal.cross(self.along()).normalize_or_zero();
        let middle = (self.cone[0] + self.cone[1]).normalize_or_zero();
        // Both directions of the cone are equally far from its middle.
        into.dot(middle).abs() > self.cone[0].dot(middle) - 1e-6
    }

    /// The stretch below a plane.
    fn below(&self, plane: &Plane) -> Option<Notch> {
        let [a, b] = self.ends;
        let (ha, hb) = (
            plane.normal.dot(a) - plane.offset,
            plane.normal.dot(b) - plane.offset,
        );
        // An edge in the plane is resolved.
        if ha > -ON && hb > -ON {
            return None;
        }
        let at = a.lerp(b, ha / (ha - hb));
        Some(Notch {
            ends: [if ha > 0.0 { at } else { a }, if hb > 0.0 { at } else { b }],
            ..*self
        })
    }
}

/// The straight reflex edges of a closed surface, the heaviest ones.
pub fn find(mesh: &Mesh) -> Vec<Notch> {
    let normals: Vec<DVec3> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).normalize_or_zero()
        })
        .collect();
    // (smaller vertex, larger vertex, triangle, opposite vertex)
    let mut sides: Vec<(u32, u32, u32, u32)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, v) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b, c) = (v[i], v[(i + 1) % 3], v[(i + 2) % 3]);
            sides.push((a.min(b), a.max(b), t as u32, c));
        }
    }
    sides.sort_unstable();
    let at = |v: u32| mesh.vertices[v as usize];
    let mut edges: Vec<([u32; 2], Notch)> = Vec::new();
    for pair in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let &[(a, b, s, opposite_s), (_, _, t, opposite_t)] = pair else {
            continue;
        };
        let (m, n) = (normals[s as usize], normals[t as usize]);
        let depth = 0.5 * (m - n).length();
        if depth < LEAST || m.dot(at(opposite_t) - at(a)) <= 0.0 {
            continue;
        }
        let along = (at(b) - at(a)).normalize_or_zero();
        let away = |opposite: u32| {
            let d = at(opposite) - at(a);
            -(d - along * along.dot(d)).normalize_or_zero()
        };
        edges.push((
            [a, b],
            Notch {
                ends: [at(a), at(b)],
                normals: [m, n],
                cone: [away(opposite_s), away(opposite_t)],
                depth,
            },
        ));
    }
    let mut found = straighten(&edges, mesh.vertices.len());
    found.sort_by(|a, b| b.weight().total_cmp(&a.weight()));
    found.truncate(MOST);
    found
}

/// Edges that continue one another become one.
fn straighten(edges: &[([u32; 2], Notch)], vertices: usize) -> Vec<Notch> {
    let mut at: Vec<[u32; 2]> = vec![[u32::MAX; 2]; vertices];
    let mut many = vec![false; vertices];
    for (i, (ends, _)) in edges.iter().enumerate() {
        for &v in ends {
            let slots = &mut at[v as usize];
            match slots.iter().position(|&s| s == u32::MAX) {
                Some(slot) => slots[slot] = i as u32,
                None => many[v as usize] = true,
            }
        }
    }
    let same = |a: &Notch, b: &Notch| {
        let close = |x: DVec3, y: DVec3| x.cross(y).length() < STRAIGHT && x.dot(y) > 0.0;
        let (u, v) = (a.along().normalize_or_zero(), b.along().normalize_or_zero());
        let [m, n] = b.normals;
        u.cross(v).length() < STRAIGHT
            && (close(a.normals[0], m) && close(a.normals[1], n)
                || close(a.normals[0], n) && close(a.normals[1], m))
    };
    let mut used = vec![false; edges.len()];
    let mut found = Vec::new();
    for start in 0..edges.len() {
        if used[start] {
            continue;
        }
        used[start] = true;
        let (ends, notch) = &edges[start];
        let mut whole = *notch;
        for (side, &end) in ends.iter().enumerate() {
            let (mut from, mut v) = (start, end);
            while !many[v as usize] {
                let [i, j] = at[v as usize];
                let next = if i as usize == from { j } else { i };
                if next == u32::MAX || used[next as usize] || !same(notch, &edges[next as usize].1)
                {
                    break;
                }
                from = next as usize;
                used[from] = true;
                let (next_ends, next_notch) = &edges[from];
                let far = usize::from(next_ends[0] == v);
                v = next_ends[far];
                whole.ends[side] = next_notch.ends[far];
            }
        }
        found.push(whole);
    }
    found
}

/// What a cut leaves of the notches, (below, above).
pub fn split(notches: &[Notch], plane: &Plane) -> (Vec<Notch>, Vec<Notch>) {
    let flipped = Plane {
        normal: -plane.normal,
        offset: -plane.offset,
    };
    let part = |plane: &Plane| notches.iter().filter_map(|n| n.below(plane)).collect();
    (part(plane), part(&flipped))
}

/// The notches whose middle is in a box.
pub fn within(notches: &[Notch], (lo, hi): (DVec3, DVec3)) -> Vec<Notch> {
    let inside = |n: &&Notch| {
        let middle = 0.5 * (n.ends[0] + n.ends[1]);
        middle.cmpge(lo).all() && middle.cmple(hi).all()
    };
    notches.iter().filter(inside).copied().collect()
}

/// At most `most` planes that are along none of the axes, those first that resolve most: length
/// of edges, at least `least` in all, times how reflex they are. Each with the share of the
/// part's that it resolves.
pub fn planes(notches: &[Notch], epsilon: f64, least: f64, most: usize) -> Vec<(Plane, f64)> {
    let slack = COPLANAR * epsilon;
    let all: f64 = notches.iter().map(Notch::weight).sum();
    let mut leading: Vec<&Notch> = notches.iter().collect();
    leading.sort_by(|a, b| b.weight().total_cmp(&a.weight()));
    leading.truncate(LEADING);
    let mut offers: Vec<(f64, Plane)> = Vec::new();
    let mut offer = |normal: DVec3, through: DVec3| {
        if normal == DVec3::ZERO || normal.abs().max_element() > PARALLEL {
            return;
        }
        let plane = Plane {
            normal,
            offset: normal.dot(through),
        };
        if offers.iter().any(|(_, p)| same(p, &plane, slack)) {
            return;
        }
        let resolved = notches.iter().filter(|n| n.resolved(&plane, slack));
        let (mut length, mut weight) = (0.0, 0.0);
        for notch in resolved {
            length += notch.along().length();
            weight += notch.weight();
        }
        if length >= least {
            offers.push((weight, plane));
        }
    };
    for (i, a) in leading.iter().enumerate() {
        for normal in a.normals {
            offer(normal, a.ends[0]);
        }
        for b in &leading[i + 1..] {
            let u = a.along().normalize_or_zero();
            let across = b.ends[0] - a.ends[0];
            let across = across - u * u.dot(across);
            // Edges on one line lie in many planes.
            if across.length() <= slack {
                continue;
            }
            let normal = u.cross(across.normalize());
            if normal.dot(b.ends[1] - a.ends[0]).abs() <= slack {
                offer(normal, a.ends[0]);
            }
        }
    }
    offers.sort_by(|a, b| even::weight(b.0).total_cmp(&even::weight(a.0)));
    let shares = offers.into_iter().take(most);
    shares
        .map(|(weight, plane)| (plane, weight / all))
        .collect()
}

fn same(a: &Plane, b: &Plane, slack: f64) -> bool {
    let along = a.normal.dot(b.normal);
    along.abs() > PARALLEL && (a.offset * along.signum() - b.offset).abs() < slack
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::piece::Piece;
    use assetpipe_geometry::hull::convex_hull;

    /// Three arms at 120°, 1/5 wide and 1/2 high.
    fn star(turn: glam::DMat3) -> Mesh {
        let mut outline = Vec::new();
        for k in 0..3 {
            let angle = f64::from(k) * std::f64::consts::TAU / 3.0;
            let (u, v) = (
                DVec3::new(libm::cos(angle), libm::sin(angle), 0.0),
                DVec3::new(-libm::sin(angle), libm::cos(angle), 0.0),
            );
            outline.push(u - 0.1 * v);
            outline.push(u + 0.1 * v);
            // The reflex corner between this arm and the next.
            outline.push(
                0.1 / libm::sin(std::f64::consts::FRAC_PI_3) * {
                    let half = angle + std::f64::consts::FRAC_PI_3;
                    DVec3::new(libm::cos(half), libm::sin(half), 0.0)
                },
            );
        }
        let mut vertices: Vec<DVec3> = Vec::new();
        for z in [0.0, 0.5] {
            vertices.extend(outline.iter().map(|p| turn * (*p + z * DVec3::Z)));
        }
        let mut triangles = Vec::new();
        for i in 0..9u32 {
            let j = (i + 1) % 9;
            triangles.extend([[i, j, j + 9], [i, j + 9, i + 9]]);
        }
        for [a, b, c] in [
            [8, 0, 1],
            [8, 1, 2],
            [2, 3, 4],
            [2, 4, 5],
            [5, 6, 7],
            [5, 7, 8],
            [2, 5, 8],
        ] {
            triangles.extend([[a, c, b], [a + 9, b + 9, c + 9]]);
        }
        Mesh {
            vertices,
            triangles,
        }
    }

    fn turned() -> glam::DMat3 {
        glam::DMat3::from_quat(glam::DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize())
    }

    #[test]
    fn a_star_has_three_notches_and_two_planes_free_it() {
        for turn in [glam::DMat3::IDENTITY, turned()] {
            let mesh = star(turn);
            let notches = find(&mesh);
            assert_eq!(notches.len(), 3);
            let planes: Vec<Plane> = planes(&notches, 0.02, 0.1, 8)
                .into_iter()
                .map(|p| p.0)
                .collect();
            assert!(!planes.is_empty());
            // The plane between two arms cuts one off, and it is convex.
            let whole = Piece::from(&mesh);
            let convex = |piece: &Piece| {
                let hull = convex_hull(&piece.points).map_or(0.0, |h| Piece::from(&h).volume());
                piece.volume() > 1e-3 && hull < 1.0001 * piece.volume()
            };
            let freed = planes.iter().filter(|p| {
                let (a, b) = whole.split(**p);
                assert!((a.volume() + b.volume() - whole.volume()).abs() < 1e-9);
                convex(&a) || convex(&b)
            });
            assert!(freed.count() >= 2);
            // What resolved an edge leaves none of it behind.
            let (below, above) = split(&notches, &planes[0]);
            assert!(below.len() + above.len() < 3);
        }
    }

    #[test]
    fn planes_have_unit_normals_though_edges_are_on_one_line() {
        let notch = |from: f64, to: f64| Notch {
            ends: [from, to].map(|t| turned() * DVec3::new(t, 0.1, 0.2)),
            normals: [turned() * DVec3::Y, turned() * DVec3::Z],
            cone: [turned() * -DVec3::Z, turned() * -DVec3::Y],
            depth: 0.7,
        };
        let found = planes(&[notch(-0.9, -0.1), notch(0.1, 0.8)], 0.02, 0.1, 8);
        assert!(!found.is_empty());
        assert!(found
            .iter()
            .all(|(plane, _)| (plane.normal.length() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn convex_and_smooth_surfaces_have_no_notches() {
        let points: Vec<DVec3> = (0..300u32)
            .map(|i| {
                let (z, angle) = (f64::from(i) / 150.0 - 1.0, f64::from(i) * 2.4);
                let r = (1.0 - z * z).max(0.0).sqrt();
                DVec3::new(r * libm::cos(angle), r * libm::sin(angle), z)
            })
            .collect();
        assert!(find(&convex_hull(&points).unwrap()).is_empty());
    }

    #[test]
    fn edges_that_continue_one_another_are_one() {
        let mut mesh = star(glam::DMat3::IDENTITY);
        // Divide the reflex edge from 2 to 11 in the middle.
        let middle = mesh.vertices.len() as u32;
        mesh.vertices
            .push(0.5 * (mesh.vertices[2] + mesh.vertices[11]));
        let halves = mesh.triangles.iter().flat_map(|t| {
            let at = (0..3).find(|&i| {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                (a.min(b), a.max(b)) == (2, 11)
            });
            match at {
                Some(i) => {
                    let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                    vec![[a, middle, c], [middle, b, c]]
                }
                None => vec![*t],
            }
        });
        mesh.triangles = halves.collect();
        let notches = find(&mesh);
        assert_eq!(notches.len(), 3);
        assert!(notches
            .iter()
            .all(|n| (n.along().length() - 0.5).abs() < 1e-12));
    }
}

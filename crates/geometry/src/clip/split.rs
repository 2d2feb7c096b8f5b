//! One plane, two solids.

use std::cmp::Ordering;

use glam::DVec3;

use super::section::{sides, Section, View};
use super::separate::separate_at;
use super::subdivide::subdivide;
use super::ClipError;
use crate::mesh::Mesh;
use crate::planar::{fill, Edge};
use crate::plane::Plane;
use crate::predicates::orient2d;

/// The two pieces of a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// What lies where `normal · x < offset`.
    pub below: Option<Mesh>,
    /// What lies where `normal · x > offset`.
    pub above: Option<Mesh>,
    /// Whether the cap had to be a fan with overlapping triangles, because loops
    /// crossed without end: closed, of the right volume, but not embedded.
    pub is_fan: bool,
}

/// Cuts a closed mesh in two closed meshes.
///
/// Sides are decided exactly; a vertex on the plane stays where it is. Each
/// crossing point is computed once and shared; if the plane is axis-aligned
/// its coordinate is the offset to the last bit (for a unit normal). Both pieces get the same
/// cap, turned around, so as chains the pieces add up to the solid: volumes
/// are additive up to the rounding of crossing points. Faces in the plane go
/// to the side on which the solid is. Where a piece touches itself in the
/// plane, its vertices are doubled so that it is a 2-manifold again.
///
/// The mesh may have several components, cavities, and edges with more than
/// two triangles as long as these cancel in pairs. Vertices that no triangle
/// uses are dropped. O(n) plus O(k log k) for k cut triangles.
///
/// # Errors
/// [`ClipError`]: not a plane, indices or coordinates that are not valid, or
/// a surface that is open where it is cut.
pub fn split(mesh: &Mesh, plane: &Plane) -> Result<Split, ClipError> {
    check(mesh, plane)?;
    let sides = sides(mesh, plane);
    let uses = |wanted: Ordering| {
        mesh.triangles
            .iter()
            .flatten()
            .any(|v| sides[*v as usize] == wanted)
    };
    let whole = |present: bool| present.then(|| mesh.clone());
    if !uses(Ordering::Greater) {
        let below = whole(!mesh.triangles.is_empty());
        return Ok(Split {
            below,
            above: None,
            is_fan: false,
        });
    }
    if !uses(Ordering::Less) {
        return Ok(Split {
            below: None,
            above: whole(true),
            is_fan: false,
        });
    }
    let scaled = plane.scaled();
    let view = View::of(&scaled);
    let mut cut = Cut {
        mesh,
        sides: &sides,
        section: Section::new(mesh, &scaled, view, &sides),
        view,
        below: Vec::new(),
        above: Vec::new(),
        rim: Vec::new(),
    };
    cut.triangles();
    let is_fan = cut.cap(&scaled)?;
    let (low, high): (Vec<u32>, Vec<u32>) = cut.section.crossed.iter().copied().unzip();
    Ok(Split {
        below: cut.finish(&cut.below, &low),
        above: cut.finish(&cut.above, &high),
        is_fan,
    })
}

fn check(mesh: &Mesh, plane: &Plane) -> Result<(), ClipError> {
    let (normal, offset) = (plane.normal, plane.offset);
    if !normal.is_finite() || !offset.is_finite() || normal == DVec3::ZERO {
        return Err(ClipError::NotAPlane { normal, offset });
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for &v in corners {
            match mesh.vertices.get(v as usize) {
                None => return Err(ClipError::NoSuchVertex { triangle }),
                Some(p) if !p.is_finite() => {
                    return Err(ClipError::NotFinite { vertex: v as usize })
                }
                Some(_) => {}
            }
        }
    }
    Ok(())
}

/// Triangles of a piece. Corners up to the number of the mesh's vertices are
/// these (strictly on the piece's side); higher ones are section points.
type Triangles = Vec<[u32; 3]>;

struct Cut<'a> {
    mesh: &'a Mesh,
    sides: &'a [Ordering],
    section: Section,
    view: View,
    below: Triangles,
    above: Triangles,
    /// Directed edges of the lower piece in the plane, as section points.
    rim: Vec<(u32, u32)>,
}

impl Cut<'_> {
    fn triangles(&mut self) {
        for t in &self.mesh.triangles {
            let s = t.map(|v| self.sides[v as usize]);
            let low = s.contains(&Ordering::Less);
            let high = s.contains(&Ordering::Greater);
            match (low, high) {
                (true, true) => self.cross(*t, s),
                (true, false) => self.add_below(&t.map(|v| self.corner(v))),
                (false, true) => {
                    let corners = t.map(|v| self.corner(v));
                    self.add_above(&corners);
                }
                (false, false) => self.lie(*t),
            }
        }
    }

    fn corner(&self, vertex: u32) -> u32 {
        if self.sides[vertex as usize].is_eq() {
            self.on_section(self.section.of_vertex[vertex as usize])
        } else {
            vertex
        }
    }

    fn on_section(&self, point: u32) -> u32 {
        self.mesh.vertices.len() as u32 + point
    }

    /// Divides a triangle with corners on both sides.
    fn cross(&mut self, t: [u32; 3], s: [Ordering; 3]) {
        let mut below = Polygon::default();
        let mut above = Polygon::default();
        for i in 0..3 {
            let j = (i + 1) % 3;
            if s[i].is_le() {
                below.push(self.corner(t[i]));
            }
            if s[i].is_ge() {
                above.push(self.corner(t[i]));
            }
            let point = match (s[i], s[j]) {
                (Ordering::Less, Ordering::Greater) => self.section.on_edge(t[i], t[j]),
                (Ordering::Greater, Ordering::Less) => self.section.on_edge(t[j], t[i]),
                _ => continue,
            };
            let point = self.on_section(point);
            below.push(point);
            above.push(point);
        }
        self.add_below(below.corners());
        self.add_above(above.corners());
    }

    /// A triangle in the plane belongs to the side on which its inside is.
    fn lie(&mut self, t: [u32; 3]) {
        let corners = t.map(|v| self.corner(v));
        let [a, b, c] = t.map(|v| self.view.project(self.mesh.vertices[v as usize]));
        if orient2d(a, b, c).is_gt() {
            self.add_below(&corners);
        } else {
            // One without area may go anywhere.
            self.add_above(&corners);
        }
    }

    fn add_below(&mut self, polygon: &[u32]) {
        let first = self.on_section(0);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if a >= first && b >= first && a != b {
                self.rim.push((a - first, b - first));
            }
        }
        let halves = self.triangulate(polygon);
        self.below.extend(halves.into_iter().flatten());
    }

    fn add_above(&mut self, polygon: &[u32]) {
        let halves = self.triangulate(polygon);
        self.above.extend(halves.into_iter().flatten());
    }

    /// A triangle as it is, a quadrilateral along its shorter diagonal;
    /// nothing where corners coincide.
    fn triangulate(&self, polygon: &[u32]) -> [Option<[u32; 3]>; 2] {
        let proper = |t: [u32; 3]| (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]).then_some(t);
        match *polygon {
            [a, b, c] => [proper([a, b, c]), None],
            [a, b, c, d] => {
                let length = |p, q| self.position(p).distance_squared(self.position(q));
                if length(a, c) <= length(b, d) {
                    [proper([a, b, c]), proper([a, c, d])]
                } else {
                    [proper([a, b, d]), proper([b, c, d])]
                }
            }
            _ => [None, None],
        }
    }

    fn position(&self, corner: u32) -> DVec3 {
        match corner.checked_sub(self.on_section(0)) {
            None => self.mesh.vertices[corner as usize],
            Some(point) => self.section.points[point as usize],
        }
    }

    /// Closes both pieces; tells whether by a fan.
    fn cap(&mut self, plane: &Plane) -> Result<bool, ClipError> {
        let edges = self.boundary()?;
        let filling = fill(&self.section.pictures, &edges);
        let lifted = filling.crossings.iter().map(|&p| self.view.lift(plane, p));
        self.section.points.extend(lifted);
        self.section
            .is_shared
            .resize(self.section.points.len(), true);
        for &point in filling.subdivided.values() {
            self.section.is_shared[point as usize] = true;
        }
        let first = self.on_section(0);
        if !filling.subdivided.is_empty() {
            for piece in [&mut self.below, &mut self.above] {
                *piece = subdivide(piece, first, &filling.subdivided);
            }
        }
        for t in &filling.triangles {
            let [a, b, c] = t.map(|point| first + point);
            self.below.push([a, b, c]);
            self.above.push([a, c, b]);
        }
        Ok(filling.is_fan)
    }

    /// The cycle that the cap must bound: the rim reversed, without what runs
    /// both ways.
    fn boundary(&self) -> Result<Vec<Edge>, ClipError> {
        let reversed = |&(a, b): &(u32, u32)| if a < b { (a, b, -1) } else { (b, a, 1) };
        let mut directed: Vec<Edge> = self.rim.iter().map(reversed).collect();
        directed.sort_unstable();
        let mut edges: Vec<Edge> = Vec::new();
        for (a, b, times) in directed {
            match edges.last_mut() {
                Some(last) if (last.0, last.1) == (a, b) => last.2 += times,
                _ => edges.push((a, b, times)),
            }
        }
        edges.retain(|e| e.2 != 0);
        let mut balance = vec![0i64; self.section.points.len()];
        for &(a, b, times) in &edges {
            balance[a as usize] += i64::from(times);
            balance[b as usize] -= i64::from(times);
        }
        match balance.iter().position(|b| *b != 0) {
            Some(point) => Err(ClipError::NotClosed {
                near: self.section.points[point],
            }),
            None => Ok(edges),
        }
    }

    /// A mesh of the vertices that `triangles` use, in their order, and a
    /// 2-manifold around the section. `ends` are the piece's ends of the crossed edges.
    fn finish(&self, triangles: &[[u32; 3]], ends: &[u32]) -> Option<Mesh> {
        let section = &self.section;
        let count = self.mesh.vertices.len();
        let mut name: Vec<u32> = (0..(count + section.points.len()) as u32).collect();
        let mut is_suspect = vec![false; name.len()];
        is_suspect[count..].fill(true);
        // A crossing that rounds to the end of its edge is that vertex.
        for (&end, &point) in ends.iter().zip(&section.of_crossed) {
            let point = count + point as usize;
            if name[point] as usize == point && self.position(end) == self.position(point as u32) {
                name[point] = end;
                is_suspect[end as usize] = true;
            }
        }
        // Where several points became one, the fans of the vertices around
        // may have been pinched.
        let is_merged = |v: u32| match v.checked_sub(count as u32) {
            None => false,
            Some(point) => section.is_shared[point as usize] || name[v as usize] != v,
        };
        for t in triangles.iter().filter(|t| t.iter().any(|v| is_merged(*v))) {
            for &v in t {
                is_suspect[v as usize] = true;
            }
        }
        let named = triangles.iter().map(|t| t.map(|v| name[v as usize]));
        let proper = named.filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        let triangles = cancel(proper.collect(), &is_suspect);
        if triangles.is_empty() {
            return None;
        }
        let mut used = vec![false; name.len()];
        for &v in triangles.iter().flatten() {
            used[v as usize] = true;
        }
        let mut piece = Mesh {
            vertices: Vec::new(),
            triangles,
        };
        let mut suspects = Vec::new();
        for old in (0..name.len()).filter(|v| used[*v]) {
            name[old] = piece.vertices.len() as u32;
            piece.vertices.push(self.position(old as u32));
            suspects.push(is_suspect[old]);
        }
        for t in &mut piece.triangles {
            *t = t.map(|v| name[v as usize]);
        }
        separate_at(&mut piece, &suspects);
        Some(piece)
    }
}

/// At most four corners.
#[derive(Default)]
struct Polygon {
    corners: [u32; 4],
    length: usize,
}

impl Polygon {
    fn push(&mut self, corner: u32) {
        self.corners[self.length] = corner;
        self.length += 1;
    }

    fn corners(&self) -> &[u32] {
        &self.corners[..self.length]
    }
}

/// Removes pairs of equal triangles that face each other: where the plane
/// nearly coincides with a face, cap and face leave nothing between them.
fn cancel(mut triangles: Triangles, is_suspect: &[bool]) -> Triangles {
    let mut flat: Vec<([u32; 3], bool, u32)> = Vec::new();
    for (index, t) in triangles.iter().enumerate() {
        if t.iter().all(|v| is_suspect[*v as usize]) {
            let mut sorted = *t;
            sorted.sort_unstable();
            let is_even = [[0, 1, 2], [1, 2, 0], [2, 0, 1]]
                .iter()
                .any(|turn| turn.map(|i: usize| sorted[i]) == *t);
            flat.push((sorted, is_even, index as u32));
        }
    }
    flat.sort_unstable();
    let mut dropped = vec![false; triangles.len()];
    for same in flat.chunk_by(|a, b| a.0 == b.0) {
        let odd = same.iter().filter(|f| !f.1);
        let even = same.iter().filter(|f| f.1);
        for (a, b) in odd.zip(even) {
            dropped[a.2 as usize] = true;
            dropped[b.2 as usize] = true;
        }
    }
    let mut is_dropped = dropped.into_iter();
    triangles.retain(|_| is_dropped.next() != Some(true));
    triangles
}

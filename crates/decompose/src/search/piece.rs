//! Pieces of a solid as the search sees them: surface triangles and caps.
//!
//! A piece is `solid ∩ half-spaces`. Its surface triangles come from the
//! solid; each cut leaves a *cap*, kept as directed segments on the cutting
//! plane and never triangulated. Together they are a closed signed chain, so
//! volumes follow from the divergence theorem, and the end points of all
//! segments hold every extreme point, corners inside the solid included.

use assetpipe_geometry::{Mesh, Plane};
use glam::DVec3;

/// The planar region a cut left open, by its border.
#[derive(Clone, Debug)]
pub struct Cap {
    /// The plane it lies on; the piece is *below*.
    pub plane: Plane,
    /// Directed border segments, counter-clockwise seen from above.
    pub border: Vec<[u32; 2]>,
}

/// A closed signed chain of surface triangles and caps.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Surface triangles, outward.
    pub triangles: Vec<[u32; 3]>,
    /// What the cuts left open.
    pub caps: Vec<Cap>,
}

/// Vertices this close to a plane that is along no axis are on it: the rounding of a height
/// (working copies have extent ~1). More would take from parts what no other part gets. Along the
/// axes coordinates are exact.
const ON: f64 = 64.0 * f64::EPSILON;

/// Side of a point: below, on or above a plane.
fn side(h: f64, on: f64) -> i8 {
    if h < -on {
        -1
    } else {
        i8::from(h > on)
    }
}

impl From<&Mesh> for Piece {
    fn from(mesh: &Mesh) -> Self {
        Piece {
            points: mesh.vertices.clone(),
            triangles: mesh.triangles.clone(),
            caps: Vec::new(),
        }
    }
}

/// One half of a piece while it is being built.
struct Half {
    piece: Piece,
    /// New index of each old point, or `u32::MAX`.
    index: Vec<u32>,
}

impl Half {
    fn new(points: usize) -> Self {
        Half {
            piece: Piece::default(),
            index: vec![u32::MAX; points],
        }
    }

    fn old(&mut self, whole: &Piece, v: u32) -> u32 {
        let slot = &mut self.index[v as usize];
        if *slot == u32::MAX {
            *slot = self.piece.points.len() as u32;
            self.piece.points.push(whole.points[v as usize]);
        }
        *slot
    }
}

/// Crossing points of edges with the plane, one a whole-piece edge.
struct Crossings {
    /// (smaller, larger vertex, index in below, index in above), sorted.
    edges: Vec<(u32, u32, u32, u32)>,
}

impl Crossings {
    fn find(&self, a: u32, b: u32) -> (u32, u32) {
        let key = (a.min(b), a.max(b));
        match self.edges.binary_search_by(|e| (e.0, e.1).cmp(&key)) {
            Ok(at) => (self.edges[at].2, self.edges[at].3),
            Err(_) => (0, 0),
        }
    }
}

impl Piece {
    /// Bounding box as (low, high); (0, 0) when empty.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let Some(&first) = self.points.first() else {
            return (DVec3::ZERO, DVec3::ZERO);
        };
        self.points
            .iter()
            .fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// Every directed edge (u, v) with u < v of triangles and borders: each
    /// undirected edge of the closed chain once.
    pub fn edges(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let triangles = self
            .triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
        let caps = self
            .caps
            .iter()
            .flat_map(|c| c.border.iter().map(|s| (s[0], s[1])));
        triangles.chain(caps).filter(|&(u, v)| u < v)
    }

    /// Signed volume.
    pub fn volume(&self) -> f64 {
        let Some(&o) = self.points.first() else {
            return 0.0;
        };
        let at = |v: u32| self.points[v as usize] - o;
        let mut six = 0.0;
        for t in &self.triangles {
            six += at(t[0]).dot(at(t[1]).cross(at(t[2])));
        }
        for cap in &self.caps {
            let Some(first) = cap.border.first() else {
                continue;
            };
            let apex = at(first[0]);
            for s in &cap.border {
                six += apex.dot(at(s[0]).cross(at(s[1])));
            }
        }
        six / 6.0
    }

    /// A crossing point an edge, made in a fixed order and added to both halves.
    fn cross(
        &self,
        heights: &[f64],
        sides: &[i8],
        below: &mut Half,
        above: &mut Half,
    ) -> Crossings {
        let mut edges: Vec<(u32, u32)> = self
            .triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
            .chain(
                self.caps
                    .iter()
                    .flat_map(|c| c.border.iter().map(|s| (s[0], s[1]))),
            )
            .filter(|&(a, b)| sides[a as usize] * sides[b as usize] < 0)
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        Crossings {
            edges: edges
                .into_iter()
                .map(|(a, b)| {
                    let (ha, hb) = (heights[a as usize], heights[b as usize]);
                    let p = self.points[a as usize].lerp(self.points[b as usize], ha / (ha - hb));
                    below.piece.points.push(p);
                    above.piece.points.push(p);
                    (
                        a,
                        b,
                        below.piece.points.len() as u32 - 1,
                        above.piece.points.len() as u32 - 1,
                    )
                })
                .collect(),
        }
    }

    /// The parts below and above a plane.
    ///
    /// A triangle in the plane goes to neither side's surface: the cap of the
    /// side that holds solid there replaces it. If the plane is along no axis
    /// that side keeps the triangle, and its cap is what is left of the plane.
    pub fn split(&self, plane: Plane) -> (Piece, Piece) {
        let heights: Vec<f64> = self
            .points
            .iter()
            .map(|p| plane.normal.dot(*p) - plane.offset)
            .collect();
        let on = if plane.normal.abs().max_element() == 1.0 {
            0.0
        } else {
            ON
        };
        let sides: Vec<i8> = heights.iter().map(|&h| side(h, on)).collect();
        let mut below = Half::new(self.points.len());
        let mut above = Half::new(self.points.len());

        let crossings = self.cross(&heights, &sides, &mut below, &mut above);
        let mut border_below = Vec::new();
        let mut border_above = Vec::new();
        for t in &self.triangles {
            let s = t.map(|v| sides[v as usize]);
            if s == [0, 0, 0] {
                // Where rounding made a face uneven it stays with the side that holds solid
                // there, or its points would be in no hull; where it is exact a cap does as well.
                if on > 0.0 {
                    let [a, b, c] = t.map(|v| self.points[v as usize]);
                    let (half, border) = if (b - a).cross(c - a).dot(plane.normal) > 0.0 {
                        (&mut below, &mut border_below)
                    } else {
                        (&mut above, &mut border_above)
                    };
                    let n = t.map(|v| half.old(self, v));
                    half.piece.triangles.push(n);
                    border.extend((0..3).map(|i| [n[(i + 1) % 3], n[i]]));
                }
                continue;
            }
            if s.iter().all(|&x| x <= 0) {
                let n = t.map(|v| below.old(self, v));
                below.piece.triangles.push(n);
                // The cap runs against the edge that lies in the plane.
                for i in 0..3 {
                    if s[i] == 0 && s[(i + 1) % 3] == 0 {
                        border_below.push([n[(i + 1) % 3], n[i]]);
                    }
                }
            } else if s.iter().all(|&x| x >= 0) {
                let n = t.map(|v| above.old(self, v));
                above.piece.triangles.push(n);
                for i in 0..3 {
                    if s[i] == 0 && s[(i + 1) % 3] == 0 {
                        border_above.push([n[(i + 1) % 3], n[i]]);
                    }
                }
            } else {
                let (mut low, mut high) = (Polygon::default(), Polygon::default());
                for i in 0..3 {
                    let (a, b) = (t[i], t[(i + 1) % 3]);
                    if sides[a as usize] <= 0 {
                        low.push(below.old(self, a), sides[a as usize] == 0);
                    }
                    if sides[a as usize] >= 0 {
                        high.push(above.old(self, a), sides[a as usize] == 0);
                    }
                    if sides[a as usize] * sides[b as usize] < 0 {
                        let (l, h) = crossings.find(a, b);
                        low.push(l, true);
                        high.push(h, true);
                    }
                }
                low.emit(&mut below.piece.triangles, &mut border_below);
                high.emit(&mut above.piece.triangles, &mut border_above);
            }
        }
        for cap in &self.caps {
            split_cap(
                self,
                cap,
                plane,
                &sides,
                &crossings,
                (&mut below, &mut above),
                (&mut border_below, &mut border_above),
            );
        }
        if on > 0.0 {
            cancel(&mut border_below);
            cancel(&mut border_above);
        }
        let flipped = Plane {
            normal: -plane.normal,
            offset: -plane.offset,
        };
        if !border_below.is_empty() {
            below.piece.caps.push(Cap {
                plane,
                border: border_below,
            });
        }
        if !border_above.is_empty() {
            above.piece.caps.push(Cap {
                plane: flipped,
                border: border_above,
            });
        }
        (below.piece, above.piece)
    }
}

/// Leave out segments that are there in both directions.
fn cancel(border: &mut Vec<[u32; 2]>) {
    let name = |s: &[u32; 2]| (s[0].min(s[1]), s[0].max(s[1]));
    border.sort_unstable_by_key(|s| (name(s), *s));
    let mut kept = Vec::with_capacity(border.len());
    for run in border.chunk_by(|s, t| name(s) == name(t)) {
        let forward = run.iter().filter(|s| s[0] < s[1]).count();
        let back = run.len() - forward;
        // Backward ones were sorted behind.
        let both = forward.min(back);
        kept.extend_from_slice(&run[both..run.len() - both]);
    }
    *border = kept;
}

/// A clipped triangle: up to four corners, those on the plane flagged.
#[derive(Default)]
struct Polygon {
    corners: [(u32, bool); 4],
    count: usize,
}

impl Polygon {
    fn push(&mut self, v: u32, on: bool) {
        if self.count < 4 {
            self.corners[self.count] = (v, on);
            self.count += 1;
        }
    }

    fn emit(&self, triangles: &mut Vec<[u32; 3]>, border: &mut Vec<[u32; 2]>) {
        let c = &self.corners[..self.count];
        for i in 2..self.count {
            triangles.push([c[0].0, c[i - 1].0, c[i].0]);
        }
        for i in 0..self.count {
            let (a, b) = (c[i], c[(i + 1) % self.count]);
            if a.1 && b.1 {
                border.push([b.0, a.0]);
            }
        }
    }
}

/// Divide a cap's border; the line in which both planes meet closes both
/// halves and becomes part of the new cap's border.
fn split_cap(
    whole: &Piece,
    cap: &Cap,
    plane: Plane,
    sides: &[i8],
    crossings: &Crossings,
    (below, above): (&mut Half, &mut Half),
    (border_below, border_above): (&mut Vec<[u32; 2]>, &mut Vec<[u32; 2]>),
) {
    let mut low = Vec::new();
    let mut high = Vec::new();
    // Where the border passes a line just below, and one just above, the line
    // of intersection: (position along it, +1 upwards / -1 downwards, vertex).
    let along = cap.plane.normal.cross(plane.normal);
    let (mut leave, mut enter): (Passages, Passages) = (Vec::new(), Vec::new());
    for &[a, b] in &cap.border {
        let (sa, sb) = (sides[a as usize], sides[b as usize]);
        if sa == 0 && sb == 0 {
            continue;
        }
        if sa * sb < 0 {
            let (l, h) = crossings.find(a, b);
            if sa < 0 {
                low.push([below.old(whole, a), l]);
                high.push([h, above.old(whole, b)]);
            } else {
                high.push([above.old(whole, a), h]);
                low.push([l, below.old(whole, b)]);
            }
            let position = along.dot(below.piece.points[l as usize]);
            leave.push((position, i32::from(sb), l));
            enter.push((position, i32::from(sb), h));
        } else {
            let half = if sa < 0 || sb < 0 {
                &mut *below
            } else {
                &mut *above
            };
            let segment = [half.old(whole, a), half.old(whole, b)];
            let (list, passages) = if sa < 0 || sb < 0 {
                (&mut low, &mut leave)
            } else {
                (&mut high, &mut enter)
            };
            list.push(segment);
            if sa == 0 {
                passages.push((
                    along.dot(whole.points[a as usize]),
                    i32::from(sb),
                    segment[0],
                ));
            } else if sb == 0 {
                passages.push((
                    along.dot(whole.points[b as usize]),
                    -i32::from(sa),
                    segment[1],
                ));
            }
        }
    }
    close(leave, 1, &mut low, border_below);
    close(enter, -1, &mut high, border_above);
    if !low.is_empty() {
        below.piece.caps.push(Cap {
            plane: cap.plane,
            border: low,
        });
    }
    if !high.is_empty() {
        above.piece.caps.push(Cap {
            plane: cap.plane,
            border: high,
        });
    }
}

/// (position along the line, direction, vertex).
type Passages = Vec<(f64, i32, u32)>;

/// Close a cap's border along the line, where the running sum says that the
/// region is inside; the new cap gets the same segments the other way round.
fn close(
    mut passages: Passages,
    sense: i32,
    border: &mut Vec<[u32; 2]>,
    other: &mut Vec<[u32; 2]>,
) {
    passages.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.2.cmp(&y.2)));
    let mut winding = 0;
    for pair in passages.windows(2) {
        winding += sense * pair[0].1;
        let (from, to) = if winding > 0 {
            (pair[0].2, pair[1].2)
        } else {
            (pair[1].2, pair[0].2)
        };
        if from != to {
            for _ in 0..winding.abs() {
                border.push([from, to]);
                other.push([to, from]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box [0,1]³ with a square hole [1/4,3/4]² through it along z.
    pub(crate) fn frame() -> Piece {
        let mut points = Vec::new();
        for z in [0.0, 1.0] {
            for (lo, hi) in [(0.0, 1.0), (0.25, 0.75)] {
                for (x, y) in [(lo, lo), (hi, lo), (hi, hi), (lo, hi)] {
                    points.push(DVec3::new(x, y, z));
                }
            }
        }
        let mut triangles = Vec::new();
        let mut quad = |a: u32, b: u32, c: u32, d: u32| {
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        };
        for i in 0..4 {
            let j = (i + 1) % 4;
            quad(i, j, j + 8, i + 8); // outer wall
            quad(j + 4, i + 4, i + 12, j + 12); // hole wall
            quad(j, i, i + 4, j + 4); // bottom
            quad(i + 8, j + 8, j + 12, i + 12); // top
        }
        Piece {
            points,
            triangles,
            caps: Vec::new(),
        }
    }

    fn plane(n: [f64; 3], offset: f64) -> Plane {
        Plane {
            normal: DVec3::from_array(n),
            offset,
        }
    }

    #[test]
    fn volumes_add_up_through_many_generations() {
        let whole = frame();
        assert!((whole.volume() - 0.75).abs() < 1e-12);
        let cuts = [
            plane([0.0, 0.0, 1.0], 0.4),
            plane([1.0, 0.0, 0.0], 0.5),
            plane([0.0, 1.0, 0.0], 0.25), // through faces of the hole
            plane([1.0, 0.5, 0.25], 0.6),
            plane([0.0, 0.0, 1.0], 0.2),
        ];
        let mut pieces = vec![whole];
        for cut in cuts {
            let mut next = Vec::new();
            for piece in &pieces {
                let (a, b) = piece.split(cut);
                assert!((a.volume() + b.volume() - piece.volume()).abs() < 1e-12);
                next.extend([a, b]);
            }
            pieces = next;
        }
        let sum: f64 = pieces.iter().map(Piece::volume).sum();
        assert!((sum - 0.75).abs() < 1e-12);
        assert!(pieces.iter().all(|p| p.volume() > -1e-12));
    }

    #[test]
    fn a_corner_inside_the_solid_is_kept() {
        let cube = {
            let (_, part) = frame().split(plane([1.0, 0.0, 0.0], 0.75));
            part // a solid wall [3/4,1]×[0,1]²
        };
        let (a, _) = cube.split(plane([0.0, 1.0, 0.0], 0.5));
        let (a, _) = a.split(plane([0.0, 0.0, 1.0], 0.5));
        let (a, _) = a.split(plane([1.0, 0.0, 0.0], 0.875));
        assert!((a.volume() - 0.125 * 0.25).abs() < 1e-12);
        let corner = DVec3::new(0.875, 0.5, 0.5);
        assert!(a.points.iter().any(|p| p.distance(corner) < 1e-12));
    }

    #[test]
    fn an_uneven_face_stays_whole_on_its_own_side() {
        // Turned, with noise as of single precision.
        let lower = frame();
        let turn = glam::DMat3::from_rotation_y(0.4) * glam::DMat3::from_rotation_x(0.7);
        let noise = |i: usize| 1e-7 * libm::sin(12.9 * i as f64 + 1.0);
        let noisy = Piece {
            points: lower
                .points
                .iter()
                .enumerate()
                .map(|(i, p)| turn * (*p + DVec3::splat(noise(i))))
                .collect(),
            ..lower
        };
        let normal = turn * DVec3::Z;
        let (below, above) = noisy.split(Plane {
            normal,
            offset: normal.dot(turn * DVec3::Z),
        });
        assert!((below.volume() - noisy.volume()).abs() < 1e-15);
        assert!(above.triangles.is_empty() && above.caps.is_empty());
        assert_eq!(below.points.len(), noisy.points.len());
        assert!(below.caps.is_empty());
    }

    #[test]
    fn a_cut_on_a_flat_face_leaves_that_face_to_its_own_side() {
        // The plane z = 1 touches the top from outside: nothing is above.
        let (below, above) = frame().split(plane([0.0, 0.0, 1.0], 1.0));
        assert!((below.volume() - 0.75).abs() < 1e-12);
        assert!(above.points.is_empty() && above.triangles.is_empty());
    }
}

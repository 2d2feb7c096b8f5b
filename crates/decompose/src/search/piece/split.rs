//! Cutting a piece by a plane: its triangles; its caps are cut by `border`.

use assetpipe_geometry::Plane;

use super::border::{cancel, split_cap};
use super::half::{Crossings, Half};
use super::{Cap, Piece};

/// Vertices this close to a plane that is along no axis are on it: the rounding of a height
/// (working copies have extent ~1). More would take from parts what no other part gets. Along the
/// axes coordinates are exact.
const ON: f64 = 512.0 * f64::EPSILON;

/// Side of a point: below, on or above a plane.
fn side(h: f64, on: f64) -> i8 {
    if h < -on {
        -1
    } else {
        i8::from(h > on)
    }
}

impl Piece {
    /// A crossing point an edge, made in a fixed order and added to both halves.
    fn cross(
        &self,
        plane: &Plane,
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
                    let [from, to] = [a, b].map(|v| self.points[v as usize]);
                    // What both ends share the point has too, and it is in the plane: or a later
                    // cut along a face would leave films of rounding.
                    let mut p = from + (to - from) * (ha / (ha - hb));
                    if let Some((axis, sense)) = plane.axis() {
                        p[axis] = plane.offset * sense;
                    }
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

        let crossings = self.cross(&plane, &heights, &sides, &mut below, &mut above);
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

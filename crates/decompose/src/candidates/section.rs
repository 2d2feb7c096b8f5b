//! Outlines of a piece's section by a plane.

use glam::{DVec2, DVec3};

use crate::search::piece::Piece;
use crate::search::sweep::Basis;

/// A corner of an outline and how the wall behind the edge that leaves it stands.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Coordinates along the basis' u and v.
    pub point: DVec2,
    /// Length of the wall normal's share in the section: 1 for a wall along the basis' w.
    pub upright: f64,
    /// Whether the edge that leaves this corner lies on the solid's surface, not on a cut.
    pub surface: bool,
}

/// A closed outline with the solid on its left.
pub type Outline = Vec<Corner>;

/// A piece edge, smaller vertex first: what neighbouring segments share.
type Edge = (u32, u32);

struct Segment {
    from: Edge,
    to: Edge,
    upright: f64,
    surface: bool,
}

/// Vertices so far below the plane still count as on it.
const ON: f64 = 1e-9;

/// The outlines of the section at height `h` along `basis.w`. Vertices on the plane count
/// as above it, so every outline closes.
pub fn outlines(piece: &Piece, basis: &Basis, h: f64) -> Vec<Outline> {
    let heights: Vec<f64> = piece.points.iter().map(|p| basis.w.dot(*p) - h).collect();
    let above = |v: u32| heights[v as usize] >= -ON;
    let mut segments: Vec<Segment> = Vec::new();
    for t in &piece.triangles {
        let up = t.map(above);
        if up[0] == up[1] && up[1] == up[2] {
            continue;
        }
        // Seen from outside with w upwards the outline runs to the right: from the edge that
        // goes down to the one that goes up.
        let (mut from, mut to) = ((0, 0), (0, 0));
        for i in 0..3 {
            let j = (i + 1) % 3;
            match (up[i], up[j]) {
                (true, false) => from = edge(t[i], t[j]),
                (false, true) => to = edge(t[i], t[j]),
                _ => {}
            }
        }
        let [a, b, c] = t.map(|v| piece.points[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        segments.push(Segment {
            from,
            to,
            upright: upright(normal, basis.w),
            surface: true,
        });
    }
    let at = |(a, b): Edge| {
        let (ha, hb) = (heights[a as usize], heights[b as usize]);
        let p = piece.points[a as usize]
            .lerp(piece.points[b as usize], (ha / (ha - hb)).clamp(0.0, 1.0));
        DVec2::new(basis.u.dot(p), basis.v.dot(p))
    };
    for cap in &piece.caps {
        let along = basis.w.cross(cap.plane.normal);
        let along = DVec2::new(basis.u.dot(along), basis.v.dot(along));
        let mut passages: Vec<(f64, Edge)> = cap
            .border
            .iter()
            .filter(|s| above(s[0]) != above(s[1]))
            .map(|s| {
                let e = edge(s[0], s[1]);
                (along.dot(at(e)), e)
            })
            .collect();
        passages.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for pair in passages.chunks_exact(2) {
            segments.push(Segment {
                from: pair[0].1,
                to: pair[1].1,
                upright: 1.0,
                surface: false,
            });
        }
    }
    segments.sort_by_key(|s| (s.from, s.to));
    follow(&segments, at)
}

fn edge(a: u32, b: u32) -> Edge {
    (a.min(b), a.max(b))
}

fn upright(normal: DVec3, w: DVec3) -> f64 {
    let along = normal.dot(w);
    (1.0 - along * along).max(0.0).sqrt()
}

/// Points closer than this are one; working copies have extent ~1.
const SAME: f64 = 1e-7;

fn apart(a: DVec2, b: DVec2) -> bool {
    a.distance_squared(b) > SAME * SAME
}

/// String segments, sorted by their start, to closed outlines.
fn follow(segments: &[Segment], at: impl Fn(Edge) -> DVec2) -> Vec<Outline> {
    let mut used = vec![false; segments.len()];
    let mut found = Vec::new();
    for start in 0..segments.len() {
        if used[start] {
            continue;
        }
        let mut outline = Outline::new();
        let mut next = Some(start);
        while let Some(i) = next {
            used[i] = true;
            let s = &segments[i];
            let point = at(s.from);
            // Edges that meet in a vertex on the plane give one point several times.
            if outline
                .last()
                .is_none_or(|c: &Corner| apart(c.point, point))
            {
                outline.push(Corner {
                    point,
                    upright: s.upright,
                    surface: s.surface,
                });
            }
            let first = segments.partition_point(|o| o.from < s.to);
            next = (first..segments.len())
                .take_while(|&j| segments[j].from == s.to)
                .find(|&j| !used[j]);
        }
        while outline.len() > 1 && !apart(outline[0].point, outline[outline.len() - 1].point) {
            outline.pop();
        }
        if outline.len() >= 3 {
            found.push(outline);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;
    use assetpipe_geometry::Plane;

    fn area(outline: &Outline) -> f64 {
        (0..outline.len())
            .map(|i| {
                let (a, b) = (outline[i].point, outline[(i + 1) % outline.len()].point);
                0.5 * a.perp_dot(b)
            })
            .sum()
    }

    #[test]
    fn sections_of_a_cut_cube_close_over_caps() {
        let corners: Vec<DVec3> = (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let cube = Piece::from(&convex_hull(&corners).unwrap());
        let (below, above) = cube.split(Plane {
            normal: DVec3::new(1.0, 1.0, 0.0),
            offset: 0.5,
        });
        for (piece, expected) in [(&cube, 1.0), (&below, 0.125), (&above, 0.875)] {
            let found = outlines(piece, &Basis::axis(2), 0.4);
            assert_eq!(found.len(), 1);
            assert!((area(&found[0]) - expected).abs() < 1e-12);
        }
        let cut = outlines(&below, &Basis::axis(2), 0.4);
        assert_eq!(cut[0].iter().filter(|c| !c.surface).count(), 1);
    }
}

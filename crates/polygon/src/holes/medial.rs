//! Antipodal pair by the medial axis (§5.2.2), approximated by the chordal
//! axis (Prasad 1997): midpoints of the inner edges of the hole's constrained
//! Delaunay triangles, joined through the triangles' centroids where three
//! meet. Like the medial axis of a simple polygon it is a tree.

use spade::Triangulation as _;

use crate::arrangement::{handle, index, Arrangement, Edge};
use crate::boundary::Boundary;
use crate::Point;

/// The two corners at the ends of the longest path of the axis. `None` if the
/// hole's triangles are not found (they always are for a simple hole).
pub(super) fn ends(
    arrangement: &Arrangement,
    boundary: &Boundary,
    ring: &[u32],
) -> Option<[u32; 2]> {
    let cdt = &arrangement.cdt;
    let corner = ring[0];
    let [u, v] = [corner, boundary.next(corner)].map(|c| handle(boundary.vertex[c as usize]));
    let inside = cdt.get_edge_from_neighbors(u, v)?.rev();
    let (_, first) = farthest_tip(inside)?;
    let (_, second) = farthest_tip(first)?;
    let corner_of = |tip: Edge<'_>| {
        let vertex = index(tip.from().fix());
        ring.iter()
            .copied()
            .find(|&c| boundary.vertex[c as usize] == vertex)
    };
    Some([corner_of(first)?, corner_of(second)?])
}

fn place(edge: Edge<'_>) -> Point {
    let p = edge.from().position();
    Point::new(p.x, p.y)
}

fn middle(edge: Edge<'_>) -> Point {
    let (a, b) = (place(edge), place(edge.next()));
    Point::new(f64::midpoint(a.x, b.x), f64::midpoint(a.y, b.y))
}

/// Walks the axis from the triangle left of `start`, from the origin of
/// `start`; returns the path length to the farthest tip and the edge that
/// leaves it. A tip is a vertex between two boundary edges of one triangle.
fn farthest_tip(start: Edge<'_>) -> Option<(f64, Edge<'_>)> {
    let mut best: Option<(f64, Edge<'_>)> = None;
    let mut reach = |length: f64, tip| {
        if best.is_none_or(|b| length > b.0) {
            best = Some((length, tip));
        }
    };
    let mut seen = std::collections::BTreeSet::from([start.face().fix().index()]);
    let mut stack = Vec::new();
    let origin = place(start);
    let sides = [start, start.next(), start.prev()];
    if sides.iter().all(|e| e.is_constraint_edge()) {
        for side in &sides[1..] {
            reach(origin.distance(place(*side)), *side);
        }
    }
    for side in sides {
        if !side.is_constraint_edge() {
            stack.push((side, origin.distance(middle(side))));
        }
    }
    while let Some((door, length)) = stack.pop() {
        let entry = door.rev();
        if !seen.insert(entry.face().fix().index()) {
            continue;
        }
        let open: Vec<_> = [entry.next(), entry.prev()]
            .into_iter()
            .filter(|e| !e.is_constraint_edge())
            .collect();
        let from = middle(entry);
        match open[..] {
            [] => {
                let tip = entry.prev();
                reach(length + from.distance(place(tip)), tip);
            }
            [out] => stack.push((out, length + from.distance(middle(out)))),
            _ => {
                let corners = [entry, entry.next(), entry.prev()].map(place);
                let centre = Point::new(
                    corners.iter().map(|p| p.x).sum::<f64>() / 3.0,
                    corners.iter().map(|p| p.y).sum::<f64>() / 3.0,
                );
                for out in open {
                    let through = from.distance(centre) + centre.distance(middle(out));
                    stack.push((out, length + through));
                }
            }
        }
    }
    best
}

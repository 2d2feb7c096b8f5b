//! From rings of points to a sound domain: even-odd interior, constrained
//! triangulation, boundaries as walks with the interior on the left.
//!
//! Duplicate vertices, collinear runs, spikes, rings that touch each other or
//! themselves are all settled here, once and exactly, so that nothing after
//! this file has to know of them.

use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

use crate::point::orient;
use crate::{OutlineError, Point};

/// Constrained Delaunay triangulation over all vertices; constraint edges are
/// the boundary and, later, the diagonals that cut it.
pub(crate) type Triangulation = ConstrainedDelaunayTriangulation<Point2<f64>>;
pub(crate) type Edge<'a> = DirectedEdgeHandle<'a, Point2<f64>, (), spade::CdtEdge<()>, ()>;

/// A connected open piece of the interior, by its boundary walks.
pub(crate) struct Component {
    /// Vertices of the outer boundary, interior on the left.
    pub outer: Vec<u32>,
    /// Vertices of the hole boundaries, interior on the left.
    pub holes: Vec<Vec<u32>>,
}

/// The whole outline.
pub(crate) struct Arrangement {
    pub points: Vec<Point>,
    pub cdt: Triangulation,
    pub components: Vec<Component>,
}

pub(crate) fn handle(vertex: u32) -> FixedVertexHandle {
    FixedVertexHandle::from_index(vertex as usize)
}

pub(crate) fn index(vertex: FixedVertexHandle) -> u32 {
    vertex.index() as u32
}

/// Builds the arrangement of `rings` under the even-odd rule.
pub(crate) fn arrange(rings: &[Vec<Point>]) -> Result<Arrangement, OutlineError> {
    let total: usize = rings.iter().map(Vec::len).sum();
    if total > 1 << 30 {
        return Err(OutlineError::TooLarge(total));
    }
    for (ring, points) in rings.iter().enumerate() {
        if let Some(vertex) = points.iter().position(|p| !usable(p.x) || !usable(p.y)) {
            return Err(OutlineError::Coordinate { ring, vertex });
        }
    }
    let rings: Vec<Vec<Point>> = rings.iter().map(|ring| essential(ring)).collect();
    let (points, rings) = numbered(&rings);
    if rings.iter().all(Vec::is_empty) {
        return Err(OutlineError::NoArea);
    }
    let cdt = constrained(&points, &rings)?;
    let components = components(&points, &cdt);
    if components.is_empty() {
        return Err(OutlineError::NoArea);
    }
    Ok(Arrangement {
        points,
        cdt,
        components,
    })
}

/// Whether products of differences of such numbers neither over- nor underflow.
fn usable(x: f64) -> bool {
    x.is_finite() && x.abs() < 1e100 && (x == 0.0 || x.abs() > 1e-142)
}

/// The ring without repeated and exactly collinear vertices; spikes, which
/// are collinear too, vanish with them. Empty when no area is left.
fn essential(ring: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::with_capacity(ring.len());
    for &q in ring {
        // -0.0 and 0.0 are one place and must be one vertex
        push_essential(&mut kept, Point::new(q.x + 0.0, q.y + 0.0));
    }
    // the seam between last and first
    let mut first = 0;
    loop {
        let n = kept.len();
        if n < first + 3 {
            return Vec::new();
        }
        if kept[n - 1] == kept[first] || orient(kept[n - 2], kept[n - 1], kept[first]) == 0.0 {
            kept.pop();
        } else if orient(kept[n - 1], kept[first], kept[first + 1]) == 0.0 {
            first += 1;
        } else {
            return kept.split_off(first);
        }
    }
}

fn push_essential(kept: &mut Vec<Point>, q: Point) {
    while let [.., a, b] = kept[..] {
        if b == q || orient(a, b, q) == 0.0 {
            kept.pop();
        } else {
            break;
        }
    }
    if kept.last() != Some(&q) {
        kept.push(q);
    }
}

/// Distinct points in lexicographic order, and the rings as their indices.
fn numbered(rings: &[Vec<Point>]) -> (Vec<Point>, Vec<Vec<u32>>) {
    let mut points: Vec<Point> = rings.iter().flatten().copied().collect();
    let order = |a: &Point, b: &Point| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y));
    points.sort_unstable_by(order);
    points.dedup();
    let number = |q: &Point| points.binary_search_by(|p| order(p, q)).unwrap_or(0) as u32;
    let rings = rings
        .iter()
        .map(|ring| ring.iter().map(number).collect())
        .collect();
    (points, rings)
}

/// Triangulates with every ring edge as a constraint. Edges that lie on an
/// even number of rings bound nothing and are let go again.
fn constrained(points: &[Point], rings: &[Vec<u32>]) -> Result<Triangulation, OutlineError> {
    let sites = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let mut cdt =
        Triangulation::bulk_load_cdt(sites, Vec::new()).map_err(|_| OutlineError::NoArea)?;
    let mut odd = vec![false; cdt.num_undirected_edges()];
    for (number, ring) in rings.iter().enumerate() {
        for (k, &from) in ring.iter().enumerate() {
            let to = ring[(k + 1) % ring.len()];
            let edges = cdt.try_add_constraint(handle(from), handle(to));
            if edges.is_empty() {
                return Err(crossing(&cdt, points, number, from, to));
            }
            for edge in edges {
                let bit = &mut odd[edge.as_undirected().index()];
                *bit = !*bit;
            }
        }
    }
    let even: Vec<_> = cdt
        .fixed_undirected_edges()
        .filter(|edge| cdt.is_constraint_edge(*edge) && !odd[edge.index()])
        .collect();
    for edge in even {
        cdt.remove_constraint_edge(edge);
    }
    Ok(cdt)
}

fn crossing(
    cdt: &Triangulation,
    points: &[Point],
    ring: usize,
    from: u32,
    to: u32,
) -> OutlineError {
    let edge = [points[from as usize], points[to as usize]];
    let other = cdt
        .get_conflicting_edges_between_vertices(handle(from), handle(to))
        .next()
        .map_or(edge, |e| e.vertices().map(|v| points[v.fix().index()]));
    OutlineError::Crossing { ring, edge, other }
}

/// Floods the triangulation from outside, then walks every boundary.
fn components(points: &[Point], cdt: &Triangulation) -> Vec<Component> {
    const OUTSIDE: u32 = u32::MAX;
    const UNSEEN: u32 = u32::MAX - 1;
    let mut label = vec![UNSEEN; cdt.num_all_faces()];
    label[cdt.outer_face().fix().index()] = OUTSIDE;
    // alternate: everything reachable without crossing a boundary, then one step across
    let mut frontier: Vec<(Edge<'_>, bool)> = cdt.convex_hull().map(|edge| (edge, false)).collect();
    let mut count = 0;
    while let Some((near, near_inside)) = frontier.pop() {
        let face = near.rev().face();
        if label[face.fix().index()] != UNSEEN {
            continue;
        }
        let inside = near_inside != near.is_constraint_edge();
        let name = if inside { count } else { OUTSIDE };
        count += u32::from(inside);
        label[face.fix().index()] = name;
        let mut stack = vec![near.rev()];
        while let Some(entry) = stack.pop() {
            for edge in [entry, entry.next(), entry.prev()] {
                let beyond = edge.rev().face().fix().index();
                if label[beyond] != UNSEEN {
                    continue;
                }
                if edge.is_constraint_edge() {
                    frontier.push((edge, inside));
                } else {
                    label[beyond] = name;
                    stack.push(edge.rev());
                }
            }
        }
    }

    let mut found: Vec<Component> = (0..count)
        .map(|_| Component {
            outer: Vec::new(),
            holes: Vec::new(),
        })
        .collect();
    let mut walked = vec![false; cdt.num_directed_edges()];
    for edge in cdt.directed_edges() {
        let name = label[edge.face().fix().index()];
        if !edge.is_constraint_edge() || name >= UNSEEN || walked[edge.fix().index()] {
            continue;
        }
        let ring = walk(edge, &mut walked);
        let component = &mut found[name as usize];
        if bounds_outside(points, &ring) {
            component.outer = ring;
        } else {
            component.holes.push(ring);
        }
    }
    found
}

/// The closed boundary walk through `start`: at every vertex on to the next
/// constraint edge of the same interior corner.
fn walk(start: Edge<'_>, walked: &mut [bool]) -> Vec<u32> {
    let mut ring = Vec::new();
    let mut edge = start;
    loop {
        walked[edge.fix().index()] = true;
        ring.push(index(edge.from().fix()));
        edge = edge.next();
        while !edge.is_constraint_edge() {
            edge = edge.rev().next();
        }
        if edge.fix() == start.fix() {
            return ring;
        }
    }
}

/// Whether the ring, interior on its left, is an outer boundary: at its
/// lexicographic minimum a hole has a reflex corner, an outer boundary none.
pub(crate) fn bounds_outside(points: &[Point], ring: &[u32]) -> bool {
    let Some(&low) = ring.iter().min_by(|&&a, &&b| {
        let (p, q) = (points[a as usize], points[b as usize]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
    }) else {
        return false;
    };
    let n = ring.len();
    let at = |k: usize| points[ring[k % n] as usize];
    (0..n)
        .filter(|&k| ring[k] == low)
        .all(|k| orient(at(k + n - 1), at(k), at(k + 1)) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn duplicates_spikes_and_collinear_runs_vanish() {
        let square = ring(&[
            (0., 0.),
            (1., 0.),
            (1., 0.),
            (2., 0.),
            (5., 0.),
            (2., 0.),
            (2., 2.),
            (0., 2.),
            (0., 1.),
            (0., 0.),
        ]);
        let found = arrange(&[square]).unwrap();
        assert_eq!(found.components.len(), 1);
        assert_eq!(found.components[0].outer.len(), 4);
    }

    #[test]
    fn a_touching_hole_becomes_part_of_the_outer_walk() {
        let outer = ring(&[(0., 0.), (4., 0.), (4., 4.), (0., 4.)]);
        let hole = ring(&[(2., 0.), (3., 2.), (1., 2.)]);
        let found = arrange(&[outer, hole]).unwrap();
        assert_eq!(found.components.len(), 1);
        assert!(found.components[0].holes.is_empty());
        assert_eq!(found.components[0].outer.len(), 8);
    }

    #[test]
    fn an_island_in_a_hole_is_a_component_of_its_own() {
        let frame = |a: f64, b: f64| ring(&[(a, a), (b, a), (b, b), (a, b)]);
        let found = arrange(&[frame(0., 9.), frame(1., 8.), frame(3., 5.)]).unwrap();
        assert_eq!(found.components.len(), 2);
        let holes: usize = found.components.iter().map(|c| c.holes.len()).sum();
        assert_eq!(holes, 1);
    }

    #[test]
    fn crossing_edges_are_told_apart_from_touching_ones() {
        let bow = ring(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.)]);
        assert!(matches!(
            arrange(&[bow]),
            Err(OutlineError::Crossing { .. })
        ));
        let touching = ring(&[(0., 0.), (2., 0.), (1., 1.), (2., 2.), (0., 2.), (1., 1.)]);
        assert_eq!(arrange(&[touching]).unwrap().components.len(), 2);
    }
}

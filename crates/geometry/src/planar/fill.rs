//! Triangles that a cycle bounds.

use std::collections::BTreeMap;

use glam::DVec2;

use super::constraint::Obstacle;
use super::crossing::{compare, Crossings};
use super::delaunay::Triangulation;

/// A directed boundary edge: start, end, multiplicity.
pub type Edge = (u32, u32, i32);

/// The region inside a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filling {
    /// Points made where boundary edges cross; numbered after the given points.
    pub crossings: Vec<DVec2>,
    /// Triangles whose directed edges add up to the (subdivided) boundary.
    pub triangles: Vec<[u32; 3]>,
    /// Boundary edges (lesser index first) that run through another point,
    /// with that point; the two halves may be subdivided again.
    pub subdivided: BTreeMap<(u32, u32), u32>,
    /// Whether the triangles overlap: the last resort, a fan from one point,
    /// bounds the same cycle and the same signed area.
    pub is_fan: bool,
}

/// How often crossings may be added before the fan is taken.
const ROUNDS: u32 = 40;

/// Fills the region that the cycle `edges` winds around counter-clockwise.
///
/// `points` must be finite and distinct; every point must start as many
/// `edges` as it ends (counted with multiplicity). Points that no edge uses
/// are ignored. Triangles are counter-clockwise and constrained Delaunay;
/// where the cycle winds `w` times a triangle is repeated `w` times, where it
/// winds clockwise it is reversed. O(n log n) unless many edges cross.
pub fn fill(points: &[DVec2], edges: &[Edge]) -> Filling {
    let mut all = points.to_vec();
    let mut subdivided = BTreeMap::new();
    for round in 0..ROUNDS {
        match attempt(&all, edges, &mut subdivided, round) {
            Outcome::Filled(triangles) => {
                let crossings = all.split_off(points.len());
                return Filling {
                    crossings,
                    triangles,
                    subdivided,
                    is_fan: false,
                };
            }
            Outcome::Again(crossings) => all.extend(crossings),
            Outcome::Stuck => break,
        }
    }
    Filling {
        triangles: fan(edges),
        is_fan: true,
        ..Filling::default()
    }
}

/// How an attempt ended.
enum Outcome {
    /// With the triangles of the region.
    Filled(Vec<[u32; 3]>),
    /// Boundary edges cross; they have been subdivided at these further points.
    Again(Vec<DVec2>),
    /// The points are not finite or not distinct.
    Stuck,
}

/// Triangulates with the points there are, or finds the crossings that are missing.
fn attempt(
    points: &[DVec2],
    edges: &[Edge],
    subdivided: &mut BTreeMap<(u32, u32), u32>,
    round: u32,
) -> Outcome {
    let order = sorted(points, edges, subdivided);
    if !order.iter().all(|p| points[*p as usize].is_finite()) {
        return Outcome::Stuck;
    }
    if order
        .windows(2)
        .any(|w| points[w[0] as usize] == points[w[1] as usize])
    {
        return Outcome::Stuck;
    }
    let mut mesh = Triangulation::new(points, &order);
    let mut crossings = Crossings::new(points, &order, round);
    let mut complete = true;
    let mut turned = Vec::new();
    let mut stack = Vec::new();
    for &edge in edges {
        stack.push(edge);
        while let Some((a, b, weight)) = stack.pop() {
            if let Some(&via) = subdivided.get(&key(a, b)) {
                if (via as usize) < points.len() {
                    stack.extend([(via, b, weight), (a, via, weight)]);
                } else {
                    complete = false;
                }
                continue;
            }
            match mesh.force(a, b, weight, &mut turned) {
                Ok(()) => {}
                Err(Obstacle::Point(via)) => {
                    subdivided.insert(key(a, b), via);
                    stack.extend([(via, b, weight), (a, via, weight)]);
                }
                Err(Obstacle::Edge(c, d)) => {
                    complete = false;
                    let via = crossings.between([a, b], [c, d]);
                    for (p, q) in [(a, b), (c, d)] {
                        if via != p && via != q {
                            subdivided.entry(key(p, q)).or_insert(via);
                        }
                    }
                }
                Err(Obstacle::Stuck) => return Outcome::Stuck,
            }
        }
    }
    if complete {
        mesh.legalise(turned);
        Outcome::Filled(wound(&mesh))
    } else {
        Outcome::Again(crossings.into_added())
    }
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// The points that edges use, ascending by (x, y).
fn sorted(points: &[DVec2], edges: &[Edge], subdivided: &BTreeMap<(u32, u32), u32>) -> Vec<u32> {
    let mut used = vec![false; points.len()];
    let ends = edges.iter().flat_map(|&(a, b, _)| [a, b]);
    for point in ends.chain(subdivided.values().copied()) {
        used[point as usize] = true;
    }
    let mut order: Vec<u32> = (0..points.len() as u32)
        .filter(|p| used[*p as usize])
        .collect();
    order.sort_unstable_by(|&a, &b| compare(points[a as usize], points[b as usize]));
    order
}

/// The triangles around which the weighted edges wind, by flooding from outside.
fn wound(mesh: &Triangulation) -> Vec<[u32; 3]> {
    let outer = mesh.outer();
    let mut winding: Vec<Option<i32>> = outer
        .iter()
        .map(|&is_outer| is_outer.then_some(0))
        .collect();
    let mut queue: Vec<u32> = mesh.edges().filter(|&e| outer[e as usize]).collect();
    let mut triangles = Vec::new();
    while let Some(edge) = queue.pop() {
        let Some(left) = winding[edge as usize] else {
            continue;
        };
        let first = edge ^ 1;
        if winding[first as usize].is_some() {
            continue;
        }
        let times = left - mesh.weight[edge as usize];
        let second = mesh.along(first);
        let third = mesh.along(second);
        for half in [first, second, third] {
            winding[half as usize] = Some(times);
            queue.push(half);
        }
        let [a, b, c] = [first, second, third].map(|half| mesh.origin(half));
        let triangle = if times > 0 { [a, b, c] } else { [a, c, b] };
        triangles.extend((0..times.abs()).map(|_| triangle));
    }
    triangles.sort_unstable();
    triangles
}

/// A cone from one point over all edges: bounds the cycle, may overlap.
fn fan(edges: &[Edge]) -> Vec<[u32; 3]> {
    let Some(&(hub, ..)) = edges.first() else {
        return Vec::new();
    };
    edges
        .iter()
        .filter(|(a, b, _)| *a != hub && *b != hub)
        .flat_map(|&(a, b, times)| {
            let triangle = if times > 0 { [hub, a, b] } else { [hub, b, a] };
            (0..times.abs()).map(move |_| triangle)
        })
        .collect()
}

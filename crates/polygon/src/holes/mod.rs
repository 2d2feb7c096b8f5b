//! Holes (Lien & Amato 2006, §5.2): antipodal pairs, the diagonal that ties
//! each hole to its neighbour, and the concavity of Eq. 5.

mod medial;
mod principal;

use crate::arrangement::{handle, index, Arrangement};
use crate::boundary::Boundary;
use crate::concavity::Loops;
use crate::geodesic;
use crate::visibility;
use spade::Triangulation as _;

/// How the antipodal pair of a hole is found (§5.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoleAxis {
    /// Extremes along the principal axis; distances in straight lines.
    Principal,
    /// Ends of the longest path on the hole's medial axis; distances within
    /// the hole. The axis is the chordal axis of the hole's constrained
    /// Delaunay triangulation, which approximates it.
    Medial,
}

/// The ring number of the outer boundary.
pub(crate) const OUTER: u32 = 0;

/// A hole and the diagonal by which it will be merged.
pub(crate) struct Hole {
    /// Its corners.
    pub ring: Vec<u32>,
    /// Corner of the hole at which the diagonal starts (`p` in Eq. 5).
    pub from: u32,
    /// Corner at which it ends (`x` in Eq. 5), on the outer boundary or another hole.
    pub to: u32,
    /// `dist(x, p) + dist(p, cw(p))`: Eq. 5 without the depth of `x` and without δ.
    pub extent: f64,
    /// Ring number of `to`: 0 is the outer boundary, `h + 1` is hole `h`.
    pub parent: u32,
}

#[derive(Clone, Copy)]
struct Link {
    length: f64,
    from: u32,
    to: u32,
}

/// Ties every hole to its nearest visible neighbour, such that all hang
/// together with the outer boundary. `rings` are the corners of the holes.
///
/// The paper takes the nearest vertex and says that nothing can lie between;
/// a long edge can, so nearest here is nearest *visible*. Where two holes are
/// each other's nearest, the shortest triangulation edges close the gap.
pub(crate) fn tie(
    arrangement: &Arrangement,
    boundary: &Boundary,
    rings: Vec<Vec<u32>>,
    axis: HoleAxis,
) -> Vec<Hole> {
    let mut ring_of = vec![OUTER; boundary.vertex.len()];
    for (h, ring) in rings.iter().enumerate() {
        for &corner in ring {
            ring_of[corner as usize] = h as u32 + 1;
        }
    }
    let mut loops = Loops::new(boundary.points.len());
    let mut links: Vec<Link> = rings
        .iter()
        .filter_map(|ring| {
            let ends = antipodal(arrangement, boundary, ring, axis, &mut loops);
            ends.iter()
                .filter_map(|&end| {
                    nearest(arrangement, boundary, end, |c| {
                        ring_of[c as usize] != ring_of[end as usize]
                    })
                })
                .min_by(|a, b| a.length.total_cmp(&b.length).then(a.from.cmp(&b.from)))
        })
        .collect();
    let by_length = |a: &Link, b: &Link| {
        a.length
            .total_cmp(&b.length)
            .then(a.from.cmp(&b.from))
            .then(a.to.cmp(&b.to))
    };
    links.sort_by(by_length);
    let mut bridges = crossing_edges(arrangement, boundary, &ring_of);
    bridges.sort_by(by_length);
    links.extend(bridges);
    let tree = spanning_tree(rings.len(), &links, &ring_of);
    tree.into_iter()
        .zip(rings)
        .map(|(link, ring)| {
            let reach = farthest(boundary, &ring, link.from, axis, &mut loops);
            Hole {
                from: link.from,
                to: link.to,
                extent: link.length + reach,
                parent: ring_of[link.to as usize],
                ring,
            }
        })
        .collect()
}

/// The nearest visible corner that `wanted` accepts.
fn nearest(
    arrangement: &Arrangement,
    boundary: &Boundary,
    from: u32,
    wanted: impl Fn(u32) -> bool,
) -> Option<Link> {
    let eye = boundary.point(from);
    let mut best: Option<Link> = None;
    visibility::from_corner(
        &arrangement.cdt,
        boundary,
        from,
        |_, _| true,
        |vertex, length| {
            let limit = best.map_or(f64::INFINITY, |b| b.length);
            if length > limit {
                return limit;
            }
            if let Some(to) = boundary.facing(vertex, eye).filter(|&c| wanted(c)) {
                let closer = best.is_none_or(|b| {
                    (length, boundary.vertex[to as usize])
                        < (b.length, boundary.vertex[b.to as usize])
                });
                if closer {
                    best = Some(Link { length, from, to });
                }
            }
            best.map_or(f64::INFINITY, |b| b.length)
        },
    );
    best
}

/// The nearest visible corner over all corners of a hole: the way out when a
/// diagonal laid meanwhile blocks the one that was planned.
pub(crate) fn detour(
    arrangement: &Arrangement,
    boundary: &Boundary,
    ring: &[u32],
    wanted: impl Fn(u32) -> bool,
) -> Option<(u32, u32)> {
    ring.iter()
        .filter_map(|&corner| nearest(arrangement, boundary, corner, &wanted))
        .min_by(|a, b| a.length.total_cmp(&b.length).then(a.from.cmp(&b.from)))
        .map(|link| (link.from, link.to))
}

/// Inner triangulation edges between different rings.
fn crossing_edges(arrangement: &Arrangement, boundary: &Boundary, ring_of: &[u32]) -> Vec<Link> {
    let mut found = Vec::new();
    for edge in arrangement.cdt.undirected_edges() {
        if edge.is_constraint_edge() {
            continue;
        }
        let [u, v] = edge.vertices().map(|v| index(v.fix()));
        let (p, q) = (boundary.points[u as usize], boundary.points[v as usize]);
        if let (Some(a), Some(b)) = (boundary.facing(u, q), boundary.facing(v, p)) {
            if ring_of[a as usize] != ring_of[b as usize] {
                found.push(Link {
                    length: p.distance(q),
                    from: a,
                    to: b,
                });
            }
        }
    }
    found
}

fn group_of(group: &mut [usize], mut k: usize) -> usize {
    while group[k] != k {
        group[k] = group[group[k]];
        k = group[k];
    }
    k
}

/// Per hole, the link towards the outer boundary in the tree that takes the
/// given links in order (Kruskal).
fn spanning_tree(holes: usize, links: &[Link], ring_of: &[u32]) -> Vec<Link> {
    let mut group: Vec<usize> = (0..=holes).collect();
    let mut adjacent: Vec<Vec<Link>> = vec![Vec::new(); holes + 1];
    for link in links {
        let ends = [link.from, link.to].map(|c| ring_of[c as usize] as usize);
        let [a, b] = ends.map(|k| group_of(&mut group, k));
        if a != b {
            group[a] = b;
            adjacent[ends[0]].push(*link);
            adjacent[ends[1]].push(Link {
                from: link.to,
                to: link.from,
                ..*link
            });
        }
    }
    let mut parent: Vec<Option<Link>> = vec![None; holes + 1];
    let mut stack = vec![0];
    while let Some(ring) = stack.pop() {
        for link in &adjacent[ring] {
            let child = ring_of[link.to as usize] as usize;
            if child != 0 && parent[child].is_none() {
                parent[child] = Some(Link {
                    from: link.to,
                    to: link.from,
                    ..*link
                });
                stack.push(child);
            }
        }
    }
    parent.into_iter().skip(1).flatten().collect()
}

/// Two corners of the hole that stand for its diameter (§5.2.2).
fn antipodal(
    arrangement: &Arrangement,
    boundary: &Boundary,
    ring: &[u32],
    axis: HoleAxis,
    loops: &mut Loops,
) -> [u32; 2] {
    if axis == HoleAxis::Medial && is_simple(boundary, ring, loops) {
        if let Some(ends) = medial::ends(arrangement, boundary, ring) {
            return ends;
        }
    }
    principal::ends(boundary, ring)
}

/// A hole that touches itself or another hole is no simple polygon.
fn is_simple(boundary: &Boundary, ring: &[u32], loops: &mut Loops) -> bool {
    let vertices: Vec<u32> = ring.iter().map(|&c| boundary.vertex[c as usize]).collect();
    loops.split(&vertices).2.is_empty()
}

/// `dist(p, cw(p))`: how far the hole's farthest point is from `p`.
fn farthest(boundary: &Boundary, ring: &[u32], p: u32, axis: HoleAxis, loops: &mut Loops) -> f64 {
    if axis == HoleAxis::Medial && is_simple(boundary, ring, loops) {
        let start = ring.iter().position(|&c| c == p).unwrap_or(0);
        // the hole lies right of its walk: backwards it is counter-clockwise
        let n = ring.len();
        let polygon: Vec<_> = (0..n)
            .map(|k| boundary.point(ring[(start + n - k) % n]))
            .collect();
        return geodesic::from_first_vertex(&polygon)
            .into_iter()
            .fold(0.0, f64::max);
    }
    let eye = boundary.point(p);
    ring.iter()
        .map(|&c| eye.distance(boundary.point(c)))
        .fold(0.0, f64::max)
}

/// Whether the segment between two corners is still free of constraints.
pub(crate) fn is_free(arrangement: &Arrangement, boundary: &Boundary, a: u32, b: u32) -> bool {
    let [u, v] = [a, b].map(|c| boundary.vertex[c as usize]);
    let (p, q) = (boundary.points[u as usize], boundary.points[v as usize]);
    arrangement.cdt.can_add_constraint(handle(u), handle(v))
        && boundary.facing(u, q) == Some(a)
        && boundary.facing(v, p) == Some(b)
}

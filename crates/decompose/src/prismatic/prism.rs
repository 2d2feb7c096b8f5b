//! Whether a solid is an extruded outline, corner by corner.

use std::collections::BTreeMap;

use assetpipe_geometry::Mesh;
use assetpipe_polygon::Point;

/// A prism: two plane ends whose corners belong to each other one to one.
pub struct Prism {
    /// The axis along which it is extruded.
    pub axis: usize,
    /// Positions of its two ends on the axis.
    pub ends: [f64; 2],
    /// The lower end's border as rings; the interior is even-odd.
    pub rings: Vec<Vec<Point>>,
    /// Corner of the upper end above each corner of the lower end.
    pub above: BTreeMap<u32, u32>,
    /// Lower corner that follows each in its ring, interior on the left seen from above.
    pub next: BTreeMap<u32, u32>,
    /// The wall's triangles by the lower corner where their edge begins.
    pub walls: BTreeMap<u32, Vec<[u32; 3]>>,
    /// Lower corners by position, sorted.
    corners: Vec<((u64, u64), u32)>,
}

impl Prism {
    /// The lower corner at a point of the plane.
    pub fn corner(&self, p: Point) -> Option<u32> {
        let key = bits(p);
        let at = self.corners.binary_search_by(|c| c.0.cmp(&key)).ok()?;
        Some(self.corners[at].1)
    }
}

fn bits(p: Point) -> (u64, u64) {
    ((p.x + 0.0).to_bits(), (p.y + 0.0).to_bits())
}

/// A vertex in the plane across an axis, so that (x, y, axis) is right-handed.
pub fn flat(mesh: &Mesh, vertex: u32, axis: usize) -> Point {
    let p = mesh.vertices[vertex as usize];
    Point::new(p[(axis + 1) % 3] + 0.0, p[(axis + 2) % 3] + 0.0)
}

/// Recognise a prism along a coordinate axis: every vertex on one of two
/// planes, exactly, every triangle in one of them or on a wall between an
/// edge below and the edge above it, which lie within `oblique` of each other.
pub fn detect(mesh: &Mesh, axis: usize, oblique: f64) -> Option<Prism> {
    let height = |v: u32| mesh.vertices[v as usize][axis];
    let used = mesh.triangles.iter().flatten();
    let (low, high) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| {
        (low.min(height(v)), high.max(height(v)))
    });
    let is_low = |v: u32| height(v) == low;
    let is_end = |v: u32| is_low(v) || height(v) == high;
    if !(high > low && mesh.triangles.iter().flatten().all(|&v| is_end(v))) {
        return None;
    }
    // Walls: two corners at one end and one at the other.
    let mut edges: Vec<(u32, u32)> = Vec::new();
    let mut uprights: BTreeMap<u32, u32> = BTreeMap::new();
    let mut walls: Vec<[u32; 3]> = Vec::new();
    for t in &mesh.triangles {
        let lower = t.iter().filter(|&&v| is_low(v)).count();
        if lower == 0 || lower == 3 {
            continue;
        }
        walls.push(*t);
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if is_low(a) && is_low(b) {
                // Outward triangles run along the lower border with the interior on the left.
                edges.push((a, b));
            }
        }
    }
    let mut next = BTreeMap::new();
    let mut previous = BTreeMap::new();
    for &(a, b) in &edges {
        // A corner of two rings is no simple prism.
        if next.insert(a, b).is_some() || previous.insert(b, a).is_some() {
            return None;
        }
    }
    let apart = |a: u32, b: u32| flat(mesh, a, axis).distance(flat(mesh, b, axis));
    for t in &walls {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let (a, b) = if is_low(a) { (a, b) } else { (b, a) };
            // Of two corners above, the nearer one: the other ends the wall's diagonal.
            if is_low(a) && !is_low(b) && apart(a, b) <= oblique {
                let above = uprights.entry(a).or_insert(b);
                if apart(a, b) < apart(a, *above) {
                    *above = b;
                }
            }
        }
    }
    let mut tops: Vec<u32> = uprights.values().copied().collect();
    tops.sort_unstable();
    if tops.windows(2).any(|w| w[0] == w[1]) {
        return None;
    }
    let mut by_edge: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for t in walls {
        // The lower edge below a wall's triangle, whose corners stand on its ends.
        let begins = |&(a, b): &(u32, u32)| {
            let (c, d) = (uprights.get(&a), uprights.get(&b));
            t.iter()
                .all(|v| *v == a || *v == b || Some(v) == c || Some(v) == d)
        };
        let of = t
            .iter()
            .flat_map(|v| {
                let after = next.get(v).map(|b| (*v, *b));
                let before = previous.get(v).map(|a| (*a, *v));
                after.into_iter().chain(before)
            })
            .find(begins)?;
        by_edge.entry(of.0).or_default().push(t);
    }
    // Every edge has its wall of two triangles, every corner its upright.
    let whole = next.iter().all(|(a, b)| {
        by_edge.get(a).is_some_and(|w| w.len() == 2)
            && uprights.contains_key(a)
            && uprights.contains_key(b)
    });
    if !whole || by_edge.len() != next.len() {
        return None;
    }
    let mut corners: Vec<((u64, u64), u32)> = next
        .keys()
        .map(|&v| (bits(flat(mesh, v, axis)), v))
        .collect();
    corners.sort_unstable();
    if corners.windows(2).any(|w| w[0].0 == w[1].0) {
        return None;
    }
    Some(Prism {
        axis,
        ends: [low, high],
        rings: rings(mesh, axis, &next)?,
        above: uprights,
        next,
        walls: by_edge,
        corners,
    })
}

/// The closed rings of successors.
fn rings(mesh: &Mesh, axis: usize, next: &BTreeMap<u32, u32>) -> Option<Vec<Vec<Point>>> {
    let mut open = next.clone();
    let mut rings = Vec::new();
    while let Some((first, mut at)) = open.pop_first() {
        let mut ring = vec![flat(mesh, first, axis)];
        while at != first {
            ring.push(flat(mesh, at, axis));
            at = open.remove(&at)?;
        }
        rings.push(ring);
    }
    Some(rings)
}

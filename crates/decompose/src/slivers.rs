//! Hulls whose every face has an area: faces too thin for an engine are removed
//! outward.
//!
//! Exact predicates keep a point that rounding put 1e-17 beyond the edge between
//! two others; the face between the three is right and useless: it has no normal
//! that anyone could compute. Such a point is left out, and its neighbours move
//! away from the middle until the hull encloses it again, exactly.

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;

/// Least height of a face over its longest side, as a share of the hull's
/// size: engines hold coordinates in single precision, 2^-24 of the size.
const LEAST: f64 = 1.0 / (1 << 22) as f64;
/// Heights that are tried, as shares of `LEAST`: in a hull so thin that
/// removing the first would reach too far, only faces that are lines.
const HEIGHTS: [f64; 4] = [1.0, 1e-3, 1e-6, 1e-8];
/// Removing slivers may leave others between points that have moved.
const ROUNDS: usize = 8;

/// A hull without slivers around another one.
#[derive(Clone, Debug, PartialEq)]
pub struct Cleared {
    /// Contains the other hull exactly; no more vertices.
    pub hull: Mesh,
    /// No point of it is farther than this from the other.
    pub reach: f64,
}

/// The hull with its slivers removed outward by at most `most`; nothing if it
/// has none, or if they cannot be removed within that.
#[must_use]
pub fn cleared(hull: &Mesh, most: f64) -> Option<Cleared> {
    let size = extent(hull);
    HEIGHTS.iter().find_map(|share| {
        let height = (share * LEAST * size).min(most);
        let mut found: Option<Cleared> = None;
        for _ in 0..ROUNDS {
            let (now, reach) = found.as_ref().map_or((hull, 0.0), |c| (&c.hull, c.reach));
            if thinnest(now, height).is_none() {
                return found;
            }
            let next = without(now, height, most - reach)?;
            found = Some(Cleared {
                hull: next.hull,
                reach: reach + next.reach,
            });
        }
        None
    })
}

/// The face of least height below `height`: the corner opposite its longest
/// side, and that side's ends.
fn thinnest(hull: &Mesh, height: f64) -> Option<[u32; 3]> {
    let mut least = (height, None);
    for t in &hull.triangles {
        let at = |i: usize| hull.vertices[t[i % 3] as usize];
        let side2 = |i: usize| (at(i + 1) - at(i)).length_squared();
        let longest = (0..3).fold(0, |best, i| if side2(i) > side2(best) { i } else { best });
        let double_area = (at(1) - at(0)).cross(at(2) - at(0)).length();
        let own = double_area / side2(longest).sqrt();
        if own < least.0 {
            least = (own, Some([2, 0, 1].map(|k| t[(longest + k) % 3])));
        }
    }
    least.1
}

/// Leaves out what makes slivers, and encloses it again.
fn without(hull: &Mesh, height: f64, most: f64) -> Option<Cleared> {
    let mut rest = hull.clone();
    let mut beside: Vec<DVec3> = Vec::new();
    while let Some(face) = thinnest(&rest, height) {
        let [corner, from, to] = face.map(|v| rest.vertices[v as usize]);
        beside.extend([from, to]);
        let kept: Vec<DVec3> = rest
            .vertices
            .iter()
            .copied()
            .filter(|p| *p != corner)
            .collect();
        rest = convex_hull(&kept).ok()?;
    }
    let middle = rest.vertices.iter().sum::<DVec3>() / rest.vertices.len() as f64;
    // First only what stood beside the removed; where that is not enough, everything.
    let near = |p: &DVec3| beside.contains(p);
    let all = |_: &DVec3| true;
    enclosing(hull, &rest, middle, &near, most)
        .or_else(|| enclosing(hull, &rest, middle, &all, most))
}

/// `rest` with the chosen vertices moved away from `middle` until it contains
/// `hull`.
fn enclosing(
    hull: &Mesh,
    rest: &Mesh,
    middle: DVec3,
    chosen: &dyn Fn(&DVec3) -> bool,
    most: f64,
) -> Option<Cleared> {
    let radius = rest
        .vertices
        .iter()
        .map(|p| p.distance(middle))
        .fold(0.0, f64::max);
    let mut growth = 2.0 * f64::EPSILON;
    while growth * radius <= most {
        let moved: Vec<DVec3> = rest
            .vertices
            .iter()
            .map(|p| {
                if chosen(p) {
                    *p + (*p - middle) * growth
                } else {
                    *p
                }
            })
            .collect();
        let around = convex_hull(&moved).ok()?;
        let both: Vec<DVec3> = around
            .vertices
            .iter()
            .chain(&hull.vertices)
            .copied()
            .collect();
        if convex_hull(&both).ok()?.vertices == around.vertices {
            // The last term is the rounding of the moved points.
            let reach = growth * radius + 4.0 * f64::EPSILON * farthest(&around);
            return Some(Cleared {
                hull: around,
                reach,
            });
        }
        growth *= 2.0;
    }
    None
}

/// Largest coordinate by size.
fn farthest(hull: &Mesh) -> f64 {
    hull.vertices
        .iter()
        .map(|p| p.abs().max_element())
        .fold(0.0, f64::max)
}

/// Longest side of the bounding box.
fn extent(hull: &Mesh) -> f64 {
    let (low, high) = hull
        .vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(*p), high.max(*p))
        });
    (high - low).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// A turned box with points on its edges that rounding put outside.
    fn turned_box_with_points_on_edges(size: DVec3) -> Mesh {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let corners: Vec<DVec3> = (0..8u32)
            .map(|i| {
                let bit = |k: u32| f64::from(i >> k & 1) - 0.3;
                turn * (DVec3::new(bit(0), bit(1), bit(2)) * size)
            })
            .collect();
        let mut points = corners.clone();
        for (i, j) in [(0, 1), (2, 3), (0, 4), (5, 7), (6, 7), (1, 5)] {
            for k in 1..8 {
                points.push(corners[i].lerp(corners[j], f64::from(k) / 8.3));
            }
        }
        convex_hull(&points).unwrap()
    }

    fn contains(outer: &Mesh, inner: &Mesh) -> bool {
        let both: Vec<DVec3> = outer
            .vertices
            .iter()
            .chain(&inner.vertices)
            .copied()
            .collect();
        convex_hull(&both).unwrap().vertices == outer.vertices
    }

    #[test]
    fn faces_that_are_lines_go_and_the_hull_stays_enclosed() {
        let mut with_slivers = 0;
        for size in [
            DVec3::ONE,
            DVec3::new(0.4, 0.05, 0.003),
            DVec3::new(1.0, 1.0, 1e-4),
        ] {
            let hull = turned_box_with_points_on_edges(size);
            let lines = thinnest(&hull, 1e-13 * extent(&hull)).is_some();
            with_slivers += usize::from(lines);
            assert_eq!(cleared(&hull, 1e-5).is_some(), lines);
            if let Some(found) = cleared(&hull, 1e-5) {
                assert!(thinnest(&found.hull, 1e-15 + 1e-14 * extent(&hull)).is_none());
                assert!(contains(&found.hull, &hull));
                assert!(found.hull.vertices.len() < hull.vertices.len());
                assert!(found.reach <= 1e-5 && found.reach > 0.0);
            }
        }
        assert!(with_slivers > 0, "no case had a sliver: nothing was tested");
    }

    #[test]
    fn a_point_just_beyond_an_edge_is_enclosed_within_reach() {
        for beyond in [1e-17, 1e-15, 1e-12, 1e-8] {
            let mut points: Vec<DVec3> = (0..8u32)
                .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
                .collect();
            points.push(DVec3::new(0.5, 1.0 + beyond, 1.0 - beyond));
            let hull = convex_hull(&points).unwrap();
            let found = cleared(&hull, 1e-4);
            if beyond < f64::EPSILON {
                assert_eq!(hull.vertices.len(), 8);
                assert!(found.is_none());
                continue;
            }
            let found = found.unwrap();
            assert_eq!(hull.vertices.len(), 9);
            assert_eq!(found.hull.vertices.len(), 8);
            assert!(contains(&found.hull, &hull));
            assert!(found.reach < 20.0 * beyond);
        }
    }

    #[test]
    fn what_would_reach_too_far_is_left() {
        let hull = turned_box_with_points_on_edges(DVec3::ONE);
        assert!(cleared(&hull, 1e-30).is_none());
    }

    #[test]
    fn a_hull_without_slivers_is_left() {
        let cube: Vec<DVec3> = (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        assert!(cleared(&convex_hull(&cube).unwrap(), 0.1).is_none());
    }
}

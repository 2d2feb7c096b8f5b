//! Fewer vertices, outward only.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::circumscribe::circumscribe;
use super::growing::Growing;
use super::program::{minimise, Constraint};
use super::{convex_hull, HullError};
use crate::distance::Triangle;
use crate::mesh::Mesh;
use crate::properties;
use crate::tolerance::Rounding;

/// Why there is no simpler polytope around a hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimplifyError {
    /// No solid has so few vertices.
    #[error("no convex solid has {max_vertices} vertices; at least 4 are needed")]
    TooFew {
        /// What was asked for.
        max_vertices: usize,
    },
    /// The vertices have no hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}

/// A convex polytope of at most `max_vertices` vertices that contains the
/// convex hull of `hull`'s vertices, and not much more.
///
/// Exact: no vertex of `hull` is strictly outside of a face of the result.
/// Greedy: the edge whose collapse reaches least far outward is replaced by
/// the point beyond all faces around it that adds the least volume (a linear
/// program; Sander et al., *Silhouette clipping*, 2000, §3.1, call such a
/// sequence progressive hulls). Where no edge is left to collapse, the
/// polytope grows from a box by supporting planes instead. A hull that has no
/// more vertices comes back as it is (in canonical form).
///
/// # Errors
/// [`SimplifyError`] for fewer than four vertices or flat input.
pub fn simplify_outward(hull: &Mesh, max_vertices: usize) -> Result<Mesh, SimplifyError> {
    if max_vertices < 4 {
        return Err(SimplifyError::TooFew { max_vertices });
    }
    let hull = convex_hull(&hull.vertices)?;
    let collapsed = collapse(&hull, max_vertices, Within::anywhere())?;
    if collapsed.vertices.len() <= max_vertices {
        Ok(collapsed)
    } else {
        Ok(circumscribe(&hull, max_vertices)?)
    }
}

/// A convex polytope with few vertices that contains the convex hull of
/// `hull`'s vertices and reaches at most `reach` beyond it (the Hausdorff
/// distance, measured at its vertices, where it is attained; up to rounding).
/// As [`simplify_outward`] otherwise.
///
/// # Errors
/// [`HullError`] for flat input.
pub fn simplify_within(hull: &Mesh, reach: f64) -> Result<Mesh, HullError> {
    simplify_within_room(hull, &|_| reach)
}

/// As [`simplify_within`], with a reach for each face of the convex hull, given its corners: a new
/// vertex lies within the largest of them of the hull, and no higher above the plane of any face than
/// that one's. So no point of the result whose nearest point is on a face is farther from it than
/// the face's reach.
///
/// # Errors
/// [`HullError`] for flat input.
pub fn simplify_within_room(
    hull: &Mesh,
    room: &dyn Fn([DVec3; 3]) -> f64,
) -> Result<Mesh, HullError> {
    let hull = convex_hull(&hull.vertices)?;
    let within = Within::of(&hull, room);
    collapse(&hull, 4, within)
}

/// Collapses edges until the count is met, or no edge is left to collapse
/// whose point would be `within`.
fn collapse(hull: &Mesh, max_vertices: usize, within: Within) -> Result<Mesh, HullError> {
    if hull.vertices.len() <= max_vertices {
        return Ok(hull.clone());
    }
    let rounding = Rounding::of(hull);
    let (low, high) = properties::bounds(hull).unwrap_or_default();
    let size = (high - low).max_element();
    let mut growing = Growing::new(&hull.vertices, 3.0 * size)?;
    let mut pricing = Pricing {
        within,
        size,
        lift: 16.0 * rounding.crossing(),
        spare: SPARE * (size + low.abs().max(high.abs()).max_element()),
        // Every collapse adds one point and removes at least two.
        changes: vec![0; 2 * hull.vertices.len()],
        queue: BinaryHeap::new(),
    };
    for (a, b) in growing.edges() {
        pricing.consider(&growing, a, b);
    }
    while growing.vertex_count() > max_vertices {
        let Some(candidate) = pricing.queue.pop() else {
            break;
        };
        let (a, b) = candidate.edge;
        if !growing.is_edge(a, b) {
            continue;
        }
        if pricing.age(a, b) != candidate.age {
            pricing.consider(&growing, a, b);
            continue;
        }
        if !pricing.within.contains(candidate.point) {
            continue;
        }
        let Some(added) = growing.replace(a, b, candidate.point) else {
            continue;
        };
        let neighbours = growing.neighbours(added);
        for &n in &neighbours {
            // Prices of edges out there are old now; they are renewed when it is their turn.
            pricing.changes[n as usize] += 1;
        }
        for &n in &neighbours {
            pricing.consider(&growing, n, added);
        }
    }
    Ok(growing.finish())
}

/// The points near a hull.
struct Within {
    faces: Vec<Triangle>,
    /// How far off a point may be.
    reach: f64,
    /// Outward normals of faces with less reach, and how far along them a point may be.
    tight: Vec<(DVec3, f64)>,
}

impl Within {
    fn anywhere() -> Within {
        Within {
            faces: Vec::new(),
            reach: f64::INFINITY,
            tight: Vec::new(),
        }
    }

    fn of(hull: &Mesh, room: &dyn Fn([DVec3; 3]) -> f64) -> Within {
        let faces: Vec<Triangle> = hull.faces().map(Triangle::new).collect();
        let rooms: Vec<f64> = hull.faces().map(room).collect();
        let reach = rooms.iter().copied().fold(0.0, f64::max);
        let tight = hull.faces().zip(rooms).filter(|(_, room)| *room < reach);
        let tight = tight.map(|([a, b, c], room)| {
            let normal = (b - a).cross(c - a).normalize_or_zero();
            (normal, normal.dot(a) + room)
        });
        Within {
            faces,
            reach,
            tight: tight.collect(),
        }
    }

    fn contains(&self, point: DVec3) -> bool {
        let reach2 = self.reach * self.reach;
        let near = |face: &Triangle| face.distance2(point) <= reach2;
        let low = |(normal, most): &(DVec3, f64)| normal.dot(point) <= *most;
        self.reach.is_infinite() || (self.tight.iter().all(low) && self.faces.iter().any(near))
    }
}

/// As a share of sizes and coordinates.
const SPARE: f64 = 1e-9;

/// What collapses cost.
struct Pricing {
    within: Within,
    /// Of the hull: no new point lies farther out.
    size: f64,
    /// How far beyond the faces a new point must lie for the signs to be certain.
    lift: f64,
    /// More than rounding makes of a height or a distance.
    spare: f64,
    /// How often the faces around each vertex have changed.
    changes: Vec<u32>,
    queue: BinaryHeap<Candidate>,
}

impl Pricing {
    fn age(&self, a: u32, b: u32) -> u32 {
        self.changes[a as usize] + self.changes[b as usize]
    }

    /// Squared distance to the nearest of some faces; any number above `most2` if that is
    /// farther.
    fn nearest2(&self, faces: &[[DVec3; 3]], point: DVec3, most2: f64) -> f64 {
        let mut best = f64::INFINITY;
        for &corners in faces {
            let face = Triangle::new(corners);
            // A face is no nearer than its plane. The point touches three of the planes or more,
            // and is far from most others.
            let height = (face.height(point) - self.spare).max(0.0);
            if height * height <= best.min(most2) {
                best = best.min(face.distance2(point));
            }
        }
        best
    }

    /// Prices the collapse of an edge.
    fn consider(&mut self, growing: &Growing, a: u32, b: u32) {
        let faces = growing.faces_around(a, b);
        let base = growing.at(a);
        let mut objective = DVec3::ZERO;
        let mut constraints = Vec::with_capacity(faces.len());
        for corners in &faces {
            let [p, q, r] = corners.map(|c| c - base);
            let normal = (q - p).cross(r - p);
            objective += normal;
            let Some(normal) = normal.try_normalize() else {
                continue;
            };
            constraints.push(Constraint {
                normal,
                offset: normal.dot(p) + self.lift,
            });
        }
        let Some(point) = minimise(objective, &mut constraints, self.size) else {
            return;
        };
        let point = base + point;
        let farthest = self.size.min(self.within.reach);
        let distance2 = self.nearest2(&faces, point, farthest * farthest);
        if distance2 <= farthest * farthest {
            let age = self.age(a, b);
            self.queue.push(Candidate {
                distance2,
                edge: (a, b),
                age,
                point,
            });
        }
    }
}

/// A collapse: smaller reach first, then smaller indices.
struct Candidate {
    distance2: f64,
    edge: (u32, u32),
    /// [`Pricing::age`] when it was priced.
    age: u32,
    point: DVec3,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let ascending = self.distance2.total_cmp(&other.distance2);
        ascending
            .then(self.edge.cmp(&other.edge))
            .then(self.age.cmp(&other.age))
            .reverse()
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

//! Access to a shape from inside: large convex sets within it
//! (Chassery & Coeurjolly 2005).

mod chords;
mod deepest;
pub mod discrete;
pub mod hv;
mod kernel;
mod star;

pub use kernel::{distance_to_kernel, kernel};
pub use star::{convex_subset_of_star, ConvexSubset};

use crate::arrangement::arrange;
use crate::decompose::{decompose, Parameters};
use crate::{visibility, DiagonalWeights, HoleAxis, Measure, OutlineError, Point};

/// How a convex subset was come by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The outline is star-shaped: §5 as it stands.
    Kernel,
    /// It is not: §5 on what a point inside it sees.
    Visibility,
}

/// Seeds beside the deepest point: the largest convex parts.
const PART_SEEDS: usize = 8;
/// How often a seed is moved to the middle of what it gave.
const ROUNDS: usize = 4;

/// A convex polygon of large area inside the even-odd interior of `rings`.
///
/// A star-shaped polygon is treated by the kernel dilatation of §5. For any
/// other outline the paper gives no method. Here every convex set is seen
/// whole from each of its points, so what a point sees, which is star-shaped,
/// is searched instead; the points tried are the deepest one and the middles
/// of the largest parts of an exact convex decomposition, each moved to the
/// middle of what it gave while that helps. Star-shaped polygons get the same
/// second look: the greedy order is not always the best one. The largest set
/// is kept. Vertices are rounded: they lie inside to within a few ulp.
///
/// # Errors
/// [`OutlineError`] as for [`decompose`].
pub fn convex_subset(rings: &[Vec<Point>]) -> Result<(Vec<Point>, Origin), OutlineError> {
    let arrangement = arrange(rings)?;
    let mut best = Best {
        area: 0.0,
        polygon: Vec::new(),
        origin: Origin::Visibility,
    };
    if let [only] = &arrangement.components[..] {
        let ring: Vec<Point> = only
            .outer
            .iter()
            .map(|&v| arrangement.points[v as usize])
            .collect();
        if only.holes.is_empty() {
            if let Some(found) = convex_subset_of_star(&ring) {
                best.offer(found.polygon, Origin::Kernel);
            }
        }
    }
    let parameters = Parameters {
        tolerance: 0.0,
        measure: Measure::Hybrid1,
        hole_axis: HoleAxis::Medial,
        weights: DiagonalWeights::default(),
    };
    let mut parts = decompose(rings, &parameters)?.at(0.0);
    parts.sort_by(|a, b| b.area().total_cmp(&a.area()));
    // a part is a convex subset already: the answer is never worse than the largest
    if let Some(part) = parts.first() {
        best.offer(part.outer.clone(), Origin::Visibility);
    }
    let seeds = deepest::deepest_point(rings).into_iter().chain(
        parts
            .iter()
            .take(PART_SEEDS)
            .map(|part| middle(&part.outer)),
    );
    for seed in seeds {
        let mut eye = seed;
        let mut here = 0.0;
        for _ in 0..ROUNDS {
            let seen = visibility::from_point(&arrangement.cdt, eye);
            let Some(found) = star::convex_subset_about(&seen, eye) else {
                break;
            };
            let area = crate::signed_area(&found.polygon);
            if area <= here {
                break;
            }
            here = area;
            eye = middle(&found.polygon);
            best.offer(found.polygon, Origin::Visibility);
        }
    }
    Ok((best.polygon, best.origin))
}

struct Best {
    area: f64,
    polygon: Vec<Point>,
    origin: Origin,
}

impl Best {
    /// Keeps the polygon if it is larger, and convex up to rounding.
    fn offer(&mut self, polygon: Vec<Point>, origin: Origin) -> bool {
        let area = crate::signed_area(&polygon);
        let hull = crate::signed_area(&crate::convex_hull(&polygon));
        let wins = area > self.area && hull - area <= 1e-12 * hull;
        if wins {
            *self = Self {
                area,
                polygon,
                origin,
            };
        }
        wins
    }
}

fn middle(ring: &[Point]) -> Point {
    let n = ring.len() as f64;
    Point::new(
        ring.iter().map(|p| p.x / n).sum(),
        ring.iter().map(|p| p.y / n).sum(),
    )
}

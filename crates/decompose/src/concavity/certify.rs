//! Certificates for hulls of any origin.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::{convex_hull, HullError};
use assetpipe_geometry::{DVec3, Mesh};
use rayon::prelude::*;

use super::coverage::uncovered;
use super::{thickening, Gap, Interval, Limits};

/// What is proved about hulls that claim to stand for a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificates {
    /// Of each hull, in order: sup of d(q, solid) over its points q.
    pub thickening: Vec<Interval>,
    /// sup of d(p, union of the hulls) over the points p of the solid's surface.
    pub uncovered: Interval,
}

/// A hull that is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("hull {index}: {reason}")]
pub struct NotAHull {
    /// Which.
    pub index: usize,
    /// Why.
    pub reason: HullError,
}

/// Certify `hulls`, each the convex hull of its vertices whatever its faces
/// (flat ones count as solids without volume), against a closed solid.
///
/// # Errors
/// [`NotAHull`] for one without vertices or with a vertex that is not finite.
pub fn certify(
    solid: &Mesh,
    hulls: &[Mesh],
    gap: Gap,
    limits: &Limits,
) -> Result<Certificates, NotAHull> {
    let index = SolidIndex::new(solid);
    let bodies = hulls
        .iter()
        .enumerate()
        .map(|(index, hull)| Body::of(&hull.vertices).map_err(|reason| NotAHull { index, reason }))
        .collect::<Result<Vec<Body>, NotAHull>>()?;
    let thickening = bodies
        .par_iter()
        .map(|body| {
            let Interval { lower, upper } = thickening::bounds(&index, &body.hull, gap, limits);
            Interval {
                lower: (lower - body.widened).max(0.0),
                upper,
            }
        })
        .collect();
    let widened = bodies.iter().fold(0.0f64, |w, b| w.max(b.widened));
    let hulls: Vec<Mesh> = bodies.into_iter().map(|b| b.hull).collect();
    let Interval { lower, upper } = uncovered(solid, &hulls, gap, limits);
    Ok(Certificates {
        thickening,
        uncovered: Interval {
            lower,
            upper: upper + widened,
        },
    })
}

/// A hull with volume, and how far its points may lie outside the given one.
struct Body {
    hull: Mesh,
    widened: f64,
}

impl Body {
    /// Share of its size by which a flat hull is thickened to have a volume.
    const SHEET: f64 = 1e-9;

    fn of(points: &[DVec3]) -> Result<Body, HullError> {
        match convex_hull(points) {
            Ok(hull) => Ok(Body { hull, widened: 0.0 }),
            Err(HullError::Degenerate { .. }) => {
                let size = points.iter().fold(0.0f64, |s, p| {
                    s.max(p.abs().max_element()).max(f64::MIN_POSITIVE.sqrt())
                });
                let widened = Self::SHEET * size;
                let around: Vec<DVec3> = points
                    .iter()
                    .flat_map(|p| {
                        [DVec3::X, DVec3::Y, DVec3::Z]
                            .into_iter()
                            .flat_map(|axis| [*p - axis * widened, *p + axis * widened])
                    })
                    .collect();
                convex_hull(&around).map(|hull| Body { hull, widened })
            }
            Err(other) => Err(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    const CLOSE: Gap = Gap {
        relative: 0.005,
        absolute: 1e-4,
    };

    #[test]
    fn hulls_of_another_engine() {
        let solid = shapes::ell();
        // One for the lower half, one that reaches over the missing quarter, a
        // flat one, with points inside and faces in disorder.
        let mut lower = shapes::cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
        lower.vertices.push(DVec3::splat(0.5));
        lower.triangles.reverse();
        let upper = shapes::cuboid(DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.25, 2.0, 1.0));
        let flat = Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, 0.0)],
            triangles: vec![[0, 1, 2]],
        };
        let found = certify(&solid, &[lower, upper, flat], CLOSE, &Limits::default()).unwrap();
        assert!(found.thickening[0].upper < 2e-4);
        assert!(found.thickening[1].holds(0.25), "{found:?}");
        assert!(found.thickening[2].upper < 2e-4, "{found:?}");
        assert!(found.uncovered.lower == 0.0 && found.uncovered.upper < 2e-4);
    }

    #[test]
    fn names_the_hull_that_is_none() {
        let bad = Mesh {
            vertices: vec![DVec3::NAN],
            triangles: vec![],
        };
        let good = shapes::cuboid(DVec3::ZERO, DVec3::ONE);
        let error = certify(&shapes::ell(), &[good, bad], CLOSE, &Limits::default());
        assert_eq!(error.unwrap_err().index, 1);
    }
}

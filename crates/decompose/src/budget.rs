//! Budgets of vertices, met outward.

use assetpipe_geometry::hull::{convex_hull, simplify_outward};
use assetpipe_geometry::primitive::fit_box;
use assetpipe_geometry::Mesh;

use crate::error::DecomposeError;
use crate::merge::volume;

/// Vertices of a box.
const CORNERS: usize = 8;
/// Shares by which a box is widened until it encloses exactly.
const WIDENED: [f64; 3] = [0.0, 1e-12, 1e-9];

/// A polytope of at most `most` vertices around a hull: the hull itself if it has no more,
/// else the smaller one of an outward simplification and, if it has room, a box. Collapsing
/// edges is at its worst where hardly a vertex may stay: of a drum it leaves spikes.
///
/// # Errors
/// [`DecomposeError::Internal`] for a hull without volume, or fewer than four vertices.
pub fn within(hull: Mesh, most: usize) -> Result<Mesh, DecomposeError> {
    if hull.vertices.len() <= most {
        return Ok(hull);
    }
    let simple =
        simplify_outward(&hull, most).map_err(|e| DecomposeError::Internal(e.to_string()))?;
    match boxed(&hull).filter(|_| most >= CORNERS) {
        Some(boxed) if volume(&boxed) < volume(&simple) => Ok(boxed),
        _ => Ok(simple),
    }
}

/// A box around a hull that contains it by exact predicates.
fn boxed(hull: &Mesh) -> Option<Mesh> {
    let fitted = fit_box(hull)?.shape;
    WIDENED.iter().find_map(|share| {
        let mut wider = fitted;
        wider.half *= 1.0 + share;
        let mesh = convex_hull(&wider.corners()).ok()?;
        let mut both = mesh.vertices.clone();
        both.extend(&hull.vertices);
        let contained = convex_hull(&both).ok()?.vertices == mesh.vertices;
        (contained && mesh.vertices.len() == CORNERS).then_some(mesh)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    fn turned_drum() -> Mesh {
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let points: Vec<DVec3> = (0..128u32)
            .map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i / 2) / 64.0;
                let z = if i % 2 == 0 { -0.2 } else { 0.2 };
                turn * DVec3::new(libm::cos(angle), libm::sin(angle), z)
            })
            .collect();
        convex_hull(&points).unwrap()
    }

    #[test]
    fn budgets_are_met_outward_and_a_drum_gets_no_spikes() {
        let drum = turned_drum();
        for most in [4, 5, 6, 8, 9, 12, 16, 32, 64] {
            let found = within(drum.clone(), most).unwrap();
            assert!(found.vertices.len() <= most);
            let mut both = found.vertices.clone();
            both.extend(&drum.vertices);
            assert_eq!(convex_hull(&both).unwrap().vertices, found.vertices);
            if most >= CORNERS {
                // A box around a disk has 4/π of its area.
                assert!(volume(&found) < 1.3 * volume(&drum), "{most}");
            }
        }
    }

    #[test]
    fn a_hull_within_its_budget_is_left() {
        let drum = turned_drum();
        assert_eq!(within(drum.clone(), 128).unwrap(), drum);
    }
}

//! From working hulls to the hulls that leave the engine: exact in the input's
//! coordinates, with fewer vertices, proved again.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::{convex_hull, simplify_within};
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::concavity::thickening::{decide, Decision};
use crate::concavity::Limits;
use crate::error::DecomposeError;
use crate::merge::Proved;
use crate::working::Working;

/// Hulls with fewer vertices gain nothing from simplification.
const FEW: usize = 8;

/// What all hulls of one solid share.
pub struct Finish<'a> {
    /// Between the copies.
    pub working: &'a Working,
    /// The solid, working copy.
    pub solid: &'a SolidIndex,
    /// The tolerance, working length.
    pub epsilon: f64,
    /// How far simplification may reach outward, in ε; 0 for none.
    pub slim: f64,
    /// Limits of proofs.
    pub limits: &'a Limits<'a>,
}

impl Finish<'_> {
    /// The hull in the input's coordinates, and its working copy with the
    /// bound that holds for it.
    ///
    /// The hull of all the part's points as the input has them encloses them
    /// exactly; simplification only reaches outward and is kept only if the
    /// result is proved within ε.
    ///
    /// # Errors
    /// [`DecomposeError::Internal`] for a hull that has no volume.
    pub fn run(&self, group: &Proved, parts: &[Vec<DVec3>]) -> Result<(Mesh, Proved), DecomposeError> {
        let internal = |e: &dyn std::fmt::Display| DecomposeError::Internal(e.to_string());
        let points: Vec<DVec3> = group
            .members
            .iter()
            .flat_map(|&m| parts[m as usize].iter().map(|&p| self.working.input(p)))
            .collect();
        let exact = convex_hull(&points).map_err(|e| internal(&e))?;
        let mut slim = self.slim * self.epsilon;
        let least = 0.1 * slim;
        while exact.vertices.len() > FEW && slim > 0.0 && slim >= least {
            let reach = self.working.input_length(slim);
            if let Ok(simple) = simplify_within(&exact, reach) {
                if simple.vertices.len() < exact.vertices.len() {
                    if let Some(proved) = self.prove(&simple, group) {
                        return Ok((simple, proved));
                    }
                }
            }
            slim *= 0.3;
        }
        // The exact hull differs from the proved one by rounding alone.
        Ok((exact, group.clone()))
    }

    fn prove(&self, hull: &Mesh, group: &Proved) -> Option<Proved> {
        let points: Vec<DVec3> = hull.vertices.iter().map(|&p| self.working.work(p)).collect();
        let work = convex_hull(&points).ok()?;
        match decide(self.solid, &work, self.epsilon, self.limits) {
            Decision::Within(thickening) => {
                Some(Proved { hull: work, thickening, members: group.members.clone() })
            }
            _ => None,
        }
    }
}

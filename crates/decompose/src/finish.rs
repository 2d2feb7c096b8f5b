//! From working hulls to the hulls that leave the engine: exact in the input's
//! coordinates, with fewer vertices, proved again.

use assetpipe_geometry::hull::{convex_hull, simplify_within};
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::budget;
use crate::concavity::thickening::{bounds, bounds_above};
use crate::concavity::{Decision, Gap, Interval, Limits};
use crate::error::DecomposeError;
use crate::judge::Judge;
use crate::merge::Proved;
use crate::search::piece::Piece;
use crate::settings::Metric;
use crate::slivers::cleared;
use crate::working::Working;

/// Hulls with fewer vertices gain nothing from simplification.
const FEW: usize = 8;
/// Shares of the reach that simplification tries, the greatest first.
const REACHES: [f64; 4] = [1.0, 0.3, 0.03, 0.003];
/// Hulls with more vertices than this try the smallest reaches too: fine meshes have most of
/// their vertices next to a plane of few others.
const MANY: usize = 64;
/// How far removing slivers may reach outward, in ε; the second where the proof
/// leaves no room for the first.
const CLEARANCE: [f64; 2] = [1e-3, 1e-9];

/// What all hulls of one solid share.
pub struct Finish<'a> {
    /// Between the copies.
    pub working: &'a Working,
    /// Who decides.
    pub judge: Judge<'a>,
    /// How far simplification may reach outward, in ε; 0 for none.
    pub slim: f64,
    /// How close the bounds are brought to one another.
    pub gap: Gap,
    /// Cells that each bound may cost beyond the proof.
    pub cells: usize,
    /// Most vertices a hull may have; 0 for any number.
    pub most_vertices: usize,
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
    pub fn run(&self, group: &Proved, parts: &[Piece]) -> Result<(Mesh, Proved), DecomposeError> {
        self.judge.go_on()?;
        let (mesh, proved) = self.hull(group, parts)?;
        self.judge.go_on()?;
        let (mesh, mut proved) = self.clear(mesh, proved, parts)?;
        let Interval { lower, upper } = proved.thickening;
        if upper > self.gap.upper(lower) {
            let limits = self.limits();
            let found = bounds_above(self.judge.solid, &proved.hull, lower, self.gap, &limits);
            proved.thickening = Interval {
                lower: found.lower,
                upper: found.upper.min(upper).max(found.lower),
            };
        }
        Ok((mesh, proved))
    }

    /// Eq. 4 of a hull that [`Finish::run`] gave, towards its part.
    ///
    /// # Errors
    /// [`DecomposeError::Cancelled`].
    pub fn concavity(&self, proved: &Proved, parts: &[Piece]) -> Result<Interval, DecomposeError> {
        self.judge.go_on()?;
        let own: Vec<&Piece> = proved.members.iter().map(|&m| &parts[m as usize]).collect();
        let known = proved.thickening.lower;
        let mut concavity =
            self.judge
                .concavity(&proved.hull, &own, known, self.gap, &self.limits());
        // Bounds give up earlier than the proof of acceptance, which holds all the same.
        let epsilon = self.judge.epsilon;
        if self.judge.metric == Metric::Concavity
            && concavity.upper > epsilon
            && self.judge.decide(&proved.hull, &own).is_within()
        {
            concavity.upper = epsilon.max(concavity.lower);
        }
        Ok(concavity)
    }

    /// What each bound may cost.
    fn limits(&self) -> Limits<'_> {
        Limits {
            cells: self.cells,
            ..*self.judge.limits
        }
    }

    /// The hull and its working copy, proved.
    fn hull(&self, group: &Proved, parts: &[Piece]) -> Result<(Mesh, Proved), DecomposeError> {
        let internal = |e: &dyn std::fmt::Display| DecomposeError::Internal(e.to_string());
        let points: Vec<DVec3> = group
            .members
            .iter()
            .flat_map(|&m| {
                parts[m as usize]
                    .points
                    .iter()
                    .flat_map(|&p| self.working.inputs(p))
            })
            .collect();
        let exact = convex_hull(&points).map_err(|e| internal(&e))?;
        if let Some((mesh, proved)) = self.slimmed(&exact, group, parts) {
            if self.most_vertices == 0 || mesh.vertices.len() <= self.most_vertices {
                return Ok((mesh, proved));
            }
        }
        if self.most_vertices == 0 || exact.vertices.len() <= self.most_vertices {
            // The exact hull differs from the proved one by rounding alone.
            return Ok((exact, group.clone()));
        }
        // A budget is met outwards whatever it costs; the bound tells the cost.
        let mesh = self.within_budget(exact)?;
        let hull = self.image(&mesh)?;
        let thickening = bounds(self.judge.solid, &hull, self.gap, self.judge.limits);
        Ok((
            mesh,
            Proved {
                hull,
                thickening,
                members: group.members.clone(),
            },
        ))
    }

    /// The hull without slivers, if the proof allows that.
    fn clear(
        &self,
        mesh: Mesh,
        proved: Proved,
        parts: &[Piece],
    ) -> Result<(Mesh, Proved), DecomposeError> {
        for share in CLEARANCE {
            let Some(found) = cleared(&mesh, self.clearance(share)) else {
                continue;
            };
            let hull = self.image(&found.hull)?;
            let reach = self.working.length(found.reach) + self.judge.solid.slack();
            // Distance to the solid is 1-Lipschitz.
            let widened = Interval {
                lower: proved.thickening.lower,
                upper: proved.thickening.upper + reach,
            };
            let over_budget = proved.thickening.upper > self.judge.epsilon;
            let near =
                self.judge.metric == Metric::Thickening && widened.upper <= self.judge.epsilon;
            let thickening = if near || over_budget {
                widened
            } else {
                let members = proved.members.iter();
                let own: Vec<&Piece> = members.map(|&m| &parts[m as usize]).collect();
                match self.judge.decide(&hull, &own) {
                    Decision::Within(thickening) => thickening,
                    _ => continue,
                }
            };
            let members = proved.members;
            return Ok((
                found.hull,
                Proved {
                    hull,
                    thickening,
                    members,
                },
            ));
        }
        Ok((mesh, proved))
    }

    /// How far removing slivers may reach outward, input length.
    fn clearance(&self, share: f64) -> f64 {
        self.working.input_length(share * self.judge.epsilon)
    }

    /// A coarser hull without slivers, as far as that is possible; it is not
    /// proved yet.
    pub fn without_slivers(&self, hull: Mesh) -> Mesh {
        cleared(&hull, self.clearance(CLEARANCE[0])).map_or(hull, |found| found.hull)
    }

    /// The hull with fewer vertices, if one within ε is found.
    fn slimmed(&self, exact: &Mesh, group: &Proved, parts: &[Piece]) -> Option<(Mesh, Proved)> {
        let own: Vec<&Piece> = group.members.iter().map(|&m| &parts[m as usize]).collect();
        if exact.vertices.len() <= FEW {
            return None;
        }
        let tried = if exact.vertices.len() > MANY { 4 } else { 2 };
        for share in &REACHES[..tried] {
            let slim = share * self.slim * self.judge.epsilon;
            if slim <= 0.0 {
                return None;
            }
            let simple = simplify_within(exact, self.working.input_length(slim)).ok()?;
            if simple.vertices.len() < exact.vertices.len() {
                let hull = self.image(&simple).ok()?;
                if let Decision::Within(thickening) = self.judge.decide(&hull, &own) {
                    return Some((
                        simple,
                        Proved {
                            hull,
                            thickening,
                            members: group.members.clone(),
                        },
                    ));
                }
            }
        }
        None
    }

    /// At most `most_vertices` vertices, by simplification outward.
    ///
    /// # Errors
    /// [`DecomposeError::Internal`] for a hull without volume.
    pub fn within_budget(&self, hull: Mesh) -> Result<Mesh, DecomposeError> {
        if self.most_vertices == 0 {
            return Ok(hull);
        }
        budget::within(hull, self.most_vertices)
    }

    /// The working copy of a hull of the input.
    ///
    /// # Errors
    /// [`DecomposeError::Internal`] for a hull without volume.
    pub fn image(&self, hull: &Mesh) -> Result<Mesh, DecomposeError> {
        let points: Vec<DVec3> = hull
            .vertices
            .iter()
            .map(|&p| self.working.work(p))
            .collect();
        convex_hull(&points).map_err(|e| DecomposeError::Internal(e.to_string()))
    }
}

//! From working hulls to the hulls that leave the engine: exact in the input's
//! coordinates, with fewer vertices, proved again.

use assetpipe_geometry::hull::{convex_hull, simplify_within, simplify_within_room};
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
/// Distances between points at which the room of a face is measured, in ε, and most of them along a
/// side.
const SPACING: f64 = 0.1;
const STEPS: f64 = 16.0;
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
        let slim = self.slim * self.judge.epsilon;
        if exact.vertices.len() <= FEW || slim <= 0.0 {
            return None;
        }
        let accepted = |simple: Mesh| {
            if simple.vertices.len() == exact.vertices.len() {
                return None;
            }
            let hull = self.image(&simple).ok()?;
            let Decision::Within(thickening) = self.judge.decide(&hull, &own) else {
                return None;
            };
            let members = group.members.clone();
            Some((
                simple,
                Proved {
                    hull,
                    thickening,
                    members,
                },
            ))
        };
        let reach = self.working.input_length(slim);
        let everywhere = simplify_within(exact, reach).ok()?;
        // What leaves less room leaves it at one place mostly.
        accepted(everywhere)
            .or_else(|| accepted(simplify_within_room(exact, &|c| self.room(c, slim)).ok()?))
    }

    /// How far outward a face of a hull may move, input length: at most `most`, a working length, and
    /// no farther than ε from the solid, as far as distances at some of its points tell.
    fn room(&self, corners: [DVec3; 3], most: f64) -> f64 {
        let epsilon = self.judge.epsilon;
        let [a, b, c] = corners.map(|p| self.working.work(p));
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let steps = (longest / (SPACING * epsilon)).ceil().clamp(1.0, STEPS);
        let at = |k: u32| f64::from(k) / steps;
        let last = steps as u32;
        let points = (0..=last).flat_map(|i| (0..=last - i).map(move |j| (i, j)));
        let deepest = points
            .map(|(i, j)| {
                self.judge
                    .solid
                    .distance(a + (b - a) * at(i) + (c - a) * at(j))
            })
            .fold(0.0, f64::max);
        // No point of a triangle is farther from its corners.
        let between = longest / steps / 3f64.sqrt();
        self.working
            .input_length((epsilon - deepest - between).clamp(0.0, most))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::concavity::Limits;
    use crate::shapes::ball;
    use assetpipe_geometry::distance::SolidIndex;
    use glam::DMat3;

    /// The vertices of a fine ball's hull, and of what is left of it where hulls may reach `slim`
    /// ε outward before they are proved.
    fn slimmed(slim: f64) -> (usize, usize) {
        let (working, solid) = Working::new(&ball(3), DMat3::IDENTITY);
        let index = SolidIndex::new(&solid);
        let limits = Limits::default();
        let epsilon = 0.05;
        let gap = Gap {
            relative: 0.05,
            absolute: 1e-3,
        };
        let finish = Finish {
            working: &working,
            judge: Judge {
                solid: &index,
                metric: Metric::Thickening,
                epsilon,
                limits: &limits,
            },
            slim,
            gap,
            cells: 1000,
            most_vertices: 0,
        };
        let group = Proved {
            hull: convex_hull(&solid.vertices).unwrap(),
            thickening: Interval::exactly(0.0),
            members: vec![0],
        };
        let exact = group.hull.vertices.len();
        let (mesh, proved) = finish.run(&group, &[Piece::from(&solid)]).unwrap();
        assert!(proved.thickening.upper <= epsilon);
        (exact, mesh.vertices.len())
    }

    #[test]
    fn hulls_are_simplified_where_there_is_room() {
        assert_eq!(slimmed(0.0).0, slimmed(0.0).1);
        // The proof refuses a reach of 20 ε, and every face has room for one.
        let (exact, left) = slimmed(20.0);
        assert!(left < exact / 2, "{left} of {exact}");
    }
}

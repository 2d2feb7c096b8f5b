//! What a caller may choose, and what experiments may vary.

/// What decides that a part is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// sup of d(q, solid) over the hull (default).
    Thickening,
    /// Eq. 4 of Wei et al. 2022, towards the part.
    Concavity,
}

/// How candidate cuts are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Norm {
    /// The worst part, as in Eq. 7 and Eq. 9.
    Worst,
    /// The sum over parts of (excess volume / ε³) to this power.
    Sum(f64),
}

/// Which policy looks for cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolicyChoice {
    /// One step: Eq. 7.
    Greedy,
    /// Two steps: the best first cuts, each with its best second cut.
    Lookahead,
    /// Monte Carlo tree search: Algorithm 2.
    Mcts,
}

/// Whether walls are divided into sectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sectors {
    /// Where a hollow wall explains a part.
    Foreseen,
    /// Never: the search alone decides.
    Ignored,
}

/// Which merges come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MergeOrder {
    /// Least added volume.
    Added,
    /// Least added volume a volume of both.
    Relative,
    /// Least added volume and volume of the smaller one: small ones first.
    Smallest,
}

/// The frame of the cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameChoice {
    /// The axes of the mesh.
    Mesh,
    /// From flat faces where that aligns materially more area.
    Faces,
    /// The principal axes of the surface, as in §6.1.
    Principal,
}

/// How extruded outlines are decomposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prisms {
    /// Like every other solid.
    Search,
    /// In the plane as well, if that gives fewer hulls.
    Plane,
}

/// Parameters of the search. Lengths are in units of ε unless said otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchSettings {
    /// What is held below the tolerance.
    pub metric: Metric,
    /// Which policy.
    pub policy: PolicyChoice,
    /// Planes an axis for the first cut (m in the paper).
    pub planes: usize,
    /// How many first cuts are looked at a second step deep.
    pub expand: usize,
    /// How many of these every direction has for sure.
    pub quota: usize,
    /// Planes an axis for the second cut.
    pub second: usize,
    /// How parts are put together to a value.
    pub norm: Norm,
    /// Weight of hull volume that is not forbidden, against forbidden volume.
    pub excess: f64,
    /// Cost of a part that is not done, in the unit of `norm`.
    pub undone: f64,
    /// Samples of forbidden space a part.
    pub samples: usize,
    /// With the concavity: what surface that is deeper than ε in its hull counts as, a thickness of
    /// forbidden space; 0 for nothing.
    pub buried: f64,
    /// Offsets tried when the chosen plane is refined; 0 for no refinement.
    pub refine: usize,
    /// Triangles of the stand-ins, decreasing.
    pub ladder: Vec<usize>,
    /// Fewest surface triangles of a stand-in for a part.
    pub fewest: usize,
    /// Simplification of section outlines.
    pub section: f64,
    /// Extents below this get no grid planes.
    pub thinnest: f64,
    /// Whether walls around an axis are divided into sectors.
    pub sectors: Sectors,
    /// Cuts that Monte Carlo tree search looks ahead (d in the paper).
    pub depth: usize,
    /// Its iterations (t in the paper).
    pub iterations: usize,
    /// How much it explores: c of Eq. 8 in units of concavity/d, which is the paper's choice.
    pub exploration: f64,
    /// What its random numbers are drawn from.
    pub seed: u64,
    /// So many parallel cuts in a row may leave a part as hollow as before; the next goes
    /// another way. 0 for any number.
    pub patience: u32,
    /// Planes of flat faces, at most so many a direction; 0 for none.
    pub faces: usize,
    /// Least area of a flat face that offers its plane, in ε².
    pub face: f64,
    /// Planes of flat faces for the second cut, likewise.
    pub second_faces: usize,
    /// Planes through reflex edges that are along no axis, at most so many; 0 for none.
    pub oblique: usize,
    /// The least length of edges that such a plane resolves.
    pub notched: f64,
    /// Planes that resolve this share of a part's reflex edges are candidates of the second cut
    /// too.
    pub second_share: f64,
    /// The frame of the cuts.
    pub frame: FrameChoice,
    /// How far hulls may reach outward to have fewer vertices.
    pub slim: f64,
    /// How far apart the ends of a certificate may be, as a share of the lower.
    pub gap: f64,
    /// Cells that each bound of a certificate may cost beyond the proof.
    pub cells: usize,
    /// Most vertices a hull may have; 0 for any number.
    pub most_vertices: usize,
    /// Whether hulls are merged at the end.
    pub merging: bool,
    /// Where extruded outlines are decomposed.
    pub prisms: Prisms,
    /// Which merges come first.
    pub merge_order: MergeOrder,
    /// In how many ways (see [`SearchSettings::way`]) the parts of the first generations are
    /// cut, each followed to its end; empty for one way everywhere.
    pub ways: Vec<usize>,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings {
            metric: Metric::Thickening,
            policy: PolicyChoice::Greedy,
            planes: 20,
            expand: 14,
            quota: 3,
            second: 8,
            norm: Norm::Sum(1.0),
            excess: 0.1,
            undone: 0.0,
            samples: 2000,
            buried: 0.3,
            refine: 8,
            ladder: vec![4800, 1200, 300],
            fewest: 150,
            section: 0.05,
            thinnest: 2.5,
            sectors: Sectors::Foreseen,
            depth: 3,
            iterations: 150,
            exploration: 1.0,
            seed: 0,
            patience: 1,
            faces: 12,
            face: 4.0,
            second_faces: 6,
            oblique: 4,
            notched: 4.0,
            second_share: 0.4,
            frame: FrameChoice::Faces,
            slim: 0.1,
            gap: 0.05,
            cells: 1000,
            most_vertices: 0,
            merging: true,
            prisms: Prisms::Plane,
            merge_order: MergeOrder::Relative,
            ways: Vec::new(),
        }
    }
}

impl SearchSettings {
    /// Way `k` of cutting: the settings themselves, the other policy (one step ahead or two), the
    /// worst part instead of the sum, both. Of all variations tried these differ most; their
    /// grids differ too.
    #[must_use]
    pub fn way(&self, k: usize) -> SearchSettings {
        let other = match self.policy {
            PolicyChoice::Greedy => PolicyChoice::Lookahead,
            PolicyChoice::Lookahead | PolicyChoice::Mcts => PolicyChoice::Greedy,
        };
        let k = k % 4;
        SearchSettings {
            planes: self.planes + k,
            second: self.second + k / 2,
            policy: if k % 2 == 1 { other } else { self.policy },
            norm: if k >= 2 { Norm::Worst } else { self.norm },
            ..self.clone()
        }
    }

    /// Set one parameter by its name, as text.
    ///
    /// # Errors
    /// A sentence that names the parameter or the value that does not fit.
    // One arm a parameter.
    #[allow(clippy::too_many_lines)]
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        fn number<T: std::str::FromStr>(name: &str, value: &str) -> Result<T, String> {
            value
                .parse()
                .map_err(|_| format!("parameter '{name}': '{value}' is not a number that fits"))
        }
        fn list(name: &str, value: &str) -> Result<Vec<usize>, String> {
            let words = value.split(',').filter(|v| !v.is_empty());
            words.map(|v| number(name, v.trim())).collect()
        }
        fn choice<T>(name: &str, value: &str, known: Option<T>, all: &str) -> Result<T, String> {
            known.ok_or_else(|| format!("parameter '{name}': '{value}' is none of {all}"))
        }
        match name {
            "metric" => {
                let known = match value {
                    "thickening" => Some(Metric::Thickening),
                    "concavity" => Some(Metric::Concavity),
                    _ => None,
                };
                self.metric = choice(name, value, known, "thickening, concavity")?;
            }
            "policy" => {
                let known = match value {
                    "greedy" => Some(PolicyChoice::Greedy),
                    "lookahead" => Some(PolicyChoice::Lookahead),
                    "mcts" => Some(PolicyChoice::Mcts),
                    _ => None,
                };
                self.policy = choice(name, value, known, "greedy, lookahead, mcts")?;
            }
            "sectors" => {
                let known = match value {
                    "foreseen" => Some(Sectors::Foreseen),
                    "ignored" => Some(Sectors::Ignored),
                    _ => None,
                };
                self.sectors = choice(name, value, known, "foreseen, ignored")?;
            }
            "norm" => {
                self.norm = if value == "worst" {
                    Norm::Worst
                } else {
                    Norm::Sum(number(name, value)?)
                };
            }
            "frame" => {
                let known = match value {
                    "mesh" => Some(FrameChoice::Mesh),
                    "faces" => Some(FrameChoice::Faces),
                    "principal" => Some(FrameChoice::Principal),
                    _ => None,
                };
                self.frame = choice(name, value, known, "mesh, faces, principal")?;
            }
            "most_vertices" => self.most_vertices = number(name, value)?,
            "merge_order" => {
                let known = match value {
                    "added" => Some(MergeOrder::Added),
                    "relative" => Some(MergeOrder::Relative),
                    "smallest" => Some(MergeOrder::Smallest),
                    _ => None,
                };
                self.merge_order = choice(name, value, known, "added, relative, smallest")?;
            }
            "cells" => self.cells = number(name, value)?,
            "gap" => self.gap = number(name, value)?,
            "slim" => self.slim = number(name, value)?,
            "merging" => self.merging = choice(name, value, switch(value), "on, off")?,
            "prisms" => self.prisms = choice(name, value, prisms(value), "plane, search")?,
            "ladder" => self.ladder = list(name, value)?,
            "ways" => self.ways = list(name, value)?,
            "depth" => self.depth = number(name, value)?,
            "exploration" => self.exploration = number(name, value)?,
            "iterations" => self.iterations = number(name, value)?,
            "seed" => self.seed = number(name, value)?,
            "patience" => self.patience = number(name, value)?,
            "planes" => self.planes = number(name, value)?,
            "expand" => self.expand = number(name, value)?,
            "quota" => self.quota = number(name, value)?,
            "second" => self.second = number(name, value)?,
            "excess" => self.excess = number(name, value)?,
            "undone" => self.undone = number(name, value)?,
            "samples" => self.samples = number(name, value)?,
            "buried" => self.buried = number(name, value)?,
            "refine" => self.refine = number(name, value)?,
            "fewest" => self.fewest = number(name, value)?,
            "section" => self.section = number(name, value)?,
            "thinnest" => self.thinnest = number(name, value)?,
            "faces" => self.faces = number(name, value)?,
            "face" => self.face = number(name, value)?,
            "oblique" => self.oblique = number(name, value)?,
            "second_share" => self.second_share = number(name, value)?,
            "notched" => self.notched = number(name, value)?,
            "second_faces" => self.second_faces = number(name, value)?,
            _ => return Err(format!("'{name}' is no parameter of the search")),
        }
        Ok(())
    }
}

fn prisms(value: &str) -> Option<Prisms> {
    match value {
        "plane" => Some(Prisms::Plane),
        "search" => Some(Prisms::Search),
        _ => None,
    }
}

fn switch(value: &str) -> Option<bool> {
    match value {
        "on" => Some(true),
        "off" => Some(false),
        _ => None,
    }
}

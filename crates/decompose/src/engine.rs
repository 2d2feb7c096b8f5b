//! Algorithm 1: cut until every part is proved, then merge.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::HullError;
use assetpipe_geometry::{Mesh, Plane};
use glam::DVec3;
use rayon::prelude::*;

use crate::candidates::{flat_faces, sector};
use crate::concavity::{Decision, Interval};
use crate::control::Control;
use crate::error::DecomposeError;
use crate::forbidden;
use crate::judge::Judge;
use crate::merge::{merge, Proved};
use crate::part::{connected_parts, Part};
use crate::proxy;
use crate::search::lookahead::{extent, Lookahead, Question};
use crate::search::piece::Piece;
use crate::search::trial::Basis;
use crate::settings::{Metric, SearchSettings};

/// More parts than this mean that the tolerance does not fit the solid.
const MOST_PARTS: usize = 20_000;

/// Hulls that cover the solid, and what they were made from.
pub struct Cover {
    /// The hulls; `members` are indices of `parts`.
    pub hulls: Vec<Proved>,
    /// The parts before merging.
    pub parts: Vec<Piece>,
}

/// Decompose a closed solid in its working copy.
///
/// # Errors
/// [`DecomposeError`].
pub fn decompose_working(
    mesh: &Mesh,
    judge: &Judge<'_>,
    settings: &SearchSettings,
    control: &Control,
) -> Result<Cover, DecomposeError> {
    let mut frontier = Vec::new();
    for piece in crate::part::components(Piece::from(mesh)) {
        let closed = Mesh {
            vertices: piece.points.clone(),
            triangles: piece.triangles.clone(),
        };
        let levels = proxy::ladder(&closed, &settings.ladder)
            .iter()
            .map(Piece::from)
            .collect();
        frontier.extend(connected_parts(piece, levels).map_err(internal)?);
    }
    let total_volume = frontier.iter().map(|p| p.piece.volume()).sum::<f64>();
    let mut open_volume = total_volume;
    let mut witnesses = Vec::new();
    let mut done: Vec<Proved> = Vec::new();
    let mut parts: Vec<Piece> = Vec::new();
    while !frontier.is_empty() {
        // All parts of one generation side by side; taken in their order, so
        // the result does not depend on who was first.
        let steps: Vec<Step> = frontier
            .into_par_iter()
            .map(|part| step(judge, part, settings))
            .collect::<Result<_, _>>()?;
        frontier = Vec::new();
        for step in steps {
            match step {
                Step::Done {
                    hull,
                    thickening,
                    piece,
                } => {
                    open_volume -= piece.volume();
                    let members = vec![done.len() as u32];
                    done.push(Proved {
                        hull,
                        thickening,
                        members,
                    });
                    parts.push(piece);
                }
                Step::Cut { children, witness } => {
                    witnesses.extend(witness);
                    frontier.extend(children);
                }
            }
        }
        // Merging and the coarser levels are about a tenth of the work.
        control.report(0.9 * (1.0 - open_volume / total_volume));
        if done.len() + frontier.len() > MOST_PARTS {
            return Err(DecomposeError::TooManyParts { limit: MOST_PARTS });
        }
    }
    if settings.merging {
        done = merge(judge, done, &parts, settings.merge_order, &mut witnesses);
    }
    if control.is_cancelled() {
        return Err(DecomposeError::Cancelled);
    }
    Ok(Cover { hulls: done, parts })
}

/// What becomes of a part.
enum Step {
    /// Its hull is proved.
    Done {
        hull: Mesh,
        thickening: Interval,
        piece: Piece,
    },
    /// It was cut; the witness is why.
    Cut {
        children: Vec<Part>,
        witness: Option<DVec3>,
    },
}

fn step(judge: &Judge<'_>, part: Part, settings: &SearchSettings) -> Result<Step, DecomposeError> {
    if (judge.limits.cancelled)() {
        return Err(DecomposeError::Cancelled);
    }
    let witness = match judge.decide(&part.hull, &[&part.piece]) {
        Decision::Within(thickening) => {
            return Ok(Step::Done {
                hull: part.hull,
                thickening,
                piece: part.piece,
            });
        }
        Decision::Beyond { witness, .. } if judge.metric == Metric::Thickening => Some(witness),
        Decision::Beyond { .. } | Decision::Unproven(_) => None,
    };
    if is_void(judge.solid, &part.hull) {
        return Ok(Step::Cut {
            children: Vec::new(),
            witness: None,
        });
    }
    // Without surface there is nothing for the search to see: bisection ends, because
    // hulls smaller than ε are either void or within ε.
    let plane = if part.piece.triangles.is_empty() {
        halve(&part.hull.vertices)
    } else {
        cut(judge, &part, settings)
    };
    Ok(Step::Cut {
        children: part.split(plane).map_err(internal)?,
        witness,
    })
}

/// Whether no point of the hull belongs to the solid, proved by a ball around it
/// that no surface enters. Such a hull covers nothing, and cutting it could go on
/// for ever: it comes from a shell that is wound inside out where no other encloses it.
fn is_void(solid: &SolidIndex, hull: &Mesh) -> bool {
    let centre = hull.vertices.iter().sum::<DVec3>() / hull.vertices.len() as f64;
    let radius = hull
        .vertices
        .iter()
        .map(|v| v.distance(centre))
        .fold(0.0, f64::max);
    solid.distance(centre) > radius + solid.slack()
}

#[allow(clippy::needless_pass_by_value)]
fn internal(error: HullError) -> DecomposeError {
    DecomposeError::Internal(error.to_string())
}

/// The plane that cuts a part.
fn cut(judge: &Judge<'_>, part: &Part, settings: &SearchSettings) -> Plane {
    let epsilon = judge.epsilon;
    let directions: Vec<Basis> = (0..3).map(Basis::axis).collect();
    let flat = |most: usize| -> Vec<Vec<f64>> {
        let (area, gap) = (settings.face * epsilon * epsilon, 1e-4 * epsilon);
        directions
            .iter()
            .map(|b| flat_faces::offsets(&part.piece, b.w, area, gap, most))
            .collect()
    };
    let (extra, extra_second) = (flat(settings.faces), flat(settings.second_faces));
    let samples = forbidden::sample(judge.solid, &part.hull, epsilon, settings.samples);
    let axial = directions
        .iter()
        .filter_map(|basis| {
            let extent = extent(&part.hull.vertices, basis.w);
            sector::plane(&part.piece, basis, extent, &samples, epsilon)
        })
        .reduce(|a, b| if b.1 > a.1 { b } else { a });
    if let Some((plane, _)) = axial {
        return plane;
    }
    let question = Question {
        piece: part.stand_in(settings.fewest),
        forbidden: &samples,
        directions: &directions,
        extra: &extra,
        extra_second: &extra_second,
        epsilon,
        settings,
    };
    if let Some(choice) = Lookahead::new(&question).choose() {
        let w = directions[choice.direction].w;
        let (lo, hi) = extent(&part.hull.vertices, w);
        if choice.offset > lo && choice.offset < hi {
            return Plane {
                normal: w,
                offset: choice.offset,
            };
        }
    }
    halve(&part.hull.vertices)
}

/// Through the middle of the longest side: always ends, because hulls smaller
/// than ε are within ε.
fn halve(points: &[DVec3]) -> Plane {
    let (lo, hi) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        });
    let size = hi - lo;
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    Plane::axis_aligned(axis, 0.5 * (lo[axis] + hi[axis]))
}

//! One part: proved, or cut where the search says.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::HullError;
use assetpipe_geometry::{Mesh, Plane};
use glam::DVec3;

use crate::buried;
use crate::candidates::{flat_faces, notch, sector};
use crate::concavity::{Decision, Interval};
use crate::error::DecomposeError;
use crate::even;
use crate::forbidden;
use crate::judge::Judge;
use crate::merge::volume;
use crate::part::Part;
use crate::progress::{progress, Lineage, MOST_CUTS};
use crate::search::piece::Piece;
use crate::search::policy::{policy, Question};
use crate::search::price::extent;
use crate::search::sweep::{Basis, Side};
use crate::settings::{Metric, SearchSettings, Sectors};

/// A part to decide about.
pub type Open = (Part, Lineage);

/// What becomes of a part.
pub enum Step {
    /// Its hull is proved.
    Done {
        /// The hull.
        hull: Mesh,
        /// What is proved.
        thickening: Interval,
        /// The part.
        piece: Piece,
    },
    /// It was cut.
    Cut {
        /// Where.
        plane: Plane,
        /// Into what.
        children: Vec<Open>,
        /// A point of the hull farther than ε from the solid, if that was the reason.
        witness: Option<DVec3>,
    },
}

/// Prove a part or cut it.
///
/// # Errors
/// [`DecomposeError`].
pub fn step(
    judge: &Judge<'_>,
    (part, lineage): Open,
    settings: &SearchSettings,
) -> Result<Step, DecomposeError> {
    judge.go_on()?;
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
            plane: Plane::axis_aligned(0, 0.0),
            children: Vec::new(),
            witness: None,
        });
    }
    // Without surface there is nothing for the search to see: bisection ends, because
    // hulls smaller than ε are either void or within ε.
    let (plane, lineage) = if part.piece.triangles.is_empty() {
        let plane = halve(&part.hull.vertices, &|_| true);
        (plane, lineage.after(plane.normal, true))
    } else {
        cut(judge, &part, lineage, settings)
    };
    let children = part.split(plane).map_err(internal)?;
    let children = children.into_iter().enumerate();
    Ok(Step::Cut {
        plane,
        children: children.map(|(i, c)| (c, lineage.child(i))).collect(),
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

/// A hull that should have been possible.
#[allow(clippy::needless_pass_by_value)]
pub fn internal(error: HullError) -> DecomposeError {
    DecomposeError::Internal(error.to_string())
}

/// The plane that cuts a part, and the part's lineage after it.
fn cut(
    judge: &Judge<'_>,
    part: &Part,
    lineage: Lineage,
    settings: &SearchSettings,
) -> (Plane, Lineage) {
    let epsilon = judge.epsilon;
    let open = |w: DVec3| !lineage.closed(w, settings.patience);
    let halve = || {
        let plane = halve(&part.hull.vertices, &open);
        (plane, lineage.after(plane.normal, true))
    };
    if lineage.cuts >= MOST_CUTS {
        return halve();
    }
    let mut samples = forbidden::sample(judge.solid, &part.hull, epsilon, settings.samples);
    let mut directions: Vec<Basis> = (0..3).map(Basis::axis).collect();
    if settings.sectors == Sectors::Foreseen {
        let best = directions
            .iter()
            .filter_map(|basis| {
                let extent = extent(&part.hull.vertices, basis.w);
                sector::plane(&part.piece, basis, extent, &samples, epsilon)
            })
            .reduce(|a, b| {
                if even::weight(b.1) > even::weight(a.1) {
                    b
                } else {
                    a
                }
            });
        if let Some((plane, _)) = best {
            return (plane, lineage.after(plane.normal, true));
        }
    }
    if judge.metric == Metric::Concavity && settings.buried > 0.0 {
        let (count, height) = (settings.samples / 2, settings.buried * epsilon);
        let stand_in = part.stand_in(settings.fewest);
        samples.extend(buried::sample(stand_in, &part.hull, epsilon, count, height));
    }
    // If all are closed, all are open again.
    if directions.iter().any(|b| open(b.w)) {
        directions.retain(|b| open(b.w));
    }
    let flat = |most: usize| -> Vec<Vec<f64>> {
        let (area, gap) = (settings.face * epsilon * epsilon, 1e-4 * epsilon);
        directions
            .iter()
            .map(|b| flat_faces::offsets(&part.piece, b.w, area, gap, most))
            .collect()
    };
    let (mut extra, mut extra_second) = (flat(settings.faces), flat(settings.second_faces));
    let gridded = directions.len();
    let least = settings.notched * epsilon;
    for (plane, share) in notch::planes(&part.notches, epsilon, least, settings.oblique) {
        if open(plane.normal) {
            directions.push(Basis::along(plane.normal));
            extra.push(vec![plane.offset]);
            let second = share >= settings.second_share;
            extra_second.push(if second {
                vec![plane.offset]
            } else {
                Vec::new()
            });
        }
    }
    let question = Question {
        piece: part.stand_in(settings.fewest),
        forbidden: &samples,
        directions: &directions,
        gridded,
        extra: &extra,
        extra_second: &extra_second,
        epsilon,
        key: lineage.key,
        settings,
    };
    let Some(choice) = policy(settings.policy).choose(&question) else {
        return halve();
    };
    let w = directions[choice.direction].w;
    let (lo, hi) = extent(&part.hull.vertices, w);
    if choice.offset <= lo || choice.offset >= hi {
        return halve();
    }
    let whole = Side {
        part: part.piece.volume(),
        hull: volume(&part.hull),
        forbidden: samples.iter().map(|s| s.weight).sum(),
    };
    let progress = progress(&whole, &choice, settings.excess);
    let plane = Plane {
        normal: w,
        offset: on_vertices(&part.piece, w, choice.offset),
    };
    (plane, lineage.after(w, progress))
}

/// The height of a cut, through the vertices that are beside it by rounding only: those of a lattice,
/// say, that a plane of the grid goes through.
fn on_vertices(piece: &Piece, w: DVec3, offset: f64) -> f64 {
    let near = piece.points.iter().map(|p| w.dot(*p));
    let near = near.filter(|h| (h - offset).abs() <= even::ROUNDING);
    let closer = |a: f64, b: f64| {
        let (off_a, off_b) = ((a - offset).abs(), (b - offset).abs());
        if off_b < off_a {
            b
        } else {
            a
        }
    };
    near.reduce(closer).unwrap_or(offset)
}

/// Through the middle of the longest side that is not closed: always ends, because hulls
/// smaller than ε are within ε.
fn halve(points: &[DVec3], open: &dyn Fn(DVec3) -> bool) -> Plane {
    let size = |axis: usize| {
        let (lo, hi) = extent(points, DVec3::AXES[axis]);
        hi - lo
    };
    let longest = |a: usize, b: usize| {
        if even::length(size(b)) > even::length(size(a)) {
            b
        } else {
            a
        }
    };
    let axis = (0..3)
        .filter(|&axis| open(DVec3::AXES[axis]))
        .reduce(longest)
        .unwrap_or((1..3).fold(0, longest));
    let (lo, hi) = extent(points, DVec3::AXES[axis]);
    Plane::axis_aligned(axis, 0.5 * (lo + hi))
}

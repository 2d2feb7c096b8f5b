//! Extruded outlines: decomposed in the plane, then extruded.
//!
//! A hull of an extruded part is within ε of the solid exactly if the hull of
//! its outline is within ε of the solid's outline, so the plane decides, and
//! there cuts need not be planes through the whole part: diagonals end at
//! notches (Lien & Amato 2006). The hulls are proved and merged like all others.

mod extrude;
mod prism;
#[cfg(test)]
mod tests;

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use assetpipe_polygon::{
    decompose, signed_area, DiagonalWeights, HoleAxis, Measure, Parameters, Part,
};

use crate::concavity::Decision;
use crate::engine::Cover;
use crate::judge::Judge;
use crate::merge::{merge, volume, Proved};
use crate::settings::{Prisms, SearchSettings};

/// Outlines are decomposed to these shares of ε; the fewest hulls are kept.
const TOLERANCES: [f64; 3] = [1.0, 0.5, 0.0];

/// What the two outlines of a prism may differ by, as a share of ε. Parts have
/// the solid's own corners, so the difference costs no coverage; it only makes
/// the walls a little oblique, which the proof of each hull sees.
const OBLIQUE: f64 = 0.02;

/// More parts than this are left to the search.
const MOST_PARTS: usize = 400;

/// A proved cover of a solid that is an extruded outline along one of its
/// axes; `None` for all others, and where no proof succeeds.
pub fn cover(mesh: &Mesh, judge: &Judge<'_>, settings: &SearchSettings) -> Option<Cover> {
    if settings.prisms == Prisms::Search {
        return None;
    }
    let prism = (0..3).find_map(|axis| prism::detect(mesh, axis, OBLIQUE * judge.epsilon))?;
    let mut best: Option<Cover> = None;
    for share in TOLERANCES {
        let parameters = Parameters {
            tolerance: share * judge.epsilon,
            measure: Measure::ShortestPath,
            hole_axis: HoleAxis::Principal,
            weights: DiagonalWeights::default(),
        };
        let outlines = decompose(&prism.rings, &parameters)
            .ok()?
            .at(parameters.tolerance);
        let filled: f64 = outlines.iter().map(Part::area).sum();
        let whole: f64 = prism.rings.iter().map(|r| signed_area(r)).sum();
        // Rings that wind around something twice are no outline.
        if outlines.len() > MOST_PARTS || (filled - whole).abs() > 1e-9 * whole {
            continue;
        }
        let Some(parts) = extrude::pieces(mesh, &prism, &outlines) else {
            continue;
        };
        let Some(hulls) = parts
            .iter()
            .zip(0..)
            .map(|(part, index)| {
                let hull = convex_hull(&part.points).ok()?;
                match judge.decide(&hull, &[part]) {
                    Decision::Within(thickening) => Some(Proved {
                        hull,
                        thickening,
                        members: vec![index],
                    }),
                    Decision::Beyond { .. } | Decision::Unproven(_) => None,
                }
            })
            .collect::<Option<Vec<Proved>>>()
        else {
            continue;
        };
        let hulls = if settings.merging {
            merge(judge, hulls, &parts, settings.merge_order, &mut Vec::new())
        } else {
            hulls
        };
        let found = Cover {
            hulls,
            parts,
            ..Cover::default()
        };
        best = Some(match best {
            Some(best) if !is_better(&found, &best) => best,
            _ => found,
        });
    }
    best
}

/// Fewer hulls, or as many and less volume.
pub fn is_better(one: &Cover, other: &Cover) -> bool {
    let size = |cover: &Cover| cover.hulls.iter().map(|h| volume(&h.hull)).sum::<f64>();
    (one.hulls.len(), size(one)) < (other.hulls.len(), size(other))
}

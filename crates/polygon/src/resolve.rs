//! Which diagonal removes a notch (Algorithm 4.2, Eq. 8).

use crate::arrangement::Triangulation;
use crate::boundary::Boundary;
use crate::point::orient;
use crate::visibility;
use crate::Point;

/// Weights of Eq. 8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagonalWeights {
    /// `s_c`: how much the concavity of the far end counts.
    pub concavity: f64,
    /// `s_d`: how much the length counts against it.
    pub distance: f64,
}

impl Default for DiagonalWeights {
    /// The paper's experiments: `s_c = 0.1`, `s_d = 1` (§7.2).
    fn default() -> Self {
        Self {
            concavity: 0.1,
            distance: 1.0,
        }
    }
}

/// The corner to which the notch `r` is joined: the highest Eq. 8 score among
/// all visible corners whose diagonal leaves no reflex angle at `r`.
///
/// Such a corner need not exist when no Steiner points are allowed; Eq. 8 is
/// zero everywhere then. The same score without that condition picks among
/// the notch's neighbours in the constrained Delaunay triangulation, of which
/// the nearest visible corner is one, and a later diagonal resolves what
/// remains of the notch. `largest` bounds every concavity of the part; with it
/// the search stops where no score can win any more.
pub(crate) fn diagonal(
    cdt: &Triangulation,
    boundary: &Boundary,
    r: u32,
    concavity: &[f64],
    largest: f64,
    weights: DiagonalWeights,
) -> Option<u32> {
    let [p, eye, q] = [boundary.previous(r), r, boundary.next(r)].map(|c| boundary.point(c));
    let right_of_both = |a: Point, b: Point, from: Point, to: Point| {
        orient(from, to, a) < 0.0 && orient(from, to, b) < 0.0
    };
    let wedge = |a, b| !right_of_both(a, b, p, eye) && !right_of_both(a, b, eye, q);
    let resolves = |x| orient(p, eye, x) >= 0.0 && orient(eye, q, x) >= 0.0;
    let best = |open: &dyn Fn(Point, Point) -> bool, accepts: &dyn Fn(Point) -> bool| {
        let mut best: Option<(f64, u32, u32)> = None;
        visibility::from_corner(cdt, boundary, r, open, |vertex, distance| {
            let reach = |best: Option<(f64, u32, u32)>| {
                best.map_or(f64::INFINITY, |b| {
                    (1.0 + weights.concavity * largest) / (weights.distance * b.0)
                })
            };
            if distance <= reach(best) && accepts(boundary.points[vertex as usize]) {
                if let Some(corner) = boundary.facing(vertex, eye) {
                    let score = (1.0 + weights.concavity * concavity[corner as usize])
                        / (weights.distance * distance);
                    if best.is_none_or(|b| score > b.0 || (score == b.0 && vertex < b.1)) {
                        best = Some((score, vertex, corner));
                    }
                }
            }
            reach(best)
        });
        best.map(|found| found.2)
    };
    best(&wedge, &resolves).or_else(|| best(&|_, _| false, &|_| true))
}

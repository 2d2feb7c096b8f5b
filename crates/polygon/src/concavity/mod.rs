//! Concavity of boundary points (Lien & Amato 2006, §5.1): how far a point
//! of a pocket is from the pocket's bridge.

mod hybrid;
mod sl;
mod sp;

use crate::boundary::Boundary;

pub(crate) use sp::Loops;

/// How concavity is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Straight line to the bridge (§5.1.1). Fast; may grow while decomposing.
    StraightLine,
    /// Shortest path to the bridge inside the pocket (§5.1.2). Never grows (Lemma 5.3).
    ShortestPath,
    /// Straight line where that cannot grow, else shortest path (Algorithm 5.2).
    Hybrid1,
    /// Straight line while it exceeds the tolerance, then as `Hybrid1` (Algorithm 5.3).
    Hybrid2,
}

/// The most concave notch of a pocket.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Witness {
    pub value: f64,
    pub corner: u32,
}

/// Measures the pocket `chain`, whose first and last corner are the bridge.
/// Writes the concavity of its inner corners into `concavity`; returns the
/// witness, a notch by Lemma 6.2.
pub(crate) fn measure_pocket(
    measure: Measure,
    tolerance: f64,
    boundary: &Boundary,
    chain: &[u32],
    loops: &mut Loops,
    concavity: &mut [f64],
) -> Option<Witness> {
    let straight = match measure {
        Measure::StraightLine => true,
        Measure::ShortestPath => false,
        Measure::Hybrid1 => !hybrid::hazard(boundary, chain),
        Measure::Hybrid2 => {
            sl::measure(boundary, chain, concavity);
            let found = witness(boundary, chain, concavity);
            if found.is_some_and(|w| w.value > tolerance) || !hybrid::hazard(boundary, chain) {
                return found;
            }
            false
        }
    };
    if straight {
        sl::measure(boundary, chain, concavity);
    } else {
        sp::measure(boundary, chain, loops, concavity);
    }
    witness(boundary, chain, concavity)
}

/// Breaks ties between equally concave notches. Spread out instead of in a
/// row, so that a comb is halved again and again and not eaten from one end.
pub(crate) fn scattered(vertex: u32) -> u32 {
    vertex.wrapping_mul(0x9E37_79B1)
}

/// The notch of largest concavity.
fn witness(boundary: &Boundary, chain: &[u32], concavity: &mut [f64]) -> Option<Witness> {
    let mut best: Option<Witness> = None;
    for &corner in &chain[1..chain.len() - 1] {
        // a corner strictly inside the hull is concave however small the number (Lemma 6.1)
        let value = concavity[corner as usize].max(f64::MIN_POSITIVE);
        concavity[corner as usize] = value;
        let better = best.is_none_or(|b| {
            value > b.value
                || (value == b.value
                    && scattered(boundary.vertex[corner as usize])
                        < scattered(boundary.vertex[b.corner as usize]))
        });
        if better && boundary.is_notch(corner) {
            best = Some(Witness { value, corner });
        }
    }
    best
}

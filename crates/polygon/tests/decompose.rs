//! Decomposition on shapes that have broken it, and on those that might.

use assetpipe_polygon::{decompose, DiagonalWeights, HoleAxis, Measure, Parameters, Point};

fn ring(points: &[(f64, f64)]) -> Vec<Point> {
    points.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

fn parameters(measure: Measure, tolerance: f64) -> Parameters {
    Parameters {
        tolerance,
        measure,
        hole_axis: HoleAxis::Medial,
        weights: DiagonalWeights::default(),
    }
}

#[test]
fn nine_vertices() {
    let outline = ring(&[
        (6.006974136712772, 6.168530436445279),
        (2.097138058642415, 7.084454403447965),
        (1.6833681801039801, 8.031389235812547),
        (-3.4184011770958587, 5.335696626287478),
        (-5.329954930124696, 5.6225609763842925),
        (-8.022262155137229, 1.1527980912412632),
        (-9.782325110229246, -0.16445308468924547),
        (0.7979417314110231, -5.54390234265885),
        (2.5281451418045964, -6.279257032520091),
    ]);
    let found = decompose(&[outline], &parameters(Measure::StraightLine, 0.0)).unwrap();
    for part in found.at(0.0) {
        println!("{part:?}");
    }
    panic!();
}

//! Decomposition on shapes that have broken it, and on those that might.

// coordinates as they were found; a test may fail by panic
#![allow(clippy::unreadable_literal, clippy::unwrap_used)]

use std::slice::from_ref;

use assetpipe_polygon::{
    convex_hull, decompose, orient, signed_area, DiagonalWeights, Hierarchy, HoleAxis, Measure,
    OutlineError, Parameters, Part, Point,
};

const MEASURES: [Measure; 4] = [
    Measure::StraightLine,
    Measure::ShortestPath,
    Measure::Hybrid1,
    Measure::Hybrid2,
];

fn ring(points: &[(f64, f64)]) -> Vec<Point> {
    points.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

fn run(rings: &[Vec<Point>], measure: Measure, tolerance: f64) -> Hierarchy {
    let parameters = Parameters {
        tolerance,
        measure,
        hole_axis: HoleAxis::Medial,
        weights: DiagonalWeights::default(),
    };
    decompose(rings, &parameters).unwrap()
}

fn area(parts: &[Part]) -> f64 {
    parts.iter().map(Part::area).sum()
}

/// Every corner turns left or goes straight, by exact sign.
fn is_convex(part: &Part) -> bool {
    let n = part.outer.len();
    let at = |k: usize| part.outer[k % n];
    part.holes.is_empty() && (0..n).all(|k| orient(at(k), at(k + 1), at(k + 2)) >= 0.0)
}

fn comb(teeth: i32) -> Vec<Point> {
    let mut outline = ring(&[(0.0, -1.0), (f64::from(teeth), -1.0)]);
    for k in (0..teeth).rev() {
        outline.push(Point::new(f64::from(k) + 0.75, 9.0));
        outline.push(Point::new(f64::from(k) + 0.5, 0.0));
    }
    outline
}

fn spiral(steps: i32) -> Vec<Point> {
    let arm = |shift: f64| {
        (0..steps).map(move |k| {
            let t = f64::from(k) * 12.0 / f64::from(steps) + 0.3;
            let r = 1.0 + t + shift;
            Point::new(r * libm::cos(t), r * libm::sin(t))
        })
    };
    arm(2.0)
        .chain(arm(0.0).collect::<Vec<_>>().into_iter().rev())
        .collect()
}

/// Broke once: after a cut, the pocket behind its far end was forgotten.
#[test]
fn pocket_behind_the_far_end() {
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
    for measure in MEASURES {
        assert!(run(from_ref(&outline), measure, 0.0)
            .at(0.0)
            .iter()
            .all(is_convex));
    }
}

/// Lemma 6.3 and Theorem 6.4: no tolerance, no notch left.
#[test]
fn theorem_6_4_zero_tolerance_is_exactly_convex() {
    for outline in [comb(50), spiral(200)] {
        let exact = signed_area(&outline);
        for measure in MEASURES {
            let levels = run(from_ref(&outline), measure, 0.0);
            let parts = levels.at(0.0);
            assert!(parts.iter().all(is_convex));
            assert!((area(&parts) - exact).abs() <= 1e-12 * exact);
            assert!((Hierarchy::convexity(&parts) - 1.0).abs() <= 1e-12);
        }
    }
}

/// Figure 7: with straight lines a notch may be under-measured until a cut
/// uncovers it; shortest paths never grow (Lemma 5.3).
#[test]
fn figure_7_straight_lines_grow_and_shortest_paths_do_not() {
    // a corridor goes down, right, up and back left, under the boundary
    let corridor = ring(&[
        (0.0, 8.0),
        (0.0, 0.0),
        (13.0, 0.0),
        (13.0, 8.0),
        (2.4, 8.0),
        (2.4, 2.4),
        (9.6, 2.4),
        (9.6, 2.6),
        (3.6, 2.6),
        (3.6, 3.4),
        (10.4, 3.4),
        (10.4, 1.6),
        (1.6, 1.6),
        (1.6, 8.0),
    ]);
    let growth = |measure| {
        let descents = run(from_ref(&corridor), measure, 0.0).descents();
        descents
            .iter()
            .map(|&(after, before)| after / before)
            .fold(0.0, f64::max)
    };
    assert!(growth(Measure::StraightLine) > 2.0);
    assert!(growth(Measure::ShortestPath) <= 1.0 + 1e-12);
    assert!(growth(Measure::Hybrid1) <= 1.0 + 1e-12);
    let measured = |measure| run(from_ref(&corridor), measure, f64::MAX).at(f64::MAX)[0].concavity;
    assert!(measured(Measure::ShortestPath) > 1.8 * measured(Measure::StraightLine));
    assert_eq!(measured(Measure::ShortestPath), measured(Measure::Hybrid1));
}

#[test]
fn a_comb_of_many_teeth_needs_one_part_a_tooth() {
    let teeth = 300;
    let parts = run(&[comb(teeth)], Measure::ShortestPath, 0.0).at(0.0);
    assert_eq!(parts.len(), teeth as usize + 1);
}

/// §5.2: holes stay in while Eq. 5 is within the tolerance, and are merged
/// otherwise.
#[test]
fn holes_are_kept_or_merged() {
    let frame = |a: f64, b: f64| ring(&[(a, a), (b, a), (b, b), (a, b)]);
    let rings = [frame(0.0, 10.0), frame(4.0, 6.0), frame(7.0, 8.0)];
    for axis in [HoleAxis::Principal, HoleAxis::Medial] {
        let parameters = Parameters {
            tolerance: 0.0,
            measure: Measure::ShortestPath,
            hole_axis: axis,
            weights: DiagonalWeights::default(),
        };
        let levels = decompose(&rings, &parameters).unwrap();
        let coarse = levels.at(1e9);
        assert_eq!((coarse.len(), coarse[0].holes.len()), (1, 2));
        assert_eq!(area(&coarse), 95.0);
        let fine = levels.at(0.0);
        assert!(fine.iter().all(is_convex));
        assert_eq!(area(&fine), 95.0);
        let hulls: f64 = fine
            .iter()
            .map(|p| signed_area(&convex_hull(&p.outer)))
            .sum();
        assert_eq!(hulls, 95.0);
    }
}

/// Touching holes: at a vertex, along an edge's inside, in a chain that cuts
/// the interior in two.
#[test]
fn holes_that_touch() {
    let outer = ring(&[(0., 0.), (12., 0.), (12., 9.), (0., 9.)]);
    let cases = [
        vec![ring(&[(6., 0.), (8., 3.), (4., 3.)])],
        vec![
            ring(&[(6., 3.), (8., 5.), (4., 5.)]),
            ring(&[(6., 3.), (4., 1.), (8., 1.)]),
        ],
        vec![ring(&[(6., 0.), (8., 4.), (6., 9.), (4., 4.)])],
        vec![ring(&[(0., 0.), (5., 2.), (2., 5.)])],
    ];
    for holes in cases {
        let removed: f64 = holes.iter().map(|h| signed_area(h).abs()).sum();
        let mut rings = vec![outer.clone()];
        rings.extend(holes);
        for measure in MEASURES {
            for tolerance in [0.0, 0.5, 2.0, 1e9] {
                let parts = run(&rings, measure, tolerance).at(tolerance);
                assert!((area(&parts) - (108.0 - removed)).abs() < 1e-10);
            }
        }
    }
}

#[test]
fn what_is_no_outline_is_refused() {
    let refused = |rings: &[Vec<Point>]| {
        let parameters = Parameters {
            tolerance: 0.0,
            measure: Measure::ShortestPath,
            hole_axis: HoleAxis::Medial,
            weights: DiagonalWeights::default(),
        };
        decompose(rings, &parameters).unwrap_err()
    };
    let bow = ring(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.)]);
    assert!(matches!(
        refused(&[bow]),
        OutlineError::Crossing { ring: 0, .. }
    ));
    let flat = ring(&[(0., 0.), (2., 2.), (1., 1.)]);
    assert_eq!(refused(&[flat]), OutlineError::NoArea);
    let nan = ring(&[(0., 0.), (f64::NAN, 2.), (1., 0.)]);
    assert_eq!(
        refused(&[nan]),
        OutlineError::Coordinate { ring: 0, vertex: 1 }
    );
    assert_eq!(refused(&[]), OutlineError::NoArea);
}

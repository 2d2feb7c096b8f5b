//! Fillings against their definition: the boundary is the cycle, the area is
//! the cycle's, nothing overlaps.

use std::collections::BTreeMap;

use glam::DVec2;

use super::{fill, Edge, Filling};
use crate::predicates::orient2d;
use crate::sample::Random;

/// Closed polygons as points (equal ones shared) and edges.
fn cycle(loops: &[Vec<DVec2>]) -> (Vec<DVec2>, Vec<Edge>) {
    let mut points: Vec<DVec2> = Vec::new();
    let mut edges = Vec::new();
    for polygon in loops {
        let ids: Vec<u32> = polygon
            .iter()
            .map(|p| {
                let known = points.iter().position(|q| q == p);
                known.unwrap_or_else(|| {
                    points.push(*p);
                    points.len() - 1
                }) as u32
            })
            .collect();
        for i in 0..ids.len() {
            edges.push((ids[i], ids[(i + 1) % ids.len()], 1));
        }
    }
    (points, edges)
}

fn shoelace(points: &[DVec2], edges: &[Edge]) -> f64 {
    let at = |i: u32| points[i as usize];
    edges
        .iter()
        .map(|&(a, b, m)| f64::from(m) * at(a).perp_dot(at(b)))
        .sum::<f64>()
        / 2.0
}

/// Checks the boundary and returns the summed area.
fn check(points: &[DVec2], edges: &[Edge], filling: &Filling) -> f64 {
    let all: Vec<DVec2> = points.iter().chain(&filling.crossings).copied().collect();
    let mut net: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    let mut add = |a: u32, b: u32, m: i32| {
        let (pair, sign) = if a < b { ((a, b), m) } else { ((b, a), -m) };
        *net.entry(pair).or_default() += sign;
    };
    let mut stack = edges.to_vec();
    while let Some((a, b, m)) = stack.pop() {
        match filling.subdivided.get(&(a.min(b), a.max(b))) {
            Some(&via) => stack.extend([(a, via, m), (via, b, m)]),
            None => add(a, b, m),
        }
    }
    let mut area = 0.0;
    for &[a, b, c] in &filling.triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            add(p, q, -1);
        }
        let [a, b, c] = [a, b, c].map(|i| all[i as usize]);
        if !filling.is_fan {
            assert!(orient2d(a, b, c).is_ne(), "degenerate triangle");
        }
        area += (b - a).perp_dot(c - a) / 2.0;
    }
    assert!(
        net.values().all(|m| *m == 0),
        "the boundary differs from the cycle"
    );
    area
}

/// Fills, checks, and expects only counter-clockwise triangles.
fn region(loops: &[Vec<DVec2>]) -> (f64, Filling) {
    let (points, edges) = cycle(loops);
    let filling = fill(&points, &edges);
    let area = check(&points, &edges, &filling);
    let expected = shoelace(&points, &edges);
    assert!(
        (area - expected).abs() <= 1e-12 * (1.0 + expected.abs()),
        "{area} {expected}"
    );
    (area, filling)
}

fn all_counter_clockwise(loops: &[Vec<DVec2>], filling: &Filling) -> bool {
    let (mut points, _) = cycle(loops);
    points.extend(&filling.crossings);
    filling.triangles.iter().all(|t| {
        let [a, b, c] = t.map(|i| points[i as usize]);
        orient2d(a, b, c).is_gt()
    })
}

fn square(center: [f64; 2], half: f64) -> Vec<DVec2> {
    let c = DVec2::from(center);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| c + half * DVec2::new(x, y))
        .to_vec()
}

fn reversed(mut polygon: Vec<DVec2>) -> Vec<DVec2> {
    polygon.reverse();
    polygon
}

fn ring(n: u32, radius: f64) -> Vec<DVec2> {
    (0..n)
        .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(n))
        .map(|a| radius * DVec2::new(libm::cos(a), libm::sin(a)))
        .collect()
}

#[test]
fn nested_loops_alternate_between_filled_and_hole() {
    let loops = [
        square([0.0, 0.0], 4.0),
        reversed(square([0.0, 0.0], 3.0)),
        square([0.0, 0.0], 2.0),
        reversed(square([0.0, 0.0], 1.0)),
    ];
    let (area, filling) = region(&loops);
    assert_eq!(area, 64.0 - 36.0 + 16.0 - 4.0);
    assert!(!filling.is_fan && filling.crossings.is_empty());
    assert!(all_counter_clockwise(&loops, &filling));
}

#[test]
fn loops_may_touch_at_corners_along_edges_and_inside_edges() {
    let corner = [square([0.0, 0.0], 1.0), square([2.0, 2.0], 1.0)];
    assert_eq!(region(&corner).0, 8.0);
    let hole_at_corner = [square([0.0, 0.0], 2.0), reversed(square([1.0, 1.0], 1.0))];
    let (area, filling) = region(&hole_at_corner);
    assert_eq!(area, 12.0);
    assert!(all_counter_clockwise(&hole_at_corner, &filling));
    let diamond = vec![
        DVec2::new(2.0, 0.0),
        DVec2::new(0.0, 2.0),
        DVec2::new(-2.0, 0.0),
        DVec2::new(0.0, -2.0),
    ];
    let inscribed = [square([0.0, 0.0], 2.0), reversed(diamond)];
    let (area, filling) = region(&inscribed);
    assert_eq!(area, 8.0);
    assert_eq!(filling.subdivided.len(), 4);
    assert!(all_counter_clockwise(&inscribed, &filling));
}

#[test]
fn overlapping_and_crossing_loops_are_filled_as_often_as_they_wind() {
    let overlap = [square([0.0, 0.0], 1.0), square([1.0, 0.5], 1.0)];
    let (area, filling) = region(&overlap);
    assert_eq!(area, 8.0);
    assert_eq!(filling.crossings.len(), 2);
    assert!(!filling.is_fan);
    let bow_tie = vec![
        DVec2::ZERO,
        DVec2::new(2.0, 2.0),
        DVec2::new(2.0, 0.0),
        DVec2::new(0.0, 2.0),
    ];
    assert_eq!(region(&[bow_tie]).0, 0.0);
    let twice = [ring(9, 1.0), ring(9, 1.0)];
    assert!(region(&twice).1.triangles.windows(2).any(|w| w[0] == w[1]));
}

#[test]
fn a_region_without_area_has_no_triangles() {
    let line = vec![DVec2::ZERO, DVec2::X, 3.0 * DVec2::X, 2.0 * DVec2::X];
    assert!(region(&[line]).1.triangles.is_empty());
    assert!(fill(&[], &[]).triangles.is_empty());
}

#[test]
fn combs_spirals_and_cocircular_rings() {
    let mut comb = vec![DVec2::new(200.0, -1.0), DVec2::new(200.0, 0.0)];
    for i in (0..100).rev() {
        let x = 2.0 * f64::from(i);
        comb.extend([(x + 1.0, 0.0), (x + 1.0, 50.0), (x, 50.0), (x, 0.0)].map(DVec2::from));
    }
    comb.push(DVec2::new(0.0, -1.0));
    let (area, filling) = region(&[comb.clone()]);
    assert_eq!(area, 200.0 + 100.0 * 50.0);
    assert!(all_counter_clockwise(&[comb], &filling));
    let annulus = [ring(500, 1.0), reversed(ring(500, 0.999))];
    let (_, filling) = region(&annulus);
    assert_eq!(filling.triangles.len(), 1000);
    assert!(all_counter_clockwise(&annulus, &filling));
}

#[test]
fn random_closed_walks_on_a_small_grid() {
    let mut random = Random::new(5);
    for round in 0..400 {
        let size = 3 + round % 5;
        let loops: Vec<Vec<DVec2>> = (0..=random.below(2))
            .map(|_| {
                (0..3 + random.below(12))
                    .map(|_| {
                        DVec2::new(f64::from(random.below(size)), f64::from(random.below(size)))
                    })
                    .collect()
            })
            .collect();
        let (points, mut edges) = cycle(&loops);
        edges.retain(|(a, b, _)| a != b);
        let filling = fill(&points, &edges);
        assert!(!filling.is_fan, "{loops:?}");
        let (area, expected) = (check(&points, &edges, &filling), shoelace(&points, &edges));
        assert!((area - expected).abs() < 1e-12, "{area} {expected}");
    }
}

#[test]
fn scattered_crossing_walks_close_whatever_happens() {
    let mut random = Random::new(6);
    for _ in 0..60 {
        let walk: Vec<DVec2> = (0..4 + random.below(20))
            .map(|_| random.in_cube().truncate() * DVec2::new(1.0, 1e-9))
            .collect();
        region(&[walk]);
    }
}

#[test]
fn coordinates_of_any_size_are_triangulated() {
    for scale in [1e-300, 1e-200, 1e-60, 1e60, 1e200, 1e300] {
        let loops = [
            square([0.0, 0.0], scale),
            reversed(square([0.0, 0.0], scale / 2.0)),
            square([scale, scale / 4.0], scale / 2.0),
        ];
        let (points, edges) = cycle(&loops);
        let filling = fill(&points, &edges);
        assert!(!filling.is_fan, "{scale}");
        assert_eq!(filling.crossings.len(), 2);
        check(&points, &edges, &filling);
    }
}

#[test]
fn what_cannot_be_triangulated_still_closes_the_cycle() {
    let (mut points, edges) = cycle(&[ring(12, 1.0)]);
    points[3] = points[4];
    let filling = fill(&points, &edges);
    assert!(filling.is_fan);
    check(&points, &edges, &filling);
    points[3] = DVec2::NAN;
    let filling = fill(&points, &edges);
    assert!(filling.is_fan);
    check(&points, &edges, &filling);
}

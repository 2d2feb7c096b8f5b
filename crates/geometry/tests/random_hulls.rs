//! Random hulls of every degeneracy against brute force.
//!
//! `ASSETPIPE_CASES` says which cases are drawn: `5000` or `5000..9000` (default
//! 1000). Case `k` is always the same, and a failure names it.
#![allow(clippy::panic, clippy::unwrap_used)]

use std::ops::Range;

use assetpipe_geometry::hull::{
    check_convex, convex_hull, simplify_outward, simplify_within, Builder, HullError,
};
use assetpipe_geometry::mesh::check_manifold;
use assetpipe_geometry::predicates::orient3d;
use assetpipe_geometry::sample::Random;
use assetpipe_geometry::{DVec3, Mesh};
use glam::DQuat;

fn cases() -> Range<u64> {
    let wanted = std::env::var("ASSETPIPE_CASES").unwrap_or_default();
    let (first, end) = wanted.split_once("..").unwrap_or(("0", &wanted));
    first.parse().unwrap_or(0)..end.parse().unwrap_or(1000)
}

/// A point of one of the families that break hulls.
fn point(random: &mut Random, family: u32, size: u32) -> DVec3 {
    let mut whole = || f64::from(random.below(size));
    match family {
        0 => random.in_cube(),
        1 => random.on_sphere(),
        // Crowds on a grid: coplanar, collinear and equal points.
        2 => DVec3::new(whole(), whole(), whole()),
        // A plate and a needle on the grid.
        3 => DVec3::new(whole(), whole(), (whole() / 2.0).floor() * 1e-9),
        4 => DVec3::new(whole(), whole().min(1.0), whole().min(1.0)),
        // Cocircular and cospherical: integer points of radius 5 and 9.
        5 => {
            let (x, y) = [(3.0, 4.0), (5.0, 0.0), (4.0, 3.0), (0.0, 5.0)][random.below(4) as usize];
            let sign = |random: &mut Random| f64::from(random.below(2)) * 2.0 - 1.0;
            let flips = DVec3::new(sign(random), sign(random), 1.0);
            DVec3::new(x, y, f64::from(random.below(3))) * flips
        }
        6 => {
            let all = [
                [1.0, 4.0, 8.0],
                [4.0, 4.0, 7.0],
                [3.0, 6.0, 6.0],
                [0.0, 0.0, 9.0],
            ];
            let mut p = all[random.below(4) as usize];
            random.shuffle(&mut p);
            let flips = [(); 3].map(|()| f64::from(random.below(2)) * 2.0 - 1.0);
            DVec3::from(p) * DVec3::from(flips)
        }
        // A grid whose points are off by an ulp.
        7 => {
            let base = DVec3::new(whole(), whole(), whole()) + 1.0;
            let nudge = [(); 3].map(|()| f64::from(random.below(3)) - 1.0);
            base + DVec3::from(nudge) * base * f64::EPSILON
        }
        // On a paraboloid, and on a twisted cubic.
        8 => {
            let (x, y) = (whole(), whole());
            DVec3::new(x, y, x * x + y * y)
        }
        _ => {
            let t = whole();
            DVec3::new(t, t * t, t * t * t)
        }
    }
}

struct Case {
    number: u64,
    random: Random,
    points: Vec<DVec3>,
}

impl Case {
    fn new(number: u64) -> Self {
        let mut random = Random::new(number);
        let family = random.below(10);
        let size = 2 + random.below(8);
        let count = 1 + random.below(if number % 50 == 0 { 400 } else { 24 });
        let mut points: Vec<DVec3> = (0..count)
            .map(|_| point(&mut random, family, size))
            .collect();
        match random.below(5) {
            0 => {
                let axis = random.on_sphere();
                let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, random.unit()).normalize();
                for p in &mut points {
                    *p = turn * *p;
                }
            }
            1 => {
                let scale = 2f64.powi(random.below(1200) as i32 - 600);
                for p in &mut points {
                    *p *= scale;
                }
            }
            2 => {
                let stretch = [(); 3].map(|()| 2f64.powi(random.below(60) as i32 - 30));
                for p in &mut points {
                    *p *= DVec3::from(stretch);
                }
            }
            3 => {
                let shift = random.in_cube() * 1e4;
                for p in &mut points {
                    *p += shift;
                }
            }
            _ => {}
        }
        Self {
            number,
            random,
            points,
        }
    }
}

/// Whether `p` is in the closed hull of `others`, which must span space: then
/// it is in a tetrahedron of four of them (Carathéodory).
fn is_enclosed(others: &[DVec3], p: DVec3) -> bool {
    let n = others.len();
    for i in 0..n {
        for j in 0..i {
            for k in 0..j {
                let [a, b, c] = [others[i], others[j], others[k]];
                for &d in &others[..k] {
                    let whole = orient3d(a, b, c, d);
                    if whole.is_eq() {
                        continue;
                    }
                    let parts = [
                        orient3d(p, b, c, d),
                        orient3d(a, p, c, d),
                        orient3d(a, b, p, d),
                        orient3d(a, b, c, p),
                    ];
                    if parts.iter().all(|part| part.is_eq() || *part == whole) {
                        return true;
                    }
                }
            }
        }
    }
    false
}

fn spans_space(points: &[DVec3]) -> bool {
    let n = points.len();
    (0..n).any(|i| {
        (0..i).any(|j| {
            (0..j).any(|k| {
                (0..k).any(|l| orient3d(points[i], points[j], points[k], points[l]).is_ne())
            })
        })
    })
}

fn assert_hull(case: &Case, hull: &Mesh) {
    let n = case.number;
    check_manifold(hull).unwrap_or_else(|e| panic!("case {n}: {e}"));
    check_convex(hull).unwrap_or_else(|e| panic!("case {n}: {e}"));
    for [a, b, c] in hull.faces() {
        for &p in &case.points {
            assert!(orient3d(a, b, c, p).is_le(), "case {n}: {p} is outside");
        }
    }
    for v in &hull.vertices {
        assert!(case.points.contains(v), "case {n}: {v} is no input point");
    }
}

#[test]
fn random_points_of_every_family() {
    let mut builder = Builder::default();
    for number in cases() {
        let mut case = Case::new(number);
        let result = builder.hull(&case.points);
        let mut distinct = case.points.clone();
        distinct.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        distinct.dedup();
        let few = distinct.len() <= 10;
        match &result {
            Ok(hull) => {
                assert_hull(&case, hull);
                if few {
                    for (i, &p) in distinct.iter().enumerate() {
                        let mut others = distinct.clone();
                        others.remove(i);
                        let extreme = !spans_space(&others) || !is_enclosed(&others, p);
                        assert_eq!(hull.vertices.contains(&p), extreme, "case {number}: {p}");
                    }
                }
            }
            Err(HullError::Degenerate { dimension, witness }) => {
                assert_eq!(witness.len(), dimension + 1, "case {number}");
                assert!(!few || !spans_space(&distinct), "case {number} is not flat");
            }
            Err(error) => panic!("case {number}: {error}"),
        }
        // Neither order nor repetition matters.
        let again: Vec<DVec3> = (0..3)
            .map(|_| case.points[case.random.below(case.points.len() as u32) as usize])
            .collect();
        case.points.extend(again);
        case.random.shuffle(&mut case.points);
        match (&result, convex_hull(&case.points)) {
            (Ok(a), Ok(b)) => assert_eq!(*a, b, "case {number} depends on the order"),
            (Err(_), Err(_)) => {}
            (a, b) => panic!("case {number}: {a:?} became {b:?}"),
        }
    }
}

#[test]
fn simplified_hulls_enclose() {
    for number in cases().step_by(4) {
        let mut case = Case::new(number);
        // Outside of these sizes outward steps round to nothing.
        let size = case
            .points
            .iter()
            .map(|p| p.abs().max_element())
            .fold(0.0, f64::max);
        let Ok(hull) = convex_hull(&case.points) else {
            continue;
        };
        if !(1e-60..1e60).contains(&size) {
            continue;
        }
        let max = 4 + case.random.below(hull.vertices.len() as u32) as usize;
        let simple = simplify_outward(&hull, max).unwrap_or_else(|e| panic!("case {number}: {e}"));
        assert!(simple.vertices.len() <= max, "case {number}");
        let near =
            simplify_within(&hull, size * 1e-2).unwrap_or_else(|e| panic!("case {number}: {e}"));
        assert!(near.vertices.len() <= hull.vertices.len(), "case {number}");
        for outer in [&simple, &near] {
            check_convex(outer).unwrap_or_else(|e| panic!("case {number}: {e}"));
            for [a, b, c] in outer.faces() {
                for &p in &hull.vertices {
                    assert!(
                        orient3d(a, b, c, p).is_le(),
                        "case {number}: {p} is outside"
                    );
                }
            }
        }
    }
}

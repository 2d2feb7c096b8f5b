use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::properties;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use super::{cover, prism};
use crate::close::close;
use crate::concavity::Limits;
use crate::judge::Judge;
use crate::settings::{Metric, SearchSettings};

/// An outline extruded along `axis` from 0 to `height`, ends triangulated by `close`.
fn extruded(outline: &[(f64, f64)], height: f64, axis: usize) -> Mesh {
    use crate::search::piece::{Cap, Piece};
    use assetpipe_geometry::Plane;
    let n = outline.len() as u32;
    let at = |(x, y): (f64, f64), z: f64| {
        let mut p = DVec3::ZERO;
        p[axis] = z;
        p[(axis + 1) % 3] = x;
        p[(axis + 2) % 3] = y;
        p
    };
    let mut piece = Piece::default();
    for z in [0.0, height] {
        piece.points.extend(outline.iter().map(|&p| at(p, z)));
    }
    let edges = (0..n).map(|a| [a, (a + 1) % n]);
    for [a, b] in edges.clone() {
        piece.triangles.push([a, b, b + n]);
        piece.triangles.push([a, b + n, a + n]);
    }
    piece.caps = vec![
        Cap {
            plane: Plane::axis_aligned(axis, 0.0).flipped(),
            border: edges.clone().map(|[a, b]| [b, a]).collect(),
        },
        Cap {
            plane: Plane::axis_aligned(axis, height),
            border: edges.map(|[a, b]| [a + n, b + n]).collect(),
        },
    ];
    close(&[&piece])
}

/// A star of `points` arms, with a collinear corner on one edge.
fn star(points: u32) -> Vec<(f64, f64)> {
    let mut outline: Vec<(f64, f64)> = (0..2 * points)
        .map(|k| {
            let angle = std::f64::consts::PI * f64::from(k) / f64::from(points);
            let radius = if k % 2 == 0 { 1.0 } else { 0.4 };
            (radius * libm::cos(angle), radius * libm::sin(angle))
        })
        .collect();
    let (a, b) = (outline[0], outline[1]);
    outline.insert(1, (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1)));
    outline
}

#[test]
fn a_star_is_found_along_every_axis_and_covered_by_its_parts() {
    for axis in 0..3 {
        let mesh = extruded(&star(5), 0.3, axis);
        let found = (0..3).filter(|&k| prism::detect(&mesh, k, 1e-6).is_some());
        assert_eq!(found.collect::<Vec<_>>(), [axis]);
        let solid = SolidIndex::new(&mesh);
        let limits = Limits::default();
        let judge = Judge {
            solid: &solid,
            metric: Metric::Thickening,
            epsilon: 0.01,
            limits: &limits,
        };
        let cover = cover(&mesh, &judge, &SearchSettings::default()).unwrap();
        // Five reflex corners: at least three parts, and diagonals find four.
        assert!(
            (3..=5).contains(&cover.hulls.len()),
            "{}",
            cover.hulls.len()
        );
        let whole = properties::volume(&mesh);
        let closed: Vec<Mesh> = cover.parts.iter().map(|part| close(&[part])).collect();
        let sum: f64 = closed.iter().map(properties::volume).sum();
        assert!((sum - whole).abs() < 1e-12 * whole, "{sum} {whole}");
        for part in &closed {
            assert!(assetpipe_geometry::mesh::check_closed(part).is_ok());
            assert!(properties::volume(part) > 0.0);
        }
        let all: Vec<&_> = cover.parts.iter().collect();
        let union = close(&all);
        assert!((properties::volume(&union) - whole).abs() < 1e-12 * whole);
    }
}

#[test]
fn what_tapers_or_has_a_step_is_no_prism() {
    let mut tapered = extruded(&star(5), 0.3, 2);
    for v in &mut tapered.vertices {
        if v.z > 0.0 {
            v.x *= 0.9;
        }
    }
    assert!(prism::detect(&tapered, 2, 1e-3).is_none());
    let mut stepped = extruded(&star(5), 0.3, 2);
    let top = stepped.vertices.iter().position(|v| v.z > 0.0).unwrap();
    stepped.vertices[top].z += 0.1;
    assert!(prism::detect(&stepped, 2, 1e-3).is_none());
}

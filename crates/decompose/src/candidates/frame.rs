//! The frame of the cuts: the mesh's own axes, or one from its flat faces.
//!
//! A part that was drawn along axes and then turned shows it by its faces:
//! normals cluster, and two dominant clusters at right angles give the frame
//! back. Taken only where it aligns materially more area than the mesh's axes
//! do. A surface of revolution has its axis, unless flat faces beside it show
//! another frame; all other shapes keep their own (principal axes and tightest
//! boxes cost hulls on average).

use assetpipe_geometry::Mesh;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::eigen;
use super::revolution::{self, Axis};

/// Cosine of the angle within which a face counts as aligned (1°).
const ALIGNED: f64 = 0.999_85;
/// The frame must align this many times the area of the mesh's axes, and this
/// share of all area more.
const GAIN: f64 = 1.1;
const SHARE: f64 = 0.1;
/// Cosine of directions that count as at right angles.
const SQUARE: f64 = 0.02;
/// Clusters of normals that are looked at.
const CLUSTERS: usize = 24;

/// The rotation from the mesh's frame into the frame of the cuts.
pub fn choose(mesh: &Mesh) -> DMat3 {
    let faces: Vec<(DVec3, f64)> = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            let normal = (b - a).cross(c - a);
            (canonical(normal.normalize_or_zero()), 0.5 * normal.length())
        })
        .collect();
    let total: f64 = faces.iter().map(|f| f.1).sum();
    let own = aligned(&faces, DMat3::IDENTITY);
    if own * GAIN >= total || own + SHARE * total >= total {
        return DMat3::IDENTITY;
    }
    let mut sorted = faces.clone();
    let (axis, clusters) = rayon::join(|| revolution::axis(mesh), || clusters(&mut sorted));
    let unexplained: Vec<(DVec3, f64)> = axis.iter().flat_map(|a| beside(&faces, a)).collect();
    let flat = of_faces(&sorted, &clusters, own, total);
    // Flat faces that do not go round the axis show a frame, as where a ball lost a piece; those
    // that do are the facets of what goes round.
    match axis {
        Some(Axis { direction, .. })
            if !along(flat, direction) && aligned(&unexplained, flat) <= SHARE * total =>
        {
            let across = clusters.iter().find(|c| c.0.dot(direction).abs() < SQUARE);
            let second = across.map_or(direction.any_orthonormal_vector(), |c| c.0);
            frame(direction, second)
        }
        _ => flat,
    }
}

/// The faces whose normals do not meet an axis.
fn beside(faces: &[(DVec3, f64)], axis: &Axis) -> Vec<(DVec3, f64)> {
    let each = faces.iter().zip(&axis.meets);
    each.filter(|(_, meets)| !**meets)
        .map(|(face, _)| *face)
        .collect()
}

/// Whether an axis of the frame has this direction.
fn along(frame: DMat3, direction: DVec3) -> bool {
    (frame * direction).abs().max_element() > ALIGNED
}

/// The frame of two dominant clusters of flat faces, if it aligns materially more area than the
/// mesh's axes.
fn of_faces(faces: &[(DVec3, f64)], clusters: &[(DVec3, f64)], own: f64, total: f64) -> DMat3 {
    let mut frames: Vec<DMat3> = Vec::new();
    for (i, &(first, area)) in clusters.iter().enumerate() {
        let mut partner = false;
        for &(second, _) in &clusters[i + 1..] {
            if first.dot(second).abs() < SQUARE {
                partner = true;
                frames.push(frame(first, second));
            }
        }
        // A turned solid of revolution has one direction only.
        if !partner && area > SHARE * total {
            frames.push(frame(first, first.any_orthonormal_vector()));
        }
    }
    let areas: Vec<f64> = frames.par_iter().map(|&f| aligned(faces, f)).collect();
    let best = areas
        .into_iter()
        .zip(frames)
        .fold((own, DMat3::IDENTITY), |a, b| if b.0 > a.0 { b } else { a });
    if best.0 > GAIN * own && best.0 > own + SHARE * total {
        best.1
    } else {
        DMat3::IDENTITY
    }
}

/// The frame of the principal axes: of the covariance of the surface, as in §6.1 of Wei et al.
/// 2022. Never better on average than the mesh's own axes; here for comparison.
pub fn principal(mesh: &Mesh) -> DMat3 {
    let (mut area, mut mean) = (0.0, DVec3::ZERO);
    let triangles = || (0..mesh.triangles.len()).map(|t| mesh.corners(t));
    for [a, b, c] in triangles() {
        let twice = (b - a).cross(c - a).length();
        area += twice;
        mean += twice * (a + b + c) / 3.0;
    }
    if area <= 0.0 {
        return DMat3::IDENTITY;
    }
    mean /= area;
    let mut covariance = [[0.0; 3]; 3];
    for corners in triangles() {
        let [a, b, c] = corners.map(|p| p - mean);
        let twice = (b - a).cross(c - a).length();
        // ∫ x xᵀ over a triangle is its area / 12 · (Σ pᵢ pᵢᵀ + s sᵀ) with s = Σ pᵢ.
        for p in [a, b, c, a + b + c] {
            for (i, row) in covariance.iter_mut().enumerate() {
                for (j, x) in row.iter_mut().enumerate() {
                    *x += twice * p[i] * p[j];
                }
            }
        }
    }
    let axes = eigen::symmetric(covariance);
    frame(DVec3::from_array(axes[0].1), DVec3::from_array(axes[2].1))
}

/// One of a normal and its opposite.
fn canonical(n: DVec3) -> DVec3 {
    let first = [n.z, n.y, n.x]
        .into_iter()
        .find(|x| x.abs() > 1e-6)
        .unwrap_or(0.0);
    if first < 0.0 {
        -n
    } else {
        n
    }
}

/// Rows: the axes of the new frame.
fn frame(first: DVec3, second: DVec3) -> DMat3 {
    let w = first.normalize();
    let u = (second - w * w.dot(second)).normalize();
    DMat3::from_cols(u, w.cross(u), w).transpose()
}

/// Area whose normal is along an axis of the frame.
fn aligned(faces: &[(DVec3, f64)], frame: DMat3) -> f64 {
    let axes = [frame.row(0), frame.row(1), frame.row(2)];
    faces
        .iter()
        .filter(|(n, _)| axes.iter().any(|a| a.dot(*n).abs() > ALIGNED))
        .map(|f| f.1)
        .sum()
}

/// Mean normal and area of the largest groups of almost equal normals.
fn clusters(faces: &mut [(DVec3, f64)]) -> Vec<(DVec3, f64)> {
    // Cells of a grid over the sphere, then neighbours gathered around the
    // heaviest cell first.
    let cell = |n: DVec3| (n * 64.0).round().to_array().map(|x| x as i64);
    // Areas are positive: ordered as their bits are.
    faces.par_sort_by_cached_key(|f| (cell(f.0), f.1.to_bits()));
    let mut cells: Vec<(DVec3, f64)> = faces
        .chunk_by(|a, b| cell(a.0) == cell(b.0))
        .map(|run| {
            let sum: DVec3 = run.iter().map(|f| f.0 * f.1).sum();
            (sum.normalize_or_zero(), run.iter().map(|f| f.1).sum())
        })
        // Faces so small that their normals vanish tell no direction.
        .filter(|cell: &(DVec3, f64)| cell.0 != DVec3::ZERO)
        .collect();
    cells.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut found: Vec<(DVec3, f64)> = Vec::new();
    for (normal, area) in cells {
        match found.iter().position(|f| f.0.dot(normal).abs() > ALIGNED) {
            Some(known) => found[known].1 += area,
            None if found.len() < CLUSTERS => found.push((normal, area)),
            None => {}
        }
    }
    found
}

/// Give coordinates along an axis that are at most `gap` from the lowest of them one value, so that
/// a cut at a face is exact and what rounding set apart is sorted alike everywhere.
pub fn snap(mesh: &mut Mesh, gap: f64) {
    let along = |axis: usize| {
        let mut heights: Vec<f64> = mesh.vertices.iter().map(|p| p[axis]).collect();
        let mut order: Vec<u32> = (0..heights.len() as u32).collect();
        let at = |v: u32| heights[v as usize];
        order.sort_unstable_by(|&a, &b| at(a).total_cmp(&at(b)).then(a.cmp(&b)));
        let mut anchor = f64::NEG_INFINITY;
        for v in order {
            let x = &mut heights[v as usize];
            if *x - anchor > gap {
                anchor = *x;
            }
            *x = anchor;
        }
        heights
    };
    let snapped: Vec<Vec<f64>> = (0..3).into_par_iter().map(along).collect();
    for (v, p) in mesh.vertices.iter_mut().enumerate() {
        *p = DVec3::from_array([0, 1, 2].map(|axis| snapped[axis][v]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use assetpipe_geometry::hull::convex_hull;

    /// A brick of sides 3, 2 and 1, turned.
    fn brick(turn: DMat3) -> Mesh {
        let corners: Vec<DVec3> = (0..8u32)
            .map(|i| {
                turn * DVec3::new(
                    f64::from(i & 1) * 3.0,
                    f64::from(i >> 1 & 1) * 2.0,
                    f64::from(i >> 2),
                )
            })
            .collect();
        convex_hull(&corners).unwrap()
    }

    #[test]
    fn principal_axes_of_a_turned_brick_are_its_edges() {
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize());
        let turned_back = principal(&brick(turn)) * turn;
        for column in [turned_back.x_axis, turned_back.y_axis, turned_back.z_axis] {
            assert!((column.abs().max_element() - 1.0).abs() < 1e-9);
        }
        assert!((turned_back.determinant() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_turned_box_finds_its_axes() {
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize());
        let mesh = brick(turn);
        let frame = choose(&mesh);
        assert_ne!(frame, DMat3::IDENTITY);
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let n = frame * (b - a).cross(c - a).normalize();
            assert!((n.abs().max_element() - 1.0).abs() < 1e-9);
        }
        assert_eq!(choose(&brick(DMat3::IDENTITY)), DMat3::IDENTITY);
    }

    /// A ring of so many facets around and across, round z.
    fn ring(around: u32, across: u32) -> Mesh {
        let turn = |k: u32, of: u32| std::f64::consts::TAU * f64::from(k) / f64::from(of);
        let mut mesh = Mesh::default();
        for i in 0..around {
            for j in 0..across {
                let (u, v) = (turn(i, around), turn(j, across));
                let r = 1.0 + 0.3 * libm::cos(v);
                let point = DVec3::new(r * libm::cos(u), r * libm::sin(u), 0.3 * libm::sin(v));
                mesh.vertices.push(point);
                let at = |i: u32, j: u32| i % around * across + j % across;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    #[test]
    fn facets_of_a_turned_ring_do_not_hide_its_axis() {
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize());
        let mut mesh = ring(20, 12);
        for p in &mut mesh.vertices {
            *p = turn * *p;
        }
        assert!(along(choose(&mesh), turn * DVec3::Z));
    }

    #[test]
    fn flat_faces_beside_a_surface_of_revolution_show_the_frame() {
        // A body that goes round an oblique axis, with a slab beside it along the mesh's axes.
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.3, 0.1, -0.5, 0.8).normalize());
        let mut mesh = ring(60, 31);
        for p in &mut mesh.vertices {
            *p = turn * *p;
        }
        assert!(along(choose(&mesh), turn * DVec3::Z));
        let slab = brick(DMat3::IDENTITY);
        let first = mesh.vertices.len() as u32;
        mesh.vertices
            .extend(slab.vertices.iter().map(|&p| 0.32 * p - 0.4));
        mesh.triangles
            .extend(slab.triangles.iter().map(|t| t.map(|v| v + first)));
        assert!(revolution::axis(&mesh).is_some(), "nothing is tested");
        assert_eq!(choose(&mesh), DMat3::IDENTITY);
    }
}

//! Vertices of the solid that no part has.
//!
//! A cut along a face replaces what of the face lies in its plane; a vertex in the middle of it is
//! then in no part. The parts around hold it but for the rounding of its coordinates, and hulls are
//! to hold it exactly: so the nearest one gets it.

use std::cmp::Ordering;

use assetpipe_geometry::distance::ConvexBody;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::engine::Cover;

/// How far beyond a hull such a vertex may be, in the working copy (size one). Others are those of
/// shells that enclose nothing.
const ROUNDING: f64 = 1e-12;

fn order(a: &DVec3, b: &DVec3) -> Ordering {
    a.x.total_cmp(&b.x)
        .then(a.y.total_cmp(&b.y))
        .then(a.z.total_cmp(&b.z))
}

/// Give each vertex of a face of the working copy that no part has to a part of the nearest hull.
pub fn adopt(cover: &mut Cover, copy: &Mesh) {
    let mut held: Vec<DVec3> = cover
        .parts
        .iter()
        .flat_map(|part| part.points.iter().map(|&p| p + DVec3::ZERO))
        .collect();
    held.sort_unstable_by(order);
    let mut used = vec![false; copy.vertices.len()];
    for v in copy.triangles.iter().flatten() {
        used[*v as usize] = true;
    }
    let bare: Vec<DVec3> = copy
        .vertices
        .iter()
        .zip(used)
        .filter(|(p, used)| *used && held.binary_search_by(|q| order(q, p)).is_err())
        .map(|(p, _)| *p)
        .collect();
    if bare.is_empty() {
        return;
    }
    let bodies: Vec<ConvexBody> = cover
        .hulls
        .iter()
        .map(|hull| ConvexBody::new(&hull.hull))
        .collect();
    for p in bare {
        let beyond = bodies.iter().map(|body| {
            let heights = body
                .half_spaces()
                .iter()
                .map(|s| s.normal.dot(p) - s.offset);
            heights.fold(f64::NEG_INFINITY, f64::max)
        });
        let nearest = beyond
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        if let Some((index, beyond)) = nearest {
            if beyond <= ROUNDING {
                let part = cover.hulls[index].members[0];
                cover.parts[part as usize].points.push(p);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::concavity::Interval;
    use crate::merge::Proved;
    use crate::search::piece::Piece;
    use assetpipe_geometry::hull::convex_hull;

    #[test]
    fn a_vertex_beside_a_hull_is_given_to_it_and_one_far_from_all_is_not() {
        let corners: Vec<DVec3> = (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let cube = convex_hull(&corners).unwrap();
        let mut copy = cube.clone();
        let beside = DVec3::new(0.5, 0.25, 1.0 + 2e-16);
        copy.vertices
            .extend([beside, DVec3::splat(3.0), DVec3::splat(0.5)]);
        copy.triangles.extend([[8, 0, 1], [9, 0, 1]]);
        let mut cover = Cover {
            hulls: vec![Proved {
                hull: cube.clone(),
                thickening: Interval::exactly(0.0),
                members: vec![0],
            }],
            parts: vec![Piece::from(&cube)],
            witnesses: Vec::new(),
        };
        adopt(&mut cover, &copy);
        let mut expected = cube.vertices.clone();
        expected.push(beside);
        assert_eq!(cover.parts[0].points, expected);
    }
}

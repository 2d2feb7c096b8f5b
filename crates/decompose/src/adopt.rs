//! Points that no hull would hold.
//!
//! A cut along a face replaces what of the face lies in its plane; a vertex in the middle of it is
//! then in no part. And a part as thin as rounding may have no volume left in the input's
//! coordinates, so that it has no hull there. The parts around hold such points but for rounding,
//! and hulls are to hold them exactly: so the nearest one gets them.
//! Where borders of caps cross, a part's closed surface has a vertex that is none of its points; the
//! part gets it too.

use assetpipe_geometry::distance::ConvexBody;
use assetpipe_geometry::hull::{convex_hull, HullError};
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use crate::close::crossings;
use crate::engine::Cover;
use crate::merge::{bounds, volume, Proved};
use crate::search::piece::Piece;
use crate::working::{one_zero, order, Working};

/// How far beyond a hull such a vertex may be, in the working copy (size one). Others are those of
/// shells that enclose nothing.
const ROUNDING: f64 = 1e-12;
/// Hulls with a larger share of their box are not looked at for being flat.
const THIN: f64 = 1e-9;

/// Whether the points of a hull span no volume in the input's coordinates.
fn is_flat(hull: &Proved, parts: &[Piece], working: &Working) -> bool {
    let (lo, hi) = bounds(&hull.hull);
    if volume(&hull.hull) > THIN * (hi - lo).length().powi(3) {
        return false;
    }
    let points: Vec<DVec3> = hull
        .members
        .iter()
        .flat_map(|&m| &parts[m as usize].points)
        .flat_map(|&p| working.inputs(p))
        .collect();
    matches!(convex_hull(&points), Err(HullError::Degenerate { .. }))
}

/// How far a point is beyond a hull's faces.
fn beyond(body: &ConvexBody, p: DVec3) -> f64 {
    let heights = body
        .half_spaces()
        .iter()
        .map(|s| s.normal.dot(p) - s.offset);
    heights.fold(f64::NEG_INFINITY, f64::max)
}

/// Drop hulls that are flat in the input's coordinates, and give each vertex of a face of the
/// working copy that no part of the others has to a part of the nearest hull.
pub fn adopt(cover: &mut Cover, copy: &Mesh, working: &Working) {
    let parts = &cover.parts;
    let standing = |hull: &Proved| !is_flat(hull, parts, working);
    if !cover.hulls.iter().all(standing) && cover.hulls.iter().any(standing) {
        cover.hulls.retain(standing);
    }
    let made: Vec<Vec<DVec3>> = cover.parts.par_iter().map(crossings).collect();
    for hull in &cover.hulls {
        for &m in &hull.members {
            let made = &made[m as usize];
            if !made.is_empty() {
                let body = ConvexBody::new(&hull.hull);
                let near = made.iter().copied();
                let near = near.filter(|p| beyond(&body, *p) <= ROUNDING);
                cover.parts[m as usize].points.extend(near);
            }
        }
    }
    let mut held: Vec<DVec3> = cover
        .hulls
        .iter()
        .flat_map(|hull| &hull.members)
        .flat_map(|&m| &cover.parts[m as usize].points)
        .map(|&p| one_zero(p))
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
        let beyond = bodies.iter().map(|body| beyond(body, p));
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
    use crate::close::close;
    use crate::concavity::Interval;
    use crate::shapes::{both, cuboid, placed, turned};
    use assetpipe_geometry::Plane;
    use glam::DMat3;

    fn proved(hull: &Mesh, part: u32) -> Proved {
        Proved {
            hull: hull.clone(),
            thickening: Interval::exactly(0.0),
            members: vec![part],
        }
    }

    #[test]
    fn a_vertex_beside_a_hull_is_given_to_it_and_one_far_from_all_is_not() {
        let cube = cuboid(DVec3::ZERO, DVec3::ONE);
        let mut copy = cube.clone();
        let beside = DVec3::new(0.5, 0.25, 1.0 + 2e-16);
        copy.vertices
            .extend([beside, DVec3::splat(3.0), DVec3::splat(0.5)]);
        copy.triangles.extend([[8, 0, 1], [9, 0, 1]]);
        let mut cover = Cover {
            hulls: vec![proved(&cube, 0)],
            parts: vec![Piece::from(&cube)],
            witnesses: Vec::new(),
        };
        let (working, _) = Working::new(&cube, DMat3::IDENTITY);
        adopt(&mut cover, &copy, &working);
        let mut expected = cube.vertices.clone();
        expected.push(beside);
        assert_eq!(cover.parts[0].points, expected);
    }

    #[test]
    fn a_hull_without_volume_is_dropped_and_its_points_are_held() {
        let cube = cuboid(DVec3::ZERO, DVec3::ONE);
        let (working, copy) = Working::new(&cube, DMat3::IDENTITY);
        // A sheet on the copy of the upper side, as thin as an ulp, that is flat as it came.
        let up = working.work(DVec3::new(0.5, 0.5, 1.0));
        let above = copy.vertices.iter().filter(|p| p.dot(up) > 0.0).copied();
        let sheet: Vec<DVec3> = above.chain([up * (1.0 + 2e-16)]).collect();
        let hull = convex_hull(&sheet).unwrap();
        let mut cover = Cover {
            hulls: vec![proved(&hull, 0), proved(&copy, 1)],
            parts: vec![Piece::from(&hull), Piece::from(&copy)],
            witnesses: Vec::new(),
        };
        adopt(&mut cover, &copy, &working);
        assert_eq!(cover.hulls.len(), 1);
        assert_eq!(cover.hulls[0].members, [1]);
    }

    /// Vertices of a part's closed surface that are outside of its hull, both in the input's
    /// coordinates, where the hull must hold them exactly.
    fn outside(part: &Piece, working: &Working) -> usize {
        let inputs = |p: &DVec3| working.inputs(*p).collect::<Vec<_>>();
        let points: Vec<DVec3> = part.points.iter().flat_map(inputs).collect();
        let hull = convex_hull(&points).unwrap();
        let surface = close(&[part]);
        let is_outside = |p: &&DVec3| {
            let more: Vec<DVec3> = points.iter().copied().chain(inputs(p)).collect();
            convex_hull(&more).unwrap() != hull
        };
        surface.vertices.iter().filter(is_outside).count()
    }

    #[test]
    fn where_borders_of_caps_cross_on_a_hull_it_holds_the_crossing() {
        // Two boxes that run into each other with one side in one plane: turned and far away,
        // rounding makes the borders of their sections cross along it.
        let first = cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
        let mut before = 0;
        for k in 0..40 {
            let x = 0.5 + 0.03 * f64::from(k);
            let second = cuboid(DVec3::new(x, 0.0, 0.0), DVec3::new(3.0, 0.7, 1.0));
            let solid = placed(&turned(&both(&first, &second)), 1.0, DVec3::splat(1e4));
            let (working, copy) = Working::new(&solid, DMat3::IDENTITY);
            let normal = DVec3::new(0.1, 0.2, 0.9).normalize();
            let cut = Plane {
                normal,
                offset: 0.1,
            };
            let (low, high) = Piece::from(&copy).split(cut);
            let hull = convex_hull(&low.points).unwrap();
            before += outside(&low, &working);
            let mut cover = Cover {
                hulls: vec![
                    proved(&hull, 0),
                    proved(&convex_hull(&high.points).unwrap(), 1),
                ],
                parts: vec![low, high],
                witnesses: Vec::new(),
            };
            adopt(&mut cover, &copy, &working);
            for part in &cover.parts {
                assert_eq!(outside(part, &working), 0);
            }
        }
        assert!(before > 0);
    }
}

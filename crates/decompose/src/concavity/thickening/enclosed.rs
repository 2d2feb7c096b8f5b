//! Cells that belong to the solid although their faces lie on its surface.

use assetpipe_geometry::bvh::{Bounds, Bvh};
use assetpipe_geometry::distance::{HalfSpace, Triangle};
use assetpipe_geometry::DVec3;

use super::cell::Polytope;

/// More triangles are not worth looking at: split instead.
const TRIANGLES: usize = 48;

/// Whether no triangle enters the inner part of a cell, its sides moved inward
/// by `depth`. `false` also when it is not clear.
pub(super) fn is_free_of_surface(bvh: &Bvh, cell: &Polytope, depth: f64) -> bool {
    let inner = Bounds {
        lo: cell.bounds.lo + depth,
        hi: cell.bounds.hi - depth,
    };
    let spaces = &cell.spaces;
    let mut seen = 0;
    let mut free = true;
    bvh.for_each(
        |b| overlap(b, &inner) && !spaces.iter().any(|s| box_beyond(b, s, depth)),
        |slot| {
            seen += 1;
            free = seen <= TRIANGLES && is_apart(bvh.triangle(slot), &inner, spaces, depth);
            free
        },
    );
    free
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a.lo.cmplt(b.hi).all() && b.lo.cmplt(a.hi).all()
}

fn box_beyond(b: &Bounds, space: &HalfSpace, depth: f64) -> bool {
    let half = (b.hi - b.lo) * 0.5;
    space.normal.dot(b.centre()) - space.normal.abs().dot(half) >= space.offset - depth
}

/// Whether a plane of the cell or the triangle's own keeps them apart.
fn is_apart(triangle: &Triangle, inner: &Bounds, spaces: &[HalfSpace], depth: f64) -> bool {
    let corners = triangle.corners();
    if spaces
        .iter()
        .any(|s| corners.iter().all(|c| s.normal.dot(*c) >= s.offset - depth))
    {
        return true;
    }
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let to_centre: DVec3 = inner.centre() - corners[0];
    let reach = normal.abs().dot((inner.hi - inner.lo) * 0.5);
    normal.dot(to_centre).abs() >= reach
}

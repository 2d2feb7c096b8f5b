//! Navigable space: what no ball of a given radius can enter from outside.
//!
//! A point is *reachable* if some ball of radius R that holds it can come from
//! infinity without overlapping the solid: if its distance to the *free centres*
//! (the component of {c : d(c, solid) ≥ R} that reaches infinity) is less than R.
//! Everything else is a *pocket*. The mesh returned lies wholly in pockets and
//! the solid, which is proved by erring towards the reachable at every step:
//!
//! 1. A lattice of spacing h stands for cubes of half-diagonal ρ = h·√3/2. A cube may
//!    hold a free centre only if d(its middle, solid) + ρ ≥ R, for d is 1-Lipschitz. The
//!    cubes that a walk over faces, edges and corners reaches from outside contain
//!    every free centre.
//! 2. A point's distance to these cubes is at least its distance to their middles, less ρ.
//! 3. The surface is cut through tetrahedra between lattice points, whose circumradius is ρ.
//!    The distance to one middle is convex with curvature at most 1 over itself, so
//!    linear interpolation overstates it by at most ρ²/2 of that, and the interpolated
//!    minimum over middles is not above any of them. A tetrahedron with points nearer
//!    than R − ρ to a middle has no corner beyond R + ρ, so δ = ρ² / (2 (R − ρ)) is enough.
//!
//! So space within R + ρ + δ of the middles of reached cubes is left open.

mod lattice;
mod nearest;
mod runs;
mod surface;

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::Mesh;

use crate::control::Control;
use crate::edges::check_closed;
use crate::error::DecomposeError;
use lattice::{Lattice, Place};
use runs::Components;

/// Most lattice points: 5 bytes and some 100 ns each.
const POINTS: usize = 48_000_000;
/// As many are spent on a finer lattice than is needed.
const CHEAP: usize = 6_000_000;
/// Spacings tried, as shares of the radius.
const SPACINGS: [f64; 7] = [
    1.0 / 16.0,
    1.0 / 12.0,
    1.0 / 8.0,
    1.0 / 6.0,
    1.0 / 4.0,
    1.0 / 3.0,
    1.0 / 2.0,
];
/// A pocket counts only if some point of it is so many radii from the free centres.
/// One is the reach of the ball; the rest leaves out the fillet that every concave
/// edge has: (√2 − 1) R deep in a right angle, and worth no hull.
const DEEP: f64 = 1.5;
/// Layers of solid that pockets overlap, so that a union hides their sides.
const OVERLAP: usize = 2;
/// Least value at the end of an edge that is cut, in spacings: keeps triangles from
/// shrinking to points.
const CLEAR: f64 = 1e-3;

/// What nothing can enter.
#[derive(Clone, Debug)]
pub struct Unreachable {
    /// A closed surface around pockets; it overlaps the solid.
    pub pockets: Mesh,
    /// How many there are.
    pub count: usize,
    /// Spacing of the lattice.
    pub spacing: f64,
}

/// The pockets of a closed solid that no ball of `radius` can enter from outside, on at
/// most `threads` threads (0: as many as there are cores).
///
/// # Errors
/// [`DecomposeError::Reach`] for a radius that is not positive or too small for the size
/// of the mesh; what is wrong with the mesh; [`DecomposeError::Cancelled`].
pub fn unreachable(
    mesh: &Mesh,
    radius: f64,
    threads: usize,
    control: &Control,
) -> Result<Unreachable, DecomposeError> {
    check(mesh)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| DecomposeError::Internal(e.to_string()))?;
    pool.install(|| search(mesh, radius, CHEAP, control))
}

fn check(mesh: &Mesh) -> Result<(), DecomposeError> {
    if mesh.triangles.is_empty() {
        return Err(DecomposeError::Empty);
    }
    if let Some(index) = mesh.vertices.iter().position(|p| !p.is_finite()) {
        return Err(DecomposeError::NotFinite { index });
    }
    check_closed(mesh)
}

fn search(
    mesh: &Mesh,
    radius: f64,
    cheap: usize,
    control: &Control,
) -> Result<Unreachable, DecomposeError> {
    let solid = SolidIndex::new(mesh);
    let bounds = solid.bvh().bounds();
    let within = |most: usize| {
        let points = |share: f64| Lattice::points(&bounds, radius, share * radius);
        SPACINGS.iter().find(|share| points(**share) <= most)
    };
    let found = within(cheap).or_else(|| within(POINTS));
    let Some(share) = found.filter(|_| radius > 0.0 && radius.is_finite()) else {
        return Err(DecomposeError::Reach {
            radius,
            least: least_radius(&bounds),
        });
    };
    let spacing = share * radius;
    let lattice = Lattice::new(&bounds, radius, spacing);
    let rho = spacing * 0.5 * 3.0_f64.sqrt();
    let slack = solid.slack();
    let stop = || {
        if control.is_cancelled() {
            Err(DecomposeError::Cancelled)
        } else {
            Ok(())
        }
    };
    let places = lattice.classify(&solid, radius - rho - slack, control);
    stop()?;
    control.report(0.6);
    let free = Components::of(&lattice, |i| places[i] == Place::Passable);
    let reached = free.marked(&lattice, free.label_at(&lattice, 0));
    stop()?;
    let most = (2.0 * DEEP / share).ceil() as usize;
    let squares = nearest::squares(&lattice, &reached, most);
    stop()?;
    control.report(0.8);
    let level = radius + rho + 0.5 * rho * rho / (radius - rho) + slack;
    let value = |i: usize| spacing * f64::from(squares[i]).sqrt() - level;
    let shut = |i: usize| value(i) >= CLEAR * spacing;
    let pockets = Components::of(&lattice, |i| places[i] != Place::Inside && shut(i));
    let deep = pockets.which(|i| value(i) >= (DEEP - 1.0) * radius);
    let count = deep.iter().filter(|&&is_deep| is_deep).count();
    let mut chosen = pockets.chosen(&lattice, &deep);
    let in_solid = |i: usize| matches!(places[i], Place::Skin | Place::Inside);
    for _ in 0..OVERLAP {
        chosen = lattice.grown(&chosen, |i| in_solid(i) && shut(i));
    }
    stop()?;
    control.report(0.9);
    let outside = |i: usize| {
        if shut(i) {
            // Unreachable too, but not part of this pocket: lower is the safe side.
            -spacing
        } else {
            value(i).min(-CLEAR * spacing)
        }
    };
    let pockets = surface::surface(&lattice, &chosen, |i| {
        if chosen[i] {
            value(i)
        } else {
            outside(i)
        }
    });
    control.report(1.0);
    Ok(Unreachable {
        pockets,
        count,
        spacing,
    })
}

/// The smallest radius whose coarsest lattice is small enough, rounded up.
fn least_radius(bounds: &assetpipe_geometry::bvh::Bounds) -> f64 {
    let coarsest = SPACINGS[SPACINGS.len() - 1];
    let mut radius = bounds.diagonal() * 1e-4;
    while Lattice::points(bounds, radius, coarsest * radius) > POINTS {
        radius *= 1.1;
    }
    radius
}

#[cfg(test)]
mod tests;

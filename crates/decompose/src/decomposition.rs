//! The door of the engine: a solid in, proved hulls out.

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::{convex_hull, HullError};
use assetpipe_geometry::Mesh;
use glam::DMat3;

use crate::concavity::{Interval, Limits};
use crate::control::Control;
use crate::convex::{check_closed, is_convex};
use crate::engine::decompose_working;
use crate::error::DecomposeError;
use crate::hierarchy::{build, Node};
use crate::merge::{volume, Proved};
use crate::settings::SearchSettings;
use crate::working::Working;

/// A hull that leaves the engine, in the frame and unit of the input.
#[derive(Clone, Debug)]
pub struct Hull {
    /// The convex polytope.
    pub mesh: Mesh,
    /// Its volume.
    pub volume: f64,
    /// Its thickening towards the whole solid.
    pub thickening: Interval,
    /// Its concavity towards its part, where it was computed.
    pub concavity: Option<Interval>,
    /// The two hulls that it replaces on a coarser level.
    pub children: Option<[u32; 2]>,
}

/// The result: hulls, and the hulls of all coarser levels behind them.
#[derive(Clone, Debug)]
pub struct Decomposition {
    /// First the `leaves`, then merged hulls, children before parents.
    pub hulls: Vec<Hull>,
    /// How many hulls the decomposition has at its own tolerance.
    pub leaves: usize,
}

/// Decompose a closed solid with tolerance `epsilon` in the mesh's unit.
///
/// # Errors
/// [`DecomposeError`]; nothing here panics on purpose.
pub fn decompose(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
    control: &Control,
) -> Result<Decomposition, DecomposeError> {
    check(mesh, epsilon)?;
    let hull = convex_hull(&mesh.vertices).map_err(flat)?;
    let own = volume(mesh);
    if own <= 1e-12 * volume(&hull) {
        return Err(DecomposeError::Flat { dimension: 3 });
    }
    if is_convex(mesh, &hull) {
        let hull = Hull {
            volume: volume(&hull),
            mesh: hull,
            thickening: Interval::exactly(0.0),
            concavity: Some(Interval::exactly(0.0)),
            children: None,
        };
        return Ok(Decomposition { hulls: vec![hull], leaves: 1 });
    }
    let (working, copy) = Working::new(mesh, DMat3::IDENTITY);
    let solid = SolidIndex::new(&copy);
    let cancelled = || control.is_cancelled();
    let limits = Limits { cells: 1_000_000, cancelled: &cancelled };
    let proved = decompose_working(&copy, &solid, working.length(epsilon), settings, control)?;
    let leaves = proved.len();
    let nodes = build(&solid, proved, &limits);
    if control.is_cancelled() {
        return Err(DecomposeError::Cancelled);
    }
    let hulls = nodes.iter().map(|node| output(&working, node)).collect::<Result<_, _>>()?;
    control.report(1.0);
    Ok(Decomposition { hulls, leaves })
}

fn check(mesh: &Mesh, epsilon: f64) -> Result<(), DecomposeError> {
    if !(epsilon > 0.0 && epsilon.is_finite()) {
        return Err(DecomposeError::Tolerance { epsilon });
    }
    if mesh.triangles.is_empty() {
        return Err(DecomposeError::Empty);
    }
    if let Some(index) = mesh.vertices.iter().position(|p| !p.is_finite()) {
        return Err(DecomposeError::NotFinite { index });
    }
    check_closed(mesh)
}

#[allow(clippy::needless_pass_by_value)]
fn flat(error: HullError) -> DecomposeError {
    match error {
        HullError::Degenerate { dimension, .. } => DecomposeError::Flat { dimension },
        HullError::Empty => DecomposeError::Empty,
        HullError::NotFinite { index, .. } => DecomposeError::NotFinite { index },
        HullError::TooMany { .. } => DecomposeError::Internal(error.to_string()),
    }
}

fn output(working: &Working, node: &Node) -> Result<Hull, DecomposeError> {
    let Proved { hull, thickening, .. } = &node.proved;
    let points: Vec<_> = hull.vertices.iter().map(|&p| working.input(p)).collect();
    // Rounding on the way back can make a face concave by one unit in the last
    // place: the hull of the points that are given is exact.
    let mesh = convex_hull(&points).map_err(|e| DecomposeError::Internal(e.to_string()))?;
    let out = |x: f64| working.input_length(x);
    Ok(Hull {
        volume: volume(&mesh),
        mesh,
        thickening: Interval {
            lower: (out(thickening.lower) - working.rounding()).max(0.0),
            upper: out(thickening.upper) + working.rounding(),
        },
        concavity: None,
        children: node.children,
    })
}

//! The door of the engine: a solid in, proved hulls out.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicUsize, Ordering};

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::{convex_hull, HullError};
use assetpipe_geometry::tolerance::Rounding;
use assetpipe_geometry::Mesh;
use glam::DMat3;

use crate::adopt::adopt;
use crate::ahead::next_first;
use crate::candidates::frame;
use crate::canonical::ordered;
use crate::close::close;
use crate::concavity::{Gap, Interval, Limits};
use crate::control::{Control, FINISHED, MERGED};
use crate::convex::{is_convex, is_like_a_sphere, is_strictly_convex};
use crate::edges::check_closed;
use crate::engine::{decompose_working, roots, Cover};
use crate::error::DecomposeError;
use crate::explore::fewest;
use crate::finish::Finish;
use crate::hierarchy::{build, Node};
use crate::judge::Judge;
use crate::merge::{volume, Proved};
use crate::prismatic;
use crate::settings::{FrameChoice, SearchSettings};
use crate::slivers::cleared;
use crate::step::Open;
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

/// Decompose a closed solid with tolerance `epsilon` in the mesh's unit, on
/// at most `threads` threads (0: as many as there are cores).
///
/// # Errors
/// [`DecomposeError`]; nothing here panics on purpose.
pub fn decompose(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
    threads: usize,
    control: &Control,
) -> Result<Decomposition, DecomposeError> {
    run(mesh, epsilon, settings, threads, control).map(|found| found.0)
}

/// The parts under the hulls of [`decompose`], for those who check it: for each of its
/// leaves the closed surfaces of the parts that it covers, in the frame and unit of the
/// input.
///
/// # Errors
/// As [`decompose`].
pub fn parts(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
    threads: usize,
    control: &Control,
) -> Result<Vec<Vec<Mesh>>, DecomposeError> {
    let (_, cover) = run(mesh, epsilon, settings, threads, control)?;
    let Some((working, cover)) = cover else {
        return Ok(vec![vec![mesh.clone()]]);
    };
    let surface = |&member: &u32| {
        let mut part = close(&[&cover.parts[member as usize]]);
        for p in &mut part.vertices {
            *p = working.input(*p);
        }
        if working.is_mirrored() {
            for t in &mut part.triangles {
                t.swap(1, 2);
            }
        }
        part
    };
    Ok(cover
        .hulls
        .iter()
        .map(|hull| hull.members.iter().map(surface).collect())
        .collect())
}

/// The decomposition of a solid that is exactly convex without flat edges: itself, in
/// microseconds. `None` for all others, which take [`decompose`].
///
/// # Errors
/// [`DecomposeError`] for input that is none.
pub fn at_once(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
) -> Result<Option<Decomposition>, DecomposeError> {
    check(mesh, epsilon)?;
    if !is_like_a_sphere(mesh) {
        return Ok(None);
    }
    Ok(if_strictly_convex(&ordered(mesh), epsilon, settings))
}

fn if_strictly_convex(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
) -> Option<Decomposition> {
    let affordable = settings.most_vertices == 0 || mesh.vertices.len() <= settings.most_vertices;
    (affordable && is_strictly_convex(mesh)).then(|| itself(mesh.clone(), epsilon))
}

/// The decomposition of a convex solid.
fn itself(hull: Mesh, epsilon: f64) -> Decomposition {
    let (hull, reach) = match cleared(&hull, CLEARANCE * epsilon) {
        Some(found) => (found.hull, found.reach),
        None => (hull, 0.0),
    };
    let within = Interval {
        lower: 0.0,
        upper: reach,
    };
    let hull = Hull {
        volume: volume(&hull),
        mesh: hull,
        thickening: within,
        concavity: Some(within),
        children: None,
    };
    Decomposition {
        hulls: vec![hull],
        leaves: 1,
    }
}

/// The decomposition and, unless the solid is convex, what it was made from.
type Found = (Decomposition, Option<(Working, Cover)>);

fn run(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
    threads: usize,
    control: &Control,
) -> Result<Found, DecomposeError> {
    check(mesh, epsilon)?;
    let same = ordered(mesh);
    if let Some(found) = if_strictly_convex(&same, epsilon, settings) {
        return Ok((found, None));
    }
    let small = same.triangles.len() <= SMALL;
    if small {
        if let Some(found) = if_convex(mesh, &same, epsilon, settings, control)? {
            return Ok((found, None));
        }
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK)
        .build()
        .map_err(|e| DecomposeError::Internal(e.to_string()))?;
    pool.install(|| {
        if !small {
            if let Some(found) = if_convex(mesh, &same, epsilon, settings, control)? {
                return Ok((found, None));
            }
        }
        concave(&same, epsilon, settings, control)
    })
}

/// Closed meshes with so few triangles are looked at before threads are started for them.
const SMALL: usize = 4_000;

/// The decomposition of a solid that is convex, with flat edges or without.
fn if_convex(
    mesh: &Mesh,
    ordered: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
    control: &Control,
) -> Result<Option<Decomposition>, DecomposeError> {
    // The input itself, so that an error names its vertices.
    let closed = || check_closed(mesh);
    let hull = || convex_hull(&ordered.vertices).map_err(flat);
    let (closed, hull) = if rayon::current_thread_index().is_some() {
        rayon::join(closed, hull)
    } else {
        (closed(), hull())
    };
    closed?;
    let hull = hull?;
    control.go_on()?;
    let own = volume(ordered);
    // Little bodies far apart hold little of their hull, too.
    let little = own <= 1e-12 * volume(&hull);
    if own <= 0.0 || little && own <= Rounding::of(ordered).volume(ordered) {
        return Err(DecomposeError::Flat { dimension: 3 });
    }
    let affordable = settings.most_vertices == 0 || hull.vertices.len() <= settings.most_vertices;
    let convex = affordable && is_convex(ordered, &hull);
    Ok(convex.then(|| itself(hull, epsilon)))
}

/// How far removing slivers of a convex solid may reach outward, in ε.
const CLEARANCE: f64 = 1e-3;

/// Stack of the engine's threads.
const STACK: usize = 16 << 20;

/// Everything but the convex.
fn concave(
    mesh: &Mesh,
    epsilon: f64,
    settings: &SearchSettings,
    control: &Control,
) -> Result<Found, DecomposeError> {
    let frame = match settings.frame {
        FrameChoice::Mesh => DMat3::IDENTITY,
        FrameChoice::Faces => frame::choose(mesh),
        FrameChoice::Principal => frame::principal(mesh),
    };
    control.go_on()?;
    let (working, copy) = Working::new(mesh, frame);
    control.go_on()?;
    let (solid, roots) = rayon::join(
        || SolidIndex::new(&copy),
        || roots(&copy, settings, control),
    );
    let roots = roots?;
    control.go_on()?;
    let cancelled = || control.is_cancelled();
    let limits = Limits {
        // A proof that is not there by then is a matter of the last digit; the part is
        // cut or the merge refused instead, which is as true and a thousand times faster.
        cells: 3_000,
        cancelled: &cancelled,
    };
    // What rounding between the copies may hide is taken off the tolerance.
    let target = working.length(epsilon - 2.0 * working.rounding());
    if target <= 0.0 {
        return Err(DecomposeError::Tolerance { epsilon });
    }
    let judge = Judge {
        solid: &solid,
        metric: settings.metric,
        epsilon: target,
        limits: &limits,
    };
    let mut cover = cover(&copy, roots, &judge, settings, control)?;
    adopt(&mut cover, &copy, &working);
    let gap = settings.gap;
    let finish = Finish {
        working: &working,
        judge,
        slim: settings.slim,
        // Nobody needs many digits of what is small beside the tolerance.
        gap: Gap {
            relative: gap,
            absolute: (716.0 * gap * gap * gap * gap.sqrt()).min(0.02) * target,
        },
        cells: settings.cells,
        most_vertices: settings.most_vertices,
    };
    let finished = finished(&finish, &cover, control)?;
    control.go_on()?;
    let leaves = finished.len();
    // Each step to a coarser level depends on the one before it; threads that wait for that have
    // the concavities to do.
    let (nodes, concavities) = rayon::join(
        || build(&finish, finished.clone()),
        || concavities(&finish, &finished, &cover),
    );
    let (nodes, concavities) = (nodes?, concavities?);
    control.go_on()?;
    let known = concavities.into_iter().map(Some);
    let hulls = nodes
        .into_iter()
        .zip(known.chain(std::iter::repeat(None)))
        .map(|(node, concavity)| output(&working, node, concavity))
        .collect();
    control.report(1.0);
    Ok((Decomposition { hulls, leaves }, Some((working, cover))))
}

/// All hulls of a cover, finished. Those of many vertices come first: started last, one of them
/// would keep a thread busy while the others have nothing left to do.
fn finished(
    finish: &Finish<'_>,
    cover: &Cover,
    control: &Control,
) -> Result<Vec<(Mesh, Proved)>, DecomposeError> {
    let points = |hull: &Proved| -> usize {
        let parts = hull.members.iter().map(|&m| &cover.parts[m as usize]);
        parts.map(|part| part.points.len()).sum()
    };
    let mut order: Vec<usize> = (0..cover.hulls.len()).collect();
    order.sort_by_cached_key(|&k| Reverse(cover.hulls[k].hull.vertices.len()));
    control.report(MERGED);
    let all: usize = cover.hulls.iter().map(points).sum();
    let so_far = AtomicUsize::new(0);
    let found = next_first(&order, |&k| {
        let own = points(&cover.hulls[k]);
        let found = finish.run(&cover.hulls[k], &cover.parts);
        let share = (so_far.fetch_add(own, Ordering::Relaxed) + own) as f64 / all.max(1) as f64;
        control.report(MERGED + (FINISHED - MERGED) * share);
        found.map(|found| (k, found))
    });
    let mut done: Vec<_> = found.into_iter().collect::<Result<_, _>>()?;
    done.sort_unstable_by_key(|d| d.0);
    Ok(done.into_iter().map(|d| d.1).collect())
}

/// The concavities of finished hulls.
fn concavities(
    finish: &Finish<'_>,
    finished: &[(Mesh, Proved)],
    cover: &Cover,
) -> Result<Vec<Interval>, DecomposeError> {
    let found = next_first(finished, |(_, proved)| {
        finish.concavity(proved, &cover.parts)
    });
    found.into_iter().collect()
}

/// The cover of the search or of the outline, if the solid is one extruded: with the fewest
/// hulls, of these the tightest.
fn cover(
    copy: &Mesh,
    roots: Vec<Open>,
    judge: &Judge<'_>,
    settings: &SearchSettings,
    control: &Control,
) -> Result<Cover, DecomposeError> {
    let searched = decompose_working(roots, judge, settings, control)?;
    let covers = std::iter::once(searched).chain(prismatic::cover(copy, judge, settings));
    fewest(covers.collect())
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
    Ok(())
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

fn output(working: &Working, node: Node, concavity: Option<Interval>) -> Hull {
    let out = |x: f64| working.input_length(x);
    let widened = |bounds: Interval| Interval {
        lower: (out(bounds.lower) - 2.0 * working.rounding()).max(0.0),
        upper: out(bounds.upper) + 2.0 * working.rounding(),
    };
    Hull {
        volume: volume(&node.mesh),
        mesh: node.mesh,
        thickening: widened(node.proved.thickening),
        concavity: concavity.map(widened),
        children: node.children,
    }
}

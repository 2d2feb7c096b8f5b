//! Which polytopes are kept: few that leave little of the solid out.

use assetpipe_geometry::distance::{SolidIndex, Triangle};
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use super::body::Body;
use super::grow::grow;
use super::proof::is_inside;
use super::seeds::{seeds, Seed};
use super::thin::thin_inward;
use crate::control::Control;
use crate::convex::is_convex;
use crate::error::DecomposeError;
use crate::merge::volume;

/// How bodies are grown at a time: a constant, so that the result does not
/// depend on the number of threads.
const BATCH: usize = 16;

/// Growing again around the polytope's own centre stops when it gains less.
const WORTH: f64 = 1.03;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct InnerSettings {
    /// A point of the surface counts as reached if a polytope is this near.
    pub gap: f64,
    /// At most so many polytopes.
    pub most: usize,
    /// At most so many vertices each.
    pub most_vertices: usize,
    /// Points of the surface that are to be reached.
    pub samples: usize,
}

/// A convex polytope proved to be inside.
#[derive(Clone, Debug)]
pub struct InnerPolytope {
    /// The polytope.
    pub mesh: Mesh,
    /// Its volume.
    pub volume: f64,
}

/// Convex polytopes inside a closed solid, largest first, and the share of the
/// surface (by samples) that lies within `gap` of one.
///
/// Every polytope is proved inside by [`is_inside`]; one that is not is
/// dropped. The share is an estimate.
///
/// # Errors
/// [`DecomposeError::Cancelled`].
pub fn inner_polytopes(
    mesh: &Mesh,
    settings: &InnerSettings,
    control: &Control,
) -> Result<(Vec<InnerPolytope>, f64), DecomposeError> {
    if let Some(whole) = itself(mesh, settings) {
        return Ok((vec![whole], 1.0));
    }
    let solid = SolidIndex::new(mesh);
    let seeds = seeds(mesh, &solid, settings.samples);
    let mut open: Vec<bool> = vec![true; seeds.len()];
    let mut tried: Vec<bool> = vec![false; seeds.len()];
    let mut found: Vec<(InnerPolytope, Vec<u32>)> = Vec::new();
    loop {
        control.go_on()?;
        let reached = open.iter().filter(|o| !**o).count();
        control.report(reached as f64 / seeds.len().max(1) as f64);
        let batch = next(&seeds, &open, &mut tried, settings.gap);
        if batch.is_empty() || found.len() >= 2 * settings.most {
            break;
        }
        let grown: Vec<Option<(Mesh, Vec<u32>)>> = batch
            .par_iter()
            .map(|&k| {
                let polytope = largest(&solid, &seeds[k], settings)?;
                let near = reached_by(&polytope, &seeds, settings.gap);
                Some((polytope, near))
            })
            .collect();
        for (mesh, near) in grown.into_iter().flatten() {
            if near.iter().any(|&k| open[k as usize]) {
                for &k in &near {
                    open[k as usize] = false;
                }
                let volume = volume(&mesh);
                found.push((InnerPolytope { mesh, volume }, near));
            }
        }
    }
    let (kept, reached) = fewest(found, seeds.len(), settings.most);
    control.report(1.0);
    Ok((kept, reached as f64 / seeds.len().max(1) as f64))
}

/// A convex solid, but for vertices that it can spare.
fn itself(mesh: &Mesh, settings: &InnerSettings) -> Option<InnerPolytope> {
    let hull = convex_hull(&mesh.vertices).ok()?;
    if !is_convex(mesh, &hull) {
        return None;
    }
    let mesh = thin_inward(&hull, 0.1 * settings.gap, settings.most_vertices)?;
    let volume = volume(&mesh);
    Some(InnerPolytope { mesh, volume })
}

/// The deepest seeds that are neither reached nor tried, not two about one centre.
fn next(seeds: &[Seed], open: &[bool], tried: &mut [bool], gap: f64) -> Vec<usize> {
    let mut batch: Vec<usize> = Vec::with_capacity(BATCH);
    for k in 0..seeds.len() {
        if !open[k] || tried[k] {
            continue;
        }
        let apart = |j: &usize| {
            let distance = seeds[*j].point.distance(seeds[k].point);
            let between = seeds[*j].centre.distance(seeds[k].centre);
            distance > 2.0 * gap && between > 0.5 * seeds[*j].radius
        };
        if batch.iter().all(apart) {
            tried[k] = true;
            batch.push(k);
            if batch.len() == BATCH {
                break;
            }
        }
    }
    batch
}

/// The largest proved polytope that the seed's point is near to: grown from
/// the ball, then from the ellipsoid of what it grew to, for as long as that gains.
fn largest(solid: &SolidIndex, seed: &Seed, settings: &InnerSettings) -> Option<Mesh> {
    let ease = 0.05 * settings.gap;
    let mut best: Option<(f64, Mesh)> = None;
    let mut body = Body::ball(seed.centre);
    for _ in 0..4 {
        let Some(polytope) = grow(solid.bvh(), &body, ease) else {
            break;
        };
        let size = volume(&polytope);
        if let Some((before, _)) = best {
            if size < WORTH * before || !Reach::new(&polytope, settings.gap).holds(seed.point) {
                break;
            }
        }
        let next = Body::of(&polytope);
        best = Some((size, polytope));
        let Some(next) = next else { break };
        body = next;
    }
    let (_, polytope) = best?;
    let thin = thin_inward(&polytope, 0.1 * settings.gap, settings.most_vertices)?;
    proved(solid, &thin)
}

/// The polytope, if it is proved inside, shrunk a little where rounding spoiled it.
fn proved(solid: &SolidIndex, polytope: &Mesh) -> Option<Mesh> {
    let centre = polytope.vertices.iter().sum::<DVec3>() / polytope.vertices.len() as f64;
    for shrink in [0.0, 1e-9, 1e-7, 1e-5] {
        let points: Vec<DVec3> = polytope
            .vertices
            .iter()
            .map(|&p| p + (centre - p) * shrink)
            .collect();
        let smaller = convex_hull(&points).ok()?;
        if is_inside(solid, &smaller) {
            return Some(smaller);
        }
    }
    None
}

/// A polytope that is asked how near points are.
struct Reach {
    planes: Vec<(DVec3, f64)>,
    faces: Vec<Triangle>,
    gap: f64,
}

impl Reach {
    fn new(polytope: &Mesh, gap: f64) -> Reach {
        let planes = polytope
            .faces()
            .map(|[a, b, c]| {
                let normal = (b - a).cross(c - a).normalize_or_zero();
                (normal, normal.dot(a))
            })
            .collect();
        Reach {
            planes,
            faces: polytope.faces().map(Triangle::new).collect(),
            gap,
        }
    }

    /// Whether a point is within the gap of the polytope.
    fn holds(&self, p: DVec3) -> bool {
        let mut inside = true;
        for (normal, offset) in &self.planes {
            let height = normal.dot(p) - offset;
            if height > self.gap {
                return false;
            }
            inside &= height <= 0.0;
        }
        let near = self.gap * self.gap;
        inside || self.faces.iter().any(|f| f.distance2(p) <= near)
    }
}

/// Seeds whose points are within `gap` of the polytope.
fn reached_by(polytope: &Mesh, seeds: &[Seed], gap: f64) -> Vec<u32> {
    let reach = Reach::new(polytope, gap);
    (0..seeds.len() as u32)
        .filter(|&k| reach.holds(seeds[k as usize].point))
        .collect()
}

/// Greedy set cover: at each step the polytope that reaches most of what is
/// not reached yet, the larger one of equals; those that add nothing are dropped.
fn fewest(
    found: Vec<(InnerPolytope, Vec<u32>)>,
    seeds: usize,
    most: usize,
) -> (Vec<InnerPolytope>, usize) {
    let mut open = vec![true; seeds];
    let mut rest: Vec<Option<(InnerPolytope, Vec<u32>)>> = found.into_iter().map(Some).collect();
    let mut kept = Vec::new();
    let mut reached = 0;
    while kept.len() < most {
        let gain = |entry: &Option<(InnerPolytope, Vec<u32>)>| {
            entry.as_ref().map_or((0, 0.0), |(polytope, near)| {
                let new = near.iter().filter(|&&k| open[k as usize]).count();
                (new, polytope.volume)
            })
        };
        let best = (0..rest.len()).map(|k| (gain(&rest[k]), k)).max_by(|a, b| {
            let ((new, size), k) = a;
            let ((other, than), j) = b;
            new.cmp(other).then(size.total_cmp(than)).then(j.cmp(k))
        });
        let Some(((new, _), at)) = best else { break };
        if new == 0 {
            break;
        }
        reached += new;
        if let Some((polytope, near)) = rest[at].take() {
            for k in near {
                open[k as usize] = false;
            }
            kept.push(polytope);
        }
    }
    kept.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    (kept, reached)
}

//! Coarser levels: the hulls merged on, two by two, until one is left.
//!
//! Every inner node is the hull of its two children with its own certificate,
//! so any coarser tolerance or smaller number of hulls is read off without
//! computing again (Lien & Amato 2006, §1). Hulls nest, so a parent's
//! thickening is never below its children's.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use crate::between::Tips;
use crate::concavity::thickening::bounds_above;
use crate::concavity::{Gap, Interval, Limits};
use crate::error::DecomposeError;
use crate::finish::Finish;
use crate::merge::Proved;

/// How close the bounds of coarser levels are brought to one another: they are
/// read, not searched with.
fn coarse<'a>(finish: &Finish<'a>) -> (Gap, Limits<'a>) {
    let gap = Gap {
        relative: 2.0 * finish.gap.relative,
        absolute: 1e-4,
    };
    let limits = Limits {
        cells: finish.cells.min(20_000),
        ..*finish.judge.limits
    };
    (gap, limits)
}

/// Pairs that are looked at for one that can be joined ahead of its turn.
const LOOK_AHEAD: usize = 8;

/// The bits of an estimate, and the pair that it is of.
type Turn = (u64, u32, u32);
/// Least first.
type Waiting = Reverse<Turn>;

/// A node: a leaf, or the hull of two earlier nodes.
#[derive(Clone, Debug)]
pub struct Node {
    /// The hull in the input's coordinates.
    pub mesh: Mesh,
    /// Its working copy with the bound.
    pub proved: Proved,
    /// Its concavity towards its part, for leaves.
    pub concavity: Option<Interval>,
    /// Indices of the two nodes it replaces.
    pub children: Option<[u32; 2]>,
}

/// Merge on until one hull is left, least estimated thickening first.
///
/// # Errors
/// [`DecomposeError::Internal`] for hulls without volume.
pub fn build(
    finish: &Finish<'_>,
    leaves: Vec<(Mesh, Proved, Option<Interval>)>,
) -> Result<Vec<Node>, DecomposeError> {
    let mut nodes: Vec<Node> = leaves
        .into_iter()
        .map(|(mesh, proved, concavity)| Node {
            mesh,
            proved,
            concavity,
            children: None,
        })
        .collect();
    let solid = finish.judge.solid;
    let mut tips: Vec<Tips> = nodes.par_iter().map(|n| Tips::of(&n.proved.hull)).collect();
    let mut open: Vec<bool> = vec![true; nodes.len()];
    let mut queue: BinaryHeap<Waiting> = (0..nodes.len())
        .into_par_iter()
        .flat_map_iter(|j| (0..j).map(move |i| (i, j)))
        .map(|(i, j)| estimate(solid, &nodes, &tips, i, j))
        .collect::<Vec<_>>()
        .into();
    // Joined ahead of their turn.
    let mut ready: BTreeMap<(u32, u32), Node> = BTreeMap::new();
    while let Some(Reverse(turn)) = queue.pop() {
        if (finish.judge.limits.cancelled)() {
            return Err(DecomposeError::Cancelled);
        }
        let (_, i, j) = turn;
        let known = ready.remove(&(i, j));
        if !open[i as usize] || !open[j as usize] {
            continue;
        }
        let node = if let Some(node) = known {
            node
        } else {
            let mut turns = vec![turn];
            turns.extend(likely(&mut queue, turn, &open));
            let mut made = turns
                .par_iter()
                .map(|&(bits, i, j)| join(finish, &nodes, [i, j], f64::from_bits(bits)))
                .collect::<Result<Vec<_>, _>>()?
                .into_iter();
            let Some(node) = made.next() else { break };
            ready.extend(turns[1..].iter().map(|t| (t.1, t.2)).zip(made));
            node
        };
        open[i as usize] = false;
        open[j as usize] = false;
        let new = nodes.len();
        tips.push(Tips::of(&node.proved.hull));
        nodes.push(node);
        let others: Vec<usize> = (0..new).filter(|&k| open[k]).collect();
        queue.par_extend(
            others
                .into_par_iter()
                .map(|other| estimate(solid, &nodes, &tips, other, new)),
        );
        open.push(true);
    }
    Ok(nodes)
}

/// Pairs that will most likely have their turn soon, whatever becomes of the one whose turn it is:
/// as many as there are other threads.
fn likely(queue: &mut BinaryHeap<Waiting>, turn: Turn, open: &[bool]) -> Vec<Turn> {
    let count = rayon::current_num_threads() - 1;
    let mut seen = Vec::new();
    let mut found: Vec<Turn> = Vec::new();
    while found.len() < count && seen.len() < LOOK_AHEAD * count {
        let Some(next) = queue.pop() else { break };
        let Reverse((_, i, j)) = next;
        let taken = |k: u32| {
            let of = |t: &Turn| t.1 == k || t.2 == k;
            !open[k as usize] || of(&turn) || found.iter().any(of)
        };
        if !taken(i) && !taken(j) {
            found.push(next.0);
        }
        seen.push(next);
    }
    queue.extend(seen);
    found
}

/// A pair with an estimate from a few points between the two hulls.
fn estimate(solid: &SolidIndex, nodes: &[Node], tips: &[Tips], i: usize, j: usize) -> Waiting {
    let lower = |k: usize| nodes[k].proved.thickening.lower;
    let reach = tips[i].thickening(&tips[j], solid);
    let estimate = lower(i).max(lower(j)).max(reach);
    Reverse((estimate.to_bits(), i as u32, j as u32))
}

/// The joined hull with its bound.
fn join(
    finish: &Finish<'_>,
    nodes: &[Node],
    children: [u32; 2],
    estimate: f64,
) -> Result<Node, DecomposeError> {
    let [a, b] = children.map(|c| &nodes[c as usize]);
    let points: Vec<DVec3> = a
        .mesh
        .vertices
        .iter()
        .chain(&b.mesh.vertices)
        .copied()
        .collect();
    let mesh = finish.within_budget(
        convex_hull(&points).map_err(|e| DecomposeError::Internal(e.to_string()))?,
    )?;
    let mesh = finish.without_slivers(mesh);
    let hull = finish.image(&mesh)?;
    let known = (estimate - finish.judge.solid.slack())
        .max(a.proved.thickening.lower)
        .max(b.proved.thickening.lower);
    let (gap, limits) = coarse(finish);
    let thickening = bounds_above(finish.judge.solid, &hull, known, gap, &limits);
    let mut members: Vec<u32> = a
        .proved
        .members
        .iter()
        .chain(&b.proved.members)
        .copied()
        .collect();
    members.sort_unstable();
    Ok(Node {
        mesh,
        proved: Proved {
            hull,
            thickening,
            members,
        },
        concavity: None,
        children: Some(children),
    })
}

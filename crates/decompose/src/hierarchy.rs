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

use crate::ahead::ahead;
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

/// Pairs by their estimates. Most pairs never have their turn, so they wait with a first glance,
/// which is never above the estimate, and are estimated when they would be next.
struct Queue<'a> {
    solid: &'a SolidIndex,
    waiting: BinaryHeap<Reverse<(Turn, Look)>>,
}

/// What the number of a pair in the queue is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Look {
    Glance,
    Estimate,
}

impl Queue<'_> {
    /// Add pairs of nodes.
    fn add(
        &mut self,
        nodes: &[Node],
        tips: &[Tips],
        pairs: impl ParallelIterator<Item = [usize; 2]>,
    ) {
        let solid = self.solid;
        let lower = |k: usize| nodes[k].proved.thickening.lower;
        self.waiting.par_extend(pairs.map(|[i, j]| {
            let glance = tips[i].glance(&tips[j], solid);
            let known = lower(i).max(lower(j)).max(glance);
            Reverse(((known.to_bits(), i as u32, j as u32), Look::Glance))
        }));
    }

    /// The pair of nodes that stand whose turn is next.
    fn next(&mut self, tips: &[Tips], open: &[bool]) -> Option<Turn> {
        while let Some(Reverse((turn, look))) = self.waiting.pop() {
            let (bits, i, j) = turn;
            if !open[i as usize] || !open[j as usize] {
                continue;
            }
            if look == Look::Estimate {
                return Some(turn);
            }
            let (a, b) = (&tips[i as usize], &tips[j as usize]);
            let estimate = a.thickening(b, self.solid, f64::from_bits(bits));
            self.again([(estimate.to_bits(), i, j)]);
        }
        None
    }

    /// Let pairs that were taken wait again.
    fn again(&mut self, turns: impl IntoIterator<Item = Turn>) {
        let waiting = turns
            .into_iter()
            .map(|turn| Reverse((turn, Look::Estimate)));
        self.waiting.extend(waiting);
    }
}

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
    let mut tips: Vec<Tips> = nodes.par_iter().map(|n| Tips::of(&n.proved.hull)).collect();
    let mut open: Vec<bool> = vec![true; nodes.len()];
    let mut queue = Queue {
        solid: finish.judge.solid,
        waiting: BinaryHeap::new(),
    };
    let pairs = (0..nodes.len()).into_par_iter();
    queue.add(
        &nodes,
        &tips,
        pairs.flat_map_iter(|j| (0..j).map(move |i| [i, j])),
    );
    // Joined ahead of their turn.
    let mut ready: BTreeMap<(u32, u32), Node> = BTreeMap::new();
    while let Some(turn) = queue.next(&tips, &open) {
        finish.judge.go_on()?;
        let (_, i, j) = turn;
        let known = ready.remove(&(i, j));
        let node = if let Some(node) = known {
            node
        } else {
            let mut turns = vec![turn];
            turns.extend(likely(&mut queue, turn, &tips, &open));
            let mut made = turns
                .par_iter()
                .with_max_len(1)
                .map(|&(bits, i, j)| join(finish, &nodes, [i, j], f64::from_bits(bits)))
                .collect::<Result<Vec<_>, _>>()?
                .into_iter();
            let Some(node) = made.next() else { break };
            ready.extend(turns[1..].iter().map(|t| (t.1, t.2)).zip(made));
            node
        };
        open[i as usize] = false;
        open[j as usize] = false;
        ready.retain(|&(i, j), _| open[i as usize] && open[j as usize]);
        let new = nodes.len();
        tips.push(Tips::of(&node.proved.hull));
        nodes.push(node);
        let others: Vec<usize> = (0..new).filter(|&k| open[k]).collect();
        queue.add(
            &nodes,
            &tips,
            others.into_par_iter().map(|other| [other, new]),
        );
        open.push(true);
    }
    Ok(nodes)
}

/// Pairs that will most likely have their turn soon, whatever becomes of the one whose turn it is.
fn likely(queue: &mut Queue<'_>, turn: Turn, tips: &[Tips], open: &[bool]) -> Vec<Turn> {
    let count = ahead();
    let mut seen = Vec::new();
    let mut found: Vec<Turn> = Vec::new();
    while found.len() < count && seen.len() < LOOK_AHEAD * count {
        let Some(next) = queue.next(tips, open) else {
            break;
        };
        let taken = |k: u32| {
            let of = |t: &Turn| t.1 == k || t.2 == k;
            of(&turn) || found.iter().any(of)
        };
        if !taken(next.1) && !taken(next.2) {
            found.push(next);
        }
        seen.push(next);
    }
    queue.again(seen);
    found
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

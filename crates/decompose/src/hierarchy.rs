//! Coarser levels: the hulls merged on, two by two, until one is left.
//!
//! Every inner node is the hull of its two children with its own certificate,
//! so any coarser tolerance or smaller number of hulls is read off without
//! computing again (Lien & Amato 2006, §1). Hulls nest, so a parent's
//! thickening is never below its children's.

use std::sync::Arc;

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;
use rayon::prelude::*;

use crate::ahead::{in_turn, shared_out, Ahead, Dropped, Order, Pair, Turns};
use crate::between::Tips;
use crate::concavity::thickening::bounds_above;
use crate::concavity::{Gap, Limits};
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

/// A node: a leaf, or the hull of two earlier nodes.
#[derive(Clone, Debug)]
pub struct Node {
    /// The hull in the input's coordinates.
    pub mesh: Mesh,
    /// Its working copy with the bound.
    pub proved: Proved,
    /// Indices of the two nodes it replaces.
    pub children: Option<[u32; 2]>,
}

/// Merge on until one hull is left, least estimated thickening first.
///
/// # Errors
/// [`DecomposeError::Internal`] for hulls without volume.
pub fn build(
    finish: &Finish<'_>,
    leaves: Vec<(Mesh, Proved)>,
) -> Result<Vec<Node>, DecomposeError> {
    let leaf = |(mesh, proved)| Node {
        mesh,
        proved,
        children: None,
    };
    let standing: Vec<Arc<Standing>> = leaves
        .into_par_iter()
        .map(|found| Arc::new(Standing::new(leaf(found))))
        .collect();
    let numbered = |k: usize| (k as u32, &standing[k]);
    let first: Vec<Turn> = (0..standing.len())
        .into_par_iter()
        .flat_map_iter(|j| (0..j).map(move |i| [i, j]))
        .map(|pair| glance(finish.judge.solid, pair.map(numbered)))
        .collect();
    let mut levels = Levels {
        finish,
        nodes: standing,
        order: Order::new(Ahead::Apart),
        unseen: Vec::new(),
        glancing: 0,
        failed: None,
    };
    for turn in first {
        levels.order.push((turn, Look::Glance), ());
    }
    let levels = in_turn(levels, |task| run(finish, task));
    finish.judge.go_on()?;
    if let Some(error) = levels.failed {
        return Err(error);
    }
    let nodes = levels.nodes.into_iter();
    Ok(nodes.map(|n| Arc::unwrap_or_clone(n).node).collect())
}

/// The bits of an estimate, and the pair that it is of.
type Turn = (u64, u32, u32);

/// What the number of a pair is. Most pairs never have their turn, so they wait with a first
/// glance, which is never above the estimate, and are estimated when they would be next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Look {
    Glance,
    Estimate,
}

impl Pair for (Turn, Look) {
    fn pair(&self) -> [u32; 2] {
        [self.0 .1, self.0 .2]
    }
}

/// A node with what is asked of it again and again.
#[derive(Clone)]
struct Standing {
    node: Node,
    tips: Tips,
}

impl Standing {
    fn new(node: Node) -> Standing {
        Standing {
            tips: Tips::of(&node.proved.hull),
            node,
        }
    }
}

/// What is worked on by itself.
enum Task {
    /// Glance at the pairs of the first node with the others.
    Glance(Vec<(u32, Arc<Standing>)>),
    /// Estimate a pair.
    Estimate(Turn, [Arc<Standing>; 2]),
    /// Join it, unless that is not asked any more.
    Join(Turn, [Arc<Standing>; 2], Dropped),
}

/// What came of it.
enum Done {
    Glanced(Vec<Turn>),
    /// Before and after.
    Estimated(Turn, Turn),
    Joined(Turn, Joined),
}

/// The node of a pair. What was joined ahead of its turn may fail without anybody asking for it.
type Joined = Result<Arc<Standing>, DecomposeError>;

fn run(finish: &Finish<'_>, task: Task) -> Done {
    let solid = finish.judge.solid;
    match task {
        Task::Glance(nodes) => {
            let Some(((new, node), others)) = nodes.split_first() else {
                return Done::Glanced(Vec::new());
            };
            let others = others.iter();
            let turns = others.map(|(i, other)| glance(solid, [(*i, other), (*new, node)]));
            Done::Glanced(turns.collect())
        }
        Task::Estimate(turn, [a, b]) => {
            let (bits, i, j) = turn;
            let estimate = a.tips.thickening(&b.tips, solid, f64::from_bits(bits));
            Done::Estimated(turn, (estimate.to_bits(), i, j))
        }
        Task::Join(turn, nodes, dropped) => {
            let node = join(finish, turn, &nodes, &dropped);
            Done::Joined(turn, node.map(|node| Arc::new(Standing::new(node))))
        }
    }
}

/// A pair with a first glance at it.
fn glance(solid: &SolidIndex, [(i, a), (j, b)]: [(u32, &Arc<Standing>); 2]) -> Turn {
    let lower = |s: &Standing| s.node.proved.thickening.lower;
    let known = lower(a).max(lower(b)).max(a.tips.glance(&b.tips, solid));
    (known.to_bits(), i, j)
}

/// Nodes, and pairs of them in the order of their turns.
struct Levels<'a> {
    finish: &'a Finish<'a>,
    nodes: Vec<Arc<Standing>>,
    order: Order<(Turn, Look), (), Joined>,
    /// Nodes that are still to be glanced at with another.
    unseen: Vec<Vec<(u32, Arc<Standing>)>>,
    /// How many of these come before anything has its turn.
    glancing: usize,
    failed: Option<DecomposeError>,
}

impl Turns for Levels<'_> {
    type Task = Task;
    type Done = Done;

    fn next(&mut self) -> Option<Task> {
        if self.failed.is_some() || (self.finish.judge.limits.cancelled)() {
            return None;
        }
        while self.glancing == 0 {
            let Some((key, joined)) = self.order.settle() else {
                break;
            };
            match joined {
                Ok(node) => self.stand(key, node),
                Err(error) => {
                    self.failed = Some(error);
                    return None;
                }
            }
        }
        if let Some(nodes) = self.unseen.pop() {
            return Some(Task::Glance(nodes));
        }
        let (key, (), dropped) = self.order.ask()?;
        let pair = key.pair().map(|k| self.nodes[k as usize].clone());
        let (turn, look) = key;
        Some(match look {
            Look::Glance => Task::Estimate(turn, pair),
            Look::Estimate => Task::Join(turn, pair, dropped),
        })
    }

    fn take(&mut self, done: Done) {
        match done {
            Done::Glanced(turns) => {
                self.glancing -= 1;
                for turn in turns {
                    self.order.push((turn, Look::Glance), ());
                }
            }
            Done::Estimated(before, after) => {
                let (before, after) = ((before, Look::Glance), (after, Look::Estimate));
                self.order.again(before, after, ());
            }
            Done::Joined(turn, joined) => self.order.answer((turn, Look::Estimate), joined),
        }
    }
}

impl Levels<'_> {
    /// Let a new node stand for two.
    fn stand(&mut self, key: (Turn, Look), node: Arc<Standing>) {
        self.order.retire(&key);
        let others: Vec<(u32, Arc<Standing>)> = (0u32..)
            .zip(&self.nodes)
            .filter(|(k, _)| !self.order.is_gone(*k))
            .map(|(k, node)| (k, node.clone()))
            .collect();
        self.unseen = shared_out(&(self.nodes.len() as u32, node.clone()), &others);
        self.glancing = self.unseen.len();
        self.nodes.push(node);
    }
}

/// The joined hull with its bound.
fn join(
    finish: &Finish<'_>,
    (bits, i, j): Turn,
    nodes: &[Arc<Standing>; 2],
    dropped: &Dropped,
) -> Result<Node, DecomposeError> {
    let [a, b] = [&nodes[0].node, &nodes[1].node];
    let estimate = f64::from_bits(bits);
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
    let cancelled = || (limits.cancelled)() || dropped.is_dropped();
    let limits = Limits {
        cancelled: &cancelled,
        ..limits
    };
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
        children: Some([i, j]),
    })
}

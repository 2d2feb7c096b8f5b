//! Coarser levels: the hulls merged on, two by two, until one is left.
//!
//! Every inner node is the hull of its two children with its own certificate,
//! so any coarser tolerance or smaller number of hulls is read off without
//! computing again (Lien & Amato 2006, §1). Hulls nest, so a parent's
//! thickening is never below its children's.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use assetpipe_geometry::distance::SolidIndex;
use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::concavity::thickening::bounds_above;
use crate::concavity::{Gap, Interval, Limits};
use crate::error::DecomposeError;
use crate::finish::Finish;
use crate::merge::Proved;

/// How close the bounds of coarser levels are brought to one another: they are
/// read, not searched with.
const COARSE: Gap = Gap {
    relative: 0.1,
    absolute: 1e-4,
};

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
    let mut open: Vec<bool> = vec![true; nodes.len()];
    let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    for i in 0..nodes.len() {
        for j in i + 1..nodes.len() {
            offer(finish.judge.solid, &nodes, i, j, &mut queue);
        }
    }
    while let Some(Reverse((bits, i, j))) = queue.pop() {
        if (finish.judge.limits.cancelled)() {
            return Err(DecomposeError::Cancelled);
        }
        if !open[i as usize] || !open[j as usize] {
            continue;
        }
        let node = join(finish, &nodes, [i, j], f64::from_bits(bits))?;
        open[i as usize] = false;
        open[j as usize] = false;
        let new = nodes.len();
        nodes.push(node);
        for (other, _) in open.iter().enumerate().filter(|(_, &is_open)| is_open) {
            offer(finish.judge.solid, &nodes, other, new, &mut queue);
        }
        open.push(true);
    }
    Ok(nodes)
}

/// Queue a pair with an estimate from a few points between the two hulls.
fn offer(
    solid: &SolidIndex,
    nodes: &[Node],
    i: usize,
    j: usize,
    queue: &mut BinaryHeap<Reverse<(u64, u32, u32)>>,
) {
    let (a, b) = (&nodes[i].proved, &nodes[j].proved);
    let mut estimate = a.thickening.lower.max(b.thickening.lower);
    let pick = |p: &Proved, d: DVec3| {
        p.hull
            .vertices
            .iter()
            .copied()
            .max_by(|x, y| d.dot(*x).total_cmp(&d.dot(*y)))
            .unwrap_or(DVec3::ZERO)
    };
    let middle = |p: &Proved| {
        p.hull.vertices.iter().copied().sum::<DVec3>() / p.hull.vertices.len().max(1) as f64
    };
    let (ma, mb) = (middle(a), middle(b));
    let mut probe = |p: DVec3, q: DVec3| {
        for share in [0.25, 0.5, 0.75] {
            estimate = estimate.max(solid.distance(p.lerp(q, share)));
        }
    };
    probe(ma, mb);
    for d in [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ] {
        probe(pick(a, d), pick(b, d));
    }
    queue.push(Reverse((estimate.to_bits(), i as u32, j as u32)));
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
    let limits = Limits {
        cells: finish.cells,
        ..*finish.judge.limits
    };
    let thickening = bounds_above(finish.judge.solid, &hull, known, COARSE, &limits);
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

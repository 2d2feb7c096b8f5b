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
use glam::DVec3;

use crate::concavity::thickening::{decide, Decision};
use crate::concavity::{Interval, Limits};
use crate::merge::Proved;

/// Bounds of coarser levels are at most about this far apart: they are read,
/// not searched with.
const SLACK: f64 = 1.15;

/// A node: a leaf, or the hull of two earlier nodes.
#[derive(Clone, Debug)]
pub struct Node {
    /// The hull with its bound.
    pub proved: Proved,
    /// Indices of the two nodes it replaces.
    pub children: Option<[u32; 2]>,
}

/// Merge on until one hull is left, least estimated thickening first.
pub fn build(solid: &SolidIndex, leaves: Vec<Proved>, limits: &Limits<'_>) -> Vec<Node> {
    let mut nodes: Vec<Node> = leaves.into_iter().map(|proved| Node { proved, children: None }).collect();
    let mut open: Vec<bool> = vec![true; nodes.len()];
    let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    for i in 0..nodes.len() {
        for j in i + 1..nodes.len() {
            offer(solid, &nodes, i, j, &mut queue);
        }
    }
    while let Some(Reverse((bits, i, j))) = queue.pop() {
        if (limits.cancelled)() {
            break;
        }
        if !open[i as usize] || !open[j as usize] {
            continue;
        }
        let Some(proved) = join(solid, &nodes, i, j, f64::from_bits(bits), limits) else { continue };
        open[i as usize] = false;
        open[j as usize] = false;
        nodes.push(Node { proved, children: Some([i, j]) });
        open.push(true);
        let new = nodes.len() - 1;
        for other in 0..new {
            if open[other] {
                offer(solid, &nodes, other, new, &mut queue);
            }
        }
    }
    nodes
}

fn points(nodes: &[Node], i: usize, j: usize) -> Vec<DVec3> {
    [i, j].iter().flat_map(|&k| nodes[k].proved.hull.vertices.iter().copied()).collect()
}

/// Queue a pair with an estimate from a few points between the two hulls.
fn offer(solid: &SolidIndex, nodes: &[Node], i: usize, j: usize, queue: &mut BinaryHeap<Reverse<(u64, u32, u32)>>) {
    let (a, b) = (&nodes[i].proved, &nodes[j].proved);
    let mut estimate = a.thickening.lower.max(b.thickening.lower);
    let pick = |p: &Proved, d: DVec3| {
        p.hull.vertices.iter().copied().max_by(|x, y| d.dot(*x).total_cmp(&d.dot(*y))).unwrap_or(DVec3::ZERO)
    };
    let middle = |p: &Proved| p.hull.vertices.iter().copied().sum::<DVec3>() / p.hull.vertices.len().max(1) as f64;
    let (ma, mb) = (middle(a), middle(b));
    let mut probe = |p: DVec3, q: DVec3| {
        for share in [0.25, 0.5, 0.75] {
            estimate = estimate.max(solid.distance(p.lerp(q, share)));
        }
    };
    probe(ma, mb);
    for d in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
        probe(pick(a, d), pick(b, d));
    }
    queue.push(Reverse((estimate.to_bits(), i as u32, j as u32)));
}

/// The joined hull with a bound within a few percent.
fn join(solid: &SolidIndex, nodes: &[Node], i: u32, j: u32, estimate: f64, limits: &Limits<'_>) -> Option<Proved> {
    let hull = convex_hull(&points(nodes, i as usize, j as usize)).ok()?;
    let (a, b) = (&nodes[i as usize].proved, &nodes[j as usize].proved);
    let mut lower = estimate.max(a.thickening.lower).max(b.thickening.lower);
    let mut epsilon = lower.max(1e-6) * SLACK;
    let thickening = loop {
        match decide(solid, &hull, epsilon, limits) {
            Decision::Within(found) => break Interval { lower: lower.max(found.lower), upper: found.upper },
            Decision::Beyond { lower: found, .. } => {
                lower = lower.max(found);
                epsilon = lower * SLACK;
            }
            Decision::Unproven(found) => break Interval { lower: lower.max(found.lower), upper: found.upper },
        }
    };
    let mut members = a.members.clone();
    members.extend(&b.members);
    members.sort_unstable();
    Some(Proved { hull, thickening, members })
}

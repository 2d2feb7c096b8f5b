//! Building: binned surface-area heuristic (Wald 2007), with a median split
//! where it stops making progress.

use glam::DVec3;
use rayon::prelude::*;

use super::wide::Wide;
use super::{Bounds, Bvh, Node, DEPTH};
use crate::distance::Triangle;
use crate::Mesh;

const BINS: usize = 16;
const LEAF: usize = 4;

struct Item {
    bounds: Bounds,
    centre: DVec3,
    index: u32,
}

/// Fewer triangles are not worth another thread.
const FEW: usize = 4096;

/// Whether to share the work on so many items. Only the threads of a pool that the caller has
/// set up are used: starting one is not for a hierarchy to decide.
fn is_shared(count: usize) -> bool {
    count > FEW && rayon::current_thread_index().is_some()
}

/// All of `0..count`, in order.
fn each<T: Send>(count: usize, make: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    if is_shared(count) {
        (0..count).into_par_iter().map(make).collect()
    } else {
        (0..count).map(make).collect()
    }
}

pub(super) fn build(mesh: &Mesh) -> Bvh {
    let mut items: Vec<Item> = each(mesh.triangles.len(), |t| {
        let bounds = Bounds::around(mesh.corners(t));
        Item {
            bounds,
            centre: bounds.centre(),
            index: t as u32,
        }
    });
    let mut nodes = Vec::with_capacity(items.len());
    if !items.is_empty() {
        split(&mut items, 0, 0, &mut nodes);
    }
    Bvh {
        triangles: each(items.len(), |slot| {
            Triangle::new(mesh.corners(items[slot].index as usize))
        }),
        original: items.iter().map(|item| item.index).collect(),
        wide: Wide::new(&nodes),
        nodes,
    }
}

/// Append the subtree over `items`, whose first element has slot `first`.
fn split(items: &mut [Item], first: usize, depth: usize, nodes: &mut Vec<Node>) {
    let bounds = items.iter().fold(Bounds::EMPTY, |b, i| b.join(i.bounds));
    let at = nodes.len();
    nodes.push(Node {
        bounds,
        first: first as u32,
        count: items.len() as u32,
    });
    if items.len() <= LEAF {
        return;
    }
    let middle = if depth < DEPTH / 2 {
        partition_by_area(items)
    } else {
        None
    }
    .unwrap_or_else(|| partition_at_median(items));
    let shared = is_shared(items.len());
    let (left, right) = items.split_at_mut(middle);
    if shared {
        let subtree = |items: &mut [Item], first: usize| {
            let mut nodes = Vec::with_capacity(items.len());
            split(items, first, depth + 1, &mut nodes);
            nodes
        };
        let (left, right) = rayon::join(|| subtree(left, first), || subtree(right, first + middle));
        append(nodes, left);
        nodes[at].first = nodes.len() as u32;
        append(nodes, right);
    } else {
        split(left, first, depth + 1, nodes);
        nodes[at].first = nodes.len() as u32;
        split(right, first + middle, depth + 1, nodes);
    }
    nodes[at].count = 0;
}

/// Put a subtree that was built by itself behind others.
fn append(nodes: &mut Vec<Node>, subtree: Vec<Node>) {
    let shift = nodes.len() as u32;
    nodes.extend(subtree.into_iter().map(|mut node| {
        if node.count == 0 {
            node.first += shift;
        }
        node
    }));
}

fn half_area(b: &Bounds) -> f64 {
    let d = b.hi - b.lo;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Reorder `items` along the cheapest of the binned splits; `None` if all
/// centres fall into one bin.
fn partition_by_area(items: &mut [Item]) -> Option<usize> {
    let centres = Bounds::around(items.iter().map(|i| i.centre));
    let extent = centres.hi - centres.lo;
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        // NaN or infinite extents (never from validated meshes) must not split here.
        if !(extent[axis] > 0.0 && extent[axis].is_finite()) {
            continue;
        }
        let scale = BINS as f64 / extent[axis];
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for item in items.iter() {
            let bin = &mut bins[bin_of(item.centre[axis], centres.lo[axis], scale)];
            bin.0 = bin.0.join(item.bounds);
            bin.1 += 1;
        }
        let mut right = [(0.0, 0usize); BINS];
        let mut sweep = (Bounds::EMPTY, 0);
        for b in (1..BINS).rev() {
            sweep = (sweep.0.join(bins[b].0), sweep.1 + bins[b].1);
            right[b] = (half_area(&sweep.0), sweep.1);
        }
        let mut sweep = (Bounds::EMPTY, 0);
        for b in 1..BINS {
            sweep = (sweep.0.join(bins[b - 1].0), sweep.1 + bins[b - 1].1);
            if sweep.1 == 0 || right[b].1 == 0 {
                continue;
            }
            let cost = half_area(&sweep.0) * sweep.1 as f64 + right[b].0 * right[b].1 as f64;
            if best.is_none_or(|(c, _, _)| cost < c) {
                best = Some((cost, axis, b));
            }
        }
    }
    let (_, axis, border) = best?;
    let (lo, scale) = (centres.lo[axis], BINS as f64 / extent[axis]);
    let middle = partition(items, |i| bin_of(i.centre[axis], lo, scale) < border);
    (middle > 0 && middle < items.len()).then_some(middle)
}

fn bin_of(x: f64, lo: f64, scale: f64) -> usize {
    (((x - lo) * scale) as usize).min(BINS - 1)
}

/// Items that pass first, each side in a deterministic order.
fn partition(items: &mut [Item], pass: impl Fn(&Item) -> bool) -> usize {
    let mut next = 0;
    for k in 0..items.len() {
        if pass(&items[k]) {
            items.swap(next, k);
            next += 1;
        }
    }
    next
}

fn partition_at_median(items: &mut [Item]) -> usize {
    let centres = Bounds::around(items.iter().map(|i| i.centre));
    let extent = centres.hi - centres.lo;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.centre[axis]
            .total_cmp(&b.centre[axis])
            .then(a.index.cmp(&b.index))
    });
    middle
}

//! §6.5: put parts together again where the proof allows it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use assetpipe_geometry::hull::convex_hull;
use assetpipe_geometry::Mesh;
use glam::DVec3;

use crate::concavity::{Decision, Interval};
use crate::judge::Judge;
use crate::search::piece::Piece;
use crate::settings::{MergeOrder, Metric};

/// A hull with what is proved about it.
#[derive(Clone, Debug)]
pub struct Proved {
    /// The hull.
    pub hull: Mesh,
    /// Its thickening.
    pub thickening: Interval,
    /// Which leaves it covers.
    pub members: Vec<u32>,
}

/// Volume of a closed mesh.
pub fn volume(mesh: &Mesh) -> f64 {
    let Some(&o) = mesh.vertices.first() else {
        return 0.0;
    };
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| p - o);
            a.dot(b.cross(c))
        })
        .sum::<f64>()
        / 6.0
}

fn bounds(mesh: &Mesh) -> (DVec3, DVec3) {
    mesh.vertices
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        })
}

/// Planes of a hull's faces: `normal · x ≤ offset` inside.
pub fn half_spaces(hull: &Mesh) -> Vec<(DVec3, f64)> {
    (0..hull.triangles.len())
        .map(|t| {
            let [a, b, c] = hull.corners(t);
            let n = (b - a).cross(c - a);
            (n, n.dot(a))
        })
        .collect()
}

/// Merge pairs, cheapest added volume first, for as long as a merged hull is
/// proved to stay within ε. `witnesses` are known points farther than ε from
/// the solid: a hull that holds one needs no proof to be refused.
pub fn merge(
    judge: &Judge<'_>,
    parts: Vec<Proved>,
    pieces: &[Piece],
    order: MergeOrder,
    witnesses: &mut Vec<DVec3>,
) -> Vec<Proved> {
    let epsilon = judge.epsilon;
    let mut slots: Vec<Option<Proved>> = parts.into_iter().map(Some).collect();
    let mut volumes: Vec<f64> = slots.iter().flatten().map(|p| volume(&p.hull)).collect();
    let mut boxes: Vec<(DVec3, DVec3)> = slots.iter().flatten().map(|p| bounds(&p.hull)).collect();
    let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    let candidate = |i: usize,
                     j: usize,
                     slots: &[Option<Proved>],
                     volumes: &[f64],
                     boxes: &[(DVec3, DVec3)],
                     witnesses: &[DVec3],
                     queue: &mut BinaryHeap<Reverse<(u64, u32, u32)>>| {
        let (Some(a), Some(b)) = (&slots[i], &slots[j]) else {
            return;
        };
        let gap = (boxes[i].0 - boxes[j].1)
            .max(boxes[j].0 - boxes[i].1)
            .max(DVec3::ZERO);
        if gap.length() > 2.0 * epsilon {
            return;
        }
        let Some(hull) = joined(&a.hull, &b.hull) else {
            return;
        };
        if holds_any(&hull, witnesses) {
            return;
        }
        let added = (volume(&hull) - volumes[i] - volumes[j]).max(0.0);
        let key = match order {
            MergeOrder::Added => added,
            MergeOrder::Relative => added / (volumes[i] + volumes[j]),
            MergeOrder::Smallest => added + volumes[i].min(volumes[j]),
        };
        queue.push(Reverse((key.to_bits(), i as u32, j as u32)));
    };
    for i in 0..slots.len() {
        for j in i + 1..slots.len() {
            candidate(i, j, &slots, &volumes, &boxes, witnesses, &mut queue);
        }
    }
    while let Some(Reverse((_, i, j))) = queue.pop() {
        if (judge.limits.cancelled)() {
            break;
        }
        let (i, j) = (i as usize, j as usize);
        let (Some(a), Some(b)) = (&slots[i], &slots[j]) else {
            continue;
        };
        let Some(hull) = joined(&a.hull, &b.hull) else {
            continue;
        };
        if holds_any(&hull, witnesses) {
            continue;
        }
        let mut members: Vec<u32> = a.members.iter().chain(&b.members).copied().collect();
        members.sort_unstable();
        let own: Vec<&Piece> = members.iter().map(|&m| &pieces[m as usize]).collect();
        match judge.decide(&hull, &own) {
            Decision::Within(thickening) => {
                slots[i] = None;
                slots[j] = None;
                volumes.push(volume(&hull));
                boxes.push(bounds(&hull));
                slots.push(Some(Proved {
                    hull,
                    thickening,
                    members,
                }));
                let new = slots.len() - 1;
                for other in 0..new {
                    candidate(other, new, &slots, &volumes, &boxes, witnesses, &mut queue);
                }
            }
            Decision::Beyond { witness, .. } if judge.metric == Metric::Thickening => {
                witnesses.push(witness);
            }
            Decision::Beyond { .. } | Decision::Unproven(_) => {}
        }
    }
    slots.into_iter().flatten().collect()
}

fn joined(a: &Mesh, b: &Mesh) -> Option<Mesh> {
    let points: Vec<DVec3> = a.vertices.iter().chain(&b.vertices).copied().collect();
    convex_hull(&points).ok()
}

fn holds_any(hull: &Mesh, witnesses: &[DVec3]) -> bool {
    let (lo, hi) = bounds(hull);
    let planes = half_spaces(hull);
    witnesses.iter().any(|w| {
        w.cmpge(lo).all() && w.cmple(hi).all() && planes.iter().all(|(n, o)| n.dot(*w) < *o)
    })
}

//! Approximate convex decomposition (Lien & Amato 2006, Algorithm 4.1).
//!
//! The recursion is run as one queue over all pockets of all parts, most
//! concave first; since parts do not influence one another, each part meets
//! its cuts in the order of the recursion. A cut changes the hull and the
//! pockets of its two parts only where it touches them, so only those are
//! measured again: the paper's O(n) per cut is the worst case here, not the rule.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::arrangement::{arrange, handle, Arrangement};
use crate::boundary::{Boundary, Diagonal};
use crate::concavity::{measure_pocket, scattered, Loops, Measure, Witness};
use crate::hierarchy::{Cut, Hierarchy, Start};
use crate::holes::{self, Hole, HoleAxis, OUTER};
use crate::hull::{mark_chain, mark_ring};
use crate::resolve::{self, DiagonalWeights};
use crate::{OutlineError, Point};

/// What to decompose into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// τ: the largest concavity a part may keep, in the outline's unit; 0
    /// gives an exact convex decomposition.
    pub tolerance: f64,
    /// How concavity is measured.
    pub measure: Measure,
    /// How the antipodal pairs of holes are found.
    pub hole_axis: HoleAxis,
    /// Weights of Eq. 8.
    pub weights: DiagonalWeights,
}

/// Decomposes the even-odd interior of `rings` into parts of concavity at
/// most τ, by diagonals between input vertices only.
///
/// # Errors
/// [`OutlineError`] when edges cross, coordinates are unusable, nothing is
/// enclosed or a parameter is out of range.
pub fn decompose(rings: &[Vec<Point>], parameters: &Parameters) -> Result<Hierarchy, OutlineError> {
    let wanted = |name, wanted, got: f64, good: bool| {
        if good {
            Ok(())
        } else {
            Err(OutlineError::Parameter { name, wanted, got })
        }
    };
    let Parameters {
        tolerance, weights, ..
    } = *parameters;
    wanted("tolerance", "a number >= 0", tolerance, tolerance >= 0.0)?;
    let (s_c, s_d) = (weights.concavity, weights.distance);
    wanted("s_c", "finite and >= 0", s_c, s_c >= 0.0 && s_c.is_finite())?;
    wanted("s_d", "finite and > 0", s_d, s_d > 0.0 && s_d.is_finite())?;

    let mut arrangement = arrange(rings)?;
    let components = std::mem::take(&mut arrangement.components);
    let mut boundary = Boundary::new(arrangement.points.clone());
    let mut outers = Vec::new();
    let mut holes = Vec::new();
    for component in &components {
        outers.push(boundary.add_ring(&component.outer));
        holes.push(
            component
                .holes
                .iter()
                .map(|ring| boundary.add_ring(ring))
                .collect::<Vec<_>>(),
        );
    }
    boundary.sort_corners();
    let mut engine = Engine::new(arrangement, boundary, *parameters);
    let mut starts = Vec::new();
    for (outer, holes) in outers.iter().zip(&holes) {
        engine.measure_ring(*outer);
        let left = engine.merge_holes(holes);
        engine.cut_notches();
        starts.push(Start {
            outer: *outer,
            holes: holes.clone(),
            concavity: left,
        });
    }
    Ok(engine.finish(&starts))
}

/// A pocket in the queue; stale once its bridge or witness has changed.
#[derive(Clone, Copy, PartialEq)]
struct Entry {
    witness: Witness,
    vertex: u32,
    start: u32,
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.witness.value.total_cmp(&other.witness.value))
            .then(scattered(other.vertex).cmp(&scattered(self.vertex)))
            .then(other.start.cmp(&self.start))
            .then(other.witness.corner.cmp(&self.witness.corner))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

struct Engine {
    parameters: Parameters,
    arrangement: Arrangement,
    boundary: Boundary,
    on_hull: Vec<bool>,
    concavity: Vec<f64>,
    /// Per hull corner, the witness of the pocket that begins there.
    pocket: Vec<Option<Witness>>,
    queue: BinaryHeap<Entry>,
    loops: Loops,
    cuts: Vec<Cut>,
}

impl Engine {
    fn new(arrangement: Arrangement, boundary: Boundary, parameters: Parameters) -> Self {
        let corners = boundary.vertex.len();
        Self {
            parameters,
            loops: Loops::new(boundary.points.len()),
            arrangement,
            boundary,
            on_hull: vec![false; corners],
            concavity: vec![0.0; corners],
            pocket: vec![None; corners],
            queue: BinaryHeap::new(),
            cuts: Vec::new(),
        }
    }

    /// Measures every pocket of the ring of `start` from scratch.
    fn measure_ring(&mut self, start: u32) {
        let ring = self.boundary.ring(start);
        let mut ring = mark_ring(&self.boundary, ring, &mut self.on_hull);
        ring.push(ring[0]);
        self.measure_pockets(&ring);
    }

    /// Measures the pockets of a chain from hull corner to hull corner.
    fn measure_pockets(&mut self, chain: &[u32]) {
        let mut start = 0;
        for end in 1..chain.len() {
            if !self.on_hull[chain[end] as usize] {
                continue;
            }
            let corner = chain[start];
            let found = if end > start + 1 {
                measure_pocket(
                    self.parameters.measure,
                    self.parameters.tolerance,
                    &self.boundary,
                    &chain[start..=end],
                    &mut self.loops,
                    &mut self.concavity,
                )
            } else {
                None
            };
            self.pocket[corner as usize] = found;
            self.concavity[corner as usize] = 0.0;
            self.concavity[chain[end] as usize] = 0.0;
            if let Some(witness) = found {
                let vertex = self.boundary.vertex[witness.corner as usize];
                self.queue.push(Entry {
                    witness,
                    vertex,
                    start: corner,
                });
            }
            start = end;
        }
    }

    /// The most concave pocket left.
    fn most_concave(&mut self) -> Option<Witness> {
        while let Some(entry) = self.queue.peek() {
            let start = entry.start as usize;
            if self.on_hull[start] && self.pocket[start] == Some(entry.witness) {
                return Some(entry.witness);
            }
            self.queue.pop();
        }
        None
    }

    fn link(&mut self, r: u32, x: u32) -> Diagonal {
        let [u, v] = [r, x].map(|c| handle(self.boundary.vertex[c as usize]));
        self.arrangement.cdt.add_constraint(u, v);
        let diagonal = self.boundary.link(r, x);
        for old in [r, x] {
            self.on_hull.push(self.on_hull[old as usize]);
            self.concavity.push(self.concavity[old as usize]);
            self.pocket.push(None);
        }
        // what follows the far end's hull corner now begins at its twin
        if let Some(witness) = self.pocket[x as usize].filter(|_| self.on_hull[x as usize]) {
            let new_x = diagonal.new_x;
            self.pocket[new_x as usize] = Some(witness);
            let vertex = self.boundary.vertex[witness.corner as usize];
            self.queue.push(Entry {
                witness,
                vertex,
                start: new_x,
            });
        }
        diagonal
    }

    /// Merges holes into the outer boundary, in the order of Eq. 5, while the
    /// polygon is more concave than τ. Returns the concavity of what is left.
    fn merge_holes(&mut self, starts: &[u32]) -> f64 {
        let rings: Vec<_> = starts.iter().map(|&s| self.boundary.ring(s)).collect();
        let axis = self.parameters.hole_axis;
        let holes = holes::tie(&self.arrangement, &self.boundary, rings, axis);
        let mut merged = vec![false; holes.len()];
        let mut ring_of: Vec<u32> = vec![OUTER; self.boundary.vertex.len()];
        for (h, hole) in holes.iter().enumerate() {
            for &corner in &hole.ring {
                ring_of[corner as usize] = h as u32 + 1;
            }
        }
        let mut left = holes.len();
        while left > 0 {
            let outer = self.most_concave().map_or(0.0, |w| w.value);
            let values = self.hole_concavities(&holes, &merged, outer);
            let Some(mut h) = (0..holes.len())
                .filter(|&h| !merged[h])
                .max_by(|&a, &b| values[a].total_cmp(&values[b]).then(b.cmp(&a)))
            else {
                break;
            };
            let value = values[h].max(outer);
            if value <= self.parameters.tolerance {
                return value;
            }
            while holes[h].parent != OUTER && !merged[holes[h].parent as usize - 1] {
                h = holes[h].parent as usize - 1;
            }
            // corners get a new twin at each diagonal, so the planned one may face elsewhere
            let reaches_outer = |c: u32| {
                ring_of
                    .get(c as usize)
                    .is_none_or(|&r| r == OUTER || merged[r as usize - 1])
            };
            let Some((h, r, x)) = self.free_diagonal(h, &holes, &merged, reaches_outer) else {
                debug_assert!(
                    false,
                    "some hole sees the outer boundary: the interior is connected"
                );
                return value;
            };
            let diagonal = self.link(r, x);
            merged[h] = true;
            left -= 1;
            self.measure_merged(&diagonal);
            self.cuts.push(Cut {
                diagonal,
                concavity: value,
                joins: true,
            });
        }
        0.0
    }

    /// The planned diagonal of hole `h`, or the nearest one that is free of it
    /// or of another hole if a diagonal laid meanwhile is in the way.
    fn free_diagonal(
        &self,
        h: usize,
        holes: &[Hole],
        merged: &[bool],
        wanted: impl Fn(u32) -> bool,
    ) -> Option<(usize, u32, u32)> {
        let (from, to) = (holes[h].from, holes[h].to);
        let [eye, vertex] = [self.boundary.point(from), self.boundary.point(to)];
        let to = self
            .boundary
            .facing(self.boundary.vertex[to as usize], eye)
            .unwrap_or(to);
        let from = self
            .boundary
            .facing(self.boundary.vertex[from as usize], vertex)
            .unwrap_or(from);
        if holes::is_free(&self.arrangement, &self.boundary, from, to) {
            return Some((h, from, to));
        }
        std::iter::once(h)
            .chain((0..holes.len()).filter(|&k| k != h && !merged[k]))
            .find_map(|k| {
                let ring = &holes[k].ring;
                holes::detour(&self.arrangement, &self.boundary, ring, &wanted)
                    .map(|(r, x)| (k, r, x))
            })
    }

    /// Eq. 5 for every hole; δ is the concavity of the outer boundary.
    fn hole_concavities(&self, holes: &[Hole], merged: &[bool], outer: f64) -> Vec<f64> {
        let mut depth: Vec<Option<f64>> = vec![None; holes.len()];
        let mut path = Vec::new();
        for h in 0..holes.len() {
            let mut k = h;
            let mut base = loop {
                if let Some(known) = depth[k] {
                    break known;
                }
                path.push(k);
                let parent = holes[k].parent;
                if parent == OUTER || merged[parent as usize - 1] {
                    break self.concavity[holes[k].to as usize];
                }
                k = parent as usize - 1;
            };
            while let Some(k) = path.pop() {
                // concave(x) of a hole's vertex is the hole's own concavity
                base += holes[k].extent + outer;
                depth[k] = Some(base);
            }
        }
        depth.into_iter().map(|d| d.unwrap_or(0.0)).collect()
    }

    /// After a merge the hull is as before; the pocket at `x` has grown, or a
    /// new one without a bridge has opened at the hull corner `x`.
    fn measure_merged(&mut self, diagonal: &Diagonal) {
        let Diagonal { x, new_x, .. } = *diagonal;
        let chain = self.chain_between(self.hull_before(x), new_x);
        self.measure_pockets(&chain);
    }

    fn hull_before(&self, mut corner: u32) -> u32 {
        while !self.on_hull[corner as usize] {
            corner = self.boundary.previous(corner);
        }
        corner
    }

    /// Corners from `start` to the first hull corner at or after `through`.
    fn chain_between(&self, start: u32, through: u32) -> Vec<u32> {
        let mut chain = vec![start];
        let mut corner = start;
        let mut passed = start == through;
        while !(passed && self.on_hull[corner as usize] && chain.len() > 1) {
            corner = self.boundary.next(corner);
            chain.push(corner);
            passed |= corner == through;
        }
        chain
    }

    /// Algorithm 4.1 on the outer boundary.
    fn cut_notches(&mut self) {
        while let Some(worst) = self.most_concave() {
            if worst.value <= self.parameters.tolerance {
                return;
            }
            let found = resolve::diagonal(
                &self.arrangement.cdt,
                &self.boundary,
                worst.corner,
                &self.concavity,
                worst.value,
                self.parameters.weights,
            );
            let Some(x) = found else {
                debug_assert!(false, "a notch sees at least one corner");
                return;
            };
            let diagonal = self.link(worst.corner, x);
            self.measure_cut(diagonal.x, diagonal.r);
            self.measure_cut(diagonal.new_r, diagonal.new_x);
            self.cuts.push(Cut {
                diagonal,
                concavity: worst.value,
                joins: false,
            });
        }
    }

    /// Measures anew what the new edge `tail → head` changed in its part:
    /// the chain between the hull corners on either side. All other hull
    /// corners stay hull corners, and their pockets stay as they are.
    fn measure_cut(&mut self, tail: u32, head: u32) {
        let mut after = head;
        while !self.on_hull[after as usize] && after != tail {
            after = self.boundary.next(after);
        }
        if !self.on_hull[after as usize] {
            self.measure_ring(head);
            return;
        }
        let before = self.hull_before(tail);
        if before == after || self.boundary.point(before) == self.boundary.point(after) {
            self.measure_ring(head);
            return;
        }
        let mut chain = vec![before];
        let mut corner = before;
        while corner != after {
            corner = self.boundary.next(corner);
            chain.push(corner);
        }
        mark_chain(&self.boundary, &chain, &mut self.on_hull);
        self.measure_pockets(&chain);
    }

    fn finish(self, starts: &[Start]) -> Hierarchy {
        let largest = |start: u32| {
            let ring = self.boundary.ring(start);
            ring.iter()
                .filter(|&&c| self.on_hull[c as usize])
                .filter_map(|&c| self.pocket[c as usize])
                .fold(0.0_f64, |worst, w| worst.max(w.value))
        };
        Hierarchy::new(
            &self.boundary,
            self.cuts.clone(),
            starts,
            largest,
            self.parameters.tolerance,
        )
    }
}

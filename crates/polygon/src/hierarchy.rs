//! The tree of decompositions (Lien & Amato 2006, §1 and Fig. 2b): one run at
//! the finest tolerance holds every coarser one.

use crate::arrangement::bounds_outside;
use crate::boundary::{Boundary, Diagonal};
use crate::concavity::Loops;
use crate::point::{convex_hull, signed_area};
use crate::Point;

/// A diagonal, and the concavity of the part that it was laid in.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    pub diagonal: Diagonal,
    pub concavity: f64,
    /// Whether it merges a hole instead of splitting the part.
    pub joins: bool,
}

/// Where a component began.
pub(crate) struct Start {
    /// A corner of the outer boundary.
    pub outer: u32,
    /// A corner of each hole.
    pub holes: Vec<u32>,
    /// Concavity by the holes that were left in, 0 if none were.
    pub concavity: f64,
}

/// A polygon of a decomposition.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Outer boundary, counter-clockwise, without repetition of the first point.
    pub outer: Vec<Point>,
    /// Boundaries of holes that the tolerance leaves in, clockwise.
    pub holes: Vec<Vec<Point>>,
    /// Concavity by the measure that was asked for.
    pub concavity: f64,
}

impl Part {
    /// Its area.
    pub fn area(&self) -> f64 {
        self.holes
            .iter()
            .fold(signed_area(&self.outer), |sum, hole| {
                sum + signed_area(hole)
            })
    }
}

/// One state of one part in the recursion.
#[derive(Clone, Debug)]
struct Node {
    concavity: f64,
    /// The cut that ends this state, and what it leaves.
    cut: Option<(u32, Vec<u32>)>,
    parent: Option<u32>,
    /// A corner on the outer boundary.
    corner: u32,
    /// A corner of each hole that stays unmerged below.
    holes: Vec<u32>,
}

/// A decomposition with all its coarser levels.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    boundary: Boundary,
    cuts: Vec<Cut>,
    nodes: Vec<Node>,
    roots: Vec<u32>,
    tolerance: f64,
}

impl Hierarchy {
    /// Builds the tree backwards from the final rings; `largest` is the
    /// concavity of a final part by one of its corners.
    pub(crate) fn new(
        boundary: &Boundary,
        cuts: Vec<Cut>,
        starts: &[Start],
        largest: impl Fn(u32) -> f64,
        tolerance: f64,
    ) -> Self {
        const UNKNOWN: u32 = u32::MAX;
        let mut nodes = Vec::new();
        let mut ring_of = vec![UNKNOWN; boundary.vertex.len()];
        let mut leaf = |corner: u32, nodes: &mut Vec<Node>| {
            if ring_of[corner as usize] == UNKNOWN {
                for c in boundary.ring(corner) {
                    ring_of[c as usize] = nodes.len() as u32;
                }
                let concavity = largest(corner);
                nodes.push(Node {
                    concavity,
                    cut: None,
                    parent: None,
                    corner,
                    holes: Vec::new(),
                });
            }
            ring_of[corner as usize]
        };
        let outers: Vec<u32> = starts.iter().map(|s| leaf(s.outer, &mut nodes)).collect();
        let ends: Vec<[u32; 2]> = cuts
            .iter()
            .map(|cut| [cut.diagonal.r, cut.diagonal.new_r].map(|c| leaf(c, &mut nodes)))
            .collect();
        for (start, &outer) in starts.iter().zip(&outers) {
            let node: &mut Node = &mut nodes[outer as usize];
            let unmerged = |&hole: &u32| ring_of[hole as usize] == UNKNOWN;
            node.holes
                .extend(start.holes.iter().copied().filter(unmerged));
            node.concavity = node.concavity.max(start.concavity);
        }
        let mut top: Vec<u32> = (0..nodes.len() as u32).collect();
        for (k, (cut, ends)) in cuts.iter().zip(&ends).enumerate().rev() {
            let mut children = ends.map(|leaf| find(&mut top, leaf)).to_vec();
            children.dedup();
            let number = nodes.len() as u32;
            for &child in &children {
                nodes[child as usize].parent = Some(number);
                top[child as usize] = number;
            }
            top.push(number);
            nodes.push(Node {
                concavity: cut.concavity,
                cut: Some((k as u32, children)),
                parent: None,
                // alive once the diagonal is taken back, and never on the hole that it merges
                corner: cut.diagonal.x,
                holes: Vec::new(),
            });
        }
        let roots = outers
            .into_iter()
            .map(|outer| find(&mut top, outer))
            .collect();
        Self {
            boundary: boundary.clone(),
            cuts,
            nodes,
            roots,
            tolerance,
        }
    }

    /// The tolerance it was computed for: no finer level exists.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Per part that a diagonal split off, its concavity and that of the part
    /// before: what Lemma 5.3 is about. (Merging a hole is no such step: it
    /// adds the hole's depth to the outer boundary.)
    pub fn descents(&self) -> Vec<(f64, f64)> {
        self.nodes
            .iter()
            .filter_map(|node| {
                let parent = &self.nodes[node.parent? as usize];
                let (_, children) = parent.cut.as_ref()?;
                (children.len() == 2).then_some((node.concavity, parent.concavity))
            })
            .collect()
    }

    /// The decomposition at `tolerance`: the first states, from the root down,
    /// whose concavity is within it.
    pub fn at(&self, tolerance: f64) -> Vec<Part> {
        let mut accepted = Vec::new();
        let mut stack: Vec<u32> = self.roots.iter().rev().copied().collect();
        while let Some(k) = stack.pop() {
            let node = &self.nodes[k as usize];
            match &node.cut {
                Some((_, children)) if node.concavity > tolerance => {
                    stack.extend(children.iter().rev());
                }
                _ => accepted.push(k),
            }
        }
        let mut undone = Vec::new();
        let holes: Vec<Vec<u32>> = accepted
            .iter()
            .map(|&top| {
                let mut holes = Vec::new();
                let mut below = vec![top];
                while let Some(k) = below.pop() {
                    let node = &self.nodes[k as usize];
                    holes.extend(&node.holes);
                    if let Some((cut, children)) = &node.cut {
                        undone.push(*cut);
                        if self.cuts[*cut as usize].joins {
                            holes.push(self.cuts[*cut as usize].diagonal.r);
                        }
                        below.extend(children);
                    }
                }
                holes
            })
            .collect();
        undone.sort_unstable();
        let mut boundary = self.boundary.clone();
        for &cut in undone.iter().rev() {
            boundary.unlink(&self.cuts[cut as usize].diagonal);
        }
        let mut loops = Loops::new(boundary.points.len());
        accepted
            .iter()
            .zip(holes)
            .map(|(&k, holes)| {
                let node = &self.nodes[k as usize];
                part(&boundary, &mut loops, node, &holes)
            })
            .collect()
    }

    /// Eq. 9: the parts' area over the area of their convex hulls.
    pub fn convexity(parts: &[Part]) -> f64 {
        let own: f64 = parts.iter().map(Part::area).sum();
        let hulls: f64 = parts
            .iter()
            .map(|part| signed_area(&convex_hull(&part.outer)))
            .sum();
        if hulls > 0.0 {
            own / hulls
        } else {
            1.0
        }
    }
}

fn find(top: &mut [u32], mut k: u32) -> u32 {
    while top[k as usize] != k {
        top[k as usize] = top[top[k as usize] as usize];
        k = top[k as usize];
    }
    k
}

/// Turns boundary walks into simple rings: slits cancel, what hangs together
/// at a vertex falls apart into an outer ring and holes.
fn part(boundary: &Boundary, loops: &mut Loops, node: &Node, holes: &[u32]) -> Part {
    let mut rings = Vec::new();
    for &start in std::iter::once(&node.corner).chain(holes) {
        let walk = boundary.ring(start);
        let vertices: Vec<u32> = walk.iter().map(|&c| boundary.vertex[c as usize]).collect();
        let (path, found, _) = loops.split(&vertices);
        let closed = found.iter().map(|l| {
            std::iter::once(l.root)
                .chain(l.inner.iter().copied())
                .collect()
        });
        for ring in std::iter::once(path).chain(closed) {
            if ring.len() > 2 {
                rings.push(ring.iter().map(|&k| vertices[k]).collect::<Vec<u32>>());
            }
        }
    }
    let points = |ring: &[u32]| {
        ring.iter()
            .map(|&v| boundary.points[v as usize])
            .collect::<Vec<_>>()
    };
    let mut outer = Vec::new();
    let mut inner = Vec::new();
    for ring in &rings {
        if bounds_outside(&boundary.points, ring) {
            outer = points(ring);
        } else {
            inner.push(points(ring));
        }
    }
    Part {
        outer,
        holes: inner,
        concavity: node.concavity,
    }
}

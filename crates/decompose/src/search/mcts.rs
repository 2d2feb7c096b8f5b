//! Monte Carlo tree search: Algorithm 2 of Wei et al. 2022, priced without cutting.
//!
//! A node is the set of components after some cuts; its children are the cuts of its worst
//! component. The concavity of a component is the radius of its cost (Eq. 5, over the volume
//! that [`Value`] counts). Where the paper cuts meshes for every trial, a sweep prices all
//! planes of a component at once; a component is cut only when it is looked into, and the
//! default policy's cut of a component is remembered with it.

use super::policy::{Choice, Policy, Question};
use super::price::{choice, empty, finer, halves, price, price_all, spacing, Half};
use super::sweep::Sweep;
use super::value::Value;

/// The policy.
pub struct TreeSearch;

impl Policy for TreeSearch {
    fn choose(&self, question: &Question<'_>) -> Option<Choice> {
        Search::new(question).run()
    }
}

/// Uniform random numbers: `SplitMix64` (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^= x >> 31;
        ((u128::from(x) * count as u128) >> 64) as usize
    }
}

/// A plane of a direction.
#[derive(Clone, Copy)]
struct Cut {
    direction: usize,
    offset: f64,
}

/// A component: its concavity and, unless no cut of it can follow, its geometry.
#[derive(Clone, Copy)]
struct Component {
    concavity: f64,
    body: Option<usize>,
}

/// Geometry of a component, shared by all nodes that have it.
struct Body {
    half: Half,
    /// All candidate cuts, once it is to be cut in the tree.
    sweeps: Option<Vec<Sweep>>,
    middle: Middle,
}

/// The default policy's cut of a component.
#[derive(Clone, Copy)]
enum Middle {
    Unasked,
    Impossible,
    Found(Cut, [Component; 2]),
}

/// The components after some cuts, with what Eq. 9 has added up on the way.
#[derive(Clone)]
struct State {
    components: Vec<Component>,
    cuts: Vec<Cut>,
    sum: f64,
}

impl State {
    fn worst(&self) -> usize {
        let worse = |a: usize, b: usize| {
            if self.components[b].concavity > self.components[a].concavity {
                b
            } else {
                a
            }
        };
        (0..self.components.len()).reduce(worse).unwrap_or(0)
    }

    /// After the worst component was cut.
    fn after(&self, cut: Cut, halves: [Component; 2]) -> State {
        let mut next = self.clone();
        next.components.swap_remove(self.worst());
        next.components.extend(halves);
        next.cuts.push(cut);
        next.sum -= next.components[next.worst()].concavity;
        next
    }
}

struct Node {
    parent: usize,
    children: Vec<usize>,
    /// Cuts (direction, trial) of the worst component that have no child yet; `None` until
    /// they are asked for.
    untried: Option<Vec<(usize, usize)>>,
    state: State,
    /// N of Eq. 8.
    visits: f64,
    /// Q of Eq. 8.
    quality: f64,
    /// The cuts that reached it.
    path: Vec<Cut>,
}

struct Search<'a> {
    q: &'a Question<'a>,
    value: Value,
    depth: usize,
    bodies: Vec<Body>,
    nodes: Vec<Node>,
    random: Random,
    /// c of Eq. 8.
    exploration: f64,
}

const ROOT: usize = 0;

impl<'a> Search<'a> {
    fn new(q: &'a Question<'a>) -> Self {
        let half = Half {
            piece: q.piece.clone(),
            forbidden: q.forbidden.to_vec(),
        };
        let mut search = Search {
            q,
            value: Value::radius(q.settings, q.epsilon),
            depth: q.settings.depth.max(1),
            bodies: Vec::new(),
            nodes: Vec::new(),
            random: Random(q.settings.seed ^ q.key),
            exploration: 0.0,
        };
        let body = search.add(half);
        let whole = search.concavity_of_root();
        search.exploration = q.settings.exploration * whole / search.depth as f64;
        let state = State {
            components: vec![Component {
                concavity: whole,
                body: Some(body),
            }],
            cuts: Vec::new(),
            sum: 0.0,
        };
        search.grow(ROOT, state);
        search
    }

    fn add(&mut self, half: Half) -> usize {
        self.bodies.push(Body {
            half,
            sweeps: None,
            middle: Middle::Unasked,
        });
        self.bodies.len() - 1
    }

    fn grow(&mut self, parent: usize, state: State) -> usize {
        let new = self.nodes.len();
        self.nodes.push(Node {
            parent,
            children: Vec::new(),
            untried: None,
            state,
            visits: 0.0,
            quality: f64::NEG_INFINITY,
            path: Vec::new(),
        });
        if new != ROOT {
            self.nodes[parent].children.push(new);
        }
        new
    }

    /// Of the whole part: a plane beyond it has all of it below.
    fn concavity_of_root(&self) -> f64 {
        let (q, basis) = (self.q, &self.q.directions[0]);
        let (lo, hi) = super::price::extent(&q.piece.points, basis.w);
        let edges: Vec<(u32, u32)> = q.piece.edges().collect();
        let beyond = [hi + (hi - lo)];
        let sweep = price(q, q.piece, &edges, basis, &beyond, q.forbidden);
        self.value.cost(&sweep.trials[0].below)
    }

    fn run(mut self) -> Option<Choice> {
        for _ in 0..self.q.settings.iterations {
            let leaf = self.select();
            let end = self.play(self.nodes[leaf].state.clone());
            // Eq. 9. Cuts that are not made because nothing is left to cut add nothing.
            let quality = end.sum / self.depth as f64;
            self.back_up(leaf, quality, &end.cuts);
        }
        let children = &self.nodes[ROOT].children;
        let better = |a: usize, b: usize| {
            if self.nodes[b].quality > self.nodes[a].quality {
                b
            } else {
                a
            }
        };
        let best = children.iter().copied().reduce(better)?;
        let (quality, path) = (self.nodes[best].quality, self.nodes[best].path.clone());
        Some(self.refine(quality, &path))
    }

    /// Function `TreePolicy`: down to a node with an untried cut, which becomes a child.
    fn select(&mut self) -> usize {
        let mut node = ROOT;
        while self.nodes[node].state.cuts.len() < self.depth {
            let state = &self.nodes[node].state;
            let Some(body) = state.components[state.worst()].body else {
                return node;
            };
            if self.nodes[node].untried.is_none() {
                self.nodes[node].untried = Some(self.candidates(body));
            }
            let untried = self.nodes[node].untried.as_mut();
            if let Some(untried) = untried.filter(|u| !u.is_empty()) {
                let (direction, trial) = untried.swap_remove(self.random.below(untried.len()));
                let cuts = self.nodes[node].state.cuts.len() + 1;
                let (cut, halves) = self.cut(body, direction, trial, cuts < self.depth);
                let next = self.nodes[node].state.after(cut, halves);
                return self.grow(node, next);
            }
            // Eq. 8.
            let parent = libm::log(self.nodes[node].visits.max(1.0));
            let ucb = |n: usize| {
                let child = &self.nodes[n];
                child.quality + self.exploration * (2.0 * parent / child.visits).sqrt()
            };
            let children = self.nodes[node].children.iter().copied();
            match children.reduce(|a, b| if ucb(b) > ucb(a) { b } else { a }) {
                Some(best) => node = best,
                None => return node,
            }
        }
        node
    }

    /// All cuts of a body that leave something on both sides.
    fn candidates(&mut self, body: usize) -> Vec<(usize, usize)> {
        let q = self.q;
        let half = &self.bodies[body].half;
        let extra = if body == 0 { q.extra } else { q.extra_second };
        let sweeps = price_all(q, &half.piece, &half.forbidden, q.settings.planes, extra);
        let candidates = sweeps
            .iter()
            .enumerate()
            .flat_map(|(d, s)| (0..s.trials.len()).map(move |t| (d, t)))
            .filter(|&(d, t)| {
                let trial = &sweeps[d].trials[t];
                !empty(&trial.below) && !empty(&trial.above)
            })
            .collect();
        self.bodies[body].sweeps = Some(sweeps);
        candidates
    }

    /// Cut a body by one of its candidates; with geometry if more cuts may follow.
    fn cut(
        &mut self,
        body: usize,
        direction: usize,
        trial: usize,
        geometry: bool,
    ) -> (Cut, [Component; 2]) {
        let sweeps = self.bodies[body].sweeps.take().unwrap_or_default();
        let made = self.divide(body, direction, &sweeps[direction], trial, geometry);
        self.bodies[body].sweeps = Some(sweeps);
        made
    }

    fn divide(
        &mut self,
        body: usize,
        direction: usize,
        sweep: &Sweep,
        trial: usize,
        geometry: bool,
    ) -> (Cut, [Component; 2]) {
        let t = &sweep.trials[trial];
        let (below, above) = (self.value.cost(&t.below), self.value.cost(&t.above));
        let bodies = geometry.then(|| {
            let half = &self.bodies[body].half;
            let basis = &self.q.directions[direction];
            let (b, a) = halves(&half.piece, &half.forbidden, basis, sweep, trial);
            (self.add(b), self.add(a))
        });
        let component = |concavity, body| Component { concavity, body };
        let cut = Cut {
            direction,
            offset: t.offset,
        };
        (
            cut,
            [
                component(below, bodies.map(|b| b.0)),
                component(above, bodies.map(|b| b.1)),
            ],
        )
    }

    /// Function `DefaultPolicy`: the worst component is cut in the middle, in the direction
    /// that leaves the least concavity (Eq. 7), until there are d + 1 components.
    fn play(&mut self, mut state: State) -> State {
        while state.cuts.len() < self.depth {
            let Some(body) = state.components[state.worst()].body else {
                break;
            };
            let more = state.cuts.len() + 1 < self.depth;
            let Some((cut, halves)) = self.middle(body, more) else {
                break;
            };
            state = state.after(cut, halves);
        }
        // A component that cannot be cut stays what it is for the rest of the cuts.
        let missing = (self.depth - state.cuts.len()) as f64;
        state.sum -= missing * state.components[state.worst()].concavity;
        state
    }

    fn middle(&mut self, body: usize, geometry: bool) -> Option<(Cut, [Component; 2])> {
        match self.bodies[body].middle {
            Middle::Impossible => return None,
            Middle::Found(cut, halves) if halves[0].body.is_some() || !geometry => {
                return Some((cut, halves));
            }
            _ => {}
        }
        let q = self.q;
        let half = &self.bodies[body].half;
        let edges: Vec<(u32, u32)> = half.piece.edges().collect();
        let mut best: Option<(f64, usize, Sweep)> = None;
        for direction in 0..q.gridded {
            let basis = &q.directions[direction];
            let (lo, hi) = super::price::extent(&half.piece.points, basis.w);
            let offset = [0.5 * (lo + hi)];
            let sweep = price(q, &half.piece, &edges, basis, &offset, &half.forbidden);
            let t = &sweep.trials[0];
            if empty(&t.below) || empty(&t.above) {
                continue;
            }
            let worst = self.value.cost(&t.below).max(self.value.cost(&t.above));
            if best.as_ref().is_none_or(|b| worst < b.0) {
                best = Some((worst, direction, sweep));
            }
        }
        let found =
            best.map(|(_, direction, sweep)| self.divide(body, direction, &sweep, 0, geometry));
        self.bodies[body].middle = found.map_or(Middle::Impossible, |(cut, halves)| {
            Middle::Found(cut, halves)
        });
        found
    }

    /// Function Backup, with the maximum.
    fn back_up(&mut self, leaf: usize, quality: f64, cuts: &[Cut]) {
        let mut at = leaf;
        loop {
            let node = &mut self.nodes[at];
            node.visits += 1.0;
            if quality > node.quality {
                node.quality = quality;
                node.path = cuts.to_vec();
            }
            if at == ROOT {
                return;
            }
            at = node.parent;
        }
    }

    /// §6.5: move the first plane within its spacing while the others and Eq. 9 stay. (Even
    /// steps instead of a ternary search: one sweep prices them all.)
    fn refine(&mut self, quality: f64, path: &[Cut]) -> Choice {
        let q = self.q;
        let (first, rest) = (path[0], &path[1..]);
        let sweeps = self.bodies[ROOT].sweeps.take().unwrap_or_default();
        let sweep = &sweeps[first.direction];
        let at = |t: &super::sweep::Trial| t.offset == first.offset;
        let trial = sweep.trials.iter().position(at).unwrap_or(0);
        let mut best = choice(first.direction, &sweep.trials[trial], -quality);
        let offsets = finer(q, &best, spacing(sweep, trial));
        if offsets.is_empty() {
            return best;
        }
        let edges: Vec<(u32, u32)> = q.piece.edges().collect();
        let basis = &q.directions[first.direction];
        let moved = price(q, q.piece, &edges, basis, &offsets, q.forbidden);
        let start = self.nodes[ROOT].state.clone();
        for (trial, t) in moved.trials.iter().enumerate() {
            if empty(&t.below) || empty(&t.above) {
                continue;
            }
            let (cut, parts) = self.divide(ROOT, first.direction, &moved, trial, !rest.is_empty());
            let mut state = start.after(cut, parts);
            for (i, cut) in rest.iter().enumerate() {
                let Some(body) = state.components[state.worst()].body else {
                    break;
                };
                let half = &self.bodies[body].half;
                let edges: Vec<(u32, u32)> = half.piece.edges().collect();
                let basis = &q.directions[cut.direction];
                let offset = [cut.offset];
                let one = price(q, &half.piece, &edges, basis, &offset, &half.forbidden);
                let more = i + 1 < rest.len();
                let (cut, parts) = self.divide(body, cut.direction, &one, 0, more);
                state = state.after(cut, parts);
            }
            let missing = (path.len() - state.cuts.len()) as f64;
            let sum = state.sum - missing * state.components[state.worst()].concavity;
            let worse = -sum / self.depth as f64;
            if worse < best.value {
                best = choice(first.direction, t, worse);
            }
        }
        best
    }
}

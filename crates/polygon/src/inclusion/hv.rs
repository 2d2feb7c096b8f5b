//! h-v convexity (§3): the largest set of pixels in a shape that meets every
//! row and every column in one run, put together from regions.

use super::discrete::Pixels;

/// The regions of a shape and what the paper's two graphs say about them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Regions {
    /// Per pixel its region, counted from 1; 0 is background.
    pub labels: Vec<u32>,
    /// Per pixel the number of runs in its row and column; 0 on background.
    pub weights: Vec<u32>,
    /// Pixels per region.
    pub areas: Vec<usize>,
    /// Adjacency graph: regions that share a pixel side.
    pub adjacent: Vec<Vec<bool>>,
    /// Incompatibility graph: regions with background between them in a row or column.
    pub incompatible: Vec<Vec<bool>>,
}

/// The best solution that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Solution {
    /// Its pixels.
    pub pixels: Pixels,
    /// Its regions, numbered from 0.
    pub regions: Vec<usize>,
    /// Whether the search was finished: then no union of regions is larger.
    pub optimal: bool,
}

/// Labels the regions of `shape` (Figs. 4–6).
///
/// A region is a maximal connected set of pixels of one weight. The paper
/// takes such a set to be h-v convex; it need not be (a U with a separate bar
/// at its base's height), so one that is not is labelled again as a shape of
/// its own until all are.
pub fn regions(shape: &Pixels) -> Regions {
    let weights = weights(shape);
    let mut labels = vec![0_u32; shape.inside.len()];
    let mut count = 0;
    let mut pending = vec![shape.clone()];
    while let Some(part) = pending.pop() {
        let weight = self::weights(&part);
        let before = count;
        let mut pieces = Vec::new();
        let mut seen = vec![false; part.inside.len()];
        for k in 0..part.inside.len() {
            if part.inside[k] && !seen[k] {
                pieces.push(flood(&part, &weight, k, &mut seen));
            }
        }
        let alone = pieces.len() == 1;
        for piece in pieces {
            if is_hv_convex(&piece) {
                count += 1;
                for (label, &inside) in labels.iter_mut().zip(&piece.inside) {
                    if inside {
                        *label = count;
                    }
                }
            } else if alone {
                // one weight throughout and still not convex: fall back to its rows' runs
                count = rows_apart(&piece, &mut labels, count);
            } else {
                pending.push(piece);
            }
        }
        debug_assert!(count >= before);
    }
    renumber(&mut labels);
    let n = count as usize;
    let mut areas = vec![0; n];
    for &label in labels.iter().filter(|&&l| l > 0) {
        areas[label as usize - 1] += 1;
    }
    let (adjacent, incompatible) = graphs(shape, &labels, n);
    Regions {
        labels,
        weights,
        areas,
        adjacent,
        incompatible,
    }
}

/// Labels in the order in which a reader meets them.
fn renumber(labels: &mut [u32]) {
    let mut new = std::collections::BTreeMap::new();
    for label in labels.iter_mut().filter(|l| **l > 0) {
        let next = new.len() as u32 + 1;
        *label = *new.entry(*label).or_insert(next);
    }
}

/// Calls `line` with the pixel indices of every row and then every column.
fn each_line(shape: &Pixels, mut line: impl FnMut(&[usize])) {
    let (w, h) = (shape.width, shape.height());
    for y in 0..h {
        line(&(0..w).map(|x| y * w + x).collect::<Vec<_>>());
    }
    for x in 0..w {
        line(&(0..h).map(|y| y * w + x).collect::<Vec<_>>());
    }
}

fn runs<'a>(shape: &'a Pixels, line: &'a [usize]) -> impl Iterator<Item = &'a [usize]> {
    line.chunk_by(|&a, &b| shape.inside[a] == shape.inside[b])
        .filter(|run| shape.inside[run[0]])
}

fn weights(shape: &Pixels) -> Vec<u32> {
    let mut weights = vec![0; shape.inside.len()];
    each_line(shape, |line| {
        let sections = runs(shape, line).count() as u32;
        for &k in line.iter().filter(|&&k| shape.inside[k]) {
            weights[k] += sections;
        }
    });
    weights
}

/// Whether every row and column of the shape has at most one run.
pub fn is_hv_convex(shape: &Pixels) -> bool {
    let mut convex = true;
    each_line(shape, |line| convex &= runs(shape, line).count() <= 1);
    convex
}

fn flood(part: &Pixels, weights: &[u32], seed: usize, seen: &mut [bool]) -> Pixels {
    let (w, h) = (part.width, part.height());
    let mut piece = Pixels {
        width: w,
        inside: vec![false; part.inside.len()],
    };
    let mut stack = vec![seed];
    seen[seed] = true;
    while let Some(k) = stack.pop() {
        piece.inside[k] = true;
        let (x, y) = (k % w, k / w);
        let sides = [
            (x > 0).then(|| k - 1),
            (x + 1 < w).then_some(k + 1),
            (y > 0).then(|| k - w),
            (y + 1 < h).then_some(k + w),
        ];
        for next in sides.into_iter().flatten() {
            if part.inside[next] && !seen[next] && weights[next] == weights[seed] {
                seen[next] = true;
                stack.push(next);
            }
        }
    }
    piece
}

fn rows_apart(piece: &Pixels, labels: &mut [u32], mut count: u32) -> u32 {
    for y in 0..piece.height() {
        let row: Vec<usize> = (0..piece.width).map(|x| y * piece.width + x).collect();
        for run in runs(piece, &row) {
            count += 1;
            for &k in run {
                labels[k] = count;
            }
        }
    }
    count
}

fn graphs(shape: &Pixels, labels: &[u32], n: usize) -> (Vec<Vec<bool>>, Vec<Vec<bool>>) {
    let mut adjacent = vec![vec![false; n]; n];
    let mut incompatible = vec![vec![false; n]; n];
    each_line(shape, |line| {
        let mut earlier: Vec<usize> = Vec::new();
        for run in runs(shape, line) {
            let mut here: Vec<usize> = run.iter().map(|&k| labels[k] as usize - 1).collect();
            here.dedup();
            for pair in here.windows(2) {
                adjacent[pair[0]][pair[1]] = true;
                adjacent[pair[1]][pair[0]] = true;
            }
            for &a in &here {
                for &b in earlier.iter().filter(|&&b| b != a) {
                    incompatible[a][b] = true;
                    incompatible[b][a] = true;
                }
            }
            earlier.extend(here);
        }
    });
    (adjacent, incompatible)
}

/// All maximal solutions of the two graphs, by the paper's backtracking: a
/// set grows by adjacent, compatible regions until none is left. Ascending,
/// without repetition. For graphs of few regions: the number is exponential.
pub fn maximal_sets(adjacent: &[Vec<bool>], incompatible: &[Vec<bool>]) -> Vec<Vec<usize>> {
    let n = adjacent.len();
    let mut seen = std::collections::BTreeSet::new();
    let mut found = std::collections::BTreeSet::new();
    let mut stack: Vec<Vec<usize>> = (0..n).map(|k| vec![k]).collect();
    while let Some(set) = stack.pop() {
        if !seen.insert(set.clone()) {
            continue;
        }
        let candidates = candidates(&set, adjacent, incompatible);
        if candidates.is_empty() {
            found.insert(set);
            continue;
        }
        for k in candidates {
            let mut larger = set.clone();
            larger.push(k);
            larger.sort_unstable();
            stack.push(larger);
        }
    }
    found.into_iter().collect()
}

fn candidates(set: &[usize], adjacent: &[Vec<bool>], incompatible: &[Vec<bool>]) -> Vec<usize> {
    (0..adjacent.len())
        .filter(|k| !set.contains(k))
        .filter(|&k| set.iter().any(|&s| adjacent[s][k]))
        .filter(|&k| !set.iter().any(|&s| incompatible[s][k]))
        .collect()
}

struct Search<'a> {
    shape: &'a Pixels,
    regions: &'a Regions,
    steps: usize,
    best: (usize, Vec<usize>),
}

/// The largest h-v convex union of connected regions, by backtracking with
/// the area still reachable as bound. `steps` bounds the search.
pub fn largest_hv_convex(shape: &Pixels, steps: usize) -> Solution {
    let regions = regions(shape);
    let n = regions.areas.len();
    let mut search = Search {
        shape,
        regions: &regions,
        steps,
        best: (0, Vec::new()),
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|&k| (std::cmp::Reverse(regions.areas[k]), k));
    let mut closed = vec![false; n];
    for k in order {
        // sets with an earlier initial region have all been seen
        search.grow(&mut vec![k], &closed);
        closed[k] = true;
    }
    let (steps, best) = (search.steps, search.best.1);
    Solution {
        pixels: union(shape, &regions, &best),
        regions: best,
        optimal: steps > 0,
    }
}

fn union(shape: &Pixels, regions: &Regions, set: &[usize]) -> Pixels {
    let inside = regions
        .labels
        .iter()
        .map(|&l| l > 0 && set.contains(&(l as usize - 1)))
        .collect();
    Pixels {
        width: shape.width,
        inside,
    }
}

impl Search<'_> {
    fn grow(&mut self, set: &mut Vec<usize>, closed: &[bool]) {
        if self.steps == 0 {
            return;
        }
        self.steps -= 1;
        let area: usize = set.iter().map(|&k| self.regions.areas[k]).sum();
        if area > self.best.0 && is_hv_convex(&union(self.shape, self.regions, set)) {
            let mut sorted = set.clone();
            sorted.sort_unstable();
            self.best = (area, sorted);
        }
        let mut closed = closed.to_vec();
        while area + self.reachable(set, &closed) > self.best.0 {
            let next = candidates(set, &self.regions.adjacent, &self.regions.incompatible)
                .into_iter()
                .filter(|&k| !closed[k])
                .max_by_key(|&k| (self.regions.areas[k], std::cmp::Reverse(k)));
            let Some(k) = next else {
                return;
            };
            set.push(k);
            self.grow(set, &closed);
            set.pop();
            closed[k] = true;
            if self.steps == 0 {
                return;
            }
        }
    }

    /// Area of all regions that might still join the set.
    fn reachable(&self, set: &[usize], closed: &[bool]) -> usize {
        let n = self.regions.areas.len();
        let open = |k: usize| {
            !closed[k] && !set.contains(&k) && !set.iter().any(|&s| self.regions.incompatible[s][k])
        };
        let mut joined = vec![false; n];
        let mut stack = set.to_vec();
        let mut area = 0;
        while let Some(a) = stack.pop() {
            for (b, joined) in joined.iter_mut().enumerate() {
                if self.regions.adjacent[a][b] && !*joined && open(b) {
                    *joined = true;
                    area += self.regions.areas[b];
                    stack.push(b);
                }
            }
        }
        area
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(edges: &[(char, char)]) -> Vec<Vec<bool>> {
        let mut matrix = vec![vec![false; 6]; 6];
        for &(a, b) in edges {
            let [a, b] = [a, b].map(|c| c as usize - 'A' as usize);
            matrix[a][b] = true;
            matrix[b][a] = true;
        }
        matrix
    }

    /// The table of Fig. 7 fixes both graphs of Fig. 6, save for pairs that
    /// never meet in it.
    #[test]
    fn figure_7_maximal_solutions() {
        let adjacent = graph(&[('A', 'B'), ('A', 'C'), ('C', 'D'), ('C', 'E'), ('D', 'F')]);
        let incompatible = graph(&[('A', 'D'), ('A', 'F'), ('E', 'F')]);
        let named: Vec<String> = maximal_sets(&adjacent, &incompatible)
            .iter()
            .map(|set| set.iter().map(|&k| (b'A' + k as u8) as char).collect())
            .collect();
        assert_eq!(named, ["ABCE", "CDE", "CDF"]);
    }
}

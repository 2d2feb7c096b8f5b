//! Connected sets of lattice points, by runs along x.

use super::lattice::Lattice;

/// Points `start..end` of one row.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: usize,
    end: usize,
}

/// Connected components, over faces, edges and corners.
#[derive(Clone, Debug)]
pub(super) struct Components {
    /// In the order of the lattice; indices are of points.
    runs: Vec<Run>,
    /// Of each run, from zero.
    labels: Vec<usize>,
    count: usize,
}

impl Components {
    /// The components of the points that are `in_set`.
    pub(super) fn of(lattice: &Lattice, in_set: impl Fn(usize) -> bool) -> Components {
        let [nx, ny, nz] = lattice.size;
        let mut runs: Vec<Run> = Vec::new();
        let mut first: Vec<usize> = Vec::with_capacity(ny * nz + 1);
        for row in 0..ny * nz {
            first.push(runs.len());
            let mut open = None;
            for index in row * nx..(row + 1) * nx {
                match (open, in_set(index)) {
                    (None, true) => open = Some(index),
                    (Some(start), false) => {
                        runs.push(Run { start, end: index });
                        open = None;
                    }
                    _ => {}
                }
            }
            if let Some(start) = open {
                let end = (row + 1) * nx;
                runs.push(Run { start, end });
            }
        }
        first.push(runs.len());
        let mut parents: Vec<usize> = (0..runs.len()).collect();
        for z in 0..nz {
            for y in 0..ny {
                let own = z * ny + y;
                // The four neighbouring rows that come before.
                let before = [(0, 1), (1, 0), (1, 1), (1, -1)];
                for (dz, dy) in before {
                    let Some(other_y) = y.checked_add_signed(-dy).filter(|&k| k < ny) else {
                        continue;
                    };
                    let Some(other_z) = z.checked_sub(dz) else {
                        continue;
                    };
                    let other = other_z * ny + other_y;
                    join_rows(
                        &runs,
                        first[own]..first[own + 1],
                        first[other]..first[other + 1],
                        (own - other) * nx,
                        &mut parents,
                    );
                }
            }
        }
        let mut labels = vec![usize::MAX; runs.len()];
        let mut count = 0;
        for run in 0..runs.len() {
            // A root is the first run of its component.
            let root = root(&mut parents, run);
            if root == run {
                labels[run] = count;
                count += 1;
            } else {
                labels[run] = labels[root];
            }
        }
        Components {
            runs,
            labels,
            count,
        }
    }

    /// The component of a point.
    pub(super) fn label_at(&self, _: &Lattice, point: usize) -> Option<usize> {
        let after = self.runs.partition_point(|run| run.start <= point);
        let run = after.checked_sub(1)?;
        (point < self.runs[run].end).then(|| self.labels[run])
    }

    /// Which points belong to one component.
    pub(super) fn marked(&self, lattice: &Lattice, label: Option<usize>) -> Vec<bool> {
        let chosen: Vec<bool> = (0..self.count).map(|k| Some(k) == label).collect();
        self.chosen(lattice, &chosen)
    }

    /// Which components have a point like that.
    pub(super) fn which(&self, is_like_that: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut found = vec![false; self.count];
        for (run, &label) in self.runs.iter().zip(&self.labels) {
            found[label] = found[label] || (run.start..run.end).any(&is_like_that);
        }
        found
    }

    /// Which points belong to chosen components.
    pub(super) fn chosen(&self, lattice: &Lattice, components: &[bool]) -> Vec<bool> {
        let mut points = vec![false; lattice.len()];
        for (run, &label) in self.runs.iter().zip(&self.labels) {
            if components[label] {
                points[run.start..run.end].fill(true);
            }
        }
        points
    }
}

/// Joins runs of two rows that touch, corners included; `shift` brings the other row's
/// points to this row.
fn join_rows(
    runs: &[Run],
    own: std::ops::Range<usize>,
    other: std::ops::Range<usize>,
    shift: usize,
    parents: &mut [usize],
) {
    let (mut a, mut b) = (own.start, other.start);
    while a < own.end && b < other.end {
        let (start, end) = (runs[b].start + shift, runs[b].end + shift);
        if runs[a].start <= end && start <= runs[a].end {
            let (x, y) = (root(parents, a), root(parents, b));
            parents[x.max(y)] = x.min(y);
        }
        if runs[a].end < end {
            a += 1;
        } else {
            b += 1;
        }
    }
}

fn root(parents: &mut [usize], mut run: usize) -> usize {
    while parents[run] != run {
        parents[run] = parents[parents[run]];
        run = parents[run];
    }
    run
}

//! The largest distance of a polytope's points to a set of triangles.
//!
//! Let `f_j` be the distance to triangle j, a convex function, and `v_i` the
//! corners. Every point is a mean `Σ λ_i v_i`, so for any weights μ
//!
//! `min_j f_j(Σ λ_i v_i) ≤ Σ_j μ_j f_j(Σ λ_i v_i) ≤ max_i Σ_j μ_j f_j(v_i)`.
//!
//! The best μ is the solution of a matrix game, a linear program of a few rows.
//! Any μ gives a true bound, so nothing depends on how well it is solved. In the
//! middle of a slot, between two walls, equal weights make it exact.

/// Most functions mixed in one bound.
pub(super) const MOST: usize = 6;

/// The simplex method ends long before; a bound is true at any step.
const PIVOTS: usize = 16;

/// Entries of the tableau that count as zero.
const TINY: f64 = 1e-12;

/// Buffer of [`upper_bound`]: the condensed simplex tableau, one row a corner
/// and the objective, one column a weight and the right-hand side.
#[derive(Default)]
pub(super) struct Tableau {
    entries: Vec<f64>,
    /// The variable of each row and of each column: weights first, then slacks.
    basic: Vec<usize>,
    free: Vec<usize>,
}

/// Upper bound of `max over the polytope of min_j f_j`: `rows[j][i]` is
/// `f_j(v_i)`, finite, at most [`MOST`] rows.
pub(super) fn upper_bound(rows: &[Vec<f64>], tableau: &mut Tableau) -> f64 {
    let Some(single) = rows
        .iter()
        .map(|row| row.iter().copied().fold(0.0, f64::max))
        .min_by(f64::total_cmp)
    else {
        return f64::INFINITY;
    };
    if rows.len() < 2 || single == 0.0 {
        return single;
    }
    tableau.solve(rows, single);
    let weights = tableau.row_weights(rows.len());
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return single;
    }
    let mixed = (0..rows[0].len())
        .map(|i| {
            rows.iter()
                .zip(&weights)
                .map(|(r, w)| r[i] * w)
                .sum::<f64>()
                / total
        })
        .fold(0.0, f64::max);
    single.min(mixed)
}

impl Tableau {
    /// Maximise `Σ x_j` such that `Σ_j (f_j(v_i) + shift) x_j ≤ 1` at every
    /// corner, the row player's program (Dantzig 1951); `shift` makes the game
    /// positive.
    pub(super) fn solve(&mut self, rows: &[Vec<f64>], shift: f64) {
        let (m, n) = (rows.len(), rows[0].len());
        let width = m + 1;
        let entries = &mut self.entries;
        entries.clear();
        for i in 0..n {
            entries.extend(rows.iter().map(|row| row[i] + shift));
            entries.push(1.0);
        }
        entries.extend(std::iter::repeat_n(-1.0, m));
        entries.push(0.0);
        self.basic.clear();
        self.basic.extend(m..m + n);
        self.free.clear();
        self.free.extend(0..m);
        for _ in 0..PIVOTS {
            let objective = &entries[n * width..n * width + m];
            let Some(enter) = (0..m).min_by(|a, b| objective[*a].total_cmp(&objective[*b])) else {
                break;
            };
            if objective[enter] >= -TINY {
                break;
            }
            let leave = (0..n)
                .filter(|i| entries[i * width + enter] > TINY * shift)
                .map(|i| (entries[i * width + m] / entries[i * width + enter], i))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, leave)) = leave else { break };
            pivot(entries, n + 1, width, leave, enter);
            std::mem::swap(&mut self.basic[leave], &mut self.free[enter]);
        }
    }

    /// The weights of the rows after [`Tableau::solve`], up to a factor.
    pub(super) fn row_weights(&self, m: usize) -> [f64; MOST] {
        let mut weights = [0.0; MOST];
        for (i, variable) in self.basic.iter().enumerate() {
            if *variable < m {
                weights[*variable] = self.entries[i * (m + 1) + m].max(0.0);
            }
        }
        weights
    }

    /// The weights of the corners, up to a factor: the dual values. Their mean
    /// is the point where the least distance is largest.
    pub(super) fn corner_weights(&self, m: usize, out: &mut [f64]) {
        out.fill(0.0);
        let objective = &self.entries[self.basic.len() * (m + 1)..];
        for (column, variable) in self.free.iter().enumerate() {
            if *variable >= m {
                out[*variable - m] = objective[column].max(0.0);
            }
        }
    }
}

fn pivot(entries: &mut [f64], height: usize, width: usize, row: usize, column: usize) {
    let inverse = 1.0 / entries[row * width + column];
    for i in 0..height {
        if i == row {
            continue;
        }
        let factor = entries[i * width + column] * inverse;
        for j in 0..width {
            if j != column {
                entries[i * width + j] -= factor * entries[row * width + j];
            }
        }
        entries[i * width + column] = -factor;
    }
    for j in 0..width {
        entries[row * width + j] *= inverse;
    }
    entries[row * width + column] = inverse;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bound(rows: &[Vec<f64>]) -> f64 {
        upper_bound(rows, &mut Tableau::default())
    }

    #[test]
    fn two_walls_of_a_slot() {
        // Cell from 0 to 4 across a slot with walls at −1 and 5.
        let rows = [vec![1.0, 5.0], vec![5.0, 1.0]];
        assert!((bound(&rows) - 3.0).abs() < 1e-12);
        assert_eq!(bound(&rows[..1]), 5.0);
    }

    #[test]
    fn three_walls_meet_in_the_middle() {
        let rows = [
            vec![0.0, 3.0, 3.0],
            vec![3.0, 0.0, 3.0],
            vec![3.0, 3.0, 0.0],
        ];
        assert!((bound(&rows) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn as_good_as_the_best_of_many_weights() {
        // A fixed sequence of numbers without pattern.
        let mut state = 1u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for corners in [4, 8, 20] {
            for _ in 0..50 {
                let rows: Vec<Vec<f64>> = (0..4)
                    .map(|_| (0..corners).map(|_| next()).collect())
                    .collect();
                let found = bound(&rows);
                for _ in 0..200 {
                    let weights: Vec<f64> = (0..4).map(|_| next()).collect();
                    let total: f64 = weights.iter().sum();
                    let other = (0..corners)
                        .map(|i| (0..4).map(|j| rows[j][i] * weights[j]).sum::<f64>() / total)
                        .fold(0.0, f64::max);
                    assert!(found <= other + 1e-9);
                }
            }
        }
    }

    #[test]
    fn nothing_to_be_near_to() {
        assert_eq!(bound(&[]), f64::INFINITY);
    }
}

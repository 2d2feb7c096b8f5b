//! Eigenvectors of small symmetric matrices.

/// Eigenvalues and unit eigenvectors (as rows) by Jacobi's rotations (Golub and Van Loan,
/// *Matrix Computations*, §8.5), by increasing eigenvalue.
pub fn symmetric<const N: usize>(mut a: [[f64; N]; N]) -> [(f64, [f64; N]); N] {
    let mut vectors = [[0.0; N]; N];
    for (i, row) in vectors.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for _ in 0..30 {
        for p in 0..N {
            for q in p + 1..N {
                if a[p][q].abs() <= 1e-18 * (a[p][p].abs() + a[q][q].abs()) {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..N {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                    (vectors[p][k], vectors[q][k]) = (
                        c * vectors[p][k] - s * vectors[q][k],
                        s * vectors[p][k] + c * vectors[q][k],
                    );
                }
            }
        }
    }
    let mut found: [(f64, [f64; N]); N] = std::array::from_fn(|i| (a[i][i], vectors[i]));
    found.sort_by(|x, y| x.0.total_cmp(&y.0));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_scaled_by_their_values() {
        let mut matrix = [[0.0; 6]; 6];
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = 1.0 / (1.0 + (i + j) as f64) + f64::from(u8::from(i == j));
            }
        }
        let found = symmetric(matrix);
        assert!(found.windows(2).all(|w| w[0].0 <= w[1].0));
        for (value, vector) in found {
            let length: f64 = vector.iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-12);
            for i in 0..6 {
                let image: f64 = (0..6).map(|j| matrix[i][j] * vector[j]).sum();
                assert!((image - value * vector[i]).abs() < 1e-12);
            }
        }
    }
}

//! Eigenvectors of symmetric matrices by Jacobi's rotations, row after row
//! (Golub and Van Loan, Matrix Computations, Sec. 8.5).
//!
//! Ours, since the linear-algebra crate that was tried brings in one that
//! is no longer maintained; and the same on every machine, since no kernel is
//! picked for the processor.

/// Rounds over all pairs; some six to ten are needed.
const ROUNDS: usize = 60;

/// Eigenvalues and eigenvectors of length 1 of a symmetric matrix of `side`
/// rows, the largest value first. Of equal ones, the order is that of the rows.
pub(super) fn eigen(side: usize, mut a: Vec<f64>) -> Vec<(f64, Vec<f64>)> {
    // A row a vector.
    let mut vectors = vec![0.0; side * side];
    for i in 0..side {
        vectors[i * side + i] = 1.0;
    }
    let total: f64 = a.iter().map(|v| v * v).sum();
    for _ in 0..ROUNDS {
        let off = (0..side * side).filter(|i| i / side != i % side);
        if off.map(|i| a[i] * a[i]).sum::<f64>() <= total * 1e-30 {
            break;
        }
        for p in 0..side {
            for q in p + 1..side {
                rotate(&mut a, &mut vectors, side, p, q);
            }
        }
    }
    let mut pairs: Vec<(f64, Vec<f64>)> = vectors
        .chunks_exact(side)
        .enumerate()
        .map(|(i, v)| (a[i * side + i], v.to_vec()))
        .collect();
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    pairs
}

/// Turns axes `p < q` so that their entry becomes 0.
fn rotate(a: &mut [f64], vectors: &mut [f64], side: usize, p: usize, q: usize) {
    let entry = a[p * side + q];
    if entry == 0.0 {
        return;
    }
    // The smaller of both angles, as its tangent.
    let theta = (a[q * side + q] - a[p * side + p]) / (2.0 * entry);
    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cos = 1.0 / tangent.hypot(1.0);
    let sin = tangent * cos;
    for i in 0..side {
        let (x, y) = (a[i * side + p], a[i * side + q]);
        a[i * side + p] = cos * x - sin * y;
        a[i * side + q] = sin * x + cos * y;
    }
    for rows in [a, vectors] {
        let (upper, lower) = rows.split_at_mut(q * side);
        let (first, second) = (&mut upper[p * side..][..side], &mut lower[..side]);
        for (x, y) in first.iter_mut().zip(second) {
            (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng as _, SeedableRng as _};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Vectors are orthonormal, and the matrix only scales them; matrices of
    /// less than full rank and with equal values among them.
    #[test]
    fn the_matrix_scales_its_eigenvectors() {
        let mut random = Pcg64Mcg::seed_from_u64(9);
        for (side, rank) in [(1, 1), (2, 2), (7, 3), (40, 40), (40, 5), (30, 0)] {
            let rows: Vec<f64> = (0..side * rank)
                .map(|_| random.random_range(-1.0..1.0))
                .collect();
            let row = |i: usize| &rows[i * rank..][..rank];
            let mut a = vec![0.0; side * side];
            for i in 0..side {
                for j in 0..side {
                    a[i * side + j] = dot(row(i), row(j)) + f64::from(u8::from(i == j));
                }
            }
            let found = eigen(side, a.clone());
            assert!(found.windows(2).all(|p| p[0].0 >= p[1].0));
            for (i, (value, vector)) in found.iter().enumerate() {
                for (a, v) in a.chunks_exact(side).zip(vector) {
                    assert!((dot(a, vector) - value * v).abs() < 1e-12 * side as f64);
                }
                for (j, (_, other)) in found.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((dot(vector, other) - expected).abs() < 1e-12);
                }
                if i >= rank {
                    assert!((value - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_small_one_by_hand() {
        let found = eigen(2, vec![2.0, 1.0, 1.0, 2.0]);
        assert!((found[0].0 - 3.0).abs() < 1e-15 && (found[1].0 - 1.0).abs() < 1e-15);
        assert!((found[0].1[0] - found[0].1[1]).abs() < 1e-15);
        // Equal diagonal entries of 0 and nothing beside them.
        assert_eq!(eigen(2, vec![0.0; 4])[0], (0.0, vec![1.0, 0.0]));
    }
}

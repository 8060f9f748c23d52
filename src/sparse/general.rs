//! One solution of a sparse system that need not be symmetric, by faer.
//!
//! A symmetric positive definite matrix gets Cholesky's factorisation, any other LU with row pivoting, and the caller is told which. Nothing is kept for the
//! next system: these matrices change their pattern.

use crate::error::{Error, Result};
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// How a system was solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Cholesky: the matrix is symmetric and positive definite.
    Cholesky,
    /// LU of a matrix that is not symmetric.
    Unsymmetric,
    /// LU of a symmetric matrix that is not positive definite.
    Indefinite,
}

/// Two entries across the diagonal that differ by less than this share of the largest entry are equal.
const SYMMETRY: f64 = 1e-13;

/// Solves for several right-hand sides in place. `rows`: column and value of the entries of each row, which may repeat a column.
///
/// # Errors
/// A matrix that is singular or not finite.
pub fn solve<const K: usize>(rows: &[Vec<(usize, f64)>], right: &mut [[f64; K]]) -> Result<Method> {
    let n = rows.len();
    let singular = |what: &str| Error::Numerical { message: format!("the matrix of the step is {what}"), help: None };
    let triplets: Vec<_> =
        rows.iter().enumerate().flat_map(|(row, r)| r.iter().map(move |&(col, val)| Triplet { row, col, val })).collect();
    if triplets.iter().any(|t| !t.val.is_finite()) {
        return Err(singular("not finite"));
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &triplets).map_err(|e| singular(&format!("unusable: {e:?}")))?;
    let mut x = Mat::from_fn(n, K, |i, k| right[i][k]);
    let method = if is_symmetric(&matrix) {
        match matrix.sp_cholesky(Side::Lower) {
            Ok(factor) => {
                factor.solve_in_place(x.as_mut());
                Method::Cholesky
            }
            Err(_) => Method::Indefinite,
        }
    } else {
        Method::Unsymmetric
    };
    if method != Method::Cholesky {
        matrix.sp_lu().map_err(|e| singular(&format!("singular: {e:?}")))?.solve_in_place(x.as_mut());
    }
    for (i, row) in right.iter_mut().enumerate() {
        *row = std::array::from_fn(|k| x[(i, k)]);
    }
    if right.as_flattened().iter().all(|v| v.is_finite()) { Ok(method) } else { Err(singular("singular")) }
}

fn is_symmetric(matrix: &SparseColMat<usize, f64>) -> bool {
    let largest = matrix.val().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let at = |i: usize, j: usize| matrix.get(i, j).copied().unwrap_or(0.0);
    matrix.triplet_iter().all(|t| (t.val - at(t.col, t.row)).abs() <= SYMMETRY * largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_matrix_gets_its_factorisation() -> Result<()> {
        for (matrix, method) in [
            ([[4.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.0, -1.0, 2.0]], Method::Cholesky),
            ([[4.0, 1.0, 0.0], [1.0, -3.0, -1.0], [0.0, -1.0, 2.0]], Method::Indefinite),
            ([[4.0, 1.0, 0.0], [2.0, 3.0, -1.0], [0.0, -1.0, 2.0]], Method::Unsymmetric),
        ] {
            // Entries may be given in parts.
            let rows: Vec<Vec<(usize, f64)>> = matrix
                .iter()
                .map(|row| (0..3).filter(|j| row[*j] != 0.0).flat_map(|j| [(j, 0.25 * row[j]), (j, 0.75 * row[j])]).collect())
                .collect();
            let exact = [[1.0, 0.5], [-2.0, 3.0], [0.25, -1.0]];
            let mut x: [[f64; 2]; 3] = std::array::from_fn(|i| std::array::from_fn(|k| (0..3).map(|j| matrix[i][j] * exact[j][k]).sum()));
            assert_eq!(solve(&rows, &mut x)?, method);
            assert!(x.as_flattened().iter().zip(exact.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-14), "{x:?}");
        }
        Ok(())
    }

    #[test]
    fn singular_matrices_are_refused() {
        let mut x = [[1.0], [2.0]];
        assert!(solve(&[vec![(0, 1.0), (1, 2.0)], vec![(0, 2.0), (1, 4.0)]], &mut x).is_err());
        assert!(solve(&[vec![(0, f64::NAN)], vec![(1, 1.0)]], &mut x).is_err());
    }
}

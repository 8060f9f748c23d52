//! How fast the machine is: a unit in which run times of different machines can be compared.

use faer::{Accum, Mat, Par, linalg::matmul::matmul};
use std::hint::black_box;
use std::time::Instant;

/// Rows of the square matrices.
const ROWS: usize = 512;

/// The rate of dense products of matrices of double precision, on one thread.
///
/// Products are made in rounds, between other work, and the fastest counts, so that a busy machine does little harm.
pub struct DenseProduct {
    factor: Mat<f64>,
    product: Mat<f64>,
    best: f64,
}

impl Default for DenseProduct {
    fn default() -> Self {
        let factor = Mat::from_fn(ROWS, ROWS, |i, j| ((i + 2 * j) as f64).sin());
        DenseProduct { factor, product: Mat::zeros(ROWS, ROWS), best: f64::INFINITY }
    }
}

impl DenseProduct {
    /// One product more.
    pub fn round(&mut self) {
        let start = Instant::now();
        matmul(self.product.as_mut(), Accum::Replace, self.factor.as_ref(), self.factor.as_ref(), 1.0, Par::Seq);
        black_box(&self.product);
        self.best = self.best.min(start.elapsed().as_secs_f64());
    }

    /// Rate of the fastest product so far [flop/s]; 0 before the first.
    pub fn rate(&self) -> f64 {
        2.0 * (ROWS as f64).powi(3) / self.best
    }
}

//! The largest eigenvalue of `A M`, for a symmetric positive definite `A` that is given by its action and a diagonal `M` that may be zero
//! in places: Lanczos' method in the scalar product of `M`. With `A = (K + sigma M)^-1` it is the lowest mode of `K v = lambda M v`.
//!
//! Products of all vectors with each other keep them orthogonal, so their number is bounded and the iteration starts anew from its best
//! vector. faer's iteration wants an operator that several threads may use at once, which a factor with one work space is not.

use nalgebra::{DMatrix, SymmetricEigen};

/// Vectors before the iteration starts anew.
const VECTORS: usize = 40;

/// Times it does.
const STARTS: usize = 25;

/// Change of the vector, relative to its length, at which it is found; the eigenvalue's error is of the order of its square.
const TOLERANCE: f64 = 1e-8;

/// An eigenvalue `theta` of `A M v = theta v` and its vector, `v.M v = 1`.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Eigenvalue.
    pub value: f64,
    /// Eigenvector.
    pub vector: Vec<f64>,
}

/// The largest eigenvalue; none if `mass` is zero everywhere, or if the iteration did not settle. `mass`: diagonal of `M`, >= 0. `apply`:
/// `y <- A y`. Deterministic.
pub fn largest(mass: &[f64], apply: &mut dyn FnMut(&mut [f64])) -> Option<Mode> {
    let heavy = mass.iter().filter(|m| **m > 0.0).count();
    // Numbers without any symmetry.
    let mut mode = Mode { value: 0.0, vector: (0..mass.len()).map(|i| (0.618_034 * (i + 1) as f64).fract() - 0.5).collect() };
    for _ in 0..STARTS {
        let found = run(mass, apply, &mode.vector, VECTORS.min(heavy))?;
        mode = found.0;
        if found.1 {
            return Some(mode);
        }
    }
    None
}

/// `a.M b`.
fn product(mass: &[f64], a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).zip(mass).map(|((a, b), m)| a * b * m).sum()
}

/// One start from `start`: the best vector of at most `most`, and whether it is good enough.
fn run(mass: &[f64], apply: &mut dyn FnMut(&mut [f64]), start: &[f64], most: usize) -> Option<(Mode, bool)> {
    let mut times = |v: &[f64]| {
        let mut y: Vec<f64> = v.iter().zip(mass).map(|(v, m)| v * m).collect();
        apply(&mut y);
        y
    };
    // Applied once, the start has no part that `M` does not see.
    let mut next = times(start);
    let mut length = product(mass, &next, &next).sqrt();
    let (mut basis, mut diagonal, mut beside): (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) = Default::default();
    loop {
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        next.iter_mut().for_each(|v| *v /= length);
        basis.push(next);
        let last = &basis[basis.len() - 1];
        next = times(last);
        diagonal.push(product(mass, &next, last));
        // Twice is enough against round-off.
        for _ in 0..2 {
            for q in &basis {
                let part = product(mass, &next, q);
                next.iter_mut().zip(q).for_each(|(n, q)| *n -= part * q);
            }
        }
        length = product(mass, &next, &next).sqrt();
        let k = basis.len();
        let small = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
            0 => diagonal[i],
            1 => beside[i.min(j)],
            _ => 0.0,
        });
        let eigen = SymmetricEigen::new(small);
        let best = eigen.eigenvalues.imax();
        let (value, ritz) = (eigen.eigenvalues[best], eigen.eigenvectors.column(best));
        let settled = length * ritz[k - 1].abs() <= TOLERANCE * value;
        if settled || k == most {
            let mut vector = vec![0.0; mass.len()];
            for (q, share) in basis.iter().zip(ritz.iter()) {
                vector.iter_mut().zip(q).for_each(|(v, q)| *v += share * q);
            }
            return Some((Mode { value, vector }, settled));
        }
        beside.push(length);
    }
}

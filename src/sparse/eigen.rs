//! The largest eigenvalues of an operator `A` that is self-adjoint in the scalar product of a matrix `B`: block Lanczos with full
//! orthogonalisation and thick restarts.
//!
//! `B` may be semidefinite where `A v` depends on `B v` alone, as in vibration, whose directors have no mass. Blocks find equal eigenvalues, both ends of
//! the spectrum may be of either sign, and nothing is random. faer's partial eigen-solver goes one vector at a time, which leaves equal eigenvalues
//! to round-off, knows no scalar product but the plain one, and wants an operator that several threads may use at once.

use super::Pattern;
use nalgebra::{DMatrix, SymmetricEigen};

/// Times the iteration starts anew from its best vectors.
const RESTARTS: usize = 200;

/// Steps before eigenvalues are left out as too small.
const STEPS: usize = 12;

/// Residual of an eigenvector, relative to its eigenvalue, at which it is found; the eigenvalue's error is of the order of its square.
const TOLERANCE: f64 = 1e-9;

/// Residual over the largest eigenvalue that is round-off.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// A pair `A v = value v`, `v.B v = 1`.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Eigenvalue.
    pub value: f64,
    /// Eigenvector.
    pub vector: Vec<f64>,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The largest eigenvalues with their vectors, descending.
    pub pairs: Vec<Pair>,
    /// Eigenvalues below this were left out.
    pub least: f64,
}

/// `A` and `B` by what they do.
pub trait SelfAdjoint {
    /// `A v`.
    fn apply(&mut self, v: &[f64]) -> Vec<f64>;

    /// `B v`.
    fn metric(&self, v: &[f64]) -> Vec<f64>;
}

/// `A v` for a symmetric matrix by its lower triangle.
pub fn multiply(pattern: &Pattern, matrix: &[f64], v: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; v.len()];
    for j in 0..v.len() {
        let entries = pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize;
        y[j] += matrix[entries.start] * v[j];
        for k in entries.skip(1) {
            let i = pattern.row[k] as usize;
            y[i] += matrix[k] * v[j];
            y[j] += matrix[k] * v[i];
        }
    }
    y
}

/// A vector with its image under `B`.
struct Direction {
    q: Vec<f64>,
    bq: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn subtract(from: &mut [f64], factor: f64, v: &[f64]) {
    from.iter_mut().zip(v).for_each(|(f, v)| *f -= factor * v);
}

/// `sum_i c_i q_i` over directions.
fn combine(basis: &[Direction], shares: impl Iterator<Item = f64>, of: impl Fn(&Direction) -> &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; basis.first().map_or(0, |d| d.q.len())];
    basis.iter().zip(shares).for_each(|(d, share)| subtract(&mut sum, -share, of(d)));
    sum
}

/// What is left of `v` across the `basis`, with length 1; none where nothing is left but round-off.
fn across(operator: &impl SelfAdjoint, basis: &[Direction], mut v: Vec<f64>) -> Option<Direction> {
    let mut bv = operator.metric(&v);
    let start = dot(&v, &bv).sqrt();
    let mut length = start;
    // Twice is enough against round-off; the image under B is taken anew, since it loses digits otherwise.
    for _ in 0..2 {
        for d in basis {
            let part = dot(&d.bq, &v);
            subtract(&mut v, part, &d.q);
        }
        bv = operator.metric(&v);
        length = dot(&v, &bv).sqrt();
    }
    if !(length > 1e-12 * start) || !length.is_finite() {
        return None;
    }
    [&mut v, &mut bv].into_iter().for_each(|v| v.iter_mut().for_each(|v| *v /= length));
    Some(Direction { q: v, bq: bv })
}

/// The `count` largest eigenvalues with their vectors, descending; fewer where the space has no more. None if the iteration did not settle.
/// `size`: of the vectors. `block`: vectors that go ahead together, > 0: equal eigenvalues up to that many are found for sure. `floor`: eigenvalues below this
/// share of the size of the smallest, where that is negative, are left out; what lies there is not waited for.
pub fn largest(operator: &mut impl SelfAdjoint, size: usize, count: usize, block: usize, floor: f64) -> Option<Found> {
    let kept = count + block;
    let most = (2 * kept + 4 * block).max(40);
    let (mut basis, mut applied): (Vec<Direction>, usize) = (Vec::new(), 0);
    let mut small = DMatrix::<f64>::zeros(0, 0);
    let mut seed = 0;
    let mut smallest = 0.0f64;
    // Numbers without any symmetry, applied once so that no part is left that `B` does not see.
    let mut fresh = |operator: &mut _, basis: &mut Vec<Direction>, wanted: usize| {
        for _ in 0..wanted {
            seed += 1;
            let start: Vec<f64> = (0..size).map(|i| (0.618_034 * (i + 1) as f64 * f64::from(2 * seed + 1)).fract() - 0.5).collect();
            let start = SelfAdjoint::apply(operator, &start);
            basis.extend(across(operator, basis, start));
        }
    };
    fresh(operator, &mut basis, block);
    if basis.is_empty() {
        return Some(Found { pairs: Vec::new(), least: 0.0 });
    }
    for steps in 0..RESTARTS * most {
        // The images of the newest vectors, and what of them lies outside the basis.
        let from = applied;
        let images: Vec<Vec<f64>> = (from..basis.len()).map(|j| operator.apply(&basis[j].q)).collect();
        applied = basis.len();
        let mut larger = DMatrix::zeros(applied, applied);
        larger.view_mut((0, 0), (from, from)).copy_from(&small);
        for (j, image) in (from..applied).zip(&images) {
            for i in 0..applied {
                let product = dot(&basis[i].bq, image);
                // Between two new vectors the mean of both products.
                let share = if i >= from && i != j { 0.5 } else { 1.0 };
                larger[(i, j)] += share * product;
                if i != j {
                    larger[(j, i)] += share * product;
                }
            }
        }
        small = larger;
        for image in &images {
            let next = across(operator, &basis, image.clone());
            basis.extend(next);
        }
        if basis.len() == applied {
            fresh(operator, &mut basis, block);
        }
        let exhausted = basis.len() == applied;
        let eigen = SymmetricEigen::new(small.clone());
        let mut order: Vec<usize> = (0..applied).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let scale = eigen.eigenvalues.amax();
        // The images of older vectors lie in the basis; what is outside belongs to the newest.
        let outside = DMatrix::from_fn(basis.len() - applied, images.len(), |n, j| dot(&basis[applied + n].bq, &images[j]));
        let residual = |k: usize| (&outside * eigen.eigenvectors.view((from, k), (applied - from, 1))).norm();
        let wanted = &order[..count.min(applied)];
        // A new start forgets the smallest.
        smallest = smallest.min(eigen.eigenvalues.min());
        let least = floor * -smallest;
        // Not before larger ones, if there are any, had a chance to show.
        let small_enough = |k: &usize| floor > 0.0 && steps >= STEPS && eigen.eigenvalues[*k] + residual(*k) < least;
        let found = |k: &usize| residual(*k) <= TOLERANCE * eigen.eigenvalues[*k].abs() + ROUND_OFF * scale || small_enough(k);
        if exhausted || (applied >= count && wanted.iter().all(found)) {
            let pair = |k: &usize| {
                // Applied once more, it is rid of what `B` does not see.
                let mut vector = operator.apply(&combine(&basis, eigen.eigenvectors.column(*k).iter().copied(), |d| &d.q));
                let length = dot(&vector, &operator.metric(&vector)).sqrt();
                vector.iter_mut().for_each(|v| *v /= length);
                Pair { value: eigen.eigenvalues[*k], vector }
            };
            let kept = wanted.iter().filter(|k| floor == 0.0 || eigen.eigenvalues[**k] > least);
            return Some(Found { pairs: kept.map(pair).collect(), least });
        }
        if basis.len() + block > most && applied > kept {
            let best = &order[..kept];
            let column = |k: usize| eigen.eigenvectors.column(k);
            let mut fewer: Vec<Direction> = best
                .iter()
                .map(|k| Direction {
                    q: combine(&basis[..applied], column(*k).iter().copied(), |d| &d.q),
                    bq: combine(&basis[..applied], column(*k).iter().copied(), |d| &d.bq),
                })
                .collect();
            fewer.extend(basis.drain(applied..));
            basis = fewer;
            applied = kept;
            small = DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(kept, best.iter().map(|k| eigen.eigenvalues[*k])));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonal operator in a diagonal scalar product that may be zero in places.
    struct Diagonal {
        theta: Vec<f64>,
        metric: Vec<f64>,
    }

    impl SelfAdjoint for Diagonal {
        fn apply(&mut self, v: &[f64]) -> Vec<f64> {
            v.iter().zip(&self.theta).zip(&self.metric).map(|((v, t), m)| if *m > 0.0 { v * t } else { 0.0 }).collect()
        }

        fn metric(&self, v: &[f64]) -> Vec<f64> {
            v.iter().zip(&self.metric).map(|(v, m)| v * m).collect()
        }
    }

    #[test]
    fn finds_equal_eigenvalues_beside_large_negative_ones() {
        let n = 400;
        let theta: Vec<f64> = (0..n)
            .map(|i| match i {
                7 | 90 | 200 | 211 => 3.0,
                300 => 5.0,
                13 => -50.0,
                _ => (0.1 * i as f64).sin(),
            })
            .collect();
        let mut operator =
            Diagonal { theta: theta.clone(), metric: (0..n).map(|i| if i % 10 == 9 { 0.0 } else { 1.0 + i as f64 }).collect() };
        let pairs = largest(&mut operator, n, 5, 4, 0.0).map_or(Vec::new(), |found| found.pairs);
        let values: Vec<f64> = pairs.iter().map(|p| p.value).collect();
        assert!(values.len() == 5 && values.iter().zip([5.0, 3.0, 3.0, 3.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
        for p in &pairs {
            let image = operator.apply(&p.vector);
            let off = image.iter().zip(&p.vector).map(|(a, v)| (a - p.value * v).abs()).fold(0.0, f64::max);
            assert!(off < 1e-8 && (dot(&p.vector, &operator.metric(&p.vector)) - 1.0).abs() < 1e-12, "{off}");
        }
    }

    #[test]
    fn what_lies_below_the_floor_is_left_out() {
        let theta: Vec<f64> = (0..300).map(|i| if i == 5 { 0.5 } else { -1.0 / (1.0 + i as f64) }).collect();
        let mut operator = Diagonal { theta, metric: vec![1.0; 300] };
        for (floor, count) in [(1e-4, 1), (0.9, 0)] {
            assert!(largest(&mut operator, 300, 4, 4, floor).is_some_and(|found| found.pairs.len() == count), "{floor}");
        }
    }

    #[test]
    fn an_operator_that_is_zero_has_no_pairs() {
        let mut operator = Diagonal { theta: vec![0.0; 3], metric: vec![1.0; 3] };
        assert!(largest(&mut operator, 3, 2, 2, 0.0).is_some_and(|found| found.pairs.is_empty()));
    }

    #[test]
    fn a_space_smaller_than_asked_for() {
        let mut operator = Diagonal { theta: vec![2.0, -1.0, 7.0], metric: vec![1.0, 3.0, 0.0] };
        let found = largest(&mut operator, 3, 5, 4, 0.0).map_or(Vec::new(), |found| found.pairs);
        let values: Vec<f64> = found.iter().map(|p| p.value).collect();
        assert!(values.len() == 2 && (values[0] - 2.0).abs() < 1e-14 && (values[1] + 1.0).abs() < 1e-14, "{values:?}");
    }
}

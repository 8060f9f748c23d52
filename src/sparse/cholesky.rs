//! Sparse Cholesky factorisation by faer: one symbolic analysis, many numeric factorisations into the same memory.

use super::Pattern;
use crate::error::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// Kind of factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `L L^T`, for positive definite matrices.
    Llt,
    /// `L D L^T`, whose pivots tell the number of negative eigenvalues.
    Ldlt,
}

/// Why a matrix was not factorised: the unknown whose pivot was not usable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pivot {
    /// Free number of the unknown.
    pub unknown: usize,
    /// Whether the pivot vanished (a mechanism) rather than being negative.
    pub zero: bool,
}

/// A finished numeric factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refactored {
    /// Number of negative pivots (0 for `L L^T`).
    pub negative_pivots: usize,
}

fn out_of_memory() -> Error {
    Error::Numerical { message: "not enough memory for the factor of the matrix".into(), help: Some("use a coarser mesh".into()) }
}

fn analyse(pattern: &Pattern, ordering: SymmetricOrdering<'_, u32>) -> Result<SymbolicCholesky<u32>> {
    let n = pattern.len();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &pattern.column_start, None, &pattern.row);
    factorize_symbolic_cholesky(matrix, Side::Lower, ordering, CholeskySymbolicParams::default()).map_err(|_| out_of_memory())
}

/// Symbolic analysis, factor values and work space of one pattern.
pub struct Cholesky {
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    work: MemBuffer,
    kind: Kind,
    /// Largest absolute value in each column of the matrix last factorised: the scale that a pivot is zero against.
    scale: Vec<f64>,
}

impl Cholesky {
    /// Analyses a pattern: approximate minimum degree ordering and supernodes. Errors: out of memory.
    pub fn new(pattern: &Pattern) -> Result<Self> {
        Self::prepare(analyse(pattern, SymmetricOrdering::Amd)?)
    }

    /// Analyses a pattern whose unknowns come in blocks of equal size, each a row of `blocks`: the ordering is that of the blocks. Where
    /// unknowns form columns over a surface this needs far less than an ordering of their own. Errors: out of memory.
    pub fn of_blocks(pattern: &Pattern, blocks: &Pattern) -> Result<Self> {
        let coarse = analyse(blocks, SymmetricOrdering::Amd)?;
        let Some(order) = coarse.perm() else { return Self::new(pattern) };
        let size = pattern.len() / blocks.len().max(1);
        let forward: Vec<u32> = order.arrays().0.iter().flat_map(|b| (0..size).map(move |k| b * size as u32 + k as u32)).collect();
        let mut inverse = vec![0; forward.len()];
        forward.iter().enumerate().for_each(|(i, unknown)| inverse[*unknown as usize] = i as u32);
        Self::prepare(analyse(pattern, SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, pattern.len())))?)
    }

    /// Makes room for the factor.
    fn prepare(symbolic: SymbolicCholesky<u32>) -> Result<Self> {
        let n = symbolic.nrows();
        let request = symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default())
            .or(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default()))
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let work = MemBuffer::try_new(request).map_err(|_| out_of_memory())?;
        let values = vec![0.0; symbolic.len_val()];
        Ok(Cholesky { symbolic, values, work, kind: Kind::Llt, scale: vec![0.0; n] })
    }

    /// Factorises `matrix`, the values of the pattern, into the memory of the last factorisation.
    pub fn refactor(&mut self, pattern: &Pattern, matrix: &[f64], kind: Kind) -> Result<Refactored, Pivot> {
        let n = pattern.len();
        let a = SparseColMatRef::new(SymbolicSparseColMatRef::new_checked(n, n, &pattern.column_start, None, &pattern.row), matrix);
        self.kind = kind;
        let stack = MemStack::new(&mut self.work);
        let unknown = |index: usize| match self.symbolic.perm() {
            Some(perm) => perm.arrays().0[index] as usize,
            None => index,
        };
        // The factorisation counts a failed column from 1 where it is simplicial, from 0 where it is supernodal.
        let failed = |index: usize| match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => unknown(index.saturating_sub(1)),
            SymbolicCholeskyRaw::Supernodal(_) => unknown(index),
        };
        match kind {
            Kind::Llt => {
                self.symbolic
                    .factorize_numeric_llt(&mut self.values, a, Side::Lower, LltRegularization::default(), Par::Seq, stack, Spec::default())
                    .map_err(|LltError::NonPositivePivot { index }| Pivot { unknown: failed(index), zero: false })?;
                Ok(Refactored { negative_pivots: 0 })
            }
            Kind::Ldlt => {
                self.symbolic
                    .factorize_numeric_ldlt(
                        &mut self.values,
                        a,
                        Side::Lower,
                        LdltRegularization::default(),
                        Par::Seq,
                        stack,
                        Spec::default(),
                    )
                    .map_err(|LdltError::ZeroPivot { index }| Pivot { unknown: failed(index), zero: true })?;
                self.scale.fill(0.0);
                for j in 0..n {
                    for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
                        let (i, v) = (pattern.row[k] as usize, matrix[k].abs());
                        self.scale[i] = self.scale[i].max(v);
                        self.scale[j] = self.scale[j].max(v);
                    }
                }
                let mut negative_pivots = 0;
                let mut singular = None;
                self.each_pivot(|index, d| {
                    negative_pivots += usize::from(d < 0.0);
                    let u = unknown(index);
                    // Round-off leaves about eps of the row's scale where a mechanism's pivot should be zero.
                    if !d.is_finite() || d.abs() <= 16.0 * f64::EPSILON * self.scale[u] {
                        singular.get_or_insert(Pivot { unknown: u, zero: d.is_finite() });
                    }
                });
                singular.map_or(Ok(Refactored { negative_pivots }), Err)
            }
        }
    }

    /// Shows each pivot of the `L D L^T` factorisation, in elimination order.
    fn each_pivot(&self, mut visit: impl FnMut(usize, f64)) {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(s) => {
                for j in 0..s.nrows() {
                    visit(j, self.values[s.col_ptr()[j] as usize]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(s) => {
                for k in 0..s.n_supernodes() {
                    let (begin, end) = (s.supernode_begin()[k] as usize, s.supernode_end()[k] as usize);
                    let columns = end - begin;
                    let start = s.col_ptr_for_val()[k] as usize;
                    let rows = (s.col_ptr_for_val()[k + 1] as usize - start) / columns.max(1);
                    for c in 0..columns {
                        visit(begin + c, self.values[start + c * rows + c]);
                    }
                }
            }
        }
    }

    /// Solves with the last factorisation, in place. `x`: right-hand side, then solution, over the free unknowns.
    pub fn solve(&mut self, x: &mut [f64]) {
        let n = x.len();
        let stack = MemStack::new(&mut self.work);
        let rhs = MatMut::from_column_major_slice_mut(x, n, 1);
        match self.kind {
            Kind::Llt => LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
            Kind::Ldlt => LdltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::Numbering;

    /// A chain of four blocks of two: the same solution in either order.
    #[test]
    fn blocks_may_be_ordered_whole() -> Result<()> {
        let pattern =
            Pattern::new(&Numbering::new(&[false; 8]), &mut |show| (0..3).for_each(|b| show(&[2 * b, 2 * b + 1, 2 * b + 2, 2 * b + 3])))?;
        let blocks = Pattern::new(&Numbering::new(&[false; 4]), &mut |show| (0..3).for_each(|b| show(&[b, b + 1])))?;
        let matrix: Vec<f64> =
            (0..pattern.row.len()).map(|k| if pattern.column_start.contains(&(k as u32)) { 8.0 } else { (k as f64).sin() }).collect();
        let mut solutions = Vec::new();
        for mut cholesky in [Cholesky::new(&pattern)?, Cholesky::of_blocks(&pattern, &blocks)?] {
            cholesky.refactor(&pattern, &matrix, Kind::Llt).map_err(|pivot| Error::input("matrix", format!("{pivot:?}")))?;
            let mut x: Vec<f64> = (0..8).map(f64::from).collect();
            cholesky.solve(&mut x);
            solutions.push(x);
        }
        assert!(solutions[0].iter().zip(&solutions[1]).all(|(a, b)| (a - b).abs() < 1e-14) && solutions[0][7] > 0.1, "{solutions:?}");
        Ok(())
    }

    #[test]
    fn names_the_unknown_that_fails() -> Result<()> {
        let pattern = Pattern::new(&Numbering::new(&[false; 3]), &mut |show| (0..3).for_each(|i| show(&[i])))?;
        let mut cholesky = Cholesky::new(&pattern)?;
        for kind in [Kind::Llt, Kind::Ldlt] {
            for bad in 0..3 {
                let mut matrix = [2.0, 3.0, 5.0];
                matrix[bad] = 0.0;
                assert_eq!(cholesky.refactor(&pattern, &matrix, kind).map_err(|pivot| pivot.unknown), Err(bad), "{kind:?}");
            }
        }
        Ok(())
    }
}

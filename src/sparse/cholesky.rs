//! Sparse factorisation `L D L^T`: one symbolic analysis, by faer, many numeric factorisations into the same memory.

use super::Pattern;
use super::multifrontal::Fronts;
use crate::error::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// What a matrix has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Positive definite.
    Llt,
    /// Regular; the pivots tell the number of negative eigenvalues.
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refactored {
    /// Number of negative pivots (0 for `L L^T`).
    pub negative_pivots: usize,
    /// Smallest pivot over the diagonal entry of its row (1 for `L L^T`).
    pub smallest: f64,
    /// Free number of the unknown with that pivot.
    pub softest: usize,
    /// Whether a pivot is no larger than what round-off leaves of a zero one (not asked for `L L^T`).
    pub is_vanishing: bool,
}

fn out_of_memory() -> Error {
    Error::Numerical { message: "not enough memory for the factor of the matrix".into(), help: Some("use a coarser mesh".into()) }
}

fn analyse(pattern: &Pattern, ordering: SymmetricOrdering<'_, u32>) -> Result<SymbolicCholesky<u32>> {
    let n = pattern.len();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &pattern.column_start, None, &pattern.row);
    let parameters =
        CholeskySymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
    factorize_symbolic_cholesky(matrix, Side::Lower, ordering, parameters).map_err(|_| out_of_memory())
}

/// Symbolic analysis, factor values and work space of one pattern.
pub struct Cholesky {
    symbolic: SymbolicCholesky<u32>,
    /// None for a matrix that is too small to have them, which faer factorises row by row.
    fronts: Option<Fronts>,
    values: Vec<f64>,
    work: MemBuffer,
    /// Largest absolute value in each column of the matrix last factorised: the scale that a pivot is zero against.
    scale: Vec<f64>,
}

impl Cholesky {
    /// Analyses a pattern: approximate minimum degree ordering and supernodes. Errors: out of memory.
    pub fn new(pattern: &Pattern) -> Result<Self> {
        Self::prepare(pattern, analyse(pattern, SymmetricOrdering::Amd)?)
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
        let order = PermRef::new_checked(&forward, &inverse, pattern.len());
        Self::prepare(pattern, analyse(pattern, SymmetricOrdering::Custom(order))?)
    }

    /// Makes room for the factor.
    fn prepare(pattern: &Pattern, symbolic: SymbolicCholesky<u32>) -> Result<Self> {
        let request = symbolic
            .solve_in_place_scratch::<f64>(1, Par::Seq)
            .or(symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default()));
        let work = MemBuffer::try_new(request).map_err(|_| out_of_memory())?;
        let fronts = match symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(supernodes) => {
                Some(Fronts::new(supernodes, pattern, symbolic.perm().map(|order| order.arrays().1)))
            }
            SymbolicCholeskyRaw::Simplicial(_) => None,
        };
        let values = vec![0.0; symbolic.len_val()];
        if let Some(fronts) = &fronts {
            let threads = if fronts.is_shared() { rayon::current_num_threads() } else { 1 };
            log::debug!("factor of {} numbers in {:.1e} multiplications; threads: {threads}", values.len(), fronts.work());
        }
        Ok(Cholesky { fronts, values, work, scale: vec![0.0; symbolic.nrows()], symbolic })
    }

    /// Whether several threads share a factorisation, which changes no bit of it.
    pub fn is_shared(&self) -> bool {
        self.fronts.as_ref().is_some_and(Fronts::is_shared)
    }

    /// Factorises `matrix`, the values of the pattern, into the memory of the last factorisation.
    pub fn refactor(&mut self, pattern: &Pattern, matrix: &[f64], kind: Kind) -> Result<Refactored, Pivot> {
        let unknown = |index: usize| self.symbolic.perm().map_or(index, |order| order.arrays().0[index] as usize);
        if let Some(fronts) = &self.fronts {
            fronts
                .factorize(matrix, &mut self.values, kind == Kind::Llt)
                .map_err(|index| Pivot { unknown: unknown(index), zero: kind == Kind::Ldlt })?;
        } else if !pattern.is_empty() {
            let n = pattern.len();
            let rows = SymbolicSparseColMatRef::new_checked(n, n, &pattern.column_start, None, &pattern.row);
            let stack = MemStack::new(&mut self.work);
            self.symbolic
                .factorize_numeric_ldlt(
                    &mut self.values,
                    SparseColMatRef::new(rows, matrix),
                    Side::Lower,
                    LdltRegularization::default(),
                    Par::Seq,
                    stack,
                    Spec::default(),
                )
                .map_err(|LdltError::ZeroPivot { index }| Pivot { unknown: unknown(index.saturating_sub(1)), zero: kind == Kind::Ldlt })?;
            let mut bad = None;
            self.each_pivot(|index, d| {
                if !(d > 0.0) {
                    bad.get_or_insert(index);
                }
            });
            if let Some(index) = bad.filter(|_| kind == Kind::Llt) {
                return Err(Pivot { unknown: unknown(index), zero: false });
            }
        }
        if kind == Kind::Llt {
            return Ok(Refactored { negative_pivots: 0, smallest: 1.0, softest: 0, is_vanishing: false });
        }
        self.scale.fill(0.0);
        for j in 0..pattern.len() {
            for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
                let (i, v) = (pattern.row[k] as usize, matrix[k].abs());
                self.scale[i] = self.scale[i].max(v);
                self.scale[j] = self.scale[j].max(v);
            }
        }
        let (mut negative_pivots, mut smallest, mut softest) = (0, 1.0f64, 0);
        let (mut singular, mut is_vanishing) = (None, false);
        self.each_pivot(|index, d| {
            negative_pivots += usize::from(d < 0.0);
            let u = unknown(index);
            let share = d.abs() / matrix[pattern.column_start[u] as usize].abs();
            if share < smallest {
                (smallest, softest) = (share, u);
            }
            if !(d.is_finite() && d != 0.0) {
                singular.get_or_insert(Pivot { unknown: u, zero: d.is_finite() });
            }
            // Round-off leaves about eps of the row's scale where a mechanism's pivot should be zero.
            is_vanishing |= d.abs() <= 16.0 * f64::EPSILON * self.scale[u];
        });
        singular.map_or(Ok(Refactored { negative_pivots, smallest, softest, is_vanishing }), Err)
    }

    /// Shows each pivot of the last factorisation, in the order of elimination.
    fn each_pivot(&self, mut visit: impl FnMut(usize, f64)) {
        match (&self.fronts, self.symbolic.raw()) {
            (Some(fronts), _) => fronts.each_pivot(&self.values, visit),
            (None, SymbolicCholeskyRaw::Simplicial(s)) => (0..s.nrows()).for_each(|j| visit(j, self.values[s.col_ptr()[j] as usize])),
            (None, SymbolicCholeskyRaw::Supernodal(_)) => {}
        }
    }

    /// Solves with the last factorisation, in place. `x`: right-hand side, then solution, over the free unknowns.
    pub fn solve(&mut self, x: &mut [f64]) {
        let n = x.len();
        let stack = MemStack::new(&mut self.work);
        let rhs = MatMut::from_column_major_slice_mut(x, n, 1);
        LdltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack);
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

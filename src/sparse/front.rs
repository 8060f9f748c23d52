//! The dense part of a sparse factorisation: a few columns of a front are eliminated, what they do to its other rows is left behind.
//!
//! All matrices are lower triangles of symmetric ones in columns. Small updates are made in tiles that stay in registers, large ones by faer's
//! products. Every number is the result of the same operations in the same order whatever the place of the memory.

use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular};
use faer::{Accum, MatMut, MatRef, Par};
use pulp::Simd;

/// Columns that are eliminated together.
const BLOCK: usize = 24;

/// Columns of an update that make faer's product worth its set-up, and multiplications an entry.
const LARGE: (usize, usize) = (96, 16);

/// Columns of a tile.
const WIDE: usize = 4;

/// A front: `rows` rows, of which the first `columns` are eliminated.
pub struct Front<'a> {
    pub rows: usize,
    pub columns: usize,
    /// The first columns, `rows` entries each. In: the assembled matrix. Out: `D` on the diagonal, `L` below.
    pub panel: &'a mut [f64],
    /// The other columns and rows, `rows - columns` each.
    pub rest: &'a mut [f64],
    /// Room for as many numbers as `panel`, which may be any at the start.
    pub work: &'a mut [f64],
}

/// Eliminates; the first column whose pivot is zero, not finite or, where it has to be `positive`, is not, as an error.
pub fn eliminate(front: Front<'_>, positive: bool) -> Result<(), usize> {
    pulp::Arch::new().dispatch(Elimination { front, positive })
}

struct Elimination<'a> {
    front: Front<'a>,
    positive: bool,
}

impl pulp::WithSimd for Elimination<'_> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<(), usize> {
        let Elimination { front: Front { rows: n, columns: c, panel, rest, work }, positive } = self;
        // `work` becomes L D beside L, below the diagonal.
        for start in (0..c).step_by(BLOCK) {
            let end = (start + BLOCK).min(c);
            for j in start..end {
                let (before, column) = panel.split_at_mut(n * j);
                let column = &mut column[j..n];
                subtract_columns(simd, column, &before[n * start..], &work[n * start..], n, j);
                let pivot = column[0];
                if !(pivot.is_finite() && pivot != 0.0) || positive && pivot < 0.0 {
                    return Err(j);
                }
                work[n * j + j..n * j + n].copy_from_slice(column);
                let inverse = 1.0 / pivot;
                column[1..].iter_mut().for_each(|v| *v *= inverse);
            }
            if end < c {
                let (done, ahead) = panel.split_at_mut(n * end);
                let (l, w) = (&done[n * start..], &work[n * start..n * end]);
                subtract_product(simd, &mut ahead[end..], n, (l, w, n), end..n, c - end);
            }
        }
        if n > c && c > 0 {
            subtract_product(simd, rest, n - c, (panel, work, n), c..n, n - c);
        }
        Ok(())
    }
}

/// `y -= sum_k l_k w_k[j]` over the columns that `l` has; `y`: rows from `j` on.
#[inline(always)]
fn subtract_columns<S: Simd>(simd: S, y: &mut [f64], l: &[f64], w: &[f64], n: usize, j: usize) {
    let mut columns = l.chunks_exact(n).zip(w.chunks_exact(n)).map(|(l, w)| (&l[j..], w[j]));
    let (head, tail) = S::as_mut_simd_f64s(y);
    let split = head.len() * S::F64_LANES;
    loop {
        let Some((l0, w0)) = columns.next() else { return };
        let (v0, _) = S::as_simd_f64s(&l0[..split]);
        let s0 = simd.splat_f64s(-w0);
        if let Some((l1, w1)) = columns.next() {
            let (v1, _) = S::as_simd_f64s(&l1[..split]);
            let s1 = simd.splat_f64s(-w1);
            for ((y, a), b) in head.iter_mut().zip(v0).zip(v1) {
                *y = simd.mul_add_f64s(*b, s1, simd.mul_add_f64s(*a, s0, *y));
            }
            for ((y, a), b) in tail.iter_mut().zip(&l0[split..]).zip(&l1[split..]) {
                *y = (*b).mul_add(-w1, (*a).mul_add(-w0, *y));
            }
        } else {
            for (y, a) in head.iter_mut().zip(v0) {
                *y = simd.mul_add_f64s(*a, s0, *y);
            }
            for (y, a) in tail.iter_mut().zip(&l0[split..]) {
                *y = (*a).mul_add(-w0, *y);
            }
        }
    }
}

/// Lower triangle of `y -= L W^T`, for the first `columns` columns.
///
/// `y`: rows `rows` of the front, its first column that of the first of them, `stride` entries apart. `(l, w, n)`: columns of `n` entries.
#[inline(always)]
fn subtract_product<S: Simd>(
    simd: S,
    y: &mut [f64],
    stride: usize,
    (l, w, n): (&[f64], &[f64], usize),
    rows: std::ops::Range<usize>,
    columns: usize,
) {
    let (count, depth) = (rows.len(), l.len() / n);
    if columns >= LARGE.0 && depth >= LARGE.1 {
        let left = MatRef::from_column_major_slice_with_stride(&l[rows.start..], count, depth, n);
        let right = MatRef::from_column_major_slice_with_stride(&w[rows.start..], columns, depth, n);
        let target = MatMut::from_column_major_slice_with_stride_mut(y, count, columns, stride);
        let (top, bottom) = target.split_at_row_mut(columns);
        let full = BlockStructure::Rectangular;
        let (left_top, left_bottom) = left.split_at_row(columns);
        triangular(top, BlockStructure::TriangularLower, Accum::Add, left_top, full, right.transpose(), full, -1.0, Par::Seq);
        faer::linalg::matmul::matmul(bottom, Accum::Add, left_bottom, right.transpose(), -1.0, Par::Seq);
        return;
    }
    let lanes = S::F64_LANES;
    let mut j = 0;
    while j < columns {
        let wide = WIDE.min(columns - j);
        // Rows above the diagonal that a tile covers are never read.
        let mut i = j;
        while i < count {
            let high = (2 * lanes).min(count - i);
            let at = |k: usize| (&l[n * k + rows.start + i..][..high], &w[n * k + rows.start + j..][..wide]);
            let first = j * stride + i;
            match (wide, high == 2 * lanes) {
                (4, true) => tile::<S, 4, true>(simd, y, first, stride, depth, at),
                (4, false) => tile::<S, 4, false>(simd, y, first, stride, depth, at),
                (3, true) => tile::<S, 3, true>(simd, y, first, stride, depth, at),
                (3, false) => tile::<S, 3, false>(simd, y, first, stride, depth, at),
                (2, true) => tile::<S, 2, true>(simd, y, first, stride, depth, at),
                (2, false) => tile::<S, 2, false>(simd, y, first, stride, depth, at),
                (_, true) => tile::<S, 1, true>(simd, y, first, stride, depth, at),
                (_, false) => tile::<S, 1, false>(simd, y, first, stride, depth, at),
            }
            i += high;
        }
        j += wide;
    }
}

/// One tile of [`subtract_product`] in registers, of two vectors or fewer rows (not `FULL`). `at`: rows of `L` and of `W` of a column.
#[inline(always)]
fn tile<'a, S: Simd, const W: usize, const FULL: bool>(
    simd: S,
    y: &mut [f64],
    first: usize,
    stride: usize,
    depth: usize,
    at: impl Fn(usize) -> (&'a [f64], &'a [f64]),
) {
    let lanes = S::F64_LANES;
    let mut high = 2 * lanes;
    let mut sums = [[simd.splat_f64s(0.0); 2]; W];
    for k in 0..depth {
        let (l, w) = at(k);
        high = l.len();
        let [low, up] = if FULL {
            let (l, _) = S::as_simd_f64s(l);
            [l[0], l[1]]
        } else {
            let (low, up) = l.split_at(lanes.min(high));
            [simd.partial_load_f64s(low), simd.partial_load_f64s(up)]
        };
        for (sum, w) in sums.iter_mut().zip(w) {
            let w = simd.splat_f64s(*w);
            sum[0] = simd.mul_add_f64s(low, w, sum[0]);
            sum[1] = simd.mul_add_f64s(up, w, sum[1]);
        }
    }
    for (b, sum) in sums.iter().enumerate() {
        let target = &mut y[first + b * stride..][..high];
        if FULL {
            let (target, _) = S::as_mut_simd_f64s(target);
            target.iter_mut().zip(sum).for_each(|(y, s)| *y = simd.sub_f64s(*y, *s));
        } else {
            let (low, up) = target.split_at_mut(lanes.min(high));
            for (part, sum) in [low, up].into_iter().zip(sum) {
                let y = simd.partial_load_f64s(part);
                simd.partial_store_f64s(part, simd.sub_f64s(y, *sum));
            }
        }
    }
}

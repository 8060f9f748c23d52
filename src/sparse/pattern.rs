//! Which entries a symmetric matrix has, and where an element's entries go.

use crate::error::{Error, Result};

/// Marks an unknown that is held, or absent from a stencil.
pub const HELD: u32 = u32::MAX;

/// Shows every stencil, the unknowns of one element, to its argument.
pub type ShowStencils<'a> = dyn FnMut(&mut dyn FnMut(&[usize])) + 'a;

/// Numbers of the free unknowns.
#[derive(Clone, Debug)]
pub struct Numbering {
    /// Free number of each unknown, or [`HELD`].
    number: Vec<u32>,
    /// Unknown of each free number.
    unknown: Vec<u32>,
}

impl Numbering {
    /// Numbers the unknowns that are not `held`, in order.
    pub fn new(held: &[bool]) -> Self {
        let mut numbering = Numbering { number: vec![HELD; held.len()], unknown: Vec::new() };
        for (i, _) in held.iter().enumerate().filter(|(_, held)| !**held) {
            numbering.number[i] = numbering.unknown.len() as u32;
            numbering.unknown.push(i as u32);
        }
        numbering
    }

    /// Number of free unknowns.
    pub fn free(&self) -> usize {
        self.unknown.len()
    }

    /// Number of all unknowns.
    pub fn all(&self) -> usize {
        self.number.len()
    }

    /// Free number of an unknown, or [`HELD`]; an absent unknown (`usize::MAX`) counts as held.
    pub fn of(&self, unknown: usize) -> u32 {
        self.number.get(unknown).copied().unwrap_or(HELD)
    }

    /// Unknown of each free number.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknown
    }
}

/// Lower triangle of a symmetric matrix in compressed columns.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// First entry of each column, and the number of entries at the end.
    pub column_start: Vec<u32>,
    /// Row of each entry, ascending in each column; the diagonal comes first.
    pub row: Vec<u32>,
}

impl Pattern {
    /// Union of the couplings of all `stencils`.
    ///
    /// Every free unknown gets a diagonal entry. Errors: more than 2^32 entries.
    pub fn new(numbering: &Numbering, stencils: &mut ShowStencils) -> Result<Self> {
        let n = numbering.free();
        // Two passes over the couplings bucket the rows by column without a pair list of the whole matrix.
        let mut start = vec![0usize; n + 1];
        let mut each = |f: &mut dyn FnMut(u32, u32)| {
            stencils(&mut |stencil: &[usize]| {
                for (i, &a) in stencil.iter().enumerate() {
                    let a = numbering.of(a);
                    if a == HELD {
                        continue;
                    }
                    for &b in &stencil[..i] {
                        let b = numbering.of(b);
                        if b != HELD && b != a {
                            f(a.min(b), a.max(b));
                        }
                    }
                }
            });
        };
        each(&mut |column, _| start[column as usize + 1] += 1);
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut rows = vec![0u32; start[n]];
        let mut next = start.clone();
        each(&mut |column, row| {
            rows[next[column as usize]] = row;
            next[column as usize] += 1;
        });
        let (mut column_start, mut row) = (Vec::with_capacity(n + 1), Vec::with_capacity(n + rows.len() / 2));
        column_start.push(0);
        for j in 0..n {
            row.push(j as u32);
            let column = &mut rows[start[j]..start[j + 1]];
            column.sort_unstable();
            let mut last = j as u32;
            for &r in column.iter().filter(|r| std::mem::replace(&mut last, **r) != **r) {
                row.push(r);
            }
            column_start
                .push(u32::try_from(row.len()).map_err(|_| Error::input("mesh", "too many unknowns: more than 2^32 matrix entries"))?);
        }
        row.shrink_to_fit();
        Ok(Pattern { column_start, row })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Place of entry (row, column), row >= column.
    fn slot(&self, row: u32, column: u32) -> u32 {
        let (from, to) = (self.column_start[column as usize] as usize, self.column_start[column as usize + 1] as usize);
        match self.row[from..to].binary_search(&row) {
            Ok(i) => (from + i) as u32,
            Err(_) => unreachable!("a stencil that was not declared"),
        }
    }
}

/// Matrix values, gradient and the increments of held unknowns: what potentials add into.
#[derive(Clone, Debug)]
pub struct System {
    /// Values of the entries of a [`Pattern`].
    pub matrix: Vec<f64>,
    /// Gradient over the free unknowns.
    pub gradient: Vec<f64>,
    /// Increments of held unknowns (over all unknowns) whose effect `H dx` is added to the gradient, if any moves.
    pub prescribed: Option<Vec<f64>>,
}

impl System {
    /// A zero system over a pattern.
    pub fn new(pattern: &Pattern) -> Self {
        System { matrix: vec![0.0; pattern.row.len()], gradient: vec![0.0; pattern.len()], prescribed: None }
    }

    /// Sets matrix and gradient to zero.
    pub fn clear(&mut self) {
        self.matrix.fill(0.0);
        self.gradient.fill(0.0);
    }
}

/// Where the entries of elements with `N` unknowns each go.
#[derive(Clone, Debug)]
pub struct Scatter<const N: usize> {
    /// Unknowns of each element over all unknowns; [`HELD`] where a stencil has none.
    unknowns: Vec<[u32; N]>,
    /// Free numbers of the same.
    numbers: Vec<[u32; N]>,
    /// Slot of each entry of the lower triangle, row by row, element by element.
    slots: Vec<u32>,
}

impl<const N: usize> Scatter<N> {
    const ENTRIES: usize = N * (N + 1) / 2;

    /// Looks up the slots of all elements once. `stencils`: unknowns of each element; `usize::MAX` for none.
    pub fn new(stencils: impl Iterator<Item = [usize; N]>, numbering: &Numbering, pattern: &Pattern) -> Self {
        let mut scatter = Scatter { unknowns: Vec::new(), numbers: Vec::new(), slots: Vec::new() };
        for stencil in stencils {
            let numbers = stencil.map(|u| numbering.of(u));
            scatter.unknowns.push(stencil.map(|u| u32::try_from(u).unwrap_or(HELD)));
            scatter.numbers.push(numbers);
            for i in 0..N {
                for j in 0..=i {
                    let (a, b) = (numbers[i], numbers[j]);
                    let slot = if a == HELD || b == HELD { HELD } else { pattern.slot(a.max(b), a.min(b)) };
                    scatter.slots.push(slot);
                }
            }
        }
        scatter.slots.shrink_to_fit();
        scatter
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.unknowns.len()
    }

    /// Values of one element's unknowns; 0 where the stencil has none.
    #[inline(always)]
    pub fn gather(&self, element: usize, x: &[f64]) -> [f64; N] {
        self.unknowns[element].map(|u| if u == HELD { 0.0 } else { x[u as usize] })
    }

    /// Adds one element's gradient.
    #[inline(always)]
    pub fn add_gradient(&self, element: usize, gradient: &[f64; N], into: &mut System) {
        for (&number, g) in self.numbers[element].iter().zip(gradient) {
            if number != HELD {
                into.gradient[number as usize] += g;
            }
        }
    }

    /// Adds one element's Hessian (its lower triangle is read) and, where held unknowns move, its effect on the gradient.
    #[inline(always)]
    pub fn add_hessian(&self, element: usize, hessian: &[[f64; N]; N], into: &mut System) {
        let slots = &self.slots[element * Self::ENTRIES..(element + 1) * Self::ENTRIES];
        let mut k = 0;
        for (i, row) in hessian.iter().enumerate() {
            for h in &row[..=i] {
                let slot = slots[k];
                k += 1;
                if slot != HELD {
                    into.matrix[slot as usize] += h;
                }
            }
        }
        // Two local unknowns may be one global unknown only on the diagonal of a closed stencil; meshes exclude that.
        let Some(prescribed) = &into.prescribed else { return };
        for j in 0..N {
            if self.numbers[element][j] != HELD || self.unknowns[element][j] == HELD {
                continue;
            }
            let dx = prescribed[self.unknowns[element][j] as usize];
            if dx == 0.0 {
                continue;
            }
            for i in 0..N {
                let number = self.numbers[element][i];
                if number != HELD {
                    into.gradient[number as usize] += hessian[i.max(j)][i.min(j)] * dx;
                }
            }
        }
    }
}

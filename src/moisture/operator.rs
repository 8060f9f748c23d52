//! Stiffness and mass of all prisms, on one pattern.
//!
//! Every matrix here is kept as its entries off the diagonal and its row sums. A product is then a sum of exchanges between pairs of
//! unknowns, `a_ij (x_j - x_i)`, which what one loses the other gains to the last bit, and which vanish where `x` is constant.

use super::slab::{Mass, Slab};
use crate::error::{Error, Result};
use crate::sparse::{Cholesky, Numbering, Pattern, Scatter, System};

/// Barycentric gradients of a face.
const GRADIENTS: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

/// Matrices of a slab.
pub(super) struct Operator {
    /// Lower triangle.
    pub pattern: Pattern,
    /// The same over vertices.
    sheet: Pattern,
    /// Stiffness off the diagonal [m3/s]; its rows add up to 0. Entries of the diagonal are 0.
    stiffness: Vec<f64>,
    /// Mass off the diagonal [m3], if there is any.
    mass: Option<Vec<f64>>,
    /// Row sums of the mass: the volume that each unknown stands for [m3].
    pub volume: Vec<f64>,
}

/// Diagonal and upper neighbour of a tridiagonal matrix.
struct Line {
    diagonal: Vec<f64>,
    next: Vec<f64>,
}

impl Line {
    /// From the 2x2 matrices of the layers; `f` gets the height fraction of a layer and returns its diagonal and its other entry.
    fn new(levels: &[f64], f: impl Fn(f64) -> [f64; 2]) -> Self {
        let mut line = Line { diagonal: vec![0.0; levels.len()], next: vec![0.0; levels.len() - 1] };
        for (l, pair) in levels.windows(2).enumerate() {
            let [own, other] = f(pair[1] - pair[0]);
            line.diagonal[l] += own;
            line.diagonal[l + 1] += own;
            line.next[l] = other;
        }
        line
    }

    fn at(&self, l: usize, m: usize) -> f64 {
        if l == m { self.diagonal[l] } else { self.next[l.min(m)] }
    }
}

/// Part of the height that each level stands for.
pub(super) fn shares(levels: &[f64]) -> Vec<f64> {
    Line::new(levels, |height| [0.5 * height, 0.0]).diagonal
}

impl Operator {
    /// Integrates over all prisms. Errors: too many unknowns.
    pub fn new(slab: &Slab, kind: Mass) -> Result<Self> {
        let numbering = Numbering::new(&vec![false; slab.vertices]);
        let sheet = Pattern::new(&numbering, &mut |show| slab.faces.iter().for_each(|face| show(face)))?;
        let scatter = Scatter::new(slab.faces.iter().copied(), &numbering, &sheet);
        let assemble = |block: &dyn Fn(usize) -> [[f64; 3]; 3]| {
            let mut system = System::new(&sheet);
            (0..slab.faces.len()).for_each(|f| scatter.add_hessian(f, &block(f), &mut system));
            system.matrix
        };
        let lumped = kind == Mass::Lumped;
        let triangle = |f: usize, factor: f64| -> [[f64; 3]; 3] {
            let mass = factor * slab.area(f);
            let (own, other) = if lumped { (mass / 3.0, 0.0) } else { (mass / 6.0, mass / 12.0) };
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { own } else { other }))
        };
        // Three matrices over the vertices and two over the levels; the slab's are their products.
        let along = assemble(&|f| {
            let [d11, d12, d22] = slab.in_plane[f];
            let factor = slab.area(f) * slab.thickness[f];
            let product = |a: [f64; 2], b: [f64; 2]| d11 * a[0] * b[0] + d12 * (a[0] * b[1] + a[1] * b[0]) + d22 * a[1] * b[1];
            GRADIENTS.map(|a| GRADIENTS.map(|b| factor * product(a, b)))
        });
        let across = assemble(&|f| triangle(f, slab.through[f] / slab.thickness[f]));
        let weight = assemble(&|f| triangle(f, slab.thickness[f]));
        let line_mass = Line::new(&slab.levels, |height| if lumped { [0.5 * height, 0.0] } else { [height / 3.0, height / 6.0] });
        let line_stiffness = Line::new(&slab.levels, |height| [1.0 / height, -1.0 / height]);

        let levels = slab.levels.len();
        // Upwards, or to the levels about that of a neighbour.
        let entries = if lumped { 2.0 } else { 4.0 } * sheet.row.len() as f64 * levels as f64;
        if entries >= f64::from(u32::MAX) {
            return Err(Error::input("mesh", "too many levels of moisture: more than 2^32 matrix entries"));
        }
        let mut operator = Operator {
            pattern: Pattern { column_start: vec![0], row: Vec::new() },
            stiffness: Vec::new(),
            mass: (!lumped).then(Vec::new),
            volume: vec![0.0; slab.vertices * levels],
            sheet,
        };
        for v in 0..slab.vertices {
            for l in 0..levels {
                for entry in operator.sheet.column_start[v] as usize..operator.sheet.column_start[v + 1] as usize {
                    let w = operator.sheet.row[entry] as usize;
                    let first = if w == v || lumped { l } else { l.saturating_sub(1) };
                    let last = if w == v || !lumped { (l + 1).min(levels - 1) } else { l };
                    for m in first..=last {
                        let diagonal = w == v && m == l;
                        let (mass, stiffness) = (line_mass.at(l, m), line_stiffness.at(l, m));
                        operator.pattern.row.push((w * levels + m) as u32);
                        operator.stiffness.push(if diagonal { 0.0 } else { along[entry] * mass + across[entry] * stiffness });
                        if let Some(values) = &mut operator.mass {
                            values.push(if diagonal { 0.0 } else { weight[entry] * mass });
                        }
                    }
                }
                operator.pattern.column_start.push(operator.pattern.row.len() as u32);
            }
        }
        let shares = shares(&slab.levels);
        for (f, face) in slab.faces.iter().enumerate() {
            let third = slab.area(f) * slab.thickness[f] / 3.0;
            for v in face {
                operator.volume[v * levels..(v + 1) * levels].iter_mut().zip(&shares).for_each(|(volume, share)| *volume += third * share);
            }
        }
        Ok(operator)
    }

    /// Analysis of the pattern, in the order of the columns of unknowns over vertices. Errors: out of memory.
    pub fn analyse(&self) -> Result<Cholesky> {
        Cholesky::of_blocks(&self.pattern, &self.sheet)
    }

    /// Shows entries off the diagonal: slot, row, column.
    #[inline(always)]
    fn pairs(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for (j, ends) in self.pattern.column_start.windows(2).enumerate() {
            for slot in ends[0] as usize + 1..ends[1] as usize {
                visit(slot, self.pattern.row[slot] as usize, j);
            }
        }
    }

    /// Adds `factor` times a matrix without its row sums, times `x`.
    fn add_exchanges(&self, entries: &[f64], factor: f64, x: &[f64], into: &mut [f64]) {
        self.pairs(|slot, i, j| {
            let flow = factor * entries[slot] * (x[j] - x[i]);
            into[i] += flow;
            into[j] -= flow;
        });
    }

    /// Adds `factor K x`.
    pub fn add_stiffness(&self, factor: f64, x: &[f64], into: &mut [f64]) {
        self.add_exchanges(&self.stiffness, factor, x, into);
    }

    /// Adds `factor M x`.
    pub fn add_mass(&self, factor: f64, x: &[f64], into: &mut [f64]) {
        into.iter_mut().zip(&self.volume).zip(x).for_each(|((into, volume), x)| *into += factor * volume * x);
        if let Some(mass) = &self.mass {
            self.add_exchanges(mass, factor, x, into);
        }
    }

    /// Entry of `M + tau K` off the diagonal.
    #[inline(always)]
    fn entry(&self, slot: usize, tau: f64) -> f64 {
        tau * self.stiffness[slot] + self.mass.as_ref().map_or(0.0, |mass| mass[slot])
    }

    /// The matrix `M + tau (K + excess)`, with rows and columns of held unknowns empty but for the diagonal.
    /// `excess`: added to the diagonal [m3/s].
    pub fn matrix(&self, tau: f64, excess: &[f64], held: impl Fn(usize) -> bool, matrix: &mut [f64]) {
        let start = &self.pattern.column_start;
        for (i, (volume, excess)) in self.volume.iter().zip(excess).enumerate() {
            matrix[start[i] as usize] = volume + tau * excess;
        }
        self.pairs(|slot, i, j| {
            let entry = self.entry(slot, tau);
            matrix[slot] = if held(i) || held(j) { 0.0 } else { entry };
            matrix[start[i] as usize] -= entry;
            matrix[start[j] as usize] -= entry;
        });
    }

    /// Adds the rows of `(M + tau K) x` of held unknowns, where `x` is zero on them.
    pub fn add_held_rows(&self, tau: f64, held: impl Fn(usize) -> bool, x: &[f64], into: &mut [f64]) {
        self.pairs(|slot, i, j| match (held(i), held(j)) {
            (true, false) => into[i] += self.entry(slot, tau) * x[j],
            (false, true) => into[j] += self.entry(slot, tau) * x[i],
            _ => {}
        });
    }
}

//! The lowest modes about an equilibrium: vibration, `K v = omega^2 M v`, and linear buckling, `(K_0 + lambda (K_1 - K_0)) v = 0`.
//!
//! `K_0` and `K_1` are the Hessians of two equilibria, without load and under it: linear in the load between them, as linear buckling has it, they
//! include the stiffness of stresses, of following loads and of the first-order change of shape. Sylvester's law of inertia proves that no lower mode was
//! missed: the negative pivots of the matrix just below the highest value found are as many as the values below.
//!
//! The entries of the matrices have the round-off of the stiffness in stretching, and with finer meshes less and less of what bending has is left in them. The
//! vectors bear that; their values are found anew between them, from strains ([`Newton::between`]).

use super::newton::Newton;
use crate::sparse::eigen::{Pair, SelfAdjoint, largest, multiply};
use crate::sparse::{Cholesky, Curvature, Kind, Pattern, Potential, System};
use nalgebra::{DMatrix, SymmetricEigen};

/// Shift of squared frequencies over the largest stiffness of a coordinate per mass: enough to factor a shell that nothing holds.
const SHIFT: f64 = 64.0 * f64::EPSILON;

/// Relative round-off of the entries of a stiffness.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;

/// Vectors of a block, for the first try and for those after it.
const BLOCKS: [usize; 3] = [6, 12, 24];

/// Distance, relative to the highest value, at which lower ones are counted.
const BELOW: f64 = 1e-6;

/// Smallest share of softening, over the largest stiffening by the same load, that counts: strains of order one under a load that stiffens also soften.
const LEAST_SHARE: f64 = 1e-4;

/// A mode over all unknowns.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Squared angular frequency [1/s2], 0 where it is round-off; or factor on the load at which the shell buckles [1].
    pub value: f64,
    /// How much of a squared frequency could be round-off [1/s2]; 0 for a factor.
    pub noise: f64,
    /// Shape over all unknowns, 0 for held ones; its largest coordinate is 1.
    pub vector: Vec<f64>,
}

/// Why modes were not found.
#[derive(Clone, Debug, PartialEq)]
pub enum NoModes {
    /// The matrix is not positive definite at the shift: so many directions are unstable; none where it is singular.
    Unstable(Option<usize>),
    /// The iteration did not settle, or lower modes were missed.
    Unsettled,
    /// No load of this sign makes the shell buckle, up to this factor; without end where the load does not soften it at all.
    Never(f64),
}

/// `C v = theta F v` in the scalar product of `B`, with `F = K + shift D`; the negative pivots of `K + toward u D` count the values below `u`.
struct Problem<'a> {
    /// `K`
    matrix: &'a [f64],
    /// `D`
    direction: &'a [f64],
    shift: f64,
    toward: f64,
    /// `C`
    numerator: &'a [f64],
    /// `B`
    metric: &'a [f64],
}

/// `A = F^-1 C` in the scalar product of `B`.
struct Inverse<'a> {
    pattern: &'a Pattern,
    cholesky: &'a mut Cholesky,
    numerator: &'a [f64],
    metric: &'a [f64],
}

impl SelfAdjoint for Inverse<'_> {
    fn apply(&mut self, v: &[f64]) -> Vec<f64> {
        let mut y = multiply(self.pattern, self.numerator, v);
        self.cholesky.solve(&mut y);
        y
    }

    fn metric(&self, v: &[f64]) -> Vec<f64> {
        multiply(self.pattern, self.metric, v)
    }
}

impl Newton {
    /// The exact Hessian of the sum of `potentials` at `x`, by the entries of the pattern.
    pub fn hessian(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64]) -> Vec<f64> {
        potentials.iter_mut().for_each(|p| {
            p.prepare(x);
            p.restart(x);
        });
        self.assemble(potentials, x, Curvature::Mixed);
        self.system.matrix.clone()
    }

    /// `v_i.H v_j` between modes, `H` the exact Hessian of the sum of `potentials` at `x`. Its part of the material is formed from the strains of the
    /// modes, so that its round-off is squared.
    pub fn between(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64], modes: &[Mode]) -> DMatrix<f64> {
        potentials.iter_mut().for_each(|p| {
            p.prepare(x);
            p.restart(x);
        });
        self.assemble(potentials, x, Curvature::Geometric);
        let still = vec![0.0; x.len()];
        let vectors: Vec<Vec<f64>> = modes.iter().map(|mode| self.free_part(&mode.vector)).collect();
        let mut between = DMatrix::zeros(modes.len(), modes.len());
        for (j, v) in vectors.iter().enumerate() {
            let forces = self.apply(potentials, x, v, &still);
            for (i, u) in vectors.iter().enumerate() {
                between[(i, j)] = u.iter().zip(&forces).map(|(u, f)| u * f).sum();
            }
        }
        (&between + between.transpose()) * 0.5
    }

    /// The free unknowns of a vector over all.
    fn free_part(&self, vector: &[f64]) -> Vec<f64> {
        self.numbering.unknowns().iter().map(|unknown| vector[*unknown as usize]).collect()
    }

    /// Squared frequencies anew from the stiffness and the matrix `mass` between the modes.
    pub fn settle_vibration(&self, modes: &mut [Mode], stiffness: DMatrix<f64>, mass: &[f64]) {
        let vectors: Vec<Vec<f64>> = modes.iter().map(|mode| self.free_part(&mode.vector)).collect();
        let images: Vec<Vec<f64>> = vectors.iter().map(|v| multiply(&self.pattern, mass, v)).collect();
        let inertia = DMatrix::from_fn(modes.len(), modes.len(), |i, j| vectors[i].iter().zip(&images[j]).map(|(u, m)| u * m).sum());
        let Some(values) = ritz(stiffness, inertia) else { return };
        for (mode, value) in modes.iter_mut().zip(values) {
            // An error of the vector counts by its square; what is round-off as a whole stays so.
            let noise = mode.noise * (mode.noise / value.abs()).min(1.0);
            (mode.value, mode.noise) = (if value.abs() <= noise { 0.0 } else { value }, noise);
        }
    }

    /// The matrix of another potential, whose couplings are among those of this one, at `x`.
    pub fn matrix_of(&self, potential: &mut dyn Potential, x: &[f64]) -> Vec<f64> {
        potential.bind(&self.numbering, &self.pattern);
        let mut system = System::new(&self.pattern);
        potential.assemble(x, Curvature::Mixed, &mut system);
        system.matrix
    }

    /// The `count` lowest modes of vibration, ascending; fewer where there are no more. `shift` [1/s2]: added to the squared frequencies, so that
    /// the matrix is positive definite; by default just above round-off, and as much more as an unstable equilibrium needs.
    pub fn vibration(&mut self, stiffness: &[f64], mass: &[f64], count: usize, shift: Option<f64>) -> Result<Vec<Mode>, NoModes> {
        let heavy = self.pattern.column_start[..self.pattern.len()].iter().map(|slot| *slot as usize).filter(|slot| mass[*slot] > 0.0);
        let stiffest = heavy.map(|slot| stiffness[slot].abs() / mass[slot]).fold(0.0, f64::max);
        let least = SHIFT * stiffest;
        if !(least > 0.0) {
            return Ok(Vec::new());
        }
        let mut sigma = shift.unwrap_or(least);
        loop {
            match self.factor(stiffness, sigma, mass) {
                Some(0) => break,
                negative if shift.is_some() => return Err(NoModes::Unstable(negative)),
                negative if !(sigma < 4.0 * stiffest) => return Err(NoModes::Unstable(negative)),
                _ => sigma *= 8.0,
            }
        }
        let value = |theta: f64| 1.0 / theta - sigma;
        let problem = Problem { matrix: stiffness, direction: mass, shift: sigma, toward: -1.0, numerator: mass, metric: mass };
        let (pairs, _) = self.lowest_pairs(&problem, count, value, 0.0)?;
        let mode = |pair: Pair| {
            let [size, noise] = quotient(&self.pattern, stiffness, mass, &pair.vector);
            self.mode(if size.abs() <= noise { 0.0 } else { size }, noise, &pair.vector)
        };
        let mut modes: Vec<Mode> = pairs.into_iter().map(mode).collect();
        modes.sort_by(|a, b| a.value.total_cmp(&b.value));
        Ok(modes)
    }

    /// The `count` lowest positive factors on the load at which the shell buckles, ascending; fewer where there are no more. `start`, `end`:
    /// Hessians without load and under it. `shift`: a factor, >= 0, at which the shell is still stable; the nearer to the lowest, the
    /// faster.
    pub fn buckling(&mut self, start: &[f64], end: &[f64], count: usize, shift: f64) -> Result<Vec<Mode>, NoModes> {
        let change: Vec<f64> = start.iter().zip(end).map(|(a, b)| b - a).collect();
        match self.factor(start, shift, &change) {
            Some(0) => {}
            negative => return Err(NoModes::Unstable(negative)),
        }
        let softening: Vec<f64> = change.iter().map(|d| -d).collect();
        let (mut shift, mut upper, mut floor) = (shift, 1.0, LEAST_SHARE);
        loop {
            // Where it buckles below this factor there is something to be found, however much the load stiffens other directions: from nearer to it
            // those are far away.
            if shift < upper && self.factor(start, upper, &change).is_none_or(|negative| negative > 0) {
                let mut share = 0.5;
                while share > f64::EPSILON && self.factor(start, shift + share * (upper - shift), &change) != Some(0) {
                    share *= 0.5;
                }
                (shift, floor) = (shift + share * (upper - shift), 0.0);
            }
            let metric: Vec<f64> = start.iter().zip(&change).map(|(a, d)| a + shift * d).collect();
            let value = |theta: f64| shift + 1.0 / theta;
            let problem = Problem { matrix: start, direction: &change, shift, toward: 1.0, numerator: &softening, metric: &metric };
            let (pairs, least) = self.lowest_pairs(&problem, count, value, floor)?;
            if !pairs.is_empty() {
                return Ok(pairs.into_iter().map(|p| self.mode(value(p.value), 0.0, &p.vector)).collect());
            }
            if !(least > 0.0) || upper == value(least) {
                return Err(NoModes::Never(if least > 0.0 { upper } else { f64::INFINITY }));
            }
            upper = value(least);
        }
    }

    /// The pairs with the largest `theta`, above `floor` times the size of the smallest where that is negative, and that bound. `value`: of the problem,
    /// by `theta`, ascending where `theta` descends.
    fn lowest_pairs(
        &mut self,
        problem: &Problem,
        count: usize,
        value: impl Fn(f64) -> f64,
        floor: f64,
    ) -> Result<(Vec<Pair>, f64), NoModes> {
        for block in BLOCKS {
            self.factor(problem.matrix, problem.shift, problem.direction);
            let mut operator =
                Inverse { pattern: &self.pattern, cholesky: &mut self.cholesky, numerator: problem.numerator, metric: problem.metric };
            let Some(found) = largest(&mut operator, self.pattern.len(), count, block, floor) else { continue };
            let least = found.least;
            let pairs: Vec<Pair> = found.pairs.into_iter().filter(|p| p.value > 0.0).collect();
            let values: Vec<f64> = pairs.iter().map(|p| value(p.value)).collect();
            // Values that are round-off have no side on which they lie.
            let [_, noise] = pairs.last().map_or([0.0; 2], |last| quotient(&self.pattern, problem.matrix, problem.metric, &last.vector));
            let Some(highest) = values.last().filter(|v| v.abs() > noise) else { return Ok((pairs, least)) };
            let bound = highest - BELOW * highest.abs();
            let expected = values.iter().filter(|v| **v < bound).count();
            match self.factor(problem.matrix, problem.toward * bound, problem.direction) {
                Some(negative) if negative != expected => {
                    log::debug!("{negative} values lie below {bound:e}, of which {expected} were found");
                }
                _ => return Ok((pairs, least)),
            }
        }
        Err(NoModes::Unsettled)
    }

    /// Factors `matrix + s direction`; its negative pivots, or none where it is singular.
    fn factor(&mut self, matrix: &[f64], s: f64, direction: &[f64]) -> Option<usize> {
        let sums = matrix.iter().zip(direction).map(|(a, d)| a + s * d);
        self.system.matrix.iter_mut().zip(sums).for_each(|(to, sum)| *to = sum);
        self.cholesky
            .refactor(&self.pattern, &self.system.matrix, Kind::Ldlt)
            .ok()
            .filter(|done| !done.is_vanishing)
            .map(|done| done.negative_pivots)
    }

    /// A vector over the free unknowns as a mode: its largest coordinate is 1, and the first that is half as large positive.
    fn mode(&self, value: f64, noise: f64, free: &[f64]) -> Mode {
        let mut vector = vec![0.0; self.numbering.all()];
        free.iter().zip(self.numbering.unknowns()).for_each(|(v, unknown)| vector[*unknown as usize] = *v);
        let lengths = &vector[..self.settings.lengths];
        let size = lengths.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        // Modes of equal size at several places must not hang on the last digit.
        let sign = lengths.iter().find(|v| v.abs() > 0.5 * size).map_or(1.0, |v| v.signum());
        if size > 0.0 {
            vector.iter_mut().for_each(|v| *v *= sign / size);
        }
        Mode { value, noise, vector }
    }
}

impl Mode {
    /// Factors on the load anew from the stiffness between the modes without load and under it.
    pub fn settle_buckling(modes: &mut [Mode], start: &DMatrix<f64>, end: &DMatrix<f64>, shift: f64) {
        let change = end - start;
        let Some(shares) = ritz(-&change, start + change * shift) else { return };
        if shares.iter().all(|share| *share > 0.0) {
            modes.iter_mut().zip(shares.iter().rev()).for_each(|(mode, share)| mode.value = shift + 1.0 / share);
        }
    }
}

/// Eigenvalues of `A c = theta B c` for small symmetric matrices, ascending; none where `B` is not positive definite.
fn ritz(a: DMatrix<f64>, b: DMatrix<f64>) -> Option<Vec<f64>> {
    // Modes have the largest coordinate 1, whatever their mass or stiffness.
    let scale: Vec<f64> = (0..b.nrows()).map(|i| b[(i, i)].sqrt().recip()).collect();
    let scaled = |m: DMatrix<f64>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| scale[i] * m[(i, j)] * scale[j]);
    let (a, lower) = (scaled(a), scaled(b).cholesky()?.l());
    let half = lower.solve_lower_triangular(&a)?;
    let whole = lower.solve_lower_triangular(&half.transpose())?;
    let mut values: Vec<f64> = SymmetricEigen::new((&whole + whole.transpose()) * 0.5).eigenvalues.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values.iter().all(|v| v.is_finite()).then_some(values)
}

/// Rayleigh quotient of a vector, and how much of it could be the round-off of the stiffness: what is the stretching of a thin shell drowns its bending
/// only in modes that have both.
fn quotient(pattern: &Pattern, stiffness: &[f64], mass: &[f64], v: &[f64]) -> [f64; 2] {
    let (mut size, mut sizes, mut inertia) = (0.0, 0.0, 0.0);
    for (j, entries) in pattern.column_start.windows(2).take(v.len()).enumerate() {
        for k in entries[0] as usize..entries[1] as usize {
            let i = pattern.row[k] as usize;
            let product = if i == j { v[i] * v[j] } else { 2.0 * v[i] * v[j] };
            size += stiffness[k] * product;
            sizes += (stiffness[k] * product).abs();
            inertia += mass[k] * product;
        }
    }
    [size / inertia, ROUND_OFF * sizes / inertia]
}

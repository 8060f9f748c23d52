//! What round-off makes of energies and movements, measured by what happens as coordinates change in their last digit.
//!
//! A share of their size would not do: strains are differences of much larger numbers. And a mode with next to no stiffness, as the turn of a
//! cylinder about the axis of a disc, is moved further by round-off of the forces than any tolerance. Nothing is solved for here.

use super::newton::Newton;
use crate::sparse::Potential;

/// Trials, each with other changes of the coordinates; as many modes can be told apart.
const TRIALS: u32 = 4;

/// How many times that of the trials may still be round-off.
const MARGIN: f64 = 4.0;

/// Largest movement by round-off, relative to the mesh, that says something of an equilibrium nearby; a folded shell has more.
const NEAR: f64 = 1e-3;

impl Newton {
    /// Puts the coordinates `x` with other last digits into `self.trial`.
    fn shake(&mut self, x: &[f64], trial: u32) {
        self.trial.copy_from_slice(x);
        for &unknown in self.numbering.unknowns().iter().filter(|u| (**u as usize) < self.settings.lengths) {
            let shift = 2.0 * (0.618_034 * (trial * (unknown + 1)) as f64).fract() - 1.0;
            let size = self.settings.diameter.max(x[unknown as usize].abs());
            self.trial[unknown as usize] += 2.0 * shift * f64::EPSILON * size;
        }
    }

    /// Round-off of the energy [J] at `x`.
    pub(super) fn energy_round_off(&mut self, potentials: &[&mut dyn Potential], x: &[f64]) -> f64 {
        let energy = |x: &[f64]| potentials.iter().map(|p| p.energy(x)).sum::<f64>();
        let here = energy(x);
        let mut largest = f64::EPSILON * here.abs();
        for trial in 1..=TRIALS {
            self.shake(x, trial);
            largest = largest.max((energy(&self.trial) - here).abs());
        }
        MARGIN * largest
    }

    /// Takes those parts out of the movement from `x` that round-off of the forces alone may have made: along the directions in which it moves
    /// the shell by about the `tolerance` [m] or further, and no further than that. To be asked after a solution with the matrix at `x`;
    /// no matrix is factorised. Returns how far round-off moves the shell [m]; 0 where the movement is far larger.
    pub(super) fn leave_out_round_off(&mut self, potentials: &[&mut dyn Potential], x: &[f64], tolerance: f64) -> f64 {
        // Free numbers are in the order of unknowns, lengths first. Angles follow their nodes.
        let lengths = self.numbering.unknowns().partition_point(|u| (*u as usize) < self.settings.lengths);
        let size = |v: &[f64]| v[..lengths].iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let product = |u: &[f64], v: &[f64]| u[..lengths].iter().zip(&v[..lengths]).map(|(u, v)| u * v).sum::<f64>();
        let subtract = |from: &mut [f64], share: f64, v: &[f64]| from.iter_mut().zip(v).for_each(|(f, v)| *f -= share * v);
        let mut movement = self.solution.clone();
        let here = self.forces(potentials, x);
        let mut made = Vec::new();
        for trial in 1..=TRIALS {
            self.shake(x, trial);
            let shaken = std::mem::take(&mut self.trial);
            let mut by_round_off = self.forces(potentials, &shaken);
            self.trial = shaken;
            subtract(&mut by_round_off, 1.0, &here);
            self.cholesky.solve(&mut by_round_off);
            let reach = size(&by_round_off);
            if size(&movement) > MARGIN * MARGIN * reach || !(reach <= NEAR * self.settings.diameter) {
                return 0.0;
            }
            made.push(by_round_off);
        }
        let mut directions: Vec<Vec<f64>> = Vec::new();
        for of_trial in &made {
            let mut direction = of_trial.clone();
            directions.iter().for_each(|d| subtract(&mut direction, product(of_trial, d) / product(d, d), d));
            if MARGIN * size(&direction) > tolerance {
                directions.push(direction);
            }
        }
        for direction in &directions {
            let share = |v: &[f64]| product(v, direction) / product(direction, direction);
            let by_round_off = made.iter().map(|v| share(v).abs()).fold(0.0, f64::max);
            let share = share(&movement);
            if share.abs() <= MARGIN * by_round_off {
                subtract(&mut movement, share, direction);
            }
        }
        log::trace!("{} directions in which round-off of the forces moves the shell by {:.1e} m", directions.len(), size(&made[0]));
        for (value, &unknown) in movement.iter().zip(self.numbering.unknowns()) {
            self.dx[unknown as usize] = *value;
        }
        made.iter().map(|v| size(v)).fold(0.0, f64::max)
    }

    /// Gradient of the potentials at `x` over the free unknowns; that of the system stays.
    pub(super) fn forces(&mut self, potentials: &[&mut dyn Potential], x: &[f64]) -> Vec<f64> {
        let zero = vec![0.0; self.system.gradient.len()];
        let kept = std::mem::replace(&mut self.system.gradient, zero);
        potentials.iter().for_each(|p| {
            p.gradient(x, &mut self.system);
        });
        std::mem::replace(&mut self.system.gradient, kept)
    }
}

//! Descent on the energy with a positive semidefinite Hessian and a line search, for where the mixed iteration does not contract. It returns
//! to that iteration near the minimum.

use super::newton::{Failure, Newton, Solved};
use crate::error::Result;
use crate::sparse::{Curvature, Kind, Potential};

/// Iterations in a row without a fall of the energy beyond its round-off after which descent has come as far as it can.
const IDLE: usize = 5;

/// Share of the predicted decrease that a step of the line search must bring.
const ARMIJO: f64 = 1e-4;

impl Newton {
    /// Descent on the energy with a positive semidefinite Hessian, then mixed iterations near the minimum.
    pub(super) fn descend(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64]) -> Result<Solved, Failure> {
        let mut movement = f64::INFINITY;
        let mut polish_below = 1e-2 * self.settings.diameter;
        let mut idle = 0;
        for iteration in 1..=4 * self.settings.max_iterations as u64 {
            let fell;
            (movement, fell) = self.descend_once(potentials, x)?;
            idle = if fell { 0 } else { idle + 1 };
            if !movement.is_finite() || idle > IDLE {
                break;
            }
            if idle == IDLE || movement <= polish_below || movement <= self.settings.tolerance {
                potentials.iter_mut().for_each(|p| {
                    p.prepare(x);
                    p.restart(x);
                    p.save();
                });
                let kept = x.to_vec();
                let kept_energy: f64 = potentials.iter().map(|p| p.energy(x)).sum();
                if let Ok(solved) = self.mixed(potentials, x, &[], self.settings.tolerance) {
                    let reached: f64 = potentials.iter().map(|p| p.energy(x)).sum();
                    if reached <= kept_energy + 1e-9 * kept_energy.abs() {
                        return Ok(Solved { iterations: iteration + solved.iterations, ..solved });
                    }
                }
                x.copy_from_slice(&kept);
                potentials.iter_mut().for_each(|p| p.put_back());
                polish_below = 0.03 * movement;
            }
        }
        Err(Failure::NotContracting(movement))
    }

    /// One iteration of descent; returns the movement [m], and whether the energy fell by more than its round-off.
    pub(super) fn descend_once(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64]) -> Result<(f64, bool), Failure> {
        potentials.iter_mut().for_each(|p| {
            p.prepare(x);
            p.restart(x);
        });
        let energy = self.assemble(potentials, x, Curvature::Projected);
        self.counters.fallback_iterations += 1;
        if !energy.is_finite() {
            return Err(Failure::NotContracting(f64::INFINITY));
        }
        self.solve_shifted()?;
        let slope: f64 = self.solution.iter().zip(&self.system.gradient).map(|(s, g)| s * g).sum();
        let mut fraction = potentials.iter().map(|p| p.max_step(x, &self.dx)).fold(1.0, f64::min);
        // Round-off of the energy hides decreases below this.
        let noise = 1e-14 * energy.abs();
        let fell = loop {
            self.trial.iter_mut().zip(x.iter().zip(&self.dx)).for_each(|(t, (x, d))| *t = x + fraction * d);
            let trial: f64 = potentials.iter().map(|p| p.energy(&self.trial)).sum();
            if trial <= energy + ARMIJO * fraction * slope + noise {
                break energy - trial > noise;
            }
            fraction *= 0.5;
            if !(fraction > 1e-12) {
                return Err(Failure::NotContracting(self.movement()));
            }
        };
        let movement = fraction * self.movement();
        log::trace!("descent: energy {energy:e} J, fraction {fraction}, movement {movement:e} m");
        x.copy_from_slice(&self.trial);
        Ok((movement, fell))
    }

    /// Solves with the projected matrix, shifted by a growing part of its diagonal while it is not positive definite.
    pub(super) fn solve_shifted(&mut self) -> Result<(), Failure> {
        let mut shift = 0.0;
        loop {
            match self.solve_linear(Kind::Llt) {
                Ok(_) if self.dx.iter().all(|d| d.is_finite()) => return Ok(()),
                Err(failure) if shift > 1e-3 => return Err(failure),
                _ if shift > 1e-3 => return Err(Failure::NotContracting(f64::INFINITY)),
                _ => {}
            }
            let next = if shift == 0.0 { 1e-12 } else { 1e3 * shift };
            for j in 0..self.pattern.len() {
                let diagonal = &mut self.system.matrix[self.pattern.column_start[j] as usize];
                *diagonal *= (1.0 + next) / (1.0 + shift);
            }
            shift = next;
        }
    }
}

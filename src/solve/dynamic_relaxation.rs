//! Dynamic relaxation: equilibrium as the rest of a damped motion in a time without meaning, without any factorisation (Underwood,
//! *Computational Methods for Transient Analysis*, 1983; Oakley and Knight, Comput. Methods Appl. Mech. Eng. 126, 1995).
//!
//! The motion is explicit, by central differences with steps of 1. Masses are diagonal: a quarter of the sum of the absolute entries of each
//! row of the stiffness, by which no frequency is beyond what such steps bear (Gershgorin), with a margin for the change of the stiffness until
//! it is assembled anew. Damping is twice the lowest frequency, by the Rayleigh quotient of the last movement. Angles of directors move as
//! coordinates do. It takes about as many iterations as the root of the condition number, so thin shells on fine meshes take many; what it
//! finds is a minimum wherever that is.

use super::newton::{Failure, Newton, Solved};
use crate::sparse::{Curvature, Potential};

/// When dynamic relaxation ends.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// Largest distance from equilibrium, as the residual and the lowest frequency tell it [m].
    pub tolerance: f64,
    /// Iterations before it gives up.
    pub max_iterations: u64,
}

/// Margin of the masses over those of Gershgorin's bound.
const MARGIN: f64 = 1.2;

/// Iterations between two assemblies of the stiffness.
const REFRESH: u64 = 100;

/// Iterations times the lowest frequency from which on that frequency is believed. A movement that has just begun is that of the loaded vertices
/// alone; while it spreads, its frequency falls as one over the iterations, until it is the lowest there is.
const SETTLED: f64 = 10.0;

/// Share of the bound at which a movement's own frequency says that the stiffness has grown too much since it was assembled.
const LIMIT: f64 = 3.8;

impl Newton {
    /// Finds an equilibrium of the sum of `potentials` from `x`. `targets`: held unknowns and the values they take. On failure `x` is as it was,
    /// but the potentials' own state is the caller's to put back.
    pub fn relax(
        &mut self,
        potentials: &mut [&mut dyn Potential],
        x: &mut [f64],
        targets: &[(usize, f64)],
        settings: Relaxation,
    ) -> Result<Solved, Failure> {
        let start = x.to_vec();
        targets.iter().for_each(|&(i, value)| x[i] = value);
        let relaxed = self.relax_from(potentials, x, settings);
        match relaxed {
            // Exactly, whatever reframing has done to them.
            Ok(_) => targets.iter().filter(|(i, _)| *i < self.settings.lengths).for_each(|&(i, value)| x[i] = value),
            Err(_) => x.copy_from_slice(&start),
        }
        relaxed
    }

    fn relax_from(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64], settings: Relaxation) -> Result<Solved, Failure> {
        let unknowns: Vec<usize> = self.numbering.unknowns().iter().map(|u| *u as usize).collect();
        let n = unknowns.len();
        let (mut velocity, mut masses, mut before) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let (mut stiffest, mut age, mut near, mut distance, mut lowest) = (0.0f64, REFRESH, 0u64, f64::INFINITY, 0.0f64);
        let mut done = 0;
        for iteration in 1..=settings.max_iterations {
            done = iteration;
            potentials.iter_mut().for_each(|p| p.prepare(x));
            if age >= REFRESH {
                potentials.iter_mut().for_each(|p| p.restart(x));
                self.assemble(potentials, x, Curvature::Mixed);
                self.bound_rows(&mut masses);
                stiffest = self.pattern.column_start[..n].iter().map(|k| self.system.matrix[*k as usize].abs()).fold(0.0, f64::max);
                age = 0;
            } else {
                self.system.gradient.fill(0.0);
                potentials.iter().for_each(|p| {
                    p.gradient(x, &mut self.system);
                });
            }
            self.counters.relaxation_iterations += 1;
            age += 1;
            let gradient = &self.system.gradient;
            // Rayleigh quotient of the last movement.
            let (mut stiffness, mut mass) = (0.0, 0.0);
            for i in 0..n {
                stiffness += velocity[i] * (gradient[i] - before[i]);
                mass += velocity[i] * velocity[i] * masses[i];
            }
            let square = if mass > 0.0 { stiffness / mass } else { 0.0 };
            if square > LIMIT {
                age = REFRESH;
            }
            let (mut pull, mut largest, mut fastest) = (0.0f64, 0.0f64, 0.0f64);
            let damping = 2.0 * square.clamp(0.0, 0.9).sqrt();
            for i in 0..n {
                velocity[i] = ((2.0 - damping) * velocity[i] - 2.0 * gradient[i] / masses[i]) / (2.0 + damping);
                x[unknowns[i]] += velocity[i];
                largest = largest.max(gradient[i].abs());
                if unknowns[i] < self.settings.lengths {
                    pull = pull.max((gradient[i] / masses[i]).abs());
                    fastest = fastest.max(velocity[i].abs());
                }
            }
            before.copy_from_slice(gradient);
            if !(fastest < self.settings.diameter && largest.is_finite()) {
                return Err(Failure::NotRelaxed { iterations: iteration, distance: f64::INFINITY });
            }
            // How far a motion of the lowest frequency would still have to go.
            // Its square is a mean over as many iterations as it takes to be seen: round-off raises the quotient of the smallest movements.
            if square > 0.0 {
                lowest += if lowest > 0.0 { lowest.sqrt().min(0.1) * (square - lowest) } else { square };
            }
            let frequency = lowest.sqrt();
            distance = if lowest > 0.0 { pull.max(fastest * frequency) / lowest } else { pull.max(fastest) };
            near = if distance <= settings.tolerance { near + 1 } else { 0 };
            // Less than the last digit of coordinates is no motion.
            let rests = pull.max(fastest) <= 0.25 * f64::EPSILON * self.settings.diameter;
            let is_settled = iteration as f64 * frequency >= SETTLED && near as f64 * frequency >= 1.0;
            if rests && distance > settings.tolerance {
                break;
            }
            if rests || is_settled {
                potentials.iter_mut().for_each(|p| p.prepare(x));
                potentials.iter_mut().for_each(|p| p.restart(x));
                let residual = largest / (stiffest * self.settings.diameter);
                return Ok(Solved { iterations: iteration, increment: distance, residual, negative_pivots: 0, stability: None });
            }
        }
        Err(Failure::NotRelaxed { iterations: done, distance })
    }

    /// A quarter of the sum of the absolute entries of each row of the matrix, with the margin; rows without any take the largest.
    fn bound_rows(&self, masses: &mut [f64]) {
        masses.fill(0.0);
        for j in 0..masses.len() {
            for k in self.pattern.column_start[j] as usize..self.pattern.column_start[j + 1] as usize {
                let (i, value) = (self.pattern.row[k] as usize, self.system.matrix[k].abs());
                masses[i] += value;
                if i != j {
                    masses[j] += value;
                }
            }
        }
        let largest = masses.iter().copied().fold(0.0, f64::max);
        masses.iter_mut().for_each(|m| *m = 0.25 * MARGIN * if *m > 0.0 { *m } else { largest });
    }
}

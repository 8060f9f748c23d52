//! Leaves unstable equilibria: the lowest mode of the Hessian, a step along it, and a flow down to the next minimum.
//!
//! The mode is that of `K v = lambda M v`, with `M` the rest area that each node carries, on its three coordinates, and nothing on the
//! angles, which follow the nodes; `lambda` [N/m3] is the pressure that a displacement by the mode calls forth, per displacement. `K + sigma M`
//! is positive definite once `sigma` exceeds `-lambda` of the lowest mode, which its pivots tell.
//!
//! From the displaced state the energy falls along the implicit gradient flow: each step minimises the energy and a pull
//! `sigma/2 |x - x_k|_M^2` towards where it starts, by the mixed iteration, whose count does not depend on the thickness. A step is taken only
//! if the energy with the pull fell and no pivot was negative; then the pull is weakened, else strengthened. Without a pull it is Newton's method;
//! on a floor that is level within round-off the flow ends before, where the energy no longer falls.
//! Where several modes are unstable, descent on the energy goes ahead while it pays; on the floors of valleys, where it stalls, the flow does not.
//! Paths of equilibria are not followed here.

use super::newton::{Failure, Newton, Solved};
use crate::error::Result;
use crate::sparse::lanczos::largest;
use crate::sparse::{Curvature, Kind, Numbering, Pattern, Potential, System};

/// Equilibria that one step may leave.
const MOST_SWITCHES: usize = 20;

/// Round-off of an eigenvalue over the largest stiffness of a coordinate.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Weakest pull, over the rate at which the mode grew that was left, that a floor without slope is told by.
const NEUTRAL: f64 = 1e-2;

/// Steps without a fall of the energy after which the floor counts as one.
const IDLE: usize = 4;

/// What is known of the lowest modes of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stability {
    /// Lowest eigenvalue [N/m3] of the equilibrium that was found first.
    pub before: f64,
    /// Lowest eigenvalue [N/m3] of the one that was kept; infinite where no node may move.
    pub lowest: f64,
    /// Equilibria left on the way.
    pub switches: u64,
}

/// The lowest eigenvalue of one equilibrium.
struct Lowest {
    /// Eigenvalue [N/m3].
    value: f64,
    /// Negative pivots of the Hessian. Where `value` is within its round-off, they and its sign may not agree.
    negative_pivots: usize,
    /// Largest stiffness of a coordinate over its rest area [N/m3], > 0.
    stiffest: f64,
}

impl Lowest {
    /// That of a shell none of whose nodes may move.
    const NONE: Lowest = Lowest { value: f64::INFINITY, negative_pivots: 0, stiffest: f64::MIN_POSITIVE };

    /// Rate at which the mode grows that is to be left [N/m3], > 0. An eigenvalue that round-off has put at zero or above tells only that the
    /// rate is below what round-off can tell.
    fn rate(&self) -> f64 {
        (-self.value).max(ROUND_OFF * self.stiffest)
    }
}

/// What tells modes apart, and the last one.
pub struct Stabilizer {
    /// Rest area [m2] that goes with each free unknown; 0 for angles.
    mass: Vec<f64>,
    /// The lowest mode of the last equilibrium, over the free unknowns, its largest coordinate 1.
    mode: Vec<f64>,
}

/// `weight/2 |x - centre|_M^2`.
pub(super) struct Pull {
    weight: f64,
    centre: Vec<f64>,
    mass: Vec<f64>,
}

impl Pull {
    /// Energy [J] at `x`; adds gradient and Hessian.
    pub(super) fn assemble(&self, x: &[f64], numbering: &Numbering, pattern: &Pattern, into: &mut System) -> f64 {
        let mut energy = 0.0;
        for (number, (&unknown, mass)) in numbering.unknowns().iter().zip(&self.mass).enumerate() {
            let (d, k) = (x[unknown as usize] - self.centre[unknown as usize], self.weight * mass);
            into.matrix[pattern.column_start[number] as usize] += k;
            into.gradient[number] += k * d;
            energy += 0.5 * k * d * d;
        }
        energy
    }
}

impl Newton {
    /// From now on unstable equilibria are left. `areas`: rest area of each node [m2].
    pub fn set_stabilizer(&mut self, areas: &[f64]) {
        let of = |unknown: &u32| if (*unknown as usize) < self.settings.lengths { areas[*unknown as usize / 3] } else { 0.0 };
        let mass: Vec<f64> = self.numbering.unknowns().iter().map(of).collect();
        self.stabilizer = Some(Stabilizer { mode: vec![0.0; mass.len()], mass });
    }

    /// Whether unstable equilibria are left.
    pub fn leaves_unstable(&self) -> bool {
        self.stabilizer.is_some()
    }

    /// The lowest mode of the last equilibrium over all unknowns, its largest coordinate 1; zero where none was found. None without a stabilizer.
    pub fn lowest_mode(&self) -> Option<Vec<f64>> {
        self.stabilizer.as_ref().map(|s| self.spread(&s.mode))
    }

    /// Values of the free unknowns among all; 0 for the held.
    fn spread(&self, free: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.numbering.all()];
        free.iter().zip(self.numbering.unknowns()).for_each(|(v, u)| all[*u as usize] = *v);
        all
    }

    /// Leaves equilibria until one is stable. `solved`: how `x`, an equilibrium, was found.
    pub(super) fn stabilize(
        &mut self,
        potentials: &mut [&mut dyn Potential],
        x: &mut [f64],
        mut solved: Solved,
    ) -> Result<Solved, Failure> {
        let mut stability: Option<Stability> = None;
        for switches in 0..=MOST_SWITCHES as u64 {
            let mode = self.lowest(potentials, x)?;
            let (lowest, negative_pivots) = (mode.value, mode.negative_pivots);
            solved.negative_pivots = negative_pivots;
            let known = stability.insert(Stability { before: stability.map_or(lowest, |s| s.before), lowest, switches });
            solved.stability = Some(*known);
            if negative_pivots == 0 {
                self.counters.branch_switches += switches;
                return Ok(solved);
            }
            log::debug!("the equilibrium is unstable: lowest eigenvalue {lowest:e} N/m3, {negative_pivots} negative pivots");
            let noise = self.energy_round_off(potentials, x);
            let Some(step) = self.step_along_mode(potentials, x, noise) else {
                log::debug!("along the lowest mode the energy does not fall by more than round-off: the equilibrium counts as neutral");
                self.counters.branch_switches += switches;
                return Ok(solved);
            };
            // Far past a branch, where several modes grow, the way is long and its first part steep.
            let fallen = if negative_pivots > 1 { self.fall(potentials, x) } else { 0 };
            // An equilibrium without stress has less round-off than the shapes that the shell leaves it for.
            let noise = noise.max(self.energy_round_off(potentials, x));
            let found = self.flow(potentials, x, &mode, step, noise)?;
            solved = Solved { iterations: solved.iterations + fallen + found.iterations, ..found };
        }
        Err(Failure::Unstable(stability.map(|s| s.lowest)))
    }

    /// The lowest eigenvalue of the Hessian at the equilibrium `x`; keeps the mode.
    fn lowest(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64]) -> Result<Lowest, Failure> {
        let Some(mut stabilizer) = self.stabilizer.take() else { return Ok(Lowest::NONE) };
        let found = self.lowest_of(potentials, x, &stabilizer.mass);
        if let Ok((_, vector)) = &found {
            stabilizer.mode.clone_from(vector);
        }
        self.stabilizer = Some(stabilizer);
        found.map(|(lowest, _)| lowest)
    }

    /// The same with its mode, for a rest area `mass` of each free unknown.
    fn lowest_of(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64], mass: &[f64]) -> Result<(Lowest, Vec<f64>), Failure> {
        if !mass.iter().any(|m| *m > 0.0) {
            return Ok((Lowest::NONE, vec![0.0; mass.len()]));
        }
        potentials.iter_mut().for_each(|p| p.prepare(x));
        self.assemble(potentials, x, Curvature::Mixed);
        let hessian = self.system.matrix.clone();
        // A zero pivot here is a branching point that was hit exactly, and no mechanism: its mode tells the side.
        let pivots = self.solve_linear(Kind::Ldlt).ok().filter(|_| !self.is_vanishing);
        // Eigenvalues below `least` are round-off, and so is what a solve with a matrix makes of their modes.
        let stiffness = self.pattern.column_start.iter().zip(mass).filter(|(_, m)| **m > 0.0);
        let stiffest = stiffness.map(|(slot, m)| hessian[*slot as usize].abs() / m).fold(f64::MIN_POSITIVE, f64::max);
        let least = ROUND_OFF * stiffest;
        let mut sigma = 0.0;
        if pivots.is_none() {
            sigma = self.shift_above(&hessian, mass, least)?;
        } else if pivots > Some(0) {
            // About the eigenvalue next to zero: what K^-1 M makes of a vector without symmetry.
            let start: Vec<f64> = (0..mass.len()).map(|i| (0.618_034 * (i + 1) as f64).fract() - 0.5).collect();
            let mut y: Vec<f64> = start.iter().zip(mass).map(|(s, m)| s * m).collect();
            self.cholesky.solve(&mut y);
            let size = |v: &[f64]| v.iter().zip(mass).map(|(v, m)| v * v * m).sum::<f64>().sqrt();
            sigma = self.shift_above(&hessian, mass, (size(&start) / size(&y)).max(least))?;
        }
        let mut found = largest(mass, &mut |y| self.cholesky.solve(y));
        if found.is_none() {
            sigma = self.shift_above(&hessian, mass, 16.0 * sigma.max(least))?;
            found = largest(mass, &mut |y| self.cholesky.solve(y));
        }
        let mut mode = found.ok_or(Failure::Unstable(None))?;
        mode.value = 1.0 / mode.value - sigma;
        // The largest coordinate is 1, and the first that is half as large positive: the sign does not hang on round-off.
        let coordinates = || mode.vector.iter().zip(mass).filter(|(_, m)| **m > 0.0).map(|(v, _)| *v);
        let size = coordinates().fold(0.0f64, |m, v| m.max(v.abs()));
        let sign = coordinates().find(|v| v.abs() > 0.5 * size).map_or(1.0, f64::signum);
        mode.vector.iter_mut().for_each(|v| *v *= sign / size);
        let negative_pivots = pivots.unwrap_or(usize::from(mode.value < 0.0));
        Ok((Lowest { value: mode.value, negative_pivots, stiffest }, mode.vector))
    }

    /// Factors `hessian + sigma M`, with a `sigma` [N/m3] of at least this that makes it positive definite; returns it.
    fn shift_above(&mut self, hessian: &[f64], mass: &[f64], mut sigma: f64) -> Result<f64, Failure> {
        while sigma.is_finite() && sigma > 0.0 {
            self.system.matrix.copy_from_slice(hessian);
            let diagonal = self.pattern.column_start.iter().zip(mass);
            diagonal.for_each(|(slot, m)| self.system.matrix[*slot as usize] += sigma * m);
            self.counters.factorizations += 1;
            match self.cholesky.refactor(&self.pattern, &self.system.matrix, Kind::Ldlt) {
                Ok(done) if done.negative_pivots == 0 && !done.is_vanishing => return Ok(sigma),
                _ => sigma *= 4.0,
            }
        }
        Err(Failure::Unstable(None))
    }

    /// Moves `x` along the lowest mode, to the side and as far as the energy falls most; returns how far [m], none if it does not fall by
    /// well more than its round-off `noise` [J].
    fn step_along_mode(&mut self, potentials: &[&mut dyn Potential], x: &mut [f64], noise: f64) -> Option<f64> {
        let mode = self.lowest_mode()?;
        let start = energy(potentials, x);
        let mut best: Option<(f64, f64)> = None;
        let mut size = 0.1 * self.settings.diameter;
        while size > self.settings.tolerance {
            let mut fell = false;
            for sign in [1.0, -1.0] {
                let step = sign * size;
                self.trial.iter_mut().zip(x.iter().zip(&mode)).for_each(|(t, (x, v))| *t = x + step * v);
                let change = energy(potentials, &self.trial) - start;
                // Two sides that are alike but for round-off: the first.
                let lower = best.map_or(-10.0 * noise, |(_, least)| least * (1.0 + 1e-6) - noise);
                if change < lower {
                    best = Some((step, change));
                    fell = true;
                }
            }
            if best.is_some() && !fell {
                break;
            }
            size *= 0.5;
        }
        let (step, change) = best?;
        log::debug!("moved by {step:e} m along the lowest mode: the energy falls by {:e} J", -change);
        x.iter_mut().zip(&mode).for_each(|(x, v)| *x += step * v);
        Some(step.abs())
    }

    /// Descent while it pays: until an iteration brings less than a tenth of what all of them have. Returns their number.
    fn fall(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64]) -> u64 {
        let start = energy(potentials, x);
        let mut last = start;
        for iteration in 1..=self.settings.max_iterations as u64 {
            // A failed iteration leaves the state where it was.
            if self.descend_once(potentials, x).is_err() {
                return iteration;
            }
            let now = energy(potentials, x);
            if !(last - now > 0.1 * (start - now)) {
                return iteration;
            }
            last = now;
        }
        self.settings.max_iterations as u64
    }

    /// The gradient flow from `x` to an equilibrium of lower energy. `mode`: the one along which the last was left; `step`: size of the first
    /// movements [m]; `noise`: round-off of the energy [J].
    fn flow(
        &mut self,
        potentials: &mut [&mut dyn Potential],
        x: &mut [f64],
        mode: &Lowest,
        step: f64,
        noise: f64,
    ) -> Result<Solved, Failure> {
        let mass = self.stabilizer.as_ref().map_or(Vec::new(), |s| s.mass.clone());
        let rate = mode.rate();
        // A pull as stiff as the shell itself holds it, however slowly the mode grew where it was left.
        let (strongest, weakest) = (mode.stiffest.max(1e8 * rate), 1e-3 * rate);
        // Just enough for the first step to have a minimum.
        let (mut weight, mut movement, mut iterations) = (1.25 * rate, step, 0);
        // What the pull is weakened by.
        let mut ease: f64 = 0.1;
        // Steps in a row with a weak pull in which the energy changed by no more than round-off.
        let mut idle = 0;
        for _ in 0..4 * self.settings.max_iterations {
            potentials.iter_mut().for_each(|p| {
                p.prepare(x);
                p.restart(x);
                p.save();
            });
            let kept = x.to_vec();
            let start = energy(potentials, x);
            let free = weight <= weakest;
            if !free {
                self.pull = Some(Pull { weight, centre: kept.clone(), mass: mass.clone() });
            }
            let tolerance = if free { self.settings.tolerance } else { (1e-2 * movement).max(self.settings.tolerance) };
            let outcome = self.mixed(potentials, x, &[], tolerance);
            let pulled = self.pull.take().map_or(0.0, |pull| {
                let unknowns = self.numbering.unknowns().iter().zip(&pull.mass);
                unknowns.map(|(u, m)| 0.5 * weight * m * (x[*u as usize] - kept[*u as usize]).powi(2)).sum::<f64>()
            });
            let change = energy(potentials, x) + pulled - start;
            match outcome {
                Ok(solved) if change <= noise && (free || solved.negative_pivots == 0) => {
                    iterations += solved.iterations;
                    let moved = x.iter().zip(&kept).take(self.settings.lengths).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                    log::trace!(
                        "flow: weight {weight:e}, {} iterations, moved {moved:e} m, energy fell by {:e} J",
                        solved.iterations,
                        -change
                    );
                    // Along the floor of a valley, as a cylinder's turn about the axis of a disc, forces that the energy no longer tells from
                    // round-off may move the shell for long. Where the energy has stopped falling is then all there is to know.
                    idle = if weight <= NEUTRAL * rate && change >= -noise { idle + 1 } else { 0 };
                    if free || idle == IDLE {
                        return Ok(Solved { iterations, ..solved });
                    }
                    // While movements grow the pull is what keeps the flow near its path; then it only costs steps.
                    if moved < movement {
                        weight *= ease;
                        ease = (0.8 * ease).max(0.1);
                    }
                    movement = moved;
                }
                outcome => {
                    log::trace!("flow: weight {weight:e} failed: {outcome:?}, energy {change:e} J");
                    x.copy_from_slice(&kept);
                    potentials.iter_mut().for_each(|p| p.put_back());
                    weight *= if free { 2.0 } else { 5.0 };
                    ease = ease.sqrt();
                    if weight > strongest {
                        return Err(Failure::Unstable(Some(mode.value)));
                    }
                }
            }
        }
        Err(Failure::Unstable(Some(mode.value)))
    }
}

/// The energy [J].
fn energy(potentials: &[&mut dyn Potential], x: &[f64]) -> f64 {
    potentials.iter().map(|p| p.energy(x)).sum()
}

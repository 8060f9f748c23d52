//! Newton's method with extrapolated stresses, and descent on the energy where it does not contract.
//!
//! The mixed iteration uses, in the geometric part of the Hessian, stresses that follow the linearised law of the last iteration; its
//! residual is the true one. It takes the thickness out of the iteration count, but promises no descent: when it does not contract, the
//! step starts anew by descent. Step sizes are not chosen here.

use super::stability::{Pull, Stability, Stabilizer};
use crate::error::Result;
use crate::sparse::{Cholesky, Curvature, Kind, Numbering, Pattern, Potential, System};

/// When an iteration stops. Lengths are absolute here; the caller scales them with the mesh.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Number of unknowns, at the front, that are lengths; the others are angles.
    pub lengths: usize,
    /// Size of the mesh [m].
    pub diameter: f64,
    /// Largest movement in the last iteration [m].
    pub tolerance: f64,
    /// Mixed iterations before descent takes over.
    pub max_iterations: usize,
}

/// Work done, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Mixed Newton iterations.
    pub newton_iterations: u64,
    /// Descent iterations.
    pub fallback_iterations: u64,
    /// Numeric factorisations.
    pub factorizations: u64,
    /// Unstable equilibria that were left.
    pub branch_switches: u64,
    /// Iterations of dynamic relaxation.
    pub relaxation_iterations: u64,
}

/// A solved step.
#[derive(Clone, Copy, Debug)]
pub struct Solved {
    /// Iterations of either kind.
    pub iterations: u64,
    /// Movement in the last iteration [m].
    pub increment: f64,
    /// Largest component of the gradient over the largest diagonal entry of the matrix times the diameter [1].
    pub residual: f64,
    /// Negative pivots of the last factorisation: unstable directions of the equilibrium.
    pub negative_pivots: usize,
    /// Lowest modes, where unstable equilibria are to be left.
    pub stability: Option<Stability>,
}

/// Why a step was not solved.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// The matrix is singular: this unknown (over all unknowns) moves without resistance.
    Mechanism(usize),
    /// No iteration contracted; the movement in the last one [m].
    NotContracting(f64),
    /// The same, where round-off hides how stiff the shell is.
    RoundOff(RoundOff),
    /// Dynamic relaxation had not come to rest after so many iterations.
    NotRelaxed {
        /// Iterations.
        iterations: u64,
        /// Distance from equilibrium as the residual and the lowest frequency tell it [m]; infinite where the motion left all bounds.
        distance: f64,
    },
    /// The equilibrium is unstable and was not left for a stable one; its lowest eigenvalue [N/m3], if that was found.
    Unstable(Option<f64>),
}

/// How round-off hid the stiffness of a shell from the iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundOff {
    /// The unknown with the smallest pivot, over all unknowns.
    pub unknown: usize,
    /// That pivot over its diagonal entry [1].
    pub pivot: f64,
    /// Error left in the first movement that was solved for, over its size [1].
    pub error: f64,
    /// How far round-off of the forces moves the shell [m].
    pub movement: f64,
}

/// Pattern, matrix and factor of one set of potentials and supports; allocated once.
pub struct Newton {
    pub(super) numbering: Numbering,
    pub(super) pattern: Pattern,
    pub(super) system: System,
    pub(super) cholesky: Cholesky,
    pub(super) settings: Settings,
    pub(super) dx: Vec<f64>,
    pub(super) solution: Vec<f64>,
    pub(super) trial: Vec<f64>,
    pub(super) counters: Counters,
    /// Whether descent takes over where the mixed iteration does not contract; else the step has failed.
    descends: bool,
    /// Whether first iterations go along descents of the energy where the matrix has negative pivots.
    projects: bool,
    /// Whether a first matrix has shown that nothing moves without resistance.
    is_held: bool,
    /// Smallest pivot of the last factor over its diagonal entry, and its unknown.
    pub(super) smallest_pivot: f64,
    pub(super) softest_unknown: usize,
    /// Whether a pivot of the last factor was no larger than what round-off leaves of a zero one.
    pub(super) is_vanishing: bool,
    /// Error left in the last movement that was solved for and refined, over its size; 0 where it was not looked at.
    pub(super) matrix_error: f64,
    /// What round-off has hidden of this equilibrium.
    hidden: Option<RoundOff>,
    /// Where unstable equilibria are to be left.
    pub(super) stabilizer: Option<Stabilizer>,
    /// What holds the iteration near a place for the time being.
    pub(super) pull: Option<Pull>,
}

/// Share of the matrix below which the stiffness of a direction is that of a mechanism. A thickness of 1e-6 of the span leaves 1e-17 on fine
/// meshes; round-off leaves mechanisms of shells thicker than 1e-4 of the span below 1e-19.
const MECHANISM: f64 = 1e-18;

/// Iterations that may take the semidefinite matrix; after them the end of the step is one that is no minimum.
const PROJECTED: u64 = 15;

/// Movement over the largest coordinate that is round-off.
const DIGITS: f64 = 4.0 * f64::EPSILON;

/// Error of a refined movement over its size that is told where the iteration does not contract.
const WRONG: f64 = 1e-3;

/// Largest jump of a support that descent may start with, relative to the mesh: about an edge of a fine mesh.
const TEAR: f64 = 1e-2;

impl Newton {
    /// Analyses the couplings of `potentials` with the `held` unknowns left out, and binds them.
    pub fn new(potentials: &mut [&mut dyn Potential], held: &[bool], settings: Settings) -> Result<Self> {
        let numbering = Numbering::new(held);
        let pattern = Pattern::new(&numbering, &mut |visit| potentials.iter().for_each(|p| p.stencils(visit)))?;
        for potential in potentials.iter_mut() {
            potential.bind(&numbering, &pattern);
        }
        let cholesky = Cholesky::new(&pattern)?;
        let system = System::new(&pattern);
        let all = numbering.all();
        let solution = vec![0.0; numbering.free()];
        Ok(Newton {
            numbering,
            pattern,
            system,
            cholesky,
            settings,
            dx: vec![0.0; all],
            solution,
            trial: vec![0.0; all],
            counters: Counters::default(),
            descends: true,
            projects: false,
            is_held: false,
            smallest_pivot: 1.0,
            softest_unknown: 0,
            is_vanishing: false,
            matrix_error: 0.0,
            hidden: None,
            stabilizer: None,
            pull: None,
        })
    }

    /// Binds potentials to the free unknowns, as those of this solver have to be.
    pub fn bind(&self, potentials: &mut [&mut dyn Potential]) {
        potentials.iter_mut().for_each(|p| p.bind(&self.numbering, &self.pattern));
    }

    /// Work done so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Puts counters back, as a checkpoint has them.
    pub fn set_counters(&mut self, counters: Counters) {
        self.counters = counters;
    }

    /// Whether descent takes over from now on where the mixed iteration does not contract, as at first; else such a step has failed.
    pub fn set_descends(&mut self, descends: bool) {
        self.descends = descends;
    }

    /// Whether first iterations that meet negative pivots take the positive semidefinite matrix of the same lagged stresses, as a step of a motion should:
    /// inertia makes most of its ends minima, which the exact matrix leads away from while stresses are far from theirs.
    pub fn set_projects(&mut self, projects: bool) {
        self.projects = projects;
    }

    /// Number of free unknowns.
    pub fn free(&self) -> usize {
        self.numbering.free()
    }

    /// Finds an equilibrium of the sum of `potentials` from `x`, a stable one if there is a stabilizer. `targets`: held unknowns and the
    /// values they take. On failure `x` is as it was, but the potentials' own state (directors, lagged stresses) is the caller's to put back.
    pub fn solve(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64], targets: &[(usize, f64)]) -> Result<Solved, Failure> {
        if self.stabilizer.is_none() {
            return self.equilibrium(potentials, x, targets);
        }
        let start = x.to_vec();
        let solved = self.equilibrium(potentials, x, targets)?;
        self.stabilize(potentials, x, solved).inspect_err(|_| x.copy_from_slice(&start))
    }

    /// An equilibrium, stable or not.
    fn equilibrium(&mut self, potentials: &mut [&mut dyn Potential], x: &mut [f64], targets: &[(usize, f64)]) -> Result<Solved, Failure> {
        if self.free() == 0 {
            targets.iter().for_each(|&(i, value)| x[i] = value);
            potentials.iter_mut().for_each(|p| p.prepare(x));
            return Ok(Solved { iterations: 0, increment: 0.0, residual: 0.0, negative_pivots: 0, stability: None });
        }
        let start = x.to_vec();
        potentials.iter_mut().for_each(|p| p.save());
        let moved: Vec<(usize, f64)> = targets.iter().map(|&(i, value)| (i, value - x[i])).filter(|(_, d)| *d != 0.0).collect();
        let first = match self.mixed(potentials, x, &moved, self.settings.tolerance) {
            Ok(solved) => {
                // Exactly, without the round-off of the increments. Angles are zero again: their references have turned.
                targets.iter().filter(|(i, _)| *i < self.settings.lengths).for_each(|&(i, value)| x[i] = value);
                return Ok(solved);
            }
            // Singular before anything moved: no step and no descent mends a mechanism.
            Err(failure @ Failure::Mechanism(_)) if *x == *start => return Err(failure),
            Err(failure) if !self.descends => {
                x.copy_from_slice(&start);
                return Err(self.reason(failure));
            }
            Err(failure) => {
                log::debug!("mixed iteration: {failure:?}; descending on the energy");
                failure
            }
        };
        x.copy_from_slice(&start);
        potentials.iter_mut().for_each(|p| p.put_back());
        // Descent starts with the supports moved and all else left behind. Where that tears the shell it would settle in a wrong valley.
        let reach = moved.iter().filter(|(i, _)| *i < self.settings.lengths).fold(0.0f64, |m, (_, d)| m.max(d.abs()));
        let hidden = self.hidden;
        if reach > TEAR * self.settings.diameter {
            return Err(self.reason(Failure::NotContracting(reach)));
        }
        targets.iter().for_each(|&(i, value)| x[i] = value);
        self.descend(potentials, x).map_err(|failure| {
            x.copy_from_slice(&start);
            self.hidden = hidden;
            self.reason(if matches!(failure, Failure::Mechanism(_)) { first } else { failure })
        })
    }

    /// A failure of the iteration, with round-off for its reason where it has hidden something of this equilibrium. What no longer is regular on
    /// the way from a shell that is held is no mechanism.
    fn reason(&self, failure: Failure) -> Failure {
        match (self.hidden, failure) {
            (Some(hidden), _) => Failure::RoundOff(hidden),
            (None, Failure::Mechanism(_)) if self.is_held => Failure::NotContracting(self.movement()),
            (None, failure) => failure,
        }
    }

    /// What round-off hides now. `movement`: how far that of the forces moves the shell [m].
    fn round_off(&self, movement: f64) -> RoundOff {
        RoundOff { unknown: self.softest_unknown, pivot: self.smallest_pivot, error: self.matrix_error, movement }
    }

    /// Assembles gradient and Hessian at `x`.
    pub(super) fn assemble(&mut self, potentials: &mut [&mut dyn Potential], x: &[f64], curvature: Curvature) -> f64 {
        self.system.clear();
        let energy: f64 = potentials.iter_mut().map(|p| p.assemble(x, curvature, &mut self.system)).sum();
        energy + self.pull.as_ref().map_or(0.0, |pull| pull.assemble(x, &self.numbering, &self.pattern, &mut self.system))
    }

    /// The same with what held unknowns that move by the `moved` distances do to the forces.
    pub(super) fn assemble_moving(
        &mut self,
        potentials: &mut [&mut dyn Potential],
        x: &[f64],
        curvature: Curvature,
        moved: &[(usize, f64)],
    ) -> f64 {
        if !moved.is_empty() {
            let mut prescribed = vec![0.0; x.len()];
            moved.iter().for_each(|&(i, d)| prescribed[i] = d);
            self.system.prescribed = Some(prescribed);
        }
        let energy = self.assemble(potentials, x, curvature);
        self.system.prescribed = None;
        energy
    }

    /// Largest movement in `dx` [m]; with no free length, the largest angle over one radian times the diameter. Infinite if anything is not finite.
    pub(super) fn movement(&self) -> f64 {
        let (mut lengths, mut angles) = (0.0f64, 0.0f64);
        for (i, d) in self.dx.iter().enumerate() {
            if !d.is_finite() {
                return f64::INFINITY;
            }
            let of = if i < self.settings.lengths { &mut lengths } else { &mut angles };
            *of = of.max(d.abs());
        }
        let free_length = self.numbering.unknowns().first().is_some_and(|u| (*u as usize) < self.settings.lengths);
        if free_length { lengths } else { angles * self.settings.diameter }
    }

    /// The largest movement in `dx` beside that of all nodes together [m]: what falls moves far in a long step. Infinite if anything is not finite.
    fn deformation(&self) -> f64 {
        let movement = self.movement();
        if !(movement >= self.settings.diameter && movement.is_finite()) {
            return movement;
        }
        let nodes = &self.dx[..self.settings.lengths];
        let mean = |k: usize| nodes.iter().skip(k).step_by(3).sum::<f64>() / (nodes.len() / 3) as f64;
        let together = [0, 1, 2].map(mean);
        nodes.iter().enumerate().fold(0.0, |m, (i, d)| m.max((d - together[i % 3]).abs()))
    }

    /// Largest component of the gradient over the largest diagonal entry times the diameter.
    pub(super) fn residual(&self) -> f64 {
        let largest = |m: f64, v: f64| m.max(v.abs());
        let stiffest = self.pattern.column_start[..self.pattern.len()].iter().map(|k| self.system.matrix[*k as usize]).fold(0.0, largest);
        self.system.gradient.iter().copied().fold(0.0, largest) / (stiffest * self.settings.diameter)
    }

    /// Solves `H dx = -g` into `self.dx` (held unknowns zero).
    pub(super) fn solve_linear(&mut self, kind: Kind) -> Result<usize, Failure> {
        self.counters.factorizations += 1;
        let done = self
            .cholesky
            .refactor(&self.pattern, &self.system.matrix, kind)
            .map_err(|pivot| Failure::Mechanism(self.numbering.unknowns()[pivot.unknown] as usize))?;
        self.solution.iter_mut().zip(&self.system.gradient).for_each(|(s, g)| *s = -g);
        self.cholesky.solve(&mut self.solution);
        self.dx.fill(0.0);
        for (value, &unknown) in self.solution.iter().zip(self.numbering.unknowns()) {
            self.dx[unknown as usize] = *value;
        }
        if kind == Kind::Ldlt {
            (self.smallest_pivot, self.softest_unknown) = (done.smallest, self.numbering.unknowns()[done.softest] as usize);
            self.is_vanishing = done.is_vanishing;
        }
        Ok(done.negative_pivots)
    }

    /// Mixed iterations from `x` until the movement, less what round-off alone makes of it, is within `tolerance` [m]; the held unknowns `moved`
    /// go along with the first.
    pub(super) fn mixed(
        &mut self,
        potentials: &mut [&mut dyn Potential],
        x: &mut [f64],
        moved: &[(usize, f64)],
        tolerance: f64,
    ) -> Result<Solved, Failure> {
        let (mut smallest, mut movement, mut last) = (f64::INFINITY, f64::INFINITY, 0.0);
        self.hidden = None;
        for iteration in 1..=self.settings.max_iterations as u64 {
            potentials.iter_mut().for_each(|p| p.prepare(x));
            let moving = iteration == 1 && !moved.is_empty();
            let along = if moving { moved } else { &[] };
            let energy = self.assemble_moving(potentials, x, Curvature::Mixed, along);
            self.counters.newton_iterations += 1;
            if !energy.is_finite() {
                return Err(Failure::NotContracting(movement));
            }
            let residual = self.residual();
            let negative_pivots = self.solve_linear(Kind::Ldlt)?;
            self.check_held(potentials, x)?;
            let projected = self.projects && negative_pivots > 0 && iteration <= PROJECTED;
            if projected {
                self.assemble_moving(potentials, x, Curvature::Projected, along);
                self.solve_shifted()?;
            }
            along.iter().for_each(|&(i, d)| self.dx[i] = d);
            if !projected {
                self.refine(potentials, x, along);
                if iteration == 1 && self.matrix_error > WRONG {
                    self.hidden = Some(self.round_off(0.0));
                }
            }
            movement = self.movement();
            log::trace!("mixed {iteration}: movement {movement:.3e} m, residual {residual:.1e}, negative pivots {negative_pivots}");
            if !(self.deformation() < 3.0 * self.settings.diameter) {
                return Err(Failure::NotContracting(movement));
            }
            // Where movements do not shrink, round-off may make them.
            if !moving && movement > tolerance && movement > 0.5 * last {
                let by_round_off = self.leave_out_round_off(potentials, x, tolerance);
                if by_round_off > tolerance {
                    self.hidden = Some(self.round_off(by_round_off));
                }
                movement = self.movement();
            }
            last = movement;
            potentials.iter_mut().for_each(|p| p.extrapolate(x, &self.dx));
            x.iter_mut().zip(&self.dx).for_each(|(x, d)| *x += d);
            // Far from the origin coordinates have no digits for the tolerance.
            if movement <= tolerance.max(DIGITS * x[..self.settings.lengths].iter().fold(0.0, |m: f64, x| m.max(x.abs()))) {
                potentials.iter_mut().for_each(|p| p.prepare(x));
                return Ok(Solved { iterations: iteration, increment: movement, residual, negative_pivots, stability: None });
            }
            smallest = smallest.min(movement);
            if iteration > 6 && movement > 1e3 * smallest {
                break;
            }
        }
        Err(Failure::NotContracting(movement))
    }

    /// Once, after the first solution with the matrix at `x`: that nothing moves without resistance.
    pub(super) fn check_held(&mut self, potentials: &[&mut dyn Potential], x: &[f64]) -> Result<(), Failure> {
        if !self.is_held {
            let (share, unknown) = self.softest(potentials, x);
            log::trace!("softest direction: {share:e} of the matrix; smallest pivot {:.1e}", self.smallest_pivot);
            // Here a pivot within round-off is a mechanism's too; later it only is what round-off hides.
            if self.is_vanishing || share < MECHANISM {
                return Err(Failure::Mechanism(self.numbering.unknowns()[unknown] as usize));
            }
            self.is_held = true;
        }
        Ok(())
    }

    /// The softest direction `y` of the matrix `H` last factorised, by inverse iteration: its stiffness over `|y|.|H| |y|`, and the unknown
    /// that moves most in it.
    ///
    /// A mechanism's zero pivot may be hidden by what elimination adds to it, and `y.H y` by its round-off; potentials form the stiffness
    /// along `y` from strains, whose round-off enters squared.
    fn softest(&mut self, potentials: &[&mut dyn Potential], x: &[f64]) -> (f64, usize) {
        let (start, rows, values) = (&self.pattern.column_start, &self.pattern.row, &self.system.matrix);
        let diagonal: Vec<f64> = start[..start.len() - 1].iter().map(|s| values[*s as usize].abs()).collect();
        // Numbers without any symmetry, weighted so that lengths and angles count alike.
        let mut y: Vec<f64> = diagonal.iter().enumerate().map(|(i, d)| d.sqrt() * ((0.618 * i as f64).fract() - 0.5)).collect();
        let mut largest = 0;
        for round in 0..3 {
            if round > 0 {
                y.iter_mut().zip(&diagonal).for_each(|(y, d)| *y *= d);
            }
            self.cholesky.solve(&mut y);
            let weight = |i: usize| y[i] * y[i] * diagonal[i];
            largest = (0..y.len()).max_by(|a, b| weight(*a).total_cmp(&weight(*b))).unwrap_or(0);
            let size = weight(largest).sqrt();
            if !(size.is_finite() && size > 0.0) {
                return (0.0, largest);
            }
            y.iter_mut().for_each(|y| *y /= size);
        }
        let mut bound = 0.0;
        for j in 0..y.len() {
            for k in start[j] as usize..start[j + 1] as usize {
                let i = rows[k] as usize;
                bound += (values[k] * y[i] * y[j]).abs() * if i == j { 1.0 } else { 2.0 };
            }
        }
        let mut direction = vec![0.0; x.len()];
        for (value, &unknown) in y.iter().zip(self.numbering.unknowns()) {
            direction[unknown as usize] = *value;
        }
        let value: f64 = potentials.iter().map(|p| p.stiffness_along(x, &direction)).sum();
        (value / bound, largest)
    }
}

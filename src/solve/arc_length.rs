//! Follows a path of equilibria through limit points: the load factor `t` is an unknown, and the length of the step is given instead.
//!
//! The constraint is Riks': a step ends in the plane across the tangent at its start, at the given distance from it. Distances are root mean
//! squares over the nodes of their displacements; director angles and `t` itself have no part in them, so no scale between unlike unknowns is
//! to be chosen, and a step does not depend on the size of the loads. Each iteration factorises once and solves twice, for the residual and
//! for what the load factor changes. Iterations are the mixed ones of `newton`, whose stresses follow the whole movement. The path goes on to that side
//! of the tangent on which the last step's movement lies.
//!
//! Step lengths are chosen here by the iterations of the last step. Branches are passed by and not looked for; there is no descent, which would
//! leave a path of unstable states.

use super::newton::{Failure, Newton, Solved};
use crate::sparse::{Curvature, Kind, Potential, System};

/// Potentials and held unknowns that follow a load factor `t`.
pub trait Family {
    /// Why a value of `t` is impossible.
    type Refusal;

    /// The potentials, always in the same order.
    fn potentials(&mut self) -> Vec<&mut dyn Potential>;

    /// Sets everything that follows `t`. Errors: what is impossible there.
    fn set(&mut self, t: f64) -> Result<(), Self::Refusal>;

    /// Held unknowns that move, and their values at `t`; angles [rad] from any fixed reference. Errors: what is impossible there.
    fn moved(&self, t: f64) -> Result<Vec<(usize, f64)>, Self::Refusal>;

    /// Adds the derivative by `t` of the gradient at fixed unknowns, held ones too. What follows `t` is set to it before and after. Errors: what
    /// is impossible there.
    fn add_rate(&mut self, t: f64, x: &[f64], into: &mut System) -> Result<(), Self::Refusal>;
}

/// Why a step along a path was not solved.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop<R> {
    /// The equations were not solved.
    Equations(Failure),
    /// The load factor moves nothing: there is no path.
    Still,
    /// What is prescribed at a load factor is impossible.
    Refused(R),
}

impl<R> From<Failure> for Stop<R> {
    fn from(failure: Failure) -> Self {
        Stop::Equations(failure)
    }
}

/// How far a step goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// As far as this change of the load factor takes it by the tangent.
    Factor(f64),
    /// Root mean square of the nodes' displacements [m].
    Length(f64),
}

/// A step along a path.
#[derive(Clone, Copy, Debug)]
pub struct Advance {
    /// How it was solved.
    pub solved: Solved,
    /// Load factor at its end.
    pub t: f64,
    /// Its length by the tangent at its start [m], as was asked for.
    pub length: f64,
}

/// Change of `t` on either side for derivatives by differences. Loads that are linear in `t` have none of its error.
pub const RATE_STEP: f64 = 1.0 / 1024.0;

/// Longest way a step may make over its length along the tangent: beyond that it has left the path, or turned too sharply to be sure.
const DETOUR: f64 = 2.0;

impl Newton {
    /// Root mean square of the displacements of the nodes in a movement of all unknowns [m].
    pub fn path_length(&self, movement: &[f64]) -> f64 {
        self.path_product(movement, movement).sqrt()
    }

    /// The scalar product that goes with it [m2].
    fn path_product(&self, a: &[f64], b: &[f64]) -> f64 {
        let lengths = self.settings.lengths;
        3.0 * a[..lengths].iter().zip(&b[..lengths]).map(|(a, b)| a * b).sum::<f64>() / lengths as f64
    }

    /// The next equilibrium on the path through `x` at `t`. `heading`: movement of the last step over all unknowns, none before the first, which
    /// goes to growing `t`. On failure `x` is as it was, but what follows `t` and the potentials' own state is the caller's to put back.
    pub fn advance_along<F: Family>(
        &mut self,
        family: &mut F,
        x: &mut [f64],
        t: f64,
        reach: Reach,
        heading: Option<&[f64]>,
    ) -> Result<Advance, Stop<F::Refusal>> {
        let start = x.to_vec();
        self.try_along(family, x, t, reach, heading).inspect_err(|_| x.copy_from_slice(&start))
    }

    fn try_along<F: Family>(
        &mut self,
        family: &mut F,
        x: &mut [f64],
        mut t: f64,
        reach: Reach,
        heading: Option<&[f64]>,
    ) -> Result<Advance, Stop<F::Refusal>> {
        if self.free() == 0 {
            return Err(Stop::Still);
        }
        let start = x.to_vec();
        let (mut tangent, mut length) = (Vec::new(), 0.0);
        let (mut smallest, mut movement, mut last) = (f64::INFINITY, f64::INFINITY, 0.0);
        for iteration in 1..=self.settings.max_iterations as u64 {
            family.potentials().iter_mut().for_each(|p| p.prepare(x));
            let mut by_factor = self.rate(family, x, t)?;
            let energy = self.assemble(&mut family.potentials(), x, Curvature::Mixed);
            self.counters.newton_iterations += 1;
            if !energy.is_finite() {
                return Err(Failure::NotContracting(movement).into());
            }
            let residual = self.residual();
            let negative_pivots = self.solve_linear(Kind::Ldlt)?;
            self.check_held(&family.potentials(), x)?;
            // Held unknowns move with the factor as they are told, free ones as that and the loads make them.
            let mut free: Vec<f64> = self.numbering.unknowns().iter().map(|u| by_factor[*u as usize]).collect();
            self.cholesky.solve(&mut free);
            free.iter().zip(self.numbering.unknowns()).for_each(|(value, u)| by_factor[*u as usize] = *value);
            let speed = self.path_length(&by_factor);
            if iteration == 1 {
                if !(speed > 0.0 && speed.is_finite()) {
                    return Err(Stop::Still);
                }
                let forwards = heading.is_none_or(|heading| self.path_product(heading, &by_factor) >= 0.0);
                let sign = if forwards { 1.0 } else { -1.0 };
                length = match reach {
                    Reach::Factor(dt) => dt * speed,
                    Reach::Length(length) => length,
                };
                tangent = by_factor.iter().map(|v| sign * v / speed).collect();
            }
            let way: Vec<f64> = x.iter().zip(&start).map(|(x, s)| x - s).collect();
            let rest = length - self.path_product(&tangent, &way) - self.path_product(&tangent, &self.dx);
            let dt = rest / self.path_product(&tangent, &by_factor);
            if !dt.is_finite() {
                return Err(Failure::NotContracting(movement).into());
            }
            self.dx.iter_mut().zip(&by_factor).for_each(|(d, v)| *d += dt * v);
            for ((i, from), (_, to)) in
                family.moved(t).map_err(Stop::Refused)?.into_iter().zip(family.moved(t + dt).map_err(Stop::Refused)?)
            {
                self.dx[i] = if i < self.settings.lengths { to - x[i] } else { to - from };
            }
            movement = self.movement();
            log::trace!(
                "arc {iteration}: t {t:.6} + {dt:.2e}, movement {movement:.3e} m, residual {residual:.1e}, negative pivots {negative_pivots}"
            );
            if !(movement < 3.0 * self.settings.diameter) {
                return Err(Failure::NotContracting(movement).into());
            }
            let tolerance = self.settings.tolerance;
            if iteration > 1 && movement > tolerance && movement > 0.5 * last {
                self.solution.iter_mut().zip(self.numbering.unknowns()).for_each(|(s, u)| *s = self.dx[*u as usize]);
                self.leave_out_round_off(&family.potentials(), x, tolerance);
                movement = self.movement();
            }
            last = movement;
            family.potentials().iter_mut().for_each(|p| p.extrapolate(x, &self.dx));
            x.iter_mut().zip(&self.dx).for_each(|(x, d)| *x += d);
            t += dt;
            family.set(t).map_err(Stop::Refused)?;
            if movement <= tolerance {
                family.potentials().iter_mut().for_each(|p| p.prepare(x));
                let way: Vec<f64> = x.iter().zip(&start).map(|(x, s)| x - s).collect();
                if self.path_length(&way) > DETOUR * length {
                    log::debug!("the step left the path: {:.3e} m for {length:.3e} m", self.path_length(&way));
                    return Err(Failure::NotContracting(movement).into());
                }
                let solved = Solved { iterations: iteration, increment: movement, residual, negative_pivots, stability: None };
                return Ok(Advance { solved, t, length });
            }
            smallest = smallest.min(movement);
            if iteration > 6 && movement > 1e3 * smallest {
                break;
            }
        }
        Err(Failure::NotContracting(movement).into())
    }

    /// Over all unknowns: for held ones their velocity by `t`, for free ones the force by `t` that they are out of balance by, its sign turned.
    fn rate<F: Family>(&mut self, family: &mut F, x: &[f64], t: f64) -> Result<Vec<f64>, Stop<F::Refusal>> {
        let mut rate = vec![0.0; x.len()];
        // Where one side is impossible, as before 0 with a root of t, the other does.
        let here = family.moved(t).map_err(Stop::Refused)?;
        let (before, after) = (family.moved(t - RATE_STEP), family.moved(t + RATE_STEP));
        let span = RATE_STEP * (f64::from(u8::from(before.is_ok())) + f64::from(u8::from(after.is_ok())));
        let (before, after) = (before.as_ref().unwrap_or(&here), after.as_ref().unwrap_or(&here));
        for ((i, from), (_, to)) in before.iter().zip(after).filter(|_| span > 0.0) {
            rate[*i] = (to - from) / span;
        }
        self.system.clear();
        family.add_rate(t, x, &mut self.system).map_err(Stop::Refused)?;
        let mut forces = self.system.gradient.clone();
        if rate.iter().any(|v| *v != 0.0) {
            let potentials = &mut family.potentials();
            self.system.clear();
            self.system.prescribed = Some(rate.clone());
            potentials.iter_mut().for_each(|p| {
                p.assemble(x, Curvature::Mixed, &mut self.system);
            });
            self.system.prescribed = None;
            let moving = self.system.gradient.clone();
            let still = self.forces(potentials, x);
            forces.iter_mut().zip(moving.iter().zip(&still)).for_each(|(f, (m, s))| *f += m - s);
        }
        forces.iter().zip(self.numbering.unknowns()).for_each(|(f, u)| rate[*u as usize] = -f);
        Ok(rate)
    }
}

/// Chooses the lengths of steps along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcControl {
    /// Change of the load factor that the first step is to make by its tangent.
    pub first: f64,
    /// Iterations that a step should take.
    pub iterations: f64,
    /// Longest step over the first.
    pub longest: f64,
    /// Times that steps may be half as long as the first.
    pub max_halvings: u32,
    /// Length of the first step [m]; none before it. Part of the state.
    pub unit: Option<f64>,
    /// Length of the next step over that of the first; part of the state.
    pub share: f64,
}

impl ArcControl {
    /// Starts with a step that changes the load factor by `first`.
    pub fn new(first: f64, iterations: f64, longest: f64, max_halvings: u32) -> Self {
        ArcControl { first, iterations, longest, max_halvings, unit: None, share: 1.0 }
    }

    /// How far the next step is to go.
    pub fn reach(&self) -> Reach {
        self.unit.map_or(Reach::Factor(self.share * self.first), |unit| Reach::Length(self.share * unit))
    }

    /// After a step that took so many iterations and was that long [m].
    pub fn succeed(&mut self, iterations: u64, length: f64) {
        self.unit.get_or_insert(length / self.share);
        self.share = (self.share * growth(self.iterations, iterations)).min(self.longest);
    }

    /// After a step that failed: half of it. False when that is more than `max_halvings` below the first.
    pub fn fail(&mut self) -> bool {
        self.share *= 0.5;
        self.share >= 0.5f64.powi(self.max_halvings as i32) * (1.0 - 1e-9)
    }
}

/// What the next step is over the last, which took `taken` iterations where `desired` are: the root of their ratio, 1/2 to 2.
pub fn growth(desired: f64, taken: u64) -> f64 {
    (desired / taken.max(1) as f64).sqrt().clamp(0.5, 2.0)
}

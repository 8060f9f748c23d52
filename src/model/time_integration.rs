//! Integration in time. Each step is one minimisation, `1/(2 s^2) |z - y|_M^2 + E(z, t_z)`: of the state `z` at its end or, by the
//! generalised-alpha method, at a moment within it. A formula gives the moment `t_z`, the place `y` and the length `s` that stand for
//! inertia, and makes of `z` the positions and velocities at the end.
//!
//! * implicit Euler: `y = x + dt v`, `s = dt`. First order; damps what the step does not resolve.
//! * BDF2 (variable steps, `r = dt / dt_prev`): `v' = D x'`, `a' = D v'`, `D u' = (a0 u' + a1 u + a2 u_prev) / dt` with
//!   `a0 = (1 + 2r)/(1 + r)`, `a1 = -(1 + r)`, `a2 = r^2/(1 + r)`. Second order, L-stable.
//! * generalised-alpha (Chung and Hulbert, J. Appl. Mech. 60, 1993) with the forces of the state `z = (1 - alpha_f) x' + alpha_f x` at
//!   `t_z = t + (1 - alpha_f) dt`: second order, with the spectral radius of one's choice for frequencies that the step does not resolve.
//!   Radius 1 is the implicit midpoint rule, which keeps linear and angular momentum and has no memory. With a smaller one the acceleration
//!   `A` that a step leaves is that of `delta dt` past its end, `delta = alpha_m - alpha_f`. To be of second order where steps change in size, a
//!   step moves it to `delta` times its own size, along the line through the last two, as long as it is at most [`LARGEST_RATIO`] times as long
//!   as the one before: further on that line frequencies that the step does not resolve may grow.
//!
//! The first step of the two methods of second order is one of the midpoint rule, which needs no earlier state; its acceleration, that at the
//! middle, is what the accelerations of generalised-alpha start with. BDF2 also falls back on it where a step is more than
//! [`LARGEST_RATIO`] times as long as the one before.
//!
//! Directors have no inertia: their angles are in equilibrium with the state `z`. Where that is not the end of the step, they go on to it by
//! the turn about their edges since the last state that was in equilibrium. Rates of strain for viscosity are differences over the last two
//! such states for implicit Euler, over the last three, of second order, for the others.

use super::state::take_field;
use crate::shell::Strain;
use crate::snapshot::{Association, Field, Snapshot};
use nalgebra::Vector3;

/// Largest ratio of a step to the one before for BDF2, which is stable up to `1 + sqrt(2)`, as is generalised-alpha of radius 0 in steps that are
/// longer and shorter in turn, with accelerations moved from one size to the other; larger radii are beyond that.
pub const LARGEST_RATIO: f64 = 2.4;

/// Kind of time integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// First order, dissipative.
    ImplicitEuler,
    /// Backward differentiation of second order.
    Bdf2,
    /// Generalised-alpha.
    GeneralisedAlpha {
        /// Spectral radius at infinite frequency, 0 to 1.
        spectral_radius: f64,
    },
}

impl Integrator {
    /// Order of accuracy.
    pub fn order(self) -> u32 {
        if self == Integrator::ImplicitEuler { 1 } else { 2 }
    }
}

/// The formula of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Formula {
    Euler,
    /// Ratio of the step to the one before.
    Bdf2(f64),
    /// `alpha_f` and `alpha_m`.
    Alpha(f64, f64),
}

const MIDPOINT: Formula = Formula::Alpha(0.5, 0.5);

impl Formula {
    /// `gamma` and `beta` of generalised-alpha.
    fn newmark(alpha_f: f64, alpha_m: f64) -> [f64; 2] {
        let shift = alpha_m - alpha_f;
        [0.5 - shift, 0.25 * (1.0 - shift) * (1.0 - shift)]
    }

    /// `a0`, `a1`, `a2` of BDF2.
    fn backward(r: f64) -> [f64; 3] {
        [(1.0 + 2.0 * r) / (1.0 + r), -(1.0 + r), r * r / (1.0 + r)]
    }

    /// `C` in the error `C dt^(p + 1) d^(p + 1)x/dt^(p + 1)` that one step adds to the positions, `p` being the order. `before`: that of the step
    /// before, whose error is part of the difference that BDF2 takes: along its own solution it is 1/3 in even steps, 2/9 were the past exact.
    fn error_constant(self, before: f64) -> f64 {
        match self {
            Formula::Euler => 0.5,
            Formula::Bdf2(r) => {
                let [a0, _, a2] = Formula::backward(r);
                ((1.0 + r) / (6.0 * r) + a2 * before / (r * r * r)) / a0
            }
            Formula::Alpha(alpha_f, alpha_m) => 1.0 / 12.0 + 0.25 * (alpha_m - alpha_f) * (alpha_m - alpha_f),
        }
    }
}

/// One step as a minimisation.
pub struct Stage {
    formula: Formula,
    /// Size of the step [s].
    dt: f64,
    /// Positions [m] and velocities [m/s] that it starts from.
    start: [Vec<f64>; 2],
    /// Acceleration [m/s2] of generalised-alpha that it starts from, moved to its size; empty for none.
    acceleration: Vec<f64>,
    /// Share of the step after which the state is sought, 1 for its end.
    pub share: f64,
    /// That moment [s].
    pub time: f64,
    /// Place `y` [m] of inertia, over the coordinates.
    pub predicted: Vec<f64>,
    /// Length `s` of inertia [s].
    pub length: f64,
}

impl Stage {
    /// Whether the velocities at the start must agree with what is prescribed, because the formula has no damping for what does not.
    pub fn is_midpoint(&self) -> bool {
        self.formula == MIDPOINT
    }

    /// The value at the moment of the state, of one that goes from `from` at the start of the step to `to` at its end.
    pub fn between(&self, from: f64, to: f64) -> f64 {
        if self.share == 1.0 { to } else { from + self.share * (to - from) }
    }

    /// Positions [m] at the moment of the state as far as the start tells, to the order of the method.
    pub fn guess(&self) -> Vec<f64> {
        let [x, v] = &self.start;
        if self.formula == Formula::Euler { x.clone() } else { x.iter().zip(v).map(|(x, v)| x + self.share * self.dt * v).collect() }
    }

    /// The value at the end of the step that [`Stage::between`] makes `z` of.
    fn end(&self, from: f64, z: f64) -> f64 {
        if self.share == 1.0 { z } else { from + (z - from) / self.share }
    }
}

/// A kind of time integration with its memory. What it does not need is empty.
pub struct TimeIntegration {
    integrator: Integrator,
    /// Whether errors are to be estimated.
    estimates: bool,
    /// Size of the step before [s]; 0 before the first.
    dt: f64,
    /// Positions [m] at the start of the step before, for BDF2.
    positions: Vec<f64>,
    /// Velocities [m/s] there, for BDF2 and estimates of second order.
    velocities: Vec<f64>,
    /// Acceleration [m/s2] of generalised-alpha with dissipation at the end of the last step, and that which this step started from.
    accelerations: [Vec<f64>; 2],
    /// Constant of the error of the step before, of BDF2 with estimates.
    error_constant: f64,
    /// Time of the last state that was in equilibrium, and with viscosity of the one before [s].
    times: [f64; 2],
    /// Directors of the last state in equilibrium, where it was not the present one.
    directors: Vec<Vector3<f64>>,
    /// Forms of the last states in equilibrium, with viscosity.
    forms: [Vec<Strain>; 2],
}

impl TimeIntegration {
    /// `estimates`: whether [`TimeIntegration::finish`] estimates errors.
    pub fn new(integrator: Integrator, estimates: bool) -> Self {
        TimeIntegration {
            integrator,
            estimates,
            dt: 0.0,
            positions: Vec::new(),
            velocities: Vec::new(),
            accelerations: Default::default(),
            error_constant: 0.0,
            times: [0.0; 2],
            directors: Vec::new(),
            forms: Default::default(),
        }
    }

    /// Kind.
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    fn formula(&self, dt: f64) -> Formula {
        match self.integrator {
            Integrator::ImplicitEuler => Formula::Euler,
            _ if self.dt == 0.0 => MIDPOINT,
            Integrator::Bdf2 if dt > LARGEST_RATIO * self.dt => MIDPOINT,
            Integrator::Bdf2 => Formula::Bdf2(dt / self.dt),
            Integrator::GeneralisedAlpha { spectral_radius: r } => Formula::Alpha(r / (1.0 + r), (2.0 * r - 1.0) / (1.0 + r)),
        }
    }

    /// The step of size `dt` [s] from `time` [s] to `end`. `x`, `v`: positions and velocities; `consistent`: those velocities of what is
    /// prescribed, by coordinates, that agree with its motion in this step.
    pub fn stage(&self, x: &[f64], v: &[f64], dt: f64, [time, end]: [f64; 2], consistent: impl FnOnce() -> Vec<(usize, f64)>) -> Stage {
        let formula = self.formula(dt);
        let mut v = v.to_vec();
        if formula == MIDPOINT {
            consistent().into_iter().for_each(|(i, value)| v[i] = value);
        }
        let acceleration = if matches!(formula, Formula::Alpha(..)) { self.moved_acceleration(formula, dt) } else { Vec::new() };
        let (share, length, predicted): (f64, f64, Vec<f64>) = match formula {
            Formula::Euler => (1.0, dt, x.iter().zip(&v).map(|(x, v)| x + dt * v).collect()),
            Formula::Bdf2(r) => {
                let [a0, a1, a2] = Formula::backward(r);
                let of = |i: usize| -(a1 * x[i] + a2 * self.positions[i]) / a0 - dt * (a1 * v[i] + a2 * self.velocities[i]) / (a0 * a0);
                (1.0, dt / a0, (0..v.len()).map(of).collect())
            }
            Formula::Alpha(alpha_f, alpha_m) => {
                let ([_, beta], share) = (Formula::newmark(alpha_f, alpha_m), 1.0 - alpha_f);
                let square = share * beta * dt * dt / (1.0 - alpha_m);
                let of_acceleration = share * dt * dt * (0.5 - beta) - alpha_m * square;
                let of = |i: usize| x[i] + share * dt * v[i] + acceleration.get(i).map_or(0.0, |a| of_acceleration * a);
                (share, square.sqrt(), (0..v.len()).map(of).collect())
            }
        };
        let moment = if share == 1.0 { end } else { time + share * dt };
        Stage { formula, dt, start: [x[..v.len()].to_vec(), v], acceleration, share, time: moment, predicted, length }
    }

    /// The acceleration that a step of size `dt` starts from: that of the last step, at `delta` times the new size past its end.
    fn moved_acceleration(&self, formula: Formula, dt: f64) -> Vec<f64> {
        let [last, before] = &self.accelerations;
        let Formula::Alpha(alpha_f, alpha_m) = formula else { return Vec::new() };
        if dt == self.dt || dt > LARGEST_RATIO * self.dt || before.is_empty() {
            return last.clone();
        }
        let further = (alpha_m - alpha_f) * (dt - self.dt) / self.dt;
        last.iter().zip(before).map(|(last, before)| last + further * (last - before)).collect()
    }

    /// `w` [m] and `d` [s] of the velocity `(z - w) / d` that the formula gives a state `z` at its moment, over the coordinates.
    pub fn velocity(&self, stage: &Stage) -> (Vec<f64>, f64) {
        let ([x, v], dt) = (&stage.start, stage.dt);
        match stage.formula {
            Formula::Euler => (x.clone(), dt),
            Formula::Bdf2(r) => {
                let [a0, a1, a2] = Formula::backward(r);
                (x.iter().zip(&self.positions).map(|(x, before)| -(a1 * x + a2 * before) / a0).collect(), dt / a0)
            }
            Formula::Alpha(alpha_f, alpha_m) => {
                let [gamma, beta] = Formula::newmark(alpha_f, alpha_m);
                let of_acceleration = |i: usize| (0.5 * gamma / beta - 1.0) * dt * stage.acceleration.get(i).copied().unwrap_or(0.0);
                // The velocity of a state that has not moved.
                let still = |i: usize| v[i] - (1.0 - alpha_f) * (gamma / beta * v[i] + of_acceleration(i));
                let interval = beta / gamma * dt;
                ((0..v.len()).map(|i| x[i] - interval * still(i)).collect(), interval)
            }
        }
    }

    /// Forms at the start and interval [s] whose difference quotient is the rate of strain at a moment [s]. `present`: forms of the present
    /// state, at time `now`, asked for where no earlier one is known.
    pub fn strain_start(&mut self, moment: f64, now: f64, present: impl FnOnce() -> Vec<Strain>) -> (Vec<Strain>, f64) {
        if self.integrator == Integrator::ImplicitEuler {
            return (present(), moment - now);
        }
        if self.forms[0].is_empty() {
            (self.forms[0], self.times[0]) = (present(), now);
        }
        let s = self.times.map(|time| moment - time);
        if self.forms[1].is_empty() {
            return (self.forms[0].clone(), s[0]);
        }
        let weight = 1.0 / s[0] + 1.0 / s[1];
        let (last, before) = (s[1] / (s[0] * (s[1] - s[0])) / weight, -s[0] / (s[1] * (s[1] - s[0])) / weight);
        let mix = |(a, b): (&Strain, &Strain)| std::array::from_fn(|i| last * a[i] + before * b[i]);
        (self.forms[0].iter().zip(&self.forms[1]).map(mix).collect(), 1.0 / weight)
    }

    /// Directors of the last state in equilibrium, where they are not the present ones.
    pub fn directors(&self) -> Option<&[Vector3<f64>]> {
        (!self.directors.is_empty()).then_some(&self.directors)
    }

    /// Turn of a director from the state of a stage to the end of its step, over that to this state since the last one in equilibrium.
    pub fn further_turn(&self, stage: &Stage, [time, end]: [f64; 2]) -> f64 {
        let last = if self.directors.is_empty() { time } else { self.times[0] };
        (end - stage.time) / (stage.time - last)
    }

    /// Positions and velocities at the end of a step from the coordinates `z` of its state.
    pub fn finish(&self, stage: &Stage, z: &[f64]) -> [Vec<f64>; 2] {
        let ([x, v], dt) = (&stage.start, stage.dt);
        let end: Vec<f64> = x.iter().zip(z).map(|(x, z)| stage.end(*x, *z)).collect();
        let velocity = match stage.formula {
            Formula::Euler => end.iter().zip(x).map(|(now, before)| (now - before) / dt).collect(),
            Formula::Bdf2(r) => {
                let [a0, a1, a2] = Formula::backward(r);
                (0..v.len()).map(|i| (a0 * end[i] + a1 * x[i] + a2 * self.positions[i]) / dt).collect()
            }
            Formula::Alpha(alpha_f, alpha_m) => {
                let [gamma, _] = Formula::newmark(alpha_f, alpha_m);
                let next = Self::next_acceleration(stage, &end);
                let now = |i: usize| stage.acceleration.get(i).copied().unwrap_or(0.0);
                (0..v.len()).map(|i| v[i] + dt * ((1.0 - gamma) * now(i) + gamma * next[i])).collect()
            }
        };
        [end, velocity]
    }

    /// Acceleration of generalised-alpha at the end of a step.
    fn next_acceleration(stage: &Stage, end: &[f64]) -> Vec<f64> {
        let Formula::Alpha(alpha_f, alpha_m) = stage.formula else { return Vec::new() };
        let ([_, beta], [x, v], dt) = (Formula::newmark(alpha_f, alpha_m), &stage.start, stage.dt);
        let now = |i: usize| stage.acceleration.get(i).copied().unwrap_or(0.0);
        let next = |i: usize| (end[i] - x[i] - dt * v[i]) / (beta * dt * dt) - (0.5 / beta - 1.0) * now(i);
        (0..v.len()).map(next).collect()
    }

    /// Estimate of the error [m] that a step has added to each coordinate, by its distance from an extrapolation of the steps before; none
    /// where errors are not estimated. In a first step of second order that is only an extrapolation of first order, which overestimates it.
    pub fn errors(&self, stage: &Stage, end: &[f64]) -> Option<Vec<f64>> {
        let ([x, v], dt) = (&stage.start, stage.dt);
        let constant = stage.formula.error_constant(self.error_constant);
        let of: Box<dyn Fn(usize) -> f64> = if stage.formula == Formula::Euler || self.velocities.is_empty() {
            Box::new(|i| 0.5 * (end[i] - x[i] - dt * v[i]))
        } else {
            let r = dt / self.dt;
            let share = constant / (constant + 1.0 / 6.0 + 0.25 / r);
            Box::new(move |i| share * (end[i] - x[i] - dt * v[i] - 0.5 * dt * r * (v[i] - self.velocities[i])))
        };
        self.estimates.then(|| (0..v.len()).map(of).collect())
    }

    /// Remembers an accepted step. `end`, `velocity`: of [`TimeIntegration::finish`]; `directors`: those of its state; `forms`: of its state,
    /// empty without viscosity.
    pub fn accept(&mut self, stage: Stage, [end, velocity]: [&[f64]; 2], directors: Vec<Vector3<f64>>, forms: Vec<Strain>) {
        let dt = stage.dt;
        match self.integrator {
            Integrator::ImplicitEuler => return,
            Integrator::GeneralisedAlpha { spectral_radius } if spectral_radius < 1.0 => {
                // That of the midpoint rule is one number at both ends and in between.
                let next = if stage.is_midpoint() {
                    velocity.iter().zip(&stage.start[1]).map(|(now, v)| (now - v) / dt).collect()
                } else {
                    Self::next_acceleration(&stage, end)
                };
                self.accelerations = [next, stage.acceleration];
            }
            _ => {}
        }
        if self.integrator == Integrator::Bdf2 && self.estimates {
            self.error_constant = stage.formula.error_constant(self.error_constant);
        }
        self.dt = dt;
        let [x, v] = stage.start;
        if self.integrator == Integrator::Bdf2 {
            self.positions = x;
        }
        if self.estimates || self.integrator == Integrator::Bdf2 {
            self.velocities = v;
        }
        self.times = [stage.time, self.times[0]];
        self.directors = if stage.share == 1.0 { Vec::new() } else { directors };
        if !forms.is_empty() {
            self.forms[1] = std::mem::replace(&mut self.forms[0], forms);
        }
    }

    /// Adds the memory to a snapshot.
    pub fn put(&self, snapshot: &mut Snapshot) {
        if self.dt == 0.0 {
            return;
        }
        let mut add = |name: &str, association, components, unit: &str, data: Vec<f64>| {
            if !data.is_empty() {
                snapshot.fields.push(Field { name: name.into(), association, components, unit: unit.into(), data });
            }
        };
        add("previous_position", Association::Node, 3, "m", self.positions.clone());
        add("previous_velocity", Association::Node, 3, "m/s", self.velocities.clone());
        for (name, acceleration) in ["acceleration", "previous_acceleration"].iter().zip(&self.accelerations) {
            add(name, Association::Node, 3, "m/s2", acceleration.clone());
        }
        add("previous_director", Association::Director, 3, "1", self.directors.iter().flat_map(|d| [d.x, d.y, d.z]).collect());
        for (name, forms) in ["previous_forms", "forms_before_previous"].iter().zip(&self.forms) {
            add(name, Association::Point, 6, "m2, m", forms.iter().flatten().copied().collect());
        }
        snapshot.numbers.extend([("previous_dt".to_owned(), self.dt), ("previous_time".to_owned(), self.times[0])]);
        if !self.forms[1].is_empty() {
            snapshot.numbers.push(("time_before_previous".to_owned(), self.times[1]));
        }
        if self.error_constant > 0.0 {
            snapshot.numbers.push(("previous_error_constant".to_owned(), self.error_constant));
        }
    }

    /// Takes the memory from a snapshot with `coordinates` coordinates, `directors` directors and `points` integration points.
    ///
    /// # Errors
    /// A field that is missing or of another size.
    pub fn take(&mut self, snapshot: &Snapshot, coordinates: usize, directors: usize, points: usize) -> Result<(), String> {
        *self = TimeIntegration::new(self.integrator, self.estimates);
        let Some(dt) = snapshot.number("previous_dt") else { return Ok(()) };
        let number = |name: &str| snapshot.number(name).unwrap_or(0.0);
        let optional = |name: &str, length: usize| {
            if snapshot.field(name).is_some() { take_field(snapshot, name, length) } else { Ok(Vec::new()) }
        };
        self.dt = dt;
        self.times = ["previous_time", "time_before_previous"].map(number);
        self.error_constant = number("previous_error_constant");
        if self.integrator == Integrator::Bdf2 {
            self.positions = take_field(snapshot, "previous_position", coordinates)?;
        }
        if self.integrator == Integrator::Bdf2 || self.estimates {
            self.velocities = take_field(snapshot, "previous_velocity", coordinates)?;
        }
        if matches!(self.integrator, Integrator::GeneralisedAlpha { spectral_radius } if spectral_radius < 1.0) {
            self.accelerations = [take_field(snapshot, "acceleration", coordinates)?, optional("previous_acceleration", coordinates)?];
        }
        let vectors = optional("previous_director", 3 * directors)?;
        self.directors = vectors.chunks_exact(3).map(|d| Vector3::new(d[0], d[1], d[2])).collect();
        for (forms, name) in self.forms.iter_mut().zip(["previous_forms", "forms_before_previous"]) {
            *forms = optional(name, 6 * points)?.chunks_exact(6).map(|f| std::array::from_fn(|i| f[i])).collect();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [Integrator; 6] = [
        Integrator::ImplicitEuler,
        Integrator::Bdf2,
        Integrator::GeneralisedAlpha { spectral_radius: 1.0 },
        Integrator::GeneralisedAlpha { spectral_radius: 0.8 },
        Integrator::GeneralisedAlpha { spectral_radius: 0.5 },
        Integrator::GeneralisedAlpha { spectral_radius: 0.0 },
    ];

    /// The oscillator `x'' = -x` from `x = 0`, `x' = 1` by `count` steps to time 8; `visit` gets the integration, the stage and the end of each
    /// step before it is accepted. Sizes go through `pattern` again and again. Returns positions and velocities at the ends.
    fn oscillate(
        kind: Integrator,
        count: usize,
        pattern: &[f64],
        mut visit: impl FnMut(&TimeIntegration, &Stage, &[f64]),
    ) -> Vec<[f64; 3]> {
        let sizes: Vec<f64> = pattern.iter().cycle().take(count).copied().collect();
        let unit = 8.0 / sizes.iter().sum::<f64>();
        let (mut integration, mut x, mut v, mut time) = (TimeIntegration::new(kind, true), vec![0.0], vec![1.0], 0.0);
        let mut all = Vec::new();
        for size in sizes {
            let dt = size * unit;
            let stage = integration.stage(&x, &v, dt, [time, time + dt], Vec::new);
            // The least of (z - y)^2 / (2 s^2) + z^2 / 2.
            let z = stage.predicted[0] / (1.0 + stage.length * stage.length);
            let [end, velocity] = integration.finish(&stage, &[z]);
            visit(&integration, &stage, &end);
            integration.accept(stage, [&end, &velocity], Vec::new(), Vec::new());
            (x, v, time) = (end, velocity, time + dt);
            all.push([time, x[0], v[0]]);
        }
        all
    }

    #[test]
    fn orders_do_not_depend_on_even_steps() {
        for kind in KINDS {
            for pattern in [&[1.0][..], &[4.0, 2.0], &[1.0, 2.0, 0.9, 0.9, 2.0]] {
                let errors = [320, 640, 1280].map(|count| {
                    let [time, x, v] = oscillate(kind, count, pattern, |_, _, _| ())[count - 1];
                    (x - time.sin()).abs().max((v - time.cos()).abs())
                });
                for pair in errors.windows(2) {
                    let order = (pair[0] / pair[1]).log2();
                    assert!((order - f64::from(kind.order())).abs() < 0.05, "{kind:?} {pattern:?}: {errors:?}, order {order}");
                }
            }
        }
    }

    /// Estimated errors are those that the steps add. What a solution errs by follows the same equation, here `e'' = -e` between steps, so that
    /// what a step adds is its end less the turn of the error at its start.
    #[test]
    fn estimates_are_the_errors_that_steps_add() {
        for kind in KINDS {
            for pattern in [&[1.0][..], &[4.0, 3.0], &[1.0, 2.0, 0.9, 0.9, 2.0]] {
                let (mut estimates, mut sizes) = (Vec::new(), Vec::new());
                let all = oscillate(kind, 2000, pattern, |integration, stage, end| {
                    estimates.push(integration.errors(stage, end).unwrap_or_default()[0]);
                    sizes.push(stage.dt);
                });
                let error = |[time, x, v]: [f64; 3]| [x - time.sin(), v - time.cos()];
                // Where what is differentiated is not small.
                for n in (1000..1990).filter(|n| if kind.order() == 1 { all[*n][1] } else { all[*n][2] }.abs() > 0.5) {
                    let ([x, v], dt) = (error(all[n - 1]), sizes[n]);
                    let added = error(all[n])[0] - (x * dt.cos() + v * dt.sin());
                    assert!((estimates[n] / added - 1.0).abs() < 0.03, "{kind:?} {pattern:?}, step {n}: {} {added}", estimates[n]);
                }
            }
        }
    }
}

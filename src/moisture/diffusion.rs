//! The diffusion equation advanced in time.
//!
//! Every step consists of stages of one kind: from values `w`, find `w + d` with `M d + tau K (w + d) = tau f`. It is solved for the change `d`,
//! so round-off shrinks with it, and everything that enters is counted as it stands in the equation: held unknowns by their reaction.

use super::condition::{BOTTOM, Condition, Law, RIM, Source, Surface, TOP, at_least, datum};
use super::operator::{Operator, shares};
use super::slab::{Mass, Slab};
use crate::error::{Error, Result};
use crate::sparse::{Cholesky, Kind};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// How time advances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// First order. With lumped mass it keeps values between their bounds for every step (see [`Mass::Lumped`]).
    BackwardEuler,
    /// Second order, L-stable, two stages with one matrix (Alexander, SIAM J. Numer. Anal. 14, 1977; the diagonal is `1 - 1/sqrt 2`). No
    /// method of an order above one keeps bounds for every step (Bolley and Crouzeix, RAIRO Anal. Numer. 12, 1978); this one leaves them
    /// after a jump where the step is long against the time to cross a layer, and comes back.
    Sdirk2,
}

/// Content, and what entered since [`Diffusion::set`] [u m3].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Present content: the integral of `u`.
    pub content: f64,
    /// Through the top.
    pub top: f64,
    /// Through the bottom.
    pub bottom: f64,
    /// Through the rim.
    pub rim: f64,
    /// From the source.
    pub sources: f64,
}

/// Number of the source among what enters, after the parts of the surface.
const SOURCES: usize = 3;
/// Marks an unknown that no condition holds.
const FREE: u32 = u32::MAX;

/// What a matrix depends on.
#[derive(Clone)]
struct Constraints {
    /// Condition that holds each unknown, or [`FREE`].
    holder: Vec<u32>,
    /// Coefficient of exchange times area of each unknown [m3/s].
    exchange: Vec<f64>,
}

/// Least and greatest value that the data so far allow.
#[derive(Clone, Copy)]
struct Bounds {
    low: f64,
    high: f64,
}

impl Bounds {
    /// A value that moisture had or has next to it.
    fn see(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    /// Something came from nowhere or went: there is no bound on that side.
    fn moved(&mut self, rate: f64) {
        if rate != 0.0 {
            self.see(rate * f64::INFINITY);
        }
    }
}

/// Values of moisture on a slab, advanced in time.
pub struct Diffusion {
    operator: Operator,
    levels: Vec<f64>,
    surfaces: Vec<Surface>,
    source: Option<Source>,
    scheme: Scheme,
    dt: Option<f64>,
    /// Values [u].
    u: Vec<f64>,
    /// What entered [u m3]: parts of the surface, sources.
    entered: [f64; 4],
    bounds: Bounds,
    /// What given and outside values must not be below.
    least: f64,
    /// Length of the last sub-steps [s].
    size: f64,
    /// Which conditions are in their window.
    active: Vec<bool>,
    now: Constraints,
    factored: Constraints,
    factored_size: f64,
    cholesky: Cholesky,
    factorizations: u64,
    matrix: Vec<f64>,
    /// Start values of a stage, then its result.
    w: Vec<f64>,
    /// Sudden changes of held values, or values of the source.
    jump: Vec<f64>,
    right: Vec<f64>,
    change: Vec<f64>,
}

impl Diffusion {
    /// Zero moisture on a slab. `dt`: longest sub-step [s]; without it [`advance`](Self::advance) takes one between switches of conditions.
    ///
    /// # Errors
    /// A slab or conditions that are not meaningful; out of memory.
    pub fn new(
        slab: Slab,
        conditions: Vec<Condition>,
        source: Option<Source>,
        mass: Mass,
        scheme: Scheme,
        dt: Option<f64>,
    ) -> Result<Self> {
        slab.check()?;
        if let Some(dt) = dt
            && !(dt > 0.0)
        {
            return Err(Error::input("moisture", format!("{dt} s is not a step of time")));
        }
        let shares = shares(&slab.levels);
        let surfaces = conditions.into_iter().map(|c| Surface::new(c, &slab, &shares)).collect::<Result<Vec<_>>>()?;
        let operator = Operator::new(&slab, mass)?;
        let cholesky = operator.analyse()?;
        let n = operator.volume.len();
        let constraints = Constraints { holder: vec![FREE; n], exchange: vec![0.0; n] };
        Ok(Diffusion {
            levels: slab.levels,
            active: vec![false; surfaces.len()],
            surfaces,
            source,
            scheme,
            dt,
            u: vec![0.0; n],
            entered: [0.0; 4],
            bounds: Bounds { low: 0.0, high: 0.0 },
            least: f64::NEG_INFINITY,
            size: 0.0,
            now: constraints.clone(),
            factored: constraints,
            factored_size: 0.0,
            cholesky,
            factorizations: 0,
            matrix: vec![0.0; operator.pattern.row.len()],
            w: vec![0.0; n],
            jump: vec![0.0; n],
            right: vec![0.0; n],
            change: vec![0.0; n],
            operator,
        })
    }

    /// Refuses given and outside values below this, beyond round-off.
    pub fn require_at_least(&mut self, least: f64) {
        self.least = least;
    }

    /// Starts anew from these values, one for each unknown: nothing has entered, and the bounds are those of `u`.
    ///
    /// # Panics
    /// On another number of values.
    pub fn set(&mut self, u: Vec<f64>) {
        assert_eq!(u.len(), self.u.len(), "one value for each vertex and level");
        self.entered = [0.0; 4];
        self.bounds = Bounds { low: f64::INFINITY, high: f64::NEG_INFINITY };
        u.iter().for_each(|u| self.bounds.see(*u));
        self.u = u;
    }

    /// Present values [u]; vertex `v` at level `l` is `v * levels + l`.
    pub fn values(&self) -> &[f64] {
        &self.u
    }

    /// Heights of the levels as fractions of the thickness, 0 at the bottom.
    pub fn levels(&self) -> &[f64] {
        &self.levels
    }

    /// Number of numeric factorisations so far.
    pub fn factorizations(&self) -> u64 {
        self.factorizations
    }

    /// Content and what entered.
    pub fn balance(&self) -> Balance {
        let [top, bottom, rim, sources] = [TOP, BOTTOM, RIM, SOURCES].map(|part| self.entered[part]);
        Balance { content: self.operator.volume.iter().zip(&self.u).map(|(volume, u)| volume * u).sum(), top, bottom, rim, sources }
    }

    /// How far values lie outside the bounds of all data so far (initial, given and outside values) [u], 0 or more. There is no upper bound
    /// once a flux or a source brought something, no lower one once it took something.
    pub fn overshoot(&self) -> f64 {
        let Bounds { low, high } = self.bounds;
        self.u.iter().fold(0.0, |far, u| far.max(low - u).max(u - high))
    }

    /// What a run needs, beside the values, to go on with the same bits.
    pub fn state(&self) -> Vec<f64> {
        [&self.entered[..], &[self.bounds.low, self.bounds.high, self.size]].concat()
    }

    /// Puts back what [`state`](Self::state) gave, after [`set`](Self::set). Errors: another number of entries.
    pub fn restore(&mut self, state: &[f64]) -> Result<(), String> {
        let [top, bottom, rim, sources, low, high, size] = *state else {
            return Err(format!("the state of the moisture has {} numbers, not 7", state.len()));
        };
        self.entered = [top, bottom, rim, sources];
        self.bounds = Bounds { low, high };
        self.size = size;
        Ok(())
    }

    /// Advances from one time to another [s]. `heights`: present z of every vertex [m], read only if a condition has `below`.
    ///
    /// Conditions switch at their own times; in between, steps are equal. Data are taken at the ends of stages, and given values also at the
    /// moment when they are put in force. The matrix is factorised anew only if conditions in force, held vertices or the step change; steps
    /// that differ by no more than the round-off of the times are equal.
    ///
    /// # Errors
    /// Data that are not finite, by vertex and time; more than 1e9 sub-steps. Values are then those of the last good sub-step.
    pub fn advance(&mut self, from: f64, to: f64, heights: &[f64]) -> Result<(), String> {
        if !(from <= to && from.is_finite() && to.is_finite()) {
            return Err(format!("moisture: no time passes from {from} s to {to} s"));
        }
        let vertices = self.u.len() / self.levels.len();
        if self.surfaces.iter().any(|s| s.below.is_some()) && heights.len() != vertices {
            return Err(format!("moisture: {} heights for {vertices} vertices", heights.len()));
        }
        let slack = 4.0 * f64::EPSILON * from.abs().max(to.abs());
        let mut start = from;
        while start < to {
            let switches = self.surfaces.iter().flat_map(Surface::window).filter(|t| *t > start + slack && *t < to - slack);
            let end = switches.fold(to, f64::min);
            self.interval(start, end, slack, heights)?;
            start = end;
        }
        Ok(())
    }

    /// Advances while conditions stay as they are.
    fn interval(&mut self, start: f64, end: f64, slack: f64, heights: &[f64]) -> Result<(), String> {
        self.constrain(0.5 * (start + end), heights)?;
        let length = end - start;
        let steps = self.dt.map_or(1.0, |dt| ((length - slack) / dt).ceil().max(1.0));
        if steps > 1e9 {
            return Err(format!("moisture: {steps:e} steps from {start} s to {end} s: expected a billion at most"));
        }
        if ((length / steps - self.size) * steps).abs() > slack {
            self.size = length / steps;
        }
        let tau = match self.scheme {
            Scheme::BackwardEuler => self.size,
            Scheme::Sdirk2 => self.size * (1.0 - FRAC_1_SQRT_2),
        };
        self.factorise(tau)?;
        self.w.copy_from_slice(&self.u);
        let entered = self.hold(start, heights)?;
        self.take(&entered, 1.0);
        self.u.copy_from_slice(&self.w);
        let mut time = start;
        let mut step = 0.0;
        while step < steps {
            step += 1.0;
            let next = if step == steps { end } else { start + length * (step / steps) };
            match self.scheme {
                Scheme::BackwardEuler => {
                    let entered = self.stage(next, tau, heights)?;
                    self.take(&entered, 1.0);
                }
                Scheme::Sdirk2 => {
                    // The second stage starts where the slope of the first one leads: 1 - gamma of the way, as gamma is done.
                    const FURTHER: f64 = 1.0 + SQRT_2;
                    let first = self.stage(time + (1.0 - FRAC_1_SQRT_2) * (next - time), tau, heights)?;
                    self.w.iter_mut().zip(&self.u).for_each(|(w, u)| *w = u + FURTHER * (*w - u));
                    let second = self.stage(next, tau, heights)?;
                    self.take(&first, FURTHER);
                    self.take(&second, 1.0);
                }
            }
            self.u.copy_from_slice(&self.w);
            time = next;
        }
        Ok(())
    }

    fn take(&mut self, entered: &[f64; 4], factor: f64) {
        self.entered.iter_mut().zip(entered).for_each(|(sum, e)| *sum += factor * e);
    }

    /// Looks up which conditions are in force where.
    fn constrain(&mut self, time: f64, heights: &[f64]) -> Result<(), String> {
        let levels = self.levels.len();
        let Constraints { holder, exchange } = &mut self.now;
        holder.fill(FREE);
        exchange.fill(0.0);
        for (c, surface) in self.surfaces.iter().enumerate() {
            self.active[c] = surface.in_window(time);
            if !self.active[c] {
                continue;
            }
            match &surface.law {
                Law::Value(_) => surface.each(levels, heights, |_| Ok(0.0), |i, _, _| holder[i] = c as u32)?,
                Law::Exchange { coefficient, .. } => {
                    surface.each(levels, heights, |_| Ok(0.0), |i, area, _| exchange[i] += coefficient * area)?;
                }
                Law::Flux(_) => {}
            }
        }
        Ok(())
    }

    /// Factorises the matrix of a stage unless it stands.
    fn factorise(&mut self, tau: f64) -> Result<(), String> {
        let Constraints { holder, exchange } = &self.now;
        let held_alike = holder.iter().zip(&self.factored.holder).all(|(a, b)| (*a == FREE) == (*b == FREE));
        if self.factored_size == self.size && held_alike && *exchange == self.factored.exchange {
            return Ok(());
        }
        self.operator.matrix(tau, exchange, |i| holder[i] != FREE, &mut self.matrix);
        // An unusable factor must not be taken for a good one.
        self.factored_size = 0.0;
        let levels = self.levels.len();
        self.cholesky.refactor(&self.operator.pattern, &self.matrix, Kind::Llt).map_err(|pivot| {
            format!("moisture: the matrix is not positive definite at vertex {} with steps of {} s", pivot.unknown / levels, self.size)
        })?;
        self.factorizations += 1;
        self.factored_size = self.size;
        self.factored.holder.copy_from_slice(holder);
        self.factored.exchange.copy_from_slice(exchange);
        Ok(())
    }

    /// Puts given values into `w`, their changes into `jump`, and returns what those bring.
    fn hold(&mut self, time: f64, heights: &[f64]) -> Result<[f64; 4], String> {
        let mut entered = [0.0; 4];
        let (w, jump, bounds, volume, least) = (&mut self.w, &mut self.jump, &mut self.bounds, &self.operator.volume, self.least);
        jump.fill(0.0);
        for (c, surface) in self.surfaces.iter().enumerate() {
            let Law::Value(data) = &surface.law else { continue };
            if !self.active[c] {
                continue;
            }
            let value = |v| at_least(least, data(v, time), "given value", v, time);
            surface.each(self.levels.len(), heights, value, |i, _, value| {
                if self.now.holder[i] == c as u32 {
                    jump[i] = value - w[i];
                    w[i] = value;
                    entered[surface.part] += volume[i] * jump[i];
                    bounds.see(value);
                }
            })?;
        }
        Ok(entered)
    }

    /// One stage that ends at `time`: replaces the values `w` and returns what entered.
    fn stage(&mut self, time: f64, tau: f64, heights: &[f64]) -> Result<[f64; 4], String> {
        self.hold(time, heights)?;
        let mut entered = [0.0; 4];
        let (right, levels) = (&mut self.right, self.levels.len());
        right.fill(0.0);
        self.operator.add_mass(-1.0, &self.jump, right);
        self.operator.add_stiffness(-tau, &self.w, right);
        let bounds = &mut self.bounds;
        if let Some(source) = &self.source {
            for (k, rate) in self.jump.iter_mut().enumerate() {
                let (v, height) = (k / levels, self.levels[k % levels]);
                *rate = datum((source.rate)(v, height, time), "source", v, time)?;
                bounds.moved(*rate);
                entered[SOURCES] += tau * self.operator.volume[k] * *rate;
            }
            self.operator.add_mass(tau, &self.jump, right);
        }
        for (surface, _) in self.surfaces.iter().zip(&self.active).filter(|(_, active)| **active) {
            let mut sum = 0.0;
            match &surface.law {
                Law::Value(_) => continue,
                Law::Flux(data) => {
                    let flux = |v| datum(data(v, time), "flux", v, time);
                    surface.each(levels, heights, flux, |i, area, flux| {
                        bounds.moved(flux);
                        right[i] += tau * area * flux;
                        sum += tau * area * flux;
                    })?;
                }
                Law::Exchange { coefficient, outside } => {
                    let outside = |v| at_least(self.least, outside(v, time), "outside value", v, time);
                    surface.each(levels, heights, outside, |i, area, outside| {
                        bounds.see(outside);
                        let flow = tau * coefficient * area * (outside - self.w[i]);
                        right[i] += flow;
                        sum += flow;
                    })?;
                }
            }
            entered[surface.part] += sum;
        }
        let holder = &self.now.holder;
        self.change.copy_from_slice(right);
        self.change.iter_mut().zip(holder).filter(|(_, holder)| **holder != FREE).for_each(|(change, _)| *change = 0.0);
        self.cholesky.solve(&mut self.change);
        if holder.iter().all(|holder| *holder == FREE) {
            // The sum of all equations has no stiffness; in it, the round-off of stiff equations would add to the content, or take from it.
            // Changes are scaled so that the sum is met, those up and those down the opposite way.
            let diagonal = self.operator.volume.iter().zip(&self.now.exchange).map(|(volume, exchange)| volume + tau * exchange);
            let (mut sum, mut size) = (0.0, 0.0);
            for (d, change) in diagonal.zip(&self.change) {
                sum += d * change;
                size += (d * change).abs();
            }
            let scale = if size > 0.0 { (entered.iter().sum::<f64>() - sum) / size } else { 0.0 };
            self.change.iter_mut().for_each(|change| *change += scale * change.abs());
        }
        for (surface, _) in self.surfaces.iter().zip(&self.active).filter(|(_, active)| **active) {
            let Law::Exchange { coefficient, .. } = surface.law else { continue };
            let mut sum = 0.0;
            surface.each(levels, heights, |_| Ok(0.0), |i, area, _| sum += tau * coefficient * area * self.change[i])?;
            entered[surface.part] -= sum;
        }
        right.iter_mut().for_each(|r| *r = -*r);
        self.operator.add_held_rows(tau, |i| holder[i] != FREE, &self.change, right);
        for (reaction, holder) in right.iter().zip(holder).filter(|(_, holder)| **holder != FREE) {
            entered[self.surfaces[*holder as usize].part] += reaction;
        }
        self.w.iter_mut().zip(&self.change).for_each(|(w, change)| *w += change);
        Ok(entered)
    }
}

//! Step sizes: nominal where all goes well, after the iterations of the last step ([`Adaptive`]), or as large as an estimated error allows
//! ([`ErrorControl`]); halved after a failure, cut to land on output times. Errors are estimated elsewhere. A run in which steps fail again and
//! again, each time they have grown, ends: the failures that it may have grow with the nominal steps that it has come.

use super::arc_length::growth;

/// Chooses steps by their errors: a PI controller (Gustafsson, ACM Trans. Math. Softw. 17, 1991) with the usual bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorControl {
    /// Power of the step with which the error of one step goes: the order of the method and 1.
    pub power: f64,
    /// Largest step [s], if it is bounded.
    pub largest: f64,
    /// Error over the allowed one of the last accepted step that was not cut, 1 at the start; part of the state.
    pub error: f64,
}

impl ErrorControl {
    /// Share of the step that would just be accurate enough.
    const SAFETY: f64 = 0.9;

    /// Factor on the step after one that was accepted with this error over the allowed one.
    fn after(&self, error: f64) -> f64 {
        let (now, before) = (error.max(1e-10), self.error.max(1e-10));
        (Self::SAFETY * now.powf(-0.7 / self.power) * before.powf(0.4 / self.power)).clamp(0.2, 2.0)
    }

    /// Factor on the step after one that was rejected.
    fn before(&self, error: f64) -> f64 {
        (Self::SAFETY * error.powf(-1.0 / self.power)).clamp(0.1, 0.9)
    }
}

/// Nominal steps whose failures a run may have at one place, as where a shell snaps.
const SPARE: f64 = 4.0;

/// Chooses step sizes between the start and the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepControl {
    /// Largest and usual step [s].
    pub nominal: f64,
    /// End of the run [s].
    pub end: f64,
    /// Distance of output times [s], if they are to be met.
    pub interval: Option<f64>,
    /// Times one step may be halved.
    pub max_halvings: u32,
    /// Present step [s]; part of the state.
    pub dt: f64,
    /// Steps since the last failure or growth; part of the state.
    pub successes: u32,
    /// Steps that failed since the start; part of the state.
    pub failures: u32,
    /// Where steps follow the iterations of the last; none where they are the nominal ones but after failures.
    pub adaptive: Option<Adaptive>,
    /// Whether the rest of less than two steps to an output time is taken in two equal ones, as methods that remember the steps before want it.
    pub is_even: bool,
    /// Choice by errors, if they choose.
    pub by_error: Option<ErrorControl>,
}

/// How steps follow the iterations of the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Iterations that a step should take.
    pub iterations: f64,
    /// Shortest step after failures [s]; none: as `max_halvings` says.
    pub shortest: Option<f64>,
    /// Longest step [s].
    pub longest: f64,
}

/// One step to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepPlan {
    /// Size [s].
    pub dt: f64,
    /// Time at its end [s], exact where it lands on an output time.
    pub time: f64,
    /// Whether it ends on an output time or the end.
    pub lands: bool,
}

impl StepControl {
    /// Starts with the nominal step.
    pub fn new(nominal: f64, end: f64, interval: Option<f64>, max_halvings: u32) -> Self {
        StepControl {
            nominal,
            end,
            interval,
            max_halvings,
            dt: nominal,
            successes: 0,
            failures: 0,
            adaptive: None,
            is_even: false,
            by_error: None,
        }
    }

    /// The step from `time`, or none at the end.
    pub fn plan(&self, time: f64) -> Option<StepPlan> {
        if time >= self.end {
            return None;
        }
        let next = self.interval.map_or(self.end, |interval| {
            let count = (time / interval + 1e-9).floor() + 1.0;
            (count * interval).min(self.end)
        });
        // A rest smaller than a millionth of a step would be a step of its own only by round-off.
        if time + self.dt * (1.0 + 1e-6) >= next {
            Some(StepPlan { dt: next - time, time: next, lands: true })
        } else if self.is_even && time + 2.0 * self.dt * (1.0 - 1e-6) > next {
            let dt = 0.5 * (next - time);
            Some(StepPlan { dt, time: time + dt, lands: false })
        } else {
            Some(StepPlan { dt: self.dt, time: time + self.dt, lands: false })
        }
    }

    /// After a step of size `tried` that worked, in so many iterations and with this error over the allowed one, where errors are estimated: as
    /// that allows; without, twice as long again once two have, up to the nominal; adaptive ones by their iterations, where one that was cut to
    /// land says only in which direction.
    pub fn succeed(&mut self, tried: f64, iterations: u64, error: Option<f64>) {
        if let (Some(control), Some(error)) = (&mut self.by_error, error) {
            let next = control.after(error) * tried;
            // A step that was cut says little of how long the next may be.
            if tried > 0.99 * self.dt {
                (self.dt, control.error) = (next.min(control.largest), error);
            } else {
                self.dt = self.dt.max(next).min(control.largest);
            }
            return;
        }
        self.successes += 1;
        if let Some(adaptive) = self.adaptive {
            let wanted = (tried * growth(adaptive.iterations, iterations)).min(adaptive.longest);
            let longer = iterations as f64 <= adaptive.iterations;
            self.dt = if longer { self.dt.max(wanted) } else { self.dt.min(wanted).max(adaptive.shortest.unwrap_or(0.0)) };
        } else if self.successes >= 2 && self.dt < self.nominal {
            self.dt = (2.0 * self.dt).min(self.nominal);
            self.successes = 0;
        }
    }

    /// After a step of size `tried` from time `from` that failed: half of it. False when that is more than `max_halvings` below the nominal, and
    /// when too many have failed.
    pub fn fail(&mut self, tried: f64, from: f64) -> bool {
        self.dt = 0.5 * tried.min(self.dt);
        self.successes = 0;
        self.failures += 1;
        self.is_large_enough() && f64::from(self.failures) <= self.most_failures(from)
    }

    /// Steps that may fail until `time`: as often as one may be halved for each nominal step, and four times that wherever they are.
    pub fn most_failures(&self, time: f64) -> f64 {
        let shortest = self.adaptive.and_then(|adaptive| adaptive.shortest);
        let halvings = shortest.map_or(f64::from(self.max_halvings), |shortest| (self.nominal / shortest).log2().ceil());
        halvings * (SPARE + (time / self.nominal).floor())
    }

    /// After a step of size `tried` that had `error` times the error that is allowed: a smaller one. False when that is smaller than the
    /// nominal halved `max_halvings` times.
    pub fn reject(&mut self, tried: f64, error: f64) -> bool {
        let factor = self.by_error.map_or(0.5, |control| control.before(error));
        self.dt = factor * tried;
        self.is_large_enough()
    }

    fn is_large_enough(&self) -> bool {
        let shortest = self.adaptive.and_then(|adaptive| adaptive.shortest);
        self.dt >= shortest.unwrap_or(self.nominal * 0.5f64.powi(self.max_halvings as i32)) * (1.0 - 1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lands_on_every_output_time_and_on_the_end() {
        let mut control = StepControl::new(0.03, 1.0, Some(0.1), 5);
        let (mut time, mut landed) = (0.0, Vec::new());
        while let Some(plan) = control.plan(time) {
            assert!(plan.dt > 1e-9 && plan.dt <= 0.03 * 1.00001);
            time = plan.time;
            control.succeed(plan.dt, 5, None);
            if plan.lands {
                landed.push(time);
            }
        }
        assert_eq!(landed.len(), 10);
        assert!(landed.iter().enumerate().all(|(i, t)| (t - 0.1 * (i + 1) as f64).abs() < 1e-12));
        assert_eq!(time, 1.0);
    }

    #[test]
    fn halves_and_recovers() {
        let mut control = StepControl::new(1.0, 100.0, None, 2);
        assert!(control.fail(1.0, 0.0) && control.fail(0.5, 0.0));
        assert_eq!(control.dt, 0.25);
        assert!(!control.fail(0.25, 0.0));
        control.dt = 0.25;
        for _ in 0..4 {
            control.succeed(control.dt, 5, None);
        }
        assert_eq!(control.dt, 1.0);
    }

    /// Steps longer than `longest` fail, so that each time they have grown they are halved again.
    fn goes_on(mut control: StepControl, longest: f64) -> (f64, u32) {
        let mut time = 0.0;
        while let Some(plan) = control.plan(time) {
            if plan.dt <= longest {
                time = plan.time;
                control.succeed(plan.dt, 5, None);
            } else if !control.fail(plan.dt, time) {
                break;
            }
        }
        (time, control.failures)
    }

    #[test]
    fn a_run_that_goes_on_halving_ends() {
        for end in [1.0, 10.0, 1000.0] {
            let control = StepControl::new(1.0, end, None, 12);
            // A few halvings now and then are no reason to end.
            assert_eq!(goes_on(control, 0.3).0, end);
            // A thousandth of the nominal step is as much as goes, all the time.
            let (time, failures) = goes_on(control, 1e-3);
            assert!(time < 0.3 && failures == 12 * 4 + 1, "{time} {failures}");
        }
        // A shortest step says how often one may be halved.
        let adaptive = Some(Adaptive { iterations: 6.0, shortest: Some(1e-3), longest: 1.0 });
        let control = StepControl { adaptive, ..StepControl::new(1.0, 100.0, None, 0) };
        assert_eq!(control.most_failures(2.5), 10.0 * 6.0);
        assert_eq!(goes_on(control, 0.3).0, 100.0);
    }

    #[test]
    fn adaptive_steps_follow_the_iterations() {
        let mut control = StepControl::new(0.1, 1.0, Some(0.35), 2);
        control.adaptive = Some(Adaptive { iterations: 6.0, shortest: Some(0.02), longest: 0.3 });
        control.succeed(0.1, 1, None);
        assert_eq!(control.dt, 0.2);
        control.succeed(0.2, 24, None);
        assert_eq!(control.dt, 0.1);
        control.succeed(0.1, 3, None);
        assert!((control.dt - 0.1 * 2f64.sqrt()).abs() < 1e-15);
        // Cut to land: neither a reason to go on in so small steps, nor to try larger ones than before.
        let dt = control.dt;
        control.succeed(0.01, 3, None);
        assert_eq!(control.dt, dt);
        control.succeed(0.01, 9, None);
        assert!(control.dt < 0.01 || control.dt == 0.02, "{}", control.dt);
        for _ in 0..9 {
            control.succeed(control.dt, 2, None);
        }
        assert_eq!(control.dt, 0.3);
        assert!(control.fail(0.04, 0.0) && !control.fail(0.02, 0.0));
    }

    #[test]
    fn the_rest_before_an_output_time_is_halved_where_steps_are_to_be_even() {
        let mut control = StepControl { is_even: true, ..StepControl::new(0.3, 1.0, None, 5) };
        let (mut time, mut steps) = (0.0, Vec::new());
        while let Some(plan) = control.plan(time) {
            time = plan.time;
            steps.push(plan.dt);
            control.succeed(plan.dt, 5, None);
        }
        assert_eq!(steps.len(), 4);
        assert!((steps[2] - 0.2).abs() < 1e-12 && (steps[3] - 0.2).abs() < 1e-12 && time == 1.0, "{steps:?}");
    }

    /// With an error `(dt / d)^3` steps settle at 0.9^(power / 0.3) of the allowed error, whatever the first is.
    #[test]
    fn errors_choose_steps() {
        for start in [1.0, 1e-3] {
            let by_error = Some(ErrorControl { power: 3.0, largest: f64::INFINITY, error: 1.0 });
            let mut control = StepControl { by_error, ..StepControl::new(start, 1e9, None, 40) };
            let error = |dt: f64| (dt / 0.02).powi(3);
            let mut rejected = 0;
            for _ in 0..200 {
                let e = error(control.dt);
                if e <= 1.0 {
                    control.succeed(control.dt, 5, Some(e));
                } else {
                    rejected += 1;
                    assert!(control.reject(control.dt, e));
                }
            }
            let settled = 0.9f64.powf(1.0 / 0.3);
            assert!((control.dt / 0.02 / settled - 1.0).abs() < 1e-6, "{} {settled}", control.dt / 0.02);
            assert!(rejected <= if start > 0.02 { 4 } else { 0 }, "{rejected}");
        }
        let by_error = Some(ErrorControl { power: 2.0, largest: 0.5, error: 1.0 });
        let mut control = StepControl { by_error, ..StepControl::new(0.1, 1e9, None, 3) };
        (0..20).for_each(|_| control.succeed(control.dt, 5, Some(1e-30)));
        assert_eq!(control.dt, 0.5);
        // A cut step leaves the step as it was.
        control.succeed(0.01, 5, Some(0.5));
        assert_eq!(control.dt, 0.5);
        assert!(control.reject(0.5, 1e9) && !control.reject(0.05, 1e9));
    }
}

//! Step sizes: nominal where all goes well or after the iterations of the last step, halved after a failure, cut to land on output times.
//! Error-controlled steps are not here.

use super::arc_length::growth;

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
    /// Where steps follow the iterations of the last; none where they are the nominal ones but after failures.
    pub adaptive: Option<Adaptive>,
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
        StepControl { nominal, end, interval, max_halvings, dt: nominal, successes: 0, adaptive: None }
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
        } else {
            Some(StepPlan { dt: self.dt, time: time + self.dt, lands: false })
        }
    }

    /// After a step of size `tried` that worked, in so many iterations: twice as long again once two have, up to the nominal; adaptive ones by
    /// their iterations, where one that was cut to land says only in which direction.
    pub fn succeed(&mut self, tried: f64, iterations: u64) {
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

    /// After a step of size `tried` that failed: half of it. False when that is more than `max_halvings` below the nominal.
    pub fn fail(&mut self, tried: f64) -> bool {
        self.dt = 0.5 * tried.min(self.dt);
        self.successes = 0;
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
            control.succeed(plan.dt, 5);
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
        assert!(control.fail(1.0) && control.fail(0.5));
        assert_eq!(control.dt, 0.25);
        assert!(!control.fail(0.25));
        control.dt = 0.25;
        for _ in 0..4 {
            control.succeed(control.dt, 5);
        }
        assert_eq!(control.dt, 1.0);
    }

    #[test]
    fn adaptive_steps_follow_the_iterations() {
        let mut control = StepControl::new(0.1, 1.0, Some(0.35), 2);
        control.adaptive = Some(Adaptive { iterations: 6.0, shortest: Some(0.02), longest: 0.3 });
        control.succeed(0.1, 1);
        assert_eq!(control.dt, 0.2);
        control.succeed(0.2, 24);
        assert_eq!(control.dt, 0.1);
        control.succeed(0.1, 3);
        assert!((control.dt - 0.1 * 2f64.sqrt()).abs() < 1e-15);
        // Cut to land: neither a reason to go on in so small steps, nor to try larger ones than before.
        let dt = control.dt;
        control.succeed(0.01, 3);
        assert_eq!(control.dt, dt);
        control.succeed(0.01, 9);
        assert!(control.dt < 0.01 || control.dt == 0.02, "{}", control.dt);
        for _ in 0..9 {
            control.succeed(control.dt, 2);
        }
        assert_eq!(control.dt, 0.3);
        assert!(control.fail(0.04) && !control.fail(0.02));
    }
}

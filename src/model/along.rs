//! Steps of a shell along a path of equilibria, its load factor being an unknown.

use super::shell_model::{Parts, ShellModel, StepFailure, StepReport, follow, potentials, set_loads};
use crate::solve::{Advance, Family, RATE_STEP, Reach, Stop};
use crate::sparse::{Potential, System};

/// What of a model follows the load factor.
struct Following<'a> {
    parts: &'a mut Parts,
    rest_is_set: &'a mut bool,
}

impl Family for Following<'_> {
    type Refusal = StepFailure;

    fn potentials(&mut self) -> Vec<&mut dyn Potential> {
        potentials(self.parts)
    }

    fn set(&mut self, t: f64) -> Result<(), StepFailure> {
        for load in &self.parts.loads {
            let factor = load.factor.as_ref().map_or(1.0, |factor| factor(t));
            if !factor.is_finite() {
                return Err(StepFailure::Input { place: load.key.clone(), reason: format!("is {factor} at t = {t}") });
            }
            if let Some((field, reason)) = load.potential.fault(t) {
                return Err(StepFailure::Input { place: format!("{}{field}", load.key.trim_end_matches("factor")), reason });
            }
        }
        follow(self.parts, self.rest_is_set, t).map_err(|(place, reason)| StepFailure::Input { place, reason })?;
        set_loads(self.parts, t);
        Ok(())
    }

    fn moved(&self, t: f64) -> Result<Vec<(usize, f64)>, StepFailure> {
        let mut moved = Vec::new();
        for held in &self.parts.held {
            let Some((key, motion)) = &held.motion else { continue };
            let d = motion(t);
            if !d.is_finite() {
                return Err(StepFailure::Input { place: key.clone(), reason: format!("is {d} at t = {t}") });
            }
            moved.push((held.unknown, held.start + d));
        }
        Ok(moved)
    }

    fn add_rate(&mut self, t: f64, x: &[f64], into: &mut System) -> Result<(), StepFailure> {
        for load in &mut self.parts.loads {
            let Some(factor) = &load.factor else { continue };
            let (before, after) = (factor(t - RATE_STEP), factor(t + RATE_STEP));
            let rate = match (before.is_finite(), after.is_finite()) {
                (true, true) => (after - before) / (2.0 * RATE_STEP),
                (false, true) => (after - factor(t)) / RATE_STEP,
                (true, false) => (factor(t) - before) / RATE_STEP,
                (false, false) => 0.0,
            };
            load.potential.set_factor(rate);
            load.potential.gradient(x, into);
            load.potential.set_factor(factor(t));
        }
        for load in self.parts.loads.iter_mut().filter(|load| load.potential.changes_in_time()) {
            let factor = load.factor.as_ref().map_or(1.0, |factor| factor(t));
            for side in [RATE_STEP, -RATE_STEP] {
                load.potential.set_time(t + side);
                load.potential.set_factor(factor / (2.0 * side));
                load.potential.gradient(x, into);
            }
            load.potential.set_time(t);
            load.potential.set_factor(factor);
        }
        if !self.parts.rest.as_ref().is_some_and(|driver| driver.changes()) {
            return Ok(());
        }
        let zero = vec![0.0; into.gradient.len()];
        let mut shell = |at: f64| -> Option<Vec<f64>> {
            follow(self.parts, self.rest_is_set, at).ok()?;
            let kept = std::mem::replace(&mut into.gradient, zero.clone());
            self.parts.shell.gradient(x, into);
            Some(std::mem::replace(&mut into.gradient, kept))
        };
        let (before, after) = (shell(t - RATE_STEP), shell(t + RATE_STEP));
        let sides = f64::from(u8::from(before.is_some())) + f64::from(u8::from(after.is_some()));
        follow(self.parts, self.rest_is_set, t).map_err(|(place, reason)| StepFailure::Input { place, reason })?;
        if sides > 0.0 {
            let kept = std::mem::replace(&mut into.gradient, zero.clone());
            self.parts.shell.gradient(x, into);
            let here = std::mem::replace(&mut into.gradient, kept);
            let (before, after) = (before.as_ref().unwrap_or(&here), after.as_ref().unwrap_or(&here));
            let differences = before.iter().zip(after).map(|(before, after)| (after - before) / (sides * RATE_STEP));
            into.gradient.iter_mut().zip(differences).for_each(|(g, d)| *g += d);
        }
        Ok(())
    }
}

impl ShellModel {
    /// Follows the path of equilibria through the present one for a step. One that goes past the load factor `end` ends on it instead, by
    /// an ordinary step from where it started; it has no [`Advance`]. On failure the model is as it was.
    pub(super) fn try_along(&mut self, reach: Reach, end: f64) -> Result<(StepReport, Option<Advance>), StepFailure> {
        let (x, lagged, directors) = (self.x.clone(), self.parts.shell.lagged(), self.parts.shell.directors().to_vec());
        let mut following = Following { parts: &mut self.parts, rest_is_set: &mut self.rest_is_set };
        let found = self.newton.advance_along(&mut following, &mut self.x, self.time, reach, self.heading.as_deref());
        let found = match found {
            Ok(found) if found.t < end => Ok(found),
            other => {
                self.x.clone_from(&x);
                self.parts.shell.set_lagged(&lagged);
                self.parts.shell.set_directors(&directors);
                // What held at the present factor when that was accepted cannot fail now.
                let _ = self.follow(self.time);
                self.set_loads(self.time);
                other
            }
        };
        let way = |now: &[f64]| now.iter().zip(&x).map(|(now, before)| now - before).collect();
        match found {
            Ok(found) if found.t < end => {
                self.heading = Some(way(&self.x));
                self.update_reactions();
                self.step += 1;
                self.time = found.t;
                Ok((StepReport { solved: found.solved, error: None }, Some(found)))
            }
            Ok(_) => {
                // Descent would leave the path.
                self.newton.set_descends(false);
                let report = self.advance(end - self.time, end)?;
                self.heading = Some(way(&self.x));
                Ok((report, None))
            }
            Err(Stop::Equations(failure)) => Err(self.failed(failure)),
            Err(Stop::Still) => Err(StepFailure::Input {
                place: "statics.arc-length".into(),
                reason: format!("the load factor moves nothing at t = {}: no load, motion or growth follows it", self.time),
            }),
            Err(Stop::Refused(StepFailure::Input { place, reason })) => Err(StepFailure::Equations(format!("{place} {reason}"))),
            Err(Stop::Refused(failure)) => Err(failure),
        }
    }
}

//! Steps of a shell along a path of equilibria, its load factor being an unknown.

use super::prescribed::{check_loads, set_loads};
use super::shell_model::{Parts, ShellModel, follow, potentials};
use super::step::{StepFailure, StepReport};
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
        check_loads(&self.parts.loads, t)?;
        follow(self.parts, self.rest_is_set, t).map_err(|(place, reason)| StepFailure::Input { place, reason })?;
        set_loads(&mut self.parts.loads, t);
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
        let zero = vec![0.0; into.gradient.len()];
        // Loads alone, whose differences are exact where they are linear, whatever the stresses are.
        let mut loads = |at: f64| -> Option<Vec<f64>> {
            check_loads(&self.parts.loads, at).ok()?;
            set_loads(&mut self.parts.loads, at);
            let kept = std::mem::replace(&mut into.gradient, zero.clone());
            self.parts.loads.iter().for_each(|load| {
                load.potential.gradient(x, into);
            });
            Some(std::mem::replace(&mut into.gradient, kept))
        };
        let sides = [loads(t - RATE_STEP), loads(t), loads(t + RATE_STEP)];
        set_loads(&mut self.parts.loads, t);
        add_slope(&sides, into);
        if !self.parts.rest.as_ref().is_some_and(|driver| driver.changes()) {
            return Ok(());
        }
        let mut shell = |at: f64| -> Option<Vec<f64>> {
            follow(self.parts, self.rest_is_set, at).ok()?;
            let kept = std::mem::replace(&mut into.gradient, zero.clone());
            self.parts.shell.gradient(x, into);
            Some(std::mem::replace(&mut into.gradient, kept))
        };
        let sides = [shell(t - RATE_STEP), shell(t), shell(t + RATE_STEP)];
        follow(self.parts, self.rest_is_set, t).map_err(|(place, reason)| StepFailure::Input { place, reason })?;
        add_slope(&sides, into);
        Ok(())
    }
}

/// Adds the slope of gradients at `t - RATE_STEP`, `t` and `t + RATE_STEP`, by those of them that there are.
fn add_slope(sides: &[Option<Vec<f64>>; 3], into: &mut System) {
    let (before, after, span) = match sides {
        [Some(before), _, Some(after)] => (before, after, 2.0 * RATE_STEP),
        [None, Some(here), Some(after)] => (here, after, RATE_STEP),
        [Some(before), Some(here), None] => (before, here, RATE_STEP),
        _ => return,
    };
    into.gradient.iter_mut().zip(before.iter().zip(after)).for_each(|(g, (before, after))| *g += (after - before) / span);
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
                self.update_reactions(found.t);
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

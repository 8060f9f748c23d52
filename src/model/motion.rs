//! A step of a shell in motion around its minimisation: the stage before it, positions, directors, velocities and error after it.

use super::prescribed::HeldUnknown;
use super::shell_model::{ShellModel, potentials};
use super::step::StepFailure;
use super::time_integration::Stage;
use crate::math::rigid_fit;
use nalgebra::Vector3;

impl HeldUnknown {
    /// Velocity [m/s] at the start of a step from time `start` [s] to `end`: that of the parabola through its start, middle and end, which is of
    /// second order.
    pub fn velocity(&self, start: f64, end: f64) -> f64 {
        let Some((_, motion)) = &self.motion else { return 0.0 };
        let [a, b, c] = [start, 0.5 * (start + end), end].map(motion);
        let parabola = (4.0 * b - 3.0 * a - c) / (end - start);
        if parabola.is_finite() { parabola } else { (c - a) / (end - start) }
    }
}

impl ShellModel {
    /// The stage of a step of size `dt` [s] to `time`; none in statics.
    pub(super) fn stage(&self, dt: f64, time: f64) -> Option<Stage> {
        let integration = self.integration.as_ref()?;
        // The midpoint rule follows what is held with second order only from velocities that agree with its motion.
        let held = self.parts.held.iter().filter(|h| h.unknown < self.v.len());
        let consistent = || held.map(|h| (h.unknown, h.velocity(self.time, time))).collect();
        Some(integration.stage(&self.x, &self.v, dt, [self.time, time], consistent))
    }

    /// Moves and turns a shell that nothing holds as a whole to where inertia would have it: in a long step that may be many of its sizes away, and what is
    /// left to find is how it deforms. Where nothing moves, nothing changes.
    pub(super) fn move_as_a_whole(&mut self, stage: &Stage) {
        let coordinates = self.v.len();
        if !self.parts.held.is_empty() || self.x[..coordinates] == stage.predicted {
            return;
        }
        let points = |v: &[f64]| v.chunks_exact(3).map(Vector3::from_column_slice).collect::<Vec<_>>();
        let nodes = points(&self.x[..coordinates]);
        let (rotation, translation) = rigid_fit(&nodes, &points(&stage.predicted));
        let centre = nodes.iter().sum::<Vector3<f64>>() / nodes.len() as f64;
        let moved = rotation * centre + translation;
        if !moved.iter().all(|v| v.is_finite()) {
            return;
        }
        for (x, node) in self.x.chunks_exact_mut(3).zip(&nodes) {
            x.copy_from_slice((moved + rotation * (node - centre)).as_slice());
        }
        let directors: Vec<Vector3<f64>> = self.parts.shell.directors().iter().map(|d| rotation * d).collect();
        self.parts.shell.set_directors(&directors);
    }

    /// Goes on from the state of a stage, which the unknowns hold, to the end of its step at `time`, where held unknowns have the values
    /// `targets`; returns the estimated error over the allowed one, where steps are chosen by it. `before`: directors at the start.
    ///
    /// # Errors
    /// What is impossible at the end; an error that is too large.
    pub(super) fn finish(
        &mut self,
        stage: Stage,
        targets: &[(usize, f64)],
        time: f64,
        before: &[Vector3<f64>],
    ) -> Result<Option<f64>, StepFailure> {
        let Some(integration) = &mut self.integration else { return Ok(None) };
        let coordinates = self.v.len();
        let [mut end, velocity] = integration.finish(&stage, &self.x[..coordinates]);
        let held: Vec<usize> = self.parts.held.iter().map(|h| h.unknown).collect();
        for &(i, value) in targets.iter().filter(|(i, _)| *i < coordinates) {
            end[i] = value;
        }
        let error = self.error_tolerance.and_then(|tolerance| {
            let mut errors = integration.errors(&stage, &end)?;
            held.iter().filter(|i| **i < coordinates).for_each(|i| errors[*i] = 0.0);
            Some(errors.chunks_exact(3).map(|e| e.iter().map(|e| e * e).sum::<f64>().sqrt()).fold(0.0, f64::max) / tolerance)
        });
        if let Some(error) = error.filter(|error| !(*error <= 1.0)) {
            return Err(StepFailure::Inaccurate(error));
        }
        let forms = if self.parts.shell.is_viscous() { self.parts.shell.forms(&self.x) } else { Vec::new() };
        let directors = self.parts.shell.directors().to_vec();
        if stage.share < 1.0 {
            let last = integration.directors().unwrap_or(before);
            let further = integration.further_turn(&stage, [self.time, time]);
            let mut dx: Vec<f64> = end.iter().zip(&self.x).map(|(end, z)| end - z).collect();
            dx.extend(self.parts.shell.turns(&self.x, last).into_iter().map(|turn| further * turn));
            dx.resize(self.x.len(), 0.0);
            held.iter().filter(|i| **i >= coordinates).for_each(|i| dx[*i] = 0.0);
            for &(i, turn) in targets.iter().filter(|(i, _)| *i >= coordinates) {
                dx[i] = (1.0 - stage.share) * turn;
            }
            for transport in &mut self.parts.transports {
                transport.profile.set(transport.diffusion.values());
            }
            potentials(&mut self.parts).iter_mut().for_each(|p| p.extrapolate(&self.x, &dx));
            self.x.iter_mut().zip(&dx).for_each(|(x, dx)| *x += dx);
            self.x[..coordinates].copy_from_slice(&end);
            self.parts.shell.prepare(&mut self.x);
            self.follow(time).map_err(|(place, reason)| StepFailure::Input { place, reason })?;
            self.set_loads(time);
        }
        if let Some(integration) = &mut self.integration {
            integration.accept(stage, [&end, &velocity], directors, forms);
        }
        self.v = velocity;
        Ok(error)
    }
}

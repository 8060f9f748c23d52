//! The lowest modes of a shell about an equilibrium: vibration with its prestress, and linear buckling.

use super::ShellModel;
use super::shell_model::potentials;
use crate::shell::Inertial;
use crate::snapshot::Snapshot;
use crate::solve::{Mode, NoModes};

impl ShellModel {
    /// The lowest modes of vibration about the present state, ascending by squared angular frequency [1/s2]. `inertia`: that of the shell, at any state.
    /// `shift`: see [`crate::solve::Newton::vibration`].
    ///
    /// # Errors
    /// In words, what keeps them from being found.
    pub fn vibration_modes(&mut self, mut inertia: Box<dyn Inertial>, count: usize, shift: Option<f64>) -> Result<Vec<Mode>, String> {
        if let Some(following) = &self.parts.following_mass {
            inertia.set_factors(&following.factors(&self.parts.transports)?);
        }
        let still = vec![0.0; 3 * self.parts.positions.len()];
        inertia.start_step(&self.x, &still, 1.0);
        let stiffness = self.newton.hessian(&mut potentials(&mut self.parts), &mut self.x);
        let mass = self.newton.matrix_of(&mut *inertia, &self.x);
        let mut modes = self.newton.vibration(&stiffness, &mass, count, shift).map_err(|reason| match reason {
            NoModes::Unstable(_) => "the shift does not make the matrix positive definite; take a larger one".to_owned(),
            other => describe(other),
        })?;
        let between = self.newton.between(&mut potentials(&mut self.parts), &mut self.x, &modes);
        self.newton.settle_vibration(&mut modes, between, &mass);
        Ok(modes)
    }

    /// The lowest factors on the load, above `shift`, at which the shell buckles, by the change of stiffness between two states: without load and
    /// under it. The model is left in the latter.
    ///
    /// # Errors
    /// In words, what keeps them from being found.
    pub fn buckling_modes(&mut self, states: [&Snapshot; 2], count: usize, shift: f64) -> Result<Vec<Mode>, String> {
        let mut hessians = Vec::new();
        for state in states {
            self.restore(state)?;
            hessians.push(self.newton.hessian(&mut potentials(&mut self.parts), &mut self.x));
        }
        let mut modes = self.newton.buckling(&hessians[0], &hessians[1], count, shift).map_err(|reason| match reason {
            NoModes::Unstable(Some(n)) => format!("at {shift} times the load the shell is unstable already, in {n} directions"),
            NoModes::Unstable(None) => format!("at {shift} times the load the matrix is singular"),
            other => describe(other),
        })?;
        let mut between = Vec::new();
        for state in states {
            self.restore(state)?;
            between.push(self.newton.between(&mut potentials(&mut self.parts), &mut self.x, &modes));
        }
        Mode::settle_buckling(&mut modes, &between[0], &between[1], shift);
        Ok(modes)
    }
}

fn describe(reason: NoModes) -> String {
    match reason {
        NoModes::Never(most) if most.is_finite() => {
            format!("no factor on the load below {most:.3e} makes the shell buckle; the load stiffens it")
        }
        NoModes::Never(_) => "no factor on the load makes the shell buckle; it stiffens with the load, or the load is zero".into(),
        NoModes::Unstable(_) | NoModes::Unsettled => "the iteration for the modes did not settle, or missed some".into(),
    }
}

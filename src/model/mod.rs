//! A mechanical model: potentials, supports and a rest driver, advanced one step at a time.
//!
//! A model exchanges [`crate::snapshot::Snapshot`]s with the rest of the program and knows neither files nor scenes.

mod along;
mod grid_model;
mod grid_step;
mod modes;
mod motion;
mod prescribed;
mod reactions;
mod rest_driver;
mod shell_model;
mod state;
mod step;
mod time_integration;
mod transport;

use crate::snapshot::Snapshot;
use crate::solve::{Advance, Counters, Reach};

pub use grid_model::{GridModel, GridParts, RoundTable, node_shares, quadrangles};
pub use grid_step::Strong;
pub use prescribed::{AppliedLoad, HeldUnknown, Motion};
pub use rest_driver::{Limit, Ramp, RestDriver};
pub use shell_model::{Parts, ShellModel, place_of_law};
pub use step::{StepFailure, StepReport};
pub use time_integration::{Integrator, LARGEST_RATIO, Stage, TimeIntegration};
pub use transport::{FollowingMass, Profile, Transport};

/// What runs need of a model: a state that steps advance and that snapshots keep.
pub trait Model {
    /// Advances to `time` [s], by a step of size `dt` [s]. On failure the model is as it was.
    ///
    /// # Errors
    /// Why the step failed.
    fn advance(&mut self, dt: f64, time: f64) -> Result<StepReport, StepFailure>;

    /// Follows the path of equilibria through the present one for a step. One that goes past the load factor `end` ends on it instead, by
    /// an ordinary step from where it started; it has no [`Advance`]. On failure the model is as it was.
    ///
    /// # Errors
    /// Why the step failed; a model that has no such paths.
    fn advance_along(&mut self, _reach: Reach, _end: f64) -> Result<(StepReport, Option<Advance>), StepFailure> {
        Err(StepFailure::Input { place: "statics.arc-length".into(), reason: "this model has no paths of equilibria".into() })
    }

    /// Length of the last step along a path: root mean square of the nodes' displacements [m]; 0 before the first.
    fn last_way(&self) -> f64 {
        0.0
    }

    /// Accepted steps.
    fn step(&self) -> u64;

    /// Time [s]; in statics without end the load factor.
    fn time(&self) -> f64;

    /// Number of free unknowns.
    fn free_unknowns(&self) -> usize;

    /// Work done so far.
    fn counters(&self) -> Counters;

    /// Whether steps leave unstable equilibria.
    fn leaves_unstable(&self) -> bool {
        false
    }

    /// Whether steps are chosen by their errors, which reports of steps then tell.
    fn chooses_steps(&self) -> bool {
        false
    }

    /// Energies [J] of the parts there are, by the names of the history's columns.
    fn energies(&self) -> Vec<(&'static str, f64)>;

    /// What else the history tells of the parts there are, by the names of its columns.
    fn quantities(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Makes sure that all that is prescribed at a time is finite.
    ///
    /// # Errors
    /// [`StepFailure::Input`] with the key at fault.
    fn check_prescribed(&self, time: f64) -> Result<(), StepFailure>;

    /// The state, with everything the next step reads.
    fn snapshot(&self) -> Snapshot;

    /// Puts a state back.
    ///
    /// # Errors
    /// A field that is missing or of another size.
    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), String>;
}

//! What steps have to tell, whatever the model.

use crate::solve::{Failure, Solved};

/// What an accepted step has to tell.
#[derive(Clone, Copy, Debug)]
pub struct StepReport {
    /// Iterations, last movement, residual, negative pivots.
    pub solved: Solved,
    /// Estimated error that the step has added to positions over the largest that is allowed [1], where steps are chosen by it.
    pub error: Option<f64>,
}

/// Why a step failed. The model is as it was before.
#[derive(Clone, Debug, PartialEq)]
pub enum StepFailure {
    /// The equations were not solved; a smaller step may be.
    Equations(String),
    /// The estimated error is this many times what is allowed; a smaller step has less.
    Inaccurate(f64),
    /// The matrix was singular from the start of a static run: the structure is a mechanism. Holds the unknown's description.
    Mechanism(String),
    /// What the scene prescribes is impossible at this time; no smaller step helps.
    Input {
        /// Key of the scene that prescribes it.
        place: String,
        /// What is impossible, where and when.
        reason: String,
    },
}

impl StepFailure {
    /// A failure of the solver in words. `static_start`: whether it is one of the first step of a static run. `describe`: an unknown in words.
    pub(super) fn of(failure: Failure, static_start: bool, describe: impl Fn(usize) -> String) -> Self {
        match failure {
            Failure::Mechanism(unknown) if static_start => StepFailure::Mechanism(describe(unknown)),
            Failure::Mechanism(unknown) => StepFailure::Equations(format!("the matrix is singular at {}", describe(unknown))),
            Failure::RoundOff(hidden) => StepFailure::Equations(format!(
                "round-off hides how stiff the shell is: the pivot of {} is {:.1e} of its diagonal entry; round-off of the forces moves the shell by \
                 {:.1e} m, and movements are wrong by {:.1e} of their size",
                describe(hidden.unknown),
                hidden.pivot,
                hidden.movement,
                hidden.error
            )),
            Failure::NotContracting(movement) => {
                StepFailure::Equations(format!("the iteration did not contract; its last movement was {movement:.2e} m"))
            }
            Failure::NotRelaxed { iterations, distance } => StepFailure::Equations(format!(
                "dynamic relaxation was still {distance:.2e} m from equilibrium after {iterations} iterations"
            )),
            Failure::Unstable(Some(lowest)) => StepFailure::Equations(format!(
                "the equilibrium is unstable (lowest eigenvalue {lowest:.3e} N/m3) and no stable one was found"
            )),
            Failure::Unstable(None) => StepFailure::Equations("the equilibrium is unstable and its lowest mode was not found".into()),
        }
    }
}

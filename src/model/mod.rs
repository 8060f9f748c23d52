//! A mechanical model: potentials, supports and a rest driver, advanced one step at a time.
//!
//! A model exchanges [`crate::snapshot::Snapshot`]s with the rest of the program and knows neither files nor scenes.

mod rest_driver;
mod shell_model;
mod transport;

pub use rest_driver::{Limit, Ramp, RestDriver};
pub use shell_model::{AppliedLoad, HeldUnknown, Motion, Parts, ShellModel, StepFailure, StepReport, place_of_law};
pub use transport::{FollowingMass, Profile, Transport};

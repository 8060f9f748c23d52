//! A mechanical model: potentials, supports and a rest driver, advanced one step at a time.
//!
//! A model exchanges [`crate::case::Snapshot`]s with the rest of the program and knows neither files nor scenes.

mod shell_model;
mod rest_driver;

pub use rest_driver::{Ramp, RestDriver};
pub use shell_model::{HeldUnknown, Motion, Parts, ShellModel, StepFailure, StepReport};

//! Nonlinear solution of one step, and the choice of steps.
//!
//! `newton` minimises a sum of potentials; `steps` chooses step sizes, halves after a failure and lands on output times. Neither knows what
//! the unknowns mean, save how many of them are lengths.

mod newton;
mod steps;

pub use newton::{Counters, Failure, Newton, Settings, Solved};
pub use steps::{StepControl, StepPlan};

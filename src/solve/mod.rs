//! Nonlinear solution of one step, and the choice of steps.
//!
//! `newton` finds equilibria of a sum of potentials, `descent` where it does not contract, and `stability` leaves those that are no minimum;
//! `refine` mends solutions that round-off of the matrix spoils;
//! `round_off` tells what none can do better; `steps` chooses step sizes, halves after a failure and lands on output times. Neither knows what
//! the unknowns mean, save how many of them are lengths.

mod descent;
mod newton;
mod refine;
mod round_off;
mod stability;
mod steps;

pub use newton::{Counters, Failure, Newton, Settings, Solved};
pub use stability::{Stability, Stabilizer};
pub use steps::{StepControl, StepPlan};

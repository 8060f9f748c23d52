//! Nonlinear solution of one step, and the choice of steps.
//!
//! `newton` finds equilibria of a sum of potentials, `descent` where it does not contract, and `stability` leaves those that are no minimum;
//! `round_off` tells what neither can do better; `steps` chooses step sizes, halves after a failure and lands on output times;
//! `arc_length` follows paths of equilibria through limit points. None knows what the unknowns mean, save how many of them are lengths.

mod arc_length;
mod descent;
mod modes;
mod newton;
mod round_off;
mod stability;
mod steps;

pub use arc_length::{Advance, ArcControl, Family, RATE_STEP, Reach, Stop};
pub use modes::{Mode, NoModes};
pub use newton::{Counters, Failure, Newton, Settings, Solved};
pub use stability::{Stability, Stabilizer};
pub use steps::{Adaptive, StepControl, StepPlan};

//! Nonlinear solution of one step, and the choice of steps.
//!
//! `newton` finds equilibria of a sum of potentials, `descent` where it does not contract, and `stability` leaves those that are no minimum;
//! `dynamic_relaxation` finds equilibria without factorisations; `round_off` tells
//! what none can do better; `steps` chooses step sizes, halves after a failure and lands on output times; `arc_length` follows paths of equilibria
//! through limit points; `modes` finds modes of vibration and buckling. None knows what the unknowns mean, save how many of them are lengths.

mod arc_length;
mod descent;
mod dynamic_relaxation;
mod modes;
mod newton;
mod refine;
mod round_off;
mod stability;
mod steps;

pub use arc_length::{Advance, ArcControl, Family, RATE_STEP, Reach, Stop};
pub use dynamic_relaxation::Relaxation;
pub use modes::{Mode, NoModes};
pub use newton::{Counters, Failure, Newton, RoundOff, Settings, Solved};
pub use stability::{Stability, Stabilizer};
pub use steps::{Adaptive, ErrorControl, StepControl, StepPlan};

//! Sparse symmetric systems whose pattern is analysed once and whose values change often.
//!
//! A [`Potential`] declares which unknowns it couples; [`Numbering`] says which of them are free; [`Pattern`] is the union of all
//! couplings; [`Scatter`] knows, for elements of one size, where in the pattern each entry goes, and adds what several threads compute in the order
//! of the elements; [`Cholesky`] is analysed once and refactored in place, by fronts that several threads share with the same bits as one;
//! [`lanczos`] finds the lowest mode with its help, [`eigen`] several; [`general`] solves what need not be symmetric. Local physics and global indices meet only here. Nothing here knows what an
//! unknown means.

mod cholesky;
pub mod eigen;
mod front;
pub mod general;
pub mod lanczos;
mod multifrontal;
mod pattern;
mod potential;
mod threads;

pub use cholesky::{Cholesky, Kind, Pivot, Refactored};
pub use pattern::{HELD, Numbering, Pattern, Scatter, System};
pub use potential::{Curvature, Potential};
pub use threads::{Contribution, collect, fill};

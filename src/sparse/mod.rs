//! Sparse symmetric systems whose pattern is analysed once and whose values change often.
//!
//! A [`Potential`] declares which unknowns it couples; [`Numbering`] says which of them are free; [`Pattern`] is the union of all
//! couplings; [`Scatter`] knows, for elements of one size, where in the pattern each entry goes; [`Cholesky`] is analysed once and
//! refactored in place; [`lanczos`] finds the lowest mode with its help, [`eigen`] several. Local physics and global indices meet only here. Nothing here knows what an unknown means.

mod cholesky;
pub mod eigen;
pub mod lanczos;
mod pattern;
mod potential;

pub use cholesky::{Cholesky, Kind, Pivot, Refactored};
pub use pattern::{HELD, Numbering, Pattern, Scatter, System};
pub use potential::{Curvature, Potential};

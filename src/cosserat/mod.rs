//! The deformable surface of Wu and de Melo: a Cosserat surface on a grid of `p x q` nodes.
//!
//! - `grid`: nodes, spacing, and differences with the two rules for borders
//! - `geometry`: metric and curvature tensors, Christoffel symbols, normals by the Gauss formula, covariant derivatives at one point
//! - `constants`: constants of elasticity and the stiffness that they give in a rest metric, with and without mixed terms
//! - `surface`: the energy discretised on the grid and differentiated, as a [`crate::sparse::Potential`]; its borders are natural ones
//! - `stencil`: one-sided differences on the grid as rows of coefficients
//! - `strong_form`: the finite differences of the paper, a linear operator for each step
//!
//! Material coordinates are in metres, so constants hold on any grid. Nothing here reads a scene, a file or the time.

mod constants;
pub mod geometry;
mod grid;
mod stencil;
mod strong_form;
mod surface;

pub use constants::{Constants, Stiffness, density, is_positive, stiffness};
pub use grid::{Border, Grid};
pub use strong_form::{Divergence, Operator, StrongForm};
pub use surface::{CosseratSurface, Elasticity};

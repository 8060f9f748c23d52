//! One physical effect, as an energy of the unknowns.

use super::{Numbering, Pattern, System};

/// Which second derivative a Newton iteration asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// The exact Hessian, with the lagged, linearly extrapolated stresses in its geometric part where a potential has stresses.
    Mixed,
    /// The same without the part of the material, which [`Potential::add_material_forces`] makes.
    Geometric,
    /// A positive semidefinite approximation of [`Curvature::Mixed`], for descent on the energy.
    Projected,
}

/// One physical effect: adds its energy, gradient and Hessian into buffers that the caller owns.
///
/// `x` holds all unknowns, held ones too. Couplings are declared once, before [`bind`](Potential::bind). Everything is deterministic:
/// elements are added in order.
pub trait Potential {
    /// Shows the unknowns of every element to `visit`; `usize::MAX` stands for none.
    fn stencils(&self, visit: &mut dyn FnMut(&[usize]));

    /// Looks up where its entries go, once.
    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern);

    /// Energy [J].
    fn energy(&self, x: &[f64]) -> f64;

    /// Adds gradient and Hessian at `x`; returns the energy [J].
    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64;

    /// Adds the gradient at `x` alone; returns the energy [J].
    fn gradient(&self, x: &[f64], into: &mut System) -> f64;

    /// Stiffness `y.H y` along a direction of all unknowns, without the part of present stresses, formed so that its round-off is squared.
    fn stiffness_along(&self, _x: &[f64], _y: &[f64]) -> f64 {
        0.0
    }

    /// Adds what the part of the Hessian that [`Curvature::Geometric`] leaves out makes of a movement `v`, from its strains: their round-off then
    /// is that of stresses, which do no work in movements without strain.
    fn add_material_forces(&self, _x: &[f64], _v: &[f64], _into: &mut System) {}

    /// Called before each iteration; may exchange unknowns for equivalent ones (directors), which leaves the state as it is.
    fn prepare(&mut self, _x: &mut [f64]) {}

    /// Called after each solve, before `x + dx` is taken: extrapolates what the next geometric stiffness uses.
    fn extrapolate(&mut self, _x: &[f64], _dx: &[f64]) {}

    /// Called when iterations start anew from `x` without extrapolated values.
    fn restart(&mut self, _x: &[f64]) {}

    /// Remembers what [`prepare`](Potential::prepare) and [`extrapolate`](Potential::extrapolate) change.
    fn save(&mut self) {}

    /// Puts back what was saved last.
    fn put_back(&mut self) {}

    /// Largest fraction of `dx`, 0 to 1, that this effect allows.
    fn max_step(&self, _x: &[f64], _dx: &[f64]) -> f64 {
        1.0
    }
}

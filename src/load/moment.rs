//! Moments on the directors of edges.

use crate::sparse::{Curvature, HELD, Numbering, Pattern, Potential, System};

/// `-factor sum_e m_e phi_e`: constant moments on director angles.
///
/// Angles count from references that turn with the shell, so a difference of this energy is work only within one iteration; its gradient,
/// the moment, holds always.
#[derive(Clone, Debug)]
pub struct EdgeMoment {
    /// Angle's unknown and moment [N m].
    moments: Vec<(usize, f64)>,
    factor: f64,
    numbers: Vec<u32>,
}

impl EdgeMoment {
    /// `moments`: unknown of an angle and moment [N m] in the sense of that angle.
    pub fn new(moments: Vec<(usize, f64)>) -> Self {
        EdgeMoment { moments, factor: 1.0, numbers: Vec::new() }
    }
}

impl super::Load for EdgeMoment {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }
}

impl Potential for EdgeMoment {
    fn stencils(&self, _visit: &mut dyn FnMut(&[usize])) {}

    fn bind(&mut self, numbering: &Numbering, _pattern: &Pattern) {
        self.numbers = self.moments.iter().map(|(unknown, _)| numbering.of(*unknown)).collect();
    }

    fn energy(&self, x: &[f64]) -> f64 {
        -self.factor * self.moments.iter().map(|(unknown, moment)| moment * x[*unknown]).sum::<f64>()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        for ((_, moment), &number) in self.moments.iter().zip(&self.numbers) {
            if number != HELD {
                into.gradient[number as usize] -= self.factor * moment;
            }
        }
        self.energy(x)
    }
}

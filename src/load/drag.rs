//! Resistance of every node to its own velocity, as an energy of a time step: `c/(2 dt) |x - x_before|^2`.

use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};

/// Damping of nodes by coefficients [kg/s] that one factor scales.
pub struct Drag {
    coefficients: Vec<f64>,
    factor: f64,
    before: Vec<f64>,
    dt: f64,
    scatter: Scatter<3>,
}

impl Drag {
    /// `coefficients`: of each node [kg/s].
    pub fn new(coefficients: Vec<f64>) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Drag { coefficients, factor: 1.0, before: Vec::new(), dt: 1.0, scatter }
    }

    /// Starts a step of size `dt` [s] from `x`. `factor`: on all coefficients.
    pub fn start_step(&mut self, x: &[f64], dt: f64, factor: f64) {
        self.before.clear();
        self.before.extend_from_slice(x);
        (self.dt, self.factor) = (dt, factor);
    }

    fn stencil(node: usize) -> [usize; 3] {
        [3 * node, 3 * node + 1, 3 * node + 2]
    }
}

impl Potential for Drag {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        (0..self.coefficients.len()).for_each(|node| visit(&Self::stencil(node)));
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.scatter = Scatter::new((0..self.coefficients.len()).map(Self::stencil), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let of = |(node, c): (usize, &f64)| c * (0..3).map(|k| (x[3 * node + k] - self.before[3 * node + k]).powi(2)).sum::<f64>();
        0.5 * self.factor / self.dt * self.coefficients.iter().enumerate().map(of).sum::<f64>()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        for (node, c) in self.coefficients.iter().enumerate() {
            let c = c * self.factor / self.dt;
            self.scatter.add_hessian(node, &[[c, 0.0, 0.0], [0.0, c, 0.0], [0.0, 0.0, c]], into);
        }
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        for (node, c) in self.coefficients.iter().enumerate() {
            let c = c * self.factor / self.dt;
            let force = std::array::from_fn(|k| c * (x[3 * node + k] - self.before[3 * node + k]));
            self.scatter.add_gradient(node, &force, into);
        }
        self.energy(x)
    }

    fn stiffness_along(&self, _x: &[f64], y: &[f64]) -> f64 {
        let of = |(node, c): (usize, &f64)| c * (0..3).map(|k| y[3 * node + k].powi(2)).sum::<f64>();
        self.factor / self.dt * self.coefficients.iter().enumerate().map(of).sum::<f64>()
    }
}

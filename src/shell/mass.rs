//! Inertia of a shell (Chen et al. 2018, section 3).
//!
//! Mass is that of the rest forms at the start, `h rho sqrt(det abar)`, and is conserved while the shell swells, but for factors on the faces by
//! which it follows moisture: what is added comes with the velocity that the shell has there, so it brings momentum and calls forth no force;
//! what leaves takes its momentum along. It is integrated with the element's shape functions. Time integration enters only as the predictor that a step starts from.

use super::quadratic_shape::{linear, shape};
use crate::math::quadrature::RADON;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::Vector3;

/// Which mass matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MassKind {
    /// Galerkin.
    Consistent,
    /// Diagonal.
    Lumped,
}

impl MassKind {
    /// Mass matrix of a linear triangle of this mass [kg]; the entries add up to it.
    pub fn linear(self, mass: f64) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match self {
                MassKind::Consistent => mass * (1.0 + f64::from(u8::from(i == j))) / 12.0,
                MassKind::Lumped => mass * f64::from(u8::from(i == j)) / 3.0,
            })
        })
    }
}

impl MassKind {
    /// Mass matrix of a quadratic triangle. `density`: mass per area of the reference triangle [kg] at the three integration points,
    /// linear in between. Lumped: the consistent diagonal, scaled to the face's mass (Hinton, Rock and Zienkiewicz), which is positive where
    /// row sums are not.
    pub fn quadratic(self, density: [f64; 3]) -> [[f64; 6]; 6] {
        let mut matrix = [[0.0; 6]; 6];
        for (place, weight) in RADON {
            let (n, l) = (shape(place), linear(place));
            let mass = weight * (l[0] * density[0] + l[1] * density[1] + l[2] * density[2]);
            for i in 0..6 {
                for j in 0..6 {
                    matrix[i][j] += mass * n[i] * n[j];
                }
            }
        }
        if self == MassKind::Consistent {
            return matrix;
        }
        let total: f64 = matrix.iter().flatten().sum();
        let trace: f64 = (0..6).map(|i| matrix[i][i]).sum();
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { matrix[i][i] * total / trace } else { 0.0 }))
    }
}

/// `1/(2 dt^2) (x - y).M (x - y)`, `y` a place predicted by the time integration (`x_prev + dt v` for implicit Euler), over faces of `K` nodes and `N = 3 K` coordinates.
pub struct Inertia<const K: usize, const N: usize> {
    nodes: Vec<[usize; K]>,
    /// Mass matrix of each face [kg].
    matrices: Vec<[[f64; K]; K]>,
    /// The same without factors, once there are any.
    start: Vec<[[f64; K]; K]>,
    scatter: Scatter<N>,
    predicted: Vec<f64>,
    dt: f64,
}

impl<const K: usize, const N: usize> Inertia<K, N> {
    /// `nodes`: of each face. `matrices`: mass matrix [kg] of each face.
    pub fn new(nodes: Vec<[usize; K]>, matrices: Vec<[[f64; K]; K]>) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Inertia { nodes, matrices, start: Vec::new(), scatter, predicted: Vec::new(), dt: 1.0 }
    }

    fn stencil(nodes: &[usize; K]) -> [usize; N] {
        std::array::from_fn(|s| 3 * nodes[s / 3] + s % 3)
    }

    /// Gradient and energy of one face.
    #[inline]
    fn face(&self, face: usize, x: &[f64]) -> ([f64; N], f64) {
        let nodes = &self.nodes[face];
        let d: [f64; N] = std::array::from_fn(|s| {
            let u = 3 * nodes[s / 3] + s % 3;
            x[u] - self.predicted[u]
        });
        let factor = 1.0 / (self.dt * self.dt);
        let mut gradient = [0.0; N];
        for (i, row) in self.matrices[face].iter().enumerate() {
            for (j, mass) in row.iter().enumerate() {
                for k in 0..3 {
                    gradient[3 * i + k] += factor * mass * d[3 * j + k];
                }
            }
        }
        let energy = 0.5 * gradient.iter().zip(&d).map(|(g, d)| g * d).sum::<f64>();
        (gradient, energy)
    }
}

/// Inertia as a model sees it, whatever the number of nodes of its faces.
pub trait Inertial: Potential {
    /// Starts a step of size `dt` [s] from positions `x` [m] and velocities `v` [m/s] (both over the coordinates, other unknowns ignored).
    fn start_step(&mut self, x: &[f64], v: &[f64], dt: f64) {
        self.pull_to(x.iter().zip(v).map(|(x, v)| x + dt * v).collect(), dt);
    }

    /// From now on the energy is `1/(2 s^2) |x - y|_M^2`. `predicted`: `y` [m], over the coordinates. `dt`: `s` [s].
    fn pull_to(&mut self, predicted: Vec<f64>, dt: f64);

    /// Sets the factors on the masses of the faces that they had at the start, > 0.
    fn set_factors(&mut self, factors: &[f64]);

    /// Kinetic energy [J] of velocities `v`.
    fn kinetic_energy(&self, v: &[f64]) -> f64;

    /// Momentum [kg m/s] of velocities `v`.
    fn momentum(&self, v: &[f64]) -> Vector3<f64>;
}

impl<const K: usize, const N: usize> Inertial for Inertia<K, N> {
    fn pull_to(&mut self, predicted: Vec<f64>, dt: f64) {
        self.predicted = predicted;
        self.dt = dt;
    }

    fn set_factors(&mut self, factors: &[f64]) {
        if self.start.is_empty() {
            self.start = self.matrices.clone();
        }
        for ((matrix, start), factor) in self.matrices.iter_mut().zip(&self.start).zip(factors) {
            *matrix = start.map(|row| row.map(|mass| factor * mass));
        }
    }

    fn kinetic_energy(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (nodes, matrix) in self.nodes.iter().zip(&self.matrices) {
            for (i, row) in matrix.iter().enumerate() {
                for (j, mass) in row.iter().enumerate() {
                    let (p, q) = (3 * nodes[i], 3 * nodes[j]);
                    sum += mass * (v[p] * v[q] + v[p + 1] * v[q + 1] + v[p + 2] * v[q + 2]);
                }
            }
        }
        0.5 * sum
    }

    fn momentum(&self, v: &[f64]) -> Vector3<f64> {
        let mut p = Vector3::zeros();
        for (nodes, matrix) in self.nodes.iter().zip(&self.matrices) {
            for (row, &node) in matrix.iter().zip(nodes) {
                let mass: f64 = row.iter().sum();
                for k in 0..3 {
                    p[k] += mass * v[3 * node + k];
                }
            }
        }
        p
    }
}

impl<const K: usize, const N: usize> Potential for Inertia<K, N> {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        for nodes in &self.nodes {
            visit(&Self::stencil(nodes));
        }
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.scatter = Scatter::new(self.nodes.iter().map(Self::stencil), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        (0..self.nodes.len()).map(|f| self.face(f, x).1).sum()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        let mut energy = 0.0;
        let inverse = 1.0 / (self.dt * self.dt);
        for face in 0..self.nodes.len() {
            let (gradient, e) = self.face(face, x);
            energy += e;
            let mut hessian = [[0.0; N]; N];
            for (i, row) in self.matrices[face].iter().enumerate() {
                for (j, mass) in row.iter().enumerate().take(i + 1) {
                    for k in 0..3 {
                        hessian[3 * i + k][3 * j + k] = mass * inverse;
                    }
                }
            }
            self.scatter.add_gradient(face, &gradient, into);
            self.scatter.add_hessian(face, &hessian, into);
        }
        energy
    }

    fn stiffness_along(&self, _x: &[f64], y: &[f64]) -> f64 {
        2.0 * self.kinetic_energy(y) / (self.dt * self.dt)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let mut energy = 0.0;
        for face in 0..self.nodes.len() {
            let (gradient, e) = self.face(face, x);
            energy += e;
            self.scatter.add_gradient(face, &gradient, into);
        }
        energy
    }
}

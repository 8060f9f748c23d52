//! Inertia and weight of a shell (seed A, section 3; PHYSICS A2, A4).
//!
//! Mass is that of the rest forms at the start, `h rho sqrt(det abar)`, and is conserved while the shell swells. Both are exact integrals of
//! the element's shape functions. Neither knows of time integration beyond the predictor it is given.

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
    /// Share of a linear triangle's mass that couples two of its vertices; the entries add up to 1.
    pub fn linear(self) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match self {
                MassKind::Consistent => (1.0 + f64::from(u8::from(i == j))) / 12.0,
                MassKind::Lumped => f64::from(u8::from(i == j)) / 3.0,
            })
        })
    }
}

/// `1/(2 dt^2) (x - y).M (x - y)` with `y = x_prev + dt v`, over faces of `K` nodes and `N = 3 K` coordinates.
pub struct Inertia<const K: usize, const N: usize> {
    nodes: Vec<[usize; K]>,
    /// Mass of each face [kg].
    masses: Vec<f64>,
    /// Mass matrix of a face of unit mass.
    reference: [[f64; K]; K],
    scatter: Scatter<N>,
    predicted: Vec<f64>,
    dt: f64,
}

impl<const K: usize, const N: usize> Inertia<K, N> {
    /// `nodes`: of each face. `masses`: [kg] of each face. `reference`: mass matrix of a face of unit mass.
    pub fn new(nodes: Vec<[usize; K]>, masses: Vec<f64>, reference: [[f64; K]; K]) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Inertia { nodes, masses, reference, scatter, predicted: Vec::new(), dt: 1.0 }
    }

    /// Starts a step of size `dt` [s] from positions `x` [m] and velocities `v` [m/s] (both over the coordinates, other unknowns ignored).
    pub fn start_step(&mut self, x: &[f64], v: &[f64], dt: f64) {
        self.predicted.clear();
        self.predicted.extend(x.iter().zip(v).map(|(x, v)| x + dt * v));
        self.dt = dt;
    }

    /// Kinetic energy [J] of velocities `v`.
    pub fn kinetic_energy(&self, v: &[f64]) -> f64 {
        0.5 * self.quadratic(v)
    }

    /// Momentum [kg m/s] of velocities `v`.
    pub fn momentum(&self, v: &[f64]) -> Vector3<f64> {
        let mut p = Vector3::zeros();
        for (nodes, mass) in self.nodes.iter().zip(&self.masses) {
            for (row, &node) in self.reference.iter().zip(nodes) {
                let share: f64 = row.iter().sum();
                for k in 0..3 {
                    p[k] += mass * share * v[3 * node + k];
                }
            }
        }
        p
    }

    /// `v.M v`.
    fn quadratic(&self, v: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (nodes, mass) in self.nodes.iter().zip(&self.masses) {
            for (i, row) in self.reference.iter().enumerate() {
                for (j, share) in row.iter().enumerate() {
                    let (p, q) = (3 * nodes[i], 3 * nodes[j]);
                    sum += mass * share * (v[p] * v[q] + v[p + 1] * v[q + 1] + v[p + 2] * v[q + 2]);
                }
            }
        }
        sum
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
        let factor = self.masses[face] / (self.dt * self.dt);
        let mut gradient = [0.0; N];
        for (i, row) in self.reference.iter().enumerate() {
            for (j, share) in row.iter().enumerate() {
                for k in 0..3 {
                    gradient[3 * i + k] += factor * share * d[3 * j + k];
                }
            }
        }
        let energy = 0.5 * gradient.iter().zip(&d).map(|(g, d)| g * d).sum::<f64>();
        (gradient, energy)
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
            for (i, row) in self.reference.iter().enumerate() {
                for (j, share) in row.iter().enumerate().take(i + 1) {
                    for k in 0..3 {
                        hessian[3 * i + k][3 * j + k] = self.masses[face] * share * inverse;
                    }
                }
            }
            self.scatter.add_gradient(face, &gradient, into);
            self.scatter.add_hessian(face, &hessian, into);
        }
        energy
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

/// Weight: `-factor sum_i m_i g.x_i`, a constant force.
pub struct Gravity {
    /// Mass carried by each node [kg].
    masses: Vec<f64>,
    /// Acceleration [m/s2].
    acceleration: Vector3<f64>,
    factor: f64,
    numbers: Vec<[u32; 3]>,
}

impl Gravity {
    /// `masses`: [kg] per node, the face masses by the shape functions' integrals.
    pub fn new(masses: Vec<f64>, acceleration: Vector3<f64>) -> Self {
        Gravity { masses, acceleration, factor: 1.0, numbers: Vec::new() }
    }

    /// Sets the factor on the acceleration.
    pub fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }
}

impl Potential for Gravity {
    fn stencils(&self, _visit: &mut dyn FnMut(&[usize])) {}

    fn bind(&mut self, numbering: &Numbering, _pattern: &Pattern) {
        self.numbers = (0..self.masses.len()).map(|i| std::array::from_fn(|k| numbering.of(3 * i + k))).collect();
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let g = self.acceleration * self.factor;
        -self.masses.iter().zip(x.chunks_exact(3)).map(|(m, x)| m * (g.x * x[0] + g.y * x[1] + g.z * x[2])).sum::<f64>()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        for (mass, numbers) in self.masses.iter().zip(&self.numbers) {
            for (k, &number) in numbers.iter().enumerate() {
                if number != crate::sparse::HELD {
                    into.gradient[number as usize] -= mass * self.factor * self.acceleration[k];
                }
            }
        }
        self.energy(x)
    }
}

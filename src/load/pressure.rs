//! Pressure that follows the surface: a force `p n dA` on every piece of it, `n` its present normal.
//!
//! The forces are those of the present surface, integrated with the shape functions. Their derivative is symmetric wherever the edge of
//! the loaded part is held or the part is closed; elsewhere the symmetric part is taken, which costs iterations, not accuracy. The energy is
//! `-p` times the volume under the surface as seen from the origin, whose gradient is the force except at free edges of the loaded part.

use crate::math::SurfacePoint;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::{Matrix3, Vector3};

/// Pressure on faces of `K` nodes and `N = 3 K` coordinates.
pub struct Pressure<const K: usize, const N: usize> {
    nodes: Vec<[usize; K]>,
    points: Vec<SurfacePoint<K>>,
    pressure: f64,
    factor: f64,
    scatter: Scatter<N>,
}

impl<const K: usize, const N: usize> Pressure<K, N> {
    /// `nodes`: of each loaded face. `points`: quadrature of the element. `pressure`: [Pa], positive along the normal.
    pub fn new(nodes: Vec<[usize; K]>, points: Vec<SurfacePoint<K>>, pressure: f64) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Pressure { nodes, points, pressure, factor: 1.0, scatter }
    }

    fn stencil(nodes: &[usize; K]) -> [usize; N] {
        std::array::from_fn(|s| 3 * nodes[s / 3] + s % 3)
    }

    fn positions(&self, face: usize, x: &[f64]) -> [Vector3<f64>; K] {
        self.nodes[face].map(|n| Vector3::new(x[3 * n], x[3 * n + 1], x[3 * n + 2]))
    }

    /// Tangent vectors at a quadrature point.
    fn tangents(point: &SurfacePoint<K>, r: &[Vector3<f64>; K]) -> [Vector3<f64>; 2] {
        point.slopes.map(|slopes| r.iter().zip(slopes).map(|(r, s)| r * s).sum())
    }

    /// Gradient and energy of one face.
    fn face(&self, face: usize, x: &[f64]) -> ([f64; N], f64) {
        let r = self.positions(face, x);
        let p = self.pressure * self.factor;
        let (mut gradient, mut energy) = ([0.0; N], 0.0);
        for point in &self.points {
            let [r1, r2] = Self::tangents(point, &r);
            let area = r1.cross(&r2) * (p * point.weight);
            for (i, n) in point.shape.iter().enumerate() {
                for k in 0..3 {
                    gradient[3 * i + k] -= n * area[k];
                }
                energy -= n * r[i].dot(&area) / 3.0;
            }
        }
        (gradient, energy)
    }
}

/// `[a]_x` with `[a]_x b = a x b`.
fn cross(a: &Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}

impl<const K: usize, const N: usize> super::Load for Pressure<K, N> {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }
}

impl<const K: usize, const N: usize> Potential for Pressure<K, N> {
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

    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        let energy = self.gradient(x, into);
        // Descent wants a positive semidefinite matrix, which that of a pressure is not.
        if curvature == Curvature::Projected {
            return energy;
        }
        let p = self.pressure * self.factor;
        for face in 0..self.nodes.len() {
            let r = self.positions(face, x);
            let mut blocks = [[Matrix3::zeros(); K]; K];
            for point in &self.points {
                let [r1, r2] = Self::tangents(point, &r).map(|t| cross(&t) * (-p * point.weight));
                for (i, n) in point.shape.iter().enumerate() {
                    for j in 0..K {
                        blocks[i][j] += (r1 * point.slopes[1][j] - r2 * point.slopes[0][j]) * *n;
                    }
                }
            }
            let mut hessian = [[0.0; N]; N];
            for i in 0..K {
                for j in 0..=i {
                    let block = (blocks[i][j] + blocks[j][i].transpose()) * 0.5;
                    for a in 0..3 {
                        for b in 0..3 {
                            hessian[3 * i + a][3 * j + b] = block[(a, b)];
                        }
                    }
                }
            }
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

//! Drag of the air on a moving surface: per area `density / 2 (c_n |u_n| u_n + c_t |u_t| u_t)`, `u` the velocity of the air relative to the surface,
//! in its parts along and across the normal.
//!
//! The surface's velocity is that which the integrator gives the state that it seeks, `(x - x_0) / interval`; place, area and normal are guessed
//! beforehand: those of the start by implicit Euler, that moved on with its velocities by the methods of second order, so that these keep their
//! order. So the drag is the gradient of a convex potential, the third power of the relative velocities: in still air it takes energy at any
//! step size, and its derivative is exact. The air itself does not feel the surface: there is no wake and no lift but that of the two coefficients.

use super::{VectorField, not_finite};
use crate::math::SurfacePoint;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::{Matrix3, Vector3};

/// What a step knows of a quadrature point.
#[derive(Clone, Copy, Debug)]
struct Frozen {
    /// Unit normal.
    normal: Vector3<f64>,
    /// Half the air's density times the area [kg/m].
    half: f64,
    /// Velocity of the air less that which the surface would have at the origin [m/s]: `air + x_0 / interval`.
    air: Vector3<f64>,
}

/// Drag on faces of `K` nodes and `N = 3 K` coordinates.
pub struct Wind<const K: usize, const N: usize> {
    nodes: Vec<[usize; K]>,
    points: Vec<SurfacePoint<K>>,
    air: VectorField,
    density: f64,
    /// Across and along the surface.
    coefficients: [f64; 2],
    factor: f64,
    /// Initial places, one per face and point, where the field is looked at beforehand.
    places: Vec<Vector3<f64>>,
    /// Interval [s] by which the way from `x_0` is divided.
    interval: f64,
    frozen: Vec<Frozen>,
    scatter: Scatter<N>,
}

impl<const K: usize, const N: usize> Wind<K, N> {
    /// `nodes`: of each face in the wind. `points`: quadrature of the element. `positions`: initial, of all nodes [m]. `air`: velocity of the air
    /// [m/s] at a present place. `density`: of the air [kg/m3]. `coefficients`: across and along the surface [1].
    pub fn new(
        nodes: Vec<[usize; K]>,
        points: Vec<SurfacePoint<K>>,
        positions: &[Vector3<f64>],
        air: VectorField,
        density: f64,
        coefficients: [f64; 2],
    ) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        let at = |face: &[usize; K], point: &SurfacePoint<K>| face.iter().zip(point.shape).map(|(n, s)| positions[*n] * s).sum();
        let places = nodes.iter().flat_map(|face| points.iter().map(move |point| at(face, point))).collect();
        Wind { nodes, points, air, density, coefficients, factor: 1.0, places, interval: 1.0, frozen: Vec::new(), scatter }
    }

    fn stencil(nodes: &[usize; K]) -> [usize; N] {
        std::array::from_fn(|s| 3 * nodes[s / 3] + s % 3)
    }

    fn positions(&self, face: usize, x: &[f64]) -> [Vector3<f64>; K] {
        self.nodes[face].map(|n| Vector3::new(x[3 * n], x[3 * n + 1], x[3 * n + 2]))
    }

    /// Force [N] at each point of a face and the interval times its power potential [J]; `visit` gets the point, the force and the relative velocity.
    fn face(&self, face: usize, x: &[f64], mut visit: impl FnMut(&SurfacePoint<K>, Vector3<f64>, &Frozen, Vector3<f64>)) -> f64 {
        let r = self.positions(face, x);
        let count = self.points.len();
        // No step has started: there is no motion yet, and no drag.
        let Some(frozen) = self.frozen.get(count * face..count * (face + 1)) else { return 0.0 };
        let mut energy = 0.0;
        for (point, frozen) in self.points.iter().zip(frozen) {
            let place: Vector3<f64> = r.iter().zip(point.shape).map(|(r, s)| r * s).sum();
            let u = frozen.air - place / self.interval;
            let across = frozen.normal * u.dot(&frozen.normal);
            let along = u - across;
            let [n, t] = self.coefficients.map(|c| c * frozen.half * self.factor);
            energy += self.interval / 3.0 * (n * across.norm().powi(3) + t * along.norm().powi(3));
            visit(point, across * (n * across.norm()) + along * (t * along.norm()), frozen, u);
        }
        energy
    }
}

impl<const K: usize, const N: usize> super::Load for Wind<K, N> {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }

    fn start_step(&mut self, [place, origin]: [&[f64]; 2], time: f64, interval: f64) {
        self.interval = interval;
        let mut frozen = std::mem::take(&mut self.frozen);
        frozen.clear();
        for face in 0..self.nodes.len() {
            let [r, from] = [place, origin].map(|x| self.positions(face, x));
            for point in &self.points {
                let [r1, r2] = point.slopes.map(|slopes| r.iter().zip(slopes).map(|(r, s)| r * s).sum::<Vector3<f64>>());
                let [place, from] = [&r, &from].map(|r| r.iter().zip(point.shape).map(|(r, s)| r * s).sum::<Vector3<f64>>());
                let area = r1.cross(&r2);
                let half = 0.5 * self.density * area.norm() * point.weight;
                let air = (self.air)(&place, time) + from / interval;
                frozen.push(Frozen { normal: area.try_normalize(0.0).unwrap_or_default(), half, air });
            }
        }
        self.frozen = frozen;
    }

    fn fault(&self, time: f64, _factor: f64) -> Option<(&'static str, String)> {
        not_finite(self.places.iter(), time, |p| (self.air)(p, time).sum()).map(|reason| ("velocity", reason))
    }
}

impl<const K: usize, const N: usize> Potential for Wind<K, N> {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        self.nodes.iter().for_each(|nodes| visit(&Self::stencil(nodes)));
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.scatter = Scatter::new(self.nodes.iter().map(Self::stencil), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        (0..self.nodes.len()).map(|face| self.face(face, x, |_, _, _, _| ())).sum()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        let energy = self.gradient(x, into);
        for face in 0..self.nodes.len() {
            let mut hessian = [[0.0; N]; N];
            self.face(face, x, |point, _, frozen, u| {
                let [n, t] = self.coefficients.map(|c| c * frozen.half * self.factor / self.interval);
                let normal = frozen.normal * frozen.normal.transpose();
                let across = u.dot(&frozen.normal);
                let along = u - frozen.normal * across;
                let size = along.norm();
                let mut block = normal * (2.0 * n * across.abs());
                if size > 0.0 {
                    block += ((Matrix3::identity() - normal) * size + along * along.transpose() / size) * t;
                }
                for i in 0..K {
                    for j in 0..=i {
                        let shares = point.shape[i] * point.shape[j];
                        for a in 0..3 {
                            for b in 0..3 {
                                hessian[3 * i + a][3 * j + b] += shares * block[(a, b)];
                            }
                        }
                    }
                }
            });
            self.scatter.add_hessian(face, &hessian, into);
        }
        energy
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let mut energy = 0.0;
        for face in 0..self.nodes.len() {
            let mut gradient = [0.0; N];
            energy += self.face(face, x, |point, force, _, _| {
                for (i, share) in point.shape.iter().enumerate() {
                    (0..3).for_each(|k| gradient[3 * i + k] -= share * force[k]);
                }
            });
            self.scatter.add_gradient(face, &gradient, into);
        }
        energy
    }
}

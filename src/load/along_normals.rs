//! Loads along the normals of a surface of quadrangles, which they follow from step to step: forces on nodes, and a stream (Wu and de Melo, (36)).
//!
//! Normals and areas are those of the start of the step, so that a stream is an energy of the step: convex, whatever the surface does.

use super::Load;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::{Matrix3, Vector3};

/// Area vector of a quadrangle [m2], along its normal. Corners around; `x`: coordinates of all nodes [m].
pub fn cell_area(quadrangle: &[usize; 4], x: &[f64]) -> Vector3<f64> {
    let [a, b, c, d] = quadrangle.map(|n| Vector3::new(x[3 * n], x[3 * n + 1], x[3 * n + 2]));
    (c - a).cross(&(d - b)) * 0.5
}

/// Area vectors of the nodes [m2]: each quadrangle gives a quarter to each corner.
pub fn node_areas(quadrangles: &[[usize; 4]], x: &[f64], nodes: usize) -> Vec<Vector3<f64>> {
    let mut areas = vec![Vector3::zeros(); nodes];
    for quadrangle in quadrangles {
        let quarter = cell_area(quadrangle, x) * 0.25;
        quadrangle.iter().for_each(|n| areas[*n] += quarter);
    }
    areas
}

/// What acts along the normals.
#[derive(Clone, Debug)]
pub enum AlongNormals {
    /// The same force [N] on some nodes.
    Force {
        /// Loaded nodes.
        nodes: Vec<usize>,
        /// Force [N].
        force: f64,
    },
    /// `coefficient (n.(velocity - v)) n` per area.
    Stream {
        /// Coefficient [Pa s/m].
        coefficient: f64,
        /// Velocity of the stream [m/s].
        velocity: Vector3<f64>,
    },
}

/// A load along the normals of a surface.
pub struct NormalLoad {
    quadrangles: Vec<[usize; 4]>,
    nodes: usize,
    kind: AlongNormals,
    factor: f64,
    before: Vec<f64>,
    dt: f64,
    /// Constant part of the force on each node [N] and, of a stream, the vector `a` of its damping `a a^T` [(kg/s)^1/2].
    forces: Vec<(Vector3<f64>, Vector3<f64>)>,
    scatter: Scatter<3>,
}

impl NormalLoad {
    /// `quadrangles`: corners around of every cell of the surface. `nodes`: their number.
    pub fn new(quadrangles: Vec<[usize; 4]>, nodes: usize, kind: AlongNormals) -> Self {
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        NormalLoad { quadrangles, nodes, kind, factor: 1.0, before: vec![0.0; 3 * nodes], dt: 1.0, forces: Vec::new(), scatter }
    }

    fn moved(&self, node: usize, x: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|k, _| x[3 * node + k] - self.before[3 * node + k])
    }
}

impl Load for NormalLoad {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }

    /// A stream of negative factor would push where it comes from: drag that gives energy, of which no step is a minimum.
    fn fault(&self, time: f64, factor: f64) -> Option<(&'static str, String)> {
        let stream = matches!(self.kind, AlongNormals::Stream { .. });
        (stream && factor < 0.0).then(|| ("factor", format!("is {factor} at t = {time}: a stream's must be >= 0")))
    }

    fn start_step(&mut self, [place, origin]: [&[f64]; 2], _time: f64, dt: f64) {
        let areas = node_areas(&self.quadrangles, place, self.nodes);
        self.before = origin.to_vec();
        self.dt = dt;
        self.forces = vec![Default::default(); self.nodes];
        match &self.kind {
            AlongNormals::Force { nodes, force } => {
                for node in nodes {
                    self.forces[*node].0 += areas[*node].try_normalize(0.0).unwrap_or_default() * (*force * self.factor);
                }
            }
            AlongNormals::Stream { coefficient, velocity } => {
                for (area, force) in areas.iter().zip(&mut self.forces) {
                    let root = (coefficient * area.norm() * self.factor).sqrt();
                    let along = area.try_normalize(0.0).unwrap_or_default() * root;
                    *force = (along * along.dot(velocity), along);
                }
            }
        }
    }
}

impl Potential for NormalLoad {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        (0..self.nodes).for_each(|n| visit(&[3 * n, 3 * n + 1, 3 * n + 2]));
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.scatter = Scatter::new((0..self.nodes).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let of = |(node, (force, along)): (usize, &(Vector3<f64>, Vector3<f64>))| {
            let moved = self.moved(node, x);
            0.5 * along.dot(&moved).powi(2) / self.dt - force.dot(&moved)
        };
        self.forces.iter().enumerate().map(of).sum()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        for (node, (_, along)) in self.forces.iter().enumerate() {
            let block: Matrix3<f64> = along * along.transpose() / self.dt;
            self.scatter.add_hessian(node, &block.data.0, into);
        }
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        for (node, (force, along)) in self.forces.iter().enumerate() {
            let gradient = along * (along.dot(&self.moved(node, x)) / self.dt) - force;
            self.scatter.add_gradient(node, &gradient.data.0[0], into);
        }
        self.energy(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slanted square that moves: the force of the stream is (36) at the end of the step.
    #[test]
    fn the_stream_is_that_of_the_paper() -> crate::Result<()> {
        let x = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 1.0, 1.0, 0.0, 1.0, 1.0];
        let velocity = Vector3::new(0.5, -3.0, 1.0);
        let kind = AlongNormals::Stream { coefficient: 0.032, velocity };
        let mut load = NormalLoad::new(vec![[0, 1, 2, 3]], 4, kind);
        let (numbering, dt) = (Numbering::new(&[false; 12]), 0.25);
        let pattern = Pattern::new(&numbering, &mut |visit| load.stencils(visit))?;
        load.bind(&numbering, &pattern);
        load.start_step([&x, &x], dt, dt);
        let moved: Vec<f64> = x.iter().enumerate().map(|(i, x)| x + 0.1 * (1.3 * i as f64).sin()).collect();
        let mut system = System::new(&pattern);
        let energy = load.assemble(&moved, Curvature::Mixed, &mut system);
        let (normal, area) = (Vector3::new(0.0, -1.0, 1.0).normalize(), 2.0 * 2f64.sqrt());
        for node in 0..4 {
            let v = Vector3::from_fn(|k, _| (moved[3 * node + k] - x[3 * node + k]) / dt);
            let force = normal * (0.032 * area / 4.0 * normal.dot(&(velocity - v)));
            for k in 0..3 {
                assert!((system.gradient[3 * node + k] + force[k]).abs() < 1e-14);
                let at = |h: f64| {
                    let mut moved = moved.clone();
                    moved[3 * node + k] += h;
                    load.energy(&moved)
                };
                assert!(((at(1e-4) - at(-1e-4)) / 2e-4 + force[k]).abs() < 1e-9);
            }
            assert!(force.norm() > 1e-3);
        }
        assert!(
            load.fault(dt, 0.0).is_none() && load.fault(dt, -0.5).is_some_and(|(key, reason)| key == "factor" && reason.contains("-0.5"))
        );
        assert!(energy.is_finite() && system.matrix.iter().all(|v| v.is_finite()));
        Ok(())
    }

    #[test]
    fn normal_forces_follow_the_surface() -> crate::Result<()> {
        let x = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 1.0, 1.0, 0.0, 1.0, 1.0];
        let mut load = NormalLoad::new(vec![[0, 1, 2, 3]], 4, AlongNormals::Force { nodes: vec![2], force: 3.0 });
        let numbering = Numbering::new(&[false; 12]);
        let pattern = Pattern::new(&numbering, &mut |visit| load.stencils(visit))?;
        load.bind(&numbering, &pattern);
        load.set_factor(0.5);
        load.start_step([&x, &x], 0.1, 0.1);
        let mut system = System::new(&pattern);
        load.gradient(&x, &mut system);
        let root = 0.5f64.sqrt();
        let expected = [0.0, 1.5 * root, -1.5 * root];
        assert!((0..3).all(|k| (system.gradient[6 + k] - expected[k]).abs() < 1e-14), "{:?}", system.gradient);
        assert!(system.gradient[..6].iter().all(|g| *g == 0.0));
        Ok(())
    }
}

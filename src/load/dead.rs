//! Forces that keep size and direction while the shell moves.

use crate::sparse::{Curvature, HELD, Numbering, Pattern, Potential, System};
use nalgebra::Vector3;

/// `-factor sum_i f_i.x_i`: constant forces on nodes.
#[derive(Clone, Debug)]
pub struct DeadLoad {
    /// Node and force [N].
    forces: Vec<(usize, Vector3<f64>)>,
    /// Acceleration of weight [m/s2]; none for other forces.
    acceleration: Option<Vector3<f64>>,
    factor: f64,
    /// Free numbers of each force's coordinates.
    numbers: Vec<[u32; 3]>,
}

impl DeadLoad {
    /// `forces`: node and force [N]; forces on one node add up.
    pub fn new(forces: Vec<(usize, Vector3<f64>)>) -> Self {
        DeadLoad { forces, acceleration: None, factor: 1.0, numbers: Vec::new() }
    }

    /// Weight of the masses that the nodes carry [kg] under an acceleration [m/s2].
    pub fn weight(masses: &[f64], acceleration: Vector3<f64>) -> Self {
        let forces = masses.iter().map(|mass| acceleration * *mass).enumerate().collect();
        DeadLoad { acceleration: Some(acceleration), ..DeadLoad::new(forces) }
    }
}

impl super::Load for DeadLoad {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }

    fn set_masses(&mut self, masses: &[f64]) {
        if let Some(acceleration) = self.acceleration {
            self.forces.iter_mut().for_each(|(node, force)| *force = acceleration * masses[*node]);
        }
    }
}

impl Potential for DeadLoad {
    fn stencils(&self, _visit: &mut dyn FnMut(&[usize])) {}

    fn bind(&mut self, numbering: &Numbering, _pattern: &Pattern) {
        self.numbers = self.forces.iter().map(|(node, _)| std::array::from_fn(|k| numbering.of(3 * node + k))).collect();
    }

    fn energy(&self, x: &[f64]) -> f64 {
        -self.factor * self.forces.iter().map(|(i, f)| f.x * x[3 * i] + f.y * x[3 * i + 1] + f.z * x[3 * i + 2]).sum::<f64>()
    }

    /// A dead load has no stiffness.
    fn add_product(&self, _x: &[f64], _v: &[f64], _into: &mut System) -> bool {
        true
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        for ((_, force), numbers) in self.forces.iter().zip(&self.numbers) {
            for (k, &number) in numbers.iter().enumerate() {
                if number != HELD {
                    into.gradient[number as usize] -= self.factor * force[k];
                }
            }
        }
        self.energy(x)
    }
}

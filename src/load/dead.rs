//! Forces that keep size and direction while the shell moves.

use super::{VectorField, not_finite};
use crate::sparse::{Curvature, HELD, Numbering, Pattern, Potential, System};
use nalgebra::Vector3;

/// Weight: the acceleration [m/s2] of a node's initial place and of time.
struct Weight {
    acceleration: VectorField,
    changes: bool,
    places: Vec<Vector3<f64>>,
    masses: Vec<f64>,
    time: f64,
}

/// `-factor sum_i f_i.x_i`: constant forces on nodes.
pub struct DeadLoad {
    /// Node and force [N].
    forces: Vec<(usize, Vector3<f64>)>,
    /// What makes the forces of weight; none for other forces.
    weight: Option<Weight>,
    factor: f64,
    /// Free numbers of each force's coordinates.
    numbers: Vec<[u32; 3]>,
}

impl DeadLoad {
    /// `forces`: node and force [N]; forces on one node add up.
    pub fn new(forces: Vec<(usize, Vector3<f64>)>) -> Self {
        DeadLoad { forces, weight: None, factor: 1.0, numbers: Vec::new() }
    }

    /// Weight of the masses that the nodes carry [kg] under an acceleration [m/s2], a field of the nodes' initial places [m] and of time.
    /// `changes`: whether it depends on time. The forces are those of time 0.
    pub fn weight(masses: &[f64], places: &[Vector3<f64>], acceleration: VectorField, changes: bool) -> Self {
        let weight = Weight { acceleration, changes, places: places.to_vec(), masses: masses.to_vec(), time: 0.0 };
        let mut load = DeadLoad { weight: Some(weight), ..DeadLoad::new((0..masses.len()).map(|i| (i, Vector3::zeros())).collect()) };
        load.weigh();
        load
    }

    /// Number of forces.
    pub(super) fn len(&self) -> usize {
        self.forces.len()
    }

    /// Replaces the forces on their nodes [N].
    pub(super) fn set_forces(&mut self, forces: Vec<Vector3<f64>>) {
        self.forces.iter_mut().zip(forces).for_each(|((_, force), new)| *force = new);
    }

    fn weigh(&mut self) {
        let Some(weight) = &self.weight else { return };
        for (node, force) in &mut self.forces {
            *force = (weight.acceleration)(&weight.places[*node], weight.time) * weight.masses[*node];
        }
    }
}

impl super::Load for DeadLoad {
    fn set_factor(&mut self, factor: f64) {
        self.factor = factor;
    }

    fn set_time(&mut self, time: f64) {
        if let Some(weight) = self.weight.as_mut().filter(|weight| weight.changes && weight.time != time) {
            weight.time = time;
            self.weigh();
        }
    }

    fn set_masses(&mut self, masses: &[f64]) {
        if let Some(weight) = &mut self.weight {
            weight.masses.copy_from_slice(masses);
            self.weigh();
        }
    }

    fn follows_mass(&self) -> bool {
        self.weight.is_some()
    }

    fn fault(&self, time: f64, _factor: f64) -> Option<(&'static str, String)> {
        let weight = self.weight.as_ref()?;
        not_finite(weight.places.iter(), time, |p| (weight.acceleration)(p, time).sum()).map(|reason| ("acceleration", reason))
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

//! What diffuses through a shell, and what it changes: the rest shape, the stiffness, the mass.
//!
//! The geometry of the diffusion is that of the rest shape at the start, so it does not depend on how the shell moves, but for wet ground, which asks for
//! heights of the middle surface at the start of a step. A step of the shell takes the values of its end: the coupling itself has no error in time.

use crate::moisture::Diffusion;
use crate::shell::rest::Site;
use crate::snapshot::{Association, Field, Snapshot};
use std::cell::{Ref, RefCell};
use std::rc::Rc;

/// Values over the vertices and levels of a shell, shared between what computes them and the rest laws that read them.
#[derive(Clone, Debug)]
pub struct Profile(Rc<Shared>);

#[derive(Debug)]
struct Shared {
    faces: Vec<[usize; 3]>,
    levels: Vec<f64>,
    /// Whether laws see means of faces.
    means: bool,
    values: RefCell<Vec<f64>>,
}

impl Profile {
    /// `levels`: heights as fractions of the thickness. `means`: laws see the mean of each face. `values`: level by level, vertex by vertex.
    pub fn new(faces: Vec<[usize; 3]>, levels: Vec<f64>, means: bool, values: Vec<f64>) -> Self {
        Profile(Rc::new(Shared { faces, levels, means, values: RefCell::new(values) }))
    }

    /// Heights as fractions of the thickness, 0 at the bottom.
    pub fn levels(&self) -> &[f64] {
        &self.0.levels
    }

    /// All values, level by level, vertex by vertex.
    pub fn values(&self) -> Ref<'_, Vec<f64>> {
        self.0.values.borrow()
    }

    /// Sets all values.
    pub fn set(&self, values: &[f64]) {
        self.0.values.borrow_mut().copy_from_slice(values);
    }

    /// Value at a site, on a level: linear over the face, or its mean.
    pub fn at(&self, site: &Site, level: usize) -> f64 {
        let values = self.0.values.borrow();
        let [x, y] = if self.0.means { [1.0 / 3.0; 2] } else { site.place };
        let [a, b, c] = self.0.faces[site.face].map(|v| values[v * self.0.levels.len() + level]);
        (1.0 - x - y) * a + x * b + y * c
    }

    /// Mean over the thickness at each vertex.
    pub fn means(&self) -> Vec<f64> {
        let levels = &self.0.levels;
        let mean = |u: &[f64]| u.windows(2).zip(levels.windows(2)).map(|(u, x)| 0.5 * (u[0] + u[1]) * (x[1] - x[0])).sum();
        self.0.values.borrow().chunks_exact(levels.len()).map(mean).collect()
    }

    /// Mean over each face and its thickness.
    pub fn face_means(&self) -> Vec<f64> {
        let means = self.means();
        self.0.faces.iter().map(|face| face.iter().map(|v| means[*v]).sum::<f64>() / 3.0).collect()
    }
}

/// A quantity that diffuses.
pub struct Transport {
    /// Table of the scene.
    pub table: &'static str,
    /// Name of the quantity.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its diffusion.
    pub diffusion: Diffusion,
    /// What rest laws read.
    pub profile: Profile,
    /// Whether the diffusion asks for heights.
    pub reads_heights: bool,
    /// Factor on the stiffness of a face by its mean value.
    pub stiffness: Option<Box<dyn Fn(f64) -> f64>>,
    /// Mass per volume that 100 units add [kg/m3].
    pub added_density: Option<f64>,
}

impl Transport {
    /// Advances in time [s]. `x`: coordinates of the nodes, vertices first. Errors: what is impossible, in words.
    pub fn advance(&mut self, from: f64, to: f64, x: &[f64]) -> Result<(), String> {
        let vertices = self.diffusion.values().len() / self.profile.levels().len();
        let heights: Vec<f64> = if self.reads_heights { x.chunks_exact(3).take(vertices).map(|p| p[2]).collect() } else { Vec::new() };
        self.diffusion.advance(from, to, &heights)?;
        self.profile.set(self.diffusion.values());
        Ok(())
    }

    /// Shows rest laws what lies by `share` of the way from the values `before` to the present ones.
    pub fn show(&self, before: &[f64], share: f64) {
        let between: Vec<f64> = before.iter().zip(self.diffusion.values()).map(|(a, b)| a + share * (b - a)).collect();
        self.profile.set(&between);
    }

    /// Values and accumulators, to put back.
    pub fn state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.diffusion.values().to_vec(), self.diffusion.state())
    }

    /// Puts a state back. Errors: one of another size.
    pub fn set_state(&mut self, (values, state): (Vec<f64>, Vec<f64>)) -> Result<(), String> {
        self.profile.set(&values);
        self.diffusion.set(values);
        self.diffusion.restore(&state)
    }

    /// Adds its state to a snapshot.
    pub fn put(&self, snapshot: &mut Snapshot) {
        snapshot.fields.push(Field {
            name: self.name.into(),
            association: Association::Vertex,
            components: self.profile.levels().len(),
            unit: self.unit.into(),
            data: self.diffusion.values().to_vec(),
        });
        let state = self.diffusion.state().into_iter().enumerate();
        snapshot.numbers.extend(state.map(|(i, value)| (format!("{}_state_{i}", self.name), value)));
    }

    /// Takes its state from a snapshot. Errors: what is missing or of another size.
    pub fn take(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        let field = snapshot.field(self.name).ok_or(format!("it has no field '{}'", self.name))?;
        if field.data.len() != self.diffusion.values().len() {
            return Err(format!("field '{}' has {} numbers instead of {}", self.name, field.data.len(), self.diffusion.values().len()));
        }
        let state = (0..self.diffusion.state().len()).map(|i| {
            let name = format!("{}_state_{i}", self.name);
            snapshot.number(&name).ok_or(format!("it has no number '{name}'"))
        });
        self.set_state((field.data.clone(), state.collect::<Result<_, _>>()?))
    }

    /// Names of the history's columns.
    pub fn columns(table: &str) -> [&'static str; 6] {
        match table {
            "heat" => ["heat_total_Km3", "heat_in_top_Km3", "heat_in_bottom_Km3", "heat_in_rim_Km3", "heat_source_Km3", "heat_overshoot_K"],
            _ => [
                "moisture_total_pct_m3",
                "moisture_in_top_pct_m3",
                "moisture_in_bottom_pct_m3",
                "moisture_in_rim_pct_m3",
                "moisture_source_pct_m3",
                "moisture_overshoot_pct",
            ],
        }
    }

    /// Their values.
    pub fn row(&self) -> [f64; 6] {
        let b = self.diffusion.balance();
        [b.content, b.top, b.bottom, b.rim, b.sources, self.diffusion.overshoot()]
    }
}

/// Mass that follows moisture: factors on the mass of each face, and what its nodes carry.
pub struct FollowingMass {
    /// Density of each face at the start, without what was added [kg/m3].
    pub densities: Vec<f64>,
    /// Node and mass [kg] of each face's shares at that density.
    pub carried: Vec<Vec<(usize, f64)>>,
    /// Number of nodes.
    pub nodes: usize,
}

impl FollowingMass {
    /// Factors on the masses of the faces for what the transports hold. Errors: the face where the mass would not be positive.
    pub fn factors(&self, transports: &[Transport]) -> Result<Vec<f64>, String> {
        let mut factors = vec![1.0; self.densities.len()];
        for transport in transports {
            let Some(added) = transport.added_density else { continue };
            for (factor, (u, density)) in factors.iter_mut().zip(transport.profile.face_means().iter().zip(&self.densities)) {
                *factor += 0.01 * u * added / density;
            }
        }
        match factors.iter().position(|f| !(f.is_finite() && *f > 0.0)) {
            Some(face) => Err(format!("face {face}: the moisture leaves it a mass of {} times that of the start", factors[face])),
            None => Ok(factors),
        }
    }

    /// Mass that each node carries [kg].
    pub fn node_masses(&self, factors: &[f64]) -> Vec<f64> {
        let mut masses = vec![0.0; self.nodes];
        for (factor, shares) in factors.iter().zip(&self.carried) {
            shares.iter().for_each(|(node, mass)| masses[*node] += factor * mass);
        }
        masses
    }
}

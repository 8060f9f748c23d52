//! A surface on a grid with its loads and supports, in statics or in motion (Wu and de Melo).
//!
//! The variational scheme is one minimisation a step, as for a shell. Density and damping of a Cosserat surface follow the area by (35): mass is that of the
//! nodes, which is conserved, and damping grows with the square of the area, since `lambda` is per present area and grows with it. The area is that at the start
//! of the step. (1), the equation of Terzopoulos and others, knows nothing of (35): there both densities are per coordinates and stay.

use super::Model;
use super::grid_step::{From, Strong};
use super::prescribed::{AppliedLoad, HeldUnknown, add_energies, check_loads, coordinate, set_loads};
use super::state::{counters, field, numbers, take_field};
use super::step::{StepFailure, StepReport};
use crate::cosserat::{CosseratSurface, Grid};
use crate::error::Result;
use crate::load::{Drag, Load, cell_area};
use crate::shell::Inertial;
use crate::snapshot::{Association, Snapshot};
use crate::solve::{Counters, Newton, Settings, Solved};
use crate::sparse::Potential;
use nalgebra::Vector3;

/// A horizontal disc on which nodes stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundTable {
    /// Centre [m]; its z is the height.
    pub centre: Vector3<f64>,
    /// Radius [m].
    pub radius: f64,
}

impl RoundTable {
    /// Where a node that moves from `before` to `after` comes down on the table, if it does.
    pub fn touch(&self, before: &Vector3<f64>, after: &Vector3<f64>) -> Option<Vector3<f64>> {
        let [above, below] = [before.z - self.centre.z, after.z - self.centre.z];
        if above < 0.0 || below > 0.0 {
            return None;
        }
        let share = if above > below { above / (above - below) } else { 0.0 };
        let mut place = before + (after - before) * share;
        place.z = self.centre.z;
        // On the rim but for round-off is on the table, or nodes of equal distance would differ.
        ((place - self.centre).norm() <= self.radius * (1.0 + 1e-12)).then_some(place)
    }
}

/// What a model on a grid is made of. What is absent has no object and costs nothing.
pub struct GridParts {
    /// Nodes and spacing, in metres.
    pub grid: Grid,
    /// Elastic energy.
    pub surface: CosseratSurface,
    /// The paper's scheme in the place of the variational one.
    pub strong: Option<Strong>,
    /// Inertia; absent in statics.
    pub inertia: Option<Box<dyn Inertial>>,
    /// Damping; absent for most.
    pub drag: Option<Drag>,
    /// Loads.
    pub loads: Vec<AppliedLoad>,
    /// Supports.
    pub held: Vec<HeldUnknown>,
    /// Initial positions [m].
    pub positions: Vec<Vector3<f64>>,
    /// Initial velocities [m/s]; empty in statics.
    pub velocities: Vec<Vector3<f64>>,
    /// A table on which nodes stick.
    pub table: Option<RoundTable>,
}

/// A surface on a grid advanced step by step.
pub struct GridModel {
    parts: GridParts,
    /// None for the paper's scheme.
    newton: Option<Newton>,
    settings: Settings,
    quadrangles: Vec<[usize; 4]>,
    initial_area: f64,
    x: Vec<f64>,
    v: Vec<f64>,
    /// Nodes that stick to the table; empty without one.
    stuck: Vec<bool>,
    step: u64,
    time: f64,
}

impl GridModel {
    /// Numbers the unknowns and analyses the matrix. `tolerance`: relative to the diameter.
    pub fn new(mut parts: GridParts, diameter: f64, tolerance: f64, max_iterations: usize) -> Result<Self> {
        let nodes = parts.positions.len();
        let mut x: Vec<f64> = parts.positions.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let mut v: Vec<f64> = parts.velocities.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        let stuck: Vec<bool> = match &parts.table {
            None => Vec::new(),
            Some(table) => x
                .chunks_exact_mut(3)
                .map(|p| {
                    let mut place = Vector3::new(p[0], p[1], p[2]);
                    // As high as the table but for the round-off of its place.
                    if (place.z - table.centre.z).abs() <= 1e-12 * diameter {
                        place.z = table.centre.z;
                    }
                    let stuck = table.touch(&place, &place).is_some();
                    if stuck {
                        p[2] = place.z;
                    }
                    stuck
                })
                .collect(),
        };
        v.chunks_exact_mut(3).zip(&stuck).filter(|(_, stuck)| **stuck).for_each(|(v, _)| v.fill(0.0));
        let settings = Settings { lengths: 3 * nodes, diameter, tolerance: tolerance * diameter, max_iterations };
        let quadrangles = quadrangles(&parts.grid);
        let held = held(&parts.held, &stuck, 3 * nodes);
        let newton = solver(&mut parts, &held, settings)?;
        let initial_area = area(&quadrangles, &x);
        Ok(GridModel { parts, newton, settings, quadrangles, initial_area, x, v, stuck, step: 0, time: 0.0 })
    }

    /// Numbers the unknowns anew after other nodes stick.
    fn renumber(&mut self) -> Result<()> {
        let counters = self.counters();
        let held = held(&self.parts.held, &self.stuck, self.x.len());
        self.newton = solver(&mut self.parts, &held, self.settings)?;
        self.set_counters(counters);
        Ok(())
    }

    fn node(x: &[f64], node: usize) -> Vector3<f64> {
        Vector3::new(x[3 * node], x[3 * node + 1], x[3 * node + 2])
    }

    /// Values [m] that the moved unknowns take at a time, once it is sure that all that is prescribed then is finite.
    fn prescribed(&self, time: f64) -> Result<Vec<(usize, f64)>, StepFailure> {
        check_loads(&self.parts.loads, time)?;
        let mut targets = Vec::new();
        for held in &self.parts.held {
            let moved = held.displacement(time, |unknown| coordinate(&self.parts.positions, unknown))?;
            if let Some((d, _)) = moved.filter(|_| !self.stuck.get(held.unknown / 3).is_some_and(|stuck| *stuck)) {
                targets.push((held.unknown, held.start + d));
            }
        }
        Ok(targets)
    }

    /// Lets nodes stick that came down on the table since `before`.
    fn touch(&mut self, before: &[f64]) -> Result<(), StepFailure> {
        let Some(table) = self.parts.table else { return Ok(()) };
        let mut any = false;
        for node in 0..self.stuck.len() {
            if self.stuck[node] {
                continue;
            }
            if let Some(place) = table.touch(&Self::node(before, node), &Self::node(&self.x, node)) {
                self.x[3 * node..3 * node + 3].copy_from_slice(place.as_slice());
                self.v[3 * node..3 * node + 3].fill(0.0);
                (self.stuck[node], any) = (true, true);
            }
        }
        if any { self.renumber().map_err(|e| StepFailure::Equations(e.to_string())) } else { Ok(()) }
    }

    fn try_advance(&mut self, dt: f64, time: f64) -> Result<StepReport, StepFailure> {
        let targets = self.prescribed(time)?;
        let before = self.x.clone();
        set_loads(&mut self.parts.loads, time);
        self.parts.loads.iter_mut().for_each(|load| load.potential.start_step([&before, &before], time, dt));
        if let Some(drag) = &mut self.parts.drag {
            let follows = self.parts.surface.is_per_present_area();
            let ratio = if follows { area(&self.quadrangles, &before) / self.initial_area } else { 1.0 };
            drag.start_step(&before, dt, ratio * ratio);
        }
        if let Some(inertia) = &mut self.parts.inertia {
            inertia.start_step(&before, &self.v, dt);
        }
        let solved = if self.parts.strong.is_some() { self.linear_step(dt, &targets)? } else { self.minimise(&targets)? };
        for (v, (now, before)) in self.v.iter_mut().zip(self.x.iter().zip(&before)) {
            *v = (now - before) / dt;
        }
        self.touch(&before)?;
        self.step += 1;
        self.time = time;
        Ok(StepReport { solved, error: None })
    }

    fn minimise(&mut self, targets: &[(usize, f64)]) -> Result<Solved, StepFailure> {
        let Some(newton) = &mut self.newton else { return Err(StepFailure::Equations("there is no solver".into())) };
        let solved = newton.solve(&mut potentials(&mut self.parts), &mut self.x, targets);
        let start = self.step == 0 && self.v.is_empty();
        solved.map_err(|failure| StepFailure::of(failure, start, |unknown| coordinate(&self.parts.positions, unknown)))
    }

    /// One step of the paper's scheme. It has blown up where a node moves by more than the surface is large.
    fn linear_step(&mut self, dt: f64, targets: &[(usize, f64)]) -> Result<Solved, StepFailure> {
        let areas = node_shares(&self.quadrangles, &self.x);
        let held = held(&self.parts.held, &self.stuck, self.x.len());
        let Some(strong) = &mut self.parts.strong else { return Err(StepFailure::Equations("there is no scheme".into())) };
        let loads: Vec<&dyn Load> = self.parts.loads.iter().map(|load| &*load.potential).collect();
        let from = From { x: &self.x, v: &self.v, dt, areas: &areas, held: &held, targets };
        let (next, residual) = strong.step(&from, &loads).map_err(|e| StepFailure::Equations(e.to_string()))?;
        let increment = next.iter().zip(&self.x).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        if !(increment <= self.settings.diameter) {
            return Err(StepFailure::Equations(format!("the scheme has blown up: a node would move by {increment:.2e} m")));
        }
        self.x = next;
        Ok(Solved { iterations: 1, increment, residual, negative_pivots: 0, stability: None })
    }

    fn set_counters(&mut self, counters: Counters) {
        match (&mut self.newton, &mut self.parts.strong) {
            (Some(newton), _) => newton.set_counters(counters),
            (None, Some(strong)) => strong.factorizations = counters.factorizations,
            (None, None) => {}
        }
    }

    /// Linear momentum [kg m/s], in motion.
    pub fn momentum(&self) -> Option<Vector3<f64>> {
        self.parts.inertia.as_ref().map(|inertia| inertia.momentum(&self.v))
    }

    /// Coordinates of all nodes [m].
    pub fn unknowns(&self) -> &[f64] {
        &self.x
    }
}

impl Model for GridModel {
    fn advance(&mut self, dt: f64, time: f64) -> Result<StepReport, StepFailure> {
        let before = (self.x.clone(), self.v.clone(), self.stuck.clone());
        self.try_advance(dt, time).inspect_err(|_| (self.x, self.v, self.stuck) = before)
    }

    fn step(&self) -> u64 {
        self.step
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn free_unknowns(&self) -> usize {
        match &self.newton {
            Some(newton) => newton.free(),
            None => held(&self.parts.held, &self.stuck, self.x.len()).iter().filter(|held| !**held).count(),
        }
    }

    fn counters(&self) -> Counters {
        let strong = |strong: &Strong| Counters { factorizations: strong.factorizations, ..Counters::default() };
        self.newton.as_ref().map(Newton::counters).or(self.parts.strong.as_ref().map(strong)).unwrap_or_default()
    }

    fn energies(&self) -> Vec<(&'static str, f64)> {
        let mut energies = Vec::new();
        if let Some(inertia) = &self.parts.inertia {
            energies.push(("kinetic_energy_J", inertia.kinetic_energy(&self.v)));
        }
        let [membrane, bending, coupling] = self.parts.surface.energies(&self.x);
        energies.extend([("membrane_energy_J", membrane), ("bending_energy_J", bending)]);
        energies.extend(self.parts.surface.is_coupled().then_some(("coupling_energy_J", coupling)));
        add_energies(&self.parts.loads, &self.x, &mut energies);
        energies
    }

    fn quantities(&self) -> Vec<(&'static str, f64)> {
        let mut quantities = vec![("area_m2", area(&self.quadrangles, &self.x))];
        if !self.stuck.is_empty() {
            quantities.push(("stuck_nodes", self.stuck.iter().filter(|stuck| **stuck).count() as f64));
        }
        quantities.extend(self.parts.strong.iter().flat_map(|strong| LU.into_iter().zip(strong.lu.map(|n| n as f64))));
        quantities
    }

    fn check_prescribed(&self, time: f64) -> Result<(), StepFailure> {
        self.prescribed(time).map(drop)
    }

    fn snapshot(&self) -> Snapshot {
        let mut fields = vec![field("position", Association::Node, 3, "m", self.x.clone())];
        if !self.v.is_empty() {
            fields.push(field("velocity", Association::Node, 3, "m/s", self.v.clone()));
        }
        if !self.stuck.is_empty() {
            fields.push(field("stuck", Association::Node, 1, "1", self.stuck.iter().map(|stuck| f64::from(u8::from(*stuck))).collect()));
        }
        let lu = self.parts.strong.iter().flat_map(|strong| LU.into_iter().zip(strong.lu));
        let numbers = numbers(&self.counters()).into_iter().chain(lu.map(|(name, value)| (name.to_owned(), value as f64))).collect();
        Snapshot { step: self.step, time: self.time, dt: 0.0, fields, numbers }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        let take = |name: &str, length: usize| take_field(snapshot, name, length);
        let x = take("position", self.x.len())?;
        let v = if self.v.is_empty() { Vec::new() } else { take("velocity", self.v.len())? };
        let stuck = if self.stuck.is_empty() { Vec::new() } else { take("stuck", self.stuck.len())? };
        (self.x, self.v) = (x, v);
        self.stuck = stuck.iter().map(|s| *s != 0.0).collect();
        self.set_counters(counters(snapshot));
        if let Some(strong) = &mut self.parts.strong {
            strong.lu = LU.map(|name| snapshot.number(name).unwrap_or(0.0) as u64);
        }
        (self.step, self.time) = (snapshot.step, snapshot.time);
        set_loads(&mut self.parts.loads, snapshot.time);
        self.parts.loads.iter_mut().for_each(|load| load.potential.start_step([&self.x, &self.x], snapshot.time, 1.0));
        if self.stuck.is_empty() { Ok(()) } else { self.renumber().map_err(|e| e.to_string()) }
    }
}

/// Corners around of every cell.
pub fn quadrangles(grid: &Grid) -> Vec<[usize; 4]> {
    let around = |cell| {
        let [a, b, c, d] = grid.corners(cell);
        [a, b, d, c]
    };
    grid.cells().map(around).collect()
}

/// Columns of the history and numbers of checkpoints: matrices that needed LU because they were unsymmetric, or indefinite; totals since the start.
const LU: [&str; 2] = ["unsymmetric_matrices", "indefinite_matrices"];

/// What finds minima; none for the paper's scheme, whose loads find their places here.
fn solver(parts: &mut GridParts, held: &[bool], settings: Settings) -> Result<Option<Newton>> {
    let Some(strong) = &mut parts.strong else { return Newton::new(&mut potentials(parts), held, settings).map(Some) };
    let mut loads: Vec<&mut dyn Potential> = parts.loads.iter_mut().map(|load| &mut *load.potential as &mut dyn Potential).collect();
    strong.bind(&mut loads)?;
    Ok(None)
}

/// Area of each node [m2]: quarters of its cells.
pub fn node_shares(quadrangles: &[[usize; 4]], x: &[f64]) -> Vec<f64> {
    let mut shares = vec![0.0; x.len() / 3];
    for cell in quadrangles {
        let quarter = 0.25 * cell_area(cell, x).norm();
        cell.iter().for_each(|n| shares[*n] += quarter);
    }
    shares
}

/// Area [m2] of the surface: the lengths of the area vectors of its cells.
fn area(quadrangles: &[[usize; 4]], x: &[f64]) -> f64 {
    quadrangles.iter().map(|q| cell_area(q, x).norm()).sum()
}

/// Which unknowns are held by supports or the table.
fn held(supports: &[HeldUnknown], stuck: &[bool], unknowns: usize) -> Vec<bool> {
    let mut held: Vec<bool> = (0..unknowns).map(|u| stuck.get(u / 3).is_some_and(|s| *s)).collect();
    supports.iter().for_each(|h| held[h.unknown] = true);
    held
}

/// The potentials of a model, in the order in which they are added.
fn potentials(parts: &mut GridParts) -> Vec<&mut dyn Potential> {
    let mut list: Vec<&mut dyn Potential> = vec![&mut parts.surface];
    list.extend(parts.inertia.as_mut().map(|p| &mut **p as &mut dyn Potential));
    list.extend(parts.drag.as_mut().map(|p| p as &mut dyn Potential));
    list.extend(parts.loads.iter_mut().map(|load| &mut *load.potential as &mut dyn Potential));
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_stick_where_they_come_down_on_the_table() {
        let table = RoundTable { centre: Vector3::new(1.0, 0.0, 2.0), radius: 0.5 };
        let p = |x: f64, z: f64| Vector3::new(x, 0.1, z);
        assert_eq!(table.touch(&p(1.0, 3.0), &p(1.4, 1.0)), Some(p(1.2, 2.0)));
        assert_eq!(table.touch(&p(1.0, 2.0), &p(1.0, 2.0)), Some(p(1.0, 2.0)));
        let [rim, out] = [1e-14, 1e-6].map(|e| Vector3::new(1.0 + 0.5 * (1.0 + e), 0.0, 2.0));
        assert!(rim.x > 1.5 && table.touch(&rim, &rim).is_some() && table.touch(&out, &out).is_none());
        for (before, after) in [((1.0, 3.0), (1.0, 2.5)), ((1.0, 1.0), (1.0, 3.0)), ((1.6, 3.0), (1.6, 1.0)), ((1.0, 1.5), (1.0, 1.0))] {
            assert_eq!(table.touch(&p(before.0, before.1), &p(after.0, after.1)), None);
        }
    }
}

//! A Koiter shell with its loads, supports and rest driver, in statics or in motion (Chen et al. 2018).

use super::Model;
use super::prescribed::{AppliedLoad, HeldUnknown, add_energies, check_loads, coordinate, set_loads};
use super::reactions::{REACTION_TIME, Reactions};
use super::rest_driver::RestDriver;
use super::state::{counters, field, numbers, take_field};
use super::step::{StepFailure, StepReport};
use super::time_integration::{Integrator, TimeIntegration};
use super::transport::{FollowingMass, Transport};
use crate::error::{Error, Result};
use crate::shell::rest::Forms;
use crate::shell::{Inertial, Shell};
use crate::snapshot::{Association, Snapshot};
use crate::solve::{Advance, Counters, Failure, Newton, Reach, Relaxation, Settings, Solved};
use crate::sparse::Potential;
use nalgebra::Vector3;

/// What a model is made of. What is absent has no object and costs nothing.
pub struct Parts {
    /// The shell.
    pub shell: Box<dyn Shell>,
    /// Inertia; absent in statics.
    pub inertia: Option<Box<dyn Inertial>>,
    /// Loads, none for a free shell.
    pub loads: Vec<AppliedLoad>,
    /// Growth; absent when the rest shape is the initial one.
    pub rest: Option<RestDriver>,
    /// What diffuses; none for most shells.
    pub transports: Vec<Transport>,
    /// Mass that follows what diffuses; absent where it stays.
    pub following_mass: Option<FollowingMass>,
    /// Forms of the initial shape, per integration point.
    pub initial_forms: Vec<Forms>,
    /// Supports.
    pub held: Vec<HeldUnknown>,
    /// Initial positions [m].
    pub positions: Vec<Vector3<f64>>,
    /// Initial velocities [m/s]; empty in statics.
    pub velocities: Vec<Vector3<f64>>,
}

/// A shell advanced step by step.
pub struct ShellModel {
    pub(super) parts: Parts,
    pub(super) newton: Newton,
    pub(super) x: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// Absent in statics.
    pub(super) integration: Option<TimeIntegration>,
    /// Largest error [m] that a step may add, where steps are chosen by it.
    pub(super) error_tolerance: Option<f64>,
    /// Where dynamic relaxation takes the place of Newton's method.
    relaxation: Option<Relaxation>,
    pub(super) step: u64,
    pub(super) time: f64,
    pub(super) rest_is_set: bool,
    /// Movement of the last step along a path, over all unknowns; none off paths and before the first step.
    pub(super) heading: Option<Vec<f64>>,
    /// Whether checkpoints keep the lowest mode.
    keeps_mode: bool,
    /// What the supports exert; absent where nobody asks.
    pub(super) reactions: Option<Reactions>,
}

impl Model for ShellModel {
    fn advance(&mut self, dt: f64, time: f64) -> Result<StepReport, StepFailure> {
        ShellModel::advance(self, dt, time)
    }

    fn step(&self) -> u64 {
        self.step
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn free_unknowns(&self) -> usize {
        self.newton.free()
    }

    fn counters(&self) -> Counters {
        self.newton.counters()
    }

    fn leaves_unstable(&self) -> bool {
        self.newton.leaves_unstable()
    }

    fn advance_along(&mut self, reach: Reach, end: f64) -> Result<(StepReport, Option<Advance>), StepFailure> {
        self.try_along(reach, end)
    }

    fn last_way(&self) -> f64 {
        self.heading.as_ref().map_or(0.0, |heading| self.newton.path_length(heading))
    }

    fn energies(&self) -> Vec<(&'static str, f64)> {
        ShellModel::energies(self)
    }

    fn chooses_steps(&self) -> bool {
        self.error_tolerance.is_some()
    }

    fn quantities(&self) -> Vec<(&'static str, f64)> {
        let diffusing = self.parts.transports.iter().flat_map(|t| Transport::columns(t.table).into_iter().zip(t.row()));
        let relaxed = self.relaxation.map(|_| ("relaxation_iterations", self.counters().relaxation_iterations as f64));
        diffusing.chain(relaxed).collect()
    }

    fn check_prescribed(&self, time: f64) -> Result<(), StepFailure> {
        self.prescribed(time).map(drop)
    }

    fn snapshot(&self) -> Snapshot {
        ShellModel::snapshot(self)
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        ShellModel::restore(self, snapshot)
    }
}

impl ShellModel {
    /// Numbers the unknowns, analyses the matrix and sets the rest forms of time 0. `tolerance`: relative to the diameter.
    pub fn new(mut parts: Parts, diameter: f64, tolerance: f64, max_iterations: usize) -> Result<Self> {
        let unknowns = parts.shell.unknowns();
        let mut held = vec![false; unknowns];
        parts.held.iter().for_each(|h| held[h.unknown] = true);
        let lengths = 3 * parts.positions.len();
        let mut x = vec![0.0; unknowns];
        for (to, from) in x.chunks_exact_mut(3).zip(&parts.positions) {
            to.copy_from_slice(from.as_slice());
        }
        let v: Vec<f64> = parts.velocities.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        parts.shell.set_rest(&parts.initial_forms);
        let settings = Settings { lengths, diameter, tolerance: tolerance * diameter, max_iterations };
        let mut newton = Newton::new(&mut potentials(&mut parts), &held, settings)?;
        newton.set_projects(parts.inertia.is_some());
        let integration = parts.inertia.is_some().then(|| TimeIntegration::new(Integrator::ImplicitEuler, false));
        let (step, time) = (0, 0.0);
        let mut model = ShellModel {
            parts,
            newton,
            x,
            v,
            integration,
            error_tolerance: None,
            relaxation: None,
            step,
            time,
            rest_is_set: false,
            heading: None,
            keeps_mode: false,
            reactions: None,
        };
        model.follow(0.0).map_err(|(place, reason)| Error::input(place, reason))?;
        model.parts.shell.restart(&model.x);
        Ok(model)
    }

    /// From now on steps leave unstable equilibria. `areas`: rest area of each node [m2]. `keep_mode`: whether checkpoints have the lowest mode.
    pub fn leave_unstable(&mut self, areas: &[f64], keep_mode: bool) {
        self.newton.set_stabilizer(areas);
        self.keeps_mode = keep_mode;
    }

    /// Integrates the motion from the start in another way than by implicit Euler. `tolerance`: largest error [m] that a step may add to a
    /// position, if steps are chosen by it.
    pub fn integrate_by(&mut self, integrator: Integrator, tolerance: Option<f64>) {
        self.integration = self.parts.inertia.is_some().then(|| TimeIntegration::new(integrator, tolerance.is_some()));
        self.error_tolerance = tolerance;
    }

    /// From now on steps find their equilibria by dynamic relaxation.
    pub fn relax_by(&mut self, relaxation: Relaxation) {
        self.relaxation = Some(relaxation);
    }

    /// Moves the first state by `displacements` of the nodes [m]; the rest shape stays. `directors`: those of the moved shape.
    pub fn disturb(&mut self, displacements: &[Vector3<f64>], directors: &[Vector3<f64>]) {
        for (x, d) in self.x.chunks_exact_mut(3).zip(displacements) {
            x.iter_mut().zip(d.iter()).for_each(|(x, d)| *x += d);
        }
        self.parts.shell.set_directors(directors);
        self.parts.shell.restart(&self.x);
    }

    /// All unknowns: node coordinates, then director angles.
    pub fn unknowns(&self) -> &[f64] {
        &self.x
    }

    pub(super) fn follow(&mut self, time: f64) -> Result<(), (String, String)> {
        follow(&mut self.parts, &mut self.rest_is_set, time)
    }

    pub(super) fn set_loads(&mut self, time: f64) {
        set_loads(&mut self.parts.loads, time);
    }

    /// Values that the moved unknowns take at a time, once it is sure that all that is prescribed then is finite.
    ///
    /// # Errors
    /// [`StepFailure::Input`] for a motion or a load's factor that is not finite.
    pub fn prescribed(&self, time: f64) -> Result<Vec<(usize, f64)>, StepFailure> {
        check_loads(&self.parts.loads, time)?;
        let mut targets = Vec::with_capacity(self.parts.held.len());
        for held in &self.parts.held {
            if let Some((d, motion)) = held.displacement(time, |unknown| self.describe(unknown))? {
                // Angles count from the present references, which turn with them.
                let angle = held.unknown >= 3 * self.parts.positions.len();
                let value = if angle { d - motion(self.time) } else { held.start + d };
                targets.push((held.unknown, value));
            }
        }
        Ok(targets)
    }

    /// Advances to `time`, by a step of size `dt`. On failure the model is as it was.
    pub fn advance(&mut self, dt: f64, time: f64) -> Result<StepReport, StepFailure> {
        let (x, lagged, directors) = (self.x.clone(), self.parts.shell.lagged(), self.parts.shell.directors().to_vec());
        let diffused: Vec<_> = self.parts.transports.iter().map(Transport::state).collect();
        let outcome = self.try_advance(dt, time, &directors);
        if outcome.is_err() {
            self.x = x;
            self.parts.shell.set_lagged(&lagged);
            self.parts.shell.set_directors(&directors);
            // What held at the present time when that was accepted cannot fail now.
            for (transport, state) in self.parts.transports.iter_mut().zip(diffused) {
                let _ = transport.set_state(state);
            }
            let _ = self.follow(self.time);
            self.set_loads(self.time);
        }
        outcome
    }

    fn try_advance(&mut self, dt: f64, time: f64, directors: &[Vector3<f64>]) -> Result<StepReport, StepFailure> {
        let targets = self.prescribed(time)?;
        let stage = self.stage(dt, time);
        let (share, moment) = stage.as_ref().map_or((1.0, time), |stage| (stage.share, stage.time));
        for transport in &mut self.parts.transports {
            let before = if share < 1.0 { transport.diffusion.values().to_vec() } else { Vec::new() };
            transport
                .advance(self.time, time, &self.x)
                .map_err(|e| StepFailure::Input { place: transport.table.into(), reason: format!("{e} (at t = {time})") })?;
            if share < 1.0 {
                transport.show(&before, share);
            }
        }
        self.follow(moment).map_err(|(place, reason)| StepFailure::Input { place, reason })?;
        self.set_loads(moment);
        let before = self.x.clone();
        if let (Some(stage), Some(integration), Some(inertia)) = (&stage, &mut self.integration, &mut self.parts.inertia) {
            inertia.pull_to(stage.predicted.clone(), stage.length);
            if self.parts.shell.is_viscous() {
                let (start, interval) = integration.strain_start(stage.time, self.time, || self.parts.shell.forms(&before));
                self.parts.shell.set_strain_start(start, interval);
            }
            if !self.parts.loads.is_empty() {
                let (place, (origin, interval)) = (stage.guess(), integration.velocity(stage));
                self.parts.loads.iter_mut().for_each(|load| load.potential.start_step([&place, &origin], moment, interval));
            }
        }
        if let Some(stage) = &stage {
            self.move_as_a_whole(stage);
        }
        let at_stage: Vec<(usize, f64)> = match &stage {
            Some(stage) => targets.iter().map(|&(i, value)| (i, stage.between(before[i], value))).collect(),
            None => targets.clone(),
        };
        let solved = self.equilibrium(&at_stage).map_err(|failure| self.failed(failure))?;
        // Supports are asked while all parts are at the moment of the stage.
        self.update_reactions(moment);
        let error = match stage {
            Some(stage) => self.finish(stage, &targets, time, directors)?,
            None => None,
        };
        self.step += 1;
        self.time = time;
        Ok(StepReport { solved, error })
    }

    /// Finds what the supports exert on the state that is there, at `time` [s], where anybody asks.
    pub(super) fn update_reactions(&mut self, time: f64) {
        if let Some(reactions) = &mut self.reactions {
            reactions.update(&mut self.parts, &self.newton, &self.x, time);
        }
    }

    /// A failure of the solver in words.
    pub(super) fn failed(&self, failure: Failure) -> StepFailure {
        StepFailure::of(failure, self.step == 0 && self.v.is_empty(), |unknown| self.describe(unknown))
    }

    /// Finds the equilibrium of the present stage from the present unknowns.
    fn equilibrium(&mut self, targets: &[(usize, f64)]) -> Result<Solved, Failure> {
        match self.relaxation {
            Some(relaxation) => self.newton.relax(&mut potentials(&mut self.parts), &mut self.x, targets, relaxation),
            None => self.newton.solve(&mut potentials(&mut self.parts), &mut self.x, targets),
        }
    }

    /// An unknown in words.
    fn describe(&self, unknown: usize) -> String {
        let lengths = 3 * self.parts.positions.len();
        if unknown < lengths { coordinate(&self.parts.positions, unknown) } else { format!("director angle {}", unknown - lengths) }
    }

    /// Energies [J] of the parts there are, by the names of the history's columns.
    pub fn energies(&self) -> Vec<(&'static str, f64)> {
        let [membrane, bending] = self.parts.shell.energies(&self.x);
        let mut energies = Vec::new();
        if let Some(inertia) = &self.parts.inertia {
            energies.push(("kinetic_energy_J", inertia.kinetic_energy(&self.v)));
        }
        energies.extend([("membrane_energy_J", membrane), ("bending_energy_J", bending)]);
        add_energies(&self.parts.loads, &self.x, &mut energies);
        energies
    }

    /// Linear momentum [kg m/s], in motion.
    pub fn momentum(&self) -> Option<Vector3<f64>> {
        self.parts.inertia.as_ref().map(|inertia| inertia.momentum(&self.v))
    }

    /// The state, with everything the next step reads.
    pub fn snapshot(&self) -> Snapshot {
        let lengths = 3 * self.parts.positions.len();
        let mut fields = vec![field("position", Association::Node, 3, "m", self.x[..lengths].to_vec())];
        if !self.v.is_empty() {
            fields.push(field("velocity", Association::Node, 3, "m/s", self.v.clone()));
        }
        let directors = self.parts.shell.directors();
        if !directors.is_empty() {
            fields.push(field("director", Association::Director, 3, "1", directors.iter().flat_map(|d| [d.x, d.y, d.z]).collect()));
        }
        fields.push(field("lagged_stress", Association::Point, 6, "J/m2, J/m", self.parts.shell.lagged()));
        if let Some(mode) = self.newton.lowest_mode().filter(|_| self.keeps_mode) {
            fields.push(field("lowest_mode", Association::Node, 3, "1", mode[..lengths].to_vec()));
        }
        fields.extend(self.reactions.iter().flat_map(|reactions| reactions.fields(lengths)));
        if let Some(heading) = &self.heading {
            fields.push(field("path_heading", Association::Node, 3, "m", heading[..lengths].to_vec()));
        }
        let counters = self.counters();
        let switches = self.leaves_unstable().then_some(("branch_switches", counters.branch_switches));
        let relaxed = self.relaxation.map(|_| ("relaxation_iterations", counters.relaxation_iterations));
        let numbers =
            numbers(&counters).into_iter().chain(switches.into_iter().chain(relaxed).map(|(name, value)| (name.into(), value as f64)));
        let numbers = numbers.collect();
        let mut snapshot = Snapshot { step: self.step, time: self.time, dt: 0.0, fields, numbers };
        let earlier = self.reactions.as_ref().map(|reactions| reactions.time).filter(|time| *time != self.time);
        snapshot.numbers.extend(earlier.map(|time| (REACTION_TIME.to_owned(), time)));
        self.parts.transports.iter().for_each(|transport| transport.put(&mut snapshot));
        if let Some(integration) = &self.integration {
            integration.put(&mut snapshot);
        }
        snapshot
    }

    /// Puts a state back. Errors: a field that is missing or of another size.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        let take = |name: &str, length: usize| take_field(snapshot, name, length);
        let lengths = 3 * self.parts.positions.len();
        let position = take("position", lengths)?;
        let velocity = if self.v.is_empty() { Vec::new() } else { take("velocity", lengths)? };
        let count = self.parts.shell.directors().len();
        if count > 0 {
            let directors: Vec<Vector3<f64>> =
                take("director", 3 * count)?.chunks_exact(3).map(|d| Vector3::new(d[0], d[1], d[2])).collect();
            self.parts.shell.set_directors(&directors);
        }
        let points = self.parts.shell.faces() * self.parts.shell.points();
        self.parts.shell.set_lagged(&take("lagged_stress", 6 * points)?);
        if let Some(reactions) = &mut self.reactions {
            reactions.take(snapshot)?;
        }
        self.x[..lengths].copy_from_slice(&position);
        self.x[lengths..].fill(0.0);
        self.v = velocity;
        // Angles have no part in the way of a path.
        self.heading = snapshot.field("path_heading").map(|_| take("path_heading", lengths)).transpose()?.map(|mut heading| {
            heading.resize(self.x.len(), 0.0);
            heading
        });
        self.step = snapshot.step;
        self.time = snapshot.time;
        self.newton.set_counters(counters(snapshot));
        self.parts.transports.iter_mut().try_for_each(|transport| transport.take(snapshot))?;
        if let Some(integration) = &mut self.integration {
            integration.take(snapshot, lengths, self.parts.shell.directors().len(), points)?;
        }
        self.follow(self.time).map_err(|(_, reason)| reason)?;
        self.set_loads(self.time);
        Ok(())
    }
}

/// Sets what follows time and what diffuses: stiffness, mass, and the rest forms if they change or were never set. Errors: the table that
/// asks for the impossible, and why.
pub(super) fn follow(parts: &mut Parts, rest_is_set: &mut bool, time: f64) -> Result<(), (String, String)> {
    let softened = parts.transports.iter().any(|transport| transport.stiffness.is_some());
    if softened {
        let factors = stiffness(&parts.transports).map_err(|(place, e)| (place, format!("{e} (at t = {time})")))?;
        parts.shell.set_stiffness(factors);
    }
    if let Some(following) = &parts.following_mass {
        let factors =
            following.factors(&parts.transports).map_err(|e| ("moisture.added_density".to_owned(), format!("{e} (at t = {time})")))?;
        if let Some(inertia) = &mut parts.inertia {
            inertia.set_factors(&factors);
        }
        let masses = following.node_masses(&factors);
        parts.loads.iter_mut().for_each(|load| load.potential.set_masses(&masses));
    }
    match &mut parts.rest {
        Some(driver) if softened || driver.changes() || !*rest_is_set => {
            parts.shell.set_rest(&driver.forms(time).map_err(|e| (place_of_law(e.law), e.reason))?);
            *rest_is_set = true;
        }
        None if softened => parts.shell.set_rest(&parts.initial_forms),
        _ => {}
    }
    Ok(())
}

/// Key of a growth law in a scene, by its name; that of all of them without one.
pub fn place_of_law(law: &str) -> String {
    if law.is_empty() { "rest".to_owned() } else { format!("rest.{law}") }
}

/// Factors on the stiffness of the faces by what diffuses. Errors: the table, and the face where a factor is not positive.
fn stiffness(transports: &[Transport]) -> Result<Vec<f64>, (String, String)> {
    let mut factors = Vec::new();
    for transport in transports {
        let Some(factor) = &transport.stiffness else { continue };
        let means = transport.profile.face_means();
        factors.resize(means.len(), 1.0);
        for (face, (product, u)) in factors.iter_mut().zip(means).enumerate() {
            let f = factor(u);
            if !(f.is_finite() && f > 0.0) {
                let (name, unit) = (transport.name, transport.unit);
                return Err((
                    transport.table.to_owned(),
                    format!("face {face}: the factor on the stiffness is {f} at a {name} of {u} {unit}"),
                ));
            }
            *product *= f;
        }
    }
    Ok(factors)
}

/// The potentials of a model, in the order in which they are added.
pub(super) fn potentials(parts: &mut Parts) -> Vec<&mut dyn Potential> {
    let mut list: Vec<&mut dyn Potential> = vec![&mut *parts.shell];
    list.extend(parts.inertia.as_mut().map(|p| &mut **p as &mut dyn Potential));
    list.extend(parts.loads.iter_mut().map(|load| &mut *load.potential as &mut dyn Potential));
    list
}

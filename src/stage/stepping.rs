//! How a run goes from step to step: through time or load factors, or along a path of equilibria.

use super::{Job, build, mesh as mesh_stage, report};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::model::{Model, StepFailure, StepReport};
use crate::scene::{Integrator, Scene};
use crate::snapshot::Snapshot;
use crate::solve::{Adaptive, ArcControl, ErrorControl, Reach, StepControl, StepPlan};

/// Chooses steps and takes them.
pub struct Stepping {
    /// Steps of time or of the load factor.
    pub control: StepControl,
    /// Whether the states of all steps are kept, not only those at output times.
    keeps_all: bool,
    path: Option<Path>,
}

/// A path of equilibria.
struct Path {
    control: ArcControl,
    most_steps: u64,
    until: Option<Until>,
    /// Sum of the lengths of all steps [m].
    way: f64,
}

/// A displacement at which a path ends.
struct Until {
    vertex: usize,
    axis: usize,
    /// Coordinate at the start [m].
    start: f64,
    /// Displacement [m].
    displacement: f64,
}

/// A step to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plan {
    /// Of given size.
    Ahead(StepPlan),
    /// Along a path.
    Along(Reach),
}

impl std::fmt::Display for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Plan::Ahead(plan) => write!(f, "by {:.3e}", plan.dt),
            Plan::Along(Reach::Factor(dt)) => write!(f, "by {dt:.3e}"),
            Plan::Along(Reach::Length(length)) => write!(f, "by a length of {length:.3e} m"),
        }
    }
}

impl Stepping {
    /// That of a scene, at its start.
    ///
    /// # Errors
    /// No vertex where the path is to end.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self> {
        let path = match scene.statics.as_ref().and_then(|s| Some((s, s.arc_length.as_ref()?))) {
            None => None,
            Some((statics, table)) => {
                let until = table.until.as_ref().map(|until| {
                    let vertex = report::vertex_at(mesh, "statics.arc-length.until", &until.at, until.region.as_deref())?;
                    let axis = build::axis_index(until.axis);
                    Ok(Until { vertex, axis, start: mesh.vertices[vertex][axis], displacement: until.displacement })
                });
                let halvings = scene.solver.max_halvings as u32;
                let control = ArcControl::new(scene.end() / statics.steps.max(1) as f64, table.iterations as f64, table.longest, halvings);
                Some(Path { control, most_steps: table.most_steps as u64, until: until.transpose()?, way: 0.0 })
            }
        };
        Ok(Stepping { control: control(scene), keeps_all: scene.output.interval.is_none(), path })
    }

    /// The same for a case whose mesh is made already.
    ///
    /// # Errors
    /// Those of [`Stepping::new`], and a mesh that cannot be read where the path ends by a displacement.
    pub fn of_case(job: &Job) -> Result<Self> {
        let until = job.scene.statics.as_ref().is_some_and(|s| s.arc_length.as_ref().is_some_and(|path| path.until.is_some()));
        let mesh = if until { mesh_stage::load(job)? } else { Mesh::default() };
        Stepping::new(&job.scene, &mesh)
    }

    /// The step after a state: its number, time and coordinates; none at the end.
    pub fn plan(&self, step: u64, time: f64, coordinate: impl Fn(usize) -> f64) -> Option<Plan> {
        let Some(path) = &self.path else { return self.control.plan(time).map(Plan::Ahead) };
        let reached = path.until.as_ref().is_some_and(|until| {
            let share = (coordinate(3 * until.vertex + until.axis) - until.start) / until.displacement;
            share >= 1.0
        });
        let ended = time >= self.control.end || step >= path.most_steps || reached;
        (!ended).then(|| Plan::Along(path.control.reach()))
    }

    /// The step after the model's state.
    pub fn plan_for(&self, model: &dyn Model) -> Option<Plan> {
        match self.path.as_ref().and_then(|path| path.until.as_ref()) {
            Some(_) => self.plan_after(&model.snapshot()),
            None => self.plan(model.step(), model.time(), |_| f64::NAN),
        }
    }

    /// The step after a checkpoint.
    pub fn plan_after(&self, snapshot: &Snapshot) -> Option<Plan> {
        let position = snapshot.field("position");
        self.plan(snapshot.step, snapshot.time, |unknown| position.and_then(|p| p.data.get(unknown)).copied().unwrap_or(f64::NAN))
    }

    /// Takes a step; on failure the model is as it was. Returns the report, the size of the step, and whether its state is to be kept.
    pub fn advance(&mut self, model: &mut dyn Model, plan: &Plan) -> Result<(StepReport, f64, bool), StepFailure> {
        let from = model.time();
        match (plan, &mut self.path) {
            (Plan::Along(reach), Some(path)) => {
                let (report, along) = model.advance_along(*reach, self.control.end)?;
                path.way += model.last_way();
                if let Some(along) = along {
                    path.control.succeed(report.solved.iterations, along.length);
                }
                Ok((report, model.time() - from, true))
            }
            (Plan::Ahead(plan), _) => {
                let report = model.advance(plan.dt, plan.time)?;
                self.control.succeed(plan.dt, report.solved.iterations, report.error);
                Ok((report, plan.dt, plan.lands || self.keeps_all))
            }
            (Plan::Along(_), None) => Err(StepFailure::Equations("there is no path".into())),
        }
    }

    /// After a step that failed: a smaller one. False when that is too small, and when too many have failed.
    pub fn fail(&mut self, plan: &Plan, from: f64) -> bool {
        match (plan, &mut self.path) {
            (Plan::Ahead(plan), _) => self.control.fail(plan.dt, from) && from + self.control.dt > from,
            (Plan::Along(_), path) => path.as_mut().is_some_and(|path| path.control.fail()),
        }
    }

    /// After a step with `error` times the error that is allowed: a smaller one. False when that is too small.
    pub fn reject(&mut self, plan: &Plan, error: f64, from: f64) -> bool {
        let Plan::Ahead(plan) = plan else { return false };
        self.control.reject(plan.dt, error) && from + self.control.dt > from
    }

    /// Why a run ends after a step from `time` that failed, in words.
    pub fn end(&self, time: f64) -> String {
        let (failures, most) = (self.control.failures, self.control.most_failures(time));
        if self.path.is_none() && most == 0.0 {
            "failed, and no step may be halved".into()
        } else if self.path.is_none() && f64::from(failures) > most {
            format!("failed, and with it {failures} steps so far, where a run that has come so far may have {most}")
        } else {
            "failed at its smallest size".into()
        }
    }

    /// The next step in words, after one that failed.
    pub fn next(&self) -> String {
        match self.path.as_ref().map(|path| path.control.reach()) {
            None => format!("{:.3e}", self.control.dt),
            Some(Reach::Factor(dt)) => format!("{dt:.3e}"),
            Some(Reach::Length(length)) => format!("a length of {length:.3e} m"),
        }
    }

    /// Names of the history's columns that this adds.
    pub fn columns(scene: &Scene) -> &'static [&'static str] {
        if scene.statics.as_ref().is_some_and(|s| s.arc_length.is_some()) { &["arc_length_m"] } else { &[] }
    }

    /// Their values.
    pub fn row(&self) -> Option<f64> {
        self.path.as_ref().map(|path| path.way)
    }

    /// Puts what the next step reads into a checkpoint.
    pub fn put(&self, snapshot: &mut Snapshot) {
        snapshot.dt = self.control.dt;
        let mut put = |name: &str, value: f64| snapshot.numbers.push((name.into(), value));
        let Some(path) = &self.path else {
            put("successes", f64::from(self.control.successes));
            if self.control.failures > 0 {
                put("failures", f64::from(self.control.failures));
            }
            if let Some(by_error) = self.control.by_error {
                put("local_error", by_error.error);
            }
            return;
        };
        put("arc_length", path.way);
        put("arc_share", path.control.share);
        if let Some(unit) = path.control.unit {
            put("arc_unit", unit);
        }
    }

    /// Takes it back.
    pub fn take(&mut self, snapshot: &Snapshot) {
        self.control.dt = snapshot.dt;
        self.control.successes = snapshot.number("successes").unwrap_or(0.0) as u32;
        self.control.failures = snapshot.number("failures").unwrap_or(0.0) as u32;
        if let (Some(by_error), Some(error)) = (&mut self.control.by_error, snapshot.number("local_error")) {
            by_error.error = error;
        }
        let Some(path) = &mut self.path else { return };
        path.way = snapshot.number("arc_length").unwrap_or(0.0);
        path.control.share = snapshot.number("arc_share").unwrap_or(1.0);
        path.control.unit = snapshot.number("arc_unit");
    }
}

/// Steps of the scene: of load factors or seconds. Load steps end where they would if none of them had been halved.
fn control(scene: &Scene) -> StepControl {
    let nominal = match (&scene.statics, &scene.dynamics) {
        (Some(statics), _) => scene.end() / statics.steps.max(1) as f64,
        (None, Some(dynamics)) => dynamics.dt,
        (None, None) => 1.0,
    };
    let even = scene.statics.as_ref().is_some_and(|statics| statics.adaptive.is_none());
    let interval = scene.output.interval.or(even.then_some(nominal));
    let mut control = StepControl::new(nominal, scene.end(), interval, scene.solver.max_halvings as u32);
    control.adaptive = scene.statics.as_ref().and_then(|s| s.adaptive.as_ref()).map(|table| Adaptive {
        iterations: table.iterations as f64,
        shortest: table.shortest,
        longest: table.longest.unwrap_or(scene.end()),
    });
    if let Some(dynamics) = &scene.dynamics {
        let first_order = dynamics.integrator == Integrator::ImplicitEuler;
        control.is_even = !first_order || dynamics.adaptive.is_some();
        control.by_error = dynamics.adaptive.as_ref().map(|table| ErrorControl {
            power: if first_order { 2.0 } else { 3.0 },
            largest: table.largest_dt.unwrap_or(f64::INFINITY),
            error: 1.0,
        });
    }
    control
}

//! `run`: simulates from the newest valid checkpoint on (`run/step_NNNNNNNN.h5`, `history.csv`).

use super::{Job, build, mesh as mesh_stage, setup};
use crate::case::{Folder, History, Newest, hash};
use crate::error::{Error, Result};
use crate::mesh::Topology;
use crate::model::{Model, StepFailure};
use crate::scene::Scene;
use crate::snapshot::Snapshot;
use crate::solve::StepControl;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// How far, and from where.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Options {
    /// Discard all checkpoints and start from the setup.
    #[arg(long)]
    pub restart: bool,
    /// Stop after this many further steps, with a checkpoint.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub stop_after: Option<u64>,
}

/// Columns of the history between `step` and the energies. Counts are totals since the start.
const COLUMNS: [&str; 9] = [
    "time_s",
    "dt_s",
    "halvings",
    "newton_iterations",
    "fallback_iterations",
    "factorizations",
    "negative_pivots",
    "residual",
    "increment_m",
];

/// Columns after the energies where unstable equilibria are left. Switches are totals since the start; eigenvalues [N/m3] are those of the
/// equilibrium kept, and of the first one found in the step.
const STABILITY: [&str; 3] = ["branch_switches", "lowest_eigenvalue", "lowest_eigenvalue_before"];

/// The stage.
///
/// # Errors
/// Stale or damaged inputs, equations that cannot be solved ([`Error::Numerical`]), a signal ([`Error::Interrupted`]).
pub fn run(job: &Job, options: &Options) -> Result<()> {
    let mesh = mesh_stage::load(job)?;
    let (setup, first) = setup::load(job)?;
    let mut folder = Folder::new(&job.case, inputs(job)?);
    let _lock = folder.lock()?;
    let newest = if options.restart { None } else { resume(job, &folder)? };
    let signals = Signals::catch()?;
    job.record()?;

    let started = Instant::now();
    let topology = Topology::new(&mesh.faces);
    let mut model = build::model(&job.scene, &mesh, &topology, &setup)?;
    let mut control = step_control(&job.scene);
    let from = newest.as_ref().unwrap_or(&first);
    model.restore(from).map_err(|e| Error::Stale {
        path: folder.path(from.step),
        message: e,
        help: crate::case::Kind::Checkpoint.remedy().into(),
    })?;
    if newest.is_some() {
        control.dt = from.dt;
        control.successes = from.number("successes").unwrap_or(0.0) as u32;
    }
    // Time spent on files is left out: the history tells what the mechanics cost.
    let built = started.elapsed().as_secs_f64();
    let columns = columns(&*model);
    let path = history_path(job);
    let (mut history, worked) = match &newest {
        // A history of step 0 has no rows, and the one that is there may be of an earlier run that this one was to replace.
        Some(from) if from.step > 0 => {
            let history = History::open_at(&path, &columns, from.step)?;
            (history, History::read(&path)?.last("wall_s").unwrap_or(0.0))
        }
        _ => {
            folder.write(&checkpoint(&*model, &control), true)?;
            (History::create(&path, &columns)?, 0.0)
        }
    };
    let bar = progress_bar(job.quiet, control.end);
    let mut wall = worked + built;
    let first_step = model.step();
    let mut unstable = None;
    let (mut halvings, mut clock) = (0u32, Instant::now());
    while let Some(plan) = control.plan(model.time()) {
        if signals.number() != 0 || options.stop_after.is_some_and(|n| model.step() - first_step >= n) {
            break;
        }
        let from = model.time();
        match model.advance(plan.dt, plan.time) {
            Ok(report) => {
                control.succeed();
                wall += clock.elapsed().as_secs_f64();
                let counters = model.counters();
                let solved = report.solved;
                let lowest = solved.stability.map(|s| s.lowest);
                unstable = job
                    .scene
                    .statics
                    .as_ref()
                    .filter(|_| solved.negative_pivots > 0)
                    .map(|_| self::unstable(solved.negative_pivots, lowest));
                let energies = model.energies();
                let mut row = vec![plan.time, plan.dt, f64::from(halvings)];
                row.extend([counters.newton_iterations, counters.fallback_iterations, counters.factorizations].map(|n| n as f64));
                row.extend([solved.negative_pivots as f64, solved.residual, solved.increment]);
                row.extend(energies.iter().map(|(_, e)| *e));
                row.extend(model.quantities().iter().map(|(_, value)| *value));
                if let Some(stability) = solved.stability {
                    row.extend([counters.branch_switches as f64, stability.lowest, stability.before]);
                    if stability.switches > 0 {
                        job.say(&switched(&job.moment(plan.time), stability.before, stability.lowest));
                    }
                }
                row.push(wall);
                history.append(model.step(), &row)?;
                history.sync()?;
                folder.write(&checkpoint(&*model, &control), plan.lands || job.scene.output.interval.is_none())?;
                let energy: f64 = energies.iter().map(|(_, e)| e).sum();
                let moment = job.moment((1e9 * plan.time).round() / 1e9);
                log::debug!("step {}: {moment}, dt {:.3e}, {} iterations, energy {energy:.6e} J", model.step(), plan.dt, solved.iterations);
                bar.set_position(bar_position(model.time(), control.end));
                bar.set_message(format!("{moment}  dt {:.1e}  {} it  {energy:.3e} J", plan.dt, solved.iterations));
                halvings = 0;
                clock = Instant::now();
            }
            Err(StepFailure::Equations(reason)) if control.fail(plan.dt) && from + control.dt > from => {
                halvings += 1;
                log::warn!("the step from {} by {:.3e} failed: {reason}; trying {:.3e}", job.moment(from), plan.dt, control.dt);
            }
            Err(failure) => {
                bar.abandon();
                return Err(give_up(failure, &job.moment(from), &folder, model.step()));
            }
        }
    }
    bar.finish_and_clear();
    match signals.number() {
        0 => {}
        number => {
            job.say(&place("stopped at", job, &*model, &folder));
            return Err(Error::Interrupted(number));
        }
    }
    if let Some(unstable) = unstable.filter(|_| control.plan(model.time()).is_none()) {
        log::warn!("{unstable}");
    }
    let counters = model.counters();
    job.say(&place("at", job, &*model, &folder));
    job.say(&format!(
        "{} Newton iterations, {} of descent, {} factorisations, {wall:.3} s",
        counters.newton_iterations, counters.fallback_iterations, counters.factorizations
    ));
    Ok(())
}

/// Columns of the history after `step`.
pub fn columns(model: &dyn Model) -> Vec<&'static str> {
    let energies = model.energies().into_iter().map(|(name, _)| name);
    let stability = if model.leaves_unstable() { &STABILITY[..] } else { &[] };
    let quantities = model.quantities().into_iter().map(|(name, _)| name);
    COLUMNS.into_iter().chain(energies).chain(quantities).chain(stability.iter().copied()).chain(["wall_s"]).collect()
}

/// What is said of a step that left an unstable equilibrium. `moment`: its time in words; `before`, `after`: lowest eigenvalues [N/m3].
pub fn switched(moment: &str, before: f64, after: f64) -> String {
    format!("branch switched at {moment}: lowest eigenvalue {before:.4e} N/m3 before, {after:.4e} N/m3 after")
}

/// What is said of a last equilibrium with negative pivots. `lowest`: its lowest eigenvalue [N/m3], where unstable ones are left: then the
/// energy does not fall by more than round-off along the mode.
pub fn unstable(negative_pivots: usize, lowest: Option<f64>) -> String {
    let directions = if negative_pivots == 1 { "1 direction".into() } else { format!("{negative_pivots} directions") };
    match lowest {
        None => format!("the last equilibrium is unstable in {directions}; a small disturbance would make the shell leave it"),
        Some(lowest) => format!(
            "the last equilibrium is neutral within round-off in {directions}: lowest eigenvalue {lowest:.4e} N/m3, along whose mode the energy \
             does not fall"
        ),
    }
}

/// Path of the history.
pub fn history_path(job: &Job) -> PathBuf {
    job.case.join("history.csv")
}

/// Hash of what checkpoints are made from: the setup and the tables that say how to step. The end of motion and the output times may change; in statics the end says how long a step is.
pub fn inputs(job: &Job) -> Result<String> {
    let s = &job.scene;
    let tables = serde_json::to_string(&(&s.statics, s.dynamics.as_ref().map(|d| d.dt), &s.solver, s.output.lowest_mode))
        .map_err(|e| Error::input("scene", e.to_string()))?;
    Ok(hash::of(&[setup::inputs(job)?.as_bytes(), tables.as_bytes()]))
}

/// How far a case has come: its newest valid checkpoint, and warnings about newer ones that are not.
///
/// # Errors
/// [`Error::Stale`] for checkpoints of other inputs, for such as lie past the end that the scene has now, and for a history that does not
/// reach as far as they do.
pub fn progress(job: &Job) -> Result<Newest> {
    let folder = Folder::new(&job.case, inputs(job)?);
    let newest = folder.newest_valid()?;
    let end = step_control(&job.scene).end;
    let Some(s) = &newest.snapshot else { return Ok(newest) };
    if s.time > end {
        return Err(Error::Stale {
            path: folder.path(s.step),
            message: format!("is at t = {} s, past the end of the run at {end} s", s.time),
            help: "discard it: thinshell run SCENE --restart, or put back a later end".into(),
        });
    }
    if s.step > 0 {
        // What a run cost is told by its history alone.
        History::read_through(&history_path(job), s.step)?;
    }
    Ok(newest)
}

/// Whether the newest checkpoint is at the end of the run. Errors: those of [`progress`].
pub fn is_done(job: &Job) -> Result<bool> {
    let control = step_control(&job.scene);
    Ok(progress(job)?.snapshot.is_some_and(|s| control.plan(s.time).is_none()))
}

fn resume(job: &Job, folder: &Folder) -> Result<Option<Snapshot>> {
    let newest = progress(job)?;
    newest.warnings.iter().for_each(|w| log::warn!("{w}"));
    match &newest.snapshot {
        Some(s) => job.say(&format!("going on from {} ({})", folder.path(s.step).display(), job.moment(s.time))),
        None if newest.warnings.is_empty() => {}
        None => job.say("no checkpoint is whole; starting from the setup"),
    }
    Ok(newest.snapshot)
}

/// Steps of the scene: of load factors or seconds. Load steps end where they would if none of them had been halved.
fn step_control(scene: &Scene) -> StepControl {
    let nominal = match (&scene.statics, &scene.dynamics) {
        (Some(statics), _) => scene.end() / statics.steps as f64,
        (None, Some(dynamics)) => dynamics.dt,
        (None, None) => 1.0,
    };
    let interval = scene.output.interval.or(scene.statics.is_some().then_some(nominal));
    StepControl::new(nominal, scene.end(), interval, scene.solver.max_halvings as u32)
}

/// The model's state and that of the step control.
fn checkpoint(model: &dyn Model, control: &StepControl) -> Snapshot {
    let mut snapshot = model.snapshot();
    snapshot.dt = control.dt;
    snapshot.numbers.push(("successes".into(), f64::from(control.successes)));
    snapshot
}

/// SIGINT and SIGTERM while this lives: the first is remembered, a second ends the program at once, as the first does afterwards.
struct Signals {
    caught: Arc<AtomicUsize>,
    at_once: Arc<AtomicBool>,
}

impl Signals {
    fn catch() -> Result<Self> {
        use signal_hook::consts::{SIGINT, SIGTERM};
        // Hooked once: a ladder has many runs.
        static HOOKED: OnceLock<(Arc<AtomicUsize>, Arc<AtomicBool>)> = OnceLock::new();
        let is_new = HOOKED.get().is_none();
        let (caught, at_once) = HOOKED.get_or_init(Default::default).clone();
        at_once.store(false, Ordering::Relaxed);
        for signal in if is_new { &[SIGINT, SIGTERM][..] } else { &[] } {
            let hooked = signal_hook::flag::register_conditional_shutdown(*signal, 128 + signal, Arc::clone(&at_once))
                .and_then(|_| signal_hook::flag::register(*signal, Arc::clone(&at_once)))
                .and_then(|_| signal_hook::flag::register_usize(*signal, Arc::clone(&caught), *signal as usize));
            hooked.map_err(|e| Error::io("catch signals for", std::path::Path::new("run"), e))?;
        }
        Ok(Signals { caught, at_once })
    }

    /// The number of the signal that came, or 0.
    fn number(&self) -> i32 {
        self.caught.load(Ordering::Relaxed) as i32
    }
}

impl Drop for Signals {
    fn drop(&mut self) {
        self.at_once.store(true, Ordering::Relaxed);
    }
}

/// Position of the progress bar.
fn bar_position(time: f64, end: f64) -> u64 {
    (1e6 * (time / end).clamp(0.0, 1.0)) as u64
}

/// A bar on standard error, if that is a terminal.
fn progress_bar(quiet: bool, end: f64) -> ProgressBar {
    if quiet || !(end > 0.0) {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(1_000_000);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}  {eta} left") {
        bar.set_style(style);
    }
    bar
}

fn place(verb: &str, job: &Job, model: &dyn Model, folder: &Folder) -> String {
    format!("{verb} {} after {} steps: {}", job.moment(model.time()), model.step(), folder.path(model.step()).display())
}

/// The error of a step that no halving mends.
fn give_up(failure: StepFailure, from: &str, folder: &Folder, step: u64) -> Error {
    let kept = format!("the last good state is in {}", folder.path(step).display());
    match failure {
        StepFailure::Equations(reason) => Error::Numerical {
            message: format!("the step from {from} failed at its smallest size: {reason}"),
            help: Some(format!("more load steps or a smaller dt, viscosity, or a look at the last state may help; {kept}")),
        },
        StepFailure::Mechanism(unknown) => Error::Numerical {
            message: format!("the structure is a mechanism: {unknown} moves without resistance"),
            help: Some("hold it by pins (six for a free body), use [dynamics], or, for a linear mesh one cell wide, two cells".into()),
        },
        StepFailure::Input { place, reason } => Error::Input { place, message: reason, help: Some(kept) },
    }
}

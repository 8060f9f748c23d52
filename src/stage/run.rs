//! `run`: simulates from the newest valid checkpoint on (`run/step_NNNNNNNN.h5`, `history.csv`).

use super::stepping::Stepping;
use super::{Job, build, mesh as mesh_stage, setup};
use crate::case::{Folder, History, Newest, hash};
use crate::error::{Error, Result};
use crate::mesh::Topology;
use crate::model::{Model, StepFailure};
use crate::scene::{AdaptiveDt, Scene};
use crate::snapshot::Snapshot;
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

/// Columns after those where steps are chosen by their errors: steps rejected since the last accepted one, and the estimated error of the
/// step, relative to the mesh diameter.
const ERRORS: [&str; 2] = ["rejections", "local_error"];

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
    let mut stepping = Stepping::new(&job.scene, &mesh)?;
    let end = job.scene.end();
    let from = newest.as_ref().unwrap_or(&first);
    model.restore(from).map_err(|e| Error::Stale {
        path: folder.path(from.step),
        message: e,
        help: crate::case::Kind::Checkpoint.remedy().into(),
    })?;
    if newest.is_some() {
        stepping.take(from);
    }
    // Time spent on files is left out: the history tells what the mechanics cost.
    let built = started.elapsed().as_secs_f64();
    let columns = columns(&job.scene, &*model);
    let path = history_path(job);
    let (mut history, worked) = match &newest {
        // A history of step 0 has no rows, and the one that is there may be of an earlier run that this one was to replace.
        Some(from) if from.step > 0 => {
            let history = History::open_at(&path, &columns, from.step)?;
            (history, History::read(&path)?.last("wall_s").unwrap_or(0.0))
        }
        _ => {
            folder.write(&checkpoint(&*model, &stepping), true)?;
            (History::create(&path, &columns)?, 0.0)
        }
    };
    let bar = progress_bar(job.quiet, end);
    let mut wall = worked + built;
    let first_step = model.step();
    let mut unstable = None;
    let (mut halvings, mut rejections, mut clock) = (0u32, 0u32, Instant::now());
    while let Some(plan) = stepping.plan_for(&*model) {
        if signals.number() != 0 || options.stop_after.is_some_and(|n| model.step() - first_step >= n) {
            break;
        }
        let from = model.time();
        match stepping.advance(&mut *model, &plan) {
            Ok((report, dt, keep)) => {
                let time = model.time();
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
                let mut row = vec![time, dt, f64::from(halvings)];
                row.extend([counters.newton_iterations, counters.fallback_iterations, counters.factorizations].map(|n| n as f64));
                row.extend([solved.negative_pivots as f64, solved.residual, solved.increment]);
                row.extend(energies.iter().map(|(_, e)| *e));
                row.extend(model.quantities().iter().map(|(_, value)| *value));
                if let Some(stability) = solved.stability {
                    row.extend([counters.branch_switches as f64, stability.lowest, stability.before]);
                    if stability.switches > 0 {
                        job.say(&switched(&job.moment(time), stability.before, stability.lowest));
                    }
                }
                if let Some((error, adaptive)) = report.error.zip(adaptive(&job.scene)) {
                    row.extend([f64::from(rejections), error * adaptive.tolerance]);
                }
                row.extend(stepping.row());
                row.push(wall);
                history.append(model.step(), &row)?;
                history.sync()?;
                folder.write(&checkpoint(&*model, &stepping), keep)?;
                let energy: f64 = energies.iter().map(|(_, e)| e).sum();
                let moment = job.moment((1e9 * time).round() / 1e9);
                log::debug!("step {}: {moment}, dt {:.3e}, {} iterations, energy {energy:.6e} J", model.step(), dt, solved.iterations);
                bar.set_position(bar_position(time, end));
                bar.set_message(format!("{moment}  dt {:.1e}  {} it  {energy:.3e} J", dt, solved.iterations));
                (halvings, rejections) = (0, 0);
                clock = Instant::now();
            }
            Err(StepFailure::Equations(reason)) if stepping.fail(&plan, from) => {
                halvings += 1;
                log::warn!("the step from {} {plan} failed: {reason}; trying {}", job.moment(from), stepping.next());
            }
            Err(StepFailure::Inaccurate(error)) if stepping.reject(&plan, error, from) => {
                rejections += 1;
                log::debug!("the step from {} {plan} has {error:.1e} of the error allowed", job.moment(from));
            }
            Err(failure) => {
                bar.abandon();
                return Err(give_up(failure, &job.moment(from), &stepping.end(from), &folder, model.step()));
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
    if let Some(unstable) = unstable.filter(|_| stepping.plan_for(&*model).is_none()) {
        log::warn!("{unstable}");
    }
    let counters = model.counters();
    job.say(&place("at", job, &*model, &folder));
    let relaxed = match counters.relaxation_iterations {
        0 => String::new(),
        n => format!("{n} iterations of dynamic relaxation, "),
    };
    job.say(&format!(
        "{relaxed}{} Newton iterations, {} of descent, {} factorisations, {wall:.3} s",
        counters.newton_iterations, counters.fallback_iterations, counters.factorizations
    ));
    Ok(())
}

/// Columns of the history after `step`.
pub fn columns(scene: &Scene, model: &dyn Model) -> Vec<&'static str> {
    let energies = model.energies().into_iter().map(|(name, _)| name);
    let stability = if model.leaves_unstable() { &STABILITY[..] } else { &[] };
    let quantities = model.quantities().into_iter().map(|(name, _)| name);
    let errors = if model.chooses_steps() { &ERRORS[..] } else { &[] };
    let after = stability.iter().chain(errors).chain(Stepping::columns(scene)).copied();
    COLUMNS.into_iter().chain(energies).chain(quantities).chain(after).chain(["wall_s"]).collect()
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

/// Hash of what checkpoints are made from: the setup and the tables that say how to step. The end of motion and of a path
/// and the output times may change; in statics the end says how long a step is.
pub fn inputs(job: &Job) -> Result<String> {
    let s = &job.scene;
    let mut statics = s.statics.clone();
    if let Some(path) = statics.as_mut().and_then(|table| table.arc_length.as_mut()) {
        (path.most_steps, path.until) = (0, None);
    }
    let tables = serde_json::to_string(&(
        &statics,
        s.dynamics.as_ref().map(|d| (d.dt, d.integrator, d.spectral_radius, &d.adaptive)),
        &s.solver,
        s.output.lowest_mode,
    ))
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
    let end = job.scene.end();
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
    let Some(snapshot) = progress(job)?.snapshot else { return Ok(false) };
    Ok(Stepping::of_case(job)?.plan_after(&snapshot).is_none())
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

/// The table that chooses steps by their errors.
fn adaptive(scene: &Scene) -> Option<&AdaptiveDt> {
    scene.dynamics.as_ref()?.adaptive.as_ref()
}

/// The model's state and that of the step control.
fn checkpoint(model: &dyn Model, stepping: &Stepping) -> Snapshot {
    let mut snapshot = model.snapshot();
    stepping.put(&mut snapshot);
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

/// The error of a step that no halving mends. `how`: why it is not halved once more.
fn give_up(failure: StepFailure, from: &str, how: &str, folder: &Folder, step: u64) -> Error {
    let kept = format!("the last good state is in {}", folder.path(step).display());
    match failure {
        StepFailure::Equations(reason) => Error::Numerical {
            message: format!("the step from {from} {how}: {reason}"),
            help: Some(format!(
                "more load steps (statics.steps) or a smaller step (dynamics.dt), viscosity, or a look at the last state may help; {kept}"
            )),
        },
        StepFailure::Inaccurate(error) => Error::Numerical {
            message: format!("the step from {from} has {error:.2e} times the error allowed at its smallest size"),
            help: Some(format!("a smaller dynamics.dt to start with, or a larger dynamics.adaptive.tolerance, may help; {kept}")),
        },
        StepFailure::Mechanism(unknown) => Error::Numerical {
            message: format!("the structure is a mechanism: {unknown} moves without resistance"),
            help: Some("hold it by pins (six for a free body); what hangs from a hinged edge turns about it freely before its weight stretches it: clamp it \
                 (director = \"clamped\"), use statics.method = \"dynamic-relaxation\" or [dynamics]; give a linear mesh one cell wide two cells; a ribbon \
                 thousands of times as long as wide or a shell thinner than a ten-millionth of its span is stiff by less than round-off: make it shorter or thicker"
                    .into()),
        },
        StepFailure::Input { place, reason } => Error::Input { place, message: reason, help: Some(kept) },
    }
}

//! `report --matrix`: runs scenes at the ends of what their keys may be and judges every run.
//!
//! A cell passes if it ends as its part says, in a solution that is one or in an error of the input or of the equations. It fails if the
//! program panics or does not end in time, and if a solution has fields that are not finite, more energy than it can have, or misses a limit.

use super::super::{Job, all, build};
use super::case::{Case, When};
use super::sweep::limit;
use crate::error::{Error, Result};
use crate::mesh::Topology;
use crate::model::ShellModel;
use crate::report::{MatrixCell, MatrixSolution, matrix as table, median};
use crate::scene::{self, Ends, Matrix, MatrixPart, PinDirector, Scene};
use crate::snapshot::Snapshot;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Energies below this share of the sum of E h A are round-off: strains of 1e-12.
const ROUND_OFF: f64 = 1e-24;

/// Largest part of its momentum that a free shell may win or lose by round-off.
const MOMENTUM: f64 = 1e-6;

/// Which cells of matrices are run.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// With --matrix: run only one cell of N, from the first of each part on.
    #[arg(long, value_name = "N", requires = "matrix", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub every: u64,
}

/// Runs each cell of the `[report.matrix]` of `scenes` in a folder of its own that does not stay, and makes one table of all
/// (`cases/matrix/matrix.json`, `matrix.md`, and `json`).
///
/// # Errors
/// A scene that is none or has no matrix; [`Error::Missed`] when a cell has a fault.
pub fn matrix(scenes: &[PathBuf], options: &Options, overrides: &[String], json: Option<&Path>, quiet: bool) -> Result<()> {
    let mut jobs = Vec::new();
    for path in scenes {
        let job = Job::read(path, None, overrides, true)?;
        let Some(table) = job.scene.report.as_ref().and_then(|r| r.matrix.clone()) else {
            return Err(Error::input("report.matrix", format!("{} has no such table", path.display())));
        };
        jobs.push((job, table));
    }
    // Steps that fail and are halved are what a matrix is made of.
    let level = log::max_level();
    let mut cells = Vec::new();
    for (job, table) in &jobs {
        for part in &table.parts {
            for (values, overrides) in part.cells().into_iter().step_by(options.every as usize) {
                let names = part.axes.iter().map(|axis| axis.key.clone());
                let values = names.zip(values.iter().map(super::sweep::json)).collect();
                if level < log::LevelFilter::Debug {
                    log::set_max_level(log::LevelFilter::Error);
                }
                let cell = run(job, table, part, values, overrides);
                log::set_max_level(level);
                let cell = cell?;
                if !quiet {
                    let how = if cell.exit == 0 { "converged" } else { "refused" };
                    log::info!(
                        "{}: {how} in {:.1} s{}",
                        table::title(&cell),
                        cell.wall_s,
                        cell.faults.iter().map(|f| format!("; {f}")).collect::<String>()
                    );
                }
                cells.push(cell);
            }
        }
    }
    let job = Job { case: PathBuf::from("cases/matrix"), ..jobs.swap_remove(0).0 };
    super::publish(&job, "matrix", &table::to_json(&cells), &table::to_markdown(&cells), json)?;
    let bad = cells.iter().filter(|cell| !cell.faults.is_empty()).count();
    if bad == 0 { Ok(()) } else { Err(Error::Missed(format!("cells of the matrix with faults: {bad} of {}", cells.len()))) }
}

/// What a run ended in.
enum End {
    Done(Box<MatrixSolution>, Vec<String>),
    Refused(Error),
}

/// One cell.
fn run(job: &Job, table: &Matrix, part: &MatrixPart, values: Vec<(String, Value)>, overrides: Vec<String>) -> Result<MatrixCell> {
    let clock = Instant::now();
    let folder = tempfile::tempdir().map_err(|e| Error::io("create a folder in", &std::env::temp_dir(), e))?;
    let (base, case) = (job.clone(), folder.path().to_path_buf());
    let (send, receive) = channel();
    // In a thread of its own, which is left behind should it not end.
    let thread = std::thread::spawn(move || {
        let _ = send.send(attempt(base, &overrides, case));
    });
    let mut cell = MatrixCell { scene: job.name(), part: part.name.clone(), values, ..MatrixCell::default() };
    match receive.recv_timeout(Duration::from_secs_f64(table.most_seconds)) {
        Ok(End::Done(solution, faults)) => {
            (cell.solution, cell.faults) = (Some(*solution), faults);
            if part.ends == Ends::Refused {
                cell.faults.push("ended in a solution".into());
            }
        }
        Ok(End::Refused(error)) => {
            (cell.exit, cell.message) = (error.exit_code(), error.to_string());
            if part.ends == Ends::Converged || !matches!(cell.exit, 2 | 3) {
                cell.faults.push(format!("ended with exit code {}: {}", cell.exit, cell.message));
            }
            if let Error::Interrupted(_) = error {
                return Err(error);
            }
        }
        Err(RecvTimeoutError::Timeout) => cell.faults.push(format!("did not end within {} s", table.most_seconds)),
        Err(RecvTimeoutError::Disconnected) => {
            let panic = thread.join().err();
            let text = panic.as_ref().and_then(|p| p.downcast_ref::<String>().map(String::as_str).or(p.downcast_ref::<&str>().copied()));
            cell.faults.push(format!("panicked: {}", text.unwrap_or("for no reason")));
        }
    }
    cell.wall_s = clock.elapsed().as_secs_f64();
    Ok(cell)
}

/// Reads, runs and judges the scene with `overrides`.
fn attempt(job: Job, overrides: &[String], case: PathBuf) -> End {
    let done = scene::parse(&job.scene_file.display().to_string(), job.source.text(), overrides).and_then(|(scene, source)| {
        let job = Job { scene, source, case, ..job };
        all::until_run(&job)?;
        judge(&job)
    });
    match done {
        Ok((solution, faults)) => End::Done(Box::new(solution), faults),
        Err(error) => End::Refused(error),
    }
}

/// Measures a run that converged, and says what is wrong with it.
fn judge(job: &Job) -> Result<(MatrixSolution, Vec<String>)> {
    let case = Case::load(job)?;
    let matrix = job.scene.report.as_ref().and_then(|r| r.matrix.as_ref());
    let matrix = matrix.ok_or_else(|| Error::input("report.matrix", "this table is missing"))?;
    let mut model = build::shell_model(&job.scene, &case.mesh, &Topology::new(&case.mesh.faces), &case.setup)?;
    let last = case.snapshot(When::End)?;
    let areas = case.mesh.faces.iter().map(|f| {
        let [a, b, c] = f.map(|v| case.mesh.vertices[v]);
        0.5 * (b - a).cross(&(c - a)).norm()
    });
    let stretching: f64 = areas.zip(&case.setup.materials).map(|(area, m)| area * m.thickness * m.youngs_modulus).sum();
    let column = |name: &str| case.column(name);
    let iterations: Vec<f64> = column("newton_iterations").iter().zip(column("fallback_iterations")).map(|(m, d)| m + d).collect();
    let per_step: Vec<f64> = iterations.iter().enumerate().map(|(i, n)| n - if i > 0 { iterations[i - 1] } else { 0.0 }).collect();
    let elastic = case.last("membrane_energy_J")? + case.last("bending_energy_J")?;
    let mut s = MatrixSolution {
        faces: case.mesh.faces.len(),
        dofs: case.setup.free_unknowns,
        steps: iterations.len(),
        newton_iterations: case.last("newton_iterations")? as u64,
        fallback_iterations: case.last("fallback_iterations")? as u64,
        factorizations: case.last("factorizations")? as u64,
        halvings: column("halvings").iter().sum::<f64>() as u64,
        median_iterations: median(&per_step, &vec![1.0; per_step.len()]),
        negative_pivots: case.last("negative_pivots")? as u64,
        residual: column("residual").iter().fold(0.0, |m, r| m.max(*r)),
        energy: elastic / stretching,
        ..MatrixSolution::default()
    };
    let moved = job.scene.pins.iter().any(|pin| pin.motion.is_some() || matches!(pin.director, Some(PinDirector::Rotation(_))));
    if !moved && job.scene.moments.is_empty() {
        (s.gain, s.lost) = balance(&case, &mut model, &last, ROUND_OFF * stretching)?;
    }
    if case.setup.held.is_empty() && job.scene.dynamics.is_some() {
        s.momentum = momentum(&job.scene, &case.start, &mut model, &last)?;
    }
    for entry in &matrix.measures {
        s.measures.push((entry.name.clone(), Some(case.measure(&entry.measure, When::End)?).filter(|v| v.is_finite())));
    }
    let mut faults = Vec::new();
    let is_finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
    if let Some(field) = last.fields.iter().find(|field| !is_finite(&field.data)) {
        faults.push(format!("field {} is not finite", field.name));
    }
    if let Some(name) = case.columns().iter().find(|name| !is_finite(&column(name)) && !name.starts_with("lowest_eigenvalue")) {
        faults.push(format!("column {name} of the history is not finite"));
    }
    let mut most = |what: &str, value: f64, most: f64| {
        if !(value <= most) {
            faults.push(format!("{what} {value:.3e}, at most {most:.3e} expected"));
        }
    };
    most("energy over E h A", s.energy, matrix.largest_energy);
    most("gain of energy", s.gain.unwrap_or(0.0), matrix.largest_gain);
    most("change of momentum", s.momentum.unwrap_or(0.0), MOMENTUM);
    most("factorisations", s.factorizations as f64, matrix.most_factorizations.map_or(f64::INFINITY, |n| n as f64));
    most("median of iterations", s.median_iterations, matrix.most_iterations.unwrap_or(f64::INFINITY));
    let limits = matrix.measures.iter().zip(&s.measures).filter_map(|(entry, (_, value))| limit(entry, *value));
    faults.extend(limits);
    Ok((s, faults))
}

/// The state of `from` with time and step of `to`, whose laws then hold.
fn at_end(from: &Snapshot, to: &Snapshot) -> Snapshot {
    let mut state = to.clone();
    for field in &mut state.fields {
        if let Some(earlier) = from.field(&field.name) {
            field.data.clone_from(&earlier.data);
        }
    }
    state
}

/// Energies by the model of a state.
fn energies(model: &mut ShellModel, state: &Snapshot) -> Result<Vec<f64>> {
    model.restore(state).map_err(|e| Error::input("report.matrix", e))?;
    Ok(model.energies().into_iter().map(|(_, e)| e).collect())
}

/// Gain of energy and, in motion, loss: see [`MatrixSolution::gain`]. `floor`: round-off [J].
fn balance(case: &Case, model: &mut ShellModel, last: &Snapshot, floor: f64) -> Result<(Option<f64>, Option<f64>)> {
    // What diffuses brings work of its own along.
    if case.job.scene.diffusing().next().is_some() {
        return Ok((None, None));
    }
    let sum = |energies: &[f64]| energies.iter().sum::<f64>();
    let size = |energies: &[f64]| energies.iter().map(|e| e.abs()).sum::<f64>();
    let start = energies(model, &case.start)?;
    let late = energies(model, &at_end(&case.start, last))?;
    if case.job.scene.statics.is_some() {
        let end = sum(&energies(model, last)?);
        let scale = sum(&late).abs().max(end.abs()).max(floor);
        return Ok((Some((end - sum(&late)) / scale), None));
    }
    // Loads or a rest shape that change do work.
    if sum(&start) != sum(&late) {
        return Ok((None, None));
    }
    let parts: Vec<Vec<f64>> = case.columns().iter().filter(|name| name.ends_with("_energy_J")).map(|name| case.column(name)).collect();
    let steps = parts.first().map_or(0, Vec::len);
    let rows: Vec<Vec<f64>> = (0..steps).map(|i| parts.iter().map(|part| part[i]).collect()).collect();
    let scale = rows.iter().map(|row| size(row)).fold(size(&start).max(floor), f64::max);
    let gain = rows.iter().map(|row| sum(row) - sum(&start)).fold(0.0, f64::max);
    let lost = rows.last().map_or(0.0, |row| sum(&start) - sum(row));
    Ok((Some(gain / scale), Some(lost / scale)))
}

/// Change of momentum that gravity does not explain: see [`MatrixSolution::momentum`]. None under other loads.
fn momentum(scene: &Scene, start: &Snapshot, model: &mut ShellModel, last: &Snapshot) -> Result<Option<f64>> {
    let dead = scene.forces.len() + scene.edge_loads.len() + scene.surface_loads.len() + scene.body_forces.len();
    let others = dead + scene.moments.len() + scene.pressures.len() + scene.winds.len() > 0;
    let gravity = scene.gravity.as_ref();
    let mut acceleration = nalgebra::Vector3::zeros();
    for (to, said) in acceleration.iter_mut().zip(gravity.iter().flat_map(|g| &g.acceleration)) {
        let parsed = build::expression("gravity.acceleration", said, scene::PLACE_AND_TIME)?;
        if !parsed.is_constant() {
            return Ok(None);
        }
        *to = parsed.eval(&[]);
    }
    if others || scene.diffusing().next().is_some() || gravity.is_some_and(|g| g.factor.is_some()) {
        return Ok(None);
    }
    let mut of = |state: &Snapshot, set: &dyn Fn(usize, f64) -> f64| -> Result<_> {
        let mut state = state.clone();
        let velocity = state.fields.iter_mut().find(|field| field.name == "velocity");
        velocity.into_iter().flat_map(|field| field.data.iter_mut().enumerate()).for_each(|(i, v)| *v = set(i, *v));
        model.restore(&state).map_err(|e| Error::input("report.matrix", e))?;
        Ok(model.momentum().unwrap_or_default())
    };
    let mass = of(start, &|i, _| f64::from(u8::from(i % 3 == 0)))?.x;
    let kept = |_: usize, v: f64| v;
    let change = of(last, &kept)? - of(start, &kept)?;
    let speeds = of(start, &|_, v| v.abs())?;
    let brought = acceleration * (mass * last.time);
    let scale = speeds.norm() + brought.norm();
    Ok((scale > 0.0).then(|| (change - brought).norm() / scale))
}

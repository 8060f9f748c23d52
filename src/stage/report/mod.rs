//! `report`: compares results with what their scenes expect (`report.json`, `report.md`), and tabulates error against run time and the
//! results of sweeps and stability matrices.

mod case;
mod check;
mod ladder;
mod matrix;
mod measure;
mod path;
mod reactions;
mod sweep;

use super::{Job, modes, print, run as run_stage};
use crate::case::{Folder, atomic, hash};
use crate::error::{Error, Result};
use crate::report::{ExpectationResult, Outcome};
use case::Case;
use std::path::{Path, PathBuf};

pub use check::check_measures;
pub use ladder::ladder;
pub use matrix::{Options as MatrixOptions, matrix};
pub use measure::vertex_at;
pub use sweep::{check_sweeps, sweep};

/// Reports on each of `targets`, a case's folder or a scene file (with `overrides`); `json` is written too, if given.
///
/// # Errors
/// Cases that are not there or not run, and [`Error::Missed`] when an expectation is.
pub fn run(targets: &[PathBuf], overrides: &[String], json: Option<&Path>, quiet: bool) -> Result<()> {
    let mut outcomes = Vec::new();
    for target in targets {
        let job = Job::read(target, None, overrides, quiet)?;
        outcomes.push(of_job(&job).map_err(|error| job.explain(error))?);
    }
    if let Some(path) = json {
        let list: Vec<String> = outcomes.iter().map(Outcome::to_json).collect();
        let text = if let [one] = list.as_slice() { one.clone() } else { format!("[{}]", list.join(",")) };
        atomic::write(path, text.as_bytes())?;
    }
    let missed: Vec<&str> = outcomes.iter().filter(|o| !o.passed).map(|o| o.scene.as_str()).collect();
    verdict(&missed)
}

/// Writes `report.json` and `report.md` of one case and prints the latter.
pub fn of_job(job: &Job) -> Result<Outcome> {
    let case = Case::load(job)?;
    let mut results = Vec::new();
    for e in job.scene.report.iter().flat_map(|r| &r.expectations) {
        let value = case.measure_at(&e.measure, e.into())?;
        results.push(ExpectationResult::new(&e.name, value, e.reference, e.tolerance, &e.source));
    }
    let path = job.scene.report.as_ref().and_then(|report| report.path.as_ref()).map(|path| case.along(path)).transpose()?;
    if let Some(path) = &path {
        path::write(job, path)?;
    }
    let outcome = Outcome { inputs: inputs(job)?, path, ..Outcome::new(job.name(), results, case.cost()?) };
    atomic::write(&job.case.join("report.json"), outcome.to_json().as_bytes())?;
    let mut text = outcome.to_markdown();
    let modes = modes::load(job)?.map_or(Vec::new(), |found| found.lines());
    for line in case.switches().into_iter().chain(case.stability()).chain(case.factored_by_lu()).chain(modes) {
        text.push_str(&format!("\n{line}.\n"));
    }
    atomic::write(&job.case.join("report.md"), text.as_bytes())?;
    job.record()?;
    if !job.quiet {
        print(text.trim_end())?;
    }
    Ok(outcome)
}

/// The report of one case, made if it is not there or out of date; [`Error::Missed`] if an expectation is.
pub fn bring_up_to_date(job: &Job) -> Result<()> {
    let passed = match current(job)? {
        Some(passed) if !job.quiet => {
            let path = job.case.join("report.md");
            print(std::fs::read_to_string(&path).map_err(|e| Error::io("read", &path, e))?.trim_end())?;
            passed
        }
        Some(passed) => passed,
        None => of_job(job)?.passed,
    };
    let name = job.name();
    verdict(if passed { &[] } else { std::slice::from_ref(&name) })
}

/// Whether the report that is there passed; none if there is none or it was made from something else.
///
/// # Errors
/// Those of the run.
pub fn current(job: &Job) -> Result<Option<bool>> {
    let Ok(text) = std::fs::read_to_string(job.case.join("report.json")) else { return Ok(None) };
    let report: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let current = job.case.join("report.md").is_file() && report["inputs"].as_str() == Some(&inputs(job)?);
    Ok(report["passed"].as_bool().filter(|_| current))
}

/// Hash of what a report is made from: what the scene expects, the checkpoints and the history.
fn inputs(job: &Job) -> Result<String> {
    let expected = job.scene.report.as_ref().map(|report| (&report.expectations, &report.path));
    let expected = serde_json::to_string(&expected).map_err(|e| Error::input("report", e.to_string()))?;
    let run = run_stage::inputs(job)?;
    let history = hash::file(&run_stage::history_path(job))?;
    let checkpoints = Folder::new(&job.case, &run).fingerprint()?;
    let modes = if job.scene.modes.is_some() { modes::inputs(job)? } else { String::new() };
    Ok(hash::of(&[&run, &expected, &history, &checkpoints, &modes].map(|text| text.as_bytes())))
}

/// [`Error::Missed`] if some scene, by its name, missed an expectation.
fn verdict(missed: &[impl AsRef<str>]) -> Result<()> {
    let missed: Vec<&str> = missed.iter().map(AsRef::as_ref).collect();
    if missed.is_empty() { Ok(()) } else { Err(Error::Missed(format!("expectations missed: {}", missed.join(", ")))) }
}

/// Writes a table of runs as JSON and Markdown into the case, as JSON to `json` too if given, and prints it.
fn publish(job: &Job, name: &str, data: &str, table: &str, json: Option<&Path>) -> Result<()> {
    std::fs::create_dir_all(&job.case).map_err(|e| Error::io("create", &job.case, e))?;
    atomic::write(&job.case.join(format!("{name}.json")), data.as_bytes())?;
    atomic::write(&job.case.join(format!("{name}.md")), table.as_bytes())?;
    if let Some(path) = json {
        atomic::write(path, data.as_bytes())?;
    }
    print(table.trim_end())
}

/// [`Error::Numerical`] if all runs of a table failed, so that there is no result in it; says how many did otherwise.
fn fail_if_all(failed: impl Iterator<Item = bool>, table: &str) -> Result<()> {
    let failed: Vec<bool> = failed.collect();
    let number = failed.iter().filter(|failed| **failed).count();
    if number > 0 && number == failed.len() {
        let help = Some("the table has the reasons; `thinshell all` shows one of them in full".into());
        return Err(Error::Numerical { message: format!("every run of the {table} failed"), help });
    }
    if number > 0 {
        log::warn!("{number} of the {} runs of the {table} failed", failed.len());
    }
    Ok(())
}

//! `report`: compares results with what their scenes expect (`report.json`, `report.md`), and tabulates error against run time and the
//! results of sweeps.

mod case;
mod check;
mod ladder;
mod measure;
mod sweep;

use super::{Job, print};
use crate::case::atomic;
use crate::error::{Error, Result};
use crate::report::{ExpectationResult, Outcome};
use case::Case;
use std::path::{Path, PathBuf};

pub use check::check_measures;
pub use ladder::ladder;
pub use sweep::sweep;

/// Reports on each of `targets`, a case's folder or a scene file (with `overrides`); `json` is written too, if given.
///
/// # Errors
/// Cases that are not there or not run, and [`Error::Missed`] when an expectation is.
pub fn run(targets: &[PathBuf], overrides: &[String], json: Option<&Path>, quiet: bool) -> Result<()> {
    let mut outcomes = Vec::new();
    for target in targets {
        outcomes.push(of_job(&Job::read(target, None, overrides, quiet)?)?);
    }
    if let Some(path) = json {
        let list: Vec<String> = outcomes.iter().map(Outcome::to_json).collect();
        let text = if let [one] = list.as_slice() { one.clone() } else { format!("[{}]", list.join(",")) };
        atomic::write(path, text.as_bytes())?;
    }
    verdict(&outcomes)
}

/// Writes `report.json` and `report.md` of one case and prints the latter.
pub fn of_job(job: &Job) -> Result<Outcome> {
    let case = Case::load(job)?;
    let mut results = Vec::new();
    for e in job.scene.report.iter().flat_map(|r| &r.expectations) {
        let value = case.measure(&e.measure, e.time)?;
        results.push(ExpectationResult::new(&e.name, value, e.reference, e.tolerance, &e.source));
    }
    let outcome = Outcome::new(job.name(), results, case.cost()?);
    atomic::write(&job.case.join("report.json"), outcome.to_json().as_bytes())?;
    let mut text = outcome.to_markdown();
    for line in case.switches().into_iter().chain(case.stability()) {
        text.push_str(&format!("\n{line}.\n"));
    }
    atomic::write(&job.case.join("report.md"), text.as_bytes())?;
    job.record()?;
    if !job.quiet {
        print(text.trim_end())?;
    }
    Ok(outcome)
}

/// [`Error::Missed`] if some expectation is.
pub fn verdict(outcomes: &[Outcome]) -> Result<()> {
    let missed: Vec<&str> = outcomes.iter().filter(|o| !o.passed).map(|o| o.scene.as_str()).collect();
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

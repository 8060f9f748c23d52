//! `all`: does every stage that is out of date, from mesh to report.

use super::{Job, export, mesh, report, run as run_stage, setup};
use crate::case::{Archive, Kind};
use crate::error::Result;

/// The stage.
///
/// # Errors
/// Those of the stages, and an expectation that is missed.
pub fn run(job: &Job) -> Result<()> {
    until_run(job)?;
    export::run(job)?;
    report::verdict(&[report::of_job(job)?])
}

/// Mesh, setup and run, where they are out of date.
pub fn until_run(job: &Job) -> Result<()> {
    if Archive::read_for(&mesh::path(job), Kind::Mesh, &mesh::inputs(job)?).is_err() {
        mesh::run(job)?;
    }
    if Archive::read_for(&setup::path(job), Kind::Setup, &setup::inputs(job)?).is_err() {
        setup::run(job)?;
    }
    // Checkpoints of an earlier state of the scene are what `all` is asked to replace.
    let restart = run_stage::is_done(job).is_err();
    if restart || !run_stage::is_done(job)? {
        run_stage::run(job, &run_stage::Options { restart, stop_after: None })?;
    }
    Ok(())
}

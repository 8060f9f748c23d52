//! `all`: does every stage that is out of date, from mesh to report.

use super::{Job, export, mesh, modes, report, run as run_stage, setup};
use crate::case::{Archive, Folder, Kind};
use crate::error::{Error, Result};

/// The stage.
///
/// # Errors
/// Those of the stages, and an expectation that is missed.
pub fn run(job: &Job) -> Result<()> {
    report::check_sweeps(job)?;
    until_run(job)?;
    if !export::is_current(job)? {
        export::run(job)?;
    }
    report::bring_up_to_date(job)
}

/// Mesh, setup, run and modes, where they are out of date.
pub fn until_run(job: &Job) -> Result<()> {
    let has_mesh = Archive::read_for(&mesh::path(job), Kind::Mesh, &mesh::inputs(job)?).is_ok();
    let has_setup = Archive::read_for(&setup::path(job), Kind::Setup, &setup::inputs(job)?).is_ok();
    if !has_mesh {
        // Both in memory first: a scene that cannot be set up leaves nothing behind.
        setup::make(&job.scene, &mesh::make(&job.scene, &job.scene_file)?.0)?;
        mesh::run(job)?;
    }
    if !has_setup {
        setup::run(job)?;
    }
    let (done, restart) = match run_stage::is_done(job) {
        // Checkpoints of an earlier state of the scene are what `all` is asked to replace.
        Err(Error::Stale { path, message, .. }) => {
            let newest = Folder::new(&job.case, "").list()?.into_iter().next_back().unwrap_or(0);
            job.say(&format!("run: {newest} steps are discarded: {} {message}", path.display()));
            (false, true)
        }
        done => (done?, false),
    };
    if !done {
        run_stage::run(job, &run_stage::Options { restart, stop_after: None })?;
    }
    if modes::is_current(job)? { Ok(()) } else { modes::run(job) }
}

//! `status`: prints which stages of a case are done, stale or missing. Writes nothing.

use super::{Job, export, mesh, print, run as run_stage, setup};
use crate::case::{Archive, Folder, Kind};
use crate::error::{Error, Result};
use std::path::Path;

/// The stage.
///
/// # Errors
/// If the case cannot be looked into.
pub fn run(job: &Job) -> Result<()> {
    let archive = |path: &Path, kind, inputs: &str| -> Result<String> {
        match Archive::read_for(path, kind, inputs) {
            Ok(_) => Ok("done".into()),
            Err(Error::Stale { message, .. }) => Ok(if path.exists() { format!("out of date: {message}") } else { "missing".into() }),
            Err(e) => Err(e),
        }
    };
    let mesh = archive(&mesh::path(job), Kind::Mesh, &mesh::inputs(job)?)?;
    let setup = archive(&setup::path(job), Kind::Setup, &setup::inputs(job)?)?;
    let folder = Folder::new(&job.case, run_stage::inputs(job)?);
    let newest = match run_stage::progress(job) {
        Ok(newest) => {
            newest.warnings.iter().for_each(|w| log::warn!("{w}"));
            newest.snapshot
        }
        Err(Error::Stale { message, .. }) => {
            return print(&format!("mesh    {mesh}\nsetup   {setup}\nrun     out of date: {message}"));
        }
        Err(e) => return Err(e),
    };
    let run = match &newest {
        None => "missing".to_owned(),
        Some(s) if run_stage::is_done(job)? => format!("done: {} steps to {}", s.step, job.moment(s.time)),
        Some(s) => format!("unfinished: {} steps to {}", s.step, job.moment(s.time)),
    };
    let age = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
    let run_age = newest.as_ref().and_then(|s| age(&folder.path(s.step)));
    let after_run = |path: &Path| match (age(path), run_age) {
        (None, _) => "missing",
        (Some(file), Some(run)) if file >= run => "done",
        (Some(_), _) => "out of date",
    };
    let (export, report) = (after_run(&export::path(job)), after_run(&job.case.join("report.json")));
    print(&format!("mesh    {mesh}\nsetup   {setup}\nrun     {run}\nexport  {export}\nreport  {report}"))
}

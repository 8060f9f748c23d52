//! `status`: prints which stages of a case are done, stale or missing. Writes nothing.

use super::{Job, export, mesh, modes, print, report, run as run_stage, setup};
use crate::case::{Archive, Kind};
use crate::error::{Error, Result};
use std::path::Path;

/// The stage.
///
/// # Errors
/// If the case cannot be looked into, and a history that does not reach as far as the checkpoints do.
pub fn run(job: &Job) -> Result<()> {
    let archive = |path: &Path, kind, inputs: &str| -> Result<String> {
        match Archive::read_for(path, kind, inputs).map_err(|e| job.explain(e)) {
            Ok(_) => Ok("done".into()),
            Err(Error::Stale { message, .. }) => Ok(if path.exists() { format!("out of date: {message}") } else { "missing".into() }),
            Err(e) => Err(e),
        }
    };
    let mesh = archive(&mesh::path(job), Kind::Mesh, &mesh::inputs(job)?)?;
    let setup = archive(&setup::path(job), Kind::Setup, &setup::inputs(job)?)?;
    let progress = run_stage::progress(job).inspect(|newest| newest.warnings.iter().for_each(|w| log::warn!("{w}")));
    let (run, damage) = match progress.map(|newest| newest.snapshot) {
        Ok(None) => ("missing".to_owned(), None),
        Ok(Some(s)) if run_stage::is_done(job)? => (format!("done: {} steps to {}", s.step, job.moment(s.time)), None),
        Ok(Some(s)) => (format!("unfinished: {} steps to {}", s.step, job.moment(s.time)), None),
        Err(e @ Error::Stale { .. }) => {
            let lost = matches!(&e, Error::Stale { path, .. } if *path == run_stage::history_path(job));
            let e = job.explain(e);
            (format!("out of date: {e}"), lost.then_some(e))
        }
        Err(e) => return Err(e),
    };
    let after_run = |path: &Path, is_current: bool| match (path.exists(), is_current) {
        (false, _) => "missing",
        (true, true) => "done",
        (true, false) => "out of date",
    };
    let modes = match &job.scene.modes {
        Some(_) => format!("modes   {}\n", after_run(&modes::path(job), modes::is_current(job).unwrap_or(false))),
        None => String::new(),
    };
    let export = after_run(&export::path(job), export::is_current(job)?);
    let report = after_run(&job.case.join("report.json"), report::current(job).is_ok_and(|passed| passed.is_some()));
    print(&format!("mesh    {mesh}\nsetup   {setup}\nrun     {run}\n{modes}export  {export}\nreport  {report}"))?;
    damage.map_or(Ok(()), Err)
}

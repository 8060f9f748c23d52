//! `report`: compares results with what their scenes expect, and tabulates error against run time.

use super::Job;
use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Reports on each of `targets`, a case's folder or a scene file (with `overrides`); `json` is written too, if given.
///
/// # Errors
/// Always, as long as it is not built.
pub fn run(_targets: &[PathBuf], _overrides: &[String], _json: Option<&Path>, _quiet: bool) -> Result<()> {
    Err(Error::input("report", "not built yet"))
}

/// Runs the scene's ladder.
///
/// # Errors
/// Always, as long as it is not built.
pub fn ladder(_job: &Job, _json: Option<&Path>) -> Result<()> {
    Err(Error::input("report", "not built yet"))
}

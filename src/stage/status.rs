//! `status`: prints which stages of a case are done, stale or missing.

use super::Job;
use crate::error::{Error, Result};

/// The stage.
///
/// # Errors
/// Always, as long as it is not built.
pub fn run(_job: &Job) -> Result<()> {
    Err(Error::input("status", "not built yet"))
}

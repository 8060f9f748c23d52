//! `setup`: makes rest forms, materials, supports and the first state.

use super::Job;
use crate::error::{Error, Result};

/// The stage.
///
/// # Errors
/// Always, as long as it is not built.
pub fn run(_job: &Job) -> Result<()> {
    Err(Error::input("setup", "not built yet"))
}

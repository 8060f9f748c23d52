//! `mesh`: makes the mesh.

use super::Job;
use crate::error::{Error, Result};

/// The stage.
///
/// # Errors
/// Always, as long as it is not built.
pub fn run(_job: &Job) -> Result<()> {
    Err(Error::input("mesh", "not built yet"))
}

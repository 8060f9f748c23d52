//! `run`: simulates from the newest valid checkpoint on.

use super::Job;
use crate::error::{Error, Result};

/// How far, and from where.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Options {
    /// Discard all checkpoints and start from the setup.
    #[arg(long)]
    pub restart: bool,
    /// Stop after this many further steps, with a checkpoint.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub stop_after: Option<u64>,
}

/// The stage.
///
/// # Errors
/// Always, as long as it is not built.
pub fn run(_job: &Job, _options: &Options) -> Result<()> {
    Err(Error::input("run", "not built yet"))
}

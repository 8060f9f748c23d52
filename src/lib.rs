//! thinshell: thin shells whose rest shape changes, from a TOML scene to VTK files and a report.

pub mod case;
pub mod cli;
pub mod error;
pub mod math;
pub mod mesh;
pub mod report;
pub mod scene;
pub mod stage;

pub use error::{Error, Result};
pub mod sparse;
pub mod shell;
pub mod solve;
pub mod model;

//! thinshell: thin shells whose rest shape changes, from a TOML scene to VTK files and a report.

pub mod case;
pub mod error;
pub mod mesh;
pub mod report;
pub mod scene;

pub use error::{Error, Result};

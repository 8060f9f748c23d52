//! thinshell: thin shells whose rest shape changes, from a TOML scene to VTK files and a report.

// Docs write units in brackets, as in `[m]`; they are not links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod case;
pub mod cli;
pub mod error;
pub mod math;
pub mod mesh;
pub mod model;
pub mod report;
pub mod scene;
pub mod shell;
pub mod snapshot;
pub mod solve;
pub mod sparse;
pub mod stage;

pub use error::{Error, Result};

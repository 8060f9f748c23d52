//! A case's files: one HDF5 file per stage and per checkpoint, history, VTK, hashes of inputs.
//!
//! Files see [`Snapshot`]s and plain arrays, never a model or a scene.

mod snapshot;

pub use snapshot::{Association, Field, Snapshot};

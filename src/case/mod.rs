//! A case's files: one HDF5 file per stage and per checkpoint, history, VTK, hashes of inputs.
//!
//! Files see [`crate::snapshot::Snapshot`]s and plain arrays, never a model or a scene.

pub mod archive;
pub mod atomic;
mod convert;
mod folder;
pub mod hash;
pub mod history;
mod seal;
pub mod vtk;

pub use archive::{Archive, Array, Data, Kind};
pub use convert::{mesh_from_archive, mesh_to_archive, put_mesh, put_snapshot, snapshot_from_archive, snapshot_to_archive};
pub use folder::{Folder, Lock, Newest};
pub use history::History;

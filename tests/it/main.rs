//! One integration binary; each module tests one part.

mod mesh_files;
mod mesh_generate;
mod mesh_import;
mod mesh_validate;

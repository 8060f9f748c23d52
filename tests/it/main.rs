//! The integration tests, in one binary.

mod case_archive;
mod case_folder;

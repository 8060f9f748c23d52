//! The integration tests, in one binary.

mod case_archive;
mod case_folder;
mod case_history;
mod case_vtk;
mod report_measures;
mod report_tables;

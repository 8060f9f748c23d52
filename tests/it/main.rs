//! The integration tests, in one binary.

mod case_archive;
mod case_folder;
mod case_history;
mod case_vtk;
mod cli;
mod pipeline_absent;
mod pipeline_check;
mod pipeline_damage;
mod pipeline_fuzz;
mod pipeline_kill;
mod pipeline_layers;
mod pipeline_resume;
mod pipeline_smallest;
mod pipeline_support;
mod pipeline_wrong;
mod report_measures;
mod report_tables;
mod scene_fuzz;
mod scene_reading;
mod scene_wrong;
mod shell_derivatives;

//! The integration tests, in one binary.

mod case_archive;
mod case_folder;
mod case_history;
mod case_vtk;
mod cli;
mod mesh_files;
mod mesh_generate;
mod mesh_import;
mod mesh_quadratic;
mod mesh_validate;
mod pipeline_layers;
mod report_measures;
mod report_tables;
mod scene_fuzz;
mod scene_reading;
mod scene_wrong;
mod shell_derivatives;

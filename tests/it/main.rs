//! The integration tests, in one binary.

mod case_archive;
mod case_folder;
mod case_history;
mod case_vtk;
mod cli;
mod physics_case;
mod physics_curvature;
mod physics_directors;
mod physics_motion;
mod physics_newton;
mod physics_sampling;
mod physics_supports;
mod physics_swelling;
mod report_measures;
mod report_tables;
mod scene_fuzz;
mod scene_reading;
mod scene_wrong;
mod shell_derivatives;

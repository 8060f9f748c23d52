//! The integration tests, one binary so that they link once.

mod cli;
mod scene_fuzz;
mod scene_reading;
mod scene_wrong;

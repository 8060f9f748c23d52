//! The iteration: work that does not depend on the thickness, and steps that fail and recover (PHYSICS A6).

use crate::physics_case::{Case, run, six_pins, try_run};
use std::f64::consts::PI;
use thinshell::report::cylinder_distance;

/// A strip of 0.1 x 0.02 that curls to a half circle.
fn curl(director: &str, cells: [usize; 2], mesh: &str, h: f64, steps: usize, solver: &str) -> String {
    format!(
        "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = {cells:?}\n{mesh}\n{}[shell]\ndirector = \"{director}\"\nthickness = {h:?}\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
         [rest.pullback]\nbbar = [\"PI/0.1\", 0, 0]\n[statics]\nsteps = {steps}\n[solver]\n{solver}\n",
        six_pins(0.05, 0.01, 0.006, 0.01)
    )
}

fn error(case: &Case) -> f64 {
    cylinder_distance(&case.mesh.vertices, &case.end, 0.1 / PI)
}

#[test]
fn work_does_not_grow_as_the_strip_becomes_thin() {
    for director in ["free-tan", "free-sin", "average"] {
        for mesh in ["", "jitter = 0.25", "pattern = \"delaunay\""] {
            for h in [1e-3, 1e-4, 1e-5, 1e-6] {
                match try_run(&curl(director, [35, 7], mesh, h, 3, "")) {
                    Ok(case) => println!("{director} {mesh} h {h:e}: {} faces, {} factorisations, {} descent, {} steps, error {:.3e}", case.mesh.faces.len(), case.last("factorizations"), case.last("fallback_iterations"), case.column("time_s").len(), error(&case)),
                    Err(e) => println!("{director} {mesh} h {h:e}: {e}"),
                }
            }
        }
    }
    let case = run(&curl("free-tan", [70, 14], "", 1e-4, 3, ""));
    println!("1960 faces: {} factorisations error {:.3e}", case.last("factorizations"), error(&case));
}

#[test]
fn steps_that_are_too_big_are_halved() {
    for solver in ["", "max_iterations = 5", "max_iterations = 3"] {
        match try_run(&curl("free-tan", [20, 4], "", 1e-3, 1, solver)) {
            Ok(case) => println!("{solver:?}: times {:?} halvings {:?} fallback {:?} factorisations {}, error {:e}", case.column("time_s"), case.column("halvings"), case.column("fallback_iterations"), case.last("factorizations"), error(&case)),
            Err(e) => println!("{solver:?}: {e}"),
        }
    }
    let case = run(&curl("free-tan", [20, 4], "", 1e-3, 8, ""));
    println!("8 steps: {}, error {:e}", case.last("factorizations"), error(&case));
}

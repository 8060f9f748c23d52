//! Moments and prescribed rotations of edges, against the circle that they roll a strip into.

use crate::physics_case::run;
use nalgebra::Vector3;

const LENGTH: f64 = 12.0;
const STIFFNESS: f64 = 100.0;

/// A strip of width 1, stiffness 100 per width, clamped at x = 0 and held in its plane, turned at the other end in eight steps.
fn strip(element: &str, cells: &str, turned: &str) -> String {
    format!(
        "[mesh.rectangle]\nsize = [12.0, 1.0]\ncells = {cells}\n[[region]]\nname = \"all\"\nwhere = \"1\"\n\
         [shell]\nelement = \"{element}\"\nthickness = 0.01\nyoungs_modulus = 1.2e9\npoissons_ratio = 0.0\n\
         [[pin]]\nregion = \"all\"\ncomponents = [\"y\"]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n{turned}[statics]\nsteps = 8\n"
    )
}

/// Place of the end of a strip bent by `angle` [rad] in all, about -y.
fn circle(angle: f64) -> Vector3<f64> {
    Vector3::new(LENGTH * angle.sin() / angle, 0.0, LENGTH * (1.0 - angle.cos()) / angle)
}

#[test]
fn a_moment_and_a_rotation_roll_the_same_circle() {
    let half = std::f64::consts::PI;
    let moment = format!("[[moment]]\nregion = \"right\"\nmoment = [0, {:?}, 0]\n", -half * STIFFNESS / LENGTH);
    let rotation = "[[pin]]\nregion = \"right\"\ncomponents = []\ndirector = { rotation = { axis = [0, -1, 0], angle = \"180 * t\" } }\n";
    for (element, cells, tolerance) in [("quadratic", "[16, 1]", 1e-3), ("linear", "[64, 2]", 2e-3)] {
        for turned in [&moment, rotation] {
            let case = run(&strip(element, cells, turned));
            let end = case.mesh.region_nearest(Vector3::new(LENGTH, 0.0, 0.0)).vertices[0];
            for state in case.states().iter().skip(1) {
                let positions = &state.field("position").unwrap().data;
                let p = Vector3::new(positions[3 * end], 0.0, positions[3 * end + 2]);
                let distance = (p - circle(half * state.time)).norm() / LENGTH;
                assert!(distance < tolerance, "{element} {turned} at {}: {distance:e}", state.time);
            }
        }
    }
}

//! Motion: free fall, rigid motion, momentum, dissipation and the order of implicit Euler (Chen et al. 2018, section 3).

use crate::physics_case::{Case, Kind, forms, free, points, rate, rolled, run, shell, unknowns};
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::TAU;
use thinshell::mesh::generate;
use thinshell::shell::Material;

const G: f64 = 9.80665;
const THICKNESS: f64 = 1e-3;
const YOUNG: f64 = 1e7;
const DENSITY: f64 = 900.0;

/// A piece of a cylinder, so that nothing is zero by flatness.
fn gutter(rest: &str) -> String {
    format!(
        "[mesh.cylinder]\nradius = 0.05\nlength = 0.1\nangle = 130.0\ncells = [6, 4]\npattern = \"alternating\"\n[solver]\ntolerance = 1e-12\n\
         [shell]\nelement = \"linear\"\nthickness = {THICKNESS}\ndensity = {DENSITY}\nyoungs_modulus = {YOUNG:?}\npoissons_ratio = 0.3\n{rest}"
    )
}

/// Lumped mass of each vertex [kg].
fn masses(case: &Case) -> Vec<f64> {
    thinshell::report::vertex_areas(&case.mesh.vertices, &case.mesh.faces).into_iter().map(|a| a * DENSITY * THICKNESS).collect()
}

fn total(masses: &[f64], vectors: &[Vector3<f64>]) -> Vector3<f64> {
    masses.iter().zip(vectors).map(|(m, v)| *m * v).sum()
}

#[test]
fn free_fall() {
    let (dt, steps) = (0.01, 20u32);
    for mass in ["consistent", "lumped"] {
        let case = run(&gutter(&format!("mass = \"{mass}\"\n[gravity]\n[dynamics]\ndt = {dt}\nend = {}\n", dt * f64::from(steps))));
        let masses = masses(&case);
        let weight: f64 = masses.iter().sum();
        let area = 6.0 * 2.0 * 0.05 * (65f64.to_radians() / 6.0).sin() * 0.1;
        assert!((weight - DENSITY * THICKNESS * area).abs() < 1e-12 * weight);
        let states = case.states();
        assert_eq!(states.len(), steps as usize + 1);
        for (n, state) in states.iter().enumerate() {
            let n = n as f64;
            // v_n = n g dt; x_n = x_0 + g dt^2 (1 + 2 + ... + n)
            let fall = Vector3::z() * (-G * dt * dt * 0.5 * n * (n + 1.0));
            for (p, q) in points(state, "position").iter().zip(&case.mesh.vertices) {
                assert!((p - q - fall).norm() < 1e-11, "{mass} step {n}: {}", (p - q - fall).norm());
            }
            let momentum = total(&masses, &points(state, "velocity"));
            assert!((momentum + Vector3::z() * (weight * G * state.time)).norm() < 1e-9 * weight * G * 0.2);
        }
        for energy in ["membrane_energy_J", "bending_energy_J"] {
            let most = case.column(energy).into_iter().fold(0.0, f64::max);
            assert!(most < 1e-12 * YOUNG * THICKNESS.powi(3), "{mass} {energy} {most:e}");
        }
        // Kinetic energy is 1/2 m v^2, with the half.
        let kinetic = case.last("kinetic_energy_J");
        assert!((kinetic - 0.5 * weight * (G * 0.2).powi(2)).abs() < 1e-9 * kinetic);
    }
}

/// A sheet of 0.1 m that turns by half a radian in each step, where inertia has it as a whole before it is sought how it deforms; and one that falls by 5e6 m, where
/// coordinates have digits for 1e-9 m only, far above the tolerance.
#[test]
fn long_steps_of_a_free_sheet() {
    let sheet = |dynamics: &str| {
        run(&format!(
            "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [3, 3]\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1e7\npoissons_ratio = 0.3\n\
             density = 1000\n[gravity]\n[dynamics]\nvelocity = [\"-5 * (y - 0.05)\", \"5 * (x - 0.05)\", 0]\n{dynamics}"
        ))
    };
    let turning = sheet("dt = 0.1\nend = 2\n");
    assert!(turning.last("newton_iterations") <= 3.0 * 20.0, "{}", turning.last("newton_iterations"));
    // A rigid sheet is where inertia would have it at best: turned by atan(omega dt) in the first step.
    let first = points(&turning.states()[1], "position");
    let (before, after) = (turning.mesh.vertices[1] - turning.mesh.vertices[0], first[1] - first[0]);
    let turn = before.cross(&after).z.atan2(before.dot(&after));
    assert!((turn - 0.5f64.atan()).abs() < 0.02, "{turn}");
    let falling = sheet("dt = 100\nend = 1000\n");
    assert_eq!(falling.last("halvings"), 0.0);
    let fall = G * 1e4 * 55.0;
    falling.end.iter().for_each(|p| assert!((p.z / fall + 1.0).abs() < 1e-7, "{}", p.z));
}

#[test]
fn uniform_motion_is_exact_and_costs_nothing() {
    let case = run(&gutter("[dynamics]\ndt = 0.05\nend = 1.0\nvelocity = [1.0, -2.0, 0.5]\n"));
    for (p, q) in case.end.iter().zip(&case.mesh.vertices) {
        assert!((p - q - Vector3::new(1.0, -2.0, 0.5)).norm() < 1e-10);
    }
    let elastic = case.last("membrane_energy_J") + case.last("bending_energy_J");
    assert!(elastic < 1e-12 * YOUNG * THICKNESS.powi(3), "{elastic:e}");
}

#[test]
fn a_state_moved_rigidly_has_no_energy() {
    let mesh = rolled(&generate::rectangle([1.0, 0.6], [7, 4], generate::Pattern::Diagonal, 0.3, 1).unwrap(), 0.4);
    let material = Material { thickness: 0.01, youngs_modulus: 5.0, poissons_ratio: 0.3 };
    for kind in [Kind::Average, Kind::Sin, Kind::Tan] {
        let mut shell = shell(kind, &mesh, &free(&mesh), material);
        let x = unknowns(&*shell, &mesh);
        shell.set_rest(&forms(&shell.forms(&x)));
        for turn in [Vector3::new(0.3, 0.2, -0.1), Vector3::new(-1.5, 2.0, 1.0), Vector3::new(0.0, 3.1, 0.0)].map(Rotation3::new) {
            let mut moved = mesh.clone();
            moved.vertices.iter_mut().for_each(|v| *v = turn * *v + Vector3::new(1.0, 2.0, -3.0));
            let before = shell.directors().to_vec();
            shell.set_directors(&before.iter().map(|p| turn * p).collect::<Vec<_>>());
            let energies = shell.energies(&unknowns(&*shell, &moved));
            shell.set_directors(&before);
            assert!(energies.iter().all(|e| *e < 1e-12 * 5.0 * 1e-6), "{kind:?} {energies:?}");
        }
        // Something that is not rigid does cost.
        let mut bent = mesh.clone();
        bent.vertices.iter_mut().for_each(|v| v.z += 0.1 * v.y * v.y);
        let energies = shell.energies(&unknowns(&*shell, &bent));
        assert!(energies.iter().all(|e| *e > 1e-6 * 5.0 * 1e-6), "{kind:?} {energies:?}");
    }
}

/// Three pins turn a third of a turn about (1, 1, 1) and the shell follows without strain, in statics and slowly in motion.
#[test]
fn a_shell_follows_its_pins_around() {
    let motion = |angle: &str| {
        let of = |a: &str, b: &str, c: &str| format!("(sin({angle})/sqrt(3))*({c} - {b}) + ((1 - cos({angle}))/3)*({b} + {c} - 2*{a})");
        format!("[pin.motion]\nx = \"{}\"\ny = \"{}\"\nz = \"{}\"\n", of("x", "y", "z"), of("y", "z", "x"), of("z", "x", "y"))
    };
    let pins = |angle: &str| {
        [("p", "0.05, 0.0, 0.0"), ("q", "0.05, 0.0, 0.1"), ("r", "-0.02, 0.045, 0.05")]
            .map(|(name, place)| {
                format!("[[region]]\nname = \"{name}\"\nnearest = [{place}]\n[[pin]]\nregion = \"{name}\"\n{}", motion(angle))
            })
            .concat()
    };
    let turn = Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(Vector3::repeat(1.0)), TAU / 3.0);
    let still = run(&gutter(&format!("{}[statics]\nsteps = 5\n", pins("TAU/3*t"))));
    for (p, q) in still.end.iter().zip(&still.mesh.vertices) {
        assert!((p - turn * q).norm() < 1e-10, "{}", (p - turn * q).norm());
    }
    let elastic = still.last("membrane_energy_J") + still.last("bending_energy_J");
    assert!(elastic < 1e-12 * YOUNG * THICKNESS.powi(3), "{elastic:e}");
    // In 20 s, from rest and to rest: what is left is the quasi-static answer up to accelerations of 1e-3 m/s2.
    let slow = run(&gutter(&format!("{}[dynamics]\ndt = 1.0\nend = 20.0\n", pins("TAU/3*(1 - cos(PI*t/20))/2"))));
    let worst = slow.end.iter().zip(&slow.mesh.vertices).map(|(p, q)| (p - turn * q).norm()).fold(0.0, f64::max);
    println!("slow turn: worst distance {worst:e}");
    assert!(worst < 1e-6, "{worst:e}");
}

/// A free strip in large vibration that also flies and turns.
fn strip(dt: f64, end: f64, viscosity: &str) -> String {
    format!(
        "[mesh.rectangle]\nsize = [0.1, 0.04]\ncells = [8, 3]\njitter = 0.2\n[solver]\ntolerance = 1e-12\n\
         [shell]\nelement = \"linear\"\nthickness = {THICKNESS}\ndensity = {DENSITY}\nyoungs_modulus = {YOUNG:?}\npoissons_ratio = 0.3\nmass = \"lumped\"\n{viscosity}\
         [dynamics]\ndt = {dt:?}\nend = {end:?}\nvelocity = [\"0.1 - 5*y\", \"5*x\", \"0.3*cos(TAU*x/0.1) + 3*y\"]\n"
    )
}

#[test]
fn momentum_is_conserved_and_energy_never_rises() {
    let mut drifts = Vec::new();
    for dt in [2e-3, 1e-3] {
        let case = run(&strip(dt, 0.06, ""));
        let masses = masses(&case);
        let states: Vec<_> = case.states().iter().map(|s| (points(s, "position"), points(s, "velocity"))).collect();
        let spin = |x: &[Vector3<f64>], v: &[Vector3<f64>]| -> Vector3<f64> {
            masses.iter().zip(x).zip(v).map(|((m, x), v)| *m * x.cross(v)).sum()
        };
        let first = total(&masses, &states[0].1);
        let scale: f64 = states[0].1.iter().zip(&masses).map(|(v, m)| m * v.norm()).sum();
        assert!(first.norm() > 0.1 * scale);
        for pair in states.windows(2) {
            let ((x0, v0), (x1, v1)) = (&pair[0], &pair[1]);
            assert!((total(&masses, v1) - first).norm() < 1e-9 * scale);
            // Forces at x1 have no moment, so L1 - L0 = (x1 - x0) x M v0: the whole drift of angular momentum is the integrator's.
            let moved: Vec<Vector3<f64>> = x1.iter().zip(x0).map(|(a, b)| a - b).collect();
            let unexplained = spin(x1, v1) - spin(x0, v0) - spin(&moved, v0);
            assert!(unexplained.norm() < 1e-9 * scale * 0.1, "{:e}", unexplained.norm() / scale);
        }
        let (last, start) = (states.last().unwrap(), &states[0]);
        drifts.push((spin(&last.0, &last.1) - spin(&start.0, &start.1)).norm() / spin(&start.0, &start.1).norm());
        never_rises(&energy(&case));
    }
    println!("drift of angular momentum {drifts:?}");
    assert!(drifts[1] > 0.0 && rate(&drifts) > 0.7, "{drifts:?}");
}

fn energy(case: &Case) -> Vec<f64> {
    let [k, m, b] = ["kinetic_energy_J", "membrane_energy_J", "bending_energy_J"].map(|name| case.column(name));
    (0..k.len()).map(|i| k[i] + m[i] + b[i]).collect()
}

fn never_rises(energy: &[f64]) {
    assert!(energy.windows(2).all(|e| e[1] <= e[0] * (1.0 + 1e-10)), "{energy:?}");
    assert!(energy[energy.len() - 1] < energy[0]);
}

#[test]
fn viscosity_dissipates() {
    let energies: Vec<f64> = ["", "viscosity = 0.002\n", "viscosity = 0.01\n"]
        .iter()
        .map(|viscosity| {
            let energy = energy(&run(&strip(5e-4, 0.04, viscosity)));
            never_rises(&energy);
            energy[energy.len() - 1]
        })
        .collect();
    println!("energies at the end without, with little, with more viscosity: {energies:?}");
    assert!(energies[1] < 0.97 * energies[0] && energies[2] < energies[1], "{energies:?}");
}

/// Errors at a time against the extrapolation of two finer runs halve with the step.
#[test]
fn implicit_euler_is_of_first_order() {
    let ends: Vec<Vec<Vector3<f64>>> = (0..5).map(|k| run(&strip(1e-3 / f64::from(1 << k), 0.02, "")).end).collect();
    let reference: Vec<Vector3<f64>> = ends[4].iter().zip(&ends[3]).map(|(fine, coarse)| 2.0 * fine - coarse).collect();
    let errors: Vec<f64> =
        ends[..3].iter().map(|end| end.iter().zip(&reference).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)).collect();
    println!("errors in time {errors:?} rate {}", rate(&errors));
    assert!((0.8..1.2).contains(&rate(&errors)) && errors[0] > 1e-5, "{errors:?}");
}

/// One vertex with one free component is an oscillator `m x'' + k (x + eta x') = 0`: implicit Euler's recurrence to all digits that a small
/// amplitude leaves, with `k/m` from the motion without viscosity.
#[test]
fn viscosity_is_that_of_kelvin_and_voigt() {
    let (dt, speed) = (1e-4, 1e-6);
    let motion = |viscosity: &str| -> Vec<f64> {
        let case = run(&format!(
            "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [2, 2]\n[[region]]\nname = \"middle\"\nnearest = [0.05, 0.05, 0.0]\n[solver]\ntolerance = 1e-13\n\
             [shell]\nelement = \"linear\"\nthickness = 1e-3\ndensity = 1000.0\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\nmass = \"lumped\"\n{viscosity}\
             [[pin]]\nregion = \"boundary\"\n[[pin]]\nregion = \"middle\"\ncomponents = [\"y\", \"z\"]\n[dynamics]\ndt = {dt:?}\nend = 0.002\nvelocity = [{speed:?}, 0, 0]\n"
        ));
        let middle = case.mesh.region_nearest(Vector3::new(0.05, 0.05, 0.0)).vertices[0];
        case.states().iter().map(|s| points(s, "position")[middle].x - 0.05).collect()
    };
    let free = motion("");
    let kappa = dt * speed / free[1] - 1.0;
    assert!(kappa > 0.01, "{kappa}");
    for eta in [0.0, 2e-4, 3e-3] {
        let now = if eta == 0.0 { free.clone() } else { motion(&format!("viscosity = {eta:?}\n")) };
        let (mut before, mut at, damping) = (-dt * speed, 0.0, kappa * eta / dt);
        let largest = now.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for x in &now[1..] {
            let next = (2.0 * at - before + damping * at) / (1.0 + kappa + damping);
            assert!((x - next).abs() < 1e-5 * largest, "eta {eta}: {x:e} {next:e}");
            (before, at) = (at, next);
        }
    }
}

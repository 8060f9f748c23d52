//! Supports: clamps, hinges, symmetry planes, moved pins, and structures that are not held.

use crate::physics_case::{points, rate, run, try_run};
use nalgebra::Vector3;
use thinshell::Error;

const G: f64 = 9.80665;

/// Droop and x of the tip of a strip of length 1 clamped at x = 0 under its own weight; `sides` adds to the scene.
fn cantilever(gamma: f64, cells: [usize; 2], nu: f64, sides: &str) -> [f64; 2] {
    let h = 0.002;
    // Gamma = rho h g L^3 / D; the plate between two planes of symmetry has D = E h^3 / (12 (1 - nu^2)).
    let young = 12.0 * 1000.0 * G * (1.0 - nu * nu) / (gamma * h * h);
    let case = run(&format!(
        "[mesh.rectangle]\nsize = [1.0, 0.1]\ncells = {cells:?}\n[shell]\nelement = \"linear\"\nthickness = {h}\ndensity = 1000.0\nyoungs_modulus = {young:?}\npoissons_ratio = {nu:?}\n\
         [gravity]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n{sides}[statics]\nsteps = 4\n"
    ));
    let tip = &case.mesh.regions["right"].vertices;
    let mean = tip.iter().map(|v| case.end[*v]).sum::<Vector3<f64>>() / tip.len() as f64;
    [-mean.z, mean.x]
}

fn elastica() -> Vec<[f64; 3]> {
    let reference: toml::Table = include_str!("../../data/reference/nonlinear_shells.toml").parse().unwrap();
    let number = |v: &toml::Value| v.as_float().or(v.as_integer().map(|i| i as f64)).unwrap();
    let rows = reference["heavy_elastica"]["rows"].as_array().unwrap();
    rows.iter().map(|row| std::array::from_fn(|i| number(&row[i]))).collect()
}

#[test]
fn clamped_strip_is_the_heavy_elastica() {
    for [gamma, droop, x] in &elastica()[..3] {
        let errors: Vec<f64> = [8, 16, 32]
            .map(|n| {
                let [z, along] = cantilever(*gamma, [n, n / 8], 0.0, "");
                (z - droop).hypot(along - x)
            })
            .into();
        println!("elastica {gamma}: {errors:?} rate {}", rate(&errors));
        assert!(errors[2] < 0.002 && rate(&errors) > 1.7, "Gamma {gamma}: {errors:?}");
    }
}

/// Between two planes of symmetry a strip cannot curl across: it is a plate, stiffer by `1 / (1 - nu^2)`.
#[test]
fn a_plate_is_stiffer_than_a_beam() {
    let [gamma, droop, _] = elastica()[1];
    let side = |name: &str| format!("[[pin]]\nregion = \"{name}\"\ncomponents = [\"y\"]\ndirector = {{ symmetry = [0.0, 1.0, 0.0] }}\n");
    let [plate, _] = cantilever(gamma, [32, 3], 0.4, &(side("top") + &side("bottom")));
    let [free, _] = cantilever(gamma, [32, 3], 0.4, "");
    println!("plate {plate}, free sides {free}, elastica {droop}");
    assert!((plate / droop - 1.0).abs() < 0.005, "{plate} {droop}");
    assert!(free > 1.05 * plate, "{free} {plate}");
}

#[test]
fn half_a_problem_with_a_plane_of_symmetry_is_the_whole() {
    let scene = |size: f64, cells: usize, right: &str| {
        format!(
            "[mesh.rectangle]\nsize = [{size}, 0.06]\ncells = [{cells}, 4]\npattern = \"criss-cross\"\n[solver]\ntolerance = 1e-11\n\
             [shell]\nelement = \"linear\"\nthickness = 1e-3\ndensity = 1000.0\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n[gravity]\n\
             [[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[[pin]]\nregion = \"right\"\n{right}[statics]\nsteps = 6\n"
        )
    };
    let whole = run(&scene(0.2, 16, "director = \"clamped\"\n"));
    let half = run(&scene(0.1, 8, "components = [\"x\"]\ndirector = { symmetry = [1.0, 0.0, 0.0] }\n"));
    let sag = -whole.displacement(0.1, 0.03, 0.0).z;
    let worst = half.mesh.vertices.iter().zip(&half.end).map(|(p, q)| (whole.vertex(p.x, p.y, p.z).1 - q).norm()).fold(0.0, f64::max);
    println!("sag {sag:e}, half against whole {worst:e}");
    assert!(sag > 1e-3 && worst < 1e-7 * sag, "{sag} {worst}");
}

/// Small deflections of beams: hinges are free to turn, clamps are not.
#[test]
fn a_hinge_is_free_and_a_clamp_is_not() {
    let (h, young, rho) = (2e-3, 1e9, 1.0);
    let unit = rho * h * G / (young * h * h * h / 12.0);
    for (director, exact) in [("", 5.0 / 384.0), ("director = \"clamped\"\n", 1.0 / 384.0)] {
        let errors: Vec<f64> = [1, 2, 4].map(|n| {
        let case = run(&format!(
            "[mesh.rectangle]\nsize = [1.0, 0.1]\ncells = [{}, {}]\n[shell]\nelement = \"linear\"\nthickness = {h}\ndensity = {rho:?}\nyoungs_modulus = {young:?}\npoissons_ratio = 0.0\n[gravity]\n\
             [[pin]]\nregion = \"left\"\n{director}[[pin]]\nregion = \"right\"\ncomponents = [\"y\", \"z\"]\n{director}[statics]\nsteps = 1\n", 10 * n, 2 * n
        ));
        let middle: Vec<f64> = case.mesh.vertices.iter().zip(&case.end).filter(|(p, _)| (p.x - 0.5).abs() < 1e-9).map(|(_, q)| -q.z).collect();
        (middle.iter().sum::<f64>() / middle.len() as f64 / (exact * unit) - 1.0).abs()
        }).into();
        println!("beam {director:?}: {errors:?} rate {}", rate(&errors));
        assert!(errors[2] < 0.01 && rate(&errors) > 1.7, "{director} {errors:?}");
    }
}

#[test]
fn moved_pins_are_where_they_are_told() {
    for (when, x, z) in [
        ("[statics]\nsteps = 5\n", "-0.03*t*(1 + 2*y)", "0.02*sin(2*t)"),
        ("[dynamics]\ndt = 0.01\nend = 0.2\n", "0.1*t^2", "0.01*sin(20*t) + y*t"),
    ] {
        let case = run(&format!(
            "[mesh.rectangle]\nsize = [0.2, 0.05]\ncells = [10, 3]\n[shell]\nelement = \"linear\"\nthickness = 1e-3\ndensity = 500.0\nyoungs_modulus = 1e7\npoissons_ratio = 0.3\n\
             [[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[[pin]]\nregion = \"right\"\n[pin.motion]\nx = \"{x}\"\nz = \"{z}\"\n{when}"
        ));
        let dynamics = when.contains("dynamics");
        for state in case.states() {
            let t: f64 = state.time;
            let now = points(&state, "position");
            for v in &case.mesh.regions["right"].vertices {
                let p = case.mesh.vertices[*v];
                let d = if dynamics {
                    Vector3::new(0.1 * t * t, 0.0, 0.01 * (20.0 * t).sin() + p.y * t)
                } else {
                    Vector3::new(-0.03 * t * (1.0 + 2.0 * p.y), 0.0, 0.02 * (2.0 * t).sin())
                };
                assert!((now[*v] - p - d).norm() < 1e-15, "t {t}: {:e}", (now[*v] - p - d).norm());
            }
            for v in &case.mesh.regions["left"].vertices {
                assert_eq!(now[*v], case.mesh.vertices[*v]);
            }
        }
        let bending = case.last("bending_energy_J");
        assert!(bending > 1e-6 * 1e7 * 1e-9, "{bending:e}");
    }
}

/// The message of a run that must fail for being a mechanism.
fn mechanism(scene: &str) -> String {
    match try_run(scene) {
        Err(e @ Error::Numerical { .. }) => {
            assert_eq!(e.exit_code(), 3);
            let Error::Numerical { message, help } = e else { unreachable!() };
            format!("{message}; {}", help.unwrap_or_default())
        }
        Err(e) => panic!("{e}\n{scene}"),
        Ok(case) => panic!("ran to its end with {} factorisations\n{scene}", case.last("factorizations")),
    }
}

#[test]
fn statics_of_what_is_not_held_is_refused() {
    for director in ["average", "free-sin", "free-tan"] {
        for (cells, h, jitter) in [("[4, 3]", 1e-3, 0.0), ("[16, 5]", 1e-5, 0.0), ("[16, 5]", 1e-3, 0.2), ("[35, 7]", 1e-4, 0.25)] {
            for pins in
                ["", "[[region]]\nname = \"c\"\nnearest = [0.0, 0.0, 0.0]\n[[pin]]\nregion = \"c\"\n", "[[pin]]\nregion = \"left\"\n"]
            {
                let message = mechanism(&format!(
                    "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = {cells}\njitter = {jitter:?}\n[shell]\nelement = \"linear\"\ndirector = \"{director}\"\nthickness = {h:?}\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
                     {pins}[rest.pullback]\nbbar = [10, 0, 0]\n[statics]\nsteps = 3\n"
                ));
                assert!(
                    message.contains("mechanism")
                        && (message.contains("coordinate") || message.contains("director"))
                        && message.contains("pins"),
                    "{message}"
                );
            }
        }
    }
}

//! Dynamic relaxation against Newton's method, without any factorisation.

use super::pipeline_support::{STATIC, Sandbox, with};
use crate::physics_case::{Case, run};

fn distance(a: &Case, b: &Case) -> f64 {
    a.end.iter().zip(&b.end).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

/// Runs a scene both ways; returns the distance of the results and the largest displacement, and checks what the work was.
fn compare(scene: &str, relaxation: &str) -> [f64; 2] {
    let newton = run(&format!("{scene}[statics]\nsteps = 2\n"));
    let relaxed = run(&format!("{scene}[statics]\nsteps = 2\nmethod = \"dynamic-relaxation\"\n{relaxation}"));
    assert_eq!(relaxed.last("factorizations") + relaxed.last("newton_iterations") + relaxed.last("fallback_iterations"), 0.0);
    let moved = newton.end.iter().zip(&newton.mesh.vertices).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    println!("{} iterations, distance {:e} of {moved:e}", relaxed.last("relaxation_iterations"), distance(&newton, &relaxed));
    [distance(&newton, &relaxed), moved]
}

#[test]
fn a_strip_rolls_up_as_by_newtons_method() {
    for (element, cells, thickness) in [("linear", "[8, 2]", 2e-3), ("quadratic", "[4, 1]", 4e-3)] {
        let scene = format!(
            "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = {cells}\njitter = 0.2\n[shell]\nelement = \"{element}\"\nthickness = {thickness:?}\n\
             youngs_modulus = 1e9\npoissons_ratio = 0.3\n[rest.pullback]\nbbar = [\"PI / 0.1\", 0, 0]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n"
        );
        let [distance, moved] = compare(&scene, "");
        assert!(moved > 0.05 && distance < 1e-5 * moved, "{element}: {distance:e} of {moved:e}");
    }
}

#[test]
fn a_plate_under_pressure_bulges_as_by_newtons_method() {
    let scene = "[mesh.rectangle]\nsize = [0.1, 0.08]\ncells = [5, 4]\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
                 [[pressure]]\npressure = 2e4\n[[pin]]\nregion = \"boundary\"\n";
    // More than its thickness: mostly by stretching.
    let [distance, moved] = compare(scene, "");
    assert!(moved > 1e-3 && distance < 1e-5 * moved, "{distance:e} of {moved:e}");
    // A smaller tolerance brings it nearer.
    let [nearer, _] = compare(scene, "relaxation = { tolerance = 1e-10 }\n");
    assert!(nearer < 1e-7 * moved, "{nearer:e}");
}

#[test]
fn it_resumes_tells_its_iterations_and_gives_up() {
    let scene = with(STATIC, "steps = 8", "steps = 4\nmethod = \"dynamic-relaxation\"");
    let (whole, parts) = (Sandbox::new(&scene).prepared(), Sandbox::new(&scene).prepared());
    whole.ok(&["run", "scene.toml"]);
    for piece in ["1", "2"] {
        parts.ok(&["run", "scene.toml", "--stop-after", piece]);
    }
    parts.ok(&["run", "scene.toml"]);
    assert!(whole.result() == parts.result());
    assert!(whole.history()[0].ends_with(",relaxation_iterations"));
    let plain = Sandbox::new(STATIC).prepared();
    plain.ok(&["run", "scene.toml"]);
    assert!(!plain.history()[0].contains("relax"));
    let short = with(&scene, "steps = 4", "steps = 4\nrelaxation = { max_iterations = 50 }") + "[solver]\nmax_halvings = 2\n";
    let message = Sandbox::new(&short).prepared().fails(3, &["run", "scene.toml"]);
    assert!(message.contains("dynamic relaxation was still") && message.contains("after 50 iterations"), "{message}");
}

#[test]
fn nothing_to_do_takes_one_iteration() {
    let scene = "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = [4, 2]\n[shell]\nelement = \"linear\"\nthickness = 1e-3\nyoungs_modulus = 1e9\n\
                 poissons_ratio = 0.3\n[[pin]]\nregion = \"left\"\n[statics]\nsteps = 1\nmethod = \"dynamic-relaxation\"\n";
    let case = run(scene);
    assert!(case.last("relaxation_iterations") <= 2.0, "{}", case.last("relaxation_iterations"));
}

#[test]
fn small_load_steps_are_not_taken_for_equilibria() {
    // At once after a step of the load its end alone moves, much faster than the strip as a whole will.
    let scene = "[mesh.rectangle]\nsize = [1.0, 0.1]\ncells = [4, 1]\n[[region]]\nname = \"tip\"\nnearest = [1, 0, 0]\n[shell]\nthickness = 4e-3\n\
                 youngs_modulus = 1e6\npoissons_ratio = 0\n[[force]]\nregion = \"tip\"\nforce = [0, 0, 1.3e-3]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n";
    let newton = run(&format!("{scene}[statics]\nsteps = 8\n"));
    let relaxed = run(&format!("{scene}[statics]\nsteps = 8\nmethod = \"dynamic-relaxation\"\nrelaxation = {{ tolerance = 1e-6 }}\n"));
    let moved = newton.end.iter().zip(&newton.mesh.vertices).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    let distance = distance(&newton, &relaxed);
    assert!(moved > 0.3 && distance < 1e-4 * moved, "{distance:e} of {moved:e}");
}

//! Steps chosen by their error, and what time integration keeps in checkpoints.

use super::pipeline_support::{DYNAMIC, Sandbox, with};
use crate::physics_case::{points, run};
use std::collections::BTreeSet;

const INTEGRATORS: [&str; 4] = [
    "integrator = \"bdf2\"\n",
    "integrator = \"generalised-alpha\"\nspectral_radius = 0.6\n",
    "integrator = \"generalised-alpha\"\nspectral_radius = 1\n",
    "integrator = \"implicit-euler\"\n",
];

/// A strip that is let go; its end swings down.
fn swing(dynamics: &str) -> String {
    format!(
        "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = [8, 2]\n[shell]\nelement = \"linear\"\nthickness = 1e-3\nyoungs_modulus = 2e6\n\
         poissons_ratio = 0.3\ndensity = 1000.0\nviscosity = 1e-3\n[gravity]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[dynamics]\nend = 0.2\n{dynamics}"
    )
}

/// Steps of a method of order `p` that each add an error of the tolerance are as long as its power `1 / (p + 1)`, and what they add in a second is
/// as its power `p / (p + 1)`. Output times are met whatever the first step is.
#[test]
fn errors_follow_the_tolerance() {
    let exact = run(&swing("dt = 2.5e-4\nintegrator = \"generalised-alpha\"\nspectral_radius = 1.0\n[output]\ninterval = 0.05\n")).end;
    for (integrator, order, tolerances, most) in
        [(INTEGRATORS[0], 2.0, [1e-3, 1e-5], 250), (INTEGRATORS[1], 2.0, [1e-3, 1e-5], 250), (INTEGRATORS[3], 1.0, [1e-3, 2e-4], 250)]
    {
        let mut errors = Vec::new();
        for tolerance in tolerances {
            for dt in [1e-3, 0.1] {
                let adaptive = format!("dt = {dt:?}\n{integrator}adaptive = {{ tolerance = {tolerance:?} }}\n[output]\ninterval = 0.05\n");
                let case = run(&swing(&adaptive));
                let times: Vec<f64> = case.states().iter().map(|s| (s.time * 1e6).round() / 1e6).collect();
                // The state before the last may still be there too.
                assert!([0.0, 0.05, 0.1, 0.15, 0.2].iter().all(|t| times.contains(t)), "{adaptive}{times:?}");
                assert!(case.column("local_error").iter().all(|e| *e <= tolerance && *e >= 0.0));
                let (steps, rejections) = (case.column("step").len(), case.column("rejections").iter().sum::<f64>());
                assert!(rejections < 0.3 * steps as f64 + 8.0 && (dt < 0.05 || rejections > 0.0), "{rejections} of {steps}");
                let error = case.end.iter().zip(&exact).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
                println!("{integrator}tolerance {tolerance:e}, dt {dt}: {steps} steps, {rejections} rejections, error {error:e}");
                assert!(steps < most);
                errors.push(error);
            }
        }
        let power = |coarse: f64, fine: f64| (coarse / fine).ln() / (tolerances[0] / tolerances[1]).ln();
        for power in [power(errors[0], errors[2]), power(errors[1], errors[3])] {
            assert!((power - order / (order + 1.0)).abs() < 0.06, "{integrator}{errors:?}: {power}");
        }
        assert!(errors[0].max(errors[1]) < 0.05, "{integrator}{errors:?}");
    }
}

/// Runs in one go and in pieces; returns the names in the newest checkpoint.
fn resumes(scene: &str, pieces: &[u64]) -> BTreeSet<String> {
    let (whole, parts) = (Sandbox::new(scene).prepared(), Sandbox::new(scene).prepared());
    whole.ok(&["run", "scene.toml"]);
    for piece in pieces {
        parts.ok(&["run", "scene.toml", "--stop-after", &piece.to_string()]);
    }
    parts.ok(&["run", "scene.toml"]);
    assert!(whole.result() == parts.result(), "resuming changes the result of\n{scene}");
    let file = hdf5::File::open(whole.case("run").join(whole.newest().0)).unwrap();
    file.group("fields").unwrap().datasets().unwrap().iter().map(|d| d.name().rsplit('/').next().unwrap().to_owned()).collect()
}

#[test]
fn every_integrator_resumes_and_keeps_what_it_needs() {
    let lagged = [
        "previous_position",
        "previous_velocity",
        "acceleration",
        "previous_acceleration",
        "previous_director",
        "previous_forms",
        "forms_before_previous",
    ];
    for (integrator, kept) in INTEGRATORS.iter().zip([
        &["previous_position", "previous_velocity"][..],
        &["acceleration", "previous_acceleration", "previous_director"],
        &["previous_director"],
        &[],
    ]) {
        for viscous in [true, false] {
            for adaptive in ["", "adaptive = { tolerance = 1e-3 }\n"] {
                let scene = with(DYNAMIC, "velocity =", &format!("{integrator}{adaptive}velocity ="));
                let scene = if viscous { scene } else { with(&scene, "viscosity = 0.01\n", "") };
                let found = resumes(&scene, &[1, 1, 3]);
                let mut expected: BTreeSet<&str> = kept.iter().copied().collect();
                let remembers = !kept.is_empty();
                expected.extend(["previous_forms", "forms_before_previous"].iter().filter(|_| viscous && remembers));
                expected.extend(["previous_velocity"].iter().filter(|_| !adaptive.is_empty() && remembers));
                let found: BTreeSet<&str> = found.iter().map(String::as_str).filter(|name| lagged.contains(name)).collect();
                assert_eq!(found, expected, "{integrator}{adaptive}");
            }
        }
    }
}

#[test]
fn steps_chosen_by_errors_leave_no_trace_where_they_are_not() {
    let adaptive = Sandbox::new(&with(DYNAMIC, "velocity =", "adaptive = { tolerance = 1e-2 }\nvelocity =")).prepared();
    let plain = Sandbox::new(DYNAMIC).prepared();
    for sandbox in [&adaptive, &plain] {
        sandbox.ok(&["run", "scene.toml"]);
    }
    let columns = |sandbox: &Sandbox| sandbox.history()[0].clone();
    assert!(columns(&adaptive).contains(",rejections,local_error"), "{}", columns(&adaptive));
    assert!(!columns(&plain).contains("rejections") && !columns(&plain).contains("local_error"));
}

#[test]
fn a_tolerance_that_cannot_be_met_is_told() {
    let scene = swing("dt = 0.1\nadaptive = { tolerance = 1e-9 }\n[solver]\nmax_halvings = 2\n");
    let sandbox = Sandbox::new(&scene).prepared();
    let message = sandbox.fails(3, &["run", "scene.toml"]);
    assert!(
        message.contains("times the error allowed at its smallest size") && message.contains("dynamics.adaptive.tolerance"),
        "{message}"
    );
    assert_eq!(sandbox.newest().0, "step_00000000.h5");
}

/// Nothing is left of the steps that were rejected.
#[test]
fn a_rejected_step_changes_nothing() {
    for integrator in INTEGRATORS {
        let rejected = run(&swing(&format!("dt = 0.05\n{integrator}adaptive = {{ tolerance = 3e-4, largest_dt = 5e-3 }}\n")));
        assert!(rejected.column("rejections")[0] > 0.0);
        // The same steps without any rejection.
        let first = rejected.column("dt_s")[0];
        let plain = run(&swing(&format!("dt = {first:?}\n{integrator}adaptive = {{ tolerance = 3e-4, largest_dt = 5e-3 }}\n")));
        assert_eq!(plain.column("rejections")[0], 0.0);
        let (a, b) = (rejected.states().swap_remove(1), plain.states().swap_remove(1));
        assert_eq!(points(&a, "position"), points(&b, "position"), "{integrator}");
        assert_eq!(points(&a, "director"), points(&b, "director"), "{integrator}");
    }
}

//! Random small scenes of everything that is allowed end in a solution that is one, or in an error that says why.

use super::pipeline_support::{Sandbox, text};
use proptest::prelude::*;

/// A power of ten, evenly by its exponent.
fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|e| 10f64.powf(e))
}

fn scene() -> impl Strategy<Value = String> {
    let mesh = prop_oneof![
        (decades(-4.0, 4.0), decades(-2.0, 2.0), 1..4usize, 1..4usize, 0.0..0.4f64).prop_map(|(l, a, n, m, j)| {
            (l, format!("[mesh.rectangle]\nsize = [{l:e}, {:e}]\ncells = [{n}, {m}]\njitter = {j:?}\n", l * a))
        }),
        (decades(-4.0, 4.0), 1..3usize).prop_map(|(l, n)| (l, format!("[mesh.disc]\nradius = {l:e}\nrings = {n}\n"))),
        (decades(-3.0, 3.0), 1.0..170.0f64)
            .prop_map(|(l, a)| (l, format!("[mesh.sphere-cap]\nradius = {l:e}\nhalf_angle = {a:?}\nrings = 2\n"))),
    ];
    let rest = prop_oneof![
        Just((0.0, String::new())),
        (-3.0..3.0f64, -3.0..3.0f64).prop_map(|(s, k)| (k, format!("[rest.isotropic]\ns = {s:?}\n"))),
        (decades(-6.0, 2.0), decades(-6.0, 2.0))
            .prop_map(|(p, m)| (0.0, format!("[rest.linear]\nm_plus = {p:e}\nm_minus = -{m:e}\nmu = 0.01\n"))),
    ];
    let time = prop_oneof![
        (1..4usize, any::<bool>()).prop_map(|(n, stable)| format!("[statics]\nsteps = {n}\nstable = {stable}\n")),
        (decades(-6.0, 2.0), decades(-6.0, 2.0), 0..9u32).prop_map(|(dt, v, seed)| {
            format!("[dynamics]\ndt = {dt:e}\nend = {:e}\nrandom_velocity = {{ speed = {v:e}, seed = {seed} }}\n", 3.0 * dt)
        }),
    ];
    let pins = prop_oneof![
        Just(""),
        Just("[[region]]\nname = \"one\"\nnearest = [0, 0, 0]\n[[pin]]\nregion = \"one\"\n"),
        Just("[[region]]\nname = \"some\"\nwhere = \"x <= 0.01 * y\"\n[[pin]]\nregion = \"some\"\ndirector = \"clamped\"\n"),
    ];
    let element = prop_oneof![Just("linear"), Just("quadratic")];
    let gravity = prop_oneof![Just(""), Just("[gravity]\n")];
    (mesh, rest, time, pins, element, gravity, decades(-6.0, -0.5), decades(3.0, 12.0), -0.95..0.4999f64).prop_map(
        |((l, mesh), (_, rest), time, pins, element, gravity, h, e, nu)| {
            // Regions come before their pins; a pin of no region is a fair mistake.
            format!(
                "{mesh}[shell]\nelement = \"{element}\"\nthickness = {:e}\nyoungs_modulus = {e:e}\npoissons_ratio = {nu:?}\ndensity = 1000.0\n\
                 {rest}{gravity}{pins}{time}[solver]\nmax_halvings = 2\n",
                h * l
            )
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, max_shrink_iters: 20, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_scenes_end_well(scene in scene()) {
        let sandbox = Sandbox::new(&scene);
        for verb in ["check", "mesh", "setup", "run"] {
            let output = sandbox.output(&[verb, "scene.toml", "-q"]);
            let (code, err) = (output.status.code(), text(&output.stderr));
            prop_assert!(!err.contains("panicked"), "{verb}: {err}\n{scene}");
            prop_assert!(matches!(code, Some(0 | 2)) || code == Some(3) && verb == "run", "{verb}: {code:?} {err}\n{scene}");
            prop_assert_eq!(err.matches("error: ").count(), usize::from(code != Some(0)), "{}\n{}", err, scene);
            if code != Some(0) {
                // What `check` accepts, meshes and sets up.
                prop_assert!(verb == "check" || verb == "run", "{verb}: {err}\n{scene}");
                return Ok(());
            }
        }
        let history = std::fs::read_to_string(sandbox.case("history.csv")).unwrap();
        let names: Vec<&str> = history.lines().next().unwrap().split(',').collect();
        for row in history.lines().skip(1) {
            for (name, value) in names.iter().zip(row.split(',')) {
                let value: f64 = value.parse().unwrap();
                prop_assert!(value.is_finite() || name.starts_with("lowest_eigenvalue"), "{name} {value}\n{scene}");
                let energy = *name == "membrane_energy_J" || *name == "kinetic_energy_J";
                prop_assert!(!energy || value >= 0.0, "{name} {value}\n{scene}");
            }
        }
    }
}

//! Stability matrices by the real program, and random velocities.

use super::pipeline_support::{DYNAMIC, Sandbox, with};
use serde_json::Value;
use std::path::Path;

/// A strip that grows by a tenth, with cells that end in all ways.
const GROWS: &str = r#"
[mesh.rectangle]
size = [0.06, 0.02]
cells = [3, 2]
[[region]]
name = "corner"
nearest = [0, 0, 0]
[shell]
thickness = 1e-3
youngs_modulus = 1e9
poissons_ratio = 0.3
[rest.orthotropic]
factors = [1.1, 1.1]
angle = 0
[[pin]]
region = "left"
components = ["x", "z"]
director = "clamped"
[[pin]]
region = "corner"
components = ["y"]
[statics]
steps = 2
[report.matrix]
most_factorizations = 20
measures = [{ name = "end", measure = { displacement = { at = [0.06, 0, 0], axis = "x" } }, least = 0.00599999, most = 0.00600001, source = "exact" }]
[[report.matrix.part]]
name = "modulus and thickness"
axes = [
    { key = "shell.youngs_modulus", values = [1e3, 1e12] },
    { key = "shell.thickness", values = [1e-3, 1e-7], with = [{ key = "statics.steps", values = [3, 1] }] },
]
[[report.matrix.part]]
name = "free"
set = ["pin=[]"]
ends = "refused"
[[report.matrix.part]]
name = "no scene"
ends = "refused"
axes = [{ key = "shell.poissons_ratio", values = [0.5, -1] }]
"#;

fn cells(sandbox: &Sandbox) -> Value {
    let found: Value = serde_json::from_str(&std::fs::read_to_string(sandbox.path("cases/matrix/matrix.json")).unwrap()).unwrap();
    assert_eq!(found["passed"], found["cells"].as_array().unwrap().iter().all(|cell| cell.get("faults").is_none()));
    found["cells"].clone()
}

#[test]
fn every_cell_ends_as_it_should() {
    let sandbox = Sandbox::new(GROWS);
    let (out, _) = sandbox.ok(&["report", "--matrix", "scene.toml", "--json", "copy.json"]);
    assert_eq!(sandbox.names("cases"), ["matrix"]);
    assert_eq!(sandbox.names("cases/matrix"), ["matrix.json", "matrix.md"]);
    let cells = cells(&sandbox);
    let cells = cells.as_array().unwrap();
    assert_eq!(cells.len(), 7);
    for (cell, (modulus, thickness)) in cells.iter().zip([(1e3, 1e-3), (1e3, 1e-7), (1e12, 1e-3), (1e12, 1e-7)]) {
        let solution = &cell["solution"];
        assert_eq!(cell["values"][0][0], "shell.youngs_modulus");
        assert_eq!((cell["values"][0][1].as_f64(), cell["values"][1][1].as_f64()), (Some(modulus), Some(thickness)));
        // The tied key changes along.
        assert_eq!(solution["steps"], if thickness == 1e-3 { 3 } else { 1 }, "{cell}");
        assert!((solution["measures"][0][1].as_f64().unwrap() - 0.006).abs() < 1e-8, "{cell}");
        let number = |name: &str| solution[name].as_f64().unwrap();
        // The flat state has the energy of the whole growth, the end none.
        assert!((number("gain") + 1.0).abs() < 1e-9 && number("energy") < 1e-15 && number("residual") < 1e-6, "{cell}");
        assert!(number("factorizations") > 0.0 && number("median_iterations") > 0.0 && number("faces") == 12.0, "{cell}");
    }
    assert!(cells[4]["exit"] == 3 && cells[4]["message"].as_str().unwrap().contains("mechanism"), "{}", cells[4]);
    for cell in &cells[5..] {
        assert!(cell["exit"] == 2 && cell["message"].as_str().unwrap().contains("must be > -1 and < 0.5"), "{cell}");
    }
    assert!(out.contains("7 cells: 4 converged, 3 refused, 0 with faults."), "{out}");
    sandbox.ok(&["report", "--matrix", "scene.toml", "--every", "3", "-q"]);
    assert_eq!(self::cells(&sandbox).as_array().unwrap().len(), 2 + 1 + 1);
}

#[test]
fn what_is_wrong_with_a_cell_is_told() {
    for (from, to, expected, faults) in [
        ("least = 0.00599999, most = 0.00600001", "most = 0.005", "end 0.006 is more than 0.005", 4),
        ("most_factorizations = 20", "most_factorizations = 1", "factorisations", 4),
        ("[report.matrix]\n", "[report.matrix]\nmost_seconds = 1e-9\n", "did not end within", 7),
        ("ends = \"refused\"\n[[", "[[", "ended with exit code 3: the structure is a mechanism", 1),
        ("set = [\"pin=[]\"]\n", "", "ended in a solution", 1),
    ] {
        let sandbox = Sandbox::new(&with(GROWS, from, to));
        let message = sandbox.fails(1, &["report", "--matrix", "scene.toml", "-q"]);
        // A cell that is refused at once may be faster than any clock.
        let all = faults == 7 && message.contains("cells of the matrix with faults: 6 of 7");
        assert!(all || message.contains(&format!("cells of the matrix with faults: {faults} of 7")), "{message}");
        let bad: Vec<Value> = cells(&sandbox).as_array().unwrap().iter().filter(|c| c.get("faults").is_some()).cloned().collect();
        assert!(bad.iter().all(|cell| cell["faults"][0].as_str().unwrap().contains(expected)), "{bad:?}");
        assert!(std::fs::read_to_string(sandbox.path("cases/matrix/matrix.md")).unwrap().contains("**no**"));
    }
    let sandbox = Sandbox::new(DYNAMIC);
    assert!(sandbox.fails(2, &["report", "--matrix", "scene.toml"]).contains("report.matrix: scene.toml has no such table"));
    assert_eq!(sandbox.output(&["report", "--every", "2", "scene.toml"]).status.code(), Some(2));
}

/// A free sheet with random velocities: what they are, and what the balance of its motion knows.
#[test]
fn random_velocities_are_those_of_their_seed() {
    let free = "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [3, 3]\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\ndensity = 1000.0\n\
        [gravity]\n[dynamics]\ndt = 1e-3\nend = 0.005\nrandom_velocity = { speed = 2.0, seed = 3 }\n\
        [report.matrix]\nmost_iterations = 8\n[[report.matrix.part]]\nname = \"speed\"\naxes = [{ key = \"dynamics.random_velocity.speed\", values = [1e-3, 10.0] }]\n";
    let velocities = |scene: &str| {
        let sandbox = Sandbox::new(scene).prepared();
        let file = hdf5::File::open(sandbox.case("setup.h5")).unwrap();
        let name = "fields/velocity";
        file.dataset(name).unwrap().read_raw::<f64>().unwrap()
    };
    let first = velocities(free);
    let speeds: Vec<f64> = first.chunks_exact(3).map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt()).collect();
    let fastest = speeds.iter().fold(0.0f64, |m, v| m.max(*v));
    assert!(speeds.len() == 16 + 33 && fastest <= 2.0 && fastest > 1.6, "{fastest}");
    assert_eq!(first, velocities(free));
    assert_ne!(first, velocities(&with(free, "seed = 3", "seed = 4")));
    assert!(velocities(&with(free, "random_velocity = { speed = 2.0, seed = 3 }\n", "")).iter().all(|v| *v == 0.0));
    // Supports take the velocity of what they hold, and nothing else.
    let held = velocities(&format!("{free}[[pin]]\nregion = \"left\"\ncomponents = [\"y\"]\n"));
    let changed: Vec<usize> = (0..first.len()).filter(|i| held[*i] != first[*i]).collect();
    assert!(changed.len() == 4 + 3 && changed.iter().all(|i| i % 3 == 1 && held[*i] == 0.0), "{changed:?}");

    let sandbox = Sandbox::new(free);
    sandbox.ok(&["report", "--matrix", "scene.toml", "-q"]);
    for cell in cells(&sandbox).as_array().unwrap() {
        let number = |name: &str| cell["solution"][name].as_f64().unwrap();
        assert!(number("momentum") < 1e-9 && number("gain") <= 1e-9 && number("lost") > 0.0, "{cell}");
    }
}

/// A sample of all cells; `make stress` runs them all.
#[test]
fn the_stress_scenes_pass() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/stress");
    let scenes: Vec<String> = super::pipeline_support::names(&folder).iter().map(|name| folder.join(name).display().to_string()).collect();
    assert!(scenes.len() >= 7);
    let sandbox = Sandbox::new(GROWS);
    let list: Vec<&str> = scenes.iter().map(String::as_str).collect();
    sandbox.ok(&[&["report", "--every", "24", "-q", "--matrix"][..], &list].concat());
    let cells = cells(&sandbox);
    assert!(cells.as_array().unwrap().len() >= 25);
}

/// Needles 5000 times as long as wide: the round-off of the matrix is larger than the stiffness of their softest movements, that of strains is not.
#[test]
fn a_strip_with_needles_grows_as_any_other() {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/stress/sliver_row.obj");
    let sandbox = Sandbox::new(&format!(
        r#"
[mesh.file]
path = {mesh:?}
[[region]]
name = "center"
nearest = [0.05, 0.01, 0]
[[region]]
name = "center-edge"
nearest = [0.05, 0, 0]
[[region]]
name = "ahead"
nearest = [0.0625, 0.01, 0]
[shell]
thickness = 1e-2
youngs_modulus = 1e9
poissons_ratio = 0.3
[rest.orthotropic]
factors = [2, 0.5]
angle = 0
[[pin]]
region = "center"
[[pin]]
region = "center-edge"
components = ["x", "z"]
[[pin]]
region = "ahead"
components = ["z"]
[statics]
steps = 3
[report.matrix]
most_factorizations = 25
measures = [{{ name = "length", measure = {{ distance-between = {{ a = [0, 0, 0], b = [0.1, 0, 0] }} }}, least = 0.1999999, most = 0.2000001, source = "exact" }}]
[[report.matrix.part]]
name = "grown"
axes = [{{ key = "shell.thickness", values = [1e-2, 1e-4] }}]
"#
    ));
    sandbox.ok(&["report", "--matrix", "scene.toml"]);
    assert!(cells(&sandbox).as_array().unwrap().iter().all(|cell| cell["exit"] == 0));
}

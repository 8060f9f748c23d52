//! Surfaces on grids through the real program: every verb, resuming, what is absent, what is refused.

use super::pipeline_support::{Sandbox, text, with};
use std::fs;

/// A cloth in a stream that comes down on a table: all that a step carries on to the next.
const CLOTH: &str = r#"
title = "cloth"
model = "cosserat"
[mesh.grid]
nodes = [6, 5]
size = [1.0, 0.8]
position = ["x", "y", "0.05 + 0.02 * x * y"]
[[region]]
name = "corner"
nearest = [0, 0, 0.05]
[cosserat]
eta = [3.0, 2.5, 3.5]
xi = 1e-3
phi = 1e-2
mass = 0.1
damping = 0.05
[cosserat.stream]
velocity = [1.0, 0.3, 0]
factor = "1 + t"
[cosserat.table]
centre = [0.7, 0.4, 0]
radius = 0.4
[[cosserat.normal-force]]
region = "corner"
force = 0.01
factor = "cos(9 * t)"
[gravity]
[[pin]]
region = "corner"
motion = { z = "0.05 * sin(8 * t)" }
[dynamics]
dt = 0.01
end = 0.14
velocity = [0, "0.1 * x", 0]
"#;

fn strong(scene: &str) -> String {
    with(scene, "[cosserat]\n", "[cosserat]\nscheme = \"strong-form\"\n")
}

fn column(sandbox: &Sandbox, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(sandbox.case("history.csv")).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|n| n == name).unwrap_or_else(|| panic!("no column {name}"));
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

#[test]
fn all_verbs() {
    for scene in [CLOTH.to_owned(), strong(CLOTH)] {
        let expect = "[[report.expect]]\nname = \"settles\"\nmeasure = { field = { name = \"stuck\", statistic = \"max\" } }\nreference = 1\n\
                      tolerance = 0\nsource = \"the cloth falls 0.05 m in 0.1 s\"\n";
        let sandbox = Sandbox::new(&format!("{scene}{expect}"));
        let (out, _) = sandbox.ok(&["check", "scene.toml"]);
        assert!(out.contains("grid, 6 x 5 nodes") && out.contains("unknowns  87 free, 3 held"), "{out}");
        let (out, _) = sandbox.ok(&["all", "scene.toml"]);
        assert!(out.contains("settles"), "{out}");
        assert_eq!(out.contains("factored by LU"), scene.contains("strong-form"), "{out}");
        assert!(column(&sandbox, "stuck_nodes").iter().any(|n| *n > 0.0));
        let frame = text(&fs::read(sandbox.case("vtk/step_00000014.vtp")).unwrap());
        // Twenty quadrangles.
        assert!(frame.contains("NumberOfPolys=\"20\""), "{}", &frame[..600]);
        for name in ["displacement", "velocity", "stuck", "mean_curvature", "gauss_curvature", "strain", "material_coordinates"] {
            assert!(frame.contains(&format!("Name=\"{name}\"")), "{name}");
        }
        sandbox.ok(&["status", "scene.toml"]);
        let (_, err) = sandbox.ok(&["all", "scene.toml"]);
        assert!(!err.contains("Newton iterations"), "nothing is out of date: {err}");
    }
}

#[test]
fn resumed_runs_are_the_same_bits() {
    for scene in [CLOTH.to_owned(), strong(CLOTH), with(&strong(CLOTH), "phi", "border = \"symmetric\"\nphi")] {
        let whole = Sandbox::new(&scene).prepared();
        whole.ok(&["run", "scene.toml"]);
        let parts = Sandbox::new(&scene).prepared();
        for piece in ["1", "4", "6"] {
            parts.ok(&["run", "scene.toml", "--stop-after", piece]);
        }
        parts.ok(&["run", "scene.toml"]);
        assert!(whole.result() == parts.result());
    }
}

#[test]
fn absent_parts_leave_no_trace() {
    let bare = "model = \"cosserat\"\n[mesh.grid]\nnodes = [4, 3]\nsize = [1, 1]\n[cosserat]\neta = 1\nxi = 1e-3\n\
                [[pin]]\nregion = \"left\"\n[[pin]]\nregion = \"right\"\n[statics]\nsteps = 1\n";
    let sandbox = Sandbox::new(bare);
    sandbox.ok(&["all", "scene.toml"]);
    let header = fs::read_to_string(sandbox.case("history.csv")).unwrap();
    for name in ["stuck", "coupling", "kinetic", "gravity", "matrices"] {
        assert!(!header.contains(name), "{name}");
    }
    let file = hdf5::File::open(sandbox.case("run").join(sandbox.newest().0)).unwrap();
    let fields = file.group("fields").unwrap().member_names().unwrap();
    assert_eq!(fields, ["position"]);
    let setup = hdf5::File::open(sandbox.case("setup.h5")).unwrap().member_names().unwrap().join(" ");
    assert!(!setup.contains("material") && !setup.contains("forms"), "{setup}");
    // And a shell has nothing of a grid.
    let record = fs::read_to_string(sandbox.case("case.toml")).unwrap();
    assert!(record.contains("[cosserat]") && !record.contains("[shell]"), "{record}");
}

/// With coordinates that count nodes another grid is another surface; the other model's constants hold on any.
#[test]
fn only_one_model_is_the_same_on_two_grids() {
    let scene = |model: &str, n: usize| {
        format!(
            "model = \"{model}\"\n[mesh.grid]\nnodes = [{n}, {n}]\nsize = [1, 1]\n[cosserat]\neta = 10\nxi = 1e-2\nmass = 1\n[gravity]\n\
             [[pin]]\nregion = \"left\"\n[[pin]]\nregion = \"right\"\n[statics]\nsteps = 2\n[[report.expect]]\nname = \"sag\"\n\
             measure = {{ displacement = {{ at = [0.5, 0.5, 0], axis = \"z\" }} }}\nreference = 0\ntolerance = 10\nsource = \"none\"\n"
        )
    };
    let sag = |model: &str, n: usize| {
        let sandbox = Sandbox::new(&scene(model, n));
        sandbox.ok(&["all", "scene.toml", "-q"]);
        let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(sandbox.case("report.json")).unwrap()).unwrap();
        report["expectations"][0]["value"].as_f64().unwrap_or_else(|| panic!("{report}"))
    };
    let [a, b, c] = [5, 9, 17].map(|n| sag("cosserat", n));
    assert!(a < -0.05 && (b - c).abs() < 0.5 * (a - b).abs() && (b - c).abs() < 0.02 * c.abs(), "{a} {b} {c}");
    let [a, b] = [5, 9].map(|n| sag("terzopoulos", n));
    assert!((a - b).abs() > 0.2 * a.abs(), "{a} {b}");
}

#[test]
fn what_blows_up_is_said_and_the_last_state_kept() {
    let scene = with(&strong(CLOTH), "dt = 0.01\nend = 0.14", "dt = 0.1\nend = 1000.0");
    let scene = with(&scene, "[[pin]]", "[solver]\nmax_halvings = 0\n[[pin]]");
    let scene = with(&scene, "[gravity]\n", "");
    let scene = with(&with(&scene, "xi = 1e-3", "xi = 1e-1"), "phi = 1e-2", "phi = 1e-1");
    let sandbox = Sandbox::new(&scene).prepared();
    let err = sandbox.fails(3, &["run", "scene.toml"]);
    assert!(err.contains("blown up") || err.contains("matrix of the step"), "{err}");
    assert!(!sandbox.newest().1.is_empty());
}

#[test]
fn wrong_scenes() {
    for (from, to, message) in [
        ("phi = 1e-2", "phi = 0.2", "cosserat.phi = 0.2: makes the energy indefinite: phi^2 = 4"),
        ("phi = 1e-2", "phi = [0, 0.1, 0]", "must be below 4 eta xi = 4 x 2.5 x 0.001 = 1e-2 (component 12)"),
        ("phi = 1e-2", "mixed_terms = true\nphi = [0.108, 0, -0.117]", "phi^2 < 4 eta xi in each component does not suffice (phi = [0.108"),
        ("eta = [3.0, 2.5, 3.5]", "eta = [3.0, 0, 3.5]", "cosserat.eta.1 = 0: must be > 0 [N/m]"),
        ("xi = 1e-3", "xi = \"thin\"", "expected a number or three numbers"),
        ("xi = 1e-3\n", "", "cosserat.xi: this key is missing"),
        ("mass = 0.1\n", "", "cosserat.mass: this key is missing, and [dynamics] needs it [kg]"),
        ("nodes = [6, 5]", "nodes = [2, 5]", "mesh.grid.nodes.0 = 2: must be 3 to 3000"),
        ("size = [1.0, 0.8]", "size = [1.0, 0.0]", "mesh.grid.size.1 = 0.0: must be > 0 [m]"),
        ("\"0.05 + 0.02 * x * y\"", "\"1 / (x - 0.2)\"", "mesh.grid.position.2 = \"1 / (x - 0.2)\": is inf at node (1, 0)"),
        ("position = [\"x\", \"y\"", "position = [\"x\", \"x\"", "mesh.grid: faces have no area"),
        ("model = \"cosserat\"\n", "", "cosserat: belongs to `model = \"cosserat\"`"),
        ("model = \"cosserat\"", "model = \"terzopoulos\"", "cosserat.phi = 0.01: `model = \"terzopoulos\"` has no such constant"),
        ("model = \"cosserat\"", "model = \"membrane\"", "`membrane` is not a choice here"),
        ("[gravity]", "[shell]\nthickness = 1e-3\n[gravity]", "shell: belongs to the Koiter shell"),
        ("[gravity]", "[rest.isotropic]\ns = 0.1\n[gravity]", "rest: belongs to the Koiter shell"),
        (
            "[mesh.grid]\nnodes = [6, 5]\nsize = [1.0, 0.8]\nposition = [\"x\", \"y\", \"0.05 + 0.02 * x * y\"]",
            "[mesh.rectangle]\nsize = [1, 1]\ncells = [2, 2]",
            "mesh: `model = \"cosserat\"` needs [mesh.grid]",
        ),
        ("radius = 0.4", "radius = 0", "cosserat.table.radius = 0: must be > 0 [m]"),
        ("force = 0.01", "force = inf", "cosserat.normal-force.0.force = inf: must be finite"),
        ("region = \"corner\"\nforce", "region = \"edge\"\nforce", "there is no region 'edge'"),
        ("[cosserat]\n", "[cosserat]\nborder = \"symmetric\"\n", "cosserat.border = \"symmetric\": has no meaning without"),
        ("motion = { z = \"0.05 * sin(8 * t)\" }", "director = \"clamped\"", "pin.0.director = \"clamped\": belongs to the Koiter shell"),
        ("factor = \"1 + t\"", "factor = \"x\"", "cosserat.stream.factor = \"x\": unknown name `x`"),
        ("[dynamics]\ndt = 0.01\nend = 0.14\nvelocity = [0, \"0.1 * x\", 0]", "[statics]", "cosserat.damping = 0.05: needs [dynamics]"),
    ] {
        let sandbox = Sandbox::new(&with(CLOTH, from, to));
        let err = sandbox.fails(2, &["check", "scene.toml"]);
        let flat = err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(message), "{message}\n{err}");
    }
    let shell = "[mesh.rectangle]\nsize = [1, 1]\ncells = [2, 2]\n[statics]\n";
    assert!(Sandbox::new(shell).fails(2, &["check", "scene.toml"]).contains("shell: this key is missing"));
}

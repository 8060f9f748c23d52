//! Sweeps and expectations of ladders, by the real program on tiny scenes.

use super::pipeline_support::{Sandbox, text, with};
use serde_json::{Value, json};

/// A strip that is held flat while its rest curvature grows: its energy is all bending, and as the cube of the thickness.
const HELD: &str = r#"
[mesh.rectangle]
size = [0.06, 0.02]
cells = [6, 2]
[[region]]
name = "all"
where = "1"
[shell]
element = "linear"
thickness = 1e-3
youngs_modulus = 1e9
poissons_ratio = 0.3
[rest.pullback]
bbar = [20, 0, 0]
[[pin]]
region = "all"
[statics]
steps = 1
"#;

const SWEEP: &str = r#"
[[report.sweep]]
name = "scaling"
key = "shell.thickness"
logarithmic = { from = 1e-4, to = 1e-3, count = 4 }
measures = [
    { name = "energy", measure = { energy = {} }, least = 1e-12, source = "bent against its rest shape" },
    { name = "scaled", measure = { energy = { over = "E * h^3" } } },
]
fit = { measure = "energy", expect = { exponent = 3.0, tolerance = 1e-6, source = "exact: bending only" } }
"#;

fn held(sweep: &str) -> String {
    format!("{HELD}{sweep}")
}

fn result(sandbox: &Sandbox) -> Value {
    serde_json::from_str(&std::fs::read_to_string(sandbox.case("sweep.json")).unwrap()).unwrap()
}

#[test]
fn energy_goes_with_the_cube_of_the_thickness() {
    let sandbox = Sandbox::new(&held(SWEEP));
    let (out, _) = sandbox.ok(&["report", "--sweep", "scene.toml", "--json", "copy.json"]);
    assert_eq!(sandbox.names("cases/scene"), ["sweep.json", "sweep.md"]);
    let found = result(&sandbox);
    assert_eq!(found, serde_json::from_str::<Value>(&std::fs::read_to_string(sandbox.path("copy.json")).unwrap()).unwrap());
    assert_eq!(out.trim(), std::fs::read_to_string(sandbox.case("sweep.md")).unwrap().trim());
    assert!(found["passed"] == true && found["scene"] == "scene");
    let sweep = &found["sweeps"][0];
    assert_eq!(
        (&sweep["name"], &sweep["keys"], &sweep["measures"]),
        (&json!("scaling"), &json!(["shell.thickness"]), &json!(["energy", "scaled"]))
    );
    let rows = sweep["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for (i, row) in rows.iter().enumerate() {
        let (thickness, exact) = (row["values"][0].as_f64().unwrap(), 1e-4 * 10f64.powf(i as f64 / 3.0));
        assert!((thickness / exact - 1.0).abs() < 1e-12, "{row}");
        assert!(row["measures"].as_array().unwrap().iter().all(|m| m.as_f64().unwrap() > 0.0), "{row}");
        assert!((row["measures"][1].as_f64().unwrap() / rows[0]["measures"][1].as_f64().unwrap() - 1.0).abs() < 1e-6, "{row}");
        assert!(row["faces"] == 24 && row["dofs"].as_u64().unwrap() > 0 && row["newton_iterations"].as_u64().unwrap() > 0, "{row}");
        assert!(row["factorizations"].as_u64().unwrap() > 0 && row["wall_s"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row.get("failure").is_none() && row.get("missed").is_none(), "{row}");
    }
    let fit = &sweep["fits"][0];
    assert!((fit["exponent"].as_f64().unwrap() - 3.0).abs() < 1e-6 && fit["misfit"].as_f64().unwrap() < 1e-6, "{fit}");
    assert!(fit["points"] == json!([4, 4]) && fit["expected"]["passed"] == true && fit.get("at").is_none(), "{fit}");
    let last = &rows[3];
    let law = fit["prefactor"].as_f64().unwrap() * last["values"][0].as_f64().unwrap().powi(3);
    assert!((law / last["measures"][0].as_f64().unwrap() - 1.0).abs() < 1e-4, "{fit} {last}");
}

#[test]
fn missed_expectations_exit_with_1() {
    let sandbox = Sandbox::new(&held(&with(SWEEP, "exponent = 3.0", "exponent = 2.9")));
    let message = sandbox.fails(1, &["report", "--sweep", "scene.toml", "-q"]);
    assert!(message.contains("expectations of sweeps missed: scaling"), "{message}");
    let found = result(&sandbox);
    assert!(found["passed"] == false && found["sweeps"][0]["fits"][0]["expected"]["passed"] == false);
    assert!(std::fs::read_to_string(sandbox.case("sweep.md")).unwrap().contains("**no**"));
    // A limit that only the thinner shells miss.
    let thick = result_of_limit("least = 1e-12", "least = 1e-3");
    let rows = thick["sweeps"][0]["rows"].as_array().unwrap();
    assert!(rows[0]["missed"][0].as_str().unwrap().contains("is less than 0.001 (bent against its rest shape)"), "{}", rows[0]);
    assert!(rows[3].get("missed").is_none(), "{}", rows[3]);
    let high = result_of_limit("least = 1e-12", "most = 1e-3");
    assert!(high["sweeps"][0]["rows"][3]["missed"][0].as_str().unwrap().contains("is more than 0.001"));
}

fn result_of_limit(from: &str, to: &str) -> Value {
    let sandbox = Sandbox::new(&held(&with(SWEEP, from, to)));
    sandbox.fails(1, &["report", "--sweep", "scene.toml", "-q"]);
    assert!(std::fs::read_to_string(sandbox.case("sweep.md")).unwrap().contains("Missed limits"));
    result(&sandbox)
}

#[test]
fn grids_take_all_pairs_and_fit_each_line() {
    let sweep = with(SWEEP, "measures = [", "second = { key = \"mesh.rectangle.cells\", values = [\"[3, 2]\", \"[6, 4]\"] }\nmeasures = [");
    let sandbox = Sandbox::new(&held(&with(&sweep, "count = 4", "count = 2")));
    let (out, _) = sandbox.ok(&["report", "--sweep", "scene.toml"]);
    let found = result(&sandbox);
    let sweep = &found["sweeps"][0];
    let rows = sweep["rows"].as_array().unwrap();
    let faces: Vec<_> = rows.iter().map(|row| row["faces"].as_u64().unwrap()).collect();
    assert_eq!(faces, [12, 48, 12, 48]);
    assert_eq!(rows[1]["values"], json!([1e-4, "[6, 4]"]));
    let fits = sweep["fits"].as_array().unwrap();
    assert!(fits.len() == 2 && fits[0]["at"] == "[3, 2]" && fits[1]["at"] == "[6, 4]", "{fits:?}");
    assert!(fits.iter().all(|f| f["expected"]["passed"] == true && f["points"] == json!([2, 2])), "{fits:?}");
    // The tables' columns: two keys, two measures, five counts; measure, key, seven of the law.
    let widths: Vec<_> = out.lines().filter(|l| l.starts_with('|')).map(|l| l.matches('|').count()).collect();
    assert_eq!(widths, [10, 10, 10, 10, 10, 10, 10, 10, 10, 10], "{out}");
}

#[test]
fn a_law_can_go_through_the_lowest_of_the_runs() {
    // The energy of a strip that is held flat goes with the square of the rest curvature: the second of three has the least.
    let bent = "second = { key = \"rest.pullback.bbar.0\", values = [20, 10, 30] }\nmeasures = [";
    let sweep = with(&with(SWEEP, "measures = [", bent), "fit = { ", "fit = { lowest = \"scaled\", ");
    let sandbox = Sandbox::new(&held(&sweep));
    let (out, _) = sandbox.ok(&["report", "--sweep", "scene.toml"]);
    let found = result(&sandbox);
    let (rows, fits) = (found["sweeps"][0]["rows"].as_array().unwrap(), found["sweeps"][0]["fits"].as_array().unwrap());
    assert!(rows.len() == 12 && fits.len() == 1, "{fits:?}");
    assert!(fits[0]["at"] == "lowest scaled" && fits[0]["points"] == json!([4, 4]) && fits[0]["expected"]["passed"] == true, "{fits:?}");
    let law = fits[0]["prefactor"].as_f64().unwrap() * 1e-12;
    for (row, share) in rows.iter().zip([4.0, 1.0, 9.0]) {
        assert!((row["measures"][0].as_f64().unwrap() / law / share - 1.0).abs() < 1e-4, "{row} {law}");
    }
    assert!(out.contains("| energy  | lowest scaled"), "{out}");
    let alone = with(SWEEP, "fit = { ", "fit = { lowest = \"scaled\", ");
    assert!(Sandbox::new(&held(&alone)).fails(2, &["report", "--sweep", "scene.toml"]).contains("needs a second key"));
}

#[test]
fn runs_that_fail_are_rows() {
    // Without pins that hold enough, a static shell is a mechanism.
    let sweep = r#"
[[report.sweep]]
name = "supports"
key = "pin.0.region"
values = ["all", "left"]
measures = [{ name = "energy", measure = { energy = {} } }]
"#;
    let scene = with(HELD, "[[pin]]\nregion = \"all\"", "[[pin]]\nregion = \"all\"\ncomponents = [\"x\", \"y\", \"z\"]");
    let sandbox = Sandbox::new(&(scene.clone() + sweep));
    sandbox.ok(&["report", "--sweep", "scene.toml", "-q"]);
    let found = result(&sandbox);
    let rows = found["sweeps"][0]["rows"].as_array().unwrap();
    assert!(rows[0]["measures"][0].is_number() && rows[0].get("failure").is_none(), "{}", rows[0]);
    assert!(rows[1]["measures"][0].is_null() && rows[1]["failure"].as_str().unwrap().contains("mechanism"), "{}", rows[1]);
    assert!(rows[1]["dofs"].as_u64().unwrap() > rows[0]["dofs"].as_u64().unwrap());
    assert!(std::fs::read_to_string(sandbox.case("sweep.md")).unwrap().contains("failed: the structure is a mechanism"));
    // Where a limit is set, a run that fails misses it.
    let sweep = with(sweep, "{ energy = {} } }", "{ energy = {} }, least = 0.0, source = \"squares\" }");
    let sandbox = Sandbox::new(&(scene + &sweep));
    sandbox.fails(1, &["report", "--sweep", "scene.toml", "-q"]);
    assert_eq!(result(&sandbox)["sweeps"][0]["rows"][1]["missed"][0], "left: energy has no value (squares)");
}

/// A sheet that is thrown up, by the difference scheme, which blows up in long steps, or by the variational one, which does not.
const THROWN: &str = r#"
model = "cosserat"
[mesh.grid]
nodes = [7, 7]
size = [1, 1]
[cosserat]
eta = 40
xi = 1e-2
mass = 1
scheme = "strong-form"
[dynamics]
dt = 0.1
end = 3.0
velocity = [0, 0, "40 * x * y * (1 - x)"]
[output]
interval = 0.5
[solver]
max_halvings = 0
[[report.sweep]]
name = "strong form"
key = "dynamics.dt"
values = [0.1, 0.0125]
measures = [
    { name = "came to", measure = "time-reached" },
    { name = "sound until", measure = { time-within = { column = "area_m2", least = 0.9, most = 1.05 } } },
    { name = "rise", measure = { displacement = { at = [1, 1, 0], axis = "z" } } },
]
[[report.sweep]]
name = "variational"
set = ["cosserat.scheme=variational"]
key = "dynamics.dt"
values = [0.1]
measures = [
    { name = "came to", measure = "time-reached", least = 3, source = "its energy never grows" },
    { name = "sound until", measure = { time-within = { column = "kinetic_energy_J", least = 0, most = 1e9 } } },
    { name = "never", measure = { time-within = { column = "area_m2", least = 0, most = 1e-3 } } },
]
"#;

#[test]
fn how_far_a_run_came_is_a_result() {
    let sandbox = Sandbox::new(THROWN);
    let (out, _) = sandbox.ok(&["report", "--sweep", "scene.toml"]);
    let found = result(&sandbox);
    let rows = found["sweeps"][0]["rows"].as_array().unwrap();
    for row in rows {
        let time = row["measures"][0].as_f64().unwrap();
        let step = row["values"][0].as_f64().unwrap();
        assert!(row["failure"].as_str().unwrap().contains("blown up") && (0.0..3.0).contains(&time), "{row}");
        // The last step that was accepted, of which there is one a matrix.
        assert!((time / step - time.div_euclid(step * (1.0 - 1e-9))).abs() < 1e-6, "{row}");
        assert!((row["factorizations"].as_f64().unwrap() * step - time).abs() < 1e-6 + step, "{row}");
        let sound = row["measures"][1].as_f64().unwrap();
        assert!(sound <= time && row["measures"][2].is_null(), "{row}");
    }
    assert!(rows.iter().any(|row| row["measures"][1].as_f64() < row["measures"][0].as_f64()), "{rows:?}");
    assert!(out.contains("Runs that stopped before their end") && !out.contains("failed:"), "{out}");
    assert_eq!(found["sweeps"][1]["rows"][0]["measures"], json!([3.0, 3.0, 0.0]));
    // Alone they are a table all the same, but not where nothing is asked that they could tell.
    let alone = &THROWN[..THROWN.find("[[report.sweep]]\nname = \"variational").unwrap()];
    Sandbox::new(alone).ok(&["report", "--sweep", "scene.toml", "-q"]);
    let silent = with(alone, "    { name = \"came to\", measure = \"time-reached\" },\n", "");
    let silent = with(
        &silent,
        "    { name = \"sound until\", measure = { time-within = { column = \"area_m2\", least = 0.9, most = 1.05 } } },\n",
        "",
    );
    assert!(Sandbox::new(&silent).fails(3, &["report", "--sweep", "scene.toml", "-q"]).contains("every run of the sweep failed"));
    // As an expectation it is the end.
    let expect = "[[report.expect]]\nname = \"end\"\nmeasure = \"time-reached\"\nreference = 3\ntolerance = 0\nsource = \"the scene\"\n";
    let scene = with(&format!("{THROWN}{expect}"), "scheme = \"strong-form\"\n", "");
    Sandbox::new(&scene).ok(&["all", "scene.toml", "-q", "--set", "report.sweep=[]"]);
}

#[test]
fn the_largest_value_up_to_which_a_measure_suffices_is_told() {
    // The energy of a strip that is held flat is k^2 A / (24 (1 - nu^2)) over E h^3, so 0.0494, 0.0220 and 0.0055, whatever its thickness.
    let bent = "second = { key = \"rest.pullback.bbar.0\", values = [-10, -30, -20] }\nlargest = { measure = \"scaled\", least = 0.015 }\nmeasures = [";
    let sandbox = Sandbox::new(&held(&with(&with(SWEEP, "measures = [", bent), "count = 4", "count = 2")));
    let (out, _) = sandbox.ok(&["report", "--sweep", "scene.toml"]);
    let found = result(&sandbox)["sweeps"][0]["largest"].clone();
    assert!(found["measure"] == "scaled" && found["least"] == 0.015, "{found}");
    assert_eq!(found["rows"], json!([[1e-4, -20.0, -10.0], [1e-3, -20.0, -10.0]]));
    assert!(out.contains("Largest rest.pullback.bbar.0 up to which scaled is at least 0.015:"), "{out}");
    sandbox.ok(&["report", "--sweep", "scene.toml", "-q", "--set", "report.sweep.0.largest.least=0.1"]);
    assert_eq!(result(&sandbox)["sweeps"][0]["largest"]["rows"], json!([[1e-4, null, -30.0], [1e-3, null, -30.0]]));
}

#[test]
fn keys_change_together_and_shapes_are_compared() {
    // A rope that is wider carries more: weight and stiffness go with the width, so with both the sag stays, and does not with one.
    let scene = "model = \"cosserat\"\n[mesh.grid]\nnodes = [5, 3]\nsize = [1, 0.5]\n[cosserat]\neta = 10\nxi = 1e-2\nmass = 1\n[gravity]\n\
                 [[pin]]\nregion = \"left\"\n[[pin]]\nregion = \"right\"\n[statics]\nsteps = 2\n";
    let sweep = "[[report.sweep]]\nname = \"both\"\nkey = \"cosserat.mass\"\nvalues = [1, 2]\nshapes = {}\n\
                 with = [{ key = \"cosserat.eta\", values = [10, 20] }, { key = \"cosserat.xi\", values = [1e-2, 2e-2] }]\n\
                 measures = [{ name = \"sag\", measure = { displacement = { at = [0.5, 0, 0], axis = \"z\" } } }]\n\
                 [[report.sweep]]\nname = \"grids\"\nkey = \"mesh.grid.nodes\"\nvalues = [\"[5, 3]\", \"[9, 5]\", \"[17, 9]\"]\nshapes = { time = 1.0 }\n\
                 measures = [{ name = \"sag\", measure = { displacement = { at = [0.5, 0, 0], axis = \"z\" } } }]\n";
    let sandbox = Sandbox::new(&format!("{scene}{sweep}"));
    sandbox.ok(&["report", "--sweep", "scene.toml", "-q"]);
    let found = result(&sandbox);
    let value = |sweep: usize, row: usize, measure: usize| found["sweeps"][sweep]["rows"][row]["measures"][measure].as_f64();
    let [a, b] = [0, 1].map(|row| value(0, row, 0).unwrap());
    assert!(a < -0.05 && (a / b - 1.0).abs() < 1e-6, "{found}");
    assert!(found["sweeps"][0]["measures"].as_array().unwrap().len() == 3 && value(0, 0, 1).is_none(), "{found}");
    assert!(value(0, 1, 2).unwrap() < 1e-6 * a.abs(), "{found}");
    let [rms, largest] = [1, 2].map(|measure| [1, 2].map(|row| value(1, row, measure).unwrap()));
    assert!(rms[1] < 0.5 * rms[0] && rms[0] < largest[0] && largest[1] < 0.5 * largest[0], "{found}");
    // At least as far as the point that is named.
    assert!(largest[0] >= (value(1, 1, 0).unwrap() - value(1, 0, 0).unwrap()).abs(), "{found}");
    for (from, to, message) in [
        ("[10, 20]", "[10]", "report.sweep.0.with.0.values = [10]: has 1 values, must have 2"),
        (
            "shapes = { time = 1.0 }",
            "shapes = { time = 1.5 }",
            "report.sweep.1.shapes.time = 1.5: 1.5 with mesh.grid.nodes=[5, 3]: is after the end",
        ),
        ("shapes = {}", "set = [\"cosserat.mass\"]", "report.sweep.0.set.0 = \"cosserat.mass\": `key=value` expected"),
        (
            "shapes = {}",
            "set = [\"cosserat.damping=0\"]",
            "report.sweep.0.set.0 = \"cosserat.damping=0\": cosserat.damping = 0: must be > 0 [kg/s]",
        ),
        ("shapes = {}", "set = [\"cosserat.hue=1\"]", "report.sweep.0.set.0 = \"cosserat.hue=1\": cosserat.hue: unknown key"),
        (
            "shapes = {}",
            "largest = { measure = \"sag\", least = 1 }",
            "report.sweep.0.largest = { measure = \"sag\", least = 1 }: needs a second key whose values are numbers",
        ),
    ] {
        let message_found = Sandbox::new(&with(&format!("{scene}{sweep}"), from, to)).fails(2, &["report", "--sweep", "scene.toml"]);
        let flat = message_found.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(message), "{message}\n{flat}");
    }
}

#[test]
fn wrong_values_are_refused_before_anything_runs() {
    let list = |key: &str, values: &str| {
        let sweep = with(SWEEP, "logarithmic = { from = 1e-4, to = 1e-3, count = 4 }", &format!("values = {values}"));
        let fit = sweep.find("fit =").unwrap();
        held(&with(&sweep[..fit], "key = \"shell.thickness\"", &format!("key = \"{key}\"")))
    };
    for (key, values, expected) in [
        ("shell.thickness", "[1e-3, -1]", "report.sweep.0.values.1 = -1: shell.thickness = -1: must be > 0 [m]"),
        ("shell.thicknes", "[1e-3]", "report.sweep.0.key = \"shell.thicknes\": shell.thicknes: unknown key"),
        ("shell.thickness.x", "[1e-3]", "`shell.thickness` is a float, it has no keys"),
        (
            "pin.0.region",
            "[\"all\", \"nowhere\"]",
            "report.sweep.0.values.1 = \"nowhere\": with nowhere, pin.0.region: there is no region 'nowhere'",
        ),
        ("pin.1.region", "[\"all\"]", "has 1 entries, numbered from 0"),
        ("mesh.rectangle.cells.0", "[2, 2.5]", "expected a whole number"),
        ("rest.pullback.bbar.0", "[1, \"1 / 0\"]", "must be finite"),
    ] {
        let sandbox = Sandbox::new(&list(key, values));
        let output = sandbox.output(&["report", "--sweep", "scene.toml"]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(expected) && message.matches("error: ").count() == 1, "expected {expected}, found {message}");
        assert_eq!(sandbox.names("."), ["scene.toml"]);
    }
    let sandbox = Sandbox::new(HELD);
    assert!(sandbox.fails(2, &["report", "--sweep", "scene.toml"]).contains("report.sweep: scene.toml has no such table"));
    assert_eq!(sandbox.output(&["report", "--sweep", "scene.toml", "--ladder", "scene.toml"]).status.code(), Some(2));
}

#[test]
fn measures_have_times_and_runs_need_not_reach_those_of_expectations() {
    // Held flat against a rest curvature that grows with the load factor, the strip's energy grows as its square.
    let expect =
        "[[report.expect]]\nname = \"late\"\nmeasure = { energy = {} }\ntime = 0.9\nreference = 1\ntolerance = 1\nsource = \"a\"\n";
    let sweep = with(SWEEP, "{ name = \"scaled\"", "{ name = \"half way\", time = 0.5, measure = { energy = {} } },\n{ name = \"scaled\"");
    let two = with(&held(&(sweep.clone() + expect)), "steps = 1", "steps = 2");
    let sandbox = Sandbox::new(&two);
    sandbox.ok(&["report", "--sweep", "scene.toml", "-q"]);
    for row in result(&sandbox)["sweeps"][0]["rows"].as_array().unwrap() {
        let ratio = row["measures"][1].as_f64().unwrap() / row["measures"][0].as_f64().unwrap();
        assert!((ratio - 0.25).abs() < 1e-6, "{row}");
    }
    // In time, a run that ends earlier than the scene expects something is one, but not if the sweep itself measures later.
    let moving = with(&two, "[statics]\nsteps = 2", "[dynamics]\ndt = 0.25\nend = 1");
    let moving = with(&moving, "thickness = 1e-3", "thickness = 1e-3\ndensity = 1000");
    let ends = |time: &str| {
        let table = "key = \"dynamics.end\"\nvalues = [0.5, 1.0]";
        let scene = with(&moving, "key = \"shell.thickness\"\nlogarithmic = { from = 1e-4, to = 1e-3, count = 4 }", table);
        let fit = scene.find("fit =").unwrap();
        let rest = &scene[fit + scene[fit..].find('\n').unwrap()..];
        Sandbox::new(&(with(&scene[..fit], "time = 0.5", time) + rest))
    };
    let sandbox = ends("time = 0.5");
    sandbox.ok(&["report", "--sweep", "scene.toml", "-q"]);
    assert_eq!(result(&sandbox)["sweeps"][0]["rows"].as_array().unwrap().len(), 2);
    let message = ends("time = 0.75").fails(2, &["report", "--sweep", "scene.toml"]);
    assert!(
        message.contains("report.sweep.0.measures.1.time") && message.contains("dynamics.end=0.5") && message.contains("after the end"),
        "{message}"
    );
}

#[test]
fn overrides_hold_for_all_runs_of_a_sweep() {
    let sandbox = Sandbox::new(&held(SWEEP));
    sandbox.ok(&["report", "--sweep", "scene.toml", "-q", "--set", "mesh.rectangle.cells=[3, 2]"]);
    let rows = result(&sandbox)["sweeps"][0]["rows"].clone();
    assert!(rows.as_array().unwrap().iter().all(|row| row["faces"] == 12), "{rows}");
}

const CURL: &str = include_str!("../../configs/analytic/smallest_curl.toml");

fn ladder(rest: &str) -> String {
    let head = &CURL[..CURL.find("[report.ladder]").unwrap()];
    format!("{head}[report.ladder]\nmeasure = {{ cylinder-distance = {{ radius = 0.038197186342054884 }} }}\nresolutions = [1, 2]\n{rest}")
}

#[test]
fn ladders_vary_the_sampling_and_know_their_order() {
    let expect = "[[report.ladder.expect]]\nsampling = 'edges'\nleast_order = 1.8\nlargest_error = 1e-2\nsource = 'second order'\n";
    let sandbox = Sandbox::new(&ladder(&format!("samplings = ['edges', 'centroid']\n{expect}")));
    let (out, _) = sandbox.ok(&["report", "--ladder", "scene.toml"]);
    let rows: Value = serde_json::from_str(&std::fs::read_to_string(sandbox.case("ladder.json")).unwrap()).unwrap();
    let samplings: Vec<_> = rows.as_array().unwrap().iter().map(|r| r["sampling"].as_str().unwrap()).collect();
    assert_eq!(samplings, ["edges", "edges", "centroid", "centroid"]);
    assert!(rows[2]["order"].is_null() && rows[3]["order"].is_number() && rows[1].get("missed").is_none());
    assert!(out.lines().next().unwrap().contains("| sampling |") && !out.contains("Missed"), "{out}");

    let strict = expect.replace("1.8", "2.5").replace("sampling = 'edges'\n", "");
    let sandbox = Sandbox::new(&ladder(&format!("{strict}[[report.ladder.expect]]\nlargest_error = 1e-9\nsource = 'too strict'\n")));
    let message = sandbox.fails(1, &["report", "--ladder", "scene.toml", "-q"]);
    assert!(message.contains("expectations of the ladder missed: 2"), "{message}");
    let rows: Value = serde_json::from_str(&std::fs::read_to_string(sandbox.case("ladder.json")).unwrap()).unwrap();
    let missed = rows[1]["missed"].as_array().unwrap();
    assert!(rows[0].get("missed").is_none() && rows[0].get("sampling").is_none());
    assert!(missed[0].as_str().unwrap().starts_with("order ") && missed[0].as_str().unwrap().contains("expected 2.5 (second order)"));
    assert!(missed[1].as_str().unwrap().starts_with("error "), "{missed:?}");
    assert!(std::fs::read_to_string(sandbox.case("ladder.md")).unwrap().contains("- free-tan, own, 0.001 m: order "));
}

#[test]
fn tables_of_failures_are_failures() {
    // Nothing holds it.
    let free = "[mesh.rectangle]\nsize = [1, 0.2]\ncells = [5, 1]\n[shell]\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0\n\
                [[force]]\nregion = \"boundary\"\nforce = [0, 0, 0.01]\n[statics]\nsteps = 1\n[solver]\nmax_halvings = 0\n";
    let measure = "measure = \"newton-iterations\"";
    let ladder = Sandbox::new(&format!("{free}[report.ladder]\n{measure}\nresolutions = [1]\n"));
    let message = ladder.fails(3, &["report", "--ladder", "scene.toml"]);
    assert!(message.contains("every run of the ladder failed"), "{message}");
    let sweep = Sandbox::new(&format!(
        "{free}[[report.sweep]]\nname = \"s\"\nkey = \"shell.thickness\"\nvalues = [0.01, 0.02]\nmeasures = [{{ name = \"n\", {measure} }}]\n"
    ));
    let message = sweep.fails(3, &["report", "--sweep", "scene.toml"]);
    assert!(message.contains("every run of the sweep failed"), "{message}");
}

#[test]
fn ladders_expect_nothing_of_runs_they_do_not_make() {
    for (rest, expected) in [
        ("samplings = ['edges']\n[[report.ladder.expect]]\nsampling = 'centroid'\nleast_order = 1\nsource = 'a'", "expect.0.sampling"),
        ("[[report.ladder.expect]]\ndirector = 'average'\nleast_order = 1\nsource = 'a'", "expect.0.director"),
        (
            "elements = ['quadratic']\ndirectors = ['average', 'free-tan']\n[[report.ladder.expect]]\ndirector = 'average'\nleast_order = 1\nsource = 'a'",
            "is about no run",
        ),
    ] {
        let sandbox = Sandbox::new(&ladder(rest));
        let message = sandbox.fails(2, &["report", "--ladder", "scene.toml"]);
        assert!(message.contains(expected), "{message}");
    }
    let scene = with(&ladder("samplings = ['edges']"), "[rest.pullback]\nbbar = [\"0.5 * PI / 0.06\", 0, 0]\n", "");
    assert!(Sandbox::new(&scene).fails(2, &["report", "--ladder", "scene.toml"]).contains("needs a law in [rest]"));
    let one = with(&ladder("[[report.ladder.expect]]\nleast_order = 1\nsource = 'a'"), "[1, 2]", "[1]");
    assert!(Sandbox::new(&one).fails(2, &["report", "--ladder", "scene.toml"]).contains("needs two resolutions"));
}

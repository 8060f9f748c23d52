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

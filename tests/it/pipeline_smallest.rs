//! The smallest scenes from end to end: every file, every key.

use super::pipeline_support::{STATIC, Sandbox, names, with};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use thinshell::scene;

const FALL: &str = include_str!("../../configs/analytic/smallest.toml");
const CURL: &str = include_str!("../../configs/analytic/smallest_curl.toml");

fn keys(value: &Value) -> BTreeSet<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

fn json(path: &std::path::Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn assert_report(report: &Value, scene: &str, expectations: usize) {
    let all = ["scene", "passed", "expectations", "dofs", "faces", "wall_s", "newton_iterations", "factorizations", "inputs"];
    assert_eq!(keys(report), BTreeSet::from(all));
    assert_eq!((&report["scene"], &report["passed"]), (&Value::from(scene), &Value::from(true)));
    let list = report["expectations"].as_array().unwrap();
    assert_eq!(list.len(), expectations);
    for row in list {
        assert_eq!(keys(row), BTreeSet::from(["name", "value", "reference", "error", "tolerance", "passed", "source"]));
        assert_eq!(row["passed"], true);
    }
    assert!(["dofs", "faces", "newton_iterations", "factorizations"].iter().all(|key| report[*key].as_u64().unwrap() > 0));
    assert!(report["wall_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_falling_strip_from_end_to_end() {
    let sandbox = Sandbox::new(FALL);
    let (out, err) = sandbox.ok(&["all", "scene.toml"]);
    assert!(out.contains("# scene: passed") && err.contains("cases/scene/vtk/case.pvd: 7 states"), "{out}{err}");
    assert_eq!(sandbox.names("."), ["cases", "scene.toml"]);
    assert_eq!(
        sandbox.names("cases/scene"),
        [".lock", "case.toml", "history.csv", "mesh.h5", "report.json", "report.md", "run", "setup.h5", "vtk"]
    );
    // Steps on output times, and the last but one.
    let steps = [0, 5, 10, 15, 20, 25, 29, 30].map(|n| format!("step_{n:08}.h5"));
    assert_eq!(sandbox.names("cases/scene/run"), steps);
    let films: Vec<Vec<u8>> = names(&sandbox.case("vtk"))
        .iter()
        .filter(|n| n.ends_with(".vtp"))
        .map(|n| fs::read(sandbox.case("vtk").join(n)).unwrap())
        .collect();
    assert_eq!(films.iter().collect::<BTreeSet<_>>().len(), films.len(), "frames are equal");
    assert!(films.len() > 3 && sandbox.case("vtk/units.json").exists());
    assert_report(&json(&sandbox.case("report.json")), "scene", 3);
    assert_eq!(sandbox.history().len(), 31);
    // The second time there is nothing to do.
    let before = sandbox.result();
    let (_, err) = sandbox.ok(&["all", "scene.toml"]);
    assert!(!err.contains("mesh.h5") && !err.contains("setup.h5") && !err.contains("going on"), "{err}");
    assert_eq!(sandbox.result(), before);
}

#[test]
fn a_case_stands_for_itself() {
    let sandbox = Sandbox::new(CURL);
    sandbox.ok(&["all", "scene.toml", "-q", "--set", "shell.thickness=2e-3"]);
    let text = fs::read_to_string(sandbox.case("case.toml")).unwrap();
    let (recorded, _) = scene::parse("case.toml", &text, &[]).unwrap();
    let (own, _) = scene::parse("scene.toml", CURL, &["shell.thickness=2e-3".into()]).unwrap();
    assert_eq!(recorded, own);
    // Without the scene, and from within.
    fs::remove_file(sandbox.path("scene.toml")).unwrap();
    let first = json(&sandbox.case("report.json"));
    fs::remove_file(sandbox.case("report.json")).unwrap();
    sandbox.ok(&["report", "cases/scene", "--json", "all.json"]);
    assert_eq!(json(&sandbox.case("report.json")), first);
    assert_eq!(json(&sandbox.path("all.json")), first);
    assert_report(&first, "scene", 2);
    sandbox.ok(&["report", "cases/scene", "cases/scene", "--json", "all.json"]);
    assert_eq!(json(&sandbox.path("all.json")).as_array().map(Vec::len), Some(2));
    let inside = sandbox.command(&["report", "."]).current_dir(sandbox.case("")).output().unwrap();
    assert!(inside.status.success());
    assert_eq!(json(&sandbox.case("report.json"))["scene"], "scene");
    assert_eq!(fs::read_to_string(sandbox.case("case.toml")).unwrap(), text);
}

#[test]
fn a_missed_expectation_exits_with_1() {
    let sandbox = Sandbox::new(CURL);
    let message = sandbox.fails(1, &["all", "scene.toml", "--set", "report.expect.0.tolerance=1e-6"]);
    assert!(message.contains("error: expectations missed: scene"), "{message}");
    let report = json(&sandbox.case("report.json"));
    assert_eq!(
        (&report["passed"], &report["expectations"][0]["passed"], &report["expectations"][1]["passed"]),
        (&false.into(), &false.into(), &true.into())
    );
    assert!(fs::read_to_string(sandbox.case("report.md")).unwrap().contains("**no**"));
    sandbox.fails(1, &["report", "cases/scene"]);
    sandbox.ok(&["report", "scene.toml"]);
}

#[test]
fn unknown_measures_name_what_there_is() {
    let sandbox = Sandbox::new(CURL);
    for (measure, known) in [
        ("{ history = { column = 'speed' } }", "bending_energy_J"),
        ("{ field = { name = 'speed', statistic = 'max' } }", "mean_curvature"),
        ("{ field = { name = 'displacement', component = 3, statistic = 'max' } }", "3 components"),
    ] {
        let message = sandbox.fails(2, &["all", "scene.toml", "-q", "--set", &format!("report.expect.1.measure={measure}")]);
        assert!(message.contains(known), "{message}");
    }
}

#[test]
fn a_ladder_has_rows_with_these_keys() {
    let sandbox = Sandbox::new(CURL);
    let (out, _) = sandbox.ok(&["report", "--ladder", "scene.toml", "--json", "rows.json"]);
    let rows = json(&sandbox.path("rows.json"));
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let all = [
            "director",
            "mesh",
            "thickness",
            "faces",
            "longest_edge",
            "dofs",
            "error",
            "order",
            "fitted_order",
            "wall_s",
            "gflop",
            "factorizations",
        ];
        assert_eq!(keys(row), BTreeSet::from(all));
        assert!(row["gflop"].as_f64().unwrap() > 1e8 * 1e-9 * row["wall_s"].as_f64().unwrap(), "no machine is so slow: {row}");
    }
    assert!(rows[0]["order"].is_null() && rows[2]["order"].is_null());
    // Second order of the angle per edge: measured 1.99.
    assert!((rows[1]["order"].as_f64().unwrap() - 2.0).abs() < 0.2, "{}", rows[1]);
    assert_eq!(out.lines().count(), 6, "{out}");
    assert!(sandbox.case("ladder.json").exists() && sandbox.case("ladder.csv").exists() && sandbox.case("ladder.md").exists());
    assert!(sandbox.fails(2, &["report", "--ladder", "scene.toml", "--set", "report.ladder.resolutions=[]"]).contains("resolutions"));
    sandbox.rewrite(FALL);
    assert!(sandbox.fails(2, &["report", "--ladder", "scene.toml"]).contains("report.ladder: scene.toml has no such table"));
}

#[test]
fn directors_are_exported_where_the_scene_asks_for_them() {
    let element = |name: &str| with(STATIC, "element = \"linear\"", &format!("element = \"{name}\""));
    for (name, per_edge) in [("linear", 1), ("quadratic", 2)] {
        let silent = Sandbox::new(&element(name));
        silent.ok(&["all", "scene.toml"]);
        assert!(!silent.case("vtk/directors.pvd").exists());
        let sandbox = Sandbox::new(&(element(name) + "[output]\ndirectors = true\n"));
        sandbox.ok(&["all", "scene.toml"]);
        assert!(sandbox.case("vtk/directors.pvd").exists());
        let edges = thinshell::mesh::Topology::new(
            &thinshell::case::mesh_from_archive(
                &thinshell::case::Archive::read(&sandbox.case("mesh.h5"), thinshell::case::Kind::Mesh).unwrap(),
                &sandbox.case("mesh.h5"),
            )
            .unwrap()
            .faces,
        )
        .edges
        .len();
        let file = names(&sandbox.case("vtk")).into_iter().rfind(|n| n.starts_with("directors_")).unwrap();
        let text = String::from_utf8_lossy(&fs::read(sandbox.case("vtk").join(file)).unwrap()).into_owned();
        assert!(text.contains(&format!("NumberOfPoints=\"{}\"", per_edge * edges)), "{name}");
        assert!(text.contains("Name=\"director\""));
    }
}

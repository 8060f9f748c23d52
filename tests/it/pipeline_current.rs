//! What of a case is taken for done: nothing that has lost a part, nothing that was made from something else; and nothing is done twice.

use super::pipeline_support::{STATIC, Sandbox, names, with};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

const EXPECTED: &str = "
[[report.expect]]
name = 'half way'
measure = { displacement = { at = [0, 0, 0], axis = 'z' } }
time = 0.5
reference = 0.005
tolerance = 1e-9
source = 'the pin'
";

fn scene() -> String {
    format!("{STATIC}{EXPECTED}")
}

/// All files of a case with the times of their last change.
fn files(folder: &Path, found: &mut BTreeMap<PathBuf, SystemTime>) {
    for name in names(folder) {
        let path = folder.join(name);
        if path.is_dir() {
            files(&path, found);
        } else {
            found.insert(path.clone(), path.metadata().unwrap().modified().unwrap());
        }
    }
}

#[test]
fn a_history_that_does_not_reach_the_newest_checkpoint_is_refused() {
    let sandbox = Sandbox::new(&scene());
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let (path, whole) = (sandbox.case("history.csv"), sandbox.result());
    let text = fs::read_to_string(&path).unwrap();
    let without_third: Vec<&str> = text.lines().filter(|line| !line.starts_with("3,")).collect();
    let shortened: Vec<&str> = text.lines().take(4).collect();
    for damaged in [None, Some(shortened.join("\n") + "\n"), Some(without_third.join("\n") + "\n")] {
        match &damaged {
            None => fs::remove_file(&path).unwrap(),
            Some(text) => fs::write(&path, text).unwrap(),
        }
        for verb in ["run", "report", "status"] {
            let message = sandbox.fails(2, &[verb, "scene.toml"]);
            let words = if damaged.is_none() { "does not exist" } else { "steps only, the newest checkpoint is of step 8" };
            assert!(message.contains("history.csv") && message.contains(words), "{verb}: {message}");
            assert!(message.contains("thinshell run scene.toml --restart"), "{verb}: {message}");
        }
        let out = String::from_utf8(sandbox.output(&["status", "scene.toml"]).stdout).unwrap();
        assert!(out.lines().count() == 5 && out.contains("run     out of date: "), "{out}");
        // The help is true.
        sandbox.ok(&["run", "scene.toml", "--restart", "-q"]);
        assert!(sandbox.result() == whole);
        sandbox.ok(&["report", "scene.toml", "-q"]);
    }
    // A longer one is what a crash leaves.
    fs::remove_file(sandbox.case("run/step_00000008.h5")).unwrap();
    sandbox.ok(&["run", "scene.toml", "-q"]);
    assert!(sandbox.result() == whole);
}

#[test]
fn a_damaged_checkpoint_stops_only_who_needs_it_and_is_made_anew() {
    let sandbox = Sandbox::new(&scene());
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let whole = sandbox.result();
    let damage = |step: usize| {
        let path = sandbox.case(&format!("run/step_{step:08}.h5"));
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
    };
    damage(3);
    sandbox.ok(&["report", "scene.toml", "-q"]);
    damage(4);
    let message = sandbox.fails(2, &["report", "scene.toml", "-q"]);
    assert!(message.contains("step_00000004.h5") && message.contains("all later ones, then: thinshell run scene.toml"), "{message}");
    for step in 3..=8 {
        fs::remove_file(sandbox.case(&format!("run/step_{step:08}.h5"))).unwrap();
    }
    sandbox.ok(&["run", "scene.toml", "-q"]);
    assert!(sandbox.result() == whole);
    sandbox.ok(&["report", "scene.toml", "-q"]);
}

#[test]
fn a_report_is_out_of_date_when_its_scene_expects_something_else() {
    let sandbox = Sandbox::new(&scene());
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let report = |arguments: &[&str]| sandbox.ok(arguments).0.lines().find(|l| l.starts_with("report")).unwrap().to_owned();
    assert_eq!(report(&["status", "scene.toml"]), "report  done");
    sandbox.rewrite(&with(&scene(), "reference = 0.005", "reference = 0.006"));
    assert_eq!(report(&["status", "scene.toml"]), "report  out of date");
    // `all` reports anew, and only that.
    let mut before = BTreeMap::new();
    files(&sandbox.case(""), &mut before);
    assert!(sandbox.fails(1, &["all", "scene.toml", "-q"]).contains("expectations missed: scene"));
    let mut after = BTreeMap::new();
    files(&sandbox.case(""), &mut after);
    let changed: Vec<_> =
        after.iter().filter(|(path, time)| before.get(*path) != Some(*time)).map(|(p, _)| p.file_name().unwrap()).collect();
    assert_eq!(changed, ["case.toml", "report.json", "report.md"]);
    // The case and the scene say the same.
    let bytes = fs::read(sandbox.case("report.json")).unwrap();
    for target in ["cases/scene", "scene.toml"] {
        assert_eq!(report(&["status", target]), "report  done");
        sandbox.fails(1, &["report", target, "-q"]);
        assert_eq!(fs::read(sandbox.case("report.json")).unwrap(), bytes);
    }
}

#[test]
fn all_leaves_a_finished_case_as_it_is() {
    let sandbox = Sandbox::new(&scene());
    let (first, _) = sandbox.ok(&["all", "scene.toml"]);
    let mut before = BTreeMap::new();
    files(&sandbox.case(""), &mut before);
    let (second, err) = sandbox.ok(&["all", "scene.toml"]);
    let mut after = BTreeMap::new();
    files(&sandbox.case(""), &mut after);
    assert_eq!(before, after);
    assert!(err.is_empty() && first.ends_with(&second) && second.contains("half way"), "{first}{second}{err}");
    // What is lost or written otherwise is made anew.
    fs::remove_file(sandbox.case("vtk/case.pvd")).unwrap();
    fs::remove_file(sandbox.case("report.md")).unwrap();
    sandbox.ok(&["all", "scene.toml", "-q"]);
    assert!(sandbox.case("vtk/case.pvd").exists() && sandbox.case("report.md").exists());
    sandbox.ok(&["all", "scene.toml", "-q", "--set", "output.directors=true"]);
    assert!(sandbox.case("vtk/directors.pvd").exists());
}

#[test]
fn all_says_what_it_discards() {
    let sandbox = Sandbox::new(&scene());
    sandbox.ok(&["all", "scene.toml", "-q"]);
    sandbox.rewrite(&with(&scene(), "thickness = 1e-3", "thickness = 2e-3"));
    let (_, err) = sandbox.ok(&["all", "scene.toml"]);
    assert!(err.lines().any(|l| l.starts_with("run: 8 steps are discarded: ") && l.contains("was made from other inputs")), "{err}");
    let (_, err) = sandbox.ok(&["all", "scene.toml"]);
    assert!(!err.contains("discarded"), "{err}");
}

#[test]
fn a_case_with_a_second_mesh_stands_for_itself() {
    let sheet = "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n";
    let scene = with(STATIC, "[rest.pullback]\nbbar = [\"30 * t\", 0, \"10 * x\"]", "[rest.shape.file]\npath = 'rest.obj'");
    let scene = with(&scene, "[mesh.rectangle]\nsize = [0.06, 0.02]\ncells = [6, 2]", "[mesh.file]\npath = 'sheet.obj'");
    let scene =
        with(&scene, "region = \"left\"\ndirector = \"clamped\"\nmotion = { z = \"0.01 * t\" }", "region = 'held'\ndirector = 'clamped'");
    let scene = with(&scene, "element = \"linear\"\n", "");
    let sandbox = Sandbox::new(&format!("{scene}[[region]]\nname = 'held'\nwhere = 'y < 0.05'\n"));
    fs::write(sandbox.path("sheet.obj"), sheet).unwrap();
    fs::write(sandbox.path("rest.obj"), sheet.replace("0.1", "0.101")).unwrap();
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let done = |target: &str| sandbox.ok(&["status", target]).0;
    assert!(!done("cases/scene").contains("out of date"), "{}", done("cases/scene"));
    assert_eq!(done("cases/scene"), done("scene.toml"));
}

//! Files of a case that are damaged, missing, foreign or out of date.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, with};
use std::fs;
use std::path::Path;

fn flip(path: &Path, at: usize) {
    let mut bytes = fs::read(path).unwrap();
    let at = at % bytes.len();
    bytes[at] ^= 0x10;
    fs::write(path, bytes).unwrap();
}

fn truncate(path: &Path, part: f64) {
    let bytes = fs::read(path).unwrap();
    fs::write(path, &bytes[..(bytes.len() as f64 * part) as usize]).unwrap();
}

/// An HDF5 file of another program.
fn other_program(path: &Path) {
    fs::remove_file(path).unwrap();
    let file = hdf5::File::create(path).unwrap();
    file.new_dataset::<f64>().shape([3]).create("vertices").unwrap().write_raw(&[1.0, 2.0, 3.0]).unwrap();
}

#[test]
fn the_checkpoint_before_a_damaged_one_is_used() {
    for scene in [DYNAMIC.to_owned(), STATIC.to_owned(), format!("{DYNAMIC}\n[output]\ninterval = 0.01\n")] {
        let whole = Sandbox::new(&scene).prepared();
        whole.ok(&["run", "scene.toml"]);
        let sandbox = Sandbox::new(&scene).prepared();
        type Damage = (&'static str, fn(&Path));
        let damages: [Damage; 6] = [
            ("is cut off", |p| truncate(p, 0.7)),
            ("is empty", |p| truncate(p, 0.0)),
            ("is damaged", |p| flip(p, 5000)),
            ("is damaged", |p| flip(p, 600)),
            ("is not a file of this program", |p| fs::write(p, "hello\n").unwrap()),
            ("not one of this program", other_program),
        ];
        sandbox.ok(&["run", "scene.toml", "--stop-after", "2"]);
        for (words, damage) in damages {
            let (newest, _) = sandbox.newest();
            damage(&sandbox.case("run").join(&newest));
            let (_, err) = sandbox.ok(&["run", "scene.toml", "--stop-after", "1"]);
            assert!(err.contains("warning: ") && err.contains(&newest) && err.contains(words) && err.contains("skipped"), "{words}: {err}");
            // One step was redone.
            assert_eq!(sandbox.newest().0, newest);
        }
        sandbox.ok(&["run", "scene.toml"]);
        assert!(whole.result() == sandbox.result());
        // Damage of the last one of all.
        truncate(&sandbox.case("run").join(sandbox.newest().0), 0.5);
        assert!(sandbox.ok(&["status", "scene.toml"]).0.contains("unfinished"));
        assert!(sandbox.fails(2, &["report", "scene.toml", "-q"]).contains("the run is not at its end"));
        sandbox.ok(&["all", "scene.toml", "-q"]);
        assert!(whole.result() == sandbox.result());
    }
}

#[test]
fn when_all_checkpoints_are_damaged_the_run_starts_over() {
    let sandbox = Sandbox::new(STATIC).prepared();
    sandbox.ok(&["run", "scene.toml"]);
    let whole = sandbox.result();
    for name in sandbox.names("cases/scene/run") {
        truncate(&sandbox.case("run").join(name), 0.9);
    }
    let (_, err) = sandbox.ok(&["run", "scene.toml"]);
    assert_eq!(err.matches("is cut off").count(), 9, "{err}");
    assert!(err.contains("starting from the setup"), "{err}");
    assert!(sandbox.result() == whole);
}

#[test]
fn a_damaged_film_frame_is_left_out() {
    let sandbox = Sandbox::new(STATIC);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    flip(&sandbox.case("run/step_00000003.h5"), 3000);
    let (_, err) = sandbox.ok(&["export", "scene.toml"]);
    assert!(err.contains("step_00000003.h5") && err.contains("left out") && err.contains("8 states"), "{err}");
    assert!(!sandbox.case("vtk/step_00000003.vtp").exists());
}

#[test]
fn damaged_stage_files_are_refused_by_name() {
    let other = Sandbox::new(&with(STATIC, "cells = [6, 2]", "cells = [5, 2]")).prepared();
    for (file, verb, after) in [("mesh.h5", "mesh", "setup"), ("mesh.h5", "mesh", "run"), ("setup.h5", "setup", "run")] {
        let sandbox = Sandbox::new(STATIC).prepared();
        sandbox.ok(&["run", "scene.toml", "-q"]);
        let path = sandbox.case(file);
        let good = fs::read(&path).unwrap();
        let before = sandbox.result();
        let another = if file == "mesh.h5" { "setup.h5" } else { "mesh.h5" };
        let refuse = |words: &str| {
            let message = sandbox.fails(2, &[after, "scene.toml"]);
            assert!(
                message.contains(file) && message.contains(words) && message.contains(&format!("thinshell {verb} scene.toml")),
                "{words}: {message}"
            );
            assert!(sandbox.result() == before);
            fs::write(&path, &good).unwrap();
        };
        truncate(&path, 0.6);
        refuse("is cut off");
        flip(&path, good.len() - 7);
        refuse("is damaged");
        fs::write(&path, "a plain text\n").unwrap();
        refuse("is not a file of this program");
        other_program(&path);
        refuse("is an HDF5 file, but not one of this program");
        fs::remove_file(&path).unwrap();
        refuse("does not exist");
        fs::copy(other.case(file), &path).unwrap();
        refuse("was made from other inputs");
        fs::copy(sandbox.case(another), &path).unwrap();
        refuse("holds a ");
        fs::copy(sandbox.case("run").join(sandbox.newest().0), &path).unwrap();
        refuse("holds a checkpoint");
        truncate(&path, 0.6);
        sandbox.ok(&["all", "scene.toml", "-q"]);
        assert_eq!(fs::read(&path).unwrap(), good, "made anew, it is the same");
    }
}

#[test]
fn a_changed_scene_is_refused_with_the_verb_to_rerun() {
    let scene = format!("{DYNAMIC}\n[[region]]\nname = 'part'\nwhere = 'x > 0.04'\n");
    let sandbox = Sandbox::new(&scene);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let changes = [
        ("mesh.rectangle.cells=[6, 3]", "thinshell mesh scene.toml"),
        ("mesh.rectangle.size=[0.06, 0.021]", "thinshell mesh scene.toml"),
        ("region.0.where='x > 0.03'", "thinshell mesh scene.toml"),
        ("shell.thickness=2e-3", "thinshell setup scene.toml"),
        ("shell.director='average'", "thinshell setup scene.toml"),
        ("shell.viscosity=0.02", "thinshell setup scene.toml"),
        ("shell.region=[{region='part', density=2000}]", "thinshell setup scene.toml"),
        ("rest.linear.mu=0.02", "thinshell setup scene.toml"),
        ("rest.ramp='t'", "thinshell setup scene.toml"),
        ("gravity.acceleration=[0, 0, -9.8]", "thinshell setup scene.toml"),
        ("gravity.factor='cos(40 * t)'", "thinshell setup scene.toml"),
        ("pin.0.components=['x', 'z']", "thinshell setup scene.toml"),
        ("pin.0.motion.z='0.001 * t'", "thinshell setup scene.toml"),
        ("dynamics.velocity=[0, 0, 0]", "thinshell setup scene.toml"),
        ("dynamics.dt=1e-3", "thinshell run scene.toml"),
        ("solver.tolerance=1e-8", "thinshell run scene.toml"),
        ("solver.max_halvings=3", "thinshell run scene.toml"),
    ];
    let before = sandbox.result();
    for (change, remedy) in changes {
        for verb in ["run", "export", "report"] {
            let message = sandbox.fails(2, &[verb, "scene.toml", "--set", change]);
            assert!(message.contains("was made from other inputs") && message.contains(remedy), "{verb} {change}: {message}");
        }
        let (out, _) = sandbox.ok(&["status", "scene.toml", "--set", change]);
        assert!(out.contains("out of date"), "{change}: {out}");
    }
    assert!(sandbox.result() == before);
    sandbox.ok(&["export", "scene.toml"]);
}

#[test]
fn all_redoes_what_is_out_of_date_and_nothing_else() {
    let sandbox = Sandbox::new(DYNAMIC);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let whole = sandbox.result();
    for (change, redone, kept) in [
        ("dynamics.dt=1e-3", &["run"][..], &["mesh.h5", "setup.h5"][..]),
        ("rest.linear.mu=0.02", &["setup.h5"], &["mesh.h5"]),
        ("mesh.rectangle.cells=[5, 2]", &["mesh.h5", "setup.h5"], &[]),
    ] {
        let bytes = |names: &[&str]| -> Vec<Vec<u8>> {
            names.iter().filter(|n| n.ends_with(".h5")).map(|n| fs::read(sandbox.case(n)).unwrap()).collect()
        };
        let times =
            |names: &[&str]| -> Vec<_> { names.iter().map(|n| fs::metadata(sandbox.case(n)).unwrap().modified().unwrap()).collect() };
        let (old, old_times) = (bytes(redone), times(kept));
        sandbox.ok(&["all", "scene.toml", "-q", "--set", change]);
        assert_eq!(times(kept), old_times, "{change}");
        assert!(old.is_empty() || bytes(redone) != old, "{change}");
        assert!(sandbox.result().2 != whole.2, "{change}");
        sandbox.ok(&["all", "scene.toml", "-q"]);
        assert!(sandbox.result() == whole, "{change}");
    }
}

#[test]
fn a_damaged_history_is_named() {
    let sandbox = Sandbox::new(STATIC).prepared();
    sandbox.ok(&["run", "scene.toml"]);
    let whole = sandbox.result();
    fs::write(sandbox.case("history.csv"), "not,a,history\n").unwrap();
    let message = sandbox.fails(2, &["run", "scene.toml"]);
    assert!(message.contains("history.csv"), "{message}");
    assert!(sandbox.fails(2, &["report", "scene.toml"]).contains("history.csv"));
    sandbox.ok(&["run", "scene.toml", "--restart"]);
    assert!(sandbox.result() == whole);
}

#[test]
fn status_tells_how_far_a_case_is() {
    let sandbox = Sandbox::new(DYNAMIC);
    let lines = |arguments: &[&str]| -> Vec<String> { sandbox.ok(arguments).0.lines().map(str::to_owned).collect() };
    let status = ["status", "scene.toml"];
    assert_eq!(lines(&status), ["mesh    missing", "setup   missing", "run     missing", "export  missing", "report  missing"]);
    assert_eq!(sandbox.names("."), ["scene.toml"], "status wrote something");
    sandbox.ok(&["mesh", "scene.toml", "-q"]);
    assert_eq!(lines(&status)[..2], ["mesh    done", "setup   missing"]);
    sandbox.ok(&["setup", "scene.toml", "-q"]);
    sandbox.ok(&["run", "scene.toml", "-q", "--stop-after", "4"]);
    assert_eq!(lines(&status)[1..4], ["setup   done", "run     unfinished: 4 steps to t = 0.008 s", "export  missing"]);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    assert_eq!(lines(&status), ["mesh    done", "setup   done", "run     done: 20 steps to t = 0.04 s", "export  done", "report  done"]);
    let changed = lines(&["status", "scene.toml", "--set", "rest.linear.mu=0.1"]);
    let setup = "setup   out of date: was made from other inputs than the present ones: rest.linear.mu was 0.01, is 0.1";
    assert_eq!(changed[..2], ["mesh    done", setup]);
    assert!(changed[2].starts_with("run     out of date"), "{changed:?}");
    truncate(&sandbox.case("mesh.h5"), 0.5);
    assert!(lines(&status)[0].starts_with("mesh    out of date: is cut off"), "{:?}", lines(&status));
}

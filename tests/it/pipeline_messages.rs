//! What the program says: the place of a fault in the scene, the command that mends, slips of the unit in mesh files, parts of a mesh.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, with};
use std::fs;
use std::process::Command;

/// Line and column of a text in a scene, as in `scene.toml:3:5`.
fn place(scene: &str, text: &str) -> String {
    let before = &scene[..scene.find(text).unwrap()];
    let line = before.matches('\n').count() + 1;
    format!("scene.toml:{line}:{}", before.len() - before.rfind('\n').map_or(0, |at| at + 1) + 1)
}

#[test]
fn faults_that_the_mesh_tells_have_line_and_key() {
    let orthotropic = with(STATIC, "[gravity]", "[rest.orthotropic]\nangle = 0\nfactors = ['1 - 30 * t * x', 1]\n[gravity]");
    let force = format!("{STATIC}[[force]]\nregion = 'right'\nforce = [0, 0, 1]\nfactor = '1 / t'\n");
    for (scene, at, words) in [
        (with(DYNAMIC, "\"left\"", "\"lefd\""), "\"lefd\"", &["pin.0.region = \"lefd\": there is no region 'lefd'"][..]),
        (with(DYNAMIC, "\"0.002 * sin(60 * t)\"", "\"ln(-t)\""), "\"ln(-t)\"", &["pin.0.motion.z", "is -inf at t = 0"]),
        (force, "'1 / t'", &["force.0.factor = \"1 / t\": is inf at t = 0"]),
        (orthotropic, "[rest.orthotropic]", &["rest.orthotropic: face ", " at (0.0", " m, t = 1: the growth factor -"]),
        (with(DYNAMIC, "\"-2 * t\"", "-101"), "[rest.linear]", &["rest.linear: face 0 at (", "t = 0: m_minus = -101 %", "bone dry"]),
        (with(DYNAMIC, "m_minus = \"-2 * t\"\nmu", "m_minus = -50\nmu"), "", &[]),
    ] {
        let sandbox = Sandbox::new(&scene);
        if at.is_empty() {
            sandbox.ok(&["check", "scene.toml"]);
            continue;
        }
        for verb in ["check", "all"] {
            let message = sandbox.fails(2, &[verb, "scene.toml"]);
            assert!(message.contains(&format!("error: {}: ", place(&scene, at))), "{verb}: {message}");
            assert!(words.iter().all(|w| message.contains(w)), "{words:?}: {message}");
        }
    }
    // The same from an override, and on the way.
    let sandbox = Sandbox::new(DYNAMIC);
    let message = sandbox.fails(2, &["check", "scene.toml", "--set", "pin.0.region=lefd"]);
    assert!(message.contains("--set:1:14: pin.0.region = \"lefd\" (from --set): there is no region 'lefd'"), "{message}");
    let late = with(&with(DYNAMIC, "\"-2 * t\"", "\"-9000 * t\""), "mu = 0.01", "mu = 1e-4");
    let sandbox = Sandbox::new(&late);
    let message = sandbox.fails(2, &["all", "scene.toml", "-q"]);
    assert!(message.contains(&format!("{}: rest.linear: face ", place(&late, "[rest.linear]"))), "{message}");
    assert!(message.contains("t = 0.012") && message.contains("bone dry") && message.contains("step_00000005.h5"), "{message}");
}

#[test]
fn moisture_may_reach_bone_dry_and_no_less() {
    for (law, key) in [("linear", "mu = 0.001"), ("bilayer", "mu = [0.001, 0.001]")] {
        let scene = |m: &str| {
            let laws = format!("[rest.{law}]\nm_plus = {m}\nm_minus = 0\n{key}\n[gravity]");
            with(&with(STATIC, "[rest.pullback]\nbbar = [\"30 * t\", 0, \"10 * x\"]\n", ""), "[gravity]", &laws)
        };
        Sandbox::new(&scene("'-100 * t'")).ok(&["check", "scene.toml"]);
        let message = Sandbox::new(&scene("'-100.1 * t'")).fails(2, &["check", "scene.toml"]);
        assert!(message.contains(&format!("rest.{law}: face 0 at (")) && message.contains("m_plus = -100.1 %"), "{message}");
    }
}

#[test]
fn a_mesh_file_that_is_not_there_is_named_with_its_key() {
    let scene = with(DYNAMIC, "[mesh.rectangle]\nsize = [0.06, 0.02]\ncells = [6, 2]", "[mesh.file]\npath = 'none.obj'");
    let sandbox = Sandbox::new(&scene);
    for verb in ["check", "mesh", "run", "all", "status"] {
        let message = sandbox.fails(2, &[verb, "scene.toml"]);
        let words = format!("{}: mesh.file.path = \"none.obj\": cannot read ", place(&scene, "'none.obj'"));
        assert!(message.contains(&words), "{verb}: {message}");
    }
}

/// A square of two faces with sides of that length, one of its corners lifted.
fn square(side: f64, lift: f64) -> String {
    format!("v 0 0 0\nv {side} 0 0\nv {side} {side} {lift}\nv 0 {side} 0\nf 1 2 3\nf 1 3 4\n")
}

#[test]
fn a_mesh_in_mm_is_suspected_and_kinks_are_told_of_curved_meshes() {
    let scene = "[mesh.file]\npath = 'sheet.obj'\n[shell]\nthickness = 1e-4\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\ndensity = 800\n[dynamics]\ndt = 0.1\nend = 1\n";
    let sandbox = Sandbox::new(scene);
    for (side, lift, scale, in_mm, kinks) in
        [(80.0, 0.0, "1", true, false), (80.0, 0.0, "1e-3", false, false), (0.1, 0.0, "1", false, false), (0.1, 0.01, "1", false, true)]
    {
        fs::write(sandbox.path("sheet.obj"), square(side, lift)).unwrap();
        let set = format!("mesh.file.scale={scale}");
        let (_, err) = sandbox.ok(&["all", "scene.toml", "--set", &set]);
        assert_eq!(err.matches("is the mesh in mm? mesh.file.scale = 1e-3").count(), usize::from(in_mm), "{err}");
        assert_eq!(err.matches("its faces are flat").count(), usize::from(kinks), "{err}");
    }
}

#[test]
fn a_sweep_over_what_is_no_key_or_value_is_refused_at_once() {
    let sweep = |key: &str, values: &str| {
        format!(
            "{STATIC}[[report.sweep]]\nname = 's'\nkey = '{key}'\nvalues = {values}\nmeasures = [{{ name = 'e', measure = {{ energy = {{}} }} }}]\n"
        )
    };
    for (key, values, at, words) in [
        ("shell.thicknes", "[1e-3, 2e-3]", "'shell.thicknes'", "report.sweep.0.key = \"shell.thicknes\": shell.thicknes: unknown key"),
        ("shell.thickness.x", "[1e-3, 2e-3]", "'shell.thickness.x'", "it has no keys"),
        ("shell.thickness", "[1e-3, -2e-3]", "-2e-3", ": must be > 0 [m]"),
    ] {
        let scene = sweep(key, values);
        let sandbox = Sandbox::new(&scene);
        for arguments in [&["check", "scene.toml"][..], &["all", "scene.toml"], &["report", "--sweep", "scene.toml"]] {
            let message = sandbox.fails(2, arguments);
            assert!(message.contains(&format!("error: {}: ", place(&scene, at))) && message.contains(words), "{message}");
        }
        assert_eq!(sandbox.names("."), ["scene.toml"]);
    }
    // What only the mesh tells is told of the value too.
    let scene = sweep("pin.0.region", "['left', 'lefd']");
    let message = Sandbox::new(&scene).fails(2, &["report", "--sweep", "scene.toml"]);
    assert!(message.contains(&format!("{}: report.sweep.0.values.1", place(&scene, "'lefd'"))), "{message}");
    assert!(message.contains("with lefd, pin.0.region: there is no region 'lefd'"), "{message}");
}

#[test]
fn a_stale_file_is_told_with_what_differs_and_the_command_to_type() {
    let sandbox = Sandbox::new(STATIC);
    sandbox.ok(&["all", "scene.toml", "-q", "--case", "my case"]);
    let arguments = ["report", "scene.toml", "--set", "rest.pullback.bbar=['40 * t', 0, 0]"];
    let message = sandbox.fails(2, &arguments);
    assert!(message.contains("thinshell mesh scene.toml --set 'rest.pullback.bbar=['\\''40 * t'\\'', 0, 0]'"), "{message}");
    sandbox.rewrite(&with(STATIC, "thickness = 1e-3", "thickness = 2e-3"));
    let message = sandbox.fails(2, &["run", "scene.toml", "--case", "my case"]);
    assert!(message.contains("other inputs than the present ones: shell.thickness was 0.001, is 0.002"), "{message}");
    assert!(message.contains("thinshell setup scene.toml --case 'my case', or "), "{message}");
    assert!(message.contains("thinshell all scene.toml --case 'my case'"), "{message}");
    let (out, _) = sandbox.ok(&["status", "scene.toml", "--case", "my case"]);
    assert_eq!(out.lines().count(), 5, "{out}");
    assert!(out.contains("setup   out of date: ") && out.contains("export  out of date\nreport  out of date"), "{out}");
}

#[test]
fn check_lists_regions_and_foresees_a_mechanism() {
    let (out, err) = Sandbox::new(STATIC).ok(&["check", "scene.toml"]);
    assert!(out.contains("left: 3 vertices, 2 edges, 0 faces\n") && err.is_empty(), "{out}{err}");
    let free = with(STATIC, "director = \"clamped\"\nmotion = { z = \"0.01 * t\" }", "components = ['z']");
    let (_, err) = Sandbox::new(&free).ok(&["check", "scene.toml"]);
    assert!(err.contains("the pins hold 3 unknowns, but a free body moves in 6 ways"), "{err}");
    let sweep = "[[report.sweep]]\nname = 's'\nkey = 'shell.thickness'\nvalues = [1e-3, 2e-3]\nmeasures = [{ name = 'e', measure = { energy = {} } }]\n";
    let (out, _) = Sandbox::new(&format!("{STATIC}{sweep}")).ok(&["check", "scene.toml"]);
    assert!(out.contains(", 1 sweep\n"), "{out}");
}

#[test]
fn the_list_of_keys_tells_types_defaults_and_meanings() {
    let sandbox = Sandbox::new(STATIC);
    let (all, _) = sandbox.ok(&["schema", "--text"]);
    for line in [
        "[shell]",
        "[pin]",
        "[rest.linear]",
        "[report.sweep]",
        "  thickness: number",
        "  title: text, default \"\"",
        "  size: array of 2 (number)",
    ] {
        assert!(all.lines().any(|l| l.starts_with(line)), "{line} is not in\n{all}");
    }
    let (shell, _) = sandbox.ok(&["schema", "--text", "shell"]);
    assert!(all.contains(&shell) && shell.starts_with("[shell]") && !shell.contains("[pin]"), "{shell}");
    assert!(shell.contains("  element: \"linear\" or \"quadratic\", default "), "{shell}");
    assert!(sandbox.fails(2, &["schema", "--text", "shel"]).contains("there are: "));
}

#[test]
fn scripts_run_in_the_folder_of_the_caller() {
    let sandbox = Sandbox::new(STATIC);
    // A copy of the script with a Python of its own, so that no package is needed.
    let root = sandbox.path("repository");
    for folder in [".ci", "post/.venv/bin"] {
        fs::create_dir_all(root.join(folder)).unwrap();
    }
    fs::copy(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/post.sh"), root.join(".ci/post.sh")).unwrap();
    fs::write(root.join("post/.venv/bin/python"), "#!/bin/sh\ncase \"$1\" in *graphics.py) exit 0;; esac\necho \"$(pwd)|$*\"\n").unwrap();
    for name in ["post/requirements.txt", "post/.venv/requirements.txt", "post/script.py"] {
        fs::write(root.join(name), "").unwrap();
    }
    assert!(Command::new("chmod").args(["+x", root.join("post/.venv/bin/python").to_str().unwrap()]).status().unwrap().success());
    let run = || {
        let output =
            Command::new("sh").arg(root.join(".ci/post.sh")).args(["post/script.py", "cases/a b"]).current_dir(sandbox.path(".")).output();
        String::from_utf8(output.unwrap().stdout).unwrap()
    };
    let here = fs::canonicalize(sandbox.path(".")).unwrap();
    let there = fs::canonicalize(&root).unwrap();
    assert_eq!(run().trim(), format!("{}|{}/post/script.py cases/a b", here.display(), there.display()));
    fs::create_dir(sandbox.path("post")).unwrap();
    fs::write(sandbox.path("post/script.py"), "").unwrap();
    assert_eq!(run().trim(), format!("{}|post/script.py cases/a b", here.display()));
}

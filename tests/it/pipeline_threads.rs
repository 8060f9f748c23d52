//! Any number of threads leaves the same files, bit by bit.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, with};
use std::fs;

/// Meshes that are large enough for threads to share the work.
fn large(scene: &str, cells: &str) -> String {
    let scene = with(scene, "cells = [6, 2]", &format!("cells = {cells}"));
    with(&scene, "element = \"linear\"", "element = \"linear\" # or not")
}

const MOISTURE: &str = r#"
[moisture]
layers = 4
diffusivity = { through = 1e-6, along = 1e-5 }
[[moisture.boundary]]
side = "top"
value = 10
[rest.linear]
mu = 1e-3
"#;

fn quadratic(scene: &str) -> String {
    with(scene, "element = \"linear\" # or not", "element = \"quadratic\"")
}

#[test]
fn any_number_of_threads_leaves_the_same_files() {
    let statics = with(&large(STATIC, "[40, 10]"), "steps = 8", "steps = 1");
    let motion = with(&large(DYNAMIC, "[100, 12]"), "end = 0.04", "end = 0.004");
    let own = "[rest.linear]\nm_plus = \"3 * sin(40 * t + 30 * x)\"\nm_minus = \"-2 * t\"\nmu = 0.01\n";
    let moist = with(&with(&motion, own, MOISTURE), "[rest]\nramp = \"min(1, 20 * t)\"\n", "");
    let scenes =
        [("statics", quadratic(&statics)), ("motion", motion.clone()), ("moisture", quadratic(&with(&moist, "[100, 12]", "[30, 10]")))];
    for (name, scene) in scenes {
        let run = |threads: &str| {
            let sandbox = Sandbox::new(&scene).prepared();
            let (_, err) = sandbox.ok(&["run", "scene.toml", "-v", "--threads", threads]);
            // The matrix of the shell is worth several threads.
            assert!(err.contains(&format!("multiplications; threads: {threads}")), "{name} {threads}: {err}");
            let files: Vec<(String, Vec<u8>)> = sandbox
                .names("cases/scene/run")
                .into_iter()
                .map(|file| (file.clone(), fs::read(sandbox.case("run").join(file)).unwrap()))
                .collect();
            (files, sandbox.history())
        };
        let (files, history) = run("1");
        assert!(files.len() > 1);
        for threads in ["2", "3"] {
            let (others, other_history) = run(threads);
            assert_eq!(history, other_history, "{name}");
            assert!(files == others, "{name}: checkpoints by {threads} threads differ");
        }
    }
}

#[test]
fn the_number_of_threads_is_checked() {
    let sandbox = Sandbox::new(STATIC);
    for threads in ["0", "-1", "many", "100000"] {
        assert_eq!(sandbox.output(&["check", "scene.toml", "--threads", threads]).status.code(), Some(2), "{threads}");
        let output = sandbox.command(&["check", "scene.toml"]).env("THINSHELL_THREADS", threads).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{threads}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("THINSHELL_THREADS"), "{threads}");
    }
    let output = sandbox.command(&["check", "scene.toml"]).env("THINSHELL_THREADS", "2").output().unwrap();
    assert_eq!(output.status.code(), Some(0));
}

//! The command line of the real program: usage, help, log file, broken pipes.

use std::path::Path;
use std::process::{Command, Output};

const FULL: &str = include_str!("full.toml");
const VERBS: [&str; 9] = ["check", "mesh", "setup", "run", "export", "report", "status", "all", "schema"];

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_thinshell")).args(arguments).current_dir(folder).output().expect("the program starts")
}

/// A fresh folder with the full scene in it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), FULL).unwrap();
    folder
}

#[test]
fn wrong_usage_exits_with_2() {
    let folder = folder();
    for arguments in [
        &[][..],
        &["fly"],
        &["check"],
        &["check", "scene.toml", "--fast"],
        &["run", "scene.toml", "--stop-after", "0"],
        &["run", "scene.toml", "--stop-after", "-1"],
        &["report"],
        &["report", "--ladder", "scene.toml", "cases/scene"],
        &["check", "-q", "-v", "scene.toml"],
        &["check", "scene.toml", "--set"],
        &["check", "scene.toml", "--set", "shell.thickness"],
        &["check", ".."],
    ] {
        let output = run(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "something was written");
}

#[test]
fn every_verb_has_help_with_an_example() {
    let folder = folder();
    for verb in VERBS {
        let output = run(folder.path(), &[verb, "--help"]);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && text.contains(&format!("thinshell {verb}")) && text.contains("Example"), "{verb}: {text}");
    }
    let text = String::from_utf8(run(folder.path(), &["--help"]).stdout).unwrap();
    assert!(VERBS.iter().all(|verb| text.contains(verb)) && text.contains("Exit codes"), "{text}");
}

#[test]
fn check_lists_the_parts_and_writes_nothing() {
    let folder = folder();
    let output = run(folder.path(), &["check", "scene.toml"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success());
    for part in ["mesh", "shell", "rest", "gravity", "pin", "dynamics", "report"] {
        assert!(text.lines().any(|line| line.starts_with(part)), "{part} is not in {text}");
    }
    assert!(!text.contains("statics"), "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "something was written");
}

#[test]
fn suspicions_are_warnings() {
    let folder = folder();
    let output = run(folder.path(), &["check", "scene.toml", "-q", "--set", "shell.density=1"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let output = run(folder.path(), &["check", "scene.toml", "-q", "--set", "shell.density=0.5"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && message.starts_with("warning: shell.density = 0.5"), "{message}");
}

#[test]
fn the_log_file_tells_what_went_wrong() {
    let folder = folder();
    for _ in 0..2 {
        let output = run(folder.path(), &["check", "scene.toml", "--log", "log.txt", "--set", "shell.thickness=-1"]);
        assert_eq!(String::from_utf8(output.stderr).unwrap().matches("must be > 0").count(), 1);
    }
    let log = std::fs::read_to_string(folder.path().join("log.txt")).unwrap();
    assert_eq!(log.matches("ERROR error: --set:1:17: shell.thickness = -1 (from --set): must be > 0 [m]").count(), 2, "{log}");
    assert_eq!(run(folder.path(), &["check", "scene.toml", "--log", "absent/log.txt"]).status.code(), Some(2));
}

#[test]
fn the_schema_knows_every_table() {
    let folder = folder();
    let output = run(folder.path(), &["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for key in ["title", "mesh", "region", "shell", "rest", "gravity", "pin", "statics", "dynamics", "solver", "output", "report"] {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn closed_pipes_are_no_panic() {
    let folder = folder();
    for arguments in [&["schema"][..], &["check", "scene.toml"], &["check", "absent.toml"], &["--help"]] {
        let closed = || std::io::pipe().map(|(_, writer)| writer).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_thinshell"));
        let status = program.args(arguments).current_dir(folder.path()).stdout(closed()).stderr(closed()).status().unwrap();
        let expected = if arguments.contains(&"absent.toml") { 2 } else { 0 };
        assert_eq!(status.code(), Some(expected), "{arguments:?}");
    }
}

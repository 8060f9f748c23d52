//! Runs the real program on small scenes in fresh folders.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use tempfile::TempDir;

/// Everything that a step carries on to the next: viscosity, gravity with a factor, growth in time, pins that move, velocity.
pub const DYNAMIC: &str = r#"
title = "dynamic"
[mesh.rectangle]
size = [0.06, 0.02]
cells = [6, 2]
[shell]
element = "linear"
thickness = 1e-3
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000.0
viscosity = 0.01
[rest]
ramp = "min(1, 20 * t)"
[rest.linear]
m_plus = "3 * sin(40 * t + 30 * x)"
m_minus = "-2 * t"
mu = 0.01
[gravity]
factor = "cos(50 * t)"
[[pin]]
region = "left"
director = "clamped"
motion = { z = "0.002 * sin(60 * t)" }
[dynamics]
dt = 2e-3
end = 0.04
velocity = [0, "x", 0]
"#;

/// Load steps with growth, gravity and a pin that moves.
pub const STATIC: &str = r#"
title = "static"
[mesh.rectangle]
size = [0.06, 0.02]
cells = [6, 2]
[shell]
element = "linear"
thickness = 1e-3
youngs_modulus = 1e8
poissons_ratio = 0.3
density = 1000.0
[rest.pullback]
bbar = ["30 * t", 0, "10 * x"]
[gravity]
[[pin]]
region = "left"
director = "clamped"
motion = { z = "0.01 * t" }
[statics]
steps = 8
"#;

/// A scene file in a fresh folder.
pub struct Sandbox {
    folder: TempDir,
}

impl Sandbox {
    pub fn new(scene: &str) -> Self {
        let sandbox = Sandbox { folder: tempfile::tempdir().unwrap() };
        sandbox.rewrite(scene);
        sandbox
    }

    /// Replaces the scene file.
    pub fn rewrite(&self, scene: &str) {
        fs::write(self.path("scene.toml"), scene).unwrap();
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Path in the case's folder.
    pub fn case(&self, name: &str) -> PathBuf {
        self.path("cases/scene").join(name)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thinshell"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    pub fn output(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    pub fn spawn(&self, arguments: &[&str]) -> Child {
        self.command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Runs to success; returns standard output and error.
    pub fn ok(&self, arguments: &[&str]) -> (String, String) {
        let output = self.output(arguments);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {out}{err}");
        (out, err)
    }

    /// Runs to failure with this code, exactly one error and no panic; returns standard error.
    pub fn fails(&self, code: i32, arguments: &[&str]) -> String {
        let output = self.output(arguments);
        let err = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}{err}", text(&output.stdout));
        assert_eq!(err.matches("error: ").count(), 1, "{arguments:?}: {err}");
        assert!(!err.contains("panicked"), "{err}");
        err
    }

    /// `mesh` and `setup`.
    pub fn prepared(self) -> Self {
        self.ok(&["mesh", "scene.toml", "-q"]);
        self.ok(&["setup", "scene.toml", "-q"]);
        self
    }

    /// Names in a folder, sorted.
    pub fn names(&self, folder: &str) -> Vec<String> {
        names(&self.path(folder))
    }

    /// Name and bytes of the newest checkpoint.
    pub fn newest(&self) -> (String, Vec<u8>) {
        let name = self.names("cases/scene/run").into_iter().rfind(|n| n.starts_with("step_")).unwrap();
        let bytes = fs::read(self.case("run").join(&name)).unwrap();
        (name, bytes)
    }

    /// Rows of the history without the run time.
    pub fn history(&self) -> Vec<String> {
        let text = fs::read_to_string(self.case("history.csv")).unwrap();
        text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect()
    }

    /// Everything that a run leaves and that must not depend on how often it was stopped: newest checkpoint, names of all, history.
    pub fn result(&self) -> ((String, Vec<u8>), Vec<String>, Vec<String>) {
        (self.newest(), self.names("cases/scene/run"), self.history())
    }
}

pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Exchanges a part of a scene that must be there.
pub fn with(scene: &str, from: &str, to: &str) -> String {
    assert!(scene.contains(from), "{from} is not in the scene");
    scene.replacen(from, to, 1)
}

//! The verbs, one file each. A stage reads the scene and the files of the stages before it, and writes its own.

pub mod all;
mod build;
mod changes;
pub mod check;
mod diffusion;
pub mod export;
mod fields;
mod grid;
mod grid_fields;
mod loads;
mod materials;
pub mod mesh;
pub mod modes;
mod perturbation;
pub mod report;
mod rest;
pub mod run;
pub mod setup;
pub mod status;
mod stepping;
mod supports;
mod velocity;

use crate::case::atomic;
use crate::error::{Error, Result};
use crate::scene::{self, Scene};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A scene and the folder in which it is worked on.
#[derive(Clone, Debug)]
pub struct Job {
    /// The checked scene.
    pub scene: Scene,
    /// Where it was read from; paths in the scene are relative to its folder.
    pub scene_file: PathBuf,
    /// Its text and overrides.
    pub source: scene::Source,
    /// Folder of the case; made by the first stage that writes.
    pub case: PathBuf,
    /// Whether to show no progress.
    pub quiet: bool,
}

impl Job {
    /// Reads and checks the scene, or that of a case's folder; writes nothing. `case`: its folder, by default [`default_case`]. `overrides`: `key=value` each.
    ///
    /// # Errors
    /// Those of [`scene::read`].
    pub fn read(scene_file: &Path, case: Option<&Path>, overrides: &[String], quiet: bool) -> Result<Self> {
        if scene_file.is_dir() && scene_file.join(RECORD).is_file() {
            return Self::read(&scene_file.join(RECORD), Some(case.unwrap_or(scene_file)), overrides, quiet);
        }
        let scene::SceneFile { scene, path, source } = scene::read(scene_file, overrides)?;
        for suspicion in scene::suspicions(&scene) {
            log::warn!("{suspicion}");
        }
        let case = match case {
            Some(case) => case.to_path_buf(),
            None => default_case(scene_file)?,
        };
        Ok(Job { scene, scene_file: path, source, case, quiet })
    }

    /// Name of the scene in reports: that of its file, or of the case's folder if it was read from there.
    pub fn name(&self) -> String {
        let case = std::path::absolute(&self.case).unwrap_or_else(|_| self.case.clone());
        let name = if self.is_recorded() { case.file_name() } else { self.scene_file.file_stem() };
        name.map_or_else(|| self.case.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// Whether the scene was read from the case's own record.
    fn is_recorded(&self) -> bool {
        self.scene_file == self.case.join(RECORD)
    }

    /// Writes the scene with all defaults and overrides into the case, so that the case can be understood and reported on by itself.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn record(&self) -> Result<()> {
        if self.is_recorded() {
            return Ok(());
        }
        atomic::write(&self.case.join(RECORD), scene::to_toml(&self.self_contained()?).as_bytes())
    }

    /// The scene with paths that do not depend on where its file is.
    fn self_contained(&self) -> Result<Scene> {
        let mut scene = self.scene.clone();
        let shape = match scene.rest.as_mut().and_then(|rest| rest.shape.as_mut()) {
            Some(scene::Shape::File(table)) => Some(&mut table.path),
            _ => None,
        };
        for file in scene.mesh.file_mut().into_iter().chain(shape) {
            let path = self.scene_file.parent().unwrap_or(Path::new("")).join(&*file);
            *file = std::path::absolute(&path).map_err(|e| Error::io("find", &path, e))?;
        }
        Ok(scene)
    }

    /// Adds to an error what only the job knows: line and column of a key of the scene, what has changed since a file was made, and the
    /// real command in the place of `SCENE`.
    pub fn explain(&self, error: Error) -> Error {
        match error {
            Error::Stale { path, mut message, help } => {
                let changes = if message.contains("other inputs") { changes::since(self) } else { None };
                message.extend(changes.map(|changes| format!(": {changes}")));
                Error::Stale { path, message, help: help.replace("SCENE", &self.arguments()) }
            }
            other => self.source.locate(other),
        }
    }

    /// Arguments of a command that is about this scene in this case.
    fn arguments(&self) -> String {
        let scene = if self.is_recorded() { &self.case } else { &self.scene_file };
        let mut words = vec![quoted(&scene.display().to_string())];
        if !self.is_recorded() && default_case(&self.scene_file).ok().as_ref() != Some(&self.case) {
            words.push(format!("--case {}", quoted(&self.case.display().to_string())));
        }
        words.extend(self.source.overrides().map(|text| format!("--set {}", quoted(text))));
        words.join(" ")
    }

    /// A time in words: seconds, or in statics the load factor.
    fn moment(&self, time: f64) -> String {
        // Without the last digits, where sums of steps show their round-off.
        let time = format!("{time:.11e}").parse().unwrap_or(time);
        if !self.scene.runs_in_time() { format!("load factor {time}") } else { format!("t = {time} s") }
    }

    /// Says something about the progress of a stage.
    fn say(&self, text: &str) {
        if !self.quiet {
            log::info!("{text}");
        }
    }
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./=+:,@%".contains(c);
    if word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// The scene as it was run, in the case's folder.
const RECORD: &str = "case.toml";

/// `cases/NAME` in the current folder, NAME being the scene file's without its extension.
///
/// # Errors
/// [`Error::Input`] if the path names no file.
pub fn default_case(scene_file: &Path) -> Result<PathBuf> {
    let stem = scene_file.file_stem().ok_or_else(|| Error::input(scene_file.display().to_string(), "this path names no scene file"))?;
    Ok(Path::new("cases").join(stem))
}

/// Writes a line (or several) to standard output. A reader that has gone away, as `head` does, is not an error.
///
/// # Errors
/// [`Error::Io`] if it cannot be written for another reason.
pub fn print(text: &str) -> Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::io("write", Path::new("standard output"), error)),
        _ => Ok(()),
    }
}

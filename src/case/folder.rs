//! The checkpoints of a case: `run/step_NNNNNNNN.h5`.
//!
//! Decides which file a run goes on from and which ones it may remove. It does not decide when a checkpoint is due.

use super::{Archive, Kind, convert, hash};
use crate::error::{Error, Result};
use crate::snapshot::Snapshot;
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The folder of a case, as far as checkpoints go.
#[derive(Debug)]
pub struct Folder {
    case: PathBuf,
    /// Hash of what the checkpoints are made from.
    inputs: String,
    /// Whether a checkpoint stays, for those that this object wrote or looked into.
    keeps: BTreeMap<u64, bool>,
}

/// The right to write into a case; ends when dropped or when the process ends, however it ends.
#[derive(Debug)]
pub struct Lock(File);

impl Drop for Lock {
    fn drop(&mut self) {
        // Closing the file is not enough: a program that another thread is just starting has it open until it has started. If this fails, the
        // end of the last of them ends the lock.
        let _ = self.0.unlock();
    }
}

/// The checkpoint that a run goes on from.
#[derive(Debug, Default)]
pub struct Newest {
    /// The newest undamaged checkpoint, if there is one.
    pub snapshot: Option<Snapshot>,
    /// One line for each newer file that could not be used.
    pub warnings: Vec<String>,
}

impl Folder {
    /// The folder `case`, which need not exist yet. `inputs`: hash of what its checkpoints are made from.
    pub fn new(case: impl Into<PathBuf>, inputs: impl Into<String>) -> Self {
        Folder { case: case.into(), inputs: inputs.into(), keeps: BTreeMap::new() }
    }

    /// Takes the right to write into the case. Error: [`Error::Input`] if another process has it.
    pub fn lock(&self) -> Result<Lock> {
        let path = self.case.join(".lock");
        fs::create_dir_all(&self.case).map_err(|e| Error::io("create", &self.case, e))?;
        // The file stays: removing it would let two processes lock two files of that name.
        let file = File::options().create(true).truncate(false).write(true).open(&path);
        let file = file.map_err(|e| Error::io("write", &path, e))?;
        match file.try_lock() {
            Ok(()) => Ok(Lock(file)),
            Err(TryLockError::WouldBlock) => Err(Error::input_with_help(
                self.case.display().to_string(),
                "another process is at work on this case",
                "wait until it is done, or write to another folder",
            )),
            Err(TryLockError::Error(e)) => Err(Error::io("lock", &path, e)),
        }
    }

    /// Path of the checkpoint of a step.
    pub fn path(&self, step: u64) -> PathBuf {
        self.case.join("run").join(format!("step_{step:08}.h5"))
    }

    /// Steps that have a checkpoint, ascending. Files of other names do not count. Error: [`Error::Io`].
    pub fn list(&self) -> Result<Vec<u64>> {
        let run = self.case.join("run");
        let entries = match fs::read_dir(&run) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(|e| Error::io("read", &run, e))?,
        };
        let mut steps = Vec::new();
        for entry in entries {
            let name = entry.map_err(|e| Error::io("read", &run, e))?.file_name();
            let digits = name.to_str().and_then(|n| n.strip_prefix("step_")?.strip_suffix(".h5"));
            // Only the name that `path` gives, so that no step is listed twice.
            steps.extend(digits.and_then(|d| d.parse().ok()).filter(|s| self.path(*s).file_name() == Some(&name)));
        }
        steps.sort_unstable();
        Ok(steps)
    }

    /// The checkpoint of a step. Error: [`Error::Stale`] if it is missing, damaged or made from other inputs.
    pub fn read(&self, step: u64) -> Result<Snapshot> {
        let path = self.path(step);
        let archive = Archive::read(&path, Kind::Checkpoint)?;
        self.check_inputs(&archive, &path)?;
        convert::snapshot_from_archive(&archive, &path)
    }

    /// The newest checkpoint that is not damaged; damaged newer ones are named in the warnings.
    ///
    /// Errors: [`Error::Stale`] if that checkpoint was made from other inputs, [`Error::Io`].
    pub fn newest_valid(&self) -> Result<Newest> {
        let mut newest = Newest::default();
        for step in self.list()?.into_iter().rev() {
            let path = self.path(step);
            let read =
                Archive::read(&path, Kind::Checkpoint).and_then(|archive| Ok((convert::snapshot_from_archive(&archive, &path)?, archive)));
            match read {
                Ok((snapshot, archive)) => {
                    self.check_inputs(&archive, &path)?;
                    newest.snapshot = Some(snapshot);
                    break;
                }
                Err(Error::Stale { path, message, .. }) => {
                    newest.warnings.push(format!("{}: {message}; skipped", path.display()));
                }
                Err(e) => return Err(e),
            }
        }
        Ok(newest)
    }

    /// Writes a checkpoint; once it is on the disk, removes those that it makes useless.
    ///
    /// `keep`: whether it stays for good. Others stay while they are among the newest two. Checkpoints of later steps belong to
    /// a run that was taken up again before them, and go too. Errors: [`Error::Io`], [`Error::Input`].
    pub fn write(&mut self, snapshot: &Snapshot, keep: bool) -> Result<()> {
        if let Some(f) = snapshot.fields.iter().find(|f| f.components == 0 || f.data.len() % f.components != 0) {
            let message = format!("field `{}` has {} numbers in rows of {}", f.name, f.data.len(), f.components);
            return Err(Error::input("checkpoint", message));
        }
        convert::snapshot_to_archive(snapshot, keep, &self.inputs).write(&self.path(snapshot.step))?;
        self.keeps.insert(snapshot.step, keep);
        let mut steps = self.list()?;
        let later = steps.split_off(steps.partition_point(|s| *s <= snapshot.step));
        for step in later {
            self.remove(step)?;
        }
        // One became the third with this write; a crash can have left a neighbour of it.
        for step in steps.into_iter().rev().skip(2).take(3) {
            if !self.keeps(step) {
                self.remove(step)?;
            }
        }
        Ok(())
    }

    /// Steps whose checkpoints stay for good, and the newest, ascending. Error: [`Error::Io`].
    pub fn kept(&mut self) -> Result<Vec<u64>> {
        let steps = self.list()?;
        let newest = steps.last().copied();
        Ok(steps.into_iter().filter(|step| Some(*step) == newest || self.keeps(*step)).collect())
    }

    /// Hash of which checkpoints there are and of the seals at their heads, which tell their contents. Error: [`Error::Io`].
    pub fn fingerprint(&self) -> Result<String> {
        let mut parts = Vec::new();
        for step in self.list()? {
            let path = self.path(step);
            let io = |e| Error::io("read", &path, e);
            let mut head = step.to_le_bytes().to_vec();
            File::open(&path).map_err(io)?.take(super::seal::LENGTH as u64).read_to_end(&mut head).map_err(io)?;
            parts.push(head);
        }
        Ok(hash::of(&parts.iter().map(Vec::as_slice).collect::<Vec<_>>()))
    }

    /// Whether a checkpoint stays for good. One that cannot be read does: somebody may want to look at it.
    fn keeps(&mut self, step: u64) -> bool {
        let path = self.path(step);
        *self.keeps.entry(step).or_insert_with(|| {
            Archive::read(&path, Kind::Checkpoint).map_or(true, |a| a.attributes.get("keep").is_none_or(|k| k != "false"))
        })
    }

    fn remove(&mut self, step: u64) -> Result<()> {
        self.keeps.remove(&step);
        let path = self.path(step);
        match fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io("remove", &path, e)),
            _ => Ok(()),
        }
    }

    fn check_inputs(&self, archive: &Archive, path: &Path) -> Result<()> {
        if archive.inputs == self.inputs {
            return Ok(());
        }
        Err(Error::Stale {
            path: path.to_path_buf(),
            message: "was made from other inputs than the present setup".into(),
            help: "start over: thinshell run SCENE --restart, or do all that is out of date: thinshell all SCENE".into(),
        })
    }
}

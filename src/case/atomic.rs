//! Files that are there whole or not at all.
//!
//! Contents go to a hidden neighbour of the target, to the disk, and only then take the target's name. Whatever stops the
//! program in between, the file of before stays as it was. This module knows nothing of formats.

use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Replaces the file at `path` by `contents`, creating its folder where needed.
///
/// Returns once file and folder are on the disk. Errors: [`Error::Io`] naming the path (disk full, folder not writable); the
/// file of before is then untouched.
pub fn write(path: &Path, contents: &[u8]) -> Result<()> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    remove_leftovers(folder);
    let temporary = temporary_name(path);
    let written = write_and_rename(&temporary, path, contents);
    if written.is_err() {
        // The first error is the one to tell; a leftover goes with the next write.
        let _ = fs::remove_file(&temporary);
    }
    written?;
    sync_folder(folder)
}

fn write_and_rename(temporary: &Path, path: &Path, contents: &[u8]) -> Result<()> {
    let mut file = File::create(temporary).map_err(|e| Error::io("write", path, e))?;
    file.write_all(contents).map_err(|e| Error::io("write", path, e))?;
    file.sync_all().map_err(|e| Error::io("write", path, e))?;
    drop(file);
    fs::rename(temporary, path).map_err(|e| Error::io("replace", path, e))
}

/// Makes renames and removals in `folder` last through a power failure.
fn sync_folder(folder: &Path) -> Result<()> {
    // Only Unix lets a folder be opened and synced; elsewhere the rename is all there is.
    if cfg!(unix) {
        File::open(folder).and_then(|f| f.sync_all()).map_err(|e| Error::io("sync", folder, e))?;
    }
    Ok(())
}

/// `.NAME.tmp-PID` beside `path`.
fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.tmp-{}", std::process::id()))
}

/// Removes temporaries of writers that no longer live. What cannot be listed or removed is left: it harms nobody.
///
/// Process numbers mean nothing elsewhere, so a folder must be written from one machine at a time.
fn remove_leftovers(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_str().and_then(writer_of).is_some_and(|pid| !is_alive(pid)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The process number in a name of the form `.NAME.tmp-PID`.
fn writer_of(name: &str) -> Option<u32> {
    let (stem, pid) = name.rsplit_once(".tmp-")?;
    if stem.len() < 2 || !stem.starts_with('.') {
        return None;
    }
    pid.parse().ok()
}

fn is_alive(pid: u32) -> bool {
    let processes = Path::new("/proc");
    // Without a process table to look into, only this process is known to live.
    pid == std::process::id() || processes.join(pid.to_string()).exists()
}

//! Checkpoints: which one a run goes on from, which ones stay.

use std::fs;
use tempfile::TempDir;
use thinshell::Error;
use thinshell::case::Folder;
use thinshell::snapshot::{Association, Field, Snapshot};

fn at(step: u64) -> Snapshot {
    let data = vec![step as f64; 9];
    let position = Field { name: "position".into(), association: Association::Node, components: 3, unit: "m".into(), data };
    Snapshot { step, time: step as f64 * 0.1, dt: 0.1, fields: vec![position], numbers: vec![("energy".into(), 2.0)] }
}

/// Changes one byte in the middle of a file.
fn damage(path: &std::path::Path) {
    let mut bytes = fs::read(path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(path, bytes).unwrap();
}

#[test]
fn no_checkpoint_yet() {
    let case = TempDir::new().unwrap();
    let folder = Folder::new(case.path().join("not/there"), "in");
    assert!(folder.list().unwrap().is_empty());
    let newest = folder.newest_valid().unwrap();
    assert!(newest.snapshot.is_none() && newest.warnings.is_empty());
}

#[test]
fn newest_two_and_the_kept_ones_stay() {
    let case = TempDir::new().unwrap();
    let mut folder = Folder::new(case.path(), "in");
    for step in 0..=10 {
        folder.write(&at(step), step % 4 == 0).unwrap();
        assert_eq!(folder.newest_valid().unwrap().snapshot, Some(at(step)));
    }
    assert_eq!(folder.list().unwrap(), [0, 4, 8, 9, 10]);
    assert!(case.path().join("run/step_00000010.h5").exists());
    // A new process knows from the files what may go.
    let mut folder = Folder::new(case.path(), "in");
    folder.write(&at(11), false).unwrap();
    folder.write(&at(12), false).unwrap();
    assert_eq!(folder.list().unwrap(), [0, 4, 8, 11, 12]);
    assert_eq!(folder.read(4).unwrap(), at(4));
    assert!(matches!(folder.read(5), Err(Error::Stale { .. })));
}

#[test]
fn leftover_of_a_crash_before_removal_goes() {
    let case = TempDir::new().unwrap();
    let mut folder = Folder::new(case.path(), "in");
    folder.write(&at(1), false).unwrap();
    folder.write(&at(2), true).unwrap();
    let first = fs::read(folder.path(1)).unwrap();
    folder.write(&at(3), false).unwrap();
    fs::write(folder.path(1), first).unwrap();
    let mut folder = Folder::new(case.path(), "in");
    folder.write(&at(4), false).unwrap();
    assert_eq!(folder.list().unwrap(), [2, 3, 4]);
}

#[test]
fn damaged_newest_is_named_and_skipped() {
    let case = TempDir::new().unwrap();
    let mut folder = Folder::new(case.path(), "in");
    for step in 1..=3 {
        folder.write(&at(step), true).unwrap();
    }
    damage(&folder.path(3));
    fs::write(folder.path(2), "").unwrap();
    let newest = folder.newest_valid().unwrap();
    assert_eq!(newest.snapshot, Some(at(1)));
    assert_eq!(newest.warnings.len(), 2);
    assert!(newest.warnings[0].contains("step_00000003.h5") && newest.warnings[0].contains("damaged"), "{:?}", newest.warnings);
    assert!(newest.warnings[1].contains("step_00000002.h5") && newest.warnings[1].contains("empty"), "{:?}", newest.warnings);
    // The run goes on from step 1: what lay after it belongs to another course of things.
    folder.write(&at(2), false).unwrap();
    assert_eq!(folder.list().unwrap(), [1, 2]);
    damage(&folder.path(1));
    damage(&folder.path(2));
    let newest = folder.newest_valid().unwrap();
    assert!(newest.snapshot.is_none());
    assert_eq!(newest.warnings.len(), 2);
}

#[test]
fn other_files_are_no_checkpoints() {
    let case = TempDir::new().unwrap();
    let mut folder = Folder::new(case.path(), "in");
    folder.write(&at(123_456_789), false).unwrap();
    for name in ["step_1.h5", "step_000000001.h5", "step_+0000001.h5", "step_x.h5", ".step_00000001.h5.tmp-1", "notes"] {
        fs::write(case.path().join("run").join(name), "x").unwrap();
    }
    assert_eq!(folder.list().unwrap(), [123_456_789]);
    assert!(case.path().join("run/step_123456789.h5").exists());
}

#[test]
fn checkpoint_of_other_inputs_is_refused() {
    let case = TempDir::new().unwrap();
    Folder::new(case.path(), "old").write(&at(1), false).unwrap();
    match Folder::new(case.path(), "new").newest_valid() {
        Err(Error::Stale { message, help, .. }) => {
            assert!(message.contains("other inputs") && help.contains("thinshell run"), "{message}; {help}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn ragged_field_is_refused() {
    let case = TempDir::new().unwrap();
    let mut snapshot = at(1);
    snapshot.fields[0].data.pop();
    let mut folder = Folder::new(case.path(), "in");
    assert!(matches!(folder.write(&snapshot, false), Err(Error::Input { .. })));
    snapshot.fields[0].components = 0;
    assert!(matches!(folder.write(&snapshot, false), Err(Error::Input { .. })));
    assert!(folder.list().unwrap().is_empty());
}

#[test]
fn one_run_at_a_time() {
    let case = TempDir::new().unwrap();
    let folder = Folder::new(case.path().join("case"), "in");
    let lock = folder.lock().unwrap();
    assert!(matches!(folder.lock(), Err(Error::Input { .. })));
    drop(lock);
    folder.lock().unwrap();
}

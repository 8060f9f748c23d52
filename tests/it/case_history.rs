//! History: numbers to the bit, nothing doubled on resuming, nothing half after a crash.

use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use thinshell::Error;
use thinshell::case::History;

const COLUMNS: [&str; 2] = ["time_s", "kinetic_energy_J"];

/// A history with the steps 1 to `steps`.
fn written(folder: &TempDir, steps: u64) -> PathBuf {
    let path = folder.path().join("history.csv");
    let mut history = History::create(&path, &COLUMNS).unwrap();
    for step in 1..=steps {
        history.append(step, &[step as f64 * 0.1, 1.0 / step as f64]).unwrap();
    }
    path
}

fn steps(path: &Path) -> Vec<f64> {
    History::read(path).unwrap().column("step").unwrap()
}

#[test]
fn numbers_come_back_to_the_bit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("history.csv");
    let mut history = History::create(&path, &["a,\"b\""]).unwrap();
    let values = [0.1 + 0.2, -0.0, 1e-300, 5e-324, f64::MAX, f64::INFINITY, 1e23, 12345678.9];
    for (step, value) in values.iter().enumerate() {
        history.append(step as u64, &[*value]).unwrap();
    }
    history.append(99, &[f64::NAN]).unwrap();
    history.sync().unwrap();
    let table = History::read(&path).unwrap();
    assert_eq!(table.columns, ["step", "a,\"b\""]);
    let read = table.column("a,\"b\"").unwrap();
    for (a, b) in read.iter().zip(values) {
        assert_eq!(a.to_bits(), b.to_bits());
    }
    assert!(table.last("a,\"b\"").unwrap().is_nan());
    assert!(table.last("none").is_none() && table.column("none").is_none());
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("\n2,1e-300\n") && text.contains("\n0,0.30000000000000004\n"), "{text}");
}

#[test]
fn resumed_history_equals_the_one_not_stopped() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, 9);
    let whole = fs::read(&path).unwrap();
    let mut history = History::open_at(&path, &COLUMNS, 6).unwrap();
    assert_eq!(steps(&path), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    for step in 7..=9 {
        history.append(step, &[step as f64 * 0.1, 1.0 / step as f64]).unwrap();
    }
    assert_eq!(fs::read(&path).unwrap(), whole);
}

#[test]
fn torn_last_row_goes_at_any_length() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, 3);
    let whole = fs::read(&path).unwrap();
    let header = whole.iter().position(|b| *b == b'\n').unwrap() + 1;
    for length in header..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        let rows = whole[header..length].iter().filter(|b| **b == b'\n').count();
        assert_eq!(steps(&path).len(), rows, "{length}");
        History::open_at(&path, &COLUMNS, 3).unwrap().append(9, &[0.0, 0.0]).unwrap();
        assert_eq!(steps(&path).len(), rows + 1, "{length}");
    }
    // A power failure can leave zeros where the last row was to be.
    fs::write(&path, [&whole[..], &[0; 20], b"\n"].concat()).unwrap();
    assert_eq!(steps(&path).len(), 3);
}

#[test]
fn other_faults_are_named() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, 2);
    let message = |read: thinshell::Result<()>| match read {
        Err(Error::Stale { message, .. }) => message,
        other => panic!("{other:?}"),
    };
    assert!(message(History::open_at(&path, &["time_s"], 1).map(drop)).contains("other columns"));
    let text = fs::read_to_string(&path).unwrap().replace("\n1,", "\nx,");
    fs::write(&path, text).unwrap();
    assert!(message(History::read(&path).map(drop)).contains("line 2"));
    fs::write(&path, "").unwrap();
    assert!(message(History::read(&path).map(drop)).contains("column names"));
    fs::write(&path, "1,2,3\n").unwrap();
    assert!(message(History::read(&path).map(drop)).contains("column names"));
    fs::remove_file(&path).unwrap();
    assert!(message(History::read(&path).map(drop)).contains("does not exist"));
    let mut history = History::open_at(&path, &COLUMNS, 5).unwrap();
    assert!(matches!(history.append(1, &[0.0]), Err(Error::Input { .. })));
    assert!(steps(&path).is_empty());
}

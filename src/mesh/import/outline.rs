//! Outlines of flat shells from CSV files: columns `x` and `y` [m], one corner a row, `#` before comments.

use super::printable;
use crate::error::{Error, Result};
use std::path::Path;

/// The corners of a polygon [m] in the order of the file. Other columns are left out.
///
/// Errors name file and line: a file that cannot be read, without one of the columns, with what is no finite number, with fewer than three
/// corners, or with the same corner twice in a row (the last is followed by the first). Whether the sides cross,
/// [`crate::mesh::generate::outline`] finds out.
pub fn read_outline(path: &Path) -> Result<Vec<[f64; 2]>> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let place = |line: Option<u64>| {
        let line = line.map_or(String::new(), |line| format!(": line {line}"));
        format!("{}{line}", path.display())
    };
    let fault = |line, message: String| Error::input(place(line), printable(&message));
    let unreadable = |e: csv::Error| fault(e.position().map(csv::Position::line), format!("is no table of numbers: {e}"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(bytes.as_slice());
    let header = reader.headers().map_err(unreadable)?.clone();
    let column = |name: &str| {
        let found = header.iter().position(|title| title == name);
        found.ok_or_else(|| fault(None, format!("has no column `{name}`: expected the columns x and y [m]")))
    };
    let columns = [column("x")?, column("y")?];
    let (mut corners, mut lines) = (Vec::new(), Vec::new());
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        let line = row.position().map(csv::Position::line);
        let mut corner = [0.0; 2];
        for (x, column) in corner.iter_mut().zip(columns) {
            let text = row.get(column).unwrap_or_default();
            let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
            *x = number.ok_or_else(|| fault(line, format!("`{text}` is not a finite number")))?;
        }
        corners.push(corner);
        lines.push(line);
    }
    if corners.len() < 3 {
        return Err(fault(None, format!("has {} corners, must have at least 3", corners.len())));
    }
    match (0..corners.len()).find(|&i| corners[i] == corners[(i + 1) % corners.len()]) {
        Some(i) => Err(fault(lines[i], "is the same as the next corner".into())),
        None => Ok(corners),
    }
}

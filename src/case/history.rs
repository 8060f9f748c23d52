//! `history.csv`: one row of numbers per accepted step.
//!
//! The first column is `step`; what the others mean is the caller's business. Numbers are written in the shortest form that
//! reads back to the same bits.

use super::atomic;
use crate::error::{Error, Result};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A history that is being written.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    file: File,
    columns: usize,
}

/// A history that was read: `columns[0]` is `step`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// One row per step, as long as `columns`.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.columns.iter().position(|c| c == name)?;
        Some(self.rows.iter().map(|row| row[at]).collect())
    }

    /// The last number in the column of that name.
    pub fn last(&self, name: &str) -> Option<f64> {
        let at = self.columns.iter().position(|c| c == name)?;
        Some(self.rows.last()?[at])
    }
}

impl History {
    /// Starts a history, replacing the one of before. `columns`: names of the columns after `step`. Errors: [`Error::Io`].
    pub fn create(path: &Path, columns: &[&str]) -> Result<History> {
        History::start(path, columns, &[])
    }

    /// Goes on with a history after `step`: later rows, which a resumed run will make again, and a row torn by a crash go.
    ///
    /// A history that does not exist is started. Errors: [`Error::Stale`] if it has other columns or an unreadable row that is
    /// not the last, [`Error::Io`].
    pub fn open_at(path: &Path, columns: &[&str], step: u64) -> Result<History> {
        if !path.exists() {
            return History::create(path, columns);
        }
        let mut table = History::read(path)?;
        if !table.columns.iter().map(String::as_str).eq(header(columns)) {
            return Err(stale(path, "has other columns than this run writes".into()));
        }
        table.rows.retain(|row| row[0] <= step as f64);
        History::start(path, columns, &table.rows)
    }

    fn start(path: &Path, columns: &[&str], rows: &[Vec<f64>]) -> Result<History> {
        let io = |e| Error::io("write", path, e);
        let mut text = line(header(columns).map(String::from)).map_err(io)?;
        for row in rows {
            text.extend(line(cells(row[0] as u64, &row[1..])).map_err(io)?);
        }
        // Written anew even where nothing was dropped, so that the rows kept are on the disk as the checkpoint is.
        atomic::write(path, &text)?;
        let file = File::options().append(true).open(path).map_err(io)?;
        Ok(History { path: path.to_path_buf(), file, columns: columns.len() })
    }

    /// Adds the row of a step. `values`: one number per column after `step`.
    ///
    /// Errors: [`Error::Io`]; [`Error::Input`] if the number of values is not that of the columns.
    pub fn append(&mut self, step: u64, values: &[f64]) -> Result<()> {
        if values.len() != self.columns {
            let message = format!("step {step} has {} values for {} columns", values.len(), self.columns);
            return Err(Error::input(self.path.display().to_string(), message));
        }
        // One call for the whole row: a process that is killed between two calls leaves whole rows.
        let io = |e| Error::io("write", &self.path, e);
        let row = line(cells(step, values)).map_err(io)?;
        self.file.write_all(&row).map_err(io)
    }

    /// Makes the rows last through a power failure; to be called before the checkpoint of the last row is written.
    pub fn sync(&self) -> Result<()> {
        self.file.sync_data().map_err(|e| Error::io("write", &self.path, e))
    }

    /// Reads a history that has to have a row for each of the first `steps` steps.
    ///
    /// Errors: those of [`History::read`], [`Error::Stale`] if it is shorter.
    pub fn read_through(path: &Path, steps: u64) -> Result<Table> {
        let table = History::read(path)?;
        let row = |step: u64| table.rows.get(usize::try_from(step).ok()?.checked_sub(1)?);
        if steps == 0 || row(steps).is_some_and(|row| row[0] == steps as f64) {
            return Ok(table);
        }
        let whole = (1..=steps).take_while(|step| row(*step).is_some_and(|row| row[0] == *step as f64)).count();
        Err(stale(path, format!("tells of the first {whole} steps only, the newest checkpoint is of step {steps}")))
    }

    /// Reads a history, without a last row that a crash tore.
    ///
    /// Errors: [`Error::Stale`] if it is missing or a row before the last cannot be read, [`Error::Io`].
    pub fn read(path: &Path) -> Result<Table> {
        let bytes = match std::fs::read(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Err(stale(path, "does not exist".into())),
            bytes => bytes.map_err(|e| Error::io("read", path, e))?,
        };
        let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(0, |end| end + 1);
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&bytes[..whole]);
        let mut records = reader.records();
        let columns: Vec<String> = match records.next() {
            Some(Ok(header)) if header.get(0) == Some("step") => header.iter().map(String::from).collect(),
            _ => return Err(stale(path, "does not start with a line of column names".into())),
        };
        let mut rows = Vec::new();
        let mut unreadable = None;
        for (n, record) in records.enumerate() {
            if let Some(line) = unreadable {
                return Err(stale(path, format!("line {line} cannot be read")));
            }
            match record.ok().and_then(|r| parse(&r)).filter(|row| row.len() == columns.len()) {
                Some(row) => rows.push(row),
                None => unreadable = Some(n + 2),
            }
        }
        Ok(Table { columns, rows })
    }
}

fn header<'a>(columns: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    ["step"].into_iter().chain(columns.iter().copied())
}

fn cells(step: u64, values: &[f64]) -> impl Iterator<Item = String> {
    // `{:?}` is the shortest form that reads back to the same number and, unlike `{}`, uses exponents where they are shorter.
    [step.to_string()].into_iter().chain(values.iter().map(|v| format!("{v:?}")))
}

fn line(cells: impl Iterator<Item = String>) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells.map(String::into_bytes))?;
    writer.into_inner().map_err(|e| e.into_error())
}

fn parse(record: &csv::StringRecord) -> Option<Vec<f64>> {
    record.get(0)?.parse::<u64>().ok()?;
    record.iter().map(|cell| cell.parse().ok()).collect()
}

fn stale(path: &Path, message: String) -> Error {
    Error::Stale { path: path.to_path_buf(), message, help: "start over: thinshell run SCENE --restart".into() }
}

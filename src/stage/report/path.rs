//! Measures along a run: at each step, and at places between steps.

use super::super::Job;
use super::case::{Case, When};
use crate::case::atomic;
use crate::error::{Error, Result};
use crate::report::path::{limit_point, passage};
use crate::report::{PathTable, Place};
use crate::scene::{Expectation, PathMeasures};
use std::path::PathBuf;

impl Case<'_> {
    /// The value that an expectation is about; not finite where its place is not on the path.
    pub fn expected(&self, expected: &Expectation) -> Result<f64> {
        if expected.limit_point.is_none() && expected.passage.is_none() {
            return self.measure(&expected.measure, expected.time.into());
        }
        let (steps, ways, times) = self.steps()?;
        let place = match (&expected.passage, expected.limit_point) {
            (Some(at), _) => {
                let values = steps.iter().map(|step| self.measure(&at.measure, When::Step(*step)));
                passage(&ways, &values.collect::<Result<Vec<_>>>()?, at.value, at.number)
            }
            (None, number) => limit_point(&ways, &times, number.unwrap_or(1)),
        };
        let Some(Place { weights }) = place else { return Ok(f64::NAN) };
        let mut value = 0.0;
        for (index, weight) in weights {
            value += weight * self.measure(&expected.measure, When::Step(steps[index]))?;
        }
        Ok(value)
    }

    /// Measures at every step that has a checkpoint.
    pub fn along(&self, table: &PathMeasures) -> Result<PathTable> {
        let (steps, _, times) = self.steps()?;
        let columns = ["step", "t"].into_iter().map(str::to_owned).chain(table.measures.iter().map(|entry| entry.name.clone())).collect();
        let mut rows = Vec::new();
        for (step, t) in steps.iter().zip(times) {
            let mut row = vec![Some(*step as f64), Some(t)];
            for entry in &table.measures {
                row.push(Some(self.measure(&entry.measure, When::Step(*step))?).filter(|value| value.is_finite()));
            }
            rows.push(row);
        }
        Ok(PathTable { columns, rows })
    }
}

/// Writes the table as `path.csv` into the case.
pub fn write(job: &Job, table: &PathTable) -> Result<()> {
    let path: PathBuf = job.case.join("path.csv");
    let text = table.to_csv().map_err(|e| Error::io("write", &path, e))?;
    atomic::write(&path, &text)
}

//! Measures along a run: at each step, and at places between steps.

use super::super::Job;
use super::case::{Case, When};
use crate::case::atomic;
use crate::error::{Error, Result};
use crate::report::path::{limit_point, passage};
use crate::report::{PathTable, Place};
use crate::scene::{Expectation, Measure, Passage, PathMeasures};
use std::path::PathBuf;

/// Where in a run something is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spot<'a> {
    /// At a checkpoint.
    At(When),
    /// At a limit point, counted from 1.
    LimitPoint(usize),
    /// Where a measure comes to a value.
    Passage(&'a Passage),
}

impl<'a> Spot<'a> {
    /// What a table says of it; the end where it says nothing.
    pub fn new(time: Option<f64>, limit_point: Option<usize>, passage: Option<&'a Passage>) -> Self {
        match (limit_point, passage) {
            (Some(number), _) => Spot::LimitPoint(number),
            (None, Some(passage)) => Spot::Passage(passage),
            (None, None) => Spot::At(time.into()),
        }
    }
}

impl<'a> From<&'a Expectation> for Spot<'a> {
    fn from(e: &'a Expectation) -> Self {
        Spot::new(e.time, e.limit_point, e.passage.as_ref())
    }
}

impl Case<'_> {
    /// A measure somewhere in the run; not finite where that is not on its path.
    ///
    /// # Errors
    /// Those of [`Case::measure`].
    pub fn measure_at(&self, measure: &Measure, spot: Spot) -> Result<f64> {
        let (steps, place) = match spot {
            Spot::At(when) => return self.measure(measure, when),
            Spot::LimitPoint(number) => {
                let (steps, ways, times) = self.steps()?;
                (steps, limit_point(&ways, &times, number))
            }
            Spot::Passage(at) => {
                let (steps, ways, _) = self.steps()?;
                let values = steps.iter().map(|step| self.measure(&at.measure, When::Step(*step))).collect::<Result<Vec<_>>>()?;
                (steps, passage(&ways, &values, at.value, at.number))
            }
        };
        let Some(Place { weights }) = place else { return Ok(f64::NAN) };
        let mut value = 0.0;
        for (index, weight) in weights {
            value += weight * self.measure(measure, When::Step(steps[index]))?;
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

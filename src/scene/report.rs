//! Tables `[report]`, `[[report.expect]]` and `[report.path]`.

use super::{Ladder, Matrix, Measure, Sweep};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the scene expects of its own result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Expectations; the scene passes when all are met.
    #[serde(default, rename = "expect", skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<Expectation>,
    /// Measures at every step that is kept: `path.csv` in the case, and in `report.json`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<PathMeasures>,
    /// Table of error against run time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ladder: Option<Ladder>,
    /// Runs over values of a key.
    #[serde(default, rename = "sweep", skip_serializing_if = "Vec::is_empty")]
    pub sweeps: Vec<Sweep>,
    /// Runs at the ends of what keys may be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Matrix>,
}

/// One expected number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// Name in the report.
    pub name: String,
    /// What is measured at the end of the run, or at `time`, `limit-point` or `passage`, of which at most one may be given.
    pub measure: Measure,
    /// Number it is compared with, in the measure's unit.
    pub reference: f64,
    /// Largest `|value - reference|` that passes, in the measure's unit, >= 0.
    pub tolerance: f64,
    /// Where the reference comes from.
    pub source: String,
    /// Time of the checkpoint to measure [s]; the nearest kept one is taken. Not along a path by arc length, which may come to a load factor
    /// more than once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Number of a limit point, from 1: a place on a path by arc length where the load factor turns back. By a polynomial through the steps around it.
    #[serde(default, rename = "limit-point", skip_serializing_if = "Option::is_none")]
    pub limit_point: Option<usize>,
    /// Where another measure comes to a value, by a polynomial through the kept steps around it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passage: Option<Passage>,
}

/// Where a measure comes to a value, from either side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Passage {
    /// The measure.
    pub measure: Measure,
    /// The value, in its unit.
    pub value: f64,
    /// Which time that it does, from 1.
    #[serde(default = "first")]
    pub number: usize,
}

fn first() -> usize {
    1
}

/// Measures at every step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PathMeasures {
    /// What is measured; there are columns of `step` and `t` beside them.
    pub measures: Vec<NamedMeasure>,
}

/// A measure and its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedMeasure {
    /// Name of its column.
    pub name: String,
    /// The measure.
    pub measure: Measure,
}

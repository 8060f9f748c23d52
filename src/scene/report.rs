//! Tables `[report]` and `[[report.expect]]`.

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
    /// What is measured at the end of the run (or at `time`).
    pub measure: Measure,
    /// Number it is compared with, in the measure's unit.
    pub reference: f64,
    /// Largest `|value - reference|` that passes, in the measure's unit, >= 0.
    pub tolerance: f64,
    /// Where the reference comes from.
    pub source: String,
    /// Time of the checkpoint to measure [s]; the nearest kept one is taken. Absent: the last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
}

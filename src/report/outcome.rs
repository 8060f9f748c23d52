//! What a scene expected of its result and what it got: `report.json` and `report.md`.

use super::{PathTable, cell, number, table};
use serde::{Serialize, Serializer};

/// One expectation and the number that was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExpectationResult {
    /// Name in the report.
    pub name: String,
    /// What was measured, in the measure's unit.
    #[serde(serialize_with = "finite")]
    pub value: f64,
    /// What was expected, in the same unit.
    #[serde(serialize_with = "finite")]
    pub reference: f64,
    /// `|value - reference|`.
    #[serde(serialize_with = "finite")]
    pub error: f64,
    /// Largest error that passes.
    #[serde(serialize_with = "finite")]
    pub tolerance: f64,
    /// Whether it does.
    pub passed: bool,
    /// Where the reference comes from.
    pub source: String,
}

/// What a run cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Number of unknowns.
    pub dofs: usize,
    /// Number of faces.
    pub faces: usize,
    /// Run time [s].
    #[serde(serialize_with = "finite")]
    pub wall_s: f64,
    /// Newton iterations of the whole run.
    pub newton_iterations: u64,
    /// Numeric factorisations of the whole run.
    pub factorizations: u64,
}

/// The report of one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Name of the scene.
    pub scene: String,
    /// Whether all expectations are met.
    pub passed: bool,
    /// One entry per expectation.
    pub expectations: Vec<ExpectationResult>,
    /// What the run cost.
    #[serde(flatten)]
    pub cost: Cost,
    /// Measures at each step, where they are asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathTable>,
    /// Hash of what the report was made from; empty where nobody asks.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub inputs: String,
}

impl ExpectationResult {
    /// Compares a measured value with its reference. What is not finite never passes.
    pub fn new(name: impl Into<String>, value: f64, reference: f64, tolerance: f64, source: impl Into<String>) -> Self {
        let error = (value - reference).abs();
        let passed = error.is_finite() && error <= tolerance;
        ExpectationResult { name: name.into(), value, reference, error, tolerance, passed, source: source.into() }
    }
}

impl Outcome {
    /// Passes when all expectations do.
    pub fn new(scene: impl Into<String>, expectations: Vec<ExpectationResult>, cost: Cost) -> Self {
        let passed = expectations.iter().all(|e| e.passed);
        Outcome { scene: scene.into(), passed, expectations, cost, path: None, inputs: String::new() }
    }

    /// Contents of `report.json`; numbers that are not finite are null.
    pub fn to_json(&self) -> String {
        json(self)
    }

    /// Contents of `report.md`.
    pub fn to_markdown(&self) -> String {
        let verdict = match (self.passed, self.expectations.len()) {
            (_, 0) => "expects nothing",
            (true, _) => "passed",
            (false, _) => "missed",
        };
        let mut text = format!("# {}: {verdict}\n\n", cell(&self.scene));
        if !self.expectations.is_empty() {
            let row = |e: &ExpectationResult| {
                let verdict = if e.passed { "yes" } else { "**no**" };
                let numbers = [e.value, e.reference, e.error, e.tolerance].map(number);
                [cell(&e.name), cell(&e.source), verdict.into()].into_iter().chain(numbers).collect()
            };
            let rows: Vec<Vec<String>> = self.expectations.iter().map(row).collect();
            text += &table(&["expectation", "source", "passed", "value", "reference", "error", "tolerance"], 3, &rows);
            text += "\n";
        }
        let c = &self.cost;
        text += &format!(
            "{} unknowns on {} faces; {} Newton iterations, {} factorisations, {} s.\n",
            c.dofs,
            c.faces,
            c.newton_iterations,
            c.factorizations,
            number(c.wall_s)
        );
        text
    }
}

/// Pretty JSON of one of this module's own tables, which hold texts and numbers only and so cannot fail to be written.
pub(super) fn json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}

/// A number, or null if it is not finite: JSON knows no others.
fn finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    value.is_finite().then_some(*value).serialize(serializer)
}

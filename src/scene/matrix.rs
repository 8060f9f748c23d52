//! Table `[report.matrix]`: a scene run at the ends of what its keys may be, to see that every run ends well or says why not.

use super::{SweepMeasure, SweepValue, Tied};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Runs of a scene, each a cell that has to end in a solution or in a clear refusal. A cell of a converged run must have finite fields, an
/// energy below `largest_energy`, and keep the other limits here; no run may take longer than `most_seconds`. See the report for how the balance
/// of energy is formed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Matrix {
    /// What is measured of each converged cell, with limits: an exact answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<SweepMeasure>,
    /// Most numeric factorisations of a converged cell, >= 1. Absent: any number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_factorizations: Option<u64>,
    /// Largest median over the steps of the iterations of a converged cell [1], > 0. Absent: any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_iterations: Option<f64>,
    /// Largest elastic energy of a converged cell over that of a plane stress of E all over the shell, the sum of E h A [1], > 0: half the mean
    /// square of strains.
    #[serde(default = "default_energy")]
    pub largest_energy: f64,
    /// Largest gain of energy, see the report [1], >= 0.
    #[serde(default = "default_gain")]
    pub largest_gain: f64,
    /// Longest that a cell may take [s], > 0, to 1e6.
    #[serde(default = "default_seconds")]
    pub most_seconds: f64,
    /// Groups of cells.
    #[serde(rename = "part")]
    pub parts: Vec<MatrixPart>,
}

/// All combinations of the values along some axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixPart {
    /// Name in the table.
    pub name: String,
    /// Changes of the scene that hold for the whole part, as behind `--set`: `"statics.steps=1"`, `"report.matrix.most_factorizations=60"`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Axes; none makes one cell.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<MatrixAxis>,
    /// How cells have to end.
    #[serde(default)]
    pub ends: Ends,
}

/// Values of a key, and of others that change along with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixAxis {
    /// Key of the scene, as on the command line: `shell.thickness`.
    pub key: String,
    /// Its values.
    pub values: Vec<SweepValue>,
    /// Other keys, each with as many values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<Tied>,
}

/// How a cell has to end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ends {
    /// In a solution.
    #[default]
    Converged,
    /// In an error that says why.
    Refused,
    /// In one of both.
    Either,
}

fn default_energy() -> f64 {
    1.0
}

fn default_gain() -> f64 {
    1e-6
}

fn default_seconds() -> f64 {
    60.0
}

impl MatrixPart {
    /// All cells of the part: the values along the axes, the last axis changing fastest, and the overrides that make the scene.
    pub fn cells(&self) -> Vec<(Vec<SweepValue>, Vec<String>)> {
        let mut cells = vec![(Vec::new(), self.set.clone())];
        for axis in &self.axes {
            let longer = |(values, overrides): &(Vec<SweepValue>, Vec<String>)| -> Vec<_> {
                let at = |(i, value): (usize, &SweepValue)| {
                    let tied = axis.with.iter().map(|tied| format!("{}={}", tied.key, tied.values[i].text()));
                    let set = [format!("{}={}", axis.key, value.text())].into_iter().chain(tied);
                    (values.iter().chain([value]).cloned().collect(), overrides.iter().cloned().chain(set).collect())
                };
                axis.values.iter().enumerate().map(at).collect()
            };
            cells = cells.iter().flat_map(longer).collect();
        }
        cells
    }
}

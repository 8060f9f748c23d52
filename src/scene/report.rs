//! Tables `[report]`, `[[report.expect]]` and `[report.ladder]`.

use super::{Director, Element, Pattern};
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

/// Part of a statistic over the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// Smallest.
    Min,
    /// Largest.
    Max,
    /// Mean, weighted by area.
    Mean,
}

/// A number that a result is measured by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Measure {
    /// Displacement [m] along one axis of the vertex nearest to a point of the initial mesh.
    Displacement {
        /// Point of the initial mesh [m].
        at: [f64; 3],
        /// Axis.
        axis: super::Axis,
        /// Name of the region that the vertex is looked for in, as where two edges lie on each other. Absent: all vertices.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        region: Option<String>,
    },
    /// Largest distance of a vertex from the exact cylinder into which the xy plane rolls along x, over the initial length along x, after
    /// the best rigid fit [1].
    CylinderDistance {
        /// Radius [m], > 0.
        radius: f64,
    },
    /// A statistic of an exported field over the faces or vertices, in the field's unit: `mean-curvature`, `principal-curvatures` (component 0 the larger, 1 the smaller), `displacement`, ...
    Field {
        /// Name of an exported field.
        name: String,
        /// Component, from 0.
        #[serde(default)]
        component: usize,
        /// Statistic.
        statistic: Statistic,
    },
    /// The last value of a column of `history.csv`, for example `kinetic_energy_J`.
    History {
        /// Name of the column.
        column: String,
    },
    /// Newton iterations of the whole run.
    NewtonIterations,
    /// Numeric factorisations of the whole run.
    Factorizations,
}

/// A scene run at several resolutions, on several meshes, with several directors and thicknesses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ladder {
    /// What is measured; its distance from `reference` is the error.
    pub measure: Measure,
    /// Exact value.
    #[serde(default)]
    pub reference: f64,
    /// Factors on the scene's numbers of cells (rings, inverse triangle size), ascending.
    pub resolutions: Vec<f64>,
    /// Variants of a rectangle's mesh. Absent: the scene's own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<LadderMesh>,
    /// Elements. Absent: the scene's own. The quadratic one has no director `average`, which is left out for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<Element>,
    /// Directors. Absent: the scene's own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub directors: Vec<Director>,
    /// Thicknesses [m]. Absent: the scene's own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thicknesses: Vec<f64>,
}

/// A variant of a rectangle's mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LadderMesh {
    /// Name in the table.
    pub name: String,
    /// Pattern.
    pub pattern: Pattern,
    /// Jitter.
    #[serde(default)]
    pub jitter: f64,
}

//! Table `[report.ladder]`: a scene run at several resolutions.

use super::{Director, Element, Integrator, Measure, Method, Pattern, Sampling};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene run at several resolutions, on several meshes, with several directors and thicknesses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ladder {
    /// What is measured; its distance from `reference` is the error.
    pub measure: Measure,
    /// Exact value.
    #[serde(default)]
    pub reference: f64,
    /// Number of the limit point at which it is measured, from 1, on a path by arc length. Absent: the end.
    #[serde(default, rename = "limit-point", skip_serializing_if = "Option::is_none")]
    pub limit_point: Option<usize>,
    /// Factors on the scene's numbers of cells (rings, inverse triangle size) or of steps, ascending. Of a mesh file, the first is 1 and finer ones are split.
    pub resolutions: Vec<f64>,
    /// How runs become finer than that of the first resolution.
    #[serde(default)]
    pub refinement: Refinement,
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
    /// How the rest law becomes the rest metric (`rest.sampling`); a column of the table. Absent: the scene's own, without a column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub samplings: Vec<Sampling>,
    /// Integrators of a motion (`dynamics.integrator`); a column of the table. Absent: the scene's own, without a column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub integrators: Vec<Integrator>,
    /// Ways to an equilibrium (`statics.method`), in the same column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub methods: Vec<Method>,
    /// What is expected at the finest resolution.
    #[serde(default, rename = "expect", skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<LadderExpectation>,
}

/// What of a ladder becomes finer, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Refinement {
    /// Each is made anew. Irregular ones are then not similar to each other, and errors go down by uneven steps.
    #[default]
    Anew,
    /// The faces of the first are split as by `[refine]`; each resolution is 2, 4, 8, ... times the first.
    Split,
    /// The mesh stays and `dynamics.dt` is divided by the resolution. Orders are by the step.
    Steps,
}

/// What is expected of the finest run of every kind that it names. Names that are absent stand for all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LadderExpectation {
    /// Element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub element: Option<Element>,
    /// Director.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub director: Option<Director>,
    /// Name of the mesh variant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Thickness [m], as in the ladder's list.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Sampling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampling: Option<Sampling>,
    /// Integrator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integrator: Option<Integrator>,
    /// Way to the equilibrium.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// Smallest order that passes [1]: fitted over all resolutions, or where meshes are split from one another, that of the two finest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_order: Option<f64>,
    /// Largest error that passes, in the measure's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_error: Option<f64>,
    /// Resolutions beyond those of the ladder that its kinds are run at too, ascending; the last is then their finest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further: Vec<f64>,
    /// Names of `[[report.expect]]` that must be met as well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meets: Vec<String>,
    /// Where these come from.
    pub source: String,
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

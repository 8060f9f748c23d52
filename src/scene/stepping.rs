//! Tables `[statics.adaptive]` and `[statics.arc-length]`: how long the steps of statics are.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Steps that grow and shrink with the iterations of the last: by the root of those desired over those taken, at most twofold. The first is one
/// of `steps`. A step that fails is halved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Adaptive {
    /// Newton iterations that a step should take, 2 to 100.
    #[serde(default = "iterations")]
    pub iterations: usize,
    /// Shortest step, > 0: load factor, or time [s] with `end`. Absent: the first halved `solver.max_halvings` times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest: Option<f64>,
    /// Longest step, at least as long as the first. Absent: all of the way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest: Option<f64>,
}

/// Follows the path of equilibria through limit points, where the load factor `t` turns back: snap-through and snap-back. Steps have a given
/// length, the root mean square of the nodes' displacements, and `t` is an unknown. Loads, motions and growth follow `t` as in load steps; it may fall, also below 0. The path ends where
/// `t` first comes to 1, exactly there, or after `most_steps`, or at `until`. Adds `arc_length_m`, the sum of all steps, to the history. Not with
/// `end`, `stable`, `adaptive` and `output.interval`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArcLength {
    /// Newton iterations that a step should take, 2 to 100; lengths change by the root of these over those taken, at most twofold. The first step
    /// is as long as by its tangent changes the load factor by one of `steps`.
    #[serde(default = "iterations")]
    pub iterations: usize,
    /// Longest step over the first [1], >= 1.
    #[serde(default = "longest")]
    pub longest: f64,
    /// Steps after which the path ends, 1 to 100000. Not part of the state: a run goes on where this grows.
    #[serde(default = "most_steps")]
    pub most_steps: usize,
    /// Displacement at which the path ends, with the first step that reaches it. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<Reached>,
}

/// A displacement that a vertex comes to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reached {
    /// Point of the initial mesh [m]; the vertex nearest to it counts.
    pub at: [f64; 3],
    /// Axis.
    pub axis: super::Axis,
    /// Name of the region that the vertex is looked for in. Absent: all vertices.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Displacement along the axis [m], not 0; reached from the side of 0.
    pub displacement: f64,
}

fn iterations() -> usize {
    6
}

fn longest() -> f64 {
    8.0
}

fn most_steps() -> usize {
    500
}

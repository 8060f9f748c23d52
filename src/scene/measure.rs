//! Measures: numbers that a result is judged by, in `[[report.expect]]`, `[report.ladder]` and `[[report.sweep]]`.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    /// Median, weighted by area: half of the area has less, half has more.
    Median,
    /// Largest absolute value.
    Magnitude,
    /// Root of the mean square, weighted by area.
    Rms,
}

/// Which distance between two shapes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Largest distance of a node from its own place.
    #[default]
    Nodes,
    /// Hausdorff distance of the surfaces, wherever their nodes are. Flat faces count with their sag.
    Hausdorff,
}

/// Which curvature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CurvatureKind {
    /// Half the sum of the principal curvatures [1/m].
    Mean,
    /// Their product [1/m2].
    Gauss,
}

/// How values at nodes become one number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Weighting {
    /// Mean, weighted by area.
    #[default]
    Area,
    /// Plain sum over the nodes; grows with their number.
    Sum,
}

/// Part of the elastic energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnergyPart {
    /// Stretching of the midsurface.
    Membrane,
    /// Bending.
    Bending,
    /// Both.
    #[default]
    Total,
}

fn yes() -> bool {
    true
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
    /// Force [N] along one axis that the supports exert on the nodes of a region, those of its edges included; in motion at the time that
    /// `reactions` in `[output]` tells of, which this needs.
    Reaction {
        /// Name of a region with vertices.
        region: String,
        /// Axis.
        axis: super::Axis,
    },
    /// Moment [N m] that they exert about an axis through a point: of the forces on the nodes, in their places at the end of the step, and of the
    /// moments on the directors.
    ReactionMoment {
        /// Name of a region with vertices.
        region: String,
        /// Direction of the axis.
        axis: super::Axis,
        /// A point on it [m].
        #[serde(default)]
        about: [f64; 3],
    },
    /// Frequency [Hz] of a mode of `[modes]`; negative where the equilibrium is unstable.
    Frequency {
        /// Number of the mode, from 1.
        mode: usize,
    },
    /// Factor on the load [1] of a mode of `[modes]`.
    BucklingFactor {
        /// Number of the mode, from 1.
        mode: usize,
    },
    /// Distance [m] between the two vertices nearest to two points of the initial mesh.
    DistanceBetween {
        /// Point of the initial mesh [m].
        a: [f64; 3],
        /// Another point of the initial mesh [m].
        b: [f64; 3],
    },
    /// Largest distance of a vertex from the exact cylinder into which the xy plane rolls along x, over the initial length along x, after
    /// the best rigid fit [1].
    CylinderDistance {
        /// Radius [m], > 0.
        radius: f64,
    },
    /// Distance [m] from the exact surface into which a map takes the initial mesh, after the best rigid fit of the nodes.
    SurfaceDistance {
        /// Exact place of a point of the initial mesh [m], of x, y, z, r, theta.
        position: [Expr; 3],
        /// Which distance.
        #[serde(default)]
        kind: Distance,
        /// Whether the mirror image of the exact surface is as good.
        #[serde(default = "yes")]
        mirror: bool,
        /// Length that the distance is divided by [m], > 0, such as the surface's diameter. Absent: the distance itself.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        over: Option<f64>,
    },
    /// The same from the shape that a flattened mesh had: the field `original_position` of its nodes (3 components [m]).
    OriginalDistance {
        /// Which distance.
        #[serde(default)]
        kind: Distance,
        /// Whether the mirror image is as good.
        #[serde(default)]
        mirror: bool,
        /// Length that the distance is divided by [m], > 0. Absent: the distance itself.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        over: Option<f64>,
    },
    /// Largest distance [m] of a node from the mirror image of the node that is its mirror image in the initial mesh: 0 for a shape as symmetric as
    /// that. None where a node has no such partner.
    Asymmetry {
        /// Axis across the mirror.
        axis: super::Axis,
        /// Place of the mirror along it [m].
        #[serde(default)]
        at: f64,
        /// Length that the distance is divided by [m], > 0. Absent: the distance itself.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        over: Option<f64>,
    },
    /// Square of the mean [1/m2] or Gauss curvature [1/m4], by quadrics fitted to the nodes around each node.
    CurvatureSquare {
        /// Which curvature.
        of: CurvatureKind,
        /// Mean over the surface or sum over the nodes.
        #[serde(default)]
        weighting: Weighting,
    },
    /// Number of waves of a closed rim: the strongest Fourier mode of the heights of its vertices over its best plane, by its initial arc
    /// length. 0 for a flat rim.
    Waves {
        /// Name of a region whose edges form one closed loop.
        region: String,
    },
    /// Amplitude of that mode [m], half of the height from trough to crest.
    WaveAmplitude {
        /// Name of a region whose edges form one closed loop.
        region: String,
    },
    /// Elastic energy over a given one [1], or in J without.
    Energy {
        /// Part of the energy.
        #[serde(default)]
        part: EnergyPart,
        /// Energy that it is divided by [J], > 0: a number or an expression of the shell's `h`, `E` and `nu`, as `"E * h^3"`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        over: Option<Expr>,
    },
    /// Elastic energy over that which the initial shape has in the same rest forms, those of the time of the measure [1].
    EnergyRatio {
        /// Part of both energies.
        #[serde(default)]
        part: EnergyPart,
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
        /// What is taken off each value before, in the field's unit, of x, y, z, r, theta and t, the place (of a face, its centroid) being that
        /// in the initial mesh: an exact solution, so that the statistic is that of the error. Absent: nothing.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        minus: Option<Expr>,
        /// Name of the region whose faces (for fields of the vertices, its vertices) count. Absent: all.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        region: Option<String>,
    },
    /// The load factor `t`, or the time [s].
    LoadFactor,
    /// The load factor `t`, or the time [s], that a run has come to; in a sweep also that of a run whose equations could not be solved any more, which then
    /// is no failure but a result.
    TimeReached,
    /// The same, but no further than a column of `history.csv` keeps between two bounds: how long a run stays sound that does not fail.
    TimeWithin {
        /// Name of the column.
        column: String,
        /// Smallest value, in the column's unit.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// The value of a column of `history.csv` at the step that is measured, by default the last, for example `kinetic_energy_J`.
    History {
        /// Name of the column.
        column: String,
    },
    /// Newton iterations of the whole run.
    NewtonIterations,
    /// Numeric factorisations of the whole run.
    Factorizations,
}

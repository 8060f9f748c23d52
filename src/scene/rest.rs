//! Table `[rest]`: the shape the shell would like to have.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a law becomes the rest metric of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// Rest lengths of the edges, so that both faces of an edge agree about it.
    #[default]
    Edges,
    /// The law's value at the centroid (as the first papers do). Prestresses the sheet by the mesh; for replication.
    Centroid,
}

impl Sampling {
    /// Name in scenes and tables.
    pub fn name(self) -> &'static str {
        match self {
            Sampling::Edges => "edges",
            Sampling::Centroid => "centroid",
        }
    }
}

/// Rest shape: at most one law (`[rest.pullback]`, `[rest.linear]`); without one, the forms of the initial mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// How the law becomes the rest metric of a face.
    #[serde(default)]
    pub sampling: Sampling,
    /// Share of the law in force at time `t`, the rest being the initial forms, 0 to 1. Default: `t` in statics if the law itself does not
    /// depend on t, else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<Expr>,
    /// Forms given in the xy plane; the mesh must be a graph over it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pullback: Option<Pullback>,
    /// Swelling that varies linearly through the thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear: Option<Linear>,
}

/// Law `pullback`: `abar = T^T abar_xy T`, `bbar = T^T bbar_xy T`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pullback {
    /// First form `[11, 12, 22]` in Euclidean or polar components [1], of x, y, r, theta, t. Default: the flat metric.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub abar: Option<[Expr; 3]>,
    /// Second form `[11, 12, 22]` [1/m], of x, y, r, theta, t: a positive 11 curls the ends of the x axis towards the top. Default: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bbar: Option<[Expr; 3]>,
    /// What the components refer to: dx, dy or dr, dtheta (then 22 is in m2 for abar and m for bbar).
    #[serde(default)]
    pub components: Components,
}

/// Coordinates that the components of a pulled back form refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Components {
    /// x and y.
    #[default]
    Cartesian,
    /// r and theta: `abar = ["1", "0", "sin(r)^2"]` is the sphere of radius 1.
    Polar,
}

/// Law `linear`: `gbar+- = (1 + m+- mu)^2 (a0 -+ h b0)`, `h` the thickness, + the top (the side of the normal), - the bottom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// Additional moisture at the top, percent of what the material holds at the start: -100 is bone dry, 100 twice as moist. Of x, y, z, r,
    /// theta, t.
    pub m_plus: Expr,
    /// The same at the bottom.
    pub m_minus: Expr,
    /// Relative change of length per percent of `m_plus` and `m_minus`; along the fibres if there is a machine direction.
    pub mu: f64,
    /// The same across the fibres. Needs, and is needed by, `machine_direction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mu_perp: Option<f64>,
    /// Direction of the fibres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine_direction: Option<Direction>,
}

/// Direction of the fibres in the initial shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Direction {
    /// A vector of space, projected onto each face, of any length > 0.
    Vector([f64; 3]),
    /// Angle from the x axis in the xy plane [degrees], of x, y, z, r, theta; projected onto each face.
    Angle(Expr),
}

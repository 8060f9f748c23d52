//! Key `model` and table `[cosserat]`: the Cosserat surface of Wu and de Melo and the surface of Terzopoulos and others, on a grid.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// A Koiter shell on triangles; needs `[shell]`.
    #[default]
    Koiter,
    /// A Cosserat surface on a grid (Wu and de Melo); needs `[mesh.grid]` and `[cosserat]`.
    Cosserat,
    /// The surface of Terzopoulos, Platt, Barr and Fleischer (1987), with which Wu and de Melo compare: coordinates count nodes, so its constants
    /// hold for one grid only. Needs `[mesh.grid]` and `[cosserat]`.
    Terzopoulos,
}

impl Model {
    /// Name in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Model::Koiter => "koiter",
            Model::Cosserat => "cosserat",
            Model::Terzopoulos => "terzopoulos",
        }
    }
}

/// How the equations are made discrete.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GridScheme {
    /// The energy on the grid, differentiated; implicit Euler by Newton's method, or statics. Borders are free. The one to take.
    #[default]
    Variational,
    /// Wu and de Melo's semi-implicit finite differences: one linear system a step, stable for some time only. Dynamics only.
    StrongForm,
}

/// What a difference is that reads a node outside the grid. `strong-form` only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GridBorder {
    /// Zero, which leaves derivatives undefined on two of the four sides.
    #[default]
    Paper,
    /// Derivatives are those of the nearest place that has them, and outer ones are taken from both sides.
    Symmetric,
}

/// Form of the divergence of the stress. `strong-form` only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Divergence {
    /// (22): derivative and Christoffel symbols.
    #[default]
    AsPrinted,
    /// `(1/sqrt G) D-_i (sqrt G N^i)`.
    Conservative,
}

/// A constant of elasticity for the components 11, 12, 22: one number for all, or three.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Constant {
    /// The same for all components.
    One(f64),
    /// Components 11, 12, 22.
    Three([f64; 3]),
}

impl Constant {
    /// Components 11, 12, 22.
    pub fn components(self) -> [f64; 3] {
        match self {
            Constant::One(value) => [value; 3],
            Constant::Three(values) => values,
        }
    }
}

impl<'de> Deserialize<'de> for Constant {
    // By hand, because an untagged enum would lose the place of a wrong value in the file.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Constant;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number or three numbers [11, 12, 22]")
            }
            fn visit_f64<E>(self, v: f64) -> Result<Constant, E> {
                Ok(Constant::One(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<Constant, E> {
                Ok(Constant::One(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> Result<Constant, E> {
                Ok(Constant::One(v as f64))
            }
            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, seq: A) -> Result<Constant, A::Error> {
                Deserialize::deserialize(serde::de::value::SeqAccessDeserializer::new(seq)).map(Constant::Three)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A surface on the nodes of `[mesh.grid]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cosserat {
    /// `eta_ij`, resistance to stretching [N/m], > 0. For `terzopoulos` the paper's Phi_ij [J/m4].
    pub eta: Constant,
    /// `xi_ij`, resistance to bending [N m], > 0. For `terzopoulos` Psi_ij [J/m2].
    pub xi: Constant,
    /// `phi_ij`, which couples both [N]; `phi^2 < 4 eta xi`. Not for `terzopoulos`. Default: 0.
    #[serde(default = "zero")]
    pub phi: Constant,
    /// Total mass [kg], > 0. Needed by dynamics and gravity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Total damping [kg/s], > 0. Dynamics only. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Scheme.
    #[serde(default)]
    pub scheme: GridScheme,
    /// Differences at the border.
    #[serde(default)]
    pub border: GridBorder,
    /// Form of the divergence.
    #[serde(default)]
    pub divergence: Divergence,
    /// Keep the mixed terms of (28): an isotropic surface, whose energy is the same in any coordinates.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixed_terms: bool,
    /// A stream (36) that drags the surface along. Dynamics only. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stream: Option<Stream>,
    /// A round table on which nodes stick. Dynamics only. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<RoundTable>,
    /// Forces along the surface's normal on nodes. Dynamics only.
    #[serde(default, rename = "normal-force", skip_serializing_if = "Vec::is_empty")]
    pub normal_forces: Vec<NormalForce>,
}

fn zero() -> Constant {
    Constant::One(0.0)
}

/// A stream whose force per area is `coefficient (n.(velocity - r_t)) n`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stream {
    /// Velocity far away [m/s].
    pub velocity: [f64; 3],
    /// Coefficient [Pa s/m], > 0. Default: 0.032, that of the paper.
    #[serde(default = "stream_coefficient")]
    pub coefficient: f64,
    /// Factor in time, of t, >= 0. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

fn stream_coefficient() -> f64 {
    0.032
}

/// A horizontal disc. A node that lies on it at the start, or comes down on it, sticks where it touches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoundTable {
    /// Centre [m]; its z is the height of the table.
    pub centre: [f64; 3],
    /// Radius [m], > 0.
    pub radius: f64,
}

/// A force on every node of a region along the normal that the surface has there, which it follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalForce {
    /// Name of a region with vertices.
    pub region: String,
    /// Force on each node [N], finite; positive along the normal.
    pub force: f64,
    /// Factor in time, of t. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

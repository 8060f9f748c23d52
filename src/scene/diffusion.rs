//! Tables `[moisture]` and `[heat]`: what diffuses through the shell, from where, and what it changes besides the rest shape.

use super::{Expr, Scalar};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Diffusion through sheet and thickness: `du/dt = div(D grad u) + source`, `u` the additional moisture [%] or the temperature above a reference
/// [K]. Percents are of whatever the coefficients of swelling refer to, as a rule of what the material holds at the start: then -100 is bone dry. The
/// geometry is that of the rest shape at the start. `u` drives the laws of `[rest]` that name no moisture of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Diffusion {
    /// Layers of prisms through the thickness, 1 to 1000. One layer, as Chen et al. (2018) have it, lets the other side know at once. Default: 8.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layers: Option<usize>,
    /// Thickness of the layers. Default: `cosine`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<Spacing>,
    /// Heights of the layers' boundaries as fractions of the thickness, from 0 at the bottom to 1 at the top, ascending. In place of `layers` and `spacing`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levels: Option<Vec<f64>>,
    /// Diffusion coefficients.
    pub diffusivity: Diffusivity,
    /// Mass matrix.
    #[serde(default)]
    pub mass: DiffusionMass,
    /// Integration in time.
    #[serde(default)]
    pub scheme: Scheme,
    /// Longest step [s], > 0; a step of the shell is divided into equal ones. Absent: one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dt: Option<f64>,
    /// Start, of x, y, z, r, theta and zeta (-1 at the bottom, 1 at the top), or a field of the mesh.
    #[serde(default = "zero")]
    pub initial: Scalar,
    /// What is added per second, of x, y, z, r, theta, zeta and t. Absent: nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<Expr>,
    /// What the laws of `[rest]` read.
    #[serde(default)]
    pub seen: Seen,
    /// What enters through the surface. What is not named is sealed.
    #[serde(default, rename = "boundary", skip_serializing_if = "Vec::is_empty")]
    pub boundaries: Vec<Boundary>,
    /// Other diffusion coefficients for the faces of some regions; later ones win.
    #[serde(default, rename = "region", skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<DiffusionRegion>,
    /// Factor on the stiffness of each face, > 0, of u, the mean over the face and its thickness. Absent: the stiffness stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Expr>,
    /// Mass per volume that 100 % of moisture add [kg/m3]: what the shell holds per volume at the start where percents are of that, the density of the
    /// dry shell where they are of its mass, that of water where they are of the volume. What is added has the shell's velocity, so it brings momentum and
    /// calls forth no force. `[moisture]` only. Absent: the mass stays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_density: Option<f64>,
    /// Also export the prisms in the present shape, as wedges (`vtk/moisture_prisms.pvd`, `vtk/temperature_prisms.pvd`).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub prisms: bool,
}

/// How the thickness is divided into layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    /// Thinner towards both faces: `(1 - cos(pi i / n)) / 2`.
    #[default]
    Cosine,
    /// Equal.
    Uniform,
}

/// Diffusion coefficients [m2/s].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Diffusivity {
    /// Through the thickness, >= 0.
    pub through: f64,
    /// In the sheet, >= 0; along the fibres if `across` is there.
    pub along: f64,
    /// In the sheet across the fibres, >= 0. Needs `[machine-direction]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<f64>,
}

/// Diffusion coefficients of one region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiffusionRegion {
    /// Name of a region with faces.
    pub region: String,
    /// Diffusion coefficients there.
    pub diffusivity: Diffusivity,
}

/// Mass matrix of the diffusion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DiffusionMass {
    /// Diagonal: with `backward-euler` no value leaves the range of the data, on meshes that are Delaunay in the metric of the diffusivity, with
    /// no obtuse angle opposite an edge of the rim. What leaves it elsewhere is in the history.
    #[default]
    Lumped,
    /// Galerkin. Values leave the range of the data where a step is short against the time to cross a layer, `D dt < (thickness of the layer)^2 / 6`.
    Consistent,
}

/// Integration of the diffusion in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// First order; keeps the range of the data.
    #[default]
    BackwardEuler,
    /// Second order, L-stable; values may leave the range of the data a little when a step is long.
    Sdirk2,
}

/// What rest laws read at a place. How they become the rest metric of a face is said by `rest.sampling`: its `centroid` is the way of Chen et al. (2018).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Seen {
    /// The value there, linear over each face, so that both faces of an edge agree about its rest length.
    #[default]
    Places,
    /// The mean of the face, as in Chen et al. (2018). On an edge that is not the value there, so that the sheet is prestressed by its mesh.
    Faces,
}

/// A part of the shell's surface through which something enters. Exactly one of `value`, `flux` and `exchange`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Side.
    pub side: Side,
    /// Name of a region: its faces, or at the rim its edges. Absent: all of the side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Given value [% or K], of x, y, z, r, theta, t: a side that is kept wet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<Expr>,
    /// What enters per area and second [% m/s or K m/s], of x, y, z, r, theta, t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flux: Option<Expr>,
    /// Exchange with the air.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exchange: Option<Exchange>,
    /// In force from this time on [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// In force until this time [s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
    /// In force only at vertices whose z is below this [m] at the start of a step of the shell: wet ground. It is the middle surface that counts, and
    /// `side` stays the same side when the shell turns over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below: Option<f64>,
}

/// Side of the shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The side of the normal.
    Top,
    /// The other one.
    Bottom,
    /// The edges of the sheet, over its whole thickness.
    Rim,
}

/// What enters is `coefficient (outside - u)` per area and second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exchange {
    /// Coefficient [m/s], > 0: the diffusivity times Biot's number over the thickness.
    pub coefficient: f64,
    /// Value outside [% or K], of x, y, z, r, theta, t.
    pub outside: Expr,
}

impl Diffusion {
    /// Number of layers.
    pub fn layers(&self) -> usize {
        self.levels.as_ref().map_or(self.layers.unwrap_or(8), |levels| levels.len() - 1)
    }
}

fn zero() -> Scalar {
    Scalar::Expr(Expr::Number(0.0))
}

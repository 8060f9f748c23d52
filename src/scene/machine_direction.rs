//! Table `[machine-direction]`: where the fibres of the material run.

use super::{Expr, Scalar};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Direction of the fibres in the initial shape, by exactly one of its keys. Swelling across the fibres (`mu_perp`), growth by two factors
/// and orthotropic materials refer to it; it is exported as the vector `machine_direction`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum MachineDirection {
    /// A vector of space, projected onto the surface, of any length > 0.
    Vector([f64; 3]),
    /// Angle from the x axis in the xy plane [degrees], of x, y, z, r, theta, or a field of the mesh; projected onto the surface.
    Angle(Scalar),
    /// Away from the vertical axis through a point.
    Radial(Axis),
    /// Around the vertical axis through a point, anticlockwise seen from above.
    Azimuthal(Axis),
    /// Along the gradient of a scalar of x, y, z, r, theta, projected onto the surface.
    Gradient(Expr),
    /// A vector field of the mesh file, projected onto the surface.
    Field(String),
    /// Carried over the surface from one face by parallel transport.
    Transport(Transport),
}

/// A vertical axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Axis {
    /// A point of it, x and y [m]. Default: the origin.
    pub center: [f64; 2],
}

/// Where a transported direction starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Transport {
    /// The face whose centroid is nearest to this point [m] has the direction.
    pub from: [f64; 3],
    /// The direction there, projected onto the face, of any length > 0.
    pub vector: [f64; 3],
}

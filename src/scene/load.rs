//! Tables `[gravity]`, `[[force]]`, `[[edge-load]]`, `[[moment]]`, `[[pressure]]` and `[[pin]]`.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Gravity, or another acceleration that acts on all mass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration [m/s2], of x, y, z, r, theta (initial place) and t, as of a turning or shaken support. Each node's mass takes that of its place.
    #[serde(default = "standard_gravity")]
    pub acceleration: [Expr; 3],
    /// Factor in time, of t. Default: the load factor `t` in statics without `end`, else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

fn standard_gravity() -> [Expr; 3] {
    [0.0, 0.0, -9.80665].map(Expr::Number)
}

/// A force on every vertex of a region; it keeps its direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Name of a region with vertices.
    pub region: String,
    /// Force on each vertex [N], each component finite.
    pub force: [f64; 3],
    /// Factor in time, of t. Default: the load factor `t` in statics without `end`, else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

/// A force per length on the edges of a region; it keeps its direction, and the length is that of the initial shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeLoad {
    /// Name of a region with edges.
    pub region: String,
    /// Force per length [N/m], each component finite.
    pub force: [f64; 3],
    /// Factor in time, of t. Default: the load factor `t` in statics without `end`, else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

/// A moment per length that turns the directors of the edges of a region about the edges. Not with `director = "average"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Moment {
    /// Name of a region with edges.
    pub region: String,
    /// Moment per length of the initial shape [N]; its part along each edge acts, and goes on acting about the edge as it turns.
    pub moment: [f64; 3],
    /// Factor in time, of t. Default: the load factor `t` in statics without `end`, else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

/// Pressure on the faces of a region; it follows the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// Name of a region with faces. Absent: all faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Pressure [Pa], of x, y, z, r, theta (present place, as of a liquid) and t; positive pushes along the normal, towards the top.
    pub pressure: Expr,
    /// Factor in time, of t. Default: the load factor `t` in statics without `end`, else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

/// A support: components of the vertices, and the directors of the edges, of one region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pin {
    /// Name of a region.
    pub region: String,
    /// Components of the position that are held: any of `"x"`, `"y"`, `"z"`. Default: all three.
    #[serde(default = "all_components")]
    pub components: Vec<Axis>,
    /// What happens to the directors of the region's edges. Absent: they are free (a hinge).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub director: Option<PinDirector>,
    /// Prescribed displacement of held components. Absent: they stay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}

fn all_components() -> Vec<Axis> {
    vec![Axis::X, Axis::Y, Axis::Z]
}

/// Support of directors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PinDirector {
    /// Held at its initial direction: a clamped edge.
    Clamped,
    /// Held in the plane of symmetry with this normal, which must contain the edges.
    Symmetry([f64; 3]),
    /// Clamped, and turned about the edges. Not with `director = "average"`.
    Rotation(Rotation),
}

/// A prescribed rotation of clamped directors about their edges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Axis that says which sense is positive; not orthogonal to the edges.
    pub axis: [f64; 3],
    /// Angle since the start [degrees], of t.
    pub angle: Expr,
}

/// Displacement of the held components [m], of x, y, z (initial place) and t.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Along x [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<Expr>,
    /// Along y [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<Expr>,
    /// Along z [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<Expr>,
}

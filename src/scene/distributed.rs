//! Tables `[[surface-load]]`, `[[body-force]]` and `[[wind]]`: loads that are spread over faces.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A force that is spread over the faces of a region and keeps its direction: per initial area in `[[surface-load]]`, as of snow or tiles; per
/// volume, initial area times thickness, in `[[body-force]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpreadForce {
    /// Name of a region with faces. Absent: all faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Force per area [N/m2], or in `[[body-force]]` per volume [N/m3], of x, y, z, r, theta (initial place) and t.
    pub force: [Expr; 3],
    /// Factor in time, of t. Default: the load factor `t` in statics without `end`, unless the force itself is one of t; else 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Expr>,
}

/// Drag of the air: per present area `density / 2 (normal |u_n| u_n + tangential |u_t| u_t)`, `u` being the velocity of the air relative to
/// the surface, `u_n` its part along the normal and `u_t` the rest. The surface's velocity is that of the state that a step seeks (implicit);
/// its place, area and normal are those of the start, by integrators of second order moved on with its velocities. Needs `[dynamics]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wind {
    /// Name of a region with faces. Absent: all faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Velocity of the air [m/s], of x, y, z, r, theta (present place) and t. Absent: still air.
    #[serde(default = "still")]
    pub velocity: [Expr; 3],
    /// Density of the air [kg/m3], > 0.
    #[serde(default = "air")]
    pub density: f64,
    /// Drag coefficient across the surface [1], >= 0; about 1.2 for a plate that faces the wind.
    #[serde(default = "across")]
    pub normal: f64,
    /// Drag coefficient along the surface, of both sides together [1], >= 0; about 0.01 for skin friction.
    #[serde(default)]
    pub tangential: f64,
}

fn still() -> [Expr; 3] {
    [0.0; 3].map(Expr::Number)
}

fn air() -> f64 {
    1.2
}

fn across() -> f64 {
    1.2
}

//! Table `[modes]`: the lowest modes about the last equilibrium.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ModeKind {
    /// Small vibrations about the last equilibrium, its stresses included. Needs `density` in [shell].
    Vibration,
    /// Factors on the loads of the end at which the shell buckles: `det (K0 + factor (K1 - K0)) = 0` with the tangent stiffnesses `K0` of the first state
    /// and `K1` of the last equilibrium. Near the load at which it buckles, factors near 1, this is the point at which the path divides; from a small
    /// part of it, it includes the first-order change of shape, as programs that keep the stress stiffness alone do not, and for shells that are curved
    /// before they buckle the factors differ: go nearer until they do not change. Needs `steps` > 0. Does not see [[moment]], which has no stiffness.
    Buckling,
}

/// The lowest modes about the last equilibrium, by the verb `modes` (`modes.h5`, `modes.json`, `vtk/modes.pvd`). Needs `[statics]`; a free
/// body vibrates about its initial shape with `steps = 0`, its six rigid modes at 0 Hz counted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Modes {
    /// `vibration` or `buckling`.
    pub kind: ModeKind,
    /// Modes to find, 1 to 200.
    #[serde(default = "four")]
    pub count: usize,
    /// Of vibration: what is added to the squared angular frequencies to make the matrix positive definite [1/s2], > 0; by default hardly more
    /// than round-off. Of buckling: a factor on the load, >= 0, at which the shell is still stable, above which factors are looked for; by
    /// default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift: Option<f64>,
}

fn four() -> usize {
    4
}

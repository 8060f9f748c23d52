//! What a scene file may say: plain data, one file per table, every field with its unit and range.
//!
//! A [`Scene`] is what the user said, with defaults filled in and ranges checked; `stage` makes objects from it. Nothing here computes.
//! All quantities are in SI units. A table that is absent stands for a part that does not exist.

mod cosserat;
mod diffusion;
mod distributed;
mod ladder;
mod load;
mod machine_direction;
mod material;
mod matrix;
mod measure;
mod mesh;
mod modes;
mod read;
mod report;
mod rest;
mod scalar;
mod shell;
mod solve;
mod source;
mod stepping;
mod suspicion;
mod sweep;
mod validate;

use crate::math::Expression;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use cosserat::{Constant, Cosserat, Divergence, GridBorder, GridScheme, Model, NormalForce, RoundTable, Stream};
pub use diffusion::{Boundary, Diffusion, DiffusionMass, DiffusionRegion, Diffusivity, Exchange, Scheme, Seen, Side, Spacing};
pub use distributed::{SpreadForce, Wind};
pub use ladder::{Ladder, LadderExpectation, LadderMesh, Refinement};
pub use load::{Axis, EdgeLoad, Force, Gravity, Moment, Motion, Pin, PinDirector, Pressure, Rotation};
pub use machine_direction::{MachineDirection, Transport};
pub use material::{Composition, Lame, Layer, Layers, Material, OrthotropicModuli};
pub use matrix::{Ends, Matrix, MatrixAxis, MatrixPart};
pub use measure::{CurvatureKind, Distance, EnergyPart, Measure, Statistic, Weighting};
pub use mesh::{
    Annulus, Cylinder, Disc, Flatten, FlattenOnto, Grid, MeshFile, MeshTable, Midpoints, Outline, Pattern, Rectangle, Refine, RegionTable,
    SphereCap, Triangulation,
};
pub use modes::{ModeKind, Modes};
pub use read::{SceneFile, parse, read, to_toml};
pub use report::{Expectation, NamedMeasure, Passage, PathMeasures, Report};
pub use rest::{
    Bilayer, Components, Isotropic, Linear, Orthotropic, Prestress, Profile, Pullback, Rest, Sampling, Shape, Surface, Thermal,
    ThermalLayer,
};
pub use scalar::{MeshField, Scalar};
pub use shell::{Director, Element, Mass, Shell, ShellRegion};
pub use solve::{AdaptiveDt, Dynamics, Integrator, Method, Output, Perturbation, RandomVelocity, Relaxation, Solver, Statics};
pub use source::Source;
pub use stepping::{Adaptive, ArcLength, Reached};
pub use suspicion::suspicions;
pub use sweep::{Fit, FitExpectation, FitKind, Largest, Logarithmic, SecondKey, Shapes, Sweep, SweepMeasure, SweepValue, Tied};

/// Variables of an expression of time: t [s], in statics without `end` the load factor.
pub const TIME: &[&str] = &["t"];
/// Variables of an expression of place: x, y, z, r = sqrt(x^2 + y^2) [m] and theta = atan2(y, x) [rad] in the initial shape.
pub const PLACE: &[&str] = &["x", "y", "z", "r", "theta"];
/// Variables of an expression of place and time.
pub const PLACE_AND_TIME: &[&str] = &["x", "y", "z", "r", "theta", "t"];
/// Variables of an expression of a place in the body: besides those of place zeta, from -1 at the bottom to 1 at the top.
pub const BODY: &[&str] = &["x", "y", "z", "r", "theta", "zeta"];
/// Variables of an expression of a place in the body and of time.
pub const BODY_AND_TIME: &[&str] = &["x", "y", "z", "r", "theta", "zeta", "t"];
/// Variable of an expression of moisture or temperature.
pub const DIFFUSED: &[&str] = &["u"];
/// Variables of an expression of the place in the xy plane.
pub const PLANE: &[&str] = &["x", "y", "r", "theta"];
/// Variables of an expression of the place in the xy plane and of time.
pub const PLANE_AND_TIME: &[&str] = &["x", "y", "r", "theta", "t"];
/// Variables of a scale of energy: the shell's own thickness h [m], Young's modulus E [Pa] (not Euler's number) and Poisson's ratio nu.
pub const SHELL: &[&str] = &["h", "E", "nu"];
/// Variables of a prescribed motion: initial place and time.
pub const POSITION_AND_TIME: &[&str] = &["x", "y", "z", "t"];

/// An expression of place and time, as text: `"0.1 * sin(2 * PI * x)"`, or a plain number.
///
/// Which variables it may use is said at each field. Functions: sin cos tan asin acos atan atan2 sinh cosh tanh exp ln log10 sqrt
/// erf erfc abs sign floor ceil round min max; operators: + - * / ^ < <= > >= == != && || and `if(c, a, b)`; constants PI, E, TAU.
/// Comparisons give 1 or 0, angles are in radians, and `-x^2` is `-(x^2)`; see [`crate::math::expression`] for the rest.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Expr {
    /// A number.
    Number(f64),
    /// An expression.
    Text(String),
}

impl Expr {
    /// The expression ready for evaluation; `variables` is the list above that the field's doc says.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn parse(&self, variables: &[&str]) -> Result<Expression, String> {
        match self {
            Expr::Number(value) => Ok(Expression::constant(*value)),
            Expr::Text(text) => Expression::parse(text, variables),
        }
    }
}

impl<'de> Deserialize<'de> for Expr {
    // By hand, because an untagged enum would lose the place of a wrong value in the file.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Expr;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number or an expression in quotes")
            }
            fn visit_f64<E>(self, v: f64) -> Result<Expr, E> {
                Ok(Expr::Number(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<Expr, E> {
                Ok(Expr::Number(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> Result<Expr, E> {
                Ok(Expr::Number(v as f64))
            }
            fn visit_str<E>(self, v: &str) -> Result<Expr, E> {
                Ok(Expr::Text(v.to_owned()))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One line that names the scene in reports.
    #[serde(default)]
    pub title: String,
    /// What the scene shows, and where its numbers come from.
    #[serde(default)]
    pub description: String,
    /// What is simulated. Default: a Koiter shell.
    #[serde(default)]
    pub model: Model,
    /// Where the triangles come from.
    pub mesh: MeshTable,
    /// Splits the faces of the mesh, before it is flattened. Absent: the mesh is as it was made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refine: Option<Refine>,
    /// Flattens the mesh by a conformal map. Absent: the mesh keeps its shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flatten: Option<Flatten>,
    /// Named parts of the mesh, added to those a mesh file or generator names.
    #[serde(default, rename = "region", skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<RegionTable>,
    /// The shell: thickness, material, element. Needed by `model = "koiter"`, absent for others.
    #[serde(default = "Shell::absent", skip_serializing_if = "Shell::is_absent")]
    pub shell: Shell,
    /// The surface on a grid. Needed by `model = "cosserat"` and `model = "terzopoulos"`, absent for a Koiter shell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cosserat: Option<Cosserat>,
    /// Where the fibres run. Absent: the material has none.
    #[serde(default, rename = "machine-direction", skip_serializing_if = "Option::is_none")]
    pub machine_direction: Option<MachineDirection>,
    /// The rest shape. Absent: the initial shape is the rest shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<Rest>,
    /// Moisture that diffuses through the shell. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moisture: Option<Diffusion>,
    /// Heat that diffuses through the shell. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heat: Option<Diffusion>,
    /// Gravity. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// Forces on vertices.
    #[serde(default, rename = "force", skip_serializing_if = "Vec::is_empty")]
    pub forces: Vec<Force>,
    /// Forces along edges.
    #[serde(default, rename = "edge-load", skip_serializing_if = "Vec::is_empty")]
    pub edge_loads: Vec<EdgeLoad>,
    /// Moments along edges.
    #[serde(default, rename = "moment", skip_serializing_if = "Vec::is_empty")]
    pub moments: Vec<Moment>,
    /// Pressures.
    #[serde(default, rename = "pressure", skip_serializing_if = "Vec::is_empty")]
    pub pressures: Vec<Pressure>,
    /// Forces per initial area.
    #[serde(default, rename = "surface-load", skip_serializing_if = "Vec::is_empty")]
    pub surface_loads: Vec<SpreadForce>,
    /// Forces per volume.
    #[serde(default, rename = "body-force", skip_serializing_if = "Vec::is_empty")]
    pub body_forces: Vec<SpreadForce>,
    /// Drag of the air.
    #[serde(default, rename = "wind", skip_serializing_if = "Vec::is_empty")]
    pub winds: Vec<Wind>,
    /// Supports.
    #[serde(default, rename = "pin", skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<Pin>,
    /// Equilibrium by load steps. Exactly one of `statics` and `dynamics` must be there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub statics: Option<Statics>,
    /// Motion in time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamics: Option<Dynamics>,
    /// The lowest modes about the last equilibrium. Absent: not found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes: Option<Modes>,
    /// Nonlinear solver.
    #[serde(default)]
    pub solver: Solver,
    /// What is kept.
    #[serde(default)]
    pub output: Output,
    /// What the scene expects of its own result, and its table of error against run time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub report: Option<Report>,
}

impl Scene {
    /// Whether `t` is a time in seconds, in motion or through equilibria that follow a process, and not a load factor.
    pub fn runs_in_time(&self) -> bool {
        self.statics.as_ref().is_none_or(|statics| statics.end.is_some())
    }

    /// End of the run: time [s], or a load factor of 1.
    pub fn end(&self) -> f64 {
        match (&self.statics, &self.dynamics) {
            (Some(statics), _) if statics.steps == 0 => 0.0,
            (Some(statics), _) => statics.end.unwrap_or(1.0),
            (None, Some(dynamics)) => dynamics.end,
            (None, None) => 0.0,
        }
    }

    /// The quantities that diffuse: table, name of the quantity and unit.
    pub fn diffusing(&self) -> impl Iterator<Item = (&'static str, &'static str, &'static str, &Diffusion)> {
        let moisture = self.moisture.iter().map(|table| ("moisture", "moisture", "%", table));
        moisture.chain(self.heat.iter().map(|table| ("heat", "temperature", "K", table)))
    }
}

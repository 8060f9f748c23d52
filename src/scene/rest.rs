//! Table `[rest]`: the shape the shell would like to have.

use super::{Expr, MeshFile, Scalar};
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

/// Rest shape: laws that follow one another in this order, each starting from the forms that those before it make; the first from those of the
/// initial mesh. At most one of `pullback`, `surface`, `shape` and at most one of `linear`, `bilayer`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// How the law becomes the rest metric of a face.
    #[serde(default)]
    pub sampling: Sampling,
    /// Share of the law in force at time `t`, the rest being the initial forms, 0 to 1. Default: the load factor in statics if the law itself does
    /// not depend on t, else 1. Not with laws that read what diffuses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<Expr>,
    /// Forms given in the xy plane; the mesh must be a graph over it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pullback: Option<Pullback>,
    /// Forms of a surface given as a map of the xy plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// Forms of another shape of the same faces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Growth that is alike in all directions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub isotropic: Option<Isotropic>,
    /// Growth by two factors, along the machine direction (or one of its own) and across it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orthotropic: Option<Orthotropic>,
    /// Swelling that varies linearly through the thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linear: Option<Linear>,
    /// Swelling of two layers of the shell, each as a whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bilayer: Option<Bilayer>,
    /// Expansion by heat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thermal: Option<Thermal>,
    /// Tensors that are added, so that the initial shape is under stress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prestress: Option<Prestress>,
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

/// Coordinates that the components of a form in the plane refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Components {
    /// x and y.
    #[default]
    Cartesian,
    /// r and theta: `abar = ["1", "0", "sin(r)^2"]` is the sphere of radius 1.
    Polar,
}

/// Law `surface`: the forms of the surface into which a map takes the xy plane, by exactly one of its keys. Its top is on the side of
/// `r_x x r_y`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Surface {
    /// Three expressions of x, y, r, theta: the point of space [m] to which a point of the plane goes.
    Position([Expr; 3]),
    /// Sphere: distances from the origin become lengths of meridians; outward normal.
    Sphere {
        /// Radius [m], > 0.
        radius: f64,
    },
    /// Torus: x runs around the axis (its length kept on the circle of the tube's centre), y around the tube; outward normal.
    Torus {
        /// Radius of the circle of the tube's centre and of the tube [m], first > second > 0.
        radii: [f64; 2],
    },
    /// Catenoid, or one of the minimal surfaces that share its metric: `x/waist` is the angle about the axis, `y/waist` the height over the waist.
    Catenoid {
        /// Radius of the waist [m], > 0.
        waist: f64,
        /// Turn within the family [degrees]: 0 the catenoid, 90 the helicoid.
        #[serde(default)]
        turn: f64,
    },
    /// Helicoid: the catenoid turned by 90 degrees. A full turn of it rises by `2 pi waist`.
    Helicoid {
        /// Radius of the waist of the catenoid that it can be bent into [m], > 0.
        waist: f64,
    },
}

impl Surface {
    /// The map as three expressions of x, y, r, theta.
    pub fn position(&self) -> [Expr; 3] {
        let texts = match self {
            Surface::Position(exprs) => return exprs.clone(),
            Surface::Sphere { radius: a } => {
                let part = |f: &str| format!("{a:?} * sin(r / {a:?}) * {f}(theta)");
                [part("cos"), part("sin"), format!("{a:?} * cos(r / {a:?})")]
            }
            Surface::Torus { radii: [a, b] } => {
                let part = |f: &str| format!("({a:?} + {b:?} * cos(y / {b:?})) * {f}(x / {a:?})");
                [part("cos"), part("sin"), format!("{b:?} * sin(y / {b:?})")]
            }
            Surface::Catenoid { waist, turn } => minimal(*waist, *turn),
            Surface::Helicoid { waist } => minimal(*waist, 90.0),
        };
        texts.map(Expr::Text)
    }
}

/// The minimal surfaces that share the metric `cosh(y/c)^2 (dx^2 + dy^2)`.
fn minimal(c: f64, turn: f64) -> [String; 3] {
    let (sin, cos) = turn.to_radians().sin_cos();
    let (u, v) = (format!("x / {c:?}"), format!("y / {c:?}"));
    [
        format!("{c:?} * ({cos:?} * cosh({v}) * cos({u}) + {sin:?} * sinh({v}) * sin({u}))"),
        format!("{c:?} * ({cos:?} * cosh({v}) * sin({u}) - {sin:?} * sinh({v}) * cos({u}))"),
        format!("{cos:?} * y + {sin:?} * x"),
    ]
}

/// Law `shape`: the forms that the same faces have in another shape: a mesh file, or a field of three components with the positions of the
/// nodes (after `[flatten]`: `original_position`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// A mesh file with the same faces.
    File(MeshFile),
    /// A field of the mesh with the positions of its nodes [m].
    Field(String),
}

/// Law `isotropic`: `abar = e^(2s) a0`, `bbar = b0`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isotropic {
    /// Logarithm of the factor by which lengths grow, of x, y, z, r, theta, t, or a field of the mesh.
    pub s: Scalar,
}

/// Law `orthotropic`: lengths grow by `factors[0]` along a direction and by `factors[1]` across it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Orthotropic {
    /// Factors along the direction and across it [1], > 0, of x, y, z, r, theta, t, or fields of the mesh.
    pub factors: [Scalar; 2],
    /// Angle of the direction from the x axis in the xy plane [degrees], of x, y, z, r, theta, t, or a field of the mesh. Absent: the machine
    /// direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
}

/// Law `linear`: `gbar+- = (1 + m+- mu)^2 (a0 -+ h b0)`, `h` the thickness, + the top (the side of the normal), - the bottom. Moisture that diffuses
/// (`[moisture]`) takes the place of `m_plus` and `m_minus`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// Additional moisture at the top, percent of what the material holds at the start: -100 is bone dry, 100 twice as moist. Of x, y, z, r,
    /// theta, t. Needed without `[moisture]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m_plus: Option<Expr>,
    /// The same at the bottom.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m_minus: Option<Expr>,
    /// What of the moisture that diffuses counts. `[moisture]` only. Default: `moments`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// Relative change of length per percent of `m_plus` and `m_minus`; along the fibres if `mu_perp` is there.
    pub mu: f64,
    /// The same across the fibres. Needs `[machine-direction]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mu_perp: Option<f64>,
}

/// Law `bilayer`: `gbar+- = (1 + m+- mu+-)^2 (a0 -+ 2/3 h b0)`: the top and the bottom half of the shell swell as a whole. Where
/// `bilayer` of `[shell]` or `[[shell.region]]` makes layers of their own thickness and moduli, these swell, and the forms are those of least energy.
/// Moisture that diffuses (`[moisture]`) takes the place of `m_plus` and `m_minus`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bilayer {
    /// Additional moisture of the top layer [%], of x, y, z, r, theta, t. Needed without `[moisture]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m_plus: Option<Expr>,
    /// Additional moisture of the bottom layer [%].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m_minus: Option<Expr>,
    /// What of the moisture that diffuses counts. `[moisture]` only. Default: `moments`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// Relative change of length per percent: top layer, bottom layer; along the fibres if `mu_perp` is there.
    pub mu: [f64; 2],
    /// The same across the fibres. Needs `[machine-direction]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mu_perp: Option<[f64; 2]>,
}

/// What a law makes of the moisture that varies through the thickness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// All of it: each height swells by its own moisture, and the forms are those of the linear metric nearest to theirs, or of least energy where
    /// the shell has layers of their own moduli.
    #[default]
    Moments,
    /// Its values at the top and the bottom alone, put into the law as it stands: what one layer of prisms knows.
    Sides,
}

/// Law `thermal`: each height expands by its own temperature, lengths by `1 + expansion u`, and the forms are those of the linear metric nearest
/// to theirs, or of least energy where the shell has layers of their own moduli; needs `[heat]`. A temperature that is the same at all heights makes
/// growth alike at all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Thermal {
    /// Relative change of length per kelvin [1/K], negative for what shrinks; along the fibres if `expansion_perp` is there.
    pub expansion: f64,
    /// The same across the fibres. Needs `[machine-direction]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expansion_perp: Option<f64>,
    /// The bottom half of the thickness, or the bottom layer of `bilayer` of `[shell]`, where it expands otherwise: a bimetal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<ThermalLayer>,
}

/// Expansion of the bottom layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThermalLayer {
    /// Relative change of length per kelvin [1/K]; along the fibres if `expansion_perp` of the law is there.
    pub expansion: f64,
    /// The same across the fibres. Default: that of the law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expansion_perp: Option<f64>,
}

/// Law `prestress`: `abar = times a + plus_a`, `bbar = b + plus_b`, of the forms that the laws before it make.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prestress {
    /// Factor on the first form [1], > 0, of x, y, z, r, theta, t, or a field of the mesh: 0.98 puts the shell under tension. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<Scalar>,
    /// First form `[11, 12, 22]` that is added [1], in the xy plane, of x, y, r, theta, t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plus_a: Option<[Expr; 3]>,
    /// Second form that is added [1/m], of x, y, r, theta, t.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plus_b: Option<[Expr; 3]>,
    /// What the components refer to.
    #[serde(default)]
    pub components: Components,
}

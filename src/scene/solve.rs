//! Tables `[statics]`, `[dynamics]`, `[solver]` and `[output]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Equilibrium, the load factor `t` going from 0 to 1; with `end`, equilibria one after the other while a process goes on, `t` being time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Statics {
    /// Steps, 1 to 100000; one that fails is halved. With [modes] of vibration also 0: the initial shape is taken as it is.
    #[serde(default = "default_steps")]
    pub steps: usize,
    /// End of the process that the equilibria follow [s], > 0. Loads and rest laws are then in force from the start, as in motion, unless they say
    /// otherwise. Absent: load steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
    /// Leave equilibria that are unstable: after each step the lowest mode of the Hessian is found, and where its eigenvalue is negative the
    /// shell is moved along it and flows down to a minimum. Adds `branch_switches`, `lowest_eigenvalue` and `lowest_eigenvalue_before` to the
    /// history, the latter two in N/m3 (pressure per displacement by the mode), of the equilibrium kept and of the first one found in the step.
    /// Not with moments, which have no energy.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stable: bool,
    /// Steps whose length follows the iterations of the last. Absent: all are alike, but for those that fail.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<super::Adaptive>,
    /// Follows the path of equilibria through limit points, the load factor being an unknown. Absent: the load factor only grows.
    #[serde(default, rename = "arc-length", skip_serializing_if = "Option::is_none")]
    pub arc_length: Option<super::ArcLength>,
    /// Disturbs the state that the first step starts from; the rest shape stays. Absent: not disturbed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perturbation: Option<Perturbation>,
    /// How equilibria are found.
    #[serde(default, skip_serializing_if = "Method::is_default")]
    pub method: Method,
    /// When dynamic relaxation ends. Absent: the defaults of its keys. Needs `method = "dynamic-relaxation"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<Relaxation>,
}

/// How an equilibrium is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Newton's method.
    #[default]
    Newton,
    /// A damped motion in a time without meaning, without any factorisation, down to a minimum of the energy. Takes many iterations, the more
    /// the thinner the shell and the finer the mesh. Adds `relaxation_iterations` to the history. Not with `stable`.
    DynamicRelaxation,
}

impl Method {
    /// As it is written in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Method::Newton => "newton",
            Method::DynamicRelaxation => "dynamic-relaxation",
        }
    }

    fn is_default(&self) -> bool {
        *self == Method::default()
    }
}

/// When dynamic relaxation ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Relaxation {
    /// Largest distance from equilibrium, as the residual and the lowest frequency tell it, relative to the mesh diameter; 1e-12 to 1e-2.
    pub tolerance: f64,
    /// Iterations of one step before it fails, 1 to 1e9.
    pub max_iterations: u64,
}

impl Default for Relaxation {
    fn default() -> Self {
        Relaxation { tolerance: 1e-7, max_iterations: 200_000 }
    }
}

/// A smooth disturbance along the surface's normal: waves of random direction and phase, the same at a place on every mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Perturbation {
    /// Largest displacement of a node [m], > 0; held coordinates stay.
    pub amplitude: f64,
    /// Another seed makes another disturbance; 0 to 2^63 - 1.
    #[serde(default)]
    pub seed: u64,
}

fn default_steps() -> usize {
    4
}

/// Motion in time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dynamics {
    /// Time step [s], > 0; a step that fails is halved, later steps grow back to this. With `adaptive` only the first.
    pub dt: f64,
    /// End [s], > 0.
    pub end: f64,
    /// Initial velocity of every vertex [m/s], of x, y, z, r, theta; what supports hold has theirs. Absent: at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[super::Expr; 3]>,
    /// How the motion is integrated.
    #[serde(default, skip_serializing_if = "Integrator::is_default")]
    pub integrator: Integrator,
    /// Spectral radius of `generalised-alpha` for motions much faster than a step, 0 to 1: what is left of such a motion after each step. 0 takes
    /// it out at once; 1 damps nothing and is the implicit midpoint rule. Absent: 0.8.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectral_radius: Option<f64>,
    /// Chooses the steps by their error. Absent: they are of size `dt`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<AdaptiveDt>,
    /// Random velocities that are added to that. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub random_velocity: Option<RandomVelocity>,
}

/// Random initial velocities, another one at every node; held coordinates have that of their support.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomVelocity {
    /// Largest speed of a node [m/s], > 0.
    pub speed: f64,
    /// Another seed makes other velocities; 0 to 2^63 - 1.
    #[serde(default)]
    pub seed: u64,
}

/// How motion is integrated in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// First order; damps all that is faster than a step, and much of what is slower. For shapes that follow a slow process.
    #[default]
    ImplicitEuler,
    /// Backward differentiation of second order: takes out what is faster than a step, damps little of what is slower.
    Bdf2,
    /// Second order, with the damping of fast motions that `spectral_radius` states, and next to none of slow ones.
    GeneralisedAlpha,
}

impl Integrator {
    /// As it is written in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Integrator::ImplicitEuler => "implicit-euler",
            Integrator::Bdf2 => "bdf2",
            Integrator::GeneralisedAlpha => "generalised-alpha",
        }
    }

    fn is_default(&self) -> bool {
        *self == Integrator::default()
    }
}

/// Steps chosen by an estimate of the error that each adds to the positions. Adds `local_error` (the estimate over the mesh diameter) and
/// `rejections` (steps tried before, whose error was too large) to the history.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptiveDt {
    /// Largest error that a step may add to the place of a node, relative to the mesh diameter; 1e-10 to 0.1.
    pub tolerance: f64,
    /// Largest step [s], > 0. Absent: as large as the error and the output times allow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_dt: Option<f64>,
}

/// Nonlinear solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// A step is solved when no vertex moved more than this, relative to the mesh diameter, in the last iteration; 1e-14 to 1e-2.
    pub tolerance: f64,
    /// Newton iterations before the fallback takes over, 1 to 1000.
    pub max_iterations: usize,
    /// Times that one step may be halved, 0 to 40, before the run gives up; it also does when so many steps have failed for each nominal step that
    /// it has come, and four times as many.
    pub max_halvings: usize,
}

impl Default for Solver {
    fn default() -> Self {
        Solver { tolerance: 1e-9, max_iterations: 25, max_halvings: 12 }
    }
}

/// What is kept. The newest checkpoint is always kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Times between kept checkpoints [s], > 0; steps are cut to land on them. Absent: every step is kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// Also export the directors of the edges, as points with a vector each (`vtk/directors.pvd`). Not with `director = "average"`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub directors: bool,
    /// Also keep and export the lowest mode of each equilibrium, field `lowest_mode` of the nodes, its largest coordinate 1. Needs
    /// `statics.stable`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lowest_mode: bool,
    /// Also keep what the supports exert: fields `reaction` [N] of the nodes, which is exported, and `reaction_moment` [N m] of the directors,
    /// about their edges. By `generalised-alpha` they are of the moment within the step at which its forces balance, not of its end: half a
    /// step before that with a spectral radius of 1; checkpoints say which, `reaction_time` [s]. The measures `reaction` and `reaction-moment` need it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub reactions: bool,
}

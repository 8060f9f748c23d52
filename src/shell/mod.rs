//! Mechanics of a thin shell: strains of a face, rest forms, energy, mass.
//!
//! - `hinge`: the angle between a face and the director of an edge, with derivatives; everything bends through it
//! - `element`: what an element must offer; `linear_free`, `linear_average` and `quadratic` are the three there are
//! - `material`: what a face is made of; `orthotropic`, `layered`, `neo_hookean` and `tension_field`: its laws other than the isotropic one
//! - `constitutive`: how the energy asks them for stress and stiffness; `projection`: positive semidefinite neighbours of these
//! - `energy`: the Koiter energy of any element, with damping, as a [`crate::sparse::Potential`]
//! - `rest`: growth laws as functions of a point, and how an element interpolates them
//! - `mass`: inertia
//! - `fields`: what is shown of a state: curvatures, strains, stresses, moments
//!
//! Nothing here reads a scene, a file or the time.

mod biot;
mod constitutive;
mod director;
mod element;
mod energy;
pub mod fields;
mod hinge;
mod layered;
mod linear_average;
mod linear_free;
mod mass;
mod material;
mod neo_hookean;
mod orthotropic;
mod projection;
mod quadratic;
mod quadratic_shape;
pub mod rest;
mod tension_field;

pub use constitutive::{Constitutive, General, Uncoupled};
pub use director::{Director, initial_directors};
pub use element::{Element, Strain};
pub use energy::{Koiter, Shell, koiter};
pub use hinge::{Hinge, Measure};
pub use layered::{Bilayer, Layer, LayerMetric, rest_forms};
pub use linear_average::LinearAverage;
pub use linear_free::LinearFree;
pub use mass::{Inertia, Inertial, MassKind};
pub use material::{Constitution, Material, Response};
pub use orthotropic::Orthotropic;
pub use quadratic::QuadraticFree;
pub use rest::{LinearInterpolation, QuadraticInterpolation};

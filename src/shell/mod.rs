//! Mechanics of a thin shell: strains of a face, rest forms, energy, mass.
//!
//! - `hinge`: the angle between a face and the director of an edge, with derivatives; everything bends through it
//! - `normal_component`: the part of a vector along the normal of a surface, with derivatives
//! - `element`: what an element must offer; `linear_free`, `linear_average` and `quadratic` are the three there are
//! - `energy`: the Koiter energy of any element, with damping, as a [`crate::sparse::Potential`]
//! - `rest`: growth laws as functions of a point, and how an element interpolates them
//! - `mass`: inertia
//! - `fields`: what is shown of a state: curvatures, strains, stresses, moments
//!
//! Nothing here reads a scene, a file or the time.

mod director;
mod element;
mod energy;
pub mod fields;
mod hinge;
mod linear_average;
mod linear_free;
mod mass;
mod normal_component;
mod quadratic;
mod quadratic_shape;
pub mod rest;

pub use director::{Director, initial_directors};
pub use element::{Element, Strain};
pub use energy::{Koiter, Material, Shell};
pub use hinge::{Hinge, Measure};
pub use linear_average::LinearAverage;
pub use linear_free::LinearFree;
pub use mass::{Inertia, Inertial, MassKind};
pub use quadratic::QuadraticFree;
pub use rest::{LinearInterpolation, QuadraticInterpolation};

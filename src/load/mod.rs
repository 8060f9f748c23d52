//! Loads on the nodes of a shell, whatever its element.
//!
//! Dead loads are nodal forces that keep their direction; weight, point loads and edge loads are all made of them, by the integrals of the
//! element's shape functions that the caller knows; spread loads take those integrals over fields of place and time. Moments turn directors;
//! pressure follows the surface, and loads along normals follow it from step to step; wind drags it, and drag resists velocities. Supports are not
//! here: they are held unknowns.

mod along_normals;
mod dead;
mod drag;
mod moment;
mod pressure;
mod spread;
mod wind;

use nalgebra::Vector3;

pub use along_normals::{AlongNormals, NormalLoad, cell_area, node_areas};
pub use dead::DeadLoad;
pub use drag::Drag;
pub use moment::EdgeMoment;
pub use pressure::{Pressure, Viewpoint};
pub use spread::{SpreadLoad, SurfacePiece};
pub use wind::Wind;

/// A scalar of place [m] and time [s].
pub type ScalarField = Box<dyn Fn(&Vector3<f64>, f64) -> f64>;

/// A vector of place [m] and time [s].
pub type VectorField = Box<dyn Fn(&Vector3<f64>, f64) -> Vector3<f64>>;

/// A load whose size changes in time by a factor, or by fields of time.
pub trait Load: crate::sparse::Potential {
    /// Sets the factor on all of the load.
    fn set_factor(&mut self, factor: f64);

    /// Sets the time [s] of what depends on it.
    fn set_time(&mut self, _time: f64) {}

    /// Sets the mass that each node carries [kg]; weight follows it, other loads do not.
    fn set_masses(&mut self, _masses: &[f64]) {}

    /// Whether it is proportional to mass.
    fn follows_mass(&self) -> bool {
        false
    }

    /// Starts a step of motion. At `time` [s], for which its state is sought, the unknowns will be near `place`, and from unknowns `x` follow
    /// velocities of `(x - origin) / interval`.
    fn start_step(&mut self, [_place, _origin]: [&[f64]; 2], _time: f64, _interval: f64) {}

    /// What is impossible at a time, with a factor on the load: the name of the key in the table of the load, and the value and place in words.
    fn fault(&self, _time: f64, _factor: f64) -> Option<(&'static str, String)> {
        None
    }
}

/// The first place at which a field of numbers is not finite, in words.
fn not_finite<'a>(places: impl Iterator<Item = &'a Vector3<f64>>, time: f64, value: impl Fn(&Vector3<f64>) -> f64) -> Option<String> {
    let found = places.map(|p| (p, value(p))).find(|(_, v)| !v.is_finite());
    found.map(|(p, v)| format!("is {v} at ({}, {}, {}) m, t = {time}", p.x, p.y, p.z))
}

//! Loads on the nodes of a shell, whatever its element.
//!
//! Dead loads are nodal forces that keep their direction; weight, point loads and edge loads are all made of them, by the integrals of the
//! element's shape functions that the caller knows. Moments turn directors; pressure follows the surface. Supports are not here: they are held unknowns.

mod dead;
mod moment;
mod pressure;

pub use dead::DeadLoad;
pub use moment::EdgeMoment;
pub use pressure::Pressure;

/// A load whose size changes in time by a factor.
pub trait Load: crate::sparse::Potential {
    /// Sets the factor on all of the load.
    fn set_factor(&mut self, factor: f64);

    /// Sets the mass that each node carries [kg]; weight follows it, other loads do not.
    fn set_masses(&mut self, _masses: &[f64]) {}
}

//! Loads on the nodes of a shell, whatever its element.
//!
//! A dead load is a set of nodal forces that keep their direction; weight, point loads and edge loads are all made of them, by the integrals
//! of the element's shape functions that the caller knows. Loads that follow the surface are not here.

mod dead;

pub use dead::DeadLoad;

//! Mesh generators: one file per family of shapes.
//!
//! Every generator returns an oriented manifold with the regions it names, or an [`Error::Input`] whose place is the key of
//! the argument at fault (`mesh.rectangle.size`). The same arguments give the same mesh.

mod delaunay;
mod grid;
mod polygon;
mod rings;

pub use grid::{MATERIAL_COORDINATES, annulus, cylinder, rectangle, surface_grid};
pub use polygon::{outline, rectangle_delaunay};
pub use rings::{disc, sphere_cap};

use crate::error::{Error, Result};

/// Most faces a generator makes: about 2 GB of mesh.
pub const MAX_FACES: usize = 20_000_000;

/// How the cells of a structured mesh are cut into triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// Every cell by the same diagonal; two faces a cell.
    #[default]
    Diagonal,
    /// Diagonals alternate like a chessboard; two faces a cell.
    Alternating,
    /// Both diagonals and a vertex at the centre; four faces a cell.
    CrissCross,
}

/// Size and quality of unstructured triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangulation {
    /// Target edge length [m], > 0.
    pub size: f64,
    /// Smallest angle aimed at [degrees], 0 to 30.
    pub min_angle: f64,
}

/// Refuses a length that is not positive and finite, or whose square is not.
fn check_length(place: &str, value: f64) -> Result<()> {
    if value > 1e-100 && value < 1e100 {
        return Ok(());
    }
    Err(Error::input(place, format!("{value} is not a usable length: expected a positive number of metres")))
}

/// Refuses a count outside `low..=high`.
fn check_count(place: &str, value: usize, low: usize, high: usize) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::input(place, format!("{value} is out of range: expected {low} to {high}")))
}

/// Refuses more than [`MAX_FACES`]; a float because the product of two counts may not fit.
fn check_faces(place: &str, faces: f64) -> Result<()> {
    if faces <= MAX_FACES as f64 {
        return Ok(());
    }
    let message = format!("makes {faces:.3e} faces, more than the {MAX_FACES} that are allowed");
    Err(Error::input_with_help(place, message, "make the cells larger or fewer"))
}

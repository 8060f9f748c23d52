//! What a shell is to diffusion: its faces, their thickness and conductivity, and the levels through the thickness.

use crate::error::{Error, Result};
use std::f64::consts::FRAC_PI_2;

/// Geometry and diffusivity of the shell at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slab {
    /// Number of vertices; each must belong to a face.
    pub vertices: usize,
    /// Vertices of each face; the normal `(v1 - v0) x (v2 - v0)` points to the top.
    pub faces: Vec<[usize; 3]>,
    /// First form of each straight face at rest in the basis `v1 - v0`, `v2 - v0`, components 11, 12, 22 [m2].
    pub metric: Vec<[f64; 3]>,
    /// Thickness of each face [m].
    pub thickness: Vec<f64>,
    /// Diffusivity of each face in the sheet, contravariant components 11, 12, 22 in the same basis [1/s]; see [`in_plane_tensor`].
    pub in_plane: Vec<[f64; 3]>,
    /// Diffusivity of each face through the thickness [m2/s].
    pub through: Vec<f64>,
    /// Heights of the levels as fractions of the thickness: 0 at the bottom, ascending, 1 at the top.
    pub levels: Vec<f64>,
}

/// Whether mass is spread to neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mass {
    /// Every mass matrix is diagonal, also those that multiply a stiffness. With [`super::Scheme::BackwardEuler`] nothing over- or undershoots,
    /// whatever the step, on meshes that are Delaunay in the metric of `D^-1`: where the two angles opposite an edge add up to at most half a turn.
    Lumped,
    /// Galerkin. A jump at the surface makes values next to it undershoot while `D dt` is less than a sixth of the layer squared.
    Consistent,
}

/// Heights of `layers + 1` levels that crowd near the two sides: `(1 - cos(pi i / layers)) / 2`, symmetric about the middle.
pub fn cosine_levels(layers: usize) -> Vec<f64> {
    let lower = |i: usize| (FRAC_PI_2 * i as f64 / layers as f64).sin().powi(2);
    (0..=layers)
        .map(|i| {
            if 2 * i < layers {
                lower(i)
            } else if 2 * i == layers {
                0.5
            } else {
                1.0 - lower(layers - i)
            }
        })
        .collect()
}

/// Contravariant components 11, 12, 22 [1/s] of the diffusivity `along` the machine direction and `across` it in the sheet [m2/s]:
/// `across g^-1 + (along - across) d d^T` with `d` of unit length.
///
/// `metric`: components 11, 12, 22 of `g` [m2]. `direction`: barycentric components, of any length but zero.
pub fn in_plane_tensor(metric: [f64; 3], direction: [f64; 2], along: f64, across: f64) -> [f64; 3] {
    let [g11, g12, g22] = metric;
    let [d1, d2] = direction;
    let isotropic = across / (g11 * g22 - g12 * g12);
    let fibres = (along - across) / (g11 * d1 * d1 + 2.0 * g12 * d1 * d2 + g22 * d2 * d2);
    [isotropic * g22 + fibres * d1 * d1, fibres * d1 * d2 - isotropic * g12, isotropic * g11 + fibres * d2 * d2]
}

impl Slab {
    /// Area of a face [m2].
    pub(super) fn area(&self, face: usize) -> f64 {
        let [g11, g12, g22] = self.metric[face];
        0.5 * (g11 * g22 - g12 * g12).sqrt()
    }

    /// Length of the edge opposite vertex `local` [m].
    pub(super) fn edge(&self, face: usize, local: usize) -> f64 {
        let [g11, g12, g22] = self.metric[face];
        [g11 - 2.0 * g12 + g22, g22, g11][local].sqrt()
    }

    /// Errors: arrays of the wrong length, a vertex without a face, anything that is not a length, a metric or a diffusivity.
    pub(super) fn check(&self) -> Result<()> {
        let fault = |message: String| Err(Error::input("moisture", message));
        let faces = self.faces.len();
        let lengths = [self.metric.len(), self.thickness.len(), self.in_plane.len(), self.through.len()];
        if lengths.iter().any(|n| *n != faces) {
            return fault(format!("{faces} faces, but {lengths:?} metrics, thicknesses, diffusivities in the sheet and through it"));
        }
        let mut used = vec![false; self.vertices];
        for (f, face) in self.faces.iter().enumerate() {
            for &v in face {
                match used.get_mut(v) {
                    Some(used) => *used = true,
                    None => return fault(format!("face {f} has vertex {v}, but there are {} vertices", self.vertices)),
                }
            }
            let positive = |x: f64| x > 0.0 && x.is_finite();
            let definite = |[a, b, c]: [f64; 3]| positive(a) && positive(c) && positive(a * c - b * b);
            // A tensor without diffusion across the fibres has a determinant of round-off.
            let semidefinite = |[a, b, c]: [f64; 3]| a >= 0.0 && c >= 0.0 && (a + c).is_finite() && b * b <= a * c * (1.0 + 1e-9);
            if !definite(self.metric[f]) {
                return fault(format!("face {f}: the metric {:?} is not positive definite", self.metric[f]));
            }
            if !positive(self.thickness[f]) {
                return fault(format!("face {f}: {} is not a thickness: expected a positive number of metres", self.thickness[f]));
            }
            if !(semidefinite(self.in_plane[f]) && self.through[f] >= 0.0 && self.through[f].is_finite()) {
                let (tensor, through) = (self.in_plane[f], self.through[f]);
                return fault(format!(
                    "face {f}: {tensor:?} in the sheet and {through} through it are not diffusivities: expected 0 or more"
                ));
            }
        }
        if let Some(v) = used.iter().position(|used| !used) {
            return fault(format!("vertex {v} belongs to no face"));
        }
        let ascending = self.levels.windows(2).all(|pair| pair[0] < pair[1]);
        if self.levels.len() < 2 || self.levels[0] != 0.0 || self.levels[self.levels.len() - 1] != 1.0 || !ascending {
            return fault(format!("the levels {:?} do not ascend from 0 to 1", self.levels));
        }
        Ok(())
    }
}

//! What an element must offer to the Koiter energy.
//!
//! An element turns the unknowns of a face into strains at its integration points. It knows its own stencil and nothing of materials,
//! rest forms or the matrix. The linear elements have one point; an element with more nodes, points and unknowns fits the same way.

use nalgebra::Vector3;

/// Forms at one integration point, in the face's barycentric basis: a11, a12, a22 [m2], b11, b12, b22 [m].
pub type Strain = [f64; 6];

/// A kind of shell element with `N` unknowns per face and `P` integration points.
pub trait Element<const N: usize, const P: usize>: Sync {
    /// Geometry of one face at one state, computed once for values and derivatives.
    type Geometry;

    /// Weights of the integration points in the reference triangle; they add up to its area, 1/2.
    const WEIGHTS: [f64; P];

    /// Leading unknowns of the stencil that the first form depends on; it depends on no others.
    const STRETCHING: usize = N;

    /// Number of faces.
    fn faces(&self) -> usize;

    /// Number of unknowns: three per node, then one per free director.
    fn unknowns(&self) -> usize;

    /// Unknowns of a face; `usize::MAX` where it has none.
    fn stencil(&self, face: usize) -> [usize; N];

    /// Geometry of a face. `u`: values of its stencil.
    fn geometry(&self, face: usize, u: &[f64; N]) -> Self::Geometry;

    /// Forms at the integration points.
    fn forms(&self, geometry: &Self::Geometry) -> [Strain; P];

    /// Derivatives of the forms in the stencil's unknowns.
    fn jacobian(&self, geometry: &Self::Geometry) -> [[[f64; N]; 6]; P];

    /// Adds `sum_i w_i d2(form_i)` to the lower triangle of `hessian`. `membrane_only` leaves the curvatures out, and what it adds for
    /// positive semidefinite membrane weights is positive semidefinite.
    fn hessian(&self, geometry: &Self::Geometry, weights: &[Strain; P], membrane_only: bool, hessian: &mut [[f64; N]; N]);

    /// Tangent vectors `r1`, `r2` [m] at the integration points.
    fn tangents(&self, geometry: &Self::Geometry) -> [[Vector3<f64>; 2]; P];

    /// Reference directors [1], one per director unknown or held director; empty when the element has none.
    fn directors(&self) -> &[Vector3<f64>];

    /// Puts directors back, as a checkpoint has them.
    fn set_directors(&mut self, directors: &[Vector3<f64>]);

    /// Makes the present directors the new references and their angles zero; the state stays what it is.
    fn reframe(&mut self, x: &mut [f64]);

    /// Angles [rad], one per director unknown, by which the directors at `x` are turned from others of an earlier shape, about their edges.
    fn turns(&self, x: &[f64], from: &[Vector3<f64>]) -> Vec<f64>;
}

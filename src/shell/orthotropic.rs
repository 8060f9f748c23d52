//! Orthotropic St. Venant-Kirchhoff law in plane stress, along and across the machine direction of paper.
//!
//! The direction is given per face in barycentric components and made a unit vector in the rest metric of each integration point. Where
//! the direction comes from is not decided here.

use nalgebra::{Matrix2, Matrix3, Vector2};

/// Moduli along (1) and across (2) the machine direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthotropic {
    /// Young's moduli `E1`, `E2` [Pa].
    pub youngs_moduli: [f64; 2],
    /// Poisson's ratio `nu12`: the contraction across under a stretch along. `nu21 = nu12 E2 / E1`.
    pub poissons_ratio: f64,
    /// Shear modulus `G12` [Pa].
    pub shear_modulus: f64,
    /// Machine direction by barycentric components, of any length.
    pub direction: [f64; 2],
}

impl Orthotropic {
    /// Young's modulus [Pa] and Poisson's ratio of an isotropic material of about the same stiffness: `sqrt(E1 E2)`, `sqrt(nu12 nu21)` with
    /// the sign of `nu12`. Exact where `E1 = E2`.
    pub fn means(&self) -> [f64; 2] {
        let [e1, e2] = self.youngs_moduli;
        [(e1 * e2).sqrt(), self.poissons_ratio * (e2 / e1).sqrt()]
    }
}

/// Columns: the unit vectors along and across `direction` in the metric `abar`, by barycentric components.
fn frame(direction: [f64; 2], abar: [f64; 3]) -> Matrix2<f64> {
    let metric = Matrix2::new(abar[0], abar[1], abar[1], abar[2]);
    let d = Vector2::from(direction).normalize();
    let d = d / d.dot(&(metric * d)).sqrt();
    // In the metric a unit vector orthogonal to d is the turned dual of d over sqrt(det).
    let dual = metric * d / metric.determinant().sqrt();
    Matrix2::from_columns(&[d, Vector2::new(-dual.y, dual.x)])
}

/// Rows turn the components 11, 12, 22 of a form `M` into `Q^T M Q`: its 11, twice its 12, its 22. Columns of `q`: the frame.
pub(super) fn engineering(q: &Matrix2<f64>) -> Matrix3<f64> {
    let (u, v) = (q.column(0), q.column(1));
    Matrix3::new(
        u[0] * u[0],
        2.0 * u[0] * u[1],
        u[1] * u[1],
        2.0 * u[0] * v[0],
        2.0 * (u[0] * v[1] + u[1] * v[0]),
        2.0 * u[1] * v[1],
        v[0] * v[0],
        2.0 * v[0] * v[1],
        v[1] * v[1],
    )
}

/// Matrix `C` with `m.C.m / 2 = weight sqrt(det abar) e.K.e / 2`, `e` the components 11, 2 12, 22 of a form `m` along and across the machine
/// direction and `K` the plane-stress stiffness; by its upper triangle.
pub(super) fn norm_matrix(material: &Orthotropic, abar: [f64; 3], weight: f64) -> [f64; 6] {
    let [e1, e2] = material.youngs_moduli;
    let nu12 = material.poissons_ratio;
    let nu21 = nu12 * e2 / e1;
    let w = weight * (abar[0] * abar[2] - abar[1] * abar[1]).sqrt() / (1.0 - nu12 * nu21);
    let shear = material.shear_modulus * (1.0 - nu12 * nu21);
    let k = Matrix3::new(e1, 0.0, nu12 * e2, 0.0, shear, 0.0, nu12 * e2, 0.0, e2) * w;
    let t = engineering(&frame(material.direction, abar));
    let c = t.transpose() * k * t;
    [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]]
}

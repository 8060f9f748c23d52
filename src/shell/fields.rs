//! What is shown of a shell's state at one integration point: curvatures, strains, stresses, moments, energy densities.
//!
//! Tensors are by components in an orthonormal frame of the face whose first axis lies along its first edge, taken in the rest metric for
//! the values and on the present surface for showing them in space; the two differ by the membrane strain.

use super::material::{Constitution, Material};
use super::rest::Forms;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Quantities at one integration point.
#[derive(Clone, Copy, Debug)]
pub struct PointFields {
    /// Principal curvatures [1/m], larger first; negative where the top is convex.
    pub principal_curvatures: [f64; 2],
    /// Their unit directions in space.
    pub principal_directions: [Vector3<f64>; 2],
    /// Half the sum of the principal curvatures [1/m].
    pub mean_curvature: f64,
    /// Their product [1/m2].
    pub gauss_curvature: f64,
    /// Green strain of the midsurface [1].
    pub membrane_strain: Matrix3<f64>,
    /// Second Piola-Kirchhoff stress: the resultant of the membrane over the thickness [Pa].
    pub membrane_stress: Matrix3<f64>,
    /// Bending moment per length [N], positive where it bends the shell like a positive `b - bbar`.
    pub bending_moment: Matrix3<f64>,
    /// Membrane energy per rest area [J/m2]; see [`super::Shell::energies`].
    pub membrane_energy_density: f64,
    /// Bending energy per rest area [J/m2].
    pub bending_energy_density: f64,
}

impl PointFields {
    /// Multiplies what goes with the stiffness by a factor on it.
    pub fn soften(&mut self, factor: f64) {
        self.membrane_stress *= factor;
        self.bending_moment *= factor;
        self.membrane_energy_density *= factor;
        self.bending_energy_density *= factor;
    }
}

/// Eigenvalues, larger first, and unit eigenvectors of a symmetric 2x2 matrix.
fn eigen(m: &Matrix2<f64>) -> ([f64; 2], [Vector2<f64>; 2]) {
    let (mean, half, off) = (0.5 * (m[(0, 0)] + m[(1, 1)]), 0.5 * (m[(0, 0)] - m[(1, 1)]), 0.5 * (m[(0, 1)] + m[(1, 0)]));
    let radius = half.hypot(off);
    let angle = 0.5 * off.atan2(half);
    let v = Vector2::new(angle.cos(), angle.sin());
    ([mean + radius, mean - radius], [v, Vector2::new(-v.y, v.x)])
}

/// Matrix whose columns are the orthonormal frame of a metric (11, 12, 22) by barycentric components, the first along the first edge.
fn frame(a: [f64; 3]) -> Matrix2<f64> {
    let l11 = a[0].sqrt();
    let l21 = a[1] / l11;
    let l22 = (a[2] - l21 * l21).max(0.0).sqrt();
    Matrix2::new(1.0 / l11, -l21 / (l11 * l22), 0.0, 1.0 / l22)
}

/// Fields at a point with tangent vectors `r` [m], present forms and rest forms.
pub fn at_point(r: &[Vector3<f64>; 2], forms: &Forms, rest: &Forms, material: &Material, constitution: &Constitution) -> PointFields {
    let matrix = |m: [f64; 3]| Matrix2::new(m[0], m[1], m[1], m[2]);
    let present = frame([r[0].norm_squared(), r[0].dot(&r[1]), r[1].norm_squared()]);
    let axes = [0, 1].map(|k| r[0] * present[(0, k)] + r[1] * present[(1, k)]);
    let space = |v: &Vector2<f64>| axes[0] * v.x + axes[1] * v.y;
    let tensor = |m: &Matrix2<f64>| {
        let mut t = Matrix3::zeros();
        for i in 0..2 {
            for j in 0..2 {
                t += axes[i] * axes[j].transpose() * m[(i, j)];
            }
        }
        t
    };
    let (k, directions) = eigen(&(present.transpose() * matrix(forms.b) * present));
    let q = frame(rest.a);
    let strain = q.transpose() * (matrix(forms.a) - matrix(rest.a)) * q * 0.5;
    let (stress, energies) = constitution.per_area(material, rest, forms);
    // A derivative in the off-diagonal component is twice the tensor's; components along the edges become those in the frame by the inverse.
    let inverse = q.try_inverse().unwrap_or_else(Matrix2::zeros);
    let resultant = |s: &[f64]| inverse * Matrix2::new(s[0], 0.5 * s[1], 0.5 * s[1], s[2]) * inverse.transpose();
    PointFields {
        principal_curvatures: k,
        principal_directions: [space(&directions[0]), space(&directions[1])],
        mean_curvature: 0.5 * (k[0] + k[1]),
        gauss_curvature: k[0] * k[1],
        membrane_strain: tensor(&strain),
        membrane_stress: tensor(&(resultant(&stress[..3]) * (2.0 / material.thickness))),
        bending_moment: tensor(&resultant(&stress[3..])),
        membrane_energy_density: energies[0],
        bending_energy_density: energies[1],
    }
}

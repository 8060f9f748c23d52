//! Membrane that wrinkles instead of bearing compression: the relaxed energy of Pipkin (1986) over St. Venant-Kirchhoff.
//!
//! With the principal strains `e1 >= e2` in the rest metric, per rest area: taut, where both principal stresses are tensile, `h psi(e1, e2)`;
//! wrinkled `E h/2 e1^2`, the stretch across the wrinkles being free; slack 0. This is convex and has continuous first derivatives. The share
//! `compression` of the St. Venant-Kirchhoff energy stays everywhere, mixed in as `(1 - c) relaxed + c psi`, so that slack parts are no
//! mechanisms and taut ones are exactly St. Venant-Kirchhoff. Bending is as in that law; single wrinkles are not resolved.

use super::element::Strain;
use super::material::{Material, Response, Stiffness, expand, stress_of};
use super::orthotropic::engineering;
use nalgebra::{Matrix2, Matrix3, Vector3};

/// Energy of the wrinkled state, derivative and second derivative in the engineering components 11, 2 12, 22 of the strain.
///
/// `E/2 e1^2` with `e1` the larger eigenvalue, `n` its direction and `m` the other: `d e1 = n.dE.n`, `d2 e1 = 2 (n.dE.m)^2 / (e1 - e2)`.
fn uniaxial(modulus: f64, [e11, gamma, e22]: [f64; 3]) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (mean, half, off) = (0.5 * (e11 + e22), 0.5 * (e11 - e22), 0.5 * gamma);
    let radius = half.hypot(off);
    let e1 = mean + radius;
    let (s, c) = (0.5 * off.atan2(half)).sin_cos();
    let along = Vector3::new(c * c, c * s, s * s);
    let mixed = Vector3::new(-c * s, 0.5 * (c * c - s * s), c * s);
    let turn = 2.0 * e1 / (2.0 * radius);
    (0.5 * modulus * e1 * e1, along * (modulus * e1), (along * along.transpose() + mixed * mixed.transpose() * turn) * modulus)
}

/// Energy, stress and, with `TANGENT`, second derivatives at a point. `stiffness`: of St. Venant-Kirchhoff there.
pub(super) fn respond<const TANGENT: bool>(
    material: &Material,
    compression: f64,
    rest: &Strain,
    stiffness: &Stiffness,
    weight: f64,
    forms: &Strain,
) -> Response {
    let d: Strain = std::array::from_fn(|i| forms[i] - rest[i]);
    let full = stress_of(stiffness, &d);
    let mut response = Response { energy: 0.0, stress: full, tangent: if TANGENT { expand(stiffness) } else { [[0.0; 6]; 6] } };
    response.energy = 0.5 * full.iter().zip(&d).map(|(s, d)| s * d).sum::<f64>();
    // Columns of q are orthonormal in the rest metric.
    let [a, b, c] = [rest[0], rest[1], rest[2]];
    let det = a * c - b * b;
    let (l11, root) = (a.sqrt(), det.sqrt());
    let q = Matrix2::new(1.0 / l11, -b / (l11 * root), 0.0, l11 / root);
    let to_strain = engineering(&q) * 0.5;
    let e = to_strain * Vector3::new(d[0], d[1], d[2]);
    let mean = 0.5 * (e.x + e.z);
    let radius = (0.5 * (e.x - e.z)).hypot(0.5 * e.y);
    let (e1, e2) = (mean + radius, mean - radius);
    if e1 > 0.0 && e2 + material.poissons_ratio * e1 > 0.0 {
        return response;
    }
    let membrane = 0.5 * (0..3).map(|i| full[i] * d[i]).sum::<f64>();
    response.energy -= (1.0 - compression) * membrane;
    response.stress[..3].iter_mut().for_each(|s| *s *= compression);
    response.tangent[..3].iter_mut().for_each(|row| row[..3].iter_mut().for_each(|t| *t *= compression));
    if e1 > 0.0 {
        let scale = (1.0 - compression) * weight * root * material.thickness;
        let (energy, slope, second) = uniaxial(scale * material.youngs_modulus, [e.x, e.y, e.z]);
        response.energy += energy;
        let stress = to_strain.transpose() * slope;
        (0..3).for_each(|i| response.stress[i] += stress[i]);
        if TANGENT {
            let tangent = to_strain.transpose() * second * to_strain;
            for i in 0..3 {
                (0..3).for_each(|j| response.tangent[i][j] += tangent[(i, j)]);
            }
        }
    }
    response
}

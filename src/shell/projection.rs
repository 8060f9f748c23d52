//! Positive semidefinite neighbours of a stress and of a tangent, for the Hessian of a descent.
//!
//! Both are projected in coordinates in which the rest metric is the identity and curvatures count by the thickness, so that the result
//! depends neither on the shape of the face nor on units. The projected Hessians of elements are not formed here.

use super::element::Strain;
use nalgebra::{Cholesky, Matrix6, SMatrix, SymmetricEigen};

/// Lower triangular factor 11, 21, 22 of a metric.
fn factor(abar: [f64; 3]) -> [f64; 3] {
    let l11 = abar[0].sqrt();
    let l21 = abar[1] / l11;
    [l11, l21, (abar[2] - l21 * l21).max(f64::MIN_POSITIVE).sqrt()]
}

/// Projects the membrane stress (11, 12, 22; derivative of the energy in a11, a12, a22) onto positive semidefinite ones in the metric `abar`.
pub(super) fn project_stress(w: &mut Strain, abar: [f64; 3]) {
    // With abar = L L^T, the physical stress is L^T W L; its negative eigenvalue is cut off.
    let [l11, l21, l22] = factor(abar);
    let (w11, w12, w22) = (w[0], 0.5 * w[1], w[2]);
    let s11 = l11 * l11 * w11 + 2.0 * l11 * l21 * w12 + l21 * l21 * w22;
    let s12 = l22 * (l11 * w12 + l21 * w22);
    let s22 = l22 * l22 * w22;
    let (mean, half) = (0.5 * (s11 + s22), 0.5 * (s11 - s22));
    let radius = half.hypot(s12);
    let (low, high) = (mean - radius, mean + radius);
    if low >= 0.0 {
        return;
    }
    if high <= 0.0 {
        w[..3].fill(0.0);
        return;
    }
    // high times the projector onto its eigenvector, pulled back by L^-1.
    let scale = high / (2.0 * radius);
    let (t11, t12, t22) = (scale * (radius + half), scale * s12, scale * (radius - half));
    let (i11, i21, i22) = (1.0 / l11, -l21 / (l11 * l22), 1.0 / l22);
    w[0] = i11 * i11 * t11 + 2.0 * i11 * i21 * t12 + i21 * i21 * t22;
    w[1] = 2.0 * i22 * (i11 * t12 + i21 * t22);
    w[2] = i22 * i22 * t22;
}

/// Projects the second derivatives of an energy in the six forms, at the rest metric `abar` and a thickness [m].
pub(super) fn project_tangent(tangent: &mut [[f64; 6]; 6], abar: [f64; 3], thickness: f64) {
    let [l11, l21, l22] = factor(abar);
    // Forms are S e: M = L E L^T for E by its components 11, sqrt(2) 12, 22, curvatures over the thickness.
    let half = 0.5f64.sqrt();
    let block = [[l11 * l11, 0.0, 0.0], [l11 * l21, half * l11 * l22, 0.0], [l21 * l21, 2.0 * half * l21 * l22, l22 * l22]];
    let mut s = Matrix6::zeros();
    for i in 0..3 {
        for j in 0..3 {
            s[(i, j)] = block[i][j];
            s[(3 + i, 3 + j)] = block[i][j] / thickness;
        }
    }
    let t = SMatrix::from_fn(|i, j| tangent[i][j]);
    let scaled = s.transpose() * t * s;
    if Cholesky::new(scaled).is_some() || !scaled.iter().all(|v| v.is_finite()) {
        return;
    }
    let Some(inverse) = s.try_inverse() else { return };
    let mut eigen = SymmetricEigen::new(scaled);
    eigen.eigenvalues.iter_mut().for_each(|v| *v = v.max(0.0));
    let projected = inverse.transpose() * eigen.recompose() * inverse;
    *tangent = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (projected[(i, j)] + projected[(j, i)])));
}

//! St. Venant-Kirchhoff whose bending strain is the second form over the stretch, to first order in the stretch (Biot's strain; Vitral and Hanna, arXiv
//! 2201.05608; compare Koiter's and Sanders' modified changes of curvature).
//!
//! `h/4 ||S (a - abar)||^2 + h^3/12 ||S (B - bbar)||^2` with `B = b - (D S b + b S D) / 4`, `D = a - abar`, `S = abar^-1`: in one dimension `B` is the turn per
//! length at rest, `k (1 - 3/2 e^2 + ...)` at a stretch `1 + e`. A pure moment then bends without stretching, and moment and turn are proportional,
//! where the Koiter energy shortens by `h^2 k^2 / 12` and softens by `h^2 k^2 / 6`. Where `a = abar` both are the same. Strains of order one are not for it.

use super::element::Strain;
use super::material::{Response, Stiffness, expand, times};

/// `T[i][j][k]` with `B_i = b_i - sum_jk T_ijk D_j b_k` on the components 11, 12, 22; symmetric in j and k.
fn coupling(abar: [f64; 3]) -> [[[f64; 3]; 3]; 3] {
    let det = abar[0] * abar[2] - abar[1] * abar[1];
    let s = [[abar[2] / det, -abar[1] / det], [-abar[1] / det, abar[0] / det]];
    const BASIS: [[[f64; 2]; 2]; 3] = [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 1.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]];
    const PLACE: [[usize; 2]; 3] = [[0, 0], [0, 1], [1, 1]];
    let product =
        |j: usize, k: usize, [r, c]: [usize; 2]| -> f64 { (0..4).map(|n| BASIS[j][r][n / 2] * s[n / 2][n % 2] * BASIS[k][n % 2][c]).sum() };
    std::array::from_fn(|i| std::array::from_fn(|j| std::array::from_fn(|k| 0.25 * (product(j, k, PLACE[i]) + product(k, j, PLACE[i])))))
}

/// Energy, stress and, with `TANGENT`, second derivatives at a point. `stiffness`: of St. Venant-Kirchhoff there.
pub(super) fn respond<const TANGENT: bool>(rest: &Strain, stiffness: &Stiffness, forms: &Strain) -> Response {
    let t = coupling([rest[0], rest[1], rest[2]]);
    let (d, b): ([f64; 3], [f64; 3]) = (std::array::from_fn(|i| forms[i] - rest[i]), std::array::from_fn(|i| forms[3 + i]));
    // Derivatives of B in both forms.
    let by_a: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| -(0..3).map(|k| t[i][j][k] * b[k]).sum::<f64>()));
    let by_b: [[f64; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|k| f64::from(i == k) - (0..3).map(|j| t[i][j][k] * d[j]).sum::<f64>()));
    let bending: [f64; 3] = std::array::from_fn(|i| b[i] + (0..3).map(|j| by_a[i][j] * d[j]).sum::<f64>() - rest[3 + i]);
    let (n, m) = (times(&stiffness[0], d), times(&stiffness[2], bending));
    let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    let jacobian: [[f64; 6]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| if j < 3 { by_a[i][j] } else { by_b[i][j - 3] }));
    let along = |j: usize, m: [f64; 3]| (0..3).map(|i| jacobian[i][j] * m[i]).sum::<f64>();
    let stress = std::array::from_fn(|j| along(j, m) + if j < 3 { n[j] } else { 0.0 });
    let mut tangent = [[0.0; 6]; 6];
    if TANGENT {
        tangent = expand(&[stiffness[0], [0.0; 6], [0.0; 6]]);
        for k in 0..6 {
            let column = times(&stiffness[2], std::array::from_fn(|i| jacobian[i][k]));
            for (j, row) in tangent.iter_mut().enumerate() {
                row[k] += along(j, column);
            }
        }
        for j in 0..3 {
            for k in 0..3 {
                let mixed: f64 = (0..3).map(|i| m[i] * t[i][j][k]).sum();
                tangent[j][3 + k] -= mixed;
                tangent[3 + k][j] -= mixed;
            }
        }
    }
    Response { energy: 0.5 * (dot(n, d) + dot(m, bending)), stress, tangent }
}

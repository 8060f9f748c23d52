//! Constants of elasticity and the quadratic form of strains that they make in a rest metric (Wu and de Melo, (27) to (30)).
//!
//! Strains are `s = (eps_11, eps_12, eps_22, kappa_11, kappa_12, kappa_22)`. The energy per rest area is `1/2 s.C s`, with each mixed component
//! counted twice, as the sums over `i` and `j` do. Without mixed terms `C` couples `eps_ij` with `kappa_ij` only.

use super::geometry::component;
use nalgebra::Matrix6;

/// Quadratic form of the strains, twice the energy per rest area.
pub type Stiffness = [[f64; 6]; 6];

/// The constants `eta` (stretching), `xi` (bending) and `phi` (both together) by components 11, 12, 22.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// `eta_ij` [N/m], > 0.
    pub eta: [f64; 3],
    /// `xi_ij` [N m], > 0.
    pub xi: [f64; 3],
    /// `phi_ij` [N].
    pub phi: [f64; 3],
}

/// Pairs of indices of the three components.
const PAIRS: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 1)];

/// How often each component stands in a sum over `i` and `j`.
const TIMES: [f64; 3] = [1.0, 2.0, 1.0];

/// `C` of the energy (29) with the coefficients (30), or with `mixed` of (27) with the isotropic tensors (28).
///
/// `inverse`: rest metric `G_0^ij` by components. Mixed terms: `A^ijkl = eta (G^ij G^kl + G^ik G^jl + G^il G^jk)`, which is (28) with
/// `beta_1 = beta_2 = beta_3 = eta`, the choice that gives (30) where `ij = kl`. Of two different components `eta` and `xi` enter by their
/// geometric mean, which keeps both energies positive, `phi`, which may be negative, by its mean.
pub fn stiffness(constants: &Constants, inverse: &[f64; 3], mixed: bool) -> Stiffness {
    let g = |i: usize, j: usize| inverse[component(i, j)];
    let mut c = [[0.0; 6]; 6];
    for (p, &(i, j)) in PAIRS.iter().enumerate() {
        for (q, &(k, l)) in PAIRS.iter().enumerate() {
            if p != q && !mixed {
                continue;
            }
            let tensor = if p == q {
                2.0 * g(i, j) * g(i, j) + g(i, i) * g(j, j)
            } else {
                g(i, j) * g(k, l) + g(i, k) * g(j, l) + g(i, l) * g(j, k)
            };
            let weight = TIMES[p] * TIMES[q] * tensor;
            // Without mixed terms 12 and 21 are two squares, not the square of their sum.
            let weight = if mixed || p != 1 { weight } else { 0.5 * weight };
            let mean = |x: &[f64; 3]| if p == q { x[p] } else { (x[p] * x[q]).sqrt() };
            c[p][q] = 2.0 * mean(&constants.eta) * weight;
            c[3 + p][3 + q] = 2.0 * mean(&constants.xi) * weight;
            let coupling = 0.5 * (constants.phi[p] + constants.phi[q]) * weight;
            c[p][3 + q] = coupling;
            c[3 + q][p] = coupling;
        }
    }
    c
}

/// Energy per rest area [J/m2] of strains.
pub fn density(c: &Stiffness, s: &[f64; 6]) -> f64 {
    0.5 * c.iter().zip(s).map(|(row, s_i)| s_i * row.iter().zip(s).map(|(c, s_j)| c * s_j).sum::<f64>()).sum::<f64>()
}

/// Whether the energy is positive for every strain but zero.
pub fn is_positive(c: &Stiffness) -> bool {
    // By components of unit size, or a small `xi` beside a large `eta` would drown in round-off.
    let scale: [f64; 6] = std::array::from_fn(|i| c[i][i].sqrt());
    Matrix6::from_fn(|i, j| c[i][j] / (scale[i] * scale[j])).cholesky().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosserat::geometry;

    const CONSTANTS: Constants = Constants { eta: [30.5, 35.5, 32.0], xi: [1.0, 0.8, 1.2], phi: [0.5, -0.3, 0.4] };
    const METRIC: [f64; 3] = [1.3, 0.4, 0.8];
    const STRAINS: [f64; 6] = [0.1, -0.07, 0.04, 0.3, 0.2, -0.25];

    fn full(s: &[f64]) -> [[f64; 2]; 2] {
        [[s[0], s[1]], [s[1], s[2]]]
    }

    /// (29) and (27) summed as they are printed.
    #[test]
    fn the_forms_are_those_of_the_paper() {
        let inverse = geometry::inverse(&METRIC);
        let g = full(&inverse);
        let (eps, kappa) = (full(&STRAINS[..3]), full(&STRAINS[3..]));
        let (mut plain, mut mixed) = (0.0, 0.0);
        let one = Constants { eta: [2.0; 3], xi: [3.0; 3], phi: [-1.0; 3] };
        for i in 0..2 {
            for j in 0..2 {
                let c = component(i, j);
                let factor = 2.0 * g[i][j] * g[i][j] + g[i][i] * g[j][j];
                plain += factor
                    * (CONSTANTS.eta[c] * eps[i][j] * eps[i][j]
                        + CONSTANTS.xi[c] * kappa[i][j] * kappa[i][j]
                        + CONSTANTS.phi[c] * eps[i][j] * kappa[i][j]);
                for k in 0..2 {
                    for l in 0..2 {
                        let tensor = g[i][j] * g[k][l] + g[i][k] * g[j][l] + g[i][l] * g[j][k];
                        mixed += tensor * (2.0 * eps[i][j] * eps[k][l] + 3.0 * kappa[i][j] * kappa[k][l] - eps[i][j] * kappa[k][l]);
                    }
                }
            }
        }
        assert!(plain > 0.1 && mixed > 0.1);
        assert!((density(&stiffness(&CONSTANTS, &inverse, false), &STRAINS) - plain).abs() < 1e-12);
        assert!((density(&stiffness(&one, &inverse, true), &STRAINS) - mixed).abs() < 1e-12);
    }

    /// With mixed terms the energy is the same in any coordinates; without them it is not, unless they are turned into each other.
    #[test]
    fn mixed_terms_make_the_energy_invariant() {
        let one = Constants { eta: [2.0; 3], xi: [3.0; 3], phi: [1.0; 3] };
        let t = [[1.1, 0.3], [-0.2, 0.9]];
        let turn = |s: &[f64]| {
            let s = full(s);
            let at = |i: usize, j: usize| (0..2).map(|k| (0..2).map(|l| t[k][i] * s[k][l] * t[l][j]).sum::<f64>()).sum::<f64>();
            [at(0, 0), at(0, 1), at(1, 1)]
        };
        let (metric, eps, kappa) = (turn(&METRIC), turn(&STRAINS[..3]), turn(&STRAINS[3..]));
        let strains = [eps[0], eps[1], eps[2], kappa[0], kappa[1], kappa[2]];
        let energies = |mixed: bool| {
            let of = |metric: &[f64; 3], s: &[f64; 6]| density(&stiffness(&one, &geometry::inverse(metric), mixed), s);
            [of(&METRIC, &STRAINS), of(&metric, &strains)]
        };
        let [[a, b], [c, d]] = [energies(true), energies(false)];
        assert!(a > 0.1 && (a - b).abs() < 1e-12 * a, "{a} {b}");
        assert!((c - d).abs() > 1e-3 * c, "{c} {d}");
    }

    #[test]
    fn energies_that_are_not_positive_are_refused() {
        // 11^2 is more than 4 eta xi = 113.6.
        let bad = Constants { phi: [0.5, 11.0, 0.4], ..CONSTANTS };
        let inverse = geometry::inverse(&METRIC);
        for mixed in [false, true] {
            assert!(is_positive(&stiffness(&CONSTANTS, &inverse, mixed)));
            assert!(!is_positive(&stiffness(&bad, &inverse, mixed)));
        }
        assert!(!is_positive(&stiffness(&Constants { phi: [f64::NAN; 3], ..CONSTANTS }, &inverse, false)));
    }
}

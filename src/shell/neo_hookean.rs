//! Compressible neo-Hookean sheet in plane stress, integrated through the thickness.
//!
//! `W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2` with the metric `g(z) = a - 2 z b` of the surfaces parallel to the middle and
//! `gbar(z) = abar - 2 z bbar` at rest. With `I = tr(gbar^-1 g)` and `D = det g / det gbar` the stretch of the thickness, `t = lambda3^2`, makes the
//! stress across the sheet vanish: `I1 = I + t`, `J^2 = D t`, `mu (t - 1) + lambda/2 ln(D t) = 0`; then `dW/dI = mu/2`, `dW/dD = -mu t / (2 D)`.
//! Three Gauss points through the thickness, each with the rest volume at its height, `h sqrt(det gbar(z))`: the outer side of a curved
//! shell holds more material than the inner one, to first order in `z` as in `gbar` itself. Incompressible rubber is not here.

use super::element::Strain;
use super::material::{Material, Response};
use super::rest::Forms;
use crate::math::quadrature::GAUSS;

/// `d - ln(1 + d)` without loss of digits for small `d`.
fn logarithm_rest(d: f64) -> f64 {
    if d.abs() > 0.1 {
        return d - d.ln_1p();
    }
    // ln(1 + d) = 2 (u + u^3/3 + u^5/5 + ...) with u = d / (2 + d), and d - 2 u = d u.
    let u = d / (2.0 + d);
    let s = u * u;
    let series = (0..7).rev().fold(0.0, |sum, k| sum * s + 1.0 / f64::from(2 * k + 3));
    d * u - 2.0 * u * s * series
}

/// `exp(s) - 1 - s` without loss of digits for small `s`.
fn exponential_rest(s: f64) -> f64 {
    if s.abs() > 0.1 {
        return s.exp_m1() - s;
    }
    0.5 * s * s * (3..13).rev().fold(1.0, |sum, k| 1.0 + s / f64::from(k) * sum)
}

/// Logarithm `s` of `t`: the root of `mu (e^s - 1) + lambda/2 (ln D + s) = 0` that is a minimum of the energy. None where there is no minimum,
/// for `lambda < 0` under extreme compression.
fn thickness_stretch(mu: f64, lambda: f64, log_d: f64) -> Option<f64> {
    let value = |s: f64| mu * s.exp_m1() + 0.5 * lambda * (log_d + s);
    // The function of s is convex, and where it grows Newton's method descends to its root from anywhere right of it.
    // Far from it, it would do so by steps of one: without the slow second term of the sum the root is known.
    let mut s = if lambda * log_d < 0.0 { (-0.5 * lambda / mu * log_d).ln_1p() } else { 0.0 };
    if lambda < 0.0 {
        let lowest = (-0.5 * lambda / mu).ln();
        if !(value(lowest) < 0.0) {
            return None;
        }
    }
    for _ in 0..100 {
        let step = value(s) / (mu * s.exp() + 0.5 * lambda);
        s -= step;
        if step.abs() <= 4.0 * f64::EPSILON * s.abs().max(f64::MIN_POSITIVE) {
            break;
        }
    }
    s.is_finite().then_some(s)
}

/// Heights [m] of the Gauss points and their shares of the thickness.
fn heights(thickness: f64) -> [(f64, f64); 3] {
    GAUSS.map(|(at, share)| ((at - 0.5) * thickness, share))
}

/// Whether the surfaces parallel to the middle have an area at all Gauss points.
pub(super) fn has_volume(thickness: f64, forms: &Forms) -> bool {
    heights(thickness).into_iter().all(|(z, _)| {
        let g: [f64; 3] = std::array::from_fn(|i| forms.a[i] - 2.0 * z * forms.b[i]);
        Forms { a: g, b: [0.0; 3] }.is_admissible()
    })
}

/// Energy, stress and, with `TANGENT`, second derivatives at a point of weight `weight` in barycentric coordinates.
pub(super) fn respond<const TANGENT: bool>(material: &Material, rest: &Strain, weight: f64, forms: &Strain) -> Response {
    let [lambda, mu] = material.lame_of_a_body();
    let mut sum = Response { energy: 0.0, stress: [0.0; 6], tangent: [[0.0; 6]; 6] };
    let nothing = Response { energy: f64::INFINITY, stress: [f64::NAN; 6], tangent: [[f64::NAN; 6]; 6] };
    for (z, share) in heights(material.thickness) {
        let at = |forms: &Strain| -> [f64; 3] { std::array::from_fn(|i| forms[i] - 2.0 * z * forms[3 + i]) };
        let bar = at(rest);
        let change: [f64; 3] = at(&std::array::from_fn(|i| forms[i] - rest[i]));
        let det_bar = bar[0] * bar[2] - bar[1] * bar[1];
        let volume = weight * material.thickness * share * det_bar.sqrt();
        let inverse = [bar[2] / det_bar, -bar[1] / det_bar, bar[0] / det_bar];
        // X = gbar^-1 (g - gbar): I = 2 + tr X, D = 1 + tr X + det X.
        let trace = inverse[0] * change[0] + 2.0 * inverse[1] * change[1] + inverse[2] * change[2];
        let det_x = (change[0] * change[2] - change[1] * change[1]) / det_bar;
        let d = trace + det_x;
        // Two negative stretches would have a positive product.
        if !(d > -1.0 && trace > -2.0 && volume > 0.0) {
            return nothing;
        }
        let log_d = d.ln_1p();
        let Some(s) = thickness_stretch(mu, lambda, log_d) else { return nothing };
        let log_j = 0.5 * (log_d + s);
        // I1 - 3 - 2 ln J = (tr X - d) + (d - ln D) + (t - 1 - s), all of second order.
        sum.energy += volume * (0.5 * mu * (logarithm_rest(d) - det_x + exponential_rest(s)) + 0.5 * lambda * log_j * log_j);
        // mu/2 (gbar^-1 - t/D adj(g) / det gbar), by what differs from rest.
        let ratio = (s - log_d).exp();
        let adjugate = [change[2], -change[1], change[0]].map(|v| v / det_bar);
        let stress: [f64; 3] = std::array::from_fn(|i| {
            let twice = if i == 1 { 2.0 } else { 1.0 };
            0.5 * mu * twice * (-(s - log_d).exp_m1() * inverse[i] - ratio * adjugate[i])
        });
        for i in 0..3 {
            sum.stress[i] += volume * stress[i];
            sum.stress[3 + i] -= 2.0 * z * volume * stress[i];
        }
        if !TANGENT {
            continue;
        }
        let slope = [inverse[0] + adjugate[0], 2.0 * (inverse[1] + adjugate[1]), inverse[2] + adjugate[2]];
        let (first, t) = (-0.5 * mu * ratio, s.exp());
        let second = 0.5 * mu * ratio / (1.0 + d) * (1.0 + lambda / (2.0 * mu * t + lambda));
        for i in 0..3 {
            for j in 0..3 {
                let curved = [[0.0, 0.0, 1.0], [0.0, -2.0, 0.0], [1.0, 0.0, 0.0]][i][j] / det_bar;
                let c = volume * (second * slope[i] * slope[j] + first * curved);
                sum.tangent[i][j] += c;
                sum.tangent[i][3 + j] -= 2.0 * z * c;
                sum.tangent[3 + i][j] -= 2.0 * z * c;
                sum.tangent[3 + i][3 + j] += 4.0 * z * z * c;
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_rests_join_the_large_ones() {
        for sign in [1.0, -1.0] {
            let (below, above) = (sign * 0.1, sign * (0.1f64).next_up());
            assert!((logarithm_rest(below) / logarithm_rest(above) - 1.0).abs() < 1e-13);
            assert!((exponential_rest(below) / exponential_rest(above) - 1.0).abs() < 1e-13);
            let x = sign * 1e-9;
            assert!((logarithm_rest(x) / (0.5 * x * x) - 1.0).abs() < 1e-8);
            assert!((exponential_rest(x) / (0.5 * x * x) - 1.0).abs() < 1e-8);
        }
    }

    #[test]
    fn the_thickness_takes_the_stretch_without_stress_or_none() {
        for (mu, lambda) in [(1.0, 0.0), (1.0, 1.0), (0.3, 300.0), (1.0, -0.3), (1.0, -0.6)] {
            for log_d in [-700.0, -20.0, -1.0, -1e-9, 0.0, 1e-9, 1.0, 20.0, 700.0] {
                let Some(s) = thickness_stretch(mu, lambda, log_d) else {
                    assert!(lambda < 0.0 && log_d < -1.0, "{mu} {lambda} {log_d}");
                    continue;
                };
                let terms = [mu * s.exp_m1(), 0.5 * lambda * log_d, 0.5 * lambda * s];
                let scale = terms.iter().fold(0.0f64, |m, t| m.max(t.abs()));
                assert!(terms.iter().sum::<f64>().abs() <= 1e-14 * scale, "{mu} {lambda} {log_d}: {s}");
                assert!(mu * s.exp() + 0.5 * lambda > 0.0, "not a minimum");
            }
        }
    }
}

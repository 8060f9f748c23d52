//! Norms over a mesh and rates of convergence.

use nalgebra::Vector3;

/// Area that belongs to each vertex [m^2]: a third of that of its faces.
pub fn vertex_areas(vertices: &[Vector3<f64>], faces: &[[usize; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; vertices.len()];
    for &[a, b, c] in faces {
        let third = (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a])).norm() / 6.0;
        for v in [a, b, c] {
            areas[v] += third;
        }
    }
    areas
}

/// `sqrt(sum w v^2)`: the L2 norm where the weights are areas. Lists of equal length.
pub fn l2_norm(values: &[f64], weights: &[f64]) -> f64 {
    values.iter().zip(weights).map(|(v, w)| w * v * v).sum::<f64>().sqrt()
}

/// Weighted mean `sum w v / sum w`; NaN without weight. Lists of equal length.
pub fn mean(values: &[f64], weights: &[f64]) -> f64 {
    let (total, weight) = values.iter().zip(weights).fold((0.0, 0.0), |(t, s), (v, w)| (t + w * v, s + w));
    total / weight
}

/// Order `p` of an error `C h^p` from two pairs `(h, error)`. None where the numbers give none: an error of zero or not
/// finite, two equal `h`.
pub fn observed_order(coarse: (f64, f64), fine: (f64, f64)) -> Option<f64> {
    rate(&[coarse, fine])
}

/// Order `p` of an error `C h^p`: slope of the least-squares line through the logarithms of pairs `(h, error)`.
///
/// None with fewer than two different `h`, or where a number is not positive and finite.
pub fn rate(pairs: &[(f64, f64)]) -> Option<f64> {
    power_law(pairs).map(|law| law.exponent)
}

/// A power law `y = prefactor x^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Exponent [1].
    pub exponent: f64,
    /// Value at `x = 1`, in the unit of y.
    pub prefactor: f64,
    /// Largest factor, less one, by which a value lies above the law or the law above a value: 0.1 where all are within 10 % of it.
    pub misfit: f64,
}

/// The power law through pairs `(x, y)`, by least squares of the logarithms.
///
/// None with fewer than two different `x`, or where a number is not positive and finite.
pub fn power_law(pairs: &[(f64, f64)]) -> Option<PowerLaw> {
    if pairs.iter().any(|(h, e)| !(h.is_normal() && e.is_normal() && *h > 0.0 && *e > 0.0)) {
        return None;
    }
    let n = pairs.len() as f64;
    let (x_mean, y_mean) = pairs.iter().fold((0.0, 0.0), |(x, y), (h, e)| (x + h.ln() / n, y + e.ln() / n));
    let (xy, xx) = pairs.iter().fold((0.0, 0.0), |(xy, xx), (h, e)| {
        let x = h.ln() - x_mean;
        (xy + x * (e.ln() - y_mean), xx + x * x)
    });
    // Logarithms of equal `h` differ by rounding at most.
    let exponent = (xx > 1e-24).then(|| xy / xx)?;
    let intercept = y_mean - exponent * x_mean;
    let off = |(h, e): &(f64, f64)| (e.ln() - intercept - exponent * h.ln()).abs();
    let misfit = pairs.iter().map(off).fold(0.0, f64::max).exp_m1();
    Some(PowerLaw { exponent, prefactor: intercept.exp(), misfit })
}

/// Weighted median: the value below and above which at most half of the weight lies, the mean of two where that is so for two. NaN
/// without weight or with a value that is not a number. Lists of equal length, weights >= 0.
pub fn median(values: &[f64], weights: &[f64]) -> f64 {
    let mut pairs: Vec<(f64, f64)> = values.iter().copied().zip(weights.iter().copied()).filter(|(_, w)| *w > 0.0).collect();
    if pairs.iter().any(|(v, w)| v.is_nan() || !w.is_finite()) {
        return f64::NAN;
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = pairs.iter().map(|(_, w)| w).sum();
    // Sums of equal weights reach the half up to rounding only.
    let half = 0.5 * total;
    let mut below = 0.0;
    for (i, (value, weight)) in pairs.iter().enumerate() {
        below += weight;
        if (below - half).abs() <= 1e-12 * total {
            return 0.5 * (value + pairs.get(i + 1).map_or(*value, |next| next.0));
        }
        if below > half {
            return *value;
        }
    }
    f64::NAN
}

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
    (xx > 1e-24).then(|| xy / xx)
}

//! Points on the unit circle and the conformal maps of the disc onto itself.

use nalgebra::Complex;
use std::f64::consts::TAU;

/// Longest step of the search for the centre, in the disc of radius 1.
const LONGEST: f64 = 0.9;
/// Steps of the search, which converges quadratically once near; the hardest of thousands of trials took 15.
const STEPS: usize = 200;
/// Share of the fall by the slope that a step of the search must bring.
const SHARE: f64 = 0.1;

/// Points in turn on the unit circle with arcs in proportion to `lengths`, all positive; the first lies at angle 0.
pub fn points(lengths: &[f64]) -> Vec<Complex<f64>> {
    let total: f64 = lengths.iter().sum();
    let mut sum = 0.0;
    let angle = lengths.iter().map(|length| {
        sum += length;
        TAU * (sum - length) / total
    });
    angle.map(|angle| Complex::from_polar(1.0, angle)).collect()
}

/// Arcs [rad] from each point to the next, counter-clockwise.
pub fn arcs(points: &[Complex<f64>]) -> Vec<f64> {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| (b * a.conj()).arg()).map(|arc| if arc < -1e-9 { arc + TAU } else { arc }).collect()
}

/// Moves points of the unit circle by the conformal map of the disc onto itself that brings their weighted mean to the centre. The map
/// exists, and is the only one up to rotations, if no point has half of the weight or more (Douady and Earle, Acta Mathematica 157, 1986).
///
/// The point that is to become the centre minimises [`height`], which has no other minimum; Newton's steps alone may go round in circles.
///
/// Error: how far from the centre the mean stays, on a circle of radius 1.
pub fn centre(points: &mut [Complex<f64>], weights: &[f64]) -> Result<(), f64> {
    let total: f64 = weights.iter().sum();
    // Round-off of a mean of so many points.
    let least = f64::EPSILON * (4 + points.len()) as f64 * weights.iter().map(|w| w.abs()).sum::<f64>() / total;
    let (mut off, mut is_near) = (f64::INFINITY, false);
    for _ in 0..STEPS {
        let mean = |power: i32| points.iter().zip(weights).map(|(z, w)| z.powi(power) * *w).sum::<Complex<f64>>() / total;
        let (first, second) = (mean(1), mean(2));
        off = first.norm();
        if !off.is_finite() {
            break;
        }
        if is_near {
            return Ok(());
        }
        // One more step then leaves nothing but round-off, which points close together see enlarged.
        is_near = off <= least;
        // Newton's step: the map z -> (z - a) / (1 - conj(a) z) changes the mean by -a + conj(a) second to first order.
        let mut a = (first + first.conj() * second) / (1.0 - second.norm_sqr()).max(1e-3);
        if a.norm() > LONGEST {
            a *= LONGEST / a.norm();
        }
        while !(height(points, weights, a) <= -SHARE * 2.0 * (a * first.conj()).re + 4.0 * f64::EPSILON) {
            a *= 0.5;
        }
        for z in points.iter_mut() {
            let moved = (*z - a) / (1.0 - a.conj() * *z);
            *z = moved / moved.norm();
        }
    }
    Err(off)
}

/// Weighted mean of the heights of horospheres through a point of the disc about the points of the circle; 0 at the centre, where its slope
/// is `-2` times the mean of the points. Convex along the lines of the hyperbolic plane if no weight is negative.
fn height(points: &[Complex<f64>], weights: &[f64], at: Complex<f64>) -> f64 {
    let scale = (1.0 - at.norm_sqr()).ln();
    let sum: f64 = points.iter().zip(weights).map(|(z, w)| w * ((z - at).norm_sqr().ln() - scale)).sum();
    sum / weights.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(points: &[Complex<f64>], weights: &[f64]) -> f64 {
        let sum: Complex<f64> = points.iter().zip(weights).map(|(z, w)| z * *w).sum();
        sum.norm() / weights.iter().sum::<f64>()
    }

    /// Newton's steps of full length go round in circles at the first three.
    #[test]
    fn brings_the_mean_to_the_centre() {
        for (angles, weights) in [
            ([2.8, 3.1, 4.1, 5.0], [3.0, 2.0, 5.0, 2.0]),
            ([0.3, 0.4, 4.8, 4.9], [4.0, 4.0, 7.0, 9.0]),
            ([0.3, 0.9, 3.4, 6.0], [1.0, 8.0, 2.0, 7.0]),
            ([1.0, 1.0 + 1e-6, 1.0 + 2e-6, 4.0], [1.0, 1.0, 1.0, 1.0]),
            ([0.0, 1.0, 2.0, 3.0], [4.999, 2.0, 2.0, 1.001]),
        ] {
            let start = angles.map(|angle| Complex::from_polar(1.0, angle));
            let mut points = start;
            assert_eq!(centre(&mut points, &weights), Ok(()), "{angles:?}");
            assert!(mean(&start, &weights) > 0.1 && mean(&points, &weights) < 2e-15, "{angles:?}");
            // Conformal maps keep cross ratios, and the order on the circle.
            let ratio = |p: &[Complex<f64>; 4]| (p[0] - p[2]) * (p[1] - p[3]) / ((p[0] - p[3]) * (p[1] - p[2]));
            assert!((ratio(&points) / ratio(&start) - 1.0).norm() < 1e-8, "{angles:?}");
        }
    }

    #[test]
    fn tells_where_a_point_has_half_of_the_weight() {
        for heavy in [3.0, 3.1, 10.0] {
            let mut points = [0.0, 1.0, 2.0, 4.0].map(|angle| Complex::from_polar(1.0, angle));
            let weights = [heavy, 1.0, 1.0, 1.0];
            let off = centre(&mut points, &weights);
            // No further than the circle lets the others go to the other side.
            assert!(off.is_err_and(|off| off > 0.9 * (heavy - 3.0) / (heavy + 3.0) && off > 1e-9), "{heavy}: {off:?}");
        }
    }
}

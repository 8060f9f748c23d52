//! Points on the unit circle and the conformal maps of the disc onto itself.

use nalgebra::Complex;
use std::f64::consts::TAU;

/// Longest step of the search for the centre, in the disc of radius 1.
const LONGEST: f64 = 0.9;
/// Steps of the search, which converges quadratically once near.
const STEPS: usize = 200;

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
pub fn centre(points: &mut [Complex<f64>], weights: &[f64]) {
    let total: f64 = weights.iter().sum();
    for _ in 0..STEPS {
        let mean = |power: i32| points.iter().zip(weights).map(|(z, w)| z.powi(power) * *w).sum::<Complex<f64>>() / total;
        let (first, second) = (mean(1), mean(2));
        if first.norm() < 1e-15 {
            return;
        }
        // Newton's step: the map z -> (z - a) / (1 - conj(a) z) changes the mean by -a + conj(a) second to first order.
        let mut a = (first + first.conj() * second) / (1.0 - second.norm_sqr()).max(1e-3);
        if a.norm() > LONGEST {
            a *= LONGEST / a.norm();
        }
        for z in points.iter_mut() {
            let moved = (*z - a) / (1.0 - a.conj() * *z);
            *z = moved / moved.norm();
        }
    }
}

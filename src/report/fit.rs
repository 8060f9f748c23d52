//! Distance from a rolled-up plane.

use crate::math::rigid_fit;
use nalgebra::Vector3;

/// Largest distance of a vertex from its place on the cylinder into which the xy plane rolls along x, after the best rigid
/// fit, over the initial extent along x [1].
///
/// `initial`: points of the xy plane [m]; `now`: where they are [m]; `radius` [m] > 0. The place is
/// `(R sin(s/R), y, +-R (1 - cos(s/R)))`, `s` from the middle of the extent along x; the better sign counts. NaN if a point is
/// not finite or the extent is 0.
pub fn cylinder_distance(initial: &[Vector3<f64>], now: &[Vector3<f64>], radius: f64) -> f64 {
    let (low, high) = initial.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.x), h.max(p.x)));
    let (middle, extent) = (0.5 * (low + high), high - low);
    let finite = initial.iter().chain(now).all(|p| p.iter().all(|x| x.is_finite()));
    if !finite || extent.is_nan() || extent <= 0.0 || now.len() != initial.len() {
        return f64::NAN;
    }
    let distance = |sign: f64| {
        let roll = |p: &Vector3<f64>| {
            let angle = (p.x - middle) / radius;
            // 1 - cos without its cancellation at small angles.
            Vector3::new(radius * angle.sin(), p.y, sign * 2.0 * radius * (0.5 * angle).sin().powi(2))
        };
        let target: Vec<_> = initial.iter().map(roll).collect();
        let (rotation, translation) = rigid_fit(&target, now);
        let distances = target.iter().zip(now).map(|(t, p)| (rotation * t + translation - p).norm());
        distances.fold(0.0, f64::max) / extent
    };
    distance(1.0).min(distance(-1.0))
}

//! Best rigid motion between two sets of points, and the distance from a rolled-up plane.

use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

/// The proper rotation `R` and translation `t` with the least `sum |R from_i + t - to_i|^2` (Kabsch; Horn 1987).
///
/// `from`, `to`: corresponding points [m]; surplus points of the longer list are ignored. The rotation is the eigenvector of
/// a 4x4 matrix, a quaternion, and so never a reflection, also for flat and straight sets, where any best one is given.
/// Points that are not finite give a translation that is not.
pub fn rigid_fit(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> (Rotation3<f64>, Vector3<f64>) {
    let n = from.len().min(to.len());
    let (from, to) = (&from[..n], &to[..n]);
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / n.max(1) as f64;
    let (from_mean, to_mean) = (mean(from), mean(to));
    let mut s = Matrix3::zeros();
    for (a, b) in from.iter().zip(to) {
        s += (a - from_mean) * (b - to_mean).transpose();
    }
    let size = s.amax();
    if !size.is_finite() || s.iter().any(|x| x.is_nan()) {
        // The eigenvalue iteration would not end.
        return (Rotation3::identity(), Vector3::repeat(f64::NAN));
    }
    if size == 0.0 {
        return (Rotation3::identity(), to_mean - from_mean);
    }
    s /= size;
    let skew = Vector3::new(s[(1, 2)] - s[(2, 1)], s[(2, 0)] - s[(0, 2)], s[(0, 1)] - s[(1, 0)]);
    let mut horn = Matrix4::zeros();
    horn[(0, 0)] = s.trace();
    horn.fixed_view_mut::<3, 1>(1, 0).copy_from(&skew);
    horn.fixed_view_mut::<1, 3>(0, 1).copy_from(&skew.transpose());
    horn.fixed_view_mut::<3, 3>(1, 1).copy_from(&(s + s.transpose() - Matrix3::identity() * s.trace()));
    let eigen = SymmetricEigen::new(horn);
    let q = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3])).to_rotation_matrix();
    (rotation, to_mean - rotation * from_mean)
}

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

//! Best rigid motion between two sets of points. Neither scaling nor reflection.

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

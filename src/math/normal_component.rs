//! The part `n . s` of a vector `s` along the normal `n` of the plane of two tangent vectors `r1`, `r2`, with first and second derivatives.
//!
//! With the dual basis `r^a`, `dn = -(n.dr_a) r^a`. So, with `z = (r^a.s) dr_a - ds` and summing over `a` and `b`:
//!
//! ```text
//! d(n.s)  = -n.z
//! d2(n.s) = 2 (n.dr_a) (r^a.z) - (n.s) (r^a.r^b) (n.dr_a) (n.dr_b)
//! ```
//!
//! All of it keeps its shape for nodes `x_p` on which `r_a = B_ap x_p` and `s = S_p x_p` depend linearly: node `p` enters by its share
//! `(r^a.s) B_ap - S_p` of `z` and by its surface gradient `B_ap r^a`. This module knows neither faces nor nodes.

use nalgebra::{Matrix3, Vector3};

/// Normal and dual basis of two tangent vectors.
#[derive(Clone, Copy, Debug)]
pub struct TangentPlane {
    /// Unit normal, along `r1 x r2`.
    pub normal: Vector3<f64>,
    /// Dual basis `r^1`, `r^2` [1/m].
    pub dual: [Vector3<f64>; 2],
}

impl TangentPlane {
    /// `r1`, `r2`: independent tangent vectors [m].
    #[inline(always)]
    pub fn new(r1: &Vector3<f64>, r2: &Vector3<f64>) -> Self {
        let cross = r1.cross(r2);
        let area = cross.norm();
        let normal = cross / area;
        TangentPlane { normal, dual: [r2.cross(&normal) / area, normal.cross(r1) / area] }
    }

    /// `r^a . s`: what `z` takes of each tangent vector's change.
    #[inline(always)]
    pub fn components(&self, s: &Vector3<f64>) -> [f64; 2] {
        [self.dual[0].dot(s), self.dual[1].dot(s)]
    }

    /// Surface gradient of a node of which `r1` and `r2` have the multiples `b`.
    #[inline(always)]
    pub fn surface_gradient(&self, b: [f64; 2]) -> Vector3<f64> {
        self.dual[0] * b[0] + self.dual[1] * b[1]
    }

    /// Second derivative of `n.s` in nodes `p` (rows) and `q` (columns). `value`: `n.s`; `share` and `gradient`: those of the two nodes.
    #[inline(always)]
    pub fn hessian(&self, value: f64, share: [f64; 2], gradient: [&Vector3<f64>; 2]) -> Matrix3<f64> {
        let n = &self.normal;
        let half = n * (0.5 * value * gradient[0].dot(gradient[1]));
        n * (gradient[0] * share[1] - half).transpose() + (gradient[1] * share[0] - half) * n.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vectors(u: &[f64; 9]) -> [Vector3<f64>; 3] {
        [0, 1, 2].map(|k| Vector3::new(u[3 * k], u[3 * k + 1], u[3 * k + 2]))
    }

    fn value(u: &[f64; 9]) -> f64 {
        let [r1, r2, s] = vectors(u);
        TangentPlane::new(&r1, &r2).normal.dot(&s)
    }

    /// `r1`, `r2` and `s` themselves are the nodes.
    fn shares(plane: &TangentPlane, s: &Vector3<f64>) -> [f64; 3] {
        let [p, q] = plane.components(s);
        [p, q, -1.0]
    }

    fn gradient(u: &[f64; 9]) -> [f64; 9] {
        let [r1, r2, s] = vectors(u);
        let plane = TangentPlane::new(&r1, &r2);
        let shares = shares(&plane, &s);
        std::array::from_fn(|i| -shares[i / 3] * plane.normal[i % 3])
    }

    #[test]
    fn derivatives_are_those_of_the_value() {
        let u = [1.1, 0.2, -0.3, 0.4, 0.9, 0.5, 0.3, -0.8, 0.6];
        let [r1, r2, s] = vectors(&u);
        let plane = TangentPlane::new(&r1, &r2);
        let (g, shares) = (gradient(&u), shares(&plane, &s));
        let gradients = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]].map(|b| plane.surface_gradient(b));
        assert!(g.iter().all(|g| g.abs() > 1e-3));
        let step = 1e-5;
        for i in 0..9 {
            let at = |d: f64| {
                let mut shifted = u;
                shifted[i] += d;
                shifted
            };
            assert!(((value(&at(step)) - value(&at(-step))) / (2.0 * step) - g[i]).abs() < 1e-9);
            let (g1, g2) = (gradient(&at(step)), gradient(&at(-step)));
            for j in 0..9 {
                let (p, q) = (i / 3, j / 3);
                let exact = plane.hessian(value(&u), [shares[p], shares[q]], [&gradients[p], &gradients[q]])[(i % 3, j % 3)];
                assert!(((g1[j] - g2[j]) / (2.0 * step) - exact).abs() < 1e-9, "{i} {j}");
                assert!(p == 2 && q == 2 || exact.abs() > 1e-4);
            }
        }
    }
}

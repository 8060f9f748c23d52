//! The angle between a surface's normal and the director of one of its edges, with first and second derivatives.
//!
//! ```text
//!            director
//!         n     /             t: along the edge, the face on its left
//!         |    / alpha        o = t x n: outward
//!         |   /               n: normal of the face at the edge
//!         |  /                alpha: from n to the director, turning about t, so positive outward
//!   ------+------> o
//!    face   (t points at the reader)
//! ```
//!
//! Everything is a function of two vectors in the tangent plane: the edge's tangent `T` and a vector `D` that reaches outward.
//! Derivatives are formed in the frame (t, o, n) and in the variables `T` and `E = D - k T`, `k = D.t / |T|`, in which most of them
//! vanish. This module knows neither faces nor unknowns.

use nalgebra::{Matrix3, Vector3};

/// Function of the angle that enters the second fundamental form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// `sin(alpha)`.
    Sin,
    /// `tan(alpha)`: grows without bound as the hinge folds flat.
    Tan,
    /// `alpha` itself.
    Angle,
}

impl Measure {
    /// Value, first and second derivative at `alpha` [rad]. `tan` continues with a steep line of its own beyond 89.9 degrees, so that an
    /// iterate beyond a right angle has a high energy instead of the one of the opposite branch.
    #[inline(always)]
    pub fn derivatives(self, alpha: f64) -> [f64; 3] {
        match self {
            Measure::Sin => {
                let (s, c) = alpha.sin_cos();
                [s, c, -s]
            }
            Measure::Tan => {
                const LIMIT: f64 = std::f64::consts::FRAC_PI_2 - 1.8e-3;
                let inside = alpha.clamp(-LIMIT, LIMIT);
                let t = inside.tan();
                let slope = 1.0 + t * t;
                if inside == alpha { [t, slope, 2.0 * t * slope] } else { [t + slope * (alpha - inside), slope, 0.0] }
            }
            Measure::Angle => [alpha, 1.0, 0.0],
        }
    }
}

/// Geometry of one hinge.
#[derive(Clone, Copy, Debug)]
pub struct Hinge {
    /// Unit tangent of the edge, outward unit vector and normal, as columns.
    pub frame: Matrix3<f64>,
    /// Length of `T` [m].
    pub length: f64,
    /// Height: part of `D` orthogonal to the edge [m].
    pub height: f64,
    /// `D.t / |T|`.
    pub skew: f64,
    /// Angle from the normal to the projection of the reference `p` [rad].
    pub angle: f64,
    /// Components of `p` along t, o, n.
    p: [f64; 3],
}

/// `f = S(alpha) H` and its derivatives in the variables `E`, `T` (each by components t, o, n) and `phi`.
#[derive(Clone, Copy, Debug)]
pub struct HingeCurvature {
    /// Value [m].
    pub value: f64,
    /// Derivative in `E`: components o and n (that along t vanishes).
    pub e: [f64; 2],
    /// Derivative in `T`: components o and n.
    pub t: [f64; 2],
    /// Derivative in `phi` [m].
    pub phi: f64,
    /// Angle measure: S, S', S''.
    measure: [f64; 3],
}

impl Hinge {
    /// `tangent`: the edge's tangent `T` [m]; `outward`: `D` [m], on the outer side of the edge; `normal`: unit normal, orthogonal to both;
    /// `reference`: the unit vector `p` that angles are measured to, not along the edge.
    #[inline(always)]
    pub fn new(tangent: &Vector3<f64>, outward: &Vector3<f64>, normal: &Vector3<f64>, reference: &Vector3<f64>) -> Self {
        let length = tangent.norm();
        let t = tangent / length;
        let o = t.cross(normal);
        let p = [reference.dot(&t), reference.dot(&o), reference.dot(normal)];
        Hinge {
            frame: Matrix3::from_columns(&[t, o, *normal]),
            length,
            height: outward.dot(&o),
            skew: outward.dot(&t) / length,
            angle: p[1].atan2(p[2]),
            p,
        }
    }

    /// `q = p_t / (1 - p_t^2)` and its derivative in `p_t`: how turning the edge within its plane changes the angle.
    #[inline(always)]
    fn twist(&self) -> (f64, f64) {
        let p2 = self.p[0] * self.p[0];
        (self.p[0] / (1.0 - p2), (1.0 + p2) / ((1.0 - p2) * (1.0 - p2)))
    }

    /// Gradient of the angle: components n of `E`, then o and n of `T` [1/m]; all others vanish.
    #[inline(always)]
    pub fn angle_gradient(&self) -> [f64; 3] {
        let ([_, s, c], (q, _)) = (self.p, self.twist());
        [1.0 / self.height, -q * c / self.length, q * s / self.length]
    }

    /// Second derivatives of the angle [1/m2], of which the symmetric ones off the diagonal are given once:
    /// (E_t, T_n), (E_o, E_n), (T_o, T_n), (T_o, T_o) = -(T_n, T_n), (T_t, T_o), (T_t, T_n).
    #[inline(always)]
    pub fn angle_hessian(&self) -> [f64; 6] {
        let ([p, s, c], (q, dq)) = (self.p, self.twist());
        let (l, h) = (self.length, self.height);
        let l2 = l * l;
        [-1.0 / (l * h), -1.0 / (h * h), (q * p - dq * c * c) / l2, -dq * c * s / l2, q * c / l2, -q * s / l2]
    }

    /// `f = S(alpha) H` with `alpha = angle + sign phi`, and its gradient. `sign`: +1 or -1.
    #[inline(always)]
    pub fn curvature(&self, measure: Measure, sign: f64, phi: f64) -> HingeCurvature {
        let m = measure.derivatives(self.angle + sign * phi);
        let [a_en, a_to, a_tn] = self.angle_gradient();
        let sh = m[1] * self.height;
        HingeCurvature { value: m[0] * self.height, e: [m[0], sh * a_en], t: [sh * a_to, sh * a_tn], phi: sh * sign, measure: m }
    }

    /// Hessian of `weight * f`: blocks (E, E), (E, T), (T, T) by components t, o, n, then rows (phi, E), (phi, T) and (phi, phi).
    #[inline(always)]
    pub fn hessian(&self, f: &HingeCurvature, sign: f64, weight: f64) -> HingeHessian {
        let [s0, s1, s2] = f.measure.map(|s| s * weight);
        let (l, h) = (self.length, self.height);
        let [_, a_to, a_tn] = self.angle_gradient();
        let [_, _, aa_ton, aa_too, aa_tto, aa_ttn] = self.angle_hessian();
        // (E_o, E_n): S' / H from the product of gradients and -S' / H from the angle's own Hessian cancel.
        let ee_nn = (s2 + s0) / h;
        let et = Matrix3::new(0.0, -s0 / l, -s1 / l, 0.0, s1 * a_to, s1 * a_tn, 0.0, s2 * a_to, s2 * a_tn);
        let (b, c) = (s1 * h, s2 * h);
        let (tto, ttn) = (b * aa_tto, b * aa_ttn);
        let too = c * a_to * a_to + b * aa_too - s0 * h / (l * l);
        let ton = c * a_to * a_tn + b * aa_ton;
        let tnn = c * a_tn * a_tn - b * aa_too;
        let tt = Matrix3::new(0.0, tto, ttn, tto, too, ton, ttn, ton, tnn);
        HingeHessian { ee_nn, et, tt, phi_e: [s1 * sign, s2 * sign], phi_t: [c * a_to * sign, c * a_tn * sign], phi_phi: c }
    }
}

/// Second derivatives of a weighted hinge curvature in the frame (t, o, n).
#[derive(Clone, Copy, Debug)]
pub struct HingeHessian {
    /// The one entry of (E, E): (n, n).
    pub ee_nn: f64,
    /// (E, T).
    pub et: Matrix3<f64>,
    /// (T, T).
    pub tt: Matrix3<f64>,
    /// (phi, E): components o and n.
    pub phi_e: [f64; 2],
    /// (phi, T): components o and n.
    pub phi_t: [f64; 2],
    /// (phi, phi).
    pub phi_phi: f64,
}

//! Values with first and second derivatives in up to three variables, carried along by the chain rule.
//!
//! What an expression's functions are and how they are differentiated is said by [`super::expression`]; this is only the arithmetic.

use nalgebra::{Matrix3, Vector3};

/// A value, its gradient and its Hessian in three variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: Vector3<f64>,
    /// Second derivatives, symmetric.
    pub hessian: Matrix3<f64>,
}

impl Jet {
    /// A number that depends on nothing.
    pub fn constant(value: f64) -> Self {
        Jet { value, gradient: Vector3::zeros(), hessian: Matrix3::zeros() }
    }

    /// Variable number `index`, 0 to 2.
    pub fn variable(value: f64, index: usize) -> Self {
        Jet { gradient: Vector3::ith(index, 1.0), ..Self::constant(value) }
    }

    /// `f(self)`, `f` having this value and these first and second derivatives there.
    pub fn unary(&self, value: f64, [d, dd]: [f64; 2]) -> Self {
        let g = self.gradient;
        Jet { value, gradient: g * d, hessian: self.hessian * d + outer(&g, &g) * dd }
    }

    /// `f(self, other)`, `f` having this value, first derivatives and second derivatives (11, 12, 22) there.
    pub fn binary(&self, other: &Jet, value: f64, [a, b]: [f64; 2], [aa, ab, bb]: [f64; 3]) -> Self {
        let (p, q) = (self.gradient, other.gradient);
        let mixed = outer(&p, &q);
        // A derivative that is not needed may be infinite, as that of a power in its exponent.
        let scaled = |m: Matrix3<f64>, s: f64| if m == Matrix3::zeros() { m } else { m * s };
        let along = |v: Vector3<f64>, s: f64| if v == Vector3::zeros() { v } else { v * s };
        Jet {
            value,
            gradient: along(p, a) + along(q, b),
            hessian: scaled(self.hessian, a)
                + scaled(other.hessian, b)
                + scaled(outer(&p, &p), aa)
                + scaled(mixed + mixed.transpose(), ab)
                + scaled(outer(&q, &q), bb),
        }
    }
}

fn outer(p: &Vector3<f64>, q: &Vector3<f64>) -> Matrix3<f64> {
    p * q.transpose()
}

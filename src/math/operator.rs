//! The functions and operators of expressions, with their first and second derivatives.
//!
//! Which text means which, and how tightly it binds, is here; how a text is read is the parser's business in [`super::expression`].

/// A function of one value, and its first and second derivative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unary {
    pub value: fn(f64) -> f64,
    pub derivatives: fn(f64) -> [f64; 2],
}

/// A function of two values; its first derivatives in both; its second derivatives 11, 12, 22.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binary {
    pub value: fn(f64, f64) -> f64,
    pub derivatives: fn(f64, f64) -> ([f64; 2], [f64; 3]),
}

/// One step of a postfix program.
#[derive(Clone, Copy, Debug)]
pub(super) enum Op {
    Number(f64),
    Variable(usize),
    Unary(Unary),
    Binary(Binary),
    /// `if(c, a, b)`. Both branches are evaluated; the value of the other one has no influence, NaN or not.
    Select,
}

impl Op {
    /// Values taken from the stack; each step puts one back.
    pub fn arity(self) -> usize {
        match self {
            Op::Number(_) | Op::Variable(_) => 0,
            Op::Unary(_) => 1,
            Op::Binary(_) => 2,
            Op::Select => 3,
        }
    }
}

const fn one(value: fn(f64) -> f64, derivatives: fn(f64) -> [f64; 2]) -> Op {
    Op::Unary(Unary { value, derivatives })
}

const fn two(value: fn(f64, f64) -> f64, derivatives: fn(f64, f64) -> ([f64; 2], [f64; 3])) -> Op {
    Op::Binary(Binary { value, derivatives })
}

/// A function that is constant between its jumps.
const fn stepwise(value: fn(f64) -> f64) -> Op {
    one(value, |_| [0.0; 2])
}

const fn comparison(value: fn(f64, f64) -> f64) -> Op {
    two(value, |_, _| FLAT)
}

const FLAT: ([f64; 2], [f64; 3]) = ([0.0; 2], [0.0; 3]);

/// First and second derivative of `sign erf(a)`.
fn bell(a: f64, sign: f64) -> [f64; 2] {
    let slope = sign * std::f64::consts::FRAC_2_SQRT_PI * (-a * a).exp();
    [slope, -2.0 * a * slope]
}

/// `-a`.
pub(super) const NEGATE: Op = one(|a| -a, |_| [-1.0, 0.0]);

/// `a^b`. The derivatives in the exponent exist for positive `a` only.
pub(super) const POWER: Op = two(f64::powf, |a, b| {
    let (power, ln) = (a.powf(b), a.ln());
    let less = |n: f64, c: f64| if c == 0.0 { 0.0 } else { c * a.powf(b - n) };
    ([less(1.0, b), power * ln], [less(2.0, b * (b - 1.0)), a.powf(b - 1.0) * (1.0 + b * ln), power * ln * ln])
});

pub(super) const FUNCTIONS: [(&str, Op); 23] = [
    ("sin", one(f64::sin, |a| [a.cos(), -a.sin()])),
    ("cos", one(f64::cos, |a| [-a.sin(), -a.cos()])),
    ("erf", one(libm::erf, |a| bell(a, 1.0))),
    ("erfc", one(libm::erfc, |a| bell(a, -1.0))),
    (
        "tan",
        one(f64::tan, |a| {
            let s = 1.0 + a.tan() * a.tan();
            [s, 2.0 * a.tan() * s]
        }),
    ),
    (
        "asin",
        one(f64::asin, |a| {
            let d = 1.0 / (1.0 - a * a).sqrt();
            [d, a * d * d * d]
        }),
    ),
    (
        "acos",
        one(f64::acos, |a| {
            let d = 1.0 / (1.0 - a * a).sqrt();
            [-d, -a * d * d * d]
        }),
    ),
    (
        "atan",
        one(f64::atan, |a| {
            let d = 1.0 / (1.0 + a * a);
            [d, -2.0 * a * d * d]
        }),
    ),
    (
        "atan2",
        two(f64::atan2, |y, x| {
            let s = x * x + y * y;
            ([x / s, -y / s], [-2.0 * x * y / (s * s), (y * y - x * x) / (s * s), 2.0 * x * y / (s * s)])
        }),
    ),
    ("sinh", one(f64::sinh, |a| [a.cosh(), a.sinh()])),
    ("cosh", one(f64::cosh, |a| [a.sinh(), a.cosh()])),
    (
        "tanh",
        one(f64::tanh, |a| {
            let s = 1.0 - a.tanh() * a.tanh();
            [s, -2.0 * a.tanh() * s]
        }),
    ),
    ("exp", one(f64::exp, |a| [a.exp(), a.exp()])),
    ("ln", one(f64::ln, |a| [1.0 / a, -1.0 / (a * a)])),
    (
        "log10",
        one(f64::log10, |a| {
            let d = std::f64::consts::LOG10_E / a;
            [d, -d / a]
        }),
    ),
    (
        "sqrt",
        one(f64::sqrt, |a| {
            let d = 0.5 / a.sqrt();
            [d, -0.5 * d / a]
        }),
    ),
    ("abs", one(f64::abs, |a| [sign(a), 0.0])),
    ("sign", stepwise(sign)),
    ("floor", stepwise(f64::floor)),
    ("ceil", stepwise(f64::ceil)),
    ("round", stepwise(f64::round)),
    ("min", two(min, |a, b| (if a < b { [1.0, 0.0] } else { [0.0, 1.0] }, [0.0; 3]))),
    ("max", two(max, |a, b| (if a > b { [1.0, 0.0] } else { [0.0, 1.0] }, [0.0; 3]))),
];

/// Binary operators: text, weight, meaning. A text that is the beginning of another comes after it.
pub(super) const OPERATORS: [(&str, u8, Op); 12] = [
    ("||", 1, comparison(|a, b| truth(a != 0.0 || b != 0.0))),
    ("&&", 2, comparison(|a, b| truth(a != 0.0 && b != 0.0))),
    ("<=", COMPARISON, comparison(|a, b| truth(a <= b))),
    (">=", COMPARISON, comparison(|a, b| truth(a >= b))),
    ("==", COMPARISON, comparison(|a, b| truth(a == b))),
    ("!=", COMPARISON, comparison(|a, b| truth(a != b))),
    ("<", COMPARISON, comparison(|a, b| truth(a < b))),
    (">", COMPARISON, comparison(|a, b| truth(a > b))),
    ("+", 4, two(|a, b| a + b, |_, _| ([1.0, 1.0], [0.0; 3]))),
    ("-", 4, two(|a, b| a - b, |_, _| ([1.0, -1.0], [0.0; 3]))),
    ("*", 5, two(|a, b| a * b, |a, b| ([b, a], [0.0, 1.0, 0.0]))),
    ("/", 5, two(|a, b| a / b, |a, b| ([1.0 / b, -a / (b * b)], [0.0, -1.0 / (b * b), 2.0 * a / (b * b * b)]))),
];

/// Weight of comparisons.
pub(super) const COMPARISON: u8 = 3;

fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

/// -1, 0 or 1; unlike `f64::signum`, 0 at 0.
fn sign(a: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a.signum() }
}

/// Unlike `f64::min`, NaN if either is NaN, so that a fault is not hidden.
fn min(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// Unlike `f64::max`, NaN if either is NaN.
fn max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

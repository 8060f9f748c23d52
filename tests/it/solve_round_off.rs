//! Newton's method and the way off unstable equilibria where round-off hides a mode's stiffness, on energies that are written down.

use nalgebra::{DMatrix, DVector, Vector2};
use std::f64::consts::TAU;
use thinshell::solve::{Failure, Newton, Settings, Stability};
use thinshell::sparse::{Curvature, Numbering, Pattern, Potential, System};

/// An energy of all unknowns at once, by its value, gradient and Hessian.
struct Formula<F> {
    unknowns: usize,
    terms: F,
    pattern: Option<Pattern>,
}

impl<F: Fn(&[f64]) -> (f64, DVector<f64>, DMatrix<f64>)> Formula<F> {
    fn new(unknowns: usize, terms: F) -> Self {
        Formula { unknowns, terms, pattern: None }
    }
}

impl<F: Fn(&[f64]) -> (f64, DVector<f64>, DMatrix<f64>)> Potential for Formula<F> {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        visit(&(0..self.unknowns).collect::<Vec<_>>());
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        assert_eq!(numbering.free(), self.unknowns);
        self.pattern = Some(pattern.clone());
    }

    fn energy(&self, x: &[f64]) -> f64 {
        (self.terms)(x).0
    }

    fn assemble(&mut self, x: &[f64], _: Curvature, into: &mut System) -> f64 {
        let (energy, gradient, hessian) = (self.terms)(x);
        let pattern = self.pattern.as_ref().unwrap();
        for j in 0..pattern.len() {
            for slot in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
                into.matrix[slot] += hessian[(pattern.row[slot] as usize, j)];
            }
        }
        into.gradient.iter_mut().zip(gradient.iter()).for_each(|(to, g)| *to += g);
        energy
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let (energy, gradient, _) = (self.terms)(x);
        into.gradient.iter_mut().zip(gradient.iter()).for_each(|(to, g)| *to += g);
        energy
    }

    /// No mechanism.
    fn stiffness_along(&self, _: &[f64], y: &[f64]) -> f64 {
        y.iter().map(|y| y * y).sum::<f64>() * 1e6
    }
}

/// Where the energy `x.K x / 2 - s^4 / 4 + s^6 / 15`, `s = u.x`, is led from `x = 0`: `u` is a vector of `K` with the eigenvalue `lowest`, the
/// others are 1 to 1e6. If `lowest` is about zero, the minima are at `s^2 = 5/2`.
fn leave_well(n: usize, lowest: f64) -> Result<(Stability, f64), thinshell::solve::Failure> {
    let basis = DMatrix::from_fn(n, n, |i, j| (0.618_034 * (1 + i + n * j) as f64).fract() - 0.5).qr().q();
    let values = DVector::from_fn(n, |i, _| if i == 0 { lowest } else { 1e6f64.powf(i as f64 / (n - 1) as f64) });
    let stiffness = &basis * DMatrix::from_diagonal(&values) * basis.transpose();
    let along = basis.column(0).into_owned();
    let mut well = Formula::new(n, |x: &[f64]| {
        let x = DVector::from_column_slice(x);
        let (s, force) = (along.dot(&x), &stiffness * &x);
        let energy = 0.5 * x.dot(&force) - s.powi(4) / 4.0 + s.powi(6) / 15.0;
        let (slope, curvature) = (0.4 * s.powi(5) - s.powi(3), 2.0 * s.powi(4) - 3.0 * s * s);
        (energy, force + &along * slope, &stiffness + &along * along.transpose() * curvature)
    });
    let settings = Settings { lengths: n, diameter: 10.0, tolerance: 1e-9, max_iterations: 30 };
    let mut newton = Newton::new(&mut [&mut well], &vec![false; n], settings).unwrap();
    newton.set_stabilizer(&vec![1.0; n / 3]);
    let mut x = vec![0.0; n];
    let solved = newton.solve(&mut [&mut well], &mut x, &[])?;
    Ok((solved.stability.unwrap(), along.dot(&DVector::from_vec(x))))
}

/// Stiffness of the mode from below to above what round-off can tell: negative pivots and the sign of the eigenvalue need not agree. Where
/// there is one, the mode is left, however little its eigenvalue tells of how fast it grows.
#[test]
fn a_mode_that_round_off_puts_at_zero_or_above_is_left_all_the_same() {
    let (mut left, mut above, mut told) = (0, 0, 0);
    for k in -40..=40 {
        let lowest = f64::from(k) * 5e-13;
        let (stability, s) = match leave_well(30, lowest) {
            Ok(found) => found,
            // That the flow found no way down such a slope is told.
            Err(Failure::Unstable(Some(value))) if value.abs() < 1e-9 => {
                told += 1;
                continue;
            }
            Err(e) => panic!("{lowest:e}: {e:?}"),
        };
        println!("{lowest:e}: {stability:?}, s {s}");
        if stability.switches > 0 {
            assert!((s.abs() - 2.5f64.sqrt()).abs() < 1e-9 && stability.lowest > 1.0, "{lowest:e}: {stability:?} {s}");
            left += 1;
            above += usize::from(stability.before >= 0.0);
        } else {
            assert!(s == 0.0 && stability.before.abs() < 1e-9, "{lowest:e}: {stability:?} {s}");
        }
    }
    assert!(left > 20 && above > 0 && told <= 2, "{left} {above} {told}");
}

/// A wheel in its plane, its hub at the origin: spokes that push, a rim that pulls, both of stiffness 1, and a spring of stiffness `weak`
/// from a point of the rim to (2, 0), which gives the wheel's turn about as much stiffness.
fn wheel(points: usize, weak: f64) -> impl Fn(&[f64]) -> (f64, DVector<f64>, DMatrix<f64>) {
    let chord = 2.0 * (0.5 * TAU / points as f64).sin();
    move |x: &[f64]| {
        let place = |i: usize| Vector2::new(x[2 * i], x[2 * i + 1]);
        let (mut energy, mut gradient, mut hessian) = (0.0, DVector::zeros(x.len()), DMatrix::zeros(x.len(), x.len()));
        let mut spring = |i: usize, j: Option<usize>, from: Vector2<f64>, length: f64, stiffness: f64| {
            let d = place(i) - j.map_or(from, place);
            let (size, along) = (d.norm(), d.normalize());
            let stretch = size - length;
            energy += 0.5 * stiffness * stretch * stretch;
            let share = stretch / size;
            for a in 0..2 {
                for (p, sign) in [Some((i, 1.0)), j.map(|j| (j, -1.0))].into_iter().flatten() {
                    gradient[2 * p + a] += sign * stiffness * stretch * along[a];
                    for b in 0..2 {
                        let k = stiffness * (share * f64::from(u8::from(a == b)) + (1.0 - share) * along[a] * along[b]);
                        for (q, other) in [Some((i, 1.0)), j.map(|j| (j, -1.0))].into_iter().flatten() {
                            hessian[(2 * p + a, 2 * q + b)] += sign * other * k;
                        }
                    }
                }
            }
        };
        for i in 0..points {
            spring(i, None, Vector2::zeros(), 2.6, 1.0);
            spring(i, Some((i + 1) % points), Vector2::zeros(), 0.7 * chord, 1.0);
        }
        spring(0, None, Vector2::new(2.0, 0.0), 0.0, weak);
        (energy, gradient, hessian)
    }
}

/// The wheel turns with so little resistance that round-off of its forces turns it by more than the tolerance, again and again.
#[test]
fn newton_ends_where_round_off_alone_moves_the_unknowns() {
    let points = 12;
    for weak in [1e-3, 1e-10, 1e-11, 1e-12] {
        let mut formula = Formula::new(2 * points, wheel(points, weak));
        let settings = Settings { lengths: 2 * points, diameter: 2.0, tolerance: 2e-9, max_iterations: 25 };
        let mut newton = Newton::new(&mut [&mut formula], &vec![false; 2 * points], settings).unwrap();
        let mut x: Vec<f64> = (0..points)
            .flat_map(|i| {
                let (sin, cos) = (TAU * i as f64 / points as f64 + 0.01).sin_cos();
                [1.9 * cos, 1.9 * sin]
            })
            .collect();
        let solved = newton.solve(&mut [&mut formula], &mut x, &[]).unwrap_or_else(|e| panic!("{weak:e}: {e:?}"));
        let forces = (wheel(points, weak))(&x).1.amax();
        // Round-off of forces of the order of 1, and what it turns against a spring on a lever of 2.
        let turn = x[1].atan2(x[0]);
        println!("{weak:e}: {solved:?}, {:?}, forces {forces:e}, turned by {turn:e}", newton.counters());
        assert!(forces < 1e-14 + weak * 2e-9 && turn.abs() < 2e-9 + 1e-15 / weak, "{weak:e}: {forces:e} {turn:e}");
        assert!(solved.negative_pivots <= usize::from(weak < 1e-9) && solved.increment <= settings.tolerance, "{weak:e}: {solved:?}");
        assert!(
            newton.counters().newton_iterations <= 10 && newton.counters().fallback_iterations == 0,
            "{weak:e}: {:?}",
            newton.counters()
        );
    }
}

//! Least energies of surfaces of revolution, by a method that shares nothing with the program: polynomials along the meridian, Gauss points,
//! Gauss and Newton's iteration. They are the references that the ladders of the axisymmetric scenes have.

use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::{PI, TAU};

/// Lengths of the metric along and around, by the length from the pole.
type Metric = fn(f64) -> [f64; 2];

/// A shape by the same length.
type Start = fn(f64) -> [f64; 5];

/// A shell of revolution with the rest metric `p^2 ds^2 + f^2 dtheta^2`.
struct Revolution {
    thickness: f64,
    poissons_ratio: f64,
    /// Ends of the meridian. Where it starts at 0, the axis is there.
    ends: [f64; 2],
    /// `p` and `f` at `s`.
    metric: Metric,
    /// Rest curvatures along and around, the same everywhere; a cup has positive ones, and so has a tube.
    rest_curvature: [f64; 2],
    /// A surface with this metric, from which the iteration starts: radius with two derivatives, first two derivatives of the height.
    start: Start,
}

/// Places in (-1, 1) and weights of Gauss' rule.
fn gauss(count: usize) -> Vec<[f64; 2]> {
    let legendre = |x: f64| {
        let (mut before, mut value) = (1.0, x);
        for k in 2..=count {
            (before, value) = (value, ((2 * k - 1) as f64 * x * value - (k - 1) as f64 * before) / k as f64);
        }
        (value, count as f64 * (x * value - before) / (x * x - 1.0))
    };
    let place = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        for _ in 0..20 {
            let (value, slope) = legendre(x);
            x -= value / slope;
        }
        let slope = legendre(x).1;
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..count).map(place).collect()
}

/// Chebyshev's polynomials up to a degree, with two derivatives.
fn chebyshev(degree: usize, x: f64) -> Vec<[f64; 3]> {
    let mut all = vec![[1.0, 0.0, 0.0], [x, 1.0, 0.0]];
    for k in 1..degree {
        let ([t, t1, t2], [s, s1, s2]) = (all[k], all[k - 1]);
        all.push([2.0 * x * t - s, 2.0 * t + 2.0 * x * t1 - s1, 4.0 * t1 + 2.0 * x * t2 - s2]);
    }
    all
}

impl Revolution {
    /// Square roots of the energy density over `E h^3`, times a weight: what is squared are the two of stretching, then those of bending.
    fn roots(&self, weight: f64, [p, f]: [f64; 2], q: [Complex<f64>; 5]) -> [Complex<f64>; 4] {
        let [r, r1, r2, z1, z2] = q;
        let nu = self.poissons_ratio;
        // alpha/2 tr^2 + beta tr of the square, over E, by its Cholesky factor.
        let (square, mixed) = (1.0 / (2.0 * (1.0 - nu * nu)), nu / (2.0 * (1.0 - nu * nu)));
        let factor = [square.sqrt(), mixed / square.sqrt(), (square - mixed * mixed / square).sqrt()];
        let length_squared = r1 * r1 + z1 * z1;
        let length = length_squared.sqrt();
        let strain = [(length_squared / (p * p) - 1.0) * 0.5, (r * r / (f * f) - 1.0) * 0.5];
        let [along, around] = self.rest_curvature;
        let bend = [(r1 * z2 - z1 * r2) / length / (p * p) - along, r * z1 / length / (f * f) - around];
        let [m, b] = [weight.sqrt() / self.thickness, (weight / 12.0).sqrt()];
        let parts = |[x, y]: [Complex<f64>; 2], scale: f64| [(x * factor[0] + y * factor[1]) * scale, y * factor[2] * scale];
        let ([a, b], [c, d]) = (parts(strain, m), parts(bend, b));
        [a, b, c, d]
    }

    /// Stretching and bending energy over `E h^3`, of the start and of the minimum among polynomials of a degree.
    fn energies(&self, degree: usize) -> [[f64; 2]; 2] {
        let (middle, half) = (0.5 * (self.ends[0] + self.ends[1]), 0.5 * (self.ends[1] - self.ends[0]));
        let axis = self.ends[0] == 0.0;
        let rule = gauss(2 * degree);
        let n = degree + 1;
        // How the five numbers at each point depend on the coefficients: of the radius, then of the slope of the height.
        let bases: Vec<DMatrix<f64>> = rule
            .iter()
            .map(|[x, _]| {
                let s = middle + half * x;
                let mut basis = DMatrix::zeros(5, 2 * n);
                for (k, [t, t1, t2]) in chebyshev(degree, *x).into_iter().enumerate() {
                    let (t1, t2) = (t1 / half, t2 / (half * half));
                    let of = if axis { [s * t, t + s * t1, 2.0 * t1 + s * t2] } else { [t, t1, t2] };
                    (0..3).for_each(|i| basis[(i, k)] = of[i]);
                    (0..2).for_each(|i| basis[(3 + i, n + k)] = of[i]);
                }
                basis
            })
            .collect();
        let point = |i: usize, u: &DVector<f64>| {
            let s = middle + half * rule[i][0];
            let (metric, start, change) = ((self.metric)(s), (self.start)(s), &bases[i] * u);
            let weight = TAU * rule[i][1] * half * metric[0] * metric[1];
            (weight, metric, std::array::from_fn::<_, 5, _>(|k| Complex::from(start[k] + change[k])))
        };
        let energy = |u: &DVector<f64>| {
            let mut sum = [0.0; 2];
            for i in 0..rule.len() {
                let (weight, metric, q) = point(i, u);
                let roots = self.roots(weight, metric, q);
                (0..4).for_each(|k| sum[k / 2] += roots[k].re * roots[k].re);
            }
            sum
        };
        let total = |u: &DVector<f64>| energy(u).iter().sum::<f64>();
        let mut u = DVector::zeros(2 * n);
        let start = energy(&u);
        for _ in 0..40 {
            let (mut jacobian, mut value) = (DMatrix::zeros(4 * rule.len(), 2 * n), DVector::zeros(4 * rule.len()));
            for i in 0..rule.len() {
                let (weight, metric, q) = point(i, &u);
                let roots = self.roots(weight, metric, q);
                (0..4).for_each(|k| value[4 * i + k] = roots[k].re);
                let mut local = DMatrix::zeros(4, 5);
                for j in 0..5 {
                    let mut moved = q;
                    moved[j].im = 1e-30;
                    let slopes = self.roots(weight, metric, moved);
                    (0..4).for_each(|k| local[(k, j)] = slopes[k].im / 1e-30);
                }
                jacobian.rows_mut(4 * i, 4).copy_from(&(local * &bases[i]));
            }
            let qr = jacobian.qr();
            let mut step = -(qr.q().transpose() * value);
            assert!(qr.r().solve_upper_triangular_mut(&mut step));
            let before = total(&u);
            while total(&(&u + &step)) > before * (1.0 + 1e-14) && step.norm() > 1e-14 {
                step *= 0.5;
            }
            u += &step;
            if step.norm() < 1e-10 {
                break;
            }
        }
        [start, energy(&u)]
    }
}

/// A sphere of radius `R` by the length from its pole.
const fn sphere<const R: usize>() -> (Metric, Start) {
    // R in thousandths of a metre, since constants of a type are whole numbers.
    fn radius<const R: usize>() -> f64 {
        R as f64 * 1e-3
    }
    (
        |s| [1.0, radius::<R>() * (s / radius::<R>()).sin()],
        |s| {
            let r = radius::<R>();
            let (sin, cos) = (s / r).sin_cos();
            [r * sin, cos, -sin / r, -sin, -cos / r]
        },
    )
}

/// A sphere of radius 10 mm by the length from its equator.
fn band(s: f64) -> [f64; 5] {
    let (sin, cos) = (s * 100.0).sin_cos();
    [0.01 * cos, -sin, -cos * 100.0, cos, -sin * 100.0]
}

/// A scene of the program, and the same problem here.
fn problems() -> [(&'static str, Revolution); 7] {
    let slope = (1.05f64 * 1.05 - 1.0).sqrt();
    assert!((slope - 0.320_156_211_871_642_4).abs() < 1e-15);
    let bent = |thickness, poissons_ratio, ends, (metric, start), rest_curvature| Revolution {
        thickness,
        poissons_ratio,
        ends,
        metric,
        rest_curvature,
        start,
    };
    let shell = |thickness, poissons_ratio, ends, (metric, start)| bent(thickness, poissons_ratio, ends, (metric, start), [0.0; 2]);
    [
        (include_str!("../../configs/analytic/sphere_annulus.toml"), shell(0.01, 0.3, [0.1, 1.1], sphere::<1000>())),
        (include_str!("../../configs/analytic/sharon_annulus_elliptic.toml"), shell(3e-4, 0.45, [0.003, 0.03], sphere::<25>())),
        // Stereographic: tan of half the angle at the centre of the sphere is 2 r.
        (include_str!("../../configs/analytic/halftone_sphere.toml"), shell(0.02, 0.3, [0.0, 2f64.atan()], sphere::<500>())),
        (
            include_str!("../../configs/analytic/cone.toml"),
            shell(2e-3, 0.3, [0.1, 1.0], (|s| [1.05, s], |s| [s, 1.0, 0.0, 0.320_156_211_871_642_4, 0.0])),
        ),
        // Growth by r^-0.2: lengths r^0.8 / 0.8 along the meridian, circles of radius r^0.8.
        (
            include_str!("../../configs/analytic/halftone_cone.toml"),
            shell(2e-3, 0.3, [0.1f64.powf(0.8) / 0.8, 1.25], (|s| [1.0, 0.8 * s], |s| [0.8 * s, 0.8, 0.0, 0.6, 0.0])),
        ),
        // The tube keeps the curvature of its circles, as the second form grows with the first.
        (
            include_str!("../../configs/analytic/sharon_tube_elliptic.toml"),
            bent(1e-4, 0.45, [-0.01, 0.01], (|s| [1.0, 0.01 * (s * 100.0).cos()], band), [0.0, 100.0]),
        ),
        (
            include_str!("../../configs/analytic/disc_curvature.toml"),
            bent(1e-3, 0.3, [0.0, 0.1], (|s| [1.0, s], |s| [s, 1.0, 0.0, 0.3 * s, 0.3]), [0.5619 * 1.01; 2]),
        ),
    ]
}

#[test]
fn rules_and_polynomials_are_right() {
    for power in [0, 2, 6, 14] {
        let sum: f64 = gauss(8).iter().map(|[x, w]| w * x.powi(power)).sum();
        assert!((sum - 2.0 / f64::from(power + 1)).abs() < 1e-14, "{power}: {sum}");
    }
    for (k, [t, t1, t2]) in chebyshev(7, 0.3).into_iter().enumerate() {
        let (angle, k) = (0.3f64.acos(), k as f64);
        let (exact, slope) = ((k * angle).cos(), k * (k * angle).sin() / angle.sin());
        assert!((t - exact).abs() < 1e-14 && (t1 - slope).abs() < 1e-13);
        // Chebyshev's equation.
        assert!(((1.0 - 0.09) * t2 - 0.3 * t1 + k * k * t).abs() < 1e-12);
    }
}

/// The cap of the annulus has a known energy; the minimum is lower, and does not depend on the degree.
#[test]
fn the_cap_of_the_annulus_is_known_and_relaxes() {
    let (_, annulus) = &problems()[0];
    let [[stretched, bent], coarse] = annulus.energies(30);
    assert!(stretched < 1e-20 && (bent - 0.404972).abs() < 1e-6, "{stretched} {bent}");
    let fine = annulus.energies(50)[1];
    assert!((0..2).all(|k| (coarse[k] / fine[k] - 1.0).abs() < 1e-8), "{coarse:?} {fine:?}");
    assert!(fine[0] + fine[1] < 0.95 * bent && fine[0] > 1e-3);
}

#[test]
fn ladders_have_these_references() {
    for (text, problem) in problems() {
        let scene: toml::Table = text.parse().unwrap();
        let number = |table: &str, key: &str| scene[table][key].as_float().unwrap();
        let ladder = &scene["report"]["ladder"];
        let thickness = ladder.get("thicknesses").map_or_else(|| number("shell", "thickness"), |list| list[0].as_float().unwrap());
        assert_eq!((thickness, number("shell", "poissons_ratio")), (problem.thickness, problem.poissons_ratio));
        assert_eq!(ladder["measure"]["energy"]["over"].as_str(), Some("E * h^3"));
        let reference = ladder["reference"].as_float().unwrap();
        let [stretched, bent] = problem.energies(50)[1];
        let energy = stretched + bent;
        println!("{}: {energy:.10}, stretching {stretched:.10}", scene["title"]);
        assert!((energy / reference - 1.0).abs() < 1e-6, "{}: {energy:.10} {reference}", scene["title"]);
    }
}

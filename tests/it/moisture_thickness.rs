//! Diffusion through the thickness against series. Lengths over `h`, times `T = D t / h^2`.
//!
//! A sheet whose metric swells as `1 + 2 eps u` takes the rest curvature `-6/h^3 int z 2 eps u dz`; over `eps / h` that is the curl,
//! `-12/h^2 int z u dz`, positive where the bottom is wetter.

use crate::moisture_support::{always, cell, constant, isotropic, order, side, uniform};
use std::f64::consts::{FRAC_PI_2, PI};
use thinshell::moisture::{Condition, Diffusion, Law, Mass, Scheme, Side, cosine_levels};

/// Curl of the values over a vertex, linear between levels.
fn curl(diffusion: &Diffusion) -> f64 {
    let (z, u) = (diffusion.levels(), diffusion.values());
    let layer = |l: usize| {
        let [a, b] = [z[l] - 0.5, z[l + 1] - 0.5];
        (b - a) / 6.0 * (a * (2.0 * u[l] + u[l + 1]) + b * (u[l] + 2.0 * u[l + 1]))
    };
    -12.0 * (0..z.len() - 1).map(layer).sum::<f64>()
}

/// Bottom held at 1 from the start, top sealed: `u = 1 - sum 2 sin(l)/l exp(-l^2 T) cos(l y)`, `l = (n + 1/2) pi`, `y` from the top.
/// Then `int (y - 1/2) cos(l y) dy = sin(l)/(2 l) + (cos(l) - 1)/l^2`.
fn wetted_curl(t: f64) -> f64 {
    let term = |n: usize| {
        let l = (n as f64 + 0.5) * PI;
        let sine = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        2.0 * sine / l * (-l * l * t).exp() * (sine / (2.0 * l) - 1.0 / (l * l))
    };
    -12.0 * (0..400).map(term).sum::<f64>()
}

fn wet(sides: &[Side]) -> Vec<Condition> {
    sides.iter().map(|s| always(side(&cell(), *s), Law::Value(constant(1.0)))).collect()
}

fn one_column(levels: Vec<f64>, conditions: Vec<Condition>, mass: Mass, scheme: Scheme) -> Diffusion {
    Diffusion::new(isotropic(&cell(), 1.0, 1.0, levels), conditions, None, mass, scheme, None).unwrap()
}

fn lumped(layers: usize, conditions: Vec<Condition>) -> Diffusion {
    one_column(cosine_levels(layers), conditions, Mass::Lumped, Scheme::Sdirk2)
}

/// Curls at equal steps, from the first on; nothing may depend on the vertex.
fn history(diffusion: &mut Diffusion, dt: f64, steps: usize) -> Vec<f64> {
    (0..steps)
        .map(|k| {
            diffusion.advance(dt * k as f64, dt * (k + 1) as f64, &[]).unwrap();
            curl(diffusion)
        })
        .collect()
}

/// Time and value of the largest of the curls, by the parabola through it and its neighbours.
fn peak(curls: &[f64], dt: f64) -> [f64; 2] {
    let k = (1..curls.len() - 1).max_by(|a, b| curls[*a].total_cmp(&curls[*b])).unwrap();
    let (a, b, c) = (curls[k - 1], curls[k], curls[k + 1]);
    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
    [dt * (k as f64 + 1.0 + shift), b - 0.25 * (a - c) * shift]
}

#[test]
fn the_series_is_the_published_curl() {
    let reference: toml::Table = include_str!("../../data/reference/nonlinear_shells.toml").parse().unwrap();
    let numbers = |array: &toml::Value| array.as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect::<Vec<_>>();
    let rows = reference["wetted_slab"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 5);
    for row in rows.iter().map(numbers) {
        assert!((wetted_curl(row[0]) - row[1]).abs() < 6e-6, "T {}: {} {}", row[0], wetted_curl(row[0]), row[1]);
    }
    let curls: Vec<f64> = (1..2000).map(|k| wetted_curl(1e-4 * k as f64)).collect();
    let (found, published) = (peak(&curls, 1e-4), numbers(&reference["wetted_slab"]["peak"]));
    assert!((found[0] - published[0]).abs() < 1e-6 && (found[1] - published[1]).abs() < 6e-7, "{found:?} {published:?}");
}

#[test]
fn a_slab_wetted_on_one_side_curls_as_the_series_says() {
    const DT: f64 = 2e-5;
    for (layers, allowed) in [(8, [0.05, 0.02, 0.01]), (16, [0.012, 0.006, 0.003])] {
        let mut diffusion = lumped(layers, wet(&[Side::Bottom]));
        let curls = history(&mut diffusion, DT, 50_000);
        assert_eq!(diffusion.factorizations(), 1);
        let error = |t: f64| (curls[(t / DT).round() as usize - 1] / wetted_curl(t) - 1.0).abs();
        let late = [0.05, 0.1, 0.2, 0.3, 0.5, 1.0].map(error).into_iter().fold(0.0, f64::max);
        let errors = [error(0.01), error(0.02), late];
        println!("{layers} layers: {errors:?}, peak {:?}", peak(&curls, DT));
        assert!(errors.iter().zip(allowed).all(|(e, a)| *e <= a), "{layers} layers: {errors:?}");
        if layers == 8 {
            let [time, value] = peak(&curls, DT);
            assert!((time / 0.084590 - 1.0).abs() < 0.02 && (value / 0.960126 - 1.0).abs() < 0.01, "{time} {value}");
        }
        // The other side curls the other way.
        let mut top = lumped(layers, wet(&[Side::Top]));
        let other = history(&mut top, DT, 1000);
        assert!(other.iter().zip(&curls).all(|(a, b)| *b > 0.01 && (a + b).abs() < 1e-11));
    }
}

#[test]
fn one_layer_decays_exponentially() {
    for (mass, rate) in [(Mass::Lumped, 2.0), (Mass::Consistent, 3.0)] {
        let mut diffusion = one_column(uniform(1), wet(&[Side::Bottom]), mass, Scheme::Sdirk2);
        let curls = history(&mut diffusion, 1e-4, 10_000);
        for (k, curl) in curls.iter().enumerate() {
            let exact = (-rate * 1e-4 * (k + 1) as f64).exp();
            assert!((curl - exact).abs() < 1e-8, "{mass:?} step {k}: {curl} {exact}");
        }
    }
}

/// The bottom rises as `t`: `u'/2 = t - u` at the top with lumped mass, `u'/3 + 1/6 = t - u` with that of the elements.
#[test]
fn one_layer_follows_a_ramp() {
    for (mass, rate) in [(Mass::Lumped, 2.0), (Mass::Consistent, 3.0)] {
        let ramp = always(side(&cell(), Side::Bottom), Law::Value(Box::new(|_, t| t)));
        let mut diffusion = one_column(uniform(1), vec![ramp], mass, Scheme::Sdirk2);
        history(&mut diffusion, 1e-3, 700);
        let (found, exact) = (diffusion.values()[1], 0.7 - 0.5 * (1.0 - (-rate * 0.7f64).exp()));
        assert!((found - exact).abs() < 1e-7, "{mass:?}: {found} {exact}");
    }
}

#[test]
fn a_slab_wetted_on_both_sides_stays_flat() {
    // The even terms of the series of the mean.
    let exact = 1.0 - (0..50).map(|n| (2.0 * n as f64 + 1.0) * PI).map(|l| 8.0 / (l * l) * (-l * l * 0.2).exp()).sum::<f64>();
    assert!(exact < 0.9);
    let errors = [8, 16].map(|layers| {
        let mut diffusion = lumped(layers, wet(&[Side::Top, Side::Bottom]));
        let curls = history(&mut diffusion, 1e-3, 200);
        assert!(curls.iter().all(|curl| curl.abs() < 1e-13), "{:?}", curls.iter().fold(0.0, |m: f64, c| m.max(c.abs())));
        (diffusion.balance().content - exact).abs()
    });
    assert!(errors[0] < 4e-3 && errors[1] < errors[0] / 3.5, "{errors:?}");
}

/// Exchange at the bottom with `k h / D = 1`, top sealed: `u = 1 - sum c exp(-l^2 T) cos(l y)`, `l tan(l) = 1`, `c = 4 sin l / (2 l + sin 2 l)`.
#[test]
fn exchange_follows_its_series() {
    let root = |n: usize| {
        let (mut low, mut high) = (n as f64 * PI, n as f64 * PI + FRAC_PI_2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle * middle.tan() < 1.0 { low = middle } else { high = middle }
        }
        low
    };
    let modes: Vec<[f64; 2]> = (0..60).map(root).map(|l| [l, 4.0 * l.sin() / (2.0 * l + (2.0 * l).sin())]).collect();
    assert!(modes.iter().all(|[l, _]| (l * l.tan() - 1.0).abs() < 1e-9), "{modes:?}");
    let sum = |t: f64, f: &dyn Fn(f64) -> f64| modes.iter().map(|[l, c]| c * (-l * l * t).exp() * f(*l)).sum::<f64>();
    const DT: f64 = 1e-4;
    let errors = [8, 16, 32].map(|layers| {
        let law = Law::Exchange { coefficient: 1.0, outside: constant(1.0) };
        let mut diffusion = lumped(layers, vec![always(side(&cell(), Side::Bottom), law)]);
        let (mut worst, mut worst_mean) = (0.0f64, 0.0f64);
        for k in 0..10_000 {
            diffusion.advance(DT * k as f64, DT * (k + 1) as f64, &[]).unwrap();
            let t = DT * (k + 1) as f64;
            if t > 0.05 {
                let exact = -12.0 * sum(t, &|l| l.sin() / (2.0 * l) + (l.cos() - 1.0) / (l * l));
                worst = worst.max((curl(&diffusion) / exact - 1.0).abs());
                worst_mean = worst_mean.max((diffusion.balance().content / (1.0 - sum(t, &|l| l.sin() / l)) - 1.0).abs());
            }
        }
        [worst, worst_mean]
    });
    println!("exchange, curl and mean: {errors:?}");
    assert!(errors[0][0] < 0.02 && errors[0][1] < 0.007, "{errors:?}");
    for part in 0..2 {
        let order = order(&[4.0, 2.0, 1.0], &errors.map(|e| e[part]));
        assert!((order - 2.0).abs() < 0.1, "order {order}: {errors:?}");
    }
}

//! Diffusion in the sheet against exact solutions, and orders of convergence.

use crate::moisture_support::{MASSES, SCHEMES, always, constant, isotropic, order, rim, side, slab, uniform};
use nalgebra::{Matrix2, Matrix3, Rotation3, Vector2, Vector3};
use std::f64::consts::PI;
use thinshell::math::quadrature::{GAUSS, RADON};
use thinshell::mesh::Mesh;
use thinshell::mesh::generate::{Pattern, rectangle};
use thinshell::moisture::{Diffusion, Law, Mass, Scheme, Side, Source, cosine_levels};
use thinshell::report::vertex_areas;

/// The error function's complement, by the continued fraction of its tail or its series (both to 1e-14).
fn erfc(x: f64) -> f64 {
    if x < 2.0 {
        let (mut term, mut sum) = (x, x);
        for n in 1..60 {
            term *= -x * x / f64::from(n);
            sum += term / f64::from(2 * n + 1);
        }
        return 1.0 - 2.0 / PI.sqrt() * sum;
    }
    let tail = (1..80).rev().fold(x, |tail, n| x + 0.5 * f64::from(n) / tail);
    (-x * x).exp() / (PI.sqrt() * tail)
}

/// Mean over the levels of each vertex, which is all there is in a sheet without fluxes through it.
fn of_vertices(diffusion: &Diffusion) -> Vec<f64> {
    diffusion.values().chunks(diffusion.levels().len()).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
}

#[test]
fn a_square_with_a_dry_rim_decays_at_its_rate() {
    // Time over L^2 / D.
    let rate = 2.0 * PI * PI;
    for mass in MASSES {
        let errors = [8, 16, 32].map(|n| {
            let mesh = rectangle([1.0; 2], [n, n], Pattern::Diagonal, 0.25, 7).unwrap();
            let dry = always(rim(&mesh, |_| true), Law::Value(constant(0.0)));
            let mut diffusion =
                Diffusion::new(isotropic(&mesh, 0.01, 1.0, uniform(1)), vec![dry], None, mass, Scheme::Sdirk2, Some(1e-3)).unwrap();
            let mode = |v: &Vector3<f64>| (PI * v.x).sin() * (PI * v.y).sin();
            diffusion.set(mesh.vertices.iter().flat_map(|v| [mode(v); 2]).collect());
            diffusion.advance(0.0, 0.02, &[]).unwrap();
            let start = diffusion.balance().content;
            diffusion.advance(0.02, 0.07, &[]).unwrap();
            ((start / diffusion.balance().content).ln() / 0.05 / rate - 1.0).abs()
        });
        println!("decay {mass:?}: {errors:?}");
        let order = order(&[4.0, 2.0, 1.0], &errors);
        assert!(errors[2] < 3e-3 && (order - 2.0).abs() < 0.1, "{mass:?}: order {order}, {errors:?}");
    }
}

#[test]
fn a_front_is_an_error_function() {
    let (reach, time) = (2.0, 0.02);
    for mass in MASSES {
        let errors = [40, 80].map(|n| {
            let mesh = rectangle([reach, 0.2], [n, n / 10], Pattern::Diagonal, 0.25, 7).unwrap();
            let wet = always(rim(&mesh, |v| v.x < 1e-9), Law::Value(constant(1.0)));
            let mut diffusion =
                Diffusion::new(isotropic(&mesh, 0.01, 1.0, uniform(1)), vec![wet], None, mass, Scheme::Sdirk2, Some(1e-4)).unwrap();
            diffusion.advance(0.0, time, &[]).unwrap();
            let exact = |v: &Vector3<f64>| erfc(0.5 * v.x / time.sqrt());
            let front = of_vertices(&diffusion);
            assert!(mesh.vertices.iter().filter(|v| (0.2..0.8).contains(&exact(v))).count() > 10);
            let entered = 0.2 * 0.01 * 2.0 * (time / PI).sqrt();
            let (content, rim) = (diffusion.balance().content, diffusion.balance().rim);
            assert!((content / rim - 1.0).abs() < 1e-12 && (content / entered - 1.0).abs() < 0.02, "{content} {rim} {entered}");
            mesh.vertices.iter().zip(front).map(|(v, u)| (u - exact(v)).abs()).fold(0.0, f64::max)
        });
        println!("front {mass:?}: {errors:?}");
        assert!(errors[1] < 2e-3 && errors[0] / errors[1] > 3.0, "{mass:?}: {errors:?}");
    }
}

/// A drop on one vertex spreads as a Gaussian with covariance `2 D t`. `diffusivity`: along and across fibres at `angle` [degrees].
fn drop(diffusivity: [f64; 2], angle: f64, mass: Mass) {
    let (cells, time) = (60, 1.0);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle.to_radians());
    let mut mesh = rectangle([1.0; 2], [cells, cells], Pattern::CrissCross, 0.0, 0).unwrap();
    mesh.vertices.iter_mut().for_each(|v| *v -= Vector3::new(0.5, 0.5, 0.0));
    let centre = mesh.vertices.iter().position(|v| v.norm() < 1e-9).unwrap();
    let fibres = turn * Vector3::x();
    let slab = slab(&mesh, 0.01, [diffusivity[0], diffusivity[1], 1.0], fibres, uniform(1));
    let mut diffusion = Diffusion::new(slab, Vec::new(), None, mass, Scheme::Sdirk2, Some(0.005)).unwrap();
    let mut u = vec![0.0; 2 * mesh.vertices.len()];
    u[2 * centre..2 * centre + 2].fill(1.0);
    diffusion.set(u.clone());
    let content = diffusion.balance().content / 0.01;
    diffusion.set(u.iter().map(|u| u / content).collect());
    diffusion.advance(0.0, time, &[]).unwrap();
    let axes = Matrix3::from_columns(&[fibres, turn * Vector3::y(), Vector3::z()]);
    let tensor = (axes * Matrix3::from_diagonal(&Vector3::new(diffusivity[0], diffusivity[1], 0.0)) * axes.transpose())
        .fixed_view::<2, 2>(0, 0)
        .into_owned();
    let covariance: Matrix2<f64> = 2.0 * time * tensor;
    let (inverse, peak) = (covariance.try_inverse().unwrap(), 1.0 / (2.0 * PI * covariance.determinant().sqrt()));
    let (found, areas) = (of_vertices(&diffusion), vertex_areas(&mesh.vertices, &mesh.faces));
    let (mut far, mut moments) = (0.0f64, Matrix2::zeros());
    for ((v, u), area) in mesh.vertices.iter().zip(found).zip(areas) {
        let x = Vector2::new(v.x, v.y);
        far = far.max((u - peak * (-0.5 * (x.transpose() * inverse * x)[0]).exp()).abs());
        moments += u * area * x * x.transpose();
    }
    println!(
        "drop {diffusivity:?} at {angle} {mass:?}: {} of the peak, moments {}",
        far / peak,
        (moments - covariance).norm() / covariance.norm()
    );
    assert!(far < 0.03 * peak, "{diffusivity:?} at {angle} {mass:?}: {far} {peak}");
    assert!((moments - covariance).norm() < 0.005 * covariance.norm(), "{moments} {covariance}");
}

#[test]
fn a_drop_spreads_as_a_gaussian() {
    for mass in MASSES {
        drop([5e-3, 5e-3], 0.0, mass);
        drop([8e-3, 1e-3], 0.0, mass);
        drop([8e-3, 1e-3], 30.0, mass);
    }
}

/// `sin(pi x)^2 sin(pi y)^2 + 2`, which no flux crosses at the rim of the unit square, times a cosine of the height above the bottom, which is sealed.
struct Manufactured {
    tensor: Matrix2<f64>,
    through: f64,
}

impl Manufactured {
    fn exact(x: f64, y: f64, z: f64) -> f64 {
        ((PI * x).sin().powi(2) * (PI * y).sin().powi(2) + 2.0) * z.cos()
    }

    /// `-div(D grad u)`.
    fn source(&self, x: f64, y: f64, z: f64) -> f64 {
        let [sx, sy] = [x, y].map(|x| (PI * x).sin().powi(2));
        let [tx, ty] = [x, y].map(|x| PI * (2.0 * PI * x).sin());
        let [cx, cy] = [x, y].map(|x| 2.0 * PI * PI * (2.0 * PI * x).cos());
        let sheet = self.tensor.m11 * cx * sy + 2.0 * self.tensor.m12 * tx * ty + self.tensor.m22 * sx * cy;
        z.cos() * (self.through * (sx * sy + 2.0) - sheet)
    }
}

/// L2 distance from the exact solution, by quadrature over every prism; the thickness is 1.
fn distance(mesh: &Mesh, diffusion: &Diffusion) -> f64 {
    let (z, u) = (diffusion.levels(), diffusion.values());
    let mut sum = 0.0;
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| mesh.vertices[v]);
        let twice = (b - a).cross(&(c - a)).norm();
        for ([p, q], weight) in RADON {
            let place = a * (1.0 - p - q) + b * p + c * q;
            for (l, layer) in z.windows(2).enumerate() {
                let at = |level: usize| [1.0 - p - q, p, q].iter().zip(face).map(|(n, v)| n * u[v * z.len() + level]).sum::<f64>();
                let [bottom, top] = [at(l), at(l + 1)];
                for (s, line) in GAUSS {
                    let height = layer[0] + s * (layer[1] - layer[0]);
                    let error = bottom + s * (top - bottom) - Manufactured::exact(place.x, place.y, height);
                    sum += twice * weight * line * (layer[1] - layer[0]) * error * error;
                }
            }
        }
    }
    sum.sqrt()
}

#[test]
fn space_is_of_second_order_with_an_oblique_tensor_on_jittered_meshes() {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 30f64.to_radians());
    let (fibres, across) = (turn * Vector3::x(), turn * Vector3::y());
    let plane = |v: Vector3<f64>| v.xy() * v.xy().transpose();
    for mass in MASSES {
        let errors = [8, 16, 32].map(|n| {
            let mesh = rectangle([1.0; 2], [n, n], Pattern::Diagonal, 0.25, 11).unwrap();
            let slab = slab(&mesh, 1.0, [1.0, 0.2, 0.5], fibres, uniform(n / 2));
            let case = Manufactured { tensor: plane(fibres) + 0.2 * plane(across), through: 0.5 };
            let places = mesh.vertices.clone();
            let source = Source { rate: Box::new(move |v, z, _| case.source(places[v].x, places[v].y, z)) };
            let places = mesh.vertices.clone();
            let top = always(side(&mesh, Side::Top), Law::Value(Box::new(move |v, _| Manufactured::exact(places[v].x, places[v].y, 1.0))));
            let mut diffusion = Diffusion::new(slab, vec![top], Some(source), mass, Scheme::BackwardEuler, None).unwrap();
            // One step of this length leaves nothing of the start.
            diffusion.advance(0.0, 1e9, &[]).unwrap();
            distance(&mesh, &diffusion)
        });
        let order = order(&[4.0, 2.0, 1.0], &errors);
        println!("space {mass:?}: {errors:?}, order {order}");
        assert!((order - 2.0).abs() < 0.15 && errors[2] < 5e-3, "{mass:?}: order {order}, {errors:?}");
    }
}

#[test]
fn time_is_of_first_and_second_order() {
    let mesh = rectangle([1.0; 2], [4, 4], Pattern::Diagonal, 0.25, 3).unwrap();
    for mass in MASSES {
        let run = |scheme: Scheme, steps: u32| {
            let conditions = vec![
                always(side(&mesh, Side::Top), Law::Exchange { coefficient: 2.0, outside: Box::new(|v, t| (3.0 * t).sin() * v as f64) }),
                always(rim(&mesh, |v| v.x < 1e-9), Law::Value(Box::new(|v, t| t * t * (1.0 + v as f64)))),
                always(side(&mesh, Side::Bottom), Law::Flux(Box::new(|v, t| (4.0 * t).cos() * (1.0 + v as f64)))),
            ];
            let source = Source { rate: Box::new(|v, z, t| (2.0 * t).cos() * z + v as f64) };
            let slab = slab(&mesh, 1.0, [1.0, 0.2, 0.5], Vector3::new(1.0, 1.0, 0.0), cosine_levels(3));
            let mut diffusion = Diffusion::new(slab, conditions, Some(source), mass, scheme, Some(1.0 / f64::from(steps))).unwrap();
            diffusion.advance(0.0, 1.0, &[]).unwrap();
            diffusion.values().to_vec()
        };
        let reference = run(Scheme::Sdirk2, 4096);
        for (scheme, expected) in SCHEMES.into_iter().zip([1.0, 2.0]) {
            let steps = [32, 64, 128];
            let error = |n: u32| run(scheme, n).iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let errors = steps.map(error);
            let order = order(&steps.map(|n| 1.0 / f64::from(n)), &errors);
            println!("time {mass:?} {scheme:?}: {errors:?}, order {order}");
            assert!((order - expected).abs() < 0.1, "{mass:?} {scheme:?}: order {order}, {errors:?}");
        }
    }
}

//! Measures of a result against surfaces whose answer is known.

use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::PI;
use thinshell::report::{self, Curvature};

type Points = Vec<Vector3<f64>>;

/// A map of `[0, 1]^2` cut into `n x n` cells of two triangles; inner vertices are moved by up to `jitter` of a cell.
fn patch(n: usize, jitter: f64, map: impl Fn(f64, f64) -> Vector3<f64>) -> (Points, Vec<[usize; 3]>) {
    let mut state = 12345u64;
    let mut noise = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 40) as f64 / (1u64 << 24) as f64 - 0.5) * 2.0 * jitter / n as f64
    };
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..=n {
        for j in 0..=n {
            let inner = (1..n).contains(&i) && (1..n).contains(&j);
            let (du, dv) = if inner { (noise(), noise()) } else { (0.0, 0.0) };
            vertices.push(map(i as f64 / n as f64 + du, j as f64 / n as f64 + dv));
            if i < n && j < n {
                let a = i * (n + 1) + j;
                faces.extend([[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]);
            }
        }
    }
    (vertices, faces)
}

fn sphere(radius: f64) -> impl Fn(f64, f64) -> Vector3<f64> {
    // Around the equator, outward normals.
    move |u, v| {
        let (theta, z) = (u, 0.8 * (v - 0.5));
        Vector3::new(theta.cos() * z.cos(), theta.sin() * z.cos(), z.sin()) * radius
    }
}

fn cylinder(radius: f64) -> impl Fn(f64, f64) -> Vector3<f64> {
    move |u, v| Vector3::new(radius * u.cos(), radius * u.sin(), v)
}

fn motion() -> (Rotation3<f64>, Vector3<f64>) {
    (Rotation3::from_euler_angles(0.3, -1.1, 2.5), Vector3::new(3.0, -0.2, 10.0))
}

#[test]
fn rigid_fit_finds_the_motion() {
    let (rotation, shift) = motion();
    let (points, _) = patch(4, 0.2, sphere(0.1));
    let moved: Points = points.iter().map(|p| rotation * p + shift).collect();
    let (r, t) = report::rigid_fit(&points, &moved);
    assert!((r.matrix() - rotation.matrix()).amax() < 1e-12);
    assert!((t - shift).amax() < 1e-12);
}

#[test]
fn rigid_fit_never_mirrors() {
    let (points, _) = patch(4, 0.2, sphere(1.0));
    let mirrored: Points = points.iter().map(|p| Vector3::new(p.x, -p.y, p.z)).collect();
    let (r, _) = report::rigid_fit(&points, &mirrored);
    assert!((r.matrix().determinant() - 1.0).abs() < 1e-12);
    // Flat and straight sets have a best motion all the same.
    for points in [patch(3, 0.0, |u, v| Vector3::new(u, v, 0.0)).0, patch(3, 0.0, |u, _| Vector3::new(u, 0.0, 0.0)).0] {
        let (rotation, shift) = motion();
        let moved: Points = points.iter().map(|p| rotation * p + shift).collect();
        let (r, t) = report::rigid_fit(&points, &moved);
        assert!((r.matrix().determinant() - 1.0).abs() < 1e-12);
        let error = points.iter().zip(&moved).map(|(p, q)| (r * p + t - q).norm()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{error}");
    }
    let (r, t) = report::rigid_fit(&[], &[]);
    assert_eq!((r, t), (Rotation3::identity(), Vector3::zeros()));
    let (_, t) = report::rigid_fit(&[Vector3::new(f64::NAN, 0.0, 0.0)], &[Vector3::zeros()]);
    assert!(t.x.is_nan());
}

proptest! {
    /// No small turn of the fit makes it better.
    #[test]
    fn rigid_fit_is_a_minimum(from in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 3..12), seed in 0u64..1000) {
        let from: Points = from.into_iter().map(Vector3::from).collect();
        let (rotation, shift) = motion();
        let wobble = |i: usize| Vector3::new((seed as f64 + i as f64).sin(), (2.0 * i as f64).cos(), (seed as f64 * i as f64).sin()) * 0.3;
        let to: Points = from.iter().enumerate().map(|(i, p)| rotation * p + shift + wobble(i)).collect();
        let (r, t) = report::rigid_fit(&from, &to);
        let cost = |r: &Rotation3<f64>, t: &Vector3<f64>| from.iter().zip(&to).map(|(a, b)| (r * a + t - b).norm_squared()).sum::<f64>();
        let best = cost(&r, &t);
        for axis in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()] {
            for angle in [-1e-3, 1e-3] {
                let turned = Rotation3::from_axis_angle(&axis, angle) * r;
                prop_assert!(cost(&turned, &t) >= best - 1e-9);
                prop_assert!(cost(&r, &(t + axis.into_inner() * angle)) >= best - 1e-9);
            }
        }
    }
}

#[test]
fn cylinder_distance_of_a_rolled_strip() {
    let (length, radius) = (0.1, 0.1 / PI);
    let (initial, _) = patch(12, 0.0, |u, v| Vector3::new(0.05 + length * u, 0.02 * v, 0.0));
    let rolled = |sign: f64, stretch: f64| -> Points {
        let (rotation, shift) = motion();
        let place = |p: &Vector3<f64>| {
            let angle = (p.x - 0.1) / radius;
            rotation * Vector3::new(radius * angle.sin(), p.y * stretch, sign * radius * (1.0 - angle.cos())) + shift
        };
        initial.iter().map(place).collect()
    };
    for sign in [1.0, -1.0] {
        let distance = report::cylinder_distance(&initial, &rolled(sign, 1.0), radius);
        assert!(distance < 1e-13, "{distance}");
    }
    // Twice as wide: the edges stand off by half of the width, 0.01 of 0.1.
    let distance = report::cylinder_distance(&initial, &rolled(1.0, 2.0), radius);
    assert!((distance - 0.1).abs() < 1e-10, "{distance}");
    // Left flat, it is far away.
    assert!(report::cylinder_distance(&initial, &initial, radius) > 0.1);
    let mut lost = initial.clone();
    lost[3].z = f64::NAN;
    assert!(report::cylinder_distance(&initial, &lost, radius).is_nan());
    assert!(report::cylinder_distance(&initial, &initial[1..], radius).is_nan());
    assert!(report::cylinder_distance(&[], &[], radius).is_nan());
}

#[test]
fn distances_between_parallel_planes_and_beyond_edges() {
    let (a, faces) = patch(7, 0.3, |u, v| Vector3::new(u, v, 0.0));
    let (b, _) = patch(7, 0.0, |u, v| Vector3::new(u, v, 0.25));
    assert!((report::hausdorff((&a, &faces), (&b, &faces)) - 0.25).abs() < 1e-14);
    // A larger plane: its corners are farther from the smaller one than the other way round.
    let (large, large_faces) = patch(3, 0.0, |u, v| Vector3::new(3.0 * u - 1.0, 3.0 * v - 1.0, 0.0));
    assert!((report::farthest(&large, &a, &faces) - 2f64.sqrt()).abs() < 1e-14);
    assert!(report::farthest(&a, &large, &large_faces) < 1e-15);
    assert!((report::hausdorff((&a, &faces), (&large, &large_faces)) - 2f64.sqrt()).abs() < 1e-14);
    assert_eq!(report::farthest(&[], &a, &faces), 0.0);
    assert_eq!(report::farthest(&a, &a, &[]), f64::INFINITY);
    assert!(report::farthest(&[Vector3::repeat(f64::NAN)], &a, &faces).is_nan());
}

proptest! {
    /// The tree finds what trying all triangles, sampled finely, cannot beat.
    #[test]
    fn distance_is_the_least_of_all(p in prop::array::uniform3(-1.5f64..1.5), shape in 0usize..3) {
        let p = Vector3::from(p);
        let (vertices, faces) = match shape {
            0 => patch(9, 0.3, sphere(1.0)),
            1 => patch(5, 0.3, cylinder(0.5)),
            // Triangles without area.
            _ => patch(4, 0.0, |u, _| Vector3::new(u, u, u)),
        };
        let found = report::farthest(&[p], &vertices, &faces);
        let mut sampled = f64::INFINITY;
        let n = 24;
        let mut edge: f64 = 0.0;
        for [a, b, c] in faces.iter().map(|f| f.map(|v| vertices[v])) {
            edge = edge.max((b - a).norm()).max((c - a).norm()).max((c - b).norm());
            for i in 0..=n {
                for j in 0..=n - i {
                    let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                    sampled = sampled.min((a + (b - a) * s + (c - a) * t - p).norm());
                }
            }
        }
        prop_assert!(found <= sampled + 1e-12);
        prop_assert!(found >= sampled - edge / n as f64 - 1e-12);
    }
}

/// Largest error of mean and Gauss curvature at vertices at least two cells from the boundary, or at all.
fn curvature_error(n: usize, jitter: f64, exact: [f64; 2], everywhere: bool, map: impl Fn(f64, f64) -> Vector3<f64>) -> f64 {
    let (vertices, faces) = patch(n, jitter, map);
    let scale = exact[0].abs().max(exact[1].abs());
    let fitted = report::curvature(&vertices, &faces);
    let inner = |v: &usize| everywhere || [v / (n + 1), v % (n + 1)].iter().all(|i| (2..=n - 2).contains(i));
    let of = |c: &Curvature| {
        assert!((c.mean - 0.5 * (c.principal[0] + c.principal[1])).abs() < 1e-12 * scale);
        assert!((c.gauss - c.principal[0] * c.principal[1]).abs() < 1e-12 * scale * scale);
        (c.principal[0] - exact[0]).abs().max((c.principal[1] - exact[1]).abs()) / scale
    };
    (0..vertices.len()).filter(inner).map(|v| of(&fitted[v])).fold(0.0, f64::max)
}

#[test]
fn curvature_converges_at_second_order_inside_regular_meshes() {
    let error = |n: usize, everywhere: bool, jitter: f64| {
        [
            curvature_error(n, jitter, [-2.0, -2.0], everywhere, sphere(0.5)),
            curvature_error(n, jitter, [0.0, -2.0], everywhere, cylinder(0.5)),
        ]
    };
    for shape in 0..2 {
        let pairs: Vec<_> = [8, 16, 32, 64].map(|n| (1.0 / n as f64, error(n, false, 0.0)[shape])).into();
        let rate = report::rate(&pairs).unwrap();
        assert!((rate - 2.0).abs() < 0.1, "shape {shape}: {rate} {pairs:?}");
        // First order where the neighbourhood is one-sided, as at the boundary, or irregular; better only by luck.
        let pairs: Vec<_> = [8, 16, 32, 64].map(|n| (1.0 / n as f64, error(n, true, 0.2)[shape])).into();
        let rate = report::rate(&pairs).unwrap();
        assert!(rate > 0.9, "shape {shape}: {rate} {pairs:?}");
    }
}

#[test]
fn curvature_has_the_sign_of_the_normal_and_needs_neighbours() {
    let (vertices, mut faces) = patch(8, 0.1, sphere(2.0));
    let outward = report::curvature(&vertices, &faces);
    faces.iter_mut().for_each(|f| f.swap(1, 2));
    let inward = report::curvature(&vertices, &faces);
    assert!(outward[40].mean < -0.4 && inward[40].mean > 0.4);
    // One triangle and a vertex without any determine no quadric.
    let lone = report::curvature(&vertices[..4], &[[0, 1, 2]]);
    assert!(lone.iter().all(|c| c.mean.is_nan() && c.principal[0].is_nan() && c.gauss.is_nan()));
    // Nor do two rows of vertices, whatever their number.
    let (strip, faces) = patch(6, 0.0, |u, v| Vector3::new(u, v, 0.0));
    let strip_faces: Vec<_> = faces.into_iter().take(12).collect();
    assert!(report::curvature(&strip, &strip_faces)[3].mean.is_nan());
}

#[test]
fn norms_and_areas() {
    let (vertices, faces) = patch(6, 0.3, |u, v| Vector3::new(2.0 * u, v, 0.0));
    let areas = report::vertex_areas(&vertices, &faces);
    assert!((areas.iter().sum::<f64>() - 2.0).abs() < 1e-14);
    let ones = vec![3.0; areas.len()];
    assert!((report::l2_norm(&ones, &areas) - 3.0 * 2f64.sqrt()).abs() < 1e-13);
    assert!((report::mean(&ones, &areas) - 3.0).abs() < 1e-13);
    // A linear function is integrated exactly by lumping.
    let x: Vec<f64> = vertices.iter().map(|v| v.x).collect();
    assert!((report::mean(&x, &areas) - 1.0).abs() < 1e-13);
    assert!(report::mean(&[], &[]).is_nan());
}

#[test]
fn rates() {
    let pairs: Vec<_> = (1..6).map(|i| 0.5f64.powi(i)).map(|h| (h, 7.0 * h.powf(2.5))).collect();
    assert!((report::rate(&pairs).unwrap() - 2.5).abs() < 1e-12);
    assert!((report::observed_order(pairs[0], pairs[3]).unwrap() - 2.5).abs() < 1e-12);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(report::observed_order((0.1, bad), (0.05, 1.0)), None);
        assert_eq!(report::observed_order((bad, 0.1), (0.05, 1.0)), None);
    }
    assert_eq!(report::observed_order((0.1, 1.0), (0.1, 0.5)), None);
    assert_eq!(report::rate(&[(0.1, 1.0)]), None);
    assert_eq!(report::rate(&[]), None);
}

//! Distances between surfaces and waves of rims, against shapes whose answer is known.

use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use thinshell::mesh::generate::{Pattern, annulus, rectangle};
use thinshell::mesh::midpoints::{Surface as Middle, place};
use thinshell::mesh::{Mesh, Region};
use thinshell::report::{self, Surface, nodes_distance, surface_distance, waves};

type Points = Vec<Vector3<f64>>;

const LENGTH: f64 = 1.0;
const RADIUS: f64 = LENGTH / PI;

fn strip(cells: usize, curved: bool) -> Mesh {
    let mut mesh = rectangle([LENGTH, 0.2], [cells, 2], Pattern::Diagonal, 0.0, 0).unwrap();
    if curved {
        place(&mut mesh, Middle::Plane);
    }
    mesh
}

fn rolled(radius: f64) -> impl Fn(Vector3<f64>) -> Vector3<f64> {
    move |p| Vector3::new(radius * (p.x / RADIUS).sin(), p.y, radius * (p.x / RADIUS).cos())
}

fn moved(points: &[Vector3<f64>]) -> Points {
    let (rotation, shift) = (Rotation3::from_euler_angles(0.3, -1.1, 2.5), Vector3::new(3.0, -0.2, 10.0));
    points.iter().map(|p| rotation * p + shift).collect()
}

/// Hausdorff and nodal distance of the image of a mesh from present positions.
fn distances(mesh: &Mesh, map: impl Fn(Vector3<f64>) -> Vector3<f64>, now: &[Vector3<f64>], mirror: bool) -> [f64; 2] {
    let initial = mesh.nodes();
    let target: Points = initial.iter().map(|p| map(*p)).collect();
    let (exact, present) = (Surface::new(mesh, &initial, map), Surface::new(mesh, now, |p| p));
    [surface_distance((&target, &exact), (now, &present), mirror), nodes_distance(&target, now, mirror)]
}

/// The quadratic through three points of a circle misses it by this at most, for an arc of angle `theta`.
fn miss_of_a_parabola(radius: f64, theta: f64) -> f64 {
    let at = |angle: f64| (radius * angle.sin(), radius * angle.cos());
    let nodes = [at(0.0), at(0.5 * theta), at(theta)];
    let miss = |t: f64| {
        let shape = [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)];
        let (x, z) = nodes.iter().zip(shape).fold((0.0, 0.0), |(x, z), (p, n)| (x + n * p.0, z + n * p.1));
        (x.hypot(z) - radius).abs()
    };
    (0..=1000).map(|i| miss(i as f64 / 1000.0)).fold(0.0, f64::max)
}

#[test]
fn hausdorff_sees_the_curved_faces_and_nothing_of_its_sampling() {
    for cells in [4, 8, 16] {
        let theta = PI / cells as f64;
        let mesh = strip(cells, true);
        let now: Points = moved(&mesh.nodes().into_iter().map(rolled(RADIUS)).collect::<Points>());
        let [surface, nodes] = distances(&mesh, rolled(RADIUS), &now, true);
        assert!(nodes < 1e-13, "{nodes}");
        let exact = miss_of_a_parabola(RADIUS, theta);
        assert!((surface / exact - 1.0).abs() < 0.05, "{cells}: {surface} {exact}");
        // Flat faces sag by what a chord does; the middle of a chord is sampled.
        let mesh = strip(cells, false);
        let now: Points = moved(&mesh.nodes().into_iter().map(rolled(RADIUS)).collect::<Points>());
        let [surface, nodes] = distances(&mesh, rolled(RADIUS), &now, true);
        let sag = RADIUS * (1.0 - (0.5 * theta).cos());
        assert!(nodes < 1e-13 && (surface / sag - 1.0).abs() < 1e-3, "{cells}: {surface} {sag}");
    }
}

/// What is left out for the sake of speed are points that cannot be the farthest.
#[test]
fn the_farthest_of_many_points_is_the_farthest_of_each() {
    let mesh = strip(5, true);
    let surface = Surface::new(&mesh, &mesh.nodes(), rolled(RADIUS));
    let places = (0..300).map(|i| f64::from(i) / 299.0);
    for amplitude in [0.0, 1e-9, 1e-4, 0.1] {
        let near = |t: f64| rolled(RADIUS * (1.0 + amplitude * (40.0 * t).sin()))(Vector3::new(t, 0.1 + 0.1 * (77.0 * t).sin(), 0.0));
        let mut points: Points = places.clone().map(near).collect();
        let each = points.iter().map(|p| surface.farthest(std::slice::from_ref(p))).fold(0.0, f64::max);
        assert!(each > 0.5 * amplitude * RADIUS);
        assert_eq!(surface.farthest(&points), each);
        points.reverse();
        assert_eq!(surface.farthest(&points), each);
    }
}

#[test]
fn hausdorff_of_a_shape_represented_exactly_is_rounding() {
    // A parabola is a quadratic surface.
    let mesh = strip(3, true);
    let map = |p: Vector3<f64>| Vector3::new(p.x, p.y, 0.7 * p.x * p.x - 0.3 * p.x * p.y);
    let now = moved(&mesh.nodes().into_iter().map(map).collect::<Points>());
    let [surface, nodes] = distances(&mesh, map, &now, true);
    assert!(surface < 1e-13 && nodes < 1e-13, "{surface} {nodes}");
}

#[test]
fn concentric_cylinders_are_as_far_apart_as_their_radii() {
    let mesh = strip(12, true);
    let initial = mesh.nodes();
    let surfaces = [RADIUS, 1.01 * RADIUS].map(|radius| Surface::new(&mesh, &initial, rolled(radius)));
    let distance = surfaces[0].hausdorff(&surfaces[1]);
    assert!((distance / (0.01 * RADIUS) - 1.0).abs() < 1e-5, "{distance}");
    assert_eq!(distance, surfaces[1].hausdorff(&surfaces[0]));
}

#[test]
fn sliding_within_the_surface_moves_nodes_only() {
    let mesh = rectangle([1.0, 1.0], [4, 4], Pattern::Diagonal, 0.0, 0).unwrap();
    let mut now = mesh.nodes();
    let mut slide = |x: f64, by: f64| {
        let node = mesh.vertices.iter().position(|p| (p - Vector3::new(x, 0.5, 0.0)).norm() < 1e-9).unwrap();
        now[node].x += by;
    };
    slide(0.25, 0.03);
    slide(0.75, -0.03);
    let [surface, nodes] = distances(&mesh, |p| p, &now, true);
    assert!(surface < 1e-14 && (nodes - 0.03).abs() < 1e-3, "{surface} {nodes}");
}

#[test]
fn mirror_images_count_where_they_may() {
    let mesh = strip(6, true);
    let twisted = |sense: f64| move |p: Vector3<f64>| Vector3::new(p.x, (p.y - 0.1) * p.x.cos(), sense * (p.y - 0.1) * p.x.sin());
    let now = moved(&mesh.nodes().into_iter().map(twisted(-1.0)).collect::<Points>());
    let [surface, nodes] = distances(&mesh, twisted(1.0), &now, true);
    assert!(surface < 1e-5 && nodes < 1e-13, "{surface} {nodes}");
    let [surface, nodes] = distances(&mesh, twisted(1.0), &now, false);
    assert!(surface > 0.02 && nodes > 0.02, "{surface} {nodes}");
}

#[test]
fn what_is_not_finite_has_no_distance() {
    let mesh = strip(2, true);
    let mut now = mesh.nodes();
    now[5].y = f64::NAN;
    let [surface, nodes] = distances(&mesh, |p| p, &now, true);
    assert!(surface.is_nan() && nodes.is_nan());
    assert!(nodes_distance(&mesh.nodes(), &mesh.nodes()[1..], true).is_nan());
    assert_eq!(Surface::default().farthest(&now[..1]), f64::INFINITY);
    assert_eq!(Surface::default().farthest(&[]), 0.0);
}

proptest! {
    /// No point of the curved faces, sampled finely, is nearer than what was found, and one is about as near.
    #[test]
    fn distance_from_curved_faces_is_the_least(p in prop::array::uniform3(-0.6f64..0.6)) {
        let mesh = strip(2, true);
        let map = |p: Vector3<f64>| Vector3::new(p.x, p.y, 0.6 * p.x * p.x + 0.5 * p.x * p.y);
        let surface = Surface::new(&mesh, &mesh.nodes(), map);
        let p = Vector3::from(p) + Vector3::new(0.5, 0.1, 0.2);
        let found = surface.farthest(&[p]);
        let n = 400;
        let grid = (0..=n).flat_map(|i| (0..=n / 5).map(move |j| map(Vector3::new(i as f64 / n as f64, j as f64 / n as f64, 0.0))));
        let sampled = grid.map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
        prop_assert!(found <= sampled + 1e-12, "{} {}", found, sampled);
        prop_assert!(found >= sampled - 2.5 / n as f64, "{} {}", found, sampled);
    }
}

fn circle(n: usize) -> Points {
    (0..n).map(|i| TAU * i as f64 / n as f64).map(|a| Vector3::new(a.cos(), a.sin(), 0.0)).collect()
}

#[test]
fn waves_are_counted_and_measured() {
    for n in [24, 25] {
        let initial = circle(n);
        for number in 2..=n / 2 {
            let height = |i: usize, p: &Vector3<f64>| p + Vector3::z() * 0.05 * (TAU * (number * i) as f64 / n as f64).cos();
            let now: Points = initial.iter().enumerate().map(|(i, p)| height(i, p)).collect();
            let found = waves(&initial, &moved(&now)).unwrap();
            assert_eq!(found.number, number, "{n}: {found:?}");
            assert!((found.amplitude - 0.05).abs() < 1e-12, "{n}, {number}: {found:?}");
        }
        // One wave is a tilt, which the plane follows.
        let tilted: Points = initial.iter().map(|p| p + Vector3::z() * 0.05 * p.x).collect();
        for flat in [&tilted, &moved(&initial)] {
            assert_eq!(waves(&initial, flat).unwrap(), report::Waves::default());
        }
    }
}

#[test]
fn the_strongest_of_several_modes_counts() {
    let initial = circle(60);
    let now: Points = initial
        .iter()
        .map(|p| {
            let a = p.y.atan2(p.x);
            p + Vector3::z() * (0.03 * (5.0 * a + 0.4).sin() + 0.02 * (2.0 * a).cos() - 0.01 * (11.0 * a).cos())
        })
        .collect();
    let found = waves(&initial, &now).unwrap();
    assert!(found.number == 5 && (found.amplitude - 0.03).abs() < 1e-4, "{found:?}");
}

/// Along an ellipse whose points are not evenly spaced, by arc length.
#[test]
fn waves_go_by_arc_length() {
    let fine = 20_000;
    let ellipse = |a: f64| Vector3::new(2.0 * a.cos(), a.sin(), 0.0);
    let mut lengths = vec![0.0];
    for i in 0..fine {
        let step = (ellipse(TAU * (i + 1) as f64 / fine as f64) - ellipse(TAU * i as f64 / fine as f64)).norm();
        lengths.push(lengths[i] + step);
    }
    let at = |i: usize| lengths[i] / lengths[fine];
    let picked: Vec<usize> = (0..fine).step_by(fine / 200).collect();
    let initial: Points = picked.iter().map(|i| ellipse(TAU * *i as f64 / fine as f64)).collect();
    let now: Points = initial.iter().zip(&picked).map(|(p, i)| p + Vector3::z() * 0.1 * (TAU * 7.0 * at(*i)).sin()).collect();
    let found = waves(&initial, &now).unwrap();
    assert!(found.number == 7 && (found.amplitude - 0.1).abs() < 1e-3, "{found:?}");
}

#[test]
fn rims_without_a_shape_have_no_waves() {
    let initial = circle(8);
    let mut lost = initial.clone();
    lost[2].z = f64::INFINITY;
    assert_eq!(waves(&initial, &lost), None);
    assert_eq!(waves(&initial[..2], &initial[..2]), None);
    assert_eq!(waves(&[Vector3::zeros(); 5], &initial[..5]), None);
    assert_eq!(waves(&initial, &[Vector3::zeros(); 8]), Some(report::Waves::default()));
}

#[test]
fn loops_run_around_once_without_their_midpoints() {
    for curved in [false, true] {
        let mut mesh = annulus([0.5, 1.0], [2, 12], false, Pattern::Diagonal).unwrap();
        if curved {
            place(&mut mesh, Middle::Annulus);
        }
        let nodes = mesh.nodes();
        let rim = report::waves::closed_loop(&mesh.regions["outer"]).unwrap();
        assert_eq!(rim.len(), 12);
        let step = (nodes[rim[0]] - nodes[rim[1]]).norm();
        for (i, node) in rim.iter().enumerate() {
            assert!((nodes[*node].norm() - 1.0).abs() < 1e-12);
            assert!(((nodes[*node] - nodes[rim[(i + 1) % rim.len()]]).norm() - step).abs() < 1e-12);
        }
        let wavy: Points = rim.iter().map(|n| nodes[*n]).map(|p| p + Vector3::z() * 0.1 * (4.0 * p.y.atan2(p.x)).cos()).collect();
        let flat: Points = rim.iter().map(|n| nodes[*n]).collect();
        let found = waves(&flat, &wavy).unwrap();
        assert!(found.number == 4 && (found.amplitude - 0.1).abs() < 1e-12, "{found:?}");
        let both = Region::new([], mesh.regions["outer"].edges.iter().chain(&mesh.regions["inner"].edges).copied(), []);
        assert!(report::waves::closed_loop(&both).unwrap_err().contains("several closed loops"));
        let open = Region::new([], mesh.regions["outer"].edges.iter().skip(1).copied(), []);
        assert!(report::waves::closed_loop(&open).unwrap_err().contains("not a closed loop"));
        assert!(report::waves::closed_loop(&Region::default()).unwrap_err().contains("no edges"));
    }
}

#[test]
fn medians_weigh() {
    assert_eq!(report::median(&[3.0, 1.0, 2.0], &[1.0, 1.0, 1.0]), 2.0);
    assert_eq!(report::median(&[4.0, 1.0, 2.0, 3.0], &[0.1; 4]), 2.5);
    assert_eq!(report::median(&[1.0, 2.0, 3.0], &[0.2, 0.2, 0.7]), 3.0);
    assert_eq!(report::median(&[1.0, 9.0], &[1.0, 0.0]), 1.0);
    assert!(report::median(&[], &[]).is_nan() && report::median(&[f64::NAN, 1.0], &[1.0, 1.0]).is_nan());
    assert!(report::median(&[1.0], &[0.0]).is_nan());
}

#[test]
fn power_laws() {
    let pairs: Vec<_> = (1..6).map(|i| f64::from(i) * 1e-4).map(|x| (x, 7.0 * x.powf(-1.5))).collect();
    let law = report::power_law(&pairs).unwrap();
    assert!((law.exponent + 1.5).abs() < 1e-12 && (law.prefactor / 7.0 - 1.0).abs() < 1e-10 && law.misfit < 1e-12, "{law:?}");
    // Two of three points on the law of exponent 1, the middle one 10 % above: the line lies between.
    let law = report::power_law(&[(1.0, 1.0), (2.0, 2.2), (4.0, 4.0)]).unwrap();
    assert!((law.exponent - 1.0).abs() < 1e-12 && (law.misfit - (1.1f64.powf(2.0 / 3.0) - 1.0)).abs() < 1e-12, "{law:?}");
    assert_eq!(report::power_law(&[(1.0, 1.0), (2.0, -1.0)]), None);
    assert_eq!(report::power_law(&[(1.0, 1.0), (1.0, 2.0)]), None);
}

//! The quadratic element: derivatives, an independent implementation's numbers, invariance, convergence, and published benchmarks.

use crate::finite_differences::{bind, compare, crumple, dense, patch};
use nalgebra::{DMatrix, Matrix2, Rotation3, Vector3};
use serde::Deserialize;
use std::f64::consts::PI;
use thinshell::mesh::generate::{Pattern as Cells, rectangle};
use thinshell::mesh::{Mesh, Topology};
use thinshell::report::cylinder_distance;
use thinshell::shell::rest::Forms;
use thinshell::shell::{Director, Koiter, Material, Measure, QuadraticFree, Shell};
use thinshell::solve::{Newton, Settings};
use thinshell::sparse::{Curvature, Numbering, Pattern, Potential, System};

type QuadraticShell = Koiter<QuadraticFree, 24, 3>;

/// Nodes of the element: vertices and `place` of the middles of straight edges.
fn nodes(mesh: &Mesh, topology: &Topology, place: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<Vector3<f64>> {
    let midpoints = topology.edges.iter().map(|[a, b]| place(0.5 * (mesh.vertices[*a] + mesh.vertices[*b])));
    mesh.vertices.iter().copied().chain(midpoints).collect()
}

/// Unknowns at given nodes with all angles zero.
fn at_nodes(nodes: &[Vector3<f64>], unknowns: usize) -> Vec<f64> {
    let mut x: Vec<f64> = nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(unknowns, 0.0);
    x
}

fn to_forms(shell: &dyn Shell, x: &[f64]) -> Vec<Forms> {
    shell.forms(x).iter().map(|e| Forms { a: [e[0], e[1], e[2]], b: [e[3], e[4], e[5]] }).collect()
}

#[test]
fn derivatives() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let nodes = nodes(&mesh, &topology, |p| p + Vector3::new(0.01, -0.02, 0.05));
    let mut supports = vec![Director::Free; topology.edges.len()];
    supports[2] = Director::Held(Vector3::new(0.3, 0.2, 1.0));
    for (measure, viscosity) in [(Measure::Sin, None), (Measure::Tan, None), (Measure::Angle, None), (Measure::Tan, Some(0.3))] {
        let element = QuadraticFree::new(&mesh, &topology, &nodes[mesh.vertices.len()..], measure, &supports);
        let (x, rest, materials) = crumple(&nodes, 3 * nodes.len() + 2 * topology.edges.len(), mesh.faces.len(), 3, 0.06);
        let mut shell = Koiter::new(element, materials, viscosity);
        shell.set_rest(&rest);
        let start: Vec<f64> = x.iter().enumerate().map(|(i, x)| x + 0.01 * (i as f64).sin()).collect();
        shell.start_step(&start, 0.2);
        compare(&mut shell, &x);
    }
}

#[derive(Deserialize)]
struct Reference {
    youngs_modulus: f64,
    poissons_ratio: f64,
    thickness: f64,
    measure: String,
    nodes: Vec<[f64; 3]>,
    angles: Vec<f64>,
    directors: Vec<[f64; 3]>,
    rest: Vec<[f64; 6]>,
    expected: Expected,
}

#[derive(Deserialize)]
struct Expected {
    energy: f64,
    forms: Vec<[f64; 6]>,
    gradient: Vec<f64>,
    hessian: Vec<Vec<f64>>,
}

#[test]
fn one_face_agrees_with_an_independent_implementation() {
    let reference: Reference = toml::from_str(include_str!("../../data/reference/quadratic_face.toml")).unwrap();
    assert_eq!(reference.measure, "tan");
    let nodes: Vec<Vector3<f64>> = reference.nodes.iter().map(|p| Vector3::from(*p)).collect();
    let mesh = Mesh { vertices: nodes[..3].to_vec(), faces: vec![[0, 1, 2]], ..Mesh::default() };
    let topology = Topology::new(&mesh.faces);
    let element = QuadraticFree::new(&mesh, &topology, &nodes[3..], Measure::Tan, &[Director::Free; 3]);
    let material =
        Material { thickness: reference.thickness, youngs_modulus: reference.youngs_modulus, poissons_ratio: reference.poissons_ratio };
    let mut shell: QuadraticShell = Koiter::new(element, vec![material], None);
    shell.set_rest(&reference.rest.iter().map(|r| Forms { a: [r[0], r[1], r[2]], b: [r[3], r[4], r[5]] }).collect::<Vec<_>>());
    shell.set_directors(&reference.directors.iter().map(|d| Vector3::from(*d)).collect::<Vec<_>>());
    let mut x = at_nodes(&nodes, 18);
    x.extend(&reference.angles);
    let close = |name: &str, computed: f64, expected: f64, scale: f64| {
        assert!((computed - expected).abs() < 1e-13 * scale, "{name}: {computed} instead of {expected}");
    };
    for (computed, expected) in shell.forms(&x).iter().flatten().zip(reference.expected.forms.iter().flatten()) {
        close("form", *computed, *expected, 1.0);
    }
    let (pattern, mut system) = bind(&mut shell, 24);
    shell.restart(&x);
    let energy = shell.assemble(&x, Curvature::Mixed, &mut system);
    close("energy", energy, reference.expected.energy, energy);
    for (computed, expected) in system.gradient.iter().zip(&reference.expected.gradient) {
        close("gradient", *computed, *expected, 1.0);
    }
    for (computed, expected) in dense(&pattern, &system.matrix).iter().flatten().zip(reference.expected.hessian.iter().flatten()) {
        close("Hessian", *computed, *expected, 10.0);
    }
}

#[test]
fn reframing_changes_nothing_but_the_angles() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let nodes = nodes(&mesh, &topology, |p| p);
    let element = QuadraticFree::new(&mesh, &topology, &nodes[9..], Measure::Tan, &vec![Director::Free; topology.edges.len()]);
    let (mut x, rest, materials) = crumple(&nodes, 3 * nodes.len() + 2 * topology.edges.len(), mesh.faces.len(), 3, 0.06);
    let mut shell = Koiter::new(element, materials, None);
    shell.set_rest(&rest);
    let before = shell.energy(&x);
    shell.prepare(&mut x);
    let after = shell.energy(&x);
    assert!(before > 0.0 && (before - after).abs() < 1e-12 * before, "{before} {after}");
    assert!(x[3 * nodes.len()..].iter().all(|phi| *phi == 0.0));
}

/// What descent on the energy relies on, at a state in compression.
#[test]
fn the_projected_hessian_is_positive_semidefinite() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let nodes = nodes(&mesh, &topology, |p| p);
    let element = QuadraticFree::new(&mesh, &topology, &nodes[9..], Measure::Tan, &vec![Director::Free; topology.edges.len()]);
    let (x, mut rest, materials) = crumple(&nodes, 3 * nodes.len() + 2 * topology.edges.len(), mesh.faces.len(), 3, 0.06);
    rest.iter_mut().for_each(|r| r.a = [2.0, 0.5, 1.0]);
    let mut shell = Koiter::new(element, materials, None);
    shell.set_rest(&rest);
    let (pattern, mut system) = bind(&mut shell, x.len());
    shell.restart(&x);
    let mut smallest = |curvature| {
        system.clear();
        shell.assemble(&x, curvature, &mut system);
        let rows = dense(&pattern, &system.matrix);
        let values = DMatrix::from_fn(x.len(), x.len(), |i, j| rows[i][j]).symmetric_eigenvalues();
        values.min() / values.max()
    };
    assert!(smallest(Curvature::Mixed) < -1e-3);
    assert!(smallest(Curvature::Projected) > -1e-13);
}

/// A jittered square of `cells` by `cells` cells and half extent 0.5, bent by `surface`, with the element's nodes on the surface.
fn bent(cells: usize, surface: &dyn Fn(f64, f64) -> Vector3<f64>) -> (Mesh, Vec<Vector3<f64>>, QuadraticShell) {
    let mut mesh = rectangle([1.0, 1.0], [cells, cells], Cells::Alternating, 0.15, 3).unwrap();
    let topology = Topology::new(&mesh.faces);
    let place = |p: Vector3<f64>| surface(p.x - 0.5, p.y - 0.5);
    let nodes: Vec<_> = nodes(&mesh, &topology, |p| p).into_iter().map(place).collect();
    mesh.vertices = nodes[..mesh.vertices.len()].to_vec();
    let element =
        QuadraticFree::new(&mesh, &topology, &nodes[mesh.vertices.len()..], Measure::Tan, &vec![Director::Free; topology.edges.len()]);
    let materials = vec![Material { thickness: 1e-3, youngs_modulus: 1e9, poissons_ratio: 0.3 }; mesh.faces.len()];
    let shell = Koiter::new(element, materials, None);
    (mesh, nodes, shell)
}

fn sphere(x: f64, y: f64) -> Vector3<f64> {
    Vector3::new(x, y, 1.0).normalize()
}

fn cylinder(x: f64, y: f64) -> Vector3<f64> {
    Vector3::new(x.sin(), y, x.cos())
}

#[test]
fn a_curved_shell_starts_without_strain_and_moves_rigidly_for_nothing() {
    for surface in [sphere, cylinder] {
        let (_, nodes, mut shell) = bent(4, &surface);
        let unknowns = shell.unknowns();
        let x = at_nodes(&nodes, unknowns);
        let rest = to_forms(&shell, &x);
        shell.set_rest(&rest);
        let (_, mut system) = bind(&mut shell, unknowns);
        assert_eq!(shell.assemble(&x, Curvature::Projected, &mut system), 0.0);
        assert!(system.gradient.iter().all(|g| *g == 0.0));
        let stretched: Vec<f64> = x.iter().map(|x| 1.01 * x).collect();
        let scale = shell.energies(&stretched);
        assert!(scale.iter().all(|e| *e > 0.0));
        let rotation = Rotation3::new(Vector3::new(0.7, -1.9, 0.8));
        let moved: Vec<_> = nodes.iter().map(|p| rotation * p + Vector3::new(3.0, -2.0, 1.0)).collect();
        let directors: Vec<_> = shell.directors().iter().map(|d| rotation * d).collect();
        shell.set_directors(&directors);
        let energies = shell.energies(&at_nodes(&moved, unknowns));
        for i in 0..2 {
            assert!(energies[i] < 1e-12 * scale[i], "{energies:?} against {scale:?}");
        }
    }
}

/// Errors of the initial forms: area-weighted root mean square of the difference of the principal curvatures from the `exact` ones, and
/// error of the mean of their half sum.
fn curvature_errors(cells: usize, surface: &dyn Fn(f64, f64) -> Vector3<f64>, exact: [f64; 2]) -> [f64; 2] {
    let (_, nodes, shell) = bent(cells, surface);
    let (mut square, mut bend, mut area) = (0.0, 0.0, 0.0);
    for form in to_forms(&shell, &at_nodes(&nodes, shell.unknowns())) {
        let [a, b] = [form.a, form.b].map(|m| Matrix2::new(m[0], m[1], m[1], m[2]));
        let shape = a.try_inverse().unwrap() * b;
        let (mean, gauss) = (0.5 * shape.trace(), shape.determinant());
        let radius = (mean * mean - gauss).max(0.0).sqrt();
        let weight = a.determinant().sqrt();
        square += weight * ((mean - radius - exact[0]).powi(2) + (mean + radius - exact[1]).powi(2));
        bend += weight * mean;
        area += weight;
    }
    [(square / area).sqrt(), (bend / area - 0.5 * (exact[0] + exact[1])).abs()]
}

/// At the order of the second derivatives of interpolated positions, and on average one order better, as the hinges see to. A cylinder,
/// which is straight in one direction, gains an order more. Outward normals: negative curvatures.
#[test]
fn initial_curvatures_converge() {
    let cases = [(sphere as fn(f64, f64) -> _, [-1.0, -1.0], [1.0, 2.0]), (cylinder, [-1.0, 0.0], [2.0, 3.0])];
    for (surface, exact, orders) in cases {
        let errors = [8, 16, 32].map(|cells| curvature_errors(cells, &surface, exact));
        for (m, order) in orders.into_iter().enumerate() {
            let rate = 0.5 * (errors[0][m] / errors[2][m]).log2();
            assert!(rate > order - 0.1, "{m}: {errors:?}, rate {rate}");
        }
    }
}

/// Bending energy per area of nodes on the exact surface (radius 1) over the exact one, less 1, with flat rest curvature: inner directors
/// relaxed, those of the boundary along the surface's normal, for a free boundary would relax its moment.
fn energy_error(cells: usize, surface: &dyn Fn(f64, f64) -> Vector3<f64>, normal: fn(Vector3<f64>) -> Vector3<f64>, exact: f64) -> f64 {
    let (mesh, nodes, mut shell) = bent(cells, surface);
    let topology = Topology::new(&mesh.faces);
    let mut x = at_nodes(&nodes, shell.unknowns());
    let rest: Vec<Forms> = to_forms(&shell, &x).iter().map(|f| Forms { b: [0.0; 3], ..*f }).collect();
    shell.set_rest(&rest);
    let mut directors = shell.directors().to_vec();
    let lengths = 3 * nodes.len();
    let mut held = vec![false; shell.unknowns()];
    held[..lengths].fill(true);
    for e in (0..topology.edges.len()).filter(|e| topology.is_boundary(*e)) {
        let [a, b] = topology.edges[e].map(|v| nodes[v]);
        let middle = nodes[mesh.vertices.len() + e];
        for (g, t) in thinshell::math::quadrature::GAUSS_2.into_iter().enumerate() {
            let tangent = (a * (4.0 * t - 3.0) + b * (4.0 * t - 1.0) + middle * (4.0 - 8.0 * t)).normalize();
            let n = normal(a * ((1.0 - t) * (1.0 - 2.0 * t)) + b * (t * (2.0 * t - 1.0)) + middle * (4.0 * t * (1.0 - t)));
            directors[2 * e + g] = (n - tangent * n.dot(&tangent)).normalize();
            held[lengths + 2 * e + g] = true;
        }
    }
    shell.set_directors(&directors);
    let settings = Settings { lengths, diameter: 1.0, tolerance: 1e-12, max_iterations: 30 };
    let mut newton = Newton::new(&mut [&mut shell], &held, settings).unwrap();
    shell.restart(&x);
    newton.solve(&mut [&mut shell], &mut x, &[]).unwrap();
    let area: f64 = rest.iter().map(|f| (f.a[0] * f.a[2] - f.a[1] * f.a[1]).sqrt() / 6.0).sum();
    (shell.energies(&x)[1] / area / exact - 1.0).abs()
}

#[test]
fn energies_of_exact_shapes_converge() {
    let material = Material { thickness: 1e-3, youngs_modulus: 1e9, poissons_ratio: 0.3 };
    let [alpha, beta] = material.lame();
    let bending = material.thickness.powi(3) / 12.0;
    let cases = [
        ("sphere", sphere as fn(f64, f64) -> _, (|p| p.normalize()) as fn(Vector3<f64>) -> _, 2.0 * (alpha + beta)),
        ("cylinder", cylinder, |p| Vector3::new(p.x, 0.0, p.z).normalize(), 0.5 * alpha + beta),
    ];
    for (name, surface, normal, exact) in cases {
        let errors = [4, 8, 16].map(|cells| energy_error(cells, &surface, normal, bending * exact));
        let rate = 0.5 * (errors[0] / errors[2]).log2();
        println!("{name}: {errors:?}, rate {rate}");
        assert!(rate > 2.9 && errors[2] < 1e-5, "{name}: {errors:?}, rate {rate}");
    }
}

/// A constant force on nodes, times a factor.
struct NodalForces {
    forces: Vec<f64>,
    factor: f64,
    numbering: Option<Numbering>,
}

impl Potential for NodalForces {
    fn stencils(&self, _visit: &mut dyn FnMut(&[usize])) {}

    fn bind(&mut self, numbering: &Numbering, _pattern: &Pattern) {
        self.numbering = Some(numbering.clone());
    }

    fn energy(&self, x: &[f64]) -> f64 {
        -self.factor * self.forces.iter().zip(x).map(|(f, x)| f * x).sum::<f64>()
    }

    fn assemble(&mut self, x: &[f64], _curvature: Curvature, into: &mut System) -> f64 {
        self.gradient(x, into)
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        for (i, &unknown) in self.numbering.as_ref().unwrap().unknowns().iter().enumerate() {
            into.gradient[i] -= self.factor * self.forces[unknown as usize];
        }
        self.energy(x)
    }
}

/// Distance from the half cylinder into which a strip of `cells` curls, over its length, and the factorisations that it took.
fn curl(cells: [usize; 2], thickness: f64) -> (f64, u64) {
    let (length, radius, steps) = (0.1, 0.1 / PI, 3);
    let mesh = rectangle([length, 0.02], cells, Cells::Diagonal, 0.25, 1).unwrap();
    let topology = Topology::new(&mesh.faces);
    let initial = nodes(&mesh, &topology, |p| p);
    let free = vec![Director::Free; topology.edges.len()];
    let element = QuadraticFree::new(&mesh, &topology, &initial[mesh.vertices.len()..], Measure::Tan, &free);
    let material = Material { thickness, youngs_modulus: 1e9, poissons_ratio: 0.3 };
    let mut shell: QuadraticShell = Koiter::new(element, vec![material; mesh.faces.len()], None);
    let mut x = at_nodes(&initial, shell.unknowns());
    let flat = to_forms(&shell, &x);
    let rolled: Vec<Forms> = flat
        .iter()
        .enumerate()
        .map(|(point, form)| {
            let [v0, v1, v2] = mesh.faces[point / 3].map(|v| mesh.vertices[v].x);
            let (p, q) = (v1 - v0, v2 - v0);
            Forms { a: form.a, b: [p * p, p * q, q * q].map(|v| v / radius) }
        })
        .collect();
    let at = |i: usize, j: usize| 3 * (i * (cells[1] + 1) + j);
    let (centre, side, next) = (at(cells[0] / 2, cells[1] / 2), at(cells[0] / 2, 0), at(cells[0] / 2 + 1, cells[1] / 2));
    let mut held = vec![false; x.len()];
    for unknown in [centre, centre + 1, centre + 2, side, side + 2, next + 2] {
        held[unknown] = true;
    }
    let settings = Settings { lengths: 3 * initial.len(), diameter: length, tolerance: 1e-9 * length, max_iterations: 40 };
    shell.set_rest(&flat);
    shell.restart(&x);
    let mut newton = Newton::new(&mut [&mut shell], &held, settings).unwrap();
    for step in 1..=steps {
        let share = step as f64 / steps as f64;
        shell.set_rest(&flat.iter().zip(&rolled).map(|(f, r)| f.mix(r, share)).collect::<Vec<_>>());
        newton.solve(&mut [&mut shell], &mut x, &[]).unwrap();
    }
    let now: Vec<_> = x[..3 * initial.len()].chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
    (cylinder_distance(&initial, &now, radius), newton.counters().factorizations)
}

/// An irregular strip curls to a half cylinder whatever its thickness: no membrane locking.
#[test]
fn a_thin_strip_curls_without_locking() {
    for thickness in [1e-3, 1e-5] {
        let (coarse, coarse_work) = curl([10, 2], thickness);
        let (fine, fine_work) = curl([20, 4], thickness);
        assert!(coarse <= 5e-5 && fine <= 4e-6, "{coarse:e} {fine:e}");
        assert!((coarse / fine).log2() > 3.0);
        assert!(coarse_work <= 25 && fine_work <= 25, "{coarse_work} {fine_work} factorisations");
    }
}

/// Cantilever with a shear force at its end (Sze, Liu & Lo 2004, case 1): displacements of its tip along and across [m], factorisations
/// and unknowns.
fn cantilever(cells: [usize; 2]) -> ([f64; 2], u64, usize) {
    let mesh = rectangle([10.0, 1.0], cells, Cells::Diagonal, 0.0, 0).unwrap();
    let topology = Topology::new(&mesh.faces);
    let initial = nodes(&mesh, &topology, |p| p);
    let vertices = mesh.vertices.len();
    let on = |p: &Vector3<f64>, x: f64| (p.x - x).abs() < 1e-9;
    let clamped: Vec<bool> = initial[vertices..].iter().map(|m| on(m, 0.0)).collect();
    let supports: Vec<Director> = clamped.iter().map(|c| if *c { Director::Held(Vector3::z()) } else { Director::Free }).collect();
    let element = QuadraticFree::new(&mesh, &topology, &initial[vertices..], Measure::Tan, &supports);
    let material = Material { thickness: 0.1, youngs_modulus: 1.2e6, poissons_ratio: 0.0 };
    let mut shell: QuadraticShell = Koiter::new(element, vec![material; mesh.faces.len()], None);
    let mut x = at_nodes(&initial, shell.unknowns());
    let rest = to_forms(&shell, &x);
    shell.set_rest(&rest);
    let lengths = 3 * initial.len();
    let held: Vec<bool> = (0..x.len()).map(|i| if i < lengths { on(&initial[i / 3], 0.0) } else { clamped[(i - lengths) / 2] }).collect();
    // The load of 4 N on the edges at the end, by the integrals of the shape functions: 1/6, 1/6, 4/6 of an edge's part.
    let mut forces = vec![0.0; x.len()];
    for (e, edge) in topology.edges.iter().enumerate().filter(|(e, _)| on(&initial[vertices + e], 10.0)) {
        let part = 4.0 / cells[1] as f64;
        for (node, share) in [(edge[0], 1.0), (edge[1], 1.0), (vertices + e, 4.0)] {
            forces[3 * node + 2] += part * share / 6.0;
        }
    }
    assert!((forces.iter().sum::<f64>() - 4.0).abs() < 1e-12);
    let mut load = NodalForces { forces, factor: 0.0, numbering: None };
    let settings = Settings { lengths, diameter: 10.0, tolerance: 1e-8, max_iterations: 40 };
    let mut newton = Newton::new(&mut [&mut shell, &mut load], &held, settings).unwrap();
    for step in 1..=4 {
        load.factor = 0.25 * step as f64;
        newton.solve(&mut [&mut shell, &mut load], &mut x, &[]).unwrap();
    }
    let tip = initial.iter().position(|p| on(p, 10.0) && (p.y - 0.5).abs() < 1e-9).unwrap();
    ([initial[tip].x - x[3 * tip], x[3 * tip + 2]], newton.counters().factorizations, newton.free())
}

/// The values, which include the stretch that the elastica leaves out (3.28941, 6.69964), are those of Neunteufel & Schoeberl's element in
/// NGSolve.
#[test]
fn a_cantilever_bends_like_the_elastica() {
    let ([u, w], factorizations, free) = cantilever([16, 1]);
    assert_eq!(free, 416);
    assert!((u - 3.28949).abs() < 1e-4 * u && (w - 6.70000).abs() < 1e-4 * w, "{u} {w}");
    assert!(factorizations <= 22, "{factorizations}");
    let ([fine_u, fine_w], _, _) = cantilever([32, 1]);
    assert!((u - fine_u).abs() < 3e-5 && (w - fine_w).abs() < 1e-5, "{u} {fine_u}, {w} {fine_w}");
}

/// Hemisphere with a hole, pulled and pushed at its rim (Sze, Liu & Lo 2004, case 4: 4.067, 8.178), a quarter of it: a curved shell whose
/// directors are held in two planes of symmetry. The values are those of the independent implementation that `quadratic_face.toml` is
/// from, on the same mesh.
#[test]
fn a_hemisphere_is_pulled_open() {
    let sphere = |p: Vector3<f64>| 10.0 * Vector3::new(p.x.cos() * p.y.cos(), p.x.sin() * p.y.cos(), p.y.sin());
    let cells = 8;
    let mut mesh = rectangle([0.5 * PI, 0.4 * PI], [cells, cells], Cells::Alternating, 0.0, 0).unwrap();
    let topology = Topology::new(&mesh.faces);
    let initial: Vec<_> = nodes(&mesh, &topology, |p| p).into_iter().map(sphere).collect();
    let vertices = mesh.vertices.len();
    mesh.vertices = initial[..vertices].to_vec();
    let in_plane = |p: &Vector3<f64>, axis: usize| p[axis].abs() < 1e-9;
    let in_planes: Vec<bool> = initial[vertices..].iter().map(|m| in_plane(m, 0) || in_plane(m, 1)).collect();
    let supports: Vec<Director> =
        initial[vertices..].iter().zip(&in_planes).map(|(m, held)| if *held { Director::Held(*m) } else { Director::Free }).collect();
    let element = QuadraticFree::new(&mesh, &topology, &initial[vertices..], Measure::Tan, &supports);
    let material = Material { thickness: 0.04, youngs_modulus: 6.825e7, poissons_ratio: 0.3 };
    let mut shell: QuadraticShell = Koiter::new(element, vec![material; mesh.faces.len()], None);
    let mut x = at_nodes(&initial, shell.unknowns());
    let rest = to_forms(&shell, &x);
    shell.set_rest(&rest);
    let (lengths, pulled, pushed) = (3 * initial.len(), 0, cells * (cells + 1));
    let mut held: Vec<bool> = (0..x.len())
        .map(|i| if i < lengths { i % 3 < 2 && in_plane(&initial[i / 3], i % 3) } else { in_planes[(i - lengths) / 2] })
        .collect();
    held[3 * pulled + 2] = true;
    let mut forces = vec![0.0; x.len()];
    (forces[3 * pulled], forces[3 * pushed + 1]) = (200.0, -200.0);
    let mut load = NodalForces { forces, factor: 0.0, numbering: None };
    let settings = Settings { lengths, diameter: 17.0, tolerance: 2e-8, max_iterations: 40 };
    let mut newton = Newton::new(&mut [&mut shell, &mut load], &held, settings).unwrap();
    for step in 1..=10 {
        load.factor = 0.1 * step as f64;
        newton.solve(&mut [&mut shell, &mut load], &mut x, &[]).unwrap();
    }
    let (out, inwards) = (x[3 * pulled] - initial[pulled].x, initial[pushed].y - x[3 * pushed + 1]);
    let work = newton.counters().factorizations;
    assert_eq!(newton.free(), 1216);
    assert!((out - 4.04703).abs() < 1e-4 && (inwards - 8.07580).abs() < 1e-4, "{out} {inwards}");
    assert!(work <= 55, "{work} factorisations");
}

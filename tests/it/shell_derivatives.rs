//! Gradients and Hessians against finite differences, after a check that they are not zero.

use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use thinshell::mesh::{Mesh, Topology};
use thinshell::shell::rest::Forms;
use thinshell::shell::{Director, Inertia, Inertial, Koiter, LinearAverage, LinearFree, MassKind, Material, Measure, Shell};
use thinshell::sparse::{Curvature, Numbering, Pattern, Potential, System};

/// A crumpled patch of eight faces with an inner vertex, edge lengths about 1.
fn patch() -> Mesh {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut mesh = Mesh::default();
    for i in 0..3 {
        for j in 0..3 {
            let mut shift = || rng.random_range(-0.15..0.15);
            mesh.vertices.push(Vector3::new(i as f64 + shift(), j as f64 + shift(), 2.0 * shift()));
        }
    }
    for i in 0..2 {
        for j in 0..2 {
            let (a, b) = (3 * i + j, 3 * i + j + 3);
            mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

fn bind(potential: &mut dyn Potential, unknowns: usize) -> (Pattern, System) {
    let numbering = Numbering::new(&vec![false; unknowns]);
    let pattern = Pattern::new(&numbering, &mut |visit| potential.stencils(visit)).unwrap();
    potential.bind(&numbering, &pattern);
    let system = System::new(&pattern);
    (pattern, system)
}

fn dense(pattern: &Pattern, values: &[f64]) -> Vec<Vec<f64>> {
    let n = pattern.len();
    let mut m = vec![vec![0.0; n]; n];
    for j in 0..n {
        for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
            let i = pattern.row[k] as usize;
            m[i][j] = values[k];
            m[j][i] = values[k];
        }
    }
    m
}

/// Compares gradient with energy and Hessian with gradient by central differences at `x`.
fn compare(potential: &mut dyn Potential, x: &[f64]) {
    let n = x.len();
    let (pattern, mut system) = bind(potential, n);
    potential.restart(x);
    let energy = potential.assemble(x, Curvature::Mixed, &mut system);
    assert!(energy > 0.0 && (energy - potential.energy(x)).abs() <= 1e-13 * energy);
    let (gradient, hessian) = (system.gradient.clone(), dense(&pattern, &system.matrix));
    let scale = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
    let stiff = hessian.iter().flatten().fold(0.0f64, |m, g| m.max(g.abs()));
    assert!(gradient.iter().all(|g| g.abs() > 1e-9 * scale), "a component of the gradient vanishes");
    let step = 1e-6;
    for i in 0..n {
        let mut shifted = x.to_vec();
        let mut at = |d: f64| {
            shifted[i] = x[i] + d;
            system.clear();
            let e = potential.gradient(&shifted, &mut system);
            (e, system.gradient.clone())
        };
        let ((e1, g1), (e2, g2)) = (at(step), at(-step));
        let difference = (e1 - e2) / (2.0 * step);
        assert!((difference - gradient[i]).abs() < 2e-8 * scale, "gradient {i}: {difference} {}", gradient[i]);
        for j in 0..n {
            let difference = (g1[j] - g2[j]) / (2.0 * step);
            assert!((difference - hessian[i][j]).abs() < 1e-8 * stiff, "Hessian {i} {j}: {difference} {}", hessian[i][j]);
        }
        assert!(hessian[i].iter().any(|h| h.abs() > 1e-6 * stiff));
    }
}

/// A state away from the mesh, with angles away from zero, and rest forms that are those of nothing in particular.
fn crumple(mesh: &Mesh, unknowns: usize) -> (Vec<f64>, Vec<Forms>, Vec<Material>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut x: Vec<f64> = mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(unknowns, 0.0);
    x.iter_mut().for_each(|x| *x += rng.random_range(-0.2..0.2));
    let rest = mesh
        .faces
        .iter()
        .map(|_| Forms { a: [1.1, rng.random_range(0.2..0.5), 1.3], b: [0.1, rng.random_range(-0.3..0.3), -0.2] })
        .collect();
    let materials =
        mesh.faces.iter().map(|_| Material { thickness: rng.random_range(0.5..1.0), youngs_modulus: 3.0, poissons_ratio: 0.3 }).collect();
    (x, rest, materials)
}

#[test]
fn free_directors() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    for measure in [Measure::Sin, Measure::Tan] {
        for viscosity in [None, Some(0.3)] {
            let mut supports = vec![Director::Free; topology.edges.len()];
            supports[2] = Director::Held(Vector3::new(0.3, 0.2, 1.0));
            let element = LinearFree::new(&mesh, &topology, measure, &supports);
            let (x, rest, materials) = crumple(&mesh, 3 * mesh.vertices.len() + topology.edges.len());
            let mut shell = Koiter::new(element, materials, viscosity);
            shell.set_rest(&rest);
            let start: Vec<f64> = x.iter().enumerate().map(|(i, x)| x + 0.01 * (i as f64).sin()).collect();
            shell.start_step(&start, 0.2);
            compare(&mut shell, &x);
        }
    }
}

#[test]
fn averaged_normals() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let mut supports = vec![Director::Free; topology.edges.len()];
    let held = (0..topology.edges.len()).find(|e| topology.is_boundary(*e)).unwrap();
    supports[held] = Director::Held(Vector3::new(0.3, 0.2, 1.0));
    for supports in [vec![Director::Free; topology.edges.len()], supports] {
        let element = LinearAverage::new(&mesh, &topology, &supports);
        let (x, rest, materials) = crumple(&mesh, 3 * mesh.vertices.len());
        let mut shell = Koiter::new(element, materials, None);
        shell.set_rest(&rest);
        compare(&mut shell, &x);
    }
}

#[test]
fn inertia() {
    let mesh = patch();
    for kind in [MassKind::Consistent, MassKind::Lumped] {
        let mut inertia: Inertia<3, 9> = Inertia::new(mesh.faces.clone(), vec![kind.linear(0.7); mesh.faces.len()]);
        let (x, _, _) = crumple(&mesh, 3 * mesh.vertices.len());
        inertia.start_step(&vec![0.1; x.len()], &vec![0.3; x.len()], 0.5);
        compare(&mut inertia, &x);
    }
}

#[test]
fn reframing_changes_nothing_but_the_angles() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let element = LinearFree::new(&mesh, &topology, Measure::Tan, &vec![Director::Free; topology.edges.len()]);
    let (mut x, rest, materials) = crumple(&mesh, 3 * mesh.vertices.len() + topology.edges.len());
    let mut shell = Koiter::new(element, materials, None);
    shell.set_rest(&rest);
    let before = shell.energy(&x);
    shell.prepare(&mut x);
    let after = shell.energy(&x);
    assert!(before > 0.0 && (before - after).abs() < 1e-12 * before, "{before} {after}");
    assert!(x[3 * mesh.vertices.len()..].iter().all(|phi| *phi == 0.0));
}

/// `free-sin` with directors halfway between the face normals is `average`, on inner edges (PHYSICS A1).
#[test]
fn free_sin_at_mean_normals_is_average() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let free = vec![Director::Free; topology.edges.len()];
    let (_, _, materials) = crumple(&mesh, 0);
    let x: Vec<f64> = mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    let average = Koiter::new(LinearAverage::new(&mesh, &topology, &free), materials.clone(), None).forms(&x);
    let mut with_angles = x.clone();
    with_angles.resize(x.len() + topology.edges.len(), 0.0);
    let sin = Koiter::new(LinearFree::new(&mesh, &topology, Measure::Sin, &free), materials, None).forms(&with_angles);
    for (p, q) in average.iter().zip(&sin) {
        assert!(p[3..].iter().any(|b| b.abs() > 1e-3));
        for i in 0..6 {
            assert!((p[i] - q[i]).abs() < 1e-13, "{p:?} {q:?}");
        }
    }
}

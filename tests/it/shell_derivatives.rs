//! Gradients and Hessians of the linear elements and of inertia against finite differences, after a check that they are not zero.

use crate::finite_differences::{compare, crumple, patch};
use nalgebra::Vector3;
use thinshell::mesh::Topology;
use thinshell::shell::{Director, Inertia, Inertial, Koiter, LinearAverage, LinearFree, MassKind, Measure, Shell};
use thinshell::sparse::Potential;

#[test]
fn free_directors() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    for measure in [Measure::Sin, Measure::Tan, Measure::Angle] {
        for viscosity in [None, Some(0.3)] {
            let mut supports = vec![Director::Free; topology.edges.len()];
            supports[2] = Director::Held(Vector3::new(0.3, 0.2, 1.0));
            let element = LinearFree::new(&mesh, &topology, measure, &supports);
            let (x, rest, materials) = crumple(&mesh.vertices, 3 * mesh.vertices.len() + topology.edges.len(), mesh.faces.len(), 1, 0.2);
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
        let (x, rest, materials) = crumple(&mesh.vertices, 3 * mesh.vertices.len(), mesh.faces.len(), 1, 0.2);
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
        let (x, _, _) = crumple(&mesh.vertices, 3 * mesh.vertices.len(), mesh.faces.len(), 1, 0.2);
        inertia.start_step(&vec![0.1; x.len()], &vec![0.3; x.len()], 0.5);
        compare(&mut inertia, &x);
    }
}

#[test]
fn reframing_changes_nothing_but_the_angles() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let element = LinearFree::new(&mesh, &topology, Measure::Tan, &vec![Director::Free; topology.edges.len()]);
    let (mut x, rest, materials) = crumple(&mesh.vertices, 3 * mesh.vertices.len() + topology.edges.len(), mesh.faces.len(), 1, 0.2);
    let mut shell = Koiter::new(element, materials, None);
    shell.set_rest(&rest);
    let before = shell.energy(&x);
    shell.prepare(&mut x);
    let after = shell.energy(&x);
    assert!(before > 0.0 && (before - after).abs() < 1e-12 * before, "{before} {after}");
    assert!(x[3 * mesh.vertices.len()..].iter().all(|phi| *phi == 0.0));
}

/// `free-sin` with directors halfway between the face normals is `average`, on inner edges.
#[test]
fn free_sin_at_mean_normals_is_average() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let free = vec![Director::Free; topology.edges.len()];
    let (_, _, materials) = crumple(&mesh.vertices, 0, mesh.faces.len(), 1, 0.2);
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

//! A disturbance of the first state: the way off an unstable path of equilibria, and the imperfection that a real shell has.
//!
//! Waves over the whole of space, so that the disturbance is smooth, is the same on every mesh and element, and has no symmetry.

use super::build;
use super::setup::Setup;
use super::supports;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::model::ShellModel;
use crate::scene::{Perturbation, Scene};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Number of waves.
const WAVES: usize = 24;

/// Shortest and longest wave over the diameter of the mesh.
const LENGTHS: [f64; 2] = [0.125, 2.0];

/// Disturbs the model's first state; directors of held edges and held coordinates stay.
///
/// # Errors
/// Supports that leave no node free to move along its normal.
pub fn apply(table: &Perturbation, scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup, model: &mut ShellModel) -> Result<()> {
    let moves = displacements(table, mesh, topology, setup)?;
    let (of_vertices, of_midpoints) = moves.split_at(mesh.vertices.len());
    let mut moved = mesh.clone();
    moved.vertices.iter_mut().zip(of_vertices).for_each(|(p, d)| *p += d);
    moved.midpoints.iter_mut().zip(of_midpoints).for_each(|(p, d)| *p += d);
    let (before, after) = (build::shell(scene, mesh, topology, setup), build::shell(scene, &moved, topology, setup));
    let mut directors = after.directors().to_vec();
    if !directors.is_empty() {
        let per_edge = supports::angles_per_edge(scene);
        for (edge, _) in &setup.held_directors {
            let own = per_edge * edge..per_edge * (edge + 1);
            directors[own.clone()].copy_from_slice(&before.directors()[own]);
        }
    }
    model.disturb(&moves, &directors);
    Ok(())
}

/// Displacement of each node [m].
fn displacements(table: &Perturbation, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<Vec<Vector3<f64>>> {
    let mut generator = ChaCha8Rng::seed_from_u64(table.seed);
    let [shortest, longest] = LENGTHS.map(|l| (l * mesh.diameter()).ln());
    let waves: Vec<(Vector3<f64>, f64)> = (0..WAVES)
        .map(|_| {
            let direction = loop {
                let v = Vector3::from_fn(|_, _| generator.random_range(-1.0..=1.0));
                if (0.1..=1.0).contains(&v.norm()) {
                    break v.normalize();
                }
            };
            let length: f64 = generator.random_range(shortest..=longest);
            (direction * (TAU / length.exp()), generator.random_range(0.0..TAU))
        })
        .collect();
    let wave = |p: &Vector3<f64>| waves.iter().map(|(k, phase)| (k.dot(p) + phase).sin()).sum::<f64>();
    let normals = normals(mesh, topology);
    let mut moves: Vec<Vector3<f64>> = mesh.nodes().iter().zip(&normals).map(|(p, n)| n * wave(p)).collect();
    for held in &setup.held {
        if let Some(d) = moves.get_mut(held.unknown / 3) {
            d[held.unknown % 3] = 0.0;
        }
    }
    let largest = moves.iter().map(Vector3::norm).fold(0.0, f64::max);
    if !(largest > 1e-6) {
        return Err(Error::input("statics.perturbation", "the supports leave no node free to move along its normal"));
    }
    moves.iter_mut().for_each(|d| *d *= table.amplitude / largest);
    Ok(moves)
}

/// Unit normal at each node: the mean over the faces around, weighted by area.
fn normals(mesh: &Mesh, topology: &Topology) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); mesh.vertices.len() + mesh.midpoints.len()];
    for (face, edges) in mesh.faces.iter().zip(&topology.face_edges) {
        let [a, b, c] = face.map(|v| mesh.vertices[v]);
        let normal = (b - a).cross(&(c - a));
        face.iter().for_each(|v| sums[*v] += normal);
        if !mesh.midpoints.is_empty() {
            edges.iter().for_each(|e| sums[mesh.vertices.len() + e] += normal);
        }
    }
    // Nodes of faces folded onto each other have none, and stay.
    sums.iter().map(|n| n.try_normalize(0.0).unwrap_or_default()).collect()
}

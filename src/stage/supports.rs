//! Which unknowns and directors the pins of a scene hold. What moves them in time is `build`'s business.

use super::build::{self, axis_index};
use super::setup::{Held, region};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::scene::{self, PinDirector, Scene};
use crate::shell::{Director, initial_directors};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Edges with held directors, and how they are held.
pub type HeldDirectors = Vec<(usize, Director)>;

/// Held unknowns, ascending, and edges with held directors, ascending. A region's edges bring their middle nodes with them.
///
/// # Errors
/// Regions that do not exist or have nothing to hold, planes of symmetry that do not fit, two pins of which one moves what the other holds.
pub fn find(scene: &Scene, mesh: &Mesh, topology: &Topology) -> Result<(Vec<Held>, HeldDirectors)> {
    let normals = initial_directors(mesh, topology);
    let (vertices, angles_per_edge, first_angle) = (mesh.vertices.len(), angles_per_edge(scene), first_angle(mesh));
    let edge_of: BTreeMap<[usize; 2], usize> = topology.edges.iter().enumerate().map(|(e, pair)| (*pair, e)).collect();
    let (mut held, mut held_directors) = (BTreeMap::<usize, Option<usize>>::new(), BTreeMap::new());
    for (i, pin) in scene.pins.iter().enumerate() {
        let key = format!("pin.{i}");
        let region = region(mesh, &format!("{key}.region"), &pin.region)?;
        if region.vertices.is_empty() {
            return Err(Error::input(format!("{key}.region"), format!("region '{}' has no vertices", pin.region)));
        }
        let edges: Vec<usize> = region.edges.iter().filter_map(|pair| edge_of.get(pair).copied()).collect();
        let middles = edges.iter().filter(|_| !mesh.midpoints.is_empty()).map(|e| vertices + e);
        for node in region.vertices.iter().copied().chain(middles) {
            for axis in pin.components.iter().map(|axis| axis_index(*axis)) {
                let mover = build::pin_motion(scene, i, axis).map(|_| i);
                match held.insert(3 * node + axis, mover) {
                    Some(before) if before.is_some() || mover.is_some() => {
                        let axis = ["x", "y", "z"][axis];
                        let message = format!("coordinate {axis} of node {node} is held by another pin too, and one of them moves it");
                        return Err(Error::input(key, message));
                    }
                    _ => {}
                }
            }
        }
        let Some(support) = &pin.director else { continue };
        let key = format!("{key}.director");
        if edges.is_empty() {
            return Err(Error::input(key, format!("region '{}' has no edges whose directors could be held", pin.region)));
        }
        for e in edges {
            let turned = matches!(support, PinDirector::Rotation(_)).then_some(i);
            let support = match support {
                PinDirector::Clamped => Director::Clamped,
                PinDirector::Rotation(rotation) => {
                    edge_sense(mesh, topology.edges[e], &rotation.axis).map_err(|m| Error::input(format!("{key}.rotation.axis"), m))?;
                    Director::Clamped
                }
                PinDirector::Symmetry(normal) => {
                    let normal = Vector3::from(*normal).normalize();
                    check_plane(mesh, topology.edges[e], &normal, &normals[e]).map_err(|m| Error::input(&key, m))?;
                    Director::Symmetry(normal)
                }
            };
            held_directors.insert(e, support);
            held.extend((0..angles_per_edge).map(|g| (first_angle + angles_per_edge * e + g, turned)));
        }
    }
    let held = held.into_iter().map(|(unknown, pin)| Held { unknown, pin }).collect();
    Ok((held, held_directors.into_iter().collect()))
}

/// Director angles of each edge.
pub fn angles_per_edge(scene: &Scene) -> usize {
    match (scene.shell.director, scene.shell.element) {
        (scene::Director::Average, _) => 0,
        (_, scene::Element::Linear) => 1,
        (_, scene::Element::Quadratic) => 2,
    }
}

/// The first unknown that is an angle: they follow three coordinates a node.
pub fn first_angle(mesh: &Mesh) -> usize {
    3 * (mesh.vertices.len() + mesh.midpoints.len())
}

/// +1 where an edge, from its lower vertex to its higher, runs along an axis rather than against it, else -1.
///
/// # Errors
/// An edge orthogonal to the axis, about which no sense is positive.
pub fn edge_sense(mesh: &Mesh, [a, b]: [usize; 2], axis: &[f64; 3]) -> Result<f64, String> {
    let along = (mesh.vertices[b] - mesh.vertices[a]).normalize().dot(&Vector3::from(*axis).normalize());
    if along.abs() < 1e-6 {
        return Err(format!("the axis is orthogonal to the edge from vertex {a} to vertex {b}"));
    }
    Ok(along.signum())
}

/// Whether an edge lies in a plane of symmetry that the surface crosses.
fn check_plane(mesh: &Mesh, [a, b]: [usize; 2], normal: &Vector3<f64>, surface: &Vector3<f64>) -> Result<(), String> {
    let t = (mesh.vertices[b] - mesh.vertices[a]).normalize();
    if t.dot(normal).abs() > 1e-6 {
        let (x, y, z) = (normal.x, normal.y, normal.z);
        return Err(format!("the edge from vertex {a} to vertex {b} does not lie in the plane of symmetry with normal ({x}, {y}, {z})"));
    }
    if normal.cross(&t).dot(surface).abs() < 1e-3 {
        return Err(format!("the surface is tangent to the plane of symmetry at the edge from vertex {a} to vertex {b}"));
    }
    Ok(())
}

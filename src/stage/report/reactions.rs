//! Resultants of what the supports of a region exert, from the fields that checkpoints keep of it.

use super::super::loads::angle_tangents;
use super::super::setup;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::snapshot::Snapshot;
use nalgebra::Vector3;

/// The vertices of a region and the middle nodes of its edges; and its edges.
pub fn nodes(mesh: &Mesh, key: &str, region: &str) -> Result<(Vec<usize>, Vec<usize>)> {
    let found = setup::region(mesh, key, region)?;
    if found.vertices.is_empty() {
        return Err(Error::input(key, format!("region '{region}' has no vertices")));
    }
    let pairs = &Topology::new(&mesh.faces).edges;
    let edges: Vec<usize> = (0..pairs.len()).filter(|e| found.edges.contains(&pairs[*e])).collect();
    let middles = edges.iter().filter(|_| !mesh.midpoints.is_empty()).map(|e| mesh.vertices.len() + e);
    Ok((found.vertices.iter().copied().chain(middles).collect(), edges))
}

/// Force on each node of a region [N].
pub fn forces(mesh: &Mesh, snapshot: &Snapshot, key: &str, region: &str) -> Result<Vec<(usize, Vector3<f64>)>> {
    let field = snapshot.field("reaction").filter(|f| f.data.len() == 3 * mesh.nodes().len());
    let field = field.ok_or_else(|| Error::input("checkpoint", "it has no reactions of this mesh"))?;
    let force = |node: usize| (node, Vector3::new(field.data[3 * node], field.data[3 * node + 1], field.data[3 * node + 2]));
    Ok(nodes(mesh, key, region)?.0.into_iter().map(force).collect())
}

/// Moment about a point [N m] of the forces on the nodes of a region, at their present `positions`, and of the moments on the directors of its edges.
pub fn moment(mesh: &Mesh, snapshot: &Snapshot, positions: &[Vector3<f64>], region: &str, about: &Vector3<f64>) -> Result<Vector3<f64>> {
    let mut sum: Vector3<f64> =
        forces(mesh, snapshot, "report", region)?.iter().map(|(node, force)| (positions[*node] - about).cross(force)).sum();
    let Some(moments) = snapshot.field("reaction_moment") else { return Ok(sum) };
    let topology = Topology::new(&mesh.faces);
    let (vertices, midpoints) = positions.split_at(mesh.vertices.len());
    let now = Mesh { vertices: vertices.to_vec(), midpoints: midpoints.to_vec(), ..Mesh::default() };
    let count = moments.data.len() / topology.edges.len().max(1);
    for edge in nodes(mesh, "report", region)?.1 {
        for (tangent, moment) in angle_tangents(&now, &topology, edge).into_iter().zip(&moments.data[count * edge..]) {
            sum += tangent.normalize() * *moment;
        }
    }
    Ok(sum)
}

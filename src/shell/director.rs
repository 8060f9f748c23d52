//! Directors of edges: where they start, and how they can be supported. How they enter the strains is the elements' business.

use crate::mesh::{Mesh, Topology};
use nalgebra::Vector3;

/// Support of the directors of one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Director {
    /// They find their own equilibrium.
    Free,
    /// They stay as they are at the start: a clamped edge.
    Clamped,
    /// They stay in the plane of symmetry with this normal, which contains the edge.
    Symmetry(Vector3<f64>),
    /// They stay along this vector (its part orthogonal to the edge).
    Held(Vector3<f64>),
}

impl Director {
    /// Whether they are held in some way.
    pub fn is_held(&self) -> bool {
        *self != Director::Free
    }

    /// The reference director where the initial one and the edge's tangent are these.
    pub fn reference(&self, initial: Vector3<f64>, tangent: &Vector3<f64>) -> Vector3<f64> {
        let side = |p: Vector3<f64>| if p.dot(&initial) < 0.0 { -p } else { p };
        match self {
            Director::Free | Director::Clamped => initial,
            Director::Symmetry(normal) => orthonormal(&normal.cross(tangent), tangent).map_or(initial, side),
            Director::Held(direction) => orthonormal(direction, tangent).unwrap_or(initial),
        }
    }
}

/// Initial directors of a mesh's edges: the mean of the face normals, on the boundary the face's own, made orthogonal to the edge.
pub fn initial_directors(mesh: &Mesh, topology: &Topology) -> Vec<Vector3<f64>> {
    let normals: Vec<Vector3<f64>> = mesh
        .faces
        .iter()
        .map(|f| {
            let [a, b, c] = f.map(|v| mesh.vertices[v]);
            (b - a).cross(&(c - a)).normalize()
        })
        .collect();
    topology
        .edges
        .iter()
        .zip(&topology.edge_faces)
        .map(|(edge, faces)| {
            let sum: Vector3<f64> = faces.iter().flatten().map(|f| normals[f.face]).sum();
            let first = faces[0].map_or_else(Vector3::z, |f| normals[f.face]);
            orthonormal(&sum, &(mesh.vertices[edge[1]] - mesh.vertices[edge[0]])).unwrap_or(first)
        })
        .collect()
}

/// Unit vector of the part of `v` orthogonal to `tangent`; none where nearly nothing is left.
pub fn orthonormal(v: &Vector3<f64>, tangent: &Vector3<f64>) -> Option<Vector3<f64>> {
    let part = v - tangent * (v.dot(tangent) / tangent.norm_squared());
    let norm = part.norm();
    (norm > 1e-8 * v.norm() && norm > 0.0).then(|| part / norm)
}

/// Angle [rad] by which `to`, a unit vector orthogonal to the `tangent`, is turned about it from `from` brought orthogonal to it by the shortest
/// way; 0 where that is impossible.
pub fn turn(from: &Vector3<f64>, to: &Vector3<f64>, tangent: &Vector3<f64>) -> f64 {
    orthonormal(from, tangent).map_or(0.0, |q| tangent.normalize().dot(&q.cross(to)).atan2(q.dot(to)))
}

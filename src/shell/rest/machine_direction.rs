//! The machine direction: where the fibres of the material run (Chen et al. 2018, section 3).
//!
//! Laws ask for it at a place; it is shown, and materials take it, per face. Components are barycentric: multiples of `v1 - v0` and `v2 - v0`.

use super::Site;
use crate::mesh::{Mesh, Topology};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A vector of space of a site and time [s].
pub type VectorField = Box<dyn Fn(&Site, f64) -> Vector3<f64>>;

/// Direction of the fibres.
pub enum MachineDirection {
    /// A vector of space, of any length, that is projected onto the tangent plane.
    Vector(VectorField),
    /// Barycentric components of each face.
    PerFace(Vec<[f64; 2]>),
}

impl MachineDirection {
    /// Barycentric components at a site, of no particular length. Errors: a vector of which nothing is left in the tangent plane.
    pub fn at(&self, site: &Site, time: f64) -> Result<[f64; 2], String> {
        match self {
            MachineDirection::Vector(vector) => projected(&vector(site, time), &site.tangents),
            MachineDirection::PerFace(components) => Ok(components[site.face]),
        }
    }
}

/// Barycentric components, of unit length in space, of the part of `d` in the plane of the tangent vectors `r`.
fn projected(d: &Vector3<f64>, r: &[Vector3<f64>; 2]) -> Result<[f64; 2], String> {
    let [r1, r2] = r;
    let metric = Matrix2::new(r1.dot(r1), r1.dot(r2), r1.dot(r2), r2.dot(r2));
    let c = metric.try_inverse().map(|inverse| inverse * Vector2::new(r1.dot(d), r2.dot(d))).filter(|c| c.iter().all(|v| v.is_finite()));
    let length = c.map_or(0.0, |c| (r1 * c.x + r2 * c.y).norm());
    match c {
        Some(c) if length > 1e-6 * d.norm() => Ok([c.x / length, c.y / length]),
        _ => Err(format!("the machine direction ({}, {}, {}) has no part in the face", d.x, d.y, d.z)),
    }
}

/// The direction on each face, unit, from its value at the face's centroid. `site`: of a face and a place of its reference triangle.
///
/// # Errors
/// The face where nothing is left of the vector.
pub fn on_faces(direction: &MachineDirection, faces: usize, site: impl Fn(usize, [f64; 2]) -> Site) -> Result<Vec<[f64; 2]>, String> {
    let at = |f| direction.at(&site(f, [1.0 / 3.0; 2]), 0.0).map_err(|e| format!("face {f}: {e}"));
    (0..faces).map(at).collect()
}

/// A direction that is carried over the mesh by parallel transport from one face: along the shortest path between faces, keeping its angle
/// to each edge that is crossed. Exact on developable shapes; elsewhere it depends on the path, which the distances between the middles
/// of neighbouring faces decide.
///
/// `vector`: projected onto the face `from`. Straight faces; unit barycentric components of each.
///
/// # Errors
/// A vector of which nothing is left in the face, faces that are not connected with it.
pub fn transported(mesh: &Mesh, topology: &Topology, from: usize, vector: &Vector3<f64>) -> Result<Vec<[f64; 2]>, String> {
    let corners = |f: usize| mesh.faces[f].map(|v| mesh.vertices[v]);
    let tangents = |f: usize| {
        let [a, b, c] = corners(f);
        [b - a, c - a]
    };
    let normal = |f: usize| {
        let [r1, r2] = tangents(f);
        r1.cross(&r2).normalize()
    };
    let middle = |f: usize| corners(f).iter().sum::<Vector3<f64>>() / 3.0;
    let [c1, c2] = projected(vector, &tangents(from)).map_err(|e| format!("face {from}: {e}"))?;
    let [r1, r2] = tangents(from);
    let mut carried: Vec<Option<Vector3<f64>>> = vec![None; mesh.faces.len()];
    // Distances are compared by their bits, whose order is that of positive numbers.
    let mut queue = BinaryHeap::from([(Reverse(0u64), Reverse(from), 0usize)]);
    let mut arriving = vec![(f64::INFINITY, Vector3::zeros()); mesh.faces.len()];
    arriving[from] = (0.0, r1 * c1 + r2 * c2);
    while let Some((_, Reverse(f), _)) = queue.pop() {
        if carried[f].is_some() {
            continue;
        }
        let (distance, d) = arriving[f];
        carried[f] = Some(d);
        for &e in &topology.face_edges[f] {
            let [a, b] = topology.edges[e].map(|v| mesh.vertices[v]);
            let across = (a + b) * 0.5;
            let t = (b - a).normalize();
            for g in topology.edge_faces[e].iter().flatten().map(|side| side.face).filter(|g| *g != f && carried[*g].is_none()) {
                let there = distance + (middle(f) - across).norm() + (middle(g) - across).norm();
                if there < arriving[g].0 {
                    arriving[g] = (there, t * d.dot(&t) + normal(g).cross(&t) * d.dot(&normal(f).cross(&t)));
                    queue.push((Reverse(there.to_bits()), Reverse(g), e));
                }
            }
        }
    }
    let lost = carried.iter().position(Option::is_none);
    if let Some(f) = lost {
        return Err(format!("face {f} is not connected with face {from}, from which the machine direction is carried on"));
    }
    carried.iter().flatten().enumerate().map(|(f, d)| projected(d, &tangents(f)).map_err(|e| format!("face {f}: {e}"))).collect()
}

/// `Q = [d d_perp]`: columns along `d` and across it by barycentric components, orthonormal in the metric `a`, so that `Q^-1 = Q^T a`.
pub(super) fn axes(a: &[f64; 3], d: [f64; 2]) -> Matrix2<f64> {
    let metric = Matrix2::new(a[0], a[1], a[1], a[2]);
    let d = Vector2::from(d);
    let d = d / d.dot(&(metric * d)).sqrt();
    let ad = metric * d;
    let perp = Vector2::new(-ad.y, ad.x);
    Matrix2::from_columns(&[d, perp / perp.dot(&(metric * perp)).sqrt()])
}

/// `F = Q diag(factors) Q^-1`: the stretch of a tangent vector in barycentric components, by `factors` along `d` and across it. Chen et al. (2018) writes
/// `T` where the formula needs its inverse.
pub(super) fn stretch(a: &[f64; 3], d: [f64; 2], factors: [f64; 2]) -> Matrix2<f64> {
    let q = axes(a, d);
    q * Matrix2::from_diagonal(&Vector2::from(factors)) * q.transpose() * Matrix2::new(a[0], a[1], a[1], a[2])
}

/// `F^T form F`.
pub(super) fn stretched(form: &[f64; 3], f: &Matrix2<f64>) -> [f64; 3] {
    let g = f.transpose() * Matrix2::new(form[0], form[1], form[1], form[2]) * f;
    [g[(0, 0)], 0.5 * (g[(0, 1)] + g[(1, 0)]), g[(1, 1)]]
}

//! Rest forms of the linear element from a growth law (PHYSICS A3): three edge lengths make a metric.

use super::linear_free::TANGENT;
use super::rest::{Forms, Interpolation, Law, Sampling, Site, admissible, on};
use crate::math::quadrature::GAUSS;
use crate::mesh::{Mesh, Topology};
use nalgebra::{Vector2, Vector3};

/// Interpolation on the faces of a mesh.
///
/// With [`Sampling::Edges`] each edge's rest length is `int sqrt(t.abar.t)`, `t.abar.t` being the mean of its faces', and `abar` the metric
/// with these lengths; `bbar` is the law's at the centroid.
pub struct LinearInterpolation {
    /// The initial shape.
    pub mesh: Mesh,
    /// Its edges.
    pub topology: Topology,
    /// How the law is asked.
    pub sampling: Sampling,
    /// Initial forms, per face.
    pub initial: Vec<Forms>,
    /// Thickness [m], per face.
    pub thickness: Vec<f64>,
}

impl LinearInterpolation {
    fn ask(&self, law: &dyn Law, face: usize, position: Vector3<f64>, time: f64) -> Result<Forms, String> {
        let [v0, v1, v2] = self.mesh.faces[face].map(|v| self.mesh.vertices[v]);
        let site = Site { face, position, tangents: [v1 - v0, v2 - v0], initial: self.initial[face], thickness: self.thickness[face] };
        law.forms(&site, time).map_err(|e| format!("face {face}: {e}"))
    }

    /// Rest length of an edge [m].
    fn length(&self, law: &dyn Law, edge: usize, time: f64) -> Result<f64, String> {
        let [p, q] = self.topology.edges[edge].map(|v| self.mesh.vertices[v]);
        let mut length = 0.0;
        for (s, weight) in GAUSS {
            let (mut square, mut count) = (0.0, 0.0);
            for side in self.topology.edge_faces[edge].iter().flatten() {
                let t = Vector2::from(TANGENT[side.local]);
                square += on(&self.ask(law, side.face, p * (1.0 - s) + q * s, time)?.a, t, t);
                count += 1.0;
            }
            if !(square > 0.0) {
                let face = self.topology.edge_faces[edge][0].map_or(0, |s| s.face);
                return Err(format!("face {face}: the rest metric gives an edge the squared length {square}, which must be > 0"));
            }
            length += weight * (square / count).sqrt();
        }
        Ok(length)
    }
}

impl Interpolation for LinearInterpolation {
    fn forms(&self, law: &dyn Law, time: f64) -> Result<Vec<Forms>, String> {
        let mut forms = Vec::with_capacity(self.mesh.faces.len());
        for (f, face) in self.mesh.faces.iter().enumerate() {
            forms.push(self.ask(law, f, face.iter().map(|v| self.mesh.vertices[*v]).sum::<Vector3<f64>>() / 3.0, time)?);
        }
        if self.sampling == Sampling::Edges {
            let lengths = (0..self.topology.edges.len()).map(|e| self.length(law, e, time)).collect::<Result<Vec<f64>, String>>()?;
            for (form, edges) in forms.iter_mut().zip(&self.topology.face_edges) {
                let [l0, l1, l2] = edges.map(|e| lengths[e] * lengths[e]);
                form.a = [l2, 0.5 * (l1 + l2 - l0), l1];
            }
        }
        admissible(forms, 1)
    }
}

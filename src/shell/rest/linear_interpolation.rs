//! Rest forms of the linear element from a growth law: three edge lengths make a metric.

use super::super::linear_free::TANGENT;
use super::{Forms, Impossible, Interpolation, Law, Sampling, Site, admissible, ask, on, place_and_time};
use crate::math::quadrature::GAUSS;
use crate::mesh::{Mesh, Topology};
use nalgebra::Vector2;

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
    /// Rest length of an edge [m].
    fn length(&self, law: &dyn Law, edge: usize, time: f64) -> Result<f64, Impossible> {
        let mut length = 0.0;
        for (s, weight) in GAUSS {
            let (mut square, mut count) = (0.0, 0.0);
            for side in self.topology.edge_faces[edge].iter().flatten() {
                let t = Vector2::from(TANGENT[side.local]);
                let along = self.topology.face_edge_signs[side.face][side.local] > 0.0;
                let place = edge_place(side.local, if along { s } else { 1.0 - s });
                square += on(&ask(self, law, side.face, place, time)?.a, t, t);
                count += 1.0;
            }
            if !(square > 0.0) {
                let side = self.topology.edge_faces[edge].iter().flatten().next();
                let place = side.map_or(String::new(), |side| place_and_time(&self.site(side.face, edge_place(side.local, s)), time));
                return Err(format!("{place}: the rest metric gives an edge the squared length {square}, which must be > 0").into());
            }
            length += weight * (square / count).sqrt();
        }
        Ok(length)
    }
}

impl Interpolation for LinearInterpolation {
    fn forms(&self, law: &dyn Law, time: f64) -> Result<Vec<Forms>, Impossible> {
        let mut forms = Vec::with_capacity(self.mesh.faces.len());
        for f in 0..self.mesh.faces.len() {
            forms.push(ask(self, law, f, [1.0 / 3.0; 2], time)?);
        }
        if self.sampling == Sampling::Edges {
            let lengths = (0..self.topology.edges.len()).map(|e| self.length(law, e, time)).collect::<Result<Vec<f64>, Impossible>>()?;
            for (form, edges) in forms.iter_mut().zip(&self.topology.face_edges) {
                let [l0, l1, l2] = edges.map(|e| lengths[e] * lengths[e]);
                form.a = [l2, 0.5 * (l1 + l2 - l0), l1];
            }
        }
        admissible(self, forms, time)
    }

    fn points(&self) -> usize {
        1
    }

    fn site(&self, face: usize, place: [f64; 2]) -> Site {
        let [v0, v1, v2] = self.mesh.faces[face].map(|v| self.mesh.vertices[v]);
        let tangents = [v1 - v0, v2 - v0];
        let position = v0 + tangents[0] * place[0] + tangents[1] * place[1];
        Site { face, place, position, tangents, initial: self.initial[face], thickness: self.thickness[face] }
    }
}

/// Place in the reference triangle at the fraction `t` of edge `i`, in the face's direction of travel.
fn edge_place(i: usize, t: f64) -> [f64; 2] {
    [[1.0 - t, t], [0.0, 1.0 - t], [t, 0.0]][i]
}

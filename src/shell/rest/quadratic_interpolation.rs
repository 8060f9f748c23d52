//! Rest forms of the quadratic element from a growth law: the Regge interpolant of the law's metric, as of the present one.

use super::super::linear_free::TANGENT as DIRECTION;
use super::super::quadratic_shape::{POINTS, REGGE, edge_point, gradient, linear, shape};
use super::{Forms, Impossible, Interpolation, Law, Sampling, Site, admissible, ask, on};
use crate::mesh::{Mesh, Topology};
use nalgebra::{Vector2, Vector3};

/// Interpolation on the faces of a mesh with midpoints.
///
/// With [`Sampling::Edges`] the metric has the law's `t.abar.t` at the two Gauss points of each edge, the mean of its faces', and the law's mean
/// over the face. Away from the integration points the initial metric is that of the curved face, which the interpolant shares with it in what is
/// taken at those Gauss points, and which is positive definite where the linear functions through the integration points need not be, as in a face
/// that is long and curved; the initial second form is that of those functions.
pub struct QuadraticInterpolation {
    /// The initial shape.
    pub mesh: Mesh,
    /// Its edges.
    pub topology: Topology,
    /// How the law is asked.
    pub sampling: Sampling,
    /// Initial forms, three per face.
    pub initial: Vec<Forms>,
    /// Thickness [m], per face.
    pub thickness: Vec<f64>,
}

impl QuadraticInterpolation {
    fn nodes(&self, face: usize) -> [Vector3<f64>; 6] {
        let (corners, edges) = (self.mesh.faces[face], self.topology.face_edges[face]);
        std::array::from_fn(|p| if p < 3 { self.mesh.vertices[corners[p]] } else { self.mesh.midpoints[edges[p - 3]] })
    }
}

impl Interpolation for QuadraticInterpolation {
    fn forms(&self, law: &dyn Law, time: f64) -> Result<Vec<Forms>, Impossible> {
        let faces = self.mesh.faces.len();
        let mut forms = Vec::with_capacity(3 * faces);
        for f in 0..faces {
            for place in POINTS {
                forms.push(ask(self, law, f, place, time)?);
            }
        }
        if self.sampling == Sampling::Centroid {
            return admissible(self, forms, time);
        }
        // t.abar.t at the Gauss points of each edge, from the lower vertex to the higher.
        let mut squares = vec![[0.0; 2]; self.topology.edges.len()];
        for (e, sides) in self.topology.edge_faces.iter().enumerate() {
            let count = sides.iter().flatten().count() as f64;
            for side in sides.iter().flatten() {
                let t = Vector2::from(DIRECTION[side.local]);
                let along = self.topology.face_edge_signs[side.face][side.local] > 0.0;
                for g in 0..2 {
                    let a = ask(self, law, side.face, edge_point(side.local, g), time)?.a;
                    squares[e][if along { g } else { 1 - g }] += on(&a, t, t) / count;
                }
            }
        }
        for f in 0..faces {
            let mut nine = [0.0; 9];
            for i in 0..3 {
                let (e, along) = (self.topology.face_edges[f][i], self.topology.face_edge_signs[f][i] > 0.0);
                for g in 0..2 {
                    nine[2 * i + g] = squares[e][if along { g } else { 1 - g }];
                }
            }
            for c in 0..3 {
                nine[6 + c] = (0..3).map(|k| forms[3 * f + k].a[c]).sum::<f64>() / 3.0;
            }
            for k in 0..3 {
                forms[3 * f + k].a = std::array::from_fn(|c| REGGE[3 * k + c].iter().zip(&nine).map(|(r, v)| r * v).sum());
            }
        }
        admissible(self, forms, time)
    }

    fn points(&self) -> usize {
        POINTS.len()
    }

    fn site(&self, face: usize, place: [f64; 2]) -> Site {
        let nodes = self.nodes(face);
        let sum = |weights: &[f64; 6]| nodes.iter().zip(weights).map(|(x, w)| x * *w).sum::<Vector3<f64>>();
        let weights = linear(place);
        let tangents = gradient(place).map(|s| sum(&s));
        let [r1, r2] = &tangents;
        let a = match POINTS.iter().position(|point| *point == place) {
            Some(k) => self.initial[3 * face + k].a,
            None => [r1.dot(r1), r1.dot(r2), r2.dot(r2)],
        };
        let b = std::array::from_fn(|c| (0..3).map(|k| weights[k] * self.initial[3 * face + k].b[c]).sum());
        Site { face, place, position: sum(&shape(place)), tangents, initial: Forms { a, b }, thickness: self.thickness[face] }
    }
}

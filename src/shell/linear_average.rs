//! Linear triangle whose edge normals are the normalised means of the face normals: 18 coordinates, no angles (Chen et al. 2018, section 3).
//!
//! The angle of an edge is half the dihedral angle, and zero on the boundary. The dihedral angle is the sum of the two faces' angles to
//! any common vector; measured to their mean normal, both faces use the same hinge kernel as free directors do. It does not converge on
//! irregular meshes and is here because Chen et al. 2018 have it.

use super::director::{Director, initial_directors, orthonormal};
use super::element::{Element, Strain};
use super::hinge::{Hinge, Measure};
use super::linear_free::{BEND, add_first_form_hessian, first_form, first_form_jacobian, tangents};
use crate::mesh::{Mesh, Topology};
use nalgebra::{Matrix3, Vector3};

/// Linear element with averaged edge normals.
pub struct LinearAverage {
    vertices: usize,
    faces: Vec<[usize; 3]>,
    face_edges: Vec<[usize; 3]>,
    /// Vertex across each edge of each face; `usize::MAX` on the boundary.
    across: Vec<[usize; 3]>,
    edges: Vec<[usize; 2]>,
    /// Prescribed director of held edges; empty where none is held, so that free meshes store nothing.
    held: Vec<Option<Vector3<f64>>>,
    directors: Vec<Vector3<f64>>,
}

/// How one edge of a face gets its normal.
enum EdgeNormal {
    /// Boundary: the face's own normal.
    Own,
    /// Mean of two faces: hinges of this face and of its neighbour, and the neighbour's place among the six vertices.
    Mean([Hinge; 2]),
    /// Held along a prescribed vector.
    Held(Hinge),
}

/// Tangent vectors and edges of one face.
pub struct AverageGeometry {
    r: [Vector3<f64>; 2],
    edges: [EdgeNormal; 3],
}

impl LinearAverage {
    /// Element on the faces of a mesh. `supports`: one per edge of the topology.
    pub fn new(mesh: &Mesh, topology: &Topology, supports: &[Director]) -> Self {
        let across = (0..mesh.faces.len())
            .map(|f| {
                topology.face_edges[f].map(|e| {
                    let other = topology.edge_faces[e].iter().flatten().find(|s| s.face != f);
                    other.map_or(usize::MAX, |s| mesh.faces[s.face][s.local])
                })
            })
            .collect();
        let held: Vec<Option<Vector3<f64>>> = initial_directors(mesh, topology)
            .into_iter()
            .zip(supports.iter().zip(&topology.edges))
            .map(|(initial, (support, edge))| {
                let tangent = mesh.vertices[edge[1]] - mesh.vertices[edge[0]];
                support.is_held().then(|| support.reference(initial, &tangent))
            })
            .collect();
        let directors: Vec<Vector3<f64>> = held.iter().flatten().copied().collect();
        LinearAverage {
            vertices: mesh.vertices.len(),
            faces: mesh.faces.clone(),
            face_edges: topology.face_edges.clone(),
            across,
            edges: topology.edges.clone(),
            held: if directors.is_empty() { Vec::new() } else { held },
            directors,
        }
    }
}

fn vertex(u: &[f64; 18], i: usize) -> Vector3<f64> {
    Vector3::new(u[3 * i], u[3 * i + 1], u[3 * i + 2])
}

/// Roles (opposite, start, end) of edge `i` in the face itself and in its neighbour, as places among the six vertices.
fn roles(i: usize) -> [[usize; 3]; 2] {
    let (a, b) = ((i + 1) % 3, (i + 2) % 3);
    [[i, a, b], [3 + i, b, a]]
}

/// `T` and `D` of an edge whose opposite vertex, start and end are given.
fn edge_vectors(u: &[f64; 18], [opposite, start, end]: [usize; 3]) -> (Vector3<f64>, Vector3<f64>) {
    (vertex(u, end) - vertex(u, start), vertex(u, start) - vertex(u, opposite))
}

/// What a unit of each vertex (opposite, start, end) adds to `E` and to `T`.
fn shares(hinge: &Hinge) -> [[f64; 2]; 3] {
    let k = hinge.skew;
    [[-1.0, 0.0], [1.0 + k, -1.0], [-k, 1.0]]
}

/// Adds `e.dE + t.dT` to a gradient in the vertices.
fn add_gradient(gradient: &mut [f64; 18], hinge: &Hinge, places: [usize; 3], e: Vector3<f64>, t: Vector3<f64>) {
    for (place, [se, st]) in places.into_iter().zip(shares(hinge)) {
        for k in 0..3 {
            gradient[3 * place + k] += se * e[k] + st * t[k];
        }
    }
}

/// Adds second derivatives in (E, T), in the hinge's frame, to the lower triangle in the vertices.
fn add_hessian(hessian: &mut [[f64; 18]; 18], hinge: &Hinge, places: [usize; 3], ee: Matrix3<f64>, et: Matrix3<f64>, tt: Matrix3<f64>) {
    let [ee, et, tt] = [ee, et, tt].map(|m| hinge.frame * m * hinge.frame.transpose());
    let s = shares(hinge);
    for (a, &pa) in places.iter().enumerate() {
        for (b, &pb) in places.iter().enumerate().filter(|(_, pb)| **pb <= pa) {
            let m = ee * (s[a][0] * s[b][0]) + et * (s[a][0] * s[b][1]) + et.transpose() * (s[a][1] * s[b][0]) + tt * (s[a][1] * s[b][1]);
            for i in 0..3 {
                for j in 0..if pa == pb { i + 1 } else { 3 } {
                    hessian[3 * pa + i][3 * pb + j] += m[(i, j)];
                }
            }
        }
    }
}

/// Second derivatives of a hinge's angle in (E, E), (E, T), (T, T).
fn angle_blocks(hinge: &Hinge) -> [Matrix3<f64>; 3] {
    let [et_tn, ee_on, ton, too, tto, ttn] = hinge.angle_hessian();
    let ee = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, ee_on, 0.0, ee_on, 0.0);
    let et = Matrix3::new(0.0, 0.0, et_tn, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let tt = Matrix3::new(0.0, tto, ttn, tto, too, ton, ttn, ton, -too);
    [ee, et, tt]
}

/// Second derivatives of a hinge's height in (E, E), (E, T), (T, T).
fn height_blocks(hinge: &Hinge) -> [Matrix3<f64>; 3] {
    let (l, h) = (hinge.length, hinge.height);
    let mut blocks = [Matrix3::zeros(); 3];
    blocks[0][(2, 2)] = 1.0 / h;
    blocks[1][(0, 1)] = -1.0 / l;
    blocks[2][(1, 1)] = -h / (l * l);
    blocks
}

/// Gradient of half the dihedral angle in the six vertices.
fn half_dihedral_gradient(hinges: &[Hinge; 2], i: usize) -> [f64; 18] {
    let mut gradient = [0.0; 18];
    for (hinge, places) in hinges.iter().zip(roles(i)) {
        let [en, to, tn] = hinge.angle_gradient().map(|g| 0.5 * g);
        let (o, n) = (hinge.frame.column(1), hinge.frame.column(2));
        add_gradient(&mut gradient, hinge, places, n * en, o * to + n * tn);
    }
    gradient
}

impl EdgeNormal {
    /// `sin(alpha) H` of edge `i`.
    fn value(&self) -> f64 {
        match self {
            EdgeNormal::Own => 0.0,
            EdgeNormal::Mean([own, other]) => (0.5 * (own.angle + other.angle)).sin() * own.height,
            EdgeNormal::Held(hinge) => hinge.curvature(Measure::Sin, 1.0, 0.0).value,
        }
    }

    fn gradient(&self, i: usize) -> [f64; 18] {
        let mut gradient = [0.0; 18];
        match self {
            EdgeNormal::Own => {}
            EdgeNormal::Mean(hinges) => {
                let own = &hinges[0];
                let (s, c) = (0.5 * (own.angle + hinges[1].angle)).sin_cos();
                gradient = half_dihedral_gradient(hinges, i).map(|g| g * c * own.height);
                add_gradient(&mut gradient, own, roles(i)[0], own.frame.column(1) * s, Vector3::zeros());
            }
            EdgeNormal::Held(hinge) => {
                let f = hinge.curvature(Measure::Sin, 1.0, 0.0);
                let (o, n) = (hinge.frame.column(1), hinge.frame.column(2));
                add_gradient(&mut gradient, hinge, roles(i)[0], o * f.e[0] + n * f.e[1], o * f.t[0] + n * f.t[1]);
            }
        }
        gradient
    }

    /// Adds `weight` times the second derivatives of the value.
    fn add_hessian(&self, i: usize, weight: f64, hessian: &mut [[f64; 18]; 18]) {
        match self {
            EdgeNormal::Own => {}
            EdgeNormal::Mean(hinges) => {
                let own = &hinges[0];
                let (s, c) = (0.5 * (own.angle + hinges[1].angle)).sin_cos();
                let (s, c) = (s * weight, c * weight);
                let half = half_dihedral_gradient(hinges, i);
                let mut height = [0.0; 18];
                add_gradient(&mut height, own, roles(i)[0], own.frame.column(1).into(), Vector3::zeros());
                for p in 0..18 {
                    for q in 0..=p {
                        hessian[p][q] += c * (half[p] * height[q] + height[p] * half[q]) - s * own.height * half[p] * half[q];
                    }
                }
                for (hinge, places) in hinges.iter().zip(roles(i)) {
                    let [ee, et, tt] = angle_blocks(hinge).map(|m| m * (0.5 * c * own.height));
                    add_hessian(hessian, hinge, places, ee, et, tt);
                }
                let [ee, et, tt] = height_blocks(own).map(|m| m * s);
                add_hessian(hessian, own, roles(i)[0], ee, et, tt);
            }
            EdgeNormal::Held(hinge) => {
                let h = hinge.hessian(&hinge.curvature(Measure::Sin, 1.0, 0.0), 1.0, weight);
                let mut ee = Matrix3::zeros();
                ee[(2, 2)] = h.ee_nn;
                add_hessian(hessian, hinge, roles(i)[0], ee, h.et, h.tt);
            }
        }
    }
}

impl Element<18, 1> for LinearAverage {
    type Geometry = AverageGeometry;

    const WEIGHTS: [f64; 1] = [0.5];
    const STRETCHING: usize = 9;

    fn faces(&self) -> usize {
        self.faces.len()
    }

    fn unknowns(&self) -> usize {
        3 * self.vertices
    }

    fn stencil(&self, face: usize) -> [usize; 18] {
        std::array::from_fn(|s| {
            let v = if s < 9 { self.faces[face][s / 3] } else { self.across[face][s / 3 - 3] };
            if v == usize::MAX { usize::MAX } else { 3 * v + s % 3 }
        })
    }

    fn geometry(&self, face: usize, u: &[f64; 18]) -> AverageGeometry {
        let r = tangents(u);
        let normal = r[0].cross(&r[1]).normalize();
        let edges = std::array::from_fn(|i| {
            let [own, other] = roles(i);
            let (t, d) = edge_vectors(u, own);
            if let Some(Some(p)) = self.held.get(self.face_edges[face][i]) {
                return EdgeNormal::Held(Hinge::new(&t, &d, &normal, p));
            }
            if self.across[face][i] == usize::MAX {
                return EdgeNormal::Own;
            }
            let (t_other, d_other) = edge_vectors(u, other);
            let normal_other = d_other.cross(&t_other).normalize();
            let sum = normal + normal_other;
            // Faces folded onto each other have no mean normal; any common vector gives the same sum of angles, save for its sign.
            let mean = if sum.norm_squared() > 1e-20 { sum.normalize() } else { t.cross(&normal).normalize() };
            EdgeNormal::Mean([Hinge::new(&t, &d, &normal, &mean), Hinge::new(&t_other, &d_other, &normal_other, &mean)])
        });
        AverageGeometry { r, edges }
    }

    fn tangents(&self, g: &AverageGeometry) -> [[Vector3<f64>; 2]; 1] {
        [g.r]
    }

    fn forms(&self, g: &AverageGeometry) -> [Strain; 1] {
        let a = first_form(&g.r);
        let f: [f64; 3] = std::array::from_fn(|i| g.edges[i].value());
        let b: [f64; 3] = std::array::from_fn(|c| (0..3).map(|i| BEND[i][c] * f[i]).sum());
        [[a[0], a[1], a[2], b[0], b[1], b[2]]]
    }

    fn jacobian(&self, g: &AverageGeometry) -> [[[f64; 18]; 6]; 1] {
        let mut rows = [[0.0; 18]; 6];
        first_form_jacobian(&g.r, &mut rows);
        for (i, edge) in g.edges.iter().enumerate() {
            let gradient = edge.gradient(i);
            for c in 0..3 {
                for (row, g) in rows[3 + c].iter_mut().zip(&gradient) {
                    *row += BEND[i][c] * g;
                }
            }
        }
        [rows]
    }

    fn hessian(&self, g: &AverageGeometry, weights: &[Strain; 1], membrane_only: bool, hessian: &mut [[f64; 18]; 18]) {
        let w = &weights[0];
        add_first_form_hessian(&w[..3], hessian);
        if membrane_only {
            return;
        }
        for (i, edge) in g.edges.iter().enumerate() {
            let weight: f64 = (0..3).map(|c| BEND[i][c] * w[3 + c]).sum();
            edge.add_hessian(i, weight, hessian);
        }
    }

    fn directors(&self) -> &[Vector3<f64>] {
        &self.directors
    }

    fn set_directors(&mut self, directors: &[Vector3<f64>]) {
        self.directors.copy_from_slice(directors);
        let mut next = directors.iter();
        for held in self.held.iter_mut().flatten() {
            if let Some(p) = next.next() {
                *held = *p;
            }
        }
    }

    fn reframe(&mut self, x: &mut [f64]) {
        if self.held.is_empty() {
            return;
        }
        let at = |v: usize| Vector3::new(x[3 * v], x[3 * v + 1], x[3 * v + 2]);
        for (held, edge) in self.held.iter_mut().zip(&self.edges) {
            if let Some(p) = held {
                *p = orthonormal(p, &(at(edge[1]) - at(edge[0]))).unwrap_or(*p);
            }
        }
        self.directors = self.held.iter().flatten().copied().collect();
    }

    fn turns(&self, _x: &[f64], _from: &[Vector3<f64>]) -> Vec<f64> {
        Vec::new()
    }
}

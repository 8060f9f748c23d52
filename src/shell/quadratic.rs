//! Quadratic triangle with free directors: six nodes and two angles an edge, no neighbours.
//!
//! Directors stand at the two Gauss points of each edge, shared by its faces, and turn about the edge's tangent there as those of the linear
//! element do. The first form is the Regge interpolant of that of the nodes, which agrees with it along edges: without it the element
//! locks in the thin limit. The second form is the surface's own, `n.r_ij`, and the hinges' at the edges, which correct it weakly.
//! Everything depends on the nodes through vectors that are linear in them, so two small kernels and constant tables make the element.

use super::director::{Director, orthonormal, turn};
use super::element::{Element, Strain};
use super::hinge::{Hinge, HingeCurvature, Measure};
use super::quadratic_shape::{BEND, EDGE_NODES, EDGE_TANGENT, GAUSS, INNER, METRIC, OUTWARD, REGGE, SECOND, TANGENT};
use crate::math::TangentPlane;
use crate::mesh::{Mesh, Topology};
use nalgebra::{Matrix3, Matrix6, SymmetricEigen, Vector3};

/// Quadratic element with free directors.
///
/// Nodes: the vertices, then the midpoint of each edge. Unknowns: three per node, then two angles per edge, at its Gauss points from the
/// lower vertex to the higher. In a face: vertices 0, 1, 2, midpoints of edges 0, 1, 2, then for each edge the angles in the face's own
/// direction of travel.
pub struct QuadraticFree {
    measure: Measure,
    vertices: usize,
    faces: Vec<[usize; 3]>,
    face_edges: Vec<[usize; 3]>,
    face_edge_signs: Vec<[f64; 3]>,
    edges: Vec<[usize; 2]>,
    /// Two per edge.
    directors: Vec<Vector3<f64>>,
}

/// A face's nodes, tangent planes and hinges.
pub struct QuadraticGeometry {
    /// Nodes, from the first [m].
    nodes: [Vector3<f64>; 6],
    /// `r1`, `r2` at the interior points.
    tangents: [[Vector3<f64>; 2]; 3],
    planes: [TangentPlane; 3],
    /// `r_11`, `r_12`, `r_22`.
    second: [Vector3<f64>; 3],
    hinges: [[Hinge; 2]; 3],
    curvatures: [[HingeCurvature; 2]; 3],
    signs: [f64; 3],
}

/// `sum_p weights[p] nodes[p]`; the first node is the origin.
#[inline(always)]
fn combine(nodes: &[Vector3<f64>; 6], weights: &[f64; 6]) -> Vector3<f64> {
    let [_, a, b, c, d, e] = nodes;
    a * weights[1] + b * weights[2] + c * weights[3] + d * weights[4] + e * weights[5]
}

/// Adds a block in nodes `p`, `q` to the lower triangle.
#[inline(always)]
fn add_block(hessian: &mut [[f64; 24]; 24], p: usize, q: usize, block: &Matrix3<f64>) {
    let (high, low) = (3 * p.max(q), 3 * p.min(q));
    for i in 0..3 {
        for j in 0..3 {
            hessian[high + i][low + j] += if p >= q { block[(i, j)] } else { block[(j, i)] };
        }
    }
}

impl QuadraticFree {
    /// Element on the faces of a mesh. `midpoints`: position of each edge's middle node [m], on the true surface where that is known.
    /// `supports`: one per edge of the topology; which angles are then held is the caller's to say.
    pub fn new(mesh: &Mesh, topology: &Topology, midpoints: &[Vector3<f64>], measure: Measure, supports: &[Director]) -> Self {
        let mut element = QuadraticFree {
            measure,
            vertices: mesh.vertices.len(),
            faces: mesh.faces.clone(),
            face_edges: topology.face_edges.clone(),
            face_edge_signs: topology.face_edge_signs.clone(),
            edges: topology.edges.clone(),
            directors: vec![Vector3::zeros(); 2 * topology.edges.len()],
        };
        for (face, corners) in mesh.faces.iter().enumerate() {
            let edges = topology.face_edges[face];
            let origin = mesh.vertices[corners[0]];
            let nodes = std::array::from_fn(|p| if p < 3 { mesh.vertices[corners[p]] } else { midpoints[edges[p - 3]] } - origin);
            for i in 0..3 {
                for g in 0..2 {
                    let normal = combine(&nodes, &OUTWARD[i][g]).cross(&combine(&nodes, &TANGENT[i][g])).normalize();
                    let d = element.director(face, i, g);
                    let director = &mut element.directors[d];
                    // The first face's own normal stays where the faces are folded onto each other.
                    let sum = *director + normal;
                    *director = if sum.norm_squared() > 1e-20 { sum } else { normal };
                }
            }
        }
        for (e, support) in supports.iter().enumerate() {
            let [a, b] = element.edges[e].map(|v| mesh.vertices[v]);
            for g in 0..2 {
                let tangent = edge_tangent(g, &a, &b, &midpoints[e]);
                let p = &mut element.directors[2 * e + g];
                *p = support.reference(orthonormal(p, &tangent).unwrap_or(*p), &tangent);
            }
        }
        element
    }

    /// Number of nodes.
    fn nodes(&self) -> usize {
        self.vertices + self.edges.len()
    }

    /// Director at Gauss point `g` of edge `i` in the face's direction of travel.
    #[inline(always)]
    fn director(&self, face: usize, i: usize, g: usize) -> usize {
        2 * self.face_edges[face][i] + if self.face_edge_signs[face][i] > 0.0 { g } else { 1 - g }
    }
}

/// Tangent of an edge at its Gauss point `g`, from its start, end and middle.
#[inline(always)]
fn edge_tangent(g: usize, start: &Vector3<f64>, end: &Vector3<f64>, middle: &Vector3<f64>) -> Vector3<f64> {
    let [a, b, m] = EDGE_TANGENT[g];
    start * a + end * b + middle * m
}

/// The nearest positive semidefinite matrix to a symmetric one, of which the lower triangle is read. Regge interpolation makes indefinite
/// matrices of positive stresses, so that those need projecting here.
fn positive_part(lower: Matrix6<f64>) -> Matrix6<f64> {
    let mut eigen = SymmetricEigen::new(lower);
    eigen.eigenvalues.apply(|value| *value = value.max(0.0));
    eigen.recompose()
}

impl QuadraticGeometry {
    /// What node `p` adds to `E` of a hinge.
    #[inline(always)]
    fn outward_share(&self, i: usize, g: usize, p: usize) -> f64 {
        OUTWARD[i][g][p] - self.hinges[i][g].skew * TANGENT[i][g][p]
    }

    /// Adds `sum_k weights[k] d2(n.r_ij)` in the nodes.
    #[inline(always)]
    fn add_normal_hessian(&self, weights: &[Strain; 3], hessian: &mut [[f64; 24]; 24]) {
        for (k, plane) in self.planes.iter().enumerate() {
            let w = &weights[k][3..];
            let s = self.second[0] * w[0] + self.second[1] * w[1] + self.second[2] * w[2];
            let (value, c, [d1, d2]) = (plane.normal.dot(&s), plane.components(&s), &INNER[k]);
            let share: [f64; 6] =
                std::array::from_fn(|p| c[0] * d1[p] + c[1] * d2[p] - w[0] * SECOND[0][p] - w[1] * SECOND[1][p] - w[2] * SECOND[2][p]);
            let gradient: [Vector3<f64>; 6] = std::array::from_fn(|p| plane.surface_gradient([d1[p], d2[p]]));
            for p in 0..6 {
                for q in 0..=p {
                    add_block(hessian, p, q, &plane.hessian(value, [share[p], share[q]], [&gradient[p], &gradient[q]]));
                }
            }
        }
    }

    /// Adds `weight d2(S H)` of the hinge at Gauss point `g` of edge `i`.
    #[inline(always)]
    fn add_hinge_hessian(&self, i: usize, g: usize, weight: f64, hessian: &mut [[f64; 24]; 24]) {
        let hinge = &self.hinges[i][g];
        let h = hinge.hessian(&self.curvatures[i][g], self.signs[i], weight);
        let frame = &hinge.frame;
        let (o, n) = (frame.column(1), frame.column(2));
        let ee = n * n.transpose() * h.ee_nn;
        let et = frame * h.et * frame.transpose();
        let tt = frame * h.tt * frame.transpose();
        let (nodes, t) = (&EDGE_NODES[i], &EDGE_TANGENT[g]);
        let e = nodes.map(|p| self.outward_share(i, g, p));
        // Nodes off the edge, the last three, have no share of T.
        for b in 0..3 {
            let (by_e, by_t) = (ee * e[b] + et * t[b], et.transpose() * e[b] + tt * t[b]);
            for a in b..3 {
                add_block(hessian, nodes[a], nodes[b], &(by_e * e[a] + by_t * t[a]));
            }
            for a in 3..6 {
                add_block(hessian, nodes[a], nodes[b], &(by_e * e[a]));
            }
        }
        for b in 3..6 {
            for a in b..6 {
                add_block(hessian, nodes[a], nodes[b], &(ee * (e[a] * e[b])));
            }
        }
        let (pe, pt) = (o * h.phi_e[0] + n * h.phi_e[1], o * h.phi_t[0] + n * h.phi_t[1]);
        let row = &mut hessian[18 + 2 * i + g];
        for (a, p) in nodes.iter().enumerate() {
            for k in 0..3 {
                row[3 * p + k] += pe[k] * e[a] + if a < 3 { pt[k] * t[a] } else { 0.0 };
            }
        }
        row[18 + 2 * i + g] += h.phi_phi;
    }
}

impl Element<24, 3> for QuadraticFree {
    type Geometry = QuadraticGeometry;

    const WEIGHTS: [f64; 3] = [1.0 / 6.0; 3];
    const STRETCHING: usize = 18;

    fn faces(&self) -> usize {
        self.faces.len()
    }

    fn unknowns(&self) -> usize {
        3 * self.nodes() + self.directors.len()
    }

    fn stencil(&self, face: usize) -> [usize; 24] {
        std::array::from_fn(|s| {
            let (p, k) = (s / 3, s % 3);
            match s {
                0..9 => 3 * self.faces[face][p] + k,
                9..18 => 3 * (self.vertices + self.face_edges[face][p - 3]) + k,
                _ => 3 * self.nodes() + self.director(face, (s - 18) / 2, s % 2),
            }
        })
    }

    #[inline(always)]
    fn geometry(&self, face: usize, u: &[f64; 24]) -> QuadraticGeometry {
        let nodes: [Vector3<f64>; 6] = std::array::from_fn(|p| Vector3::new(u[3 * p] - u[0], u[3 * p + 1] - u[1], u[3 * p + 2] - u[2]));
        let tangents: [[Vector3<f64>; 2]; 3] = std::array::from_fn(|k| std::array::from_fn(|a| combine(&nodes, &INNER[k][a])));
        let planes = std::array::from_fn(|k| TangentPlane::new(&tangents[k][0], &tangents[k][1]));
        let second = std::array::from_fn(|c| combine(&nodes, &SECOND[c]));
        let signs = self.face_edge_signs[face];
        let hinges: [[Hinge; 2]; 3] = std::array::from_fn(|i| {
            let [start, end, middle, ..] = EDGE_NODES[i].map(|p| &nodes[p]);
            std::array::from_fn(|g| {
                let (t, d) = (edge_tangent(g, start, end, middle), combine(&nodes, &OUTWARD[i][g]));
                Hinge::new(&t, &d, &d.cross(&t).normalize(), &self.directors[self.director(face, i, g)])
            })
        });
        let curvatures =
            std::array::from_fn(|i| std::array::from_fn(|g| hinges[i][g].curvature(self.measure, signs[i], u[18 + 2 * i + g])));
        QuadraticGeometry { nodes, tangents, planes, second, hinges, curvatures, signs }
    }

    fn tangents(&self, g: &QuadraticGeometry) -> [[Vector3<f64>; 2]; 3] {
        g.tangents
    }

    #[inline(always)]
    fn forms(&self, geometry: &QuadraticGeometry) -> [Strain; 3] {
        // What defines the first form: t.a.t at the edges' Gauss points and the mean over the face.
        let mut given = [0.0; 9];
        for i in 0..3 {
            for g in 0..2 {
                let length = geometry.hinges[i][g].length;
                given[2 * i + g] = length * length;
            }
            let [r1, r2] = &geometry.tangents[i];
            for (mean, value) in given[6..].iter_mut().zip([r1.dot(r1), r1.dot(r2), r2.dot(r2)]) {
                *mean += value / 3.0;
            }
        }
        std::array::from_fn(|k| {
            let mut form = [0.0; 6];
            for c in 0..3 {
                form[c] = REGGE[3 * k + c].iter().zip(&given).map(|(r, g)| r * g).sum();
                form[3 + c] = geometry.planes[k].normal.dot(&geometry.second[c]);
            }
            let h: [f64; 3] = std::array::from_fn(|i| {
                let f = &geometry.curvatures[i];
                BEND[i][0][k] * f[0].value + BEND[i][1][k] * f[1].value
            });
            form[3] += h[0] + h[1];
            form[4] += h[0];
            form[5] += h[0] + h[2];
            form
        })
    }

    #[inline(always)]
    fn jacobian(&self, geometry: &QuadraticGeometry) -> [[[f64; 24]; 6]; 3] {
        let mut rows = [[[0.0; 24]; 6]; 3];
        // Gradients of the hinges in the nodes.
        let mut hinges = [[[0.0; 18]; 2]; 3];
        for i in 0..3 {
            for g in 0..2 {
                let (hinge, f) = (&geometry.hinges[i][g], &geometry.curvatures[i][g]);
                let (o, n) = (hinge.frame.column(1), hinge.frame.column(2));
                let (e, t) = (o * f.e[0] + n * f.e[1], o * f.t[0] + n * f.t[1]);
                let t = t - e * hinge.skew;
                for p in 0..6 {
                    for k in 0..3 {
                        hinges[i][g][3 * p + k] = e[k] * OUTWARD[i][g][p] + t[k] * TANGENT[i][g][p];
                    }
                }
            }
        }
        for (k, rows) in rows.iter_mut().enumerate() {
            for (c, row) in rows[..3].iter_mut().enumerate() {
                for p in 0..6 {
                    row[3 * p..3 * p + 3].copy_from_slice(combine(&geometry.nodes, &METRIC[3 * k + c][p]).as_slice());
                }
            }
            let (plane, [d1, d2]) = (&geometry.planes[k], &INNER[k]);
            for (c, row) in rows[3..].iter_mut().enumerate() {
                let s = plane.components(&geometry.second[c]);
                for p in 0..6 {
                    let share = SECOND[c][p] - s[0] * d1[p] - s[1] * d2[p];
                    for j in 0..3 {
                        row[3 * p + j] = share * plane.normal[j];
                    }
                }
            }
            for j in 0..18 {
                let h: [f64; 3] = std::array::from_fn(|i| BEND[i][0][k] * hinges[i][0][j] + BEND[i][1][k] * hinges[i][1][j]);
                rows[3][j] += h[0] + h[1];
                rows[4][j] += h[0];
                rows[5][j] += h[0] + h[2];
            }
            for g in 0..2 {
                let phi: [f64; 3] = std::array::from_fn(|i| BEND[i][g][k] * geometry.curvatures[i][g].phi);
                (rows[3][18 + g], rows[4][18 + g], rows[5][18 + g]) = (phi[0], phi[0], phi[0]);
                rows[3][20 + g] = phi[1];
                rows[5][22 + g] = phi[2];
            }
        }
        rows
    }

    #[inline(always)]
    fn hessian(&self, geometry: &QuadraticGeometry, weights: &[Strain; 3], membrane_only: bool, hessian: &mut [[f64; 24]; 24]) {
        let mut stretch = Matrix6::zeros();
        for p in 0..6 {
            for q in 0..=p {
                stretch[(p, q)] = (0..9).map(|c| weights[c / 3][c % 3] * METRIC[c][p][q]).sum();
            }
        }
        if membrane_only {
            stretch = positive_part(stretch);
        }
        for p in 0..6 {
            for q in 0..=p {
                for k in 0..3 {
                    hessian[3 * p + k][3 * q + k] += stretch[(p, q)];
                }
            }
        }
        if membrane_only {
            return;
        }
        geometry.add_normal_hessian(weights, hessian);
        // Each edge's part of b: g_i g_i^T is (1, 1, 1), (1, 0, 0), (0, 0, 1) by components 11, 12, 22.
        let by_edge = weights.map(|w| [w[3] + w[4] + w[5], w[3], w[5]]);
        for i in 0..3 {
            for (g, bend) in BEND[i].iter().enumerate() {
                let weight = (0..3).map(|k| bend[k] * by_edge[k][i]).sum();
                geometry.add_hinge_hessian(i, g, weight, hessian);
            }
        }
    }

    fn directors(&self) -> &[Vector3<f64>] {
        &self.directors
    }

    fn set_directors(&mut self, directors: &[Vector3<f64>]) {
        self.directors.copy_from_slice(directors);
    }

    fn reframe(&mut self, x: &mut [f64]) {
        let (positions, angles) = x.split_at_mut(3 * self.nodes());
        let at = |v: usize| Vector3::new(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
        for (e, edge) in self.edges.iter().enumerate() {
            let (a, b, m) = (at(edge[0]), at(edge[1]), at(self.vertices + e));
            for g in 0..GAUSS.len() {
                let t = edge_tangent(g, &a, &b, &m).normalize();
                let (p, phi) = (&mut self.directors[2 * e + g], &mut angles[2 * e + g]);
                if let Some(q) = orthonormal(p, &t) {
                    let (s, c) = phi.sin_cos();
                    *p = q * c + t.cross(&q) * s;
                    *phi = 0.0;
                }
            }
        }
    }

    fn turns(&self, x: &[f64], from: &[Vector3<f64>]) -> Vec<f64> {
        let at = |v: usize| Vector3::new(x[3 * v], x[3 * v + 1], x[3 * v + 2]);
        let mut turns = Vec::with_capacity(from.len());
        for (e, edge) in self.edges.iter().enumerate() {
            let (a, b, m) = (at(edge[0]), at(edge[1]), at(self.vertices + e));
            for d in 2 * e..2 * e + GAUSS.len() {
                turns.push(turn(&from[d], &self.directors[d], &edge_tangent(d - 2 * e, &a, &b, &m)));
            }
        }
        turns
    }
}

//! Linear triangle with a free director on each edge: 9 coordinates and 3 angles, no neighbours.
//!
//! The angle of an edge is measured from a frozen unit vector `p`, turning about the edge's own direction (lower to higher vertex). So
//! a face reads only its own vertices and angles, whatever its neighbours do.

use super::director::{Director, initial_directors, orthonormal, turn};
use super::element::{Element, Strain};
use super::hinge::{Hinge, HingeCurvature, Measure};
use crate::mesh::{Mesh, Topology};
use nalgebra::{Matrix3, Vector3};

/// Tangents `T_i = v[i+2] - v[i+1]` of a face's edges as multiples of `r1 = v1 - v0` and `r2 = v2 - v0`.
pub(super) const TANGENT: [[f64; 2]; 3] = [[-1.0, 1.0], [0.0, -1.0], [1.0, 0.0]];
/// Outward vectors `D_i = dr o_i`, `o_i = -g_i / |g_i|^2`, as multiples of `r1` and `r2`.
pub(super) const OUTWARD: [[f64; 2]; 3] = [[0.5, 0.5], [-1.0, 0.0], [0.0, -1.0]];
/// `-2 g_i g_i^T`, by components 11, 12, 22: what a unit of hinge `i` adds to `b`.
pub(super) const BEND: [[f64; 3]; 3] = [[-2.0, -2.0, -2.0], [-2.0, 0.0, 0.0], [0.0, 0.0, -2.0]];

/// Linear element with free directors.
pub struct LinearFree {
    measure: Measure,
    vertices: usize,
    faces: Vec<[usize; 3]>,
    face_edges: Vec<[usize; 3]>,
    face_edge_signs: Vec<[f64; 3]>,
    edges: Vec<[usize; 2]>,
    directors: Vec<Vector3<f64>>,
}

/// A face's tangent vectors, normal and hinges.
pub struct FreeGeometry {
    r: [Vector3<f64>; 2],
    hinges: [Hinge; 3],
    curvatures: [HingeCurvature; 3],
    signs: [f64; 3],
}

impl LinearFree {
    /// Element on the faces of a mesh. `supports`: one per edge of the topology; which angles are then held is the caller's to say.
    pub fn new(mesh: &Mesh, topology: &Topology, measure: Measure, supports: &[Director]) -> Self {
        let mut directors = initial_directors(mesh, topology);
        for ((p, support), edge) in directors.iter_mut().zip(supports).zip(&topology.edges) {
            *p = support.reference(*p, &(mesh.vertices[edge[1]] - mesh.vertices[edge[0]]));
        }
        LinearFree {
            measure,
            vertices: mesh.vertices.len(),
            faces: mesh.faces.clone(),
            face_edges: topology.face_edges.clone(),
            face_edge_signs: topology.face_edge_signs.clone(),
            edges: topology.edges.clone(),
            directors,
        }
    }
}

/// `r1` and `r2` of a face from its nine coordinates.
#[inline(always)]
pub(super) fn tangents(u: &[f64]) -> [Vector3<f64>; 2] {
    let v0 = Vector3::new(u[0], u[1], u[2]);
    [Vector3::new(u[3], u[4], u[5]) - v0, Vector3::new(u[6], u[7], u[8]) - v0]
}

/// First form by components 11, 12, 22.
#[inline(always)]
pub(super) fn first_form(r: &[Vector3<f64>; 2]) -> [f64; 3] {
    [r[0].norm_squared(), r[0].dot(&r[1]), r[1].norm_squared()]
}

/// Derivatives of the first form, in nine coordinates.
#[inline(always)]
pub(super) fn first_form_jacobian<const N: usize>(r: &[Vector3<f64>; 2], rows: &mut [[f64; N]; 6]) {
    for k in 0..3 {
        let (a, b) = (r[0][k], r[1][k]);
        (rows[0][k], rows[0][3 + k]) = (-2.0 * a, 2.0 * a);
        (rows[1][k], rows[1][3 + k], rows[1][6 + k]) = (-a - b, b, a);
        (rows[2][k], rows[2][6 + k]) = (-2.0 * b, 2.0 * b);
    }
}

/// Adds `sum_i w_i d2(a_i)` to the lower triangle, in nine coordinates. `w`: by components 11, 12, 22.
#[inline(always)]
pub(super) fn add_first_form_hessian<const N: usize>(w: &[f64], hessian: &mut [[f64; N]; N]) {
    let (p, q, r) = (2.0 * w[0], w[1], 2.0 * w[2]);
    for k in 0..3 {
        hessian[k][k] += p + 2.0 * q + r;
        hessian[3 + k][k] -= p + q;
        hessian[6 + k][k] -= q + r;
        hessian[3 + k][3 + k] += p;
        hessian[6 + k][3 + k] += q;
        hessian[6 + k][6 + k] += r;
    }
}

impl Element<12, 1> for LinearFree {
    type Geometry = FreeGeometry;

    const WEIGHTS: [f64; 1] = [0.5];
    const STRETCHING: usize = 9;

    fn faces(&self) -> usize {
        self.faces.len()
    }

    fn unknowns(&self) -> usize {
        3 * self.vertices + self.edges.len()
    }

    fn stencil(&self, face: usize) -> [usize; 12] {
        let mut s = [0; 12];
        for i in 0..3 {
            for k in 0..3 {
                s[3 * i + k] = 3 * self.faces[face][i] + k;
            }
            s[9 + i] = 3 * self.vertices + self.face_edges[face][i];
        }
        s
    }

    #[inline(always)]
    fn geometry(&self, face: usize, u: &[f64; 12]) -> FreeGeometry {
        let r = tangents(u);
        let normal = r[0].cross(&r[1]).normalize();
        let signs = self.face_edge_signs[face];
        let hinges: [Hinge; 3] = std::array::from_fn(|i| {
            let [t, o] = [TANGENT[i], OUTWARD[i]].map(|c| r[0] * c[0] + r[1] * c[1]);
            Hinge::new(&t, &o, &normal, &self.directors[self.face_edges[face][i]])
        });
        let curvatures = std::array::from_fn(|i| hinges[i].curvature(self.measure, signs[i], u[9 + i]));
        FreeGeometry { r, hinges, curvatures, signs }
    }

    fn tangents(&self, g: &FreeGeometry) -> [[Vector3<f64>; 2]; 1] {
        [g.r]
    }

    #[inline(always)]
    fn forms(&self, g: &FreeGeometry) -> [Strain; 1] {
        let a = first_form(&g.r);
        let f = g.curvatures.map(|c| c.value);
        let b: [f64; 3] = std::array::from_fn(|c| (0..3).map(|i| BEND[i][c] * f[i]).sum());
        [[a[0], a[1], a[2], b[0], b[1], b[2]]]
    }

    #[inline(always)]
    fn jacobian(&self, g: &FreeGeometry) -> [[[f64; 12]; 6]; 1] {
        let mut rows = [[0.0; 12]; 6];
        first_form_jacobian(&g.r, &mut rows);
        for i in 0..3 {
            let (hinge, f) = (&g.hinges[i], &g.curvatures[i]);
            let (o, n) = (hinge.frame.column(1), hinge.frame.column(2));
            let (e, t) = (o * f.e[0] + n * f.e[1], o * f.t[0] + n * f.t[1]);
            // d f = e.dE + t.dT, E = sum_a (o_a - k t_a) r_a, T = sum_a t_a r_a
            let dr: [Vector3<f64>; 2] = std::array::from_fn(|a| e * (OUTWARD[i][a] - hinge.skew * TANGENT[i][a]) + t * TANGENT[i][a]);
            for c in 0..3 {
                let weight = BEND[i][c];
                if weight == 0.0 {
                    continue;
                }
                let row = &mut rows[3 + c];
                for k in 0..3 {
                    row[k] -= weight * (dr[0][k] + dr[1][k]);
                    row[3 + k] += weight * dr[0][k];
                    row[6 + k] += weight * dr[1][k];
                }
                row[9 + i] = weight * f.phi;
            }
        }
        [rows]
    }

    #[inline(always)]
    fn hessian(&self, g: &FreeGeometry, weights: &[Strain; 1], membrane_only: bool, hessian: &mut [[f64; 12]; 12]) {
        let w = &weights[0];
        add_first_form_hessian(&w[..3], hessian);
        if membrane_only {
            return;
        }
        // Blocks (r1, r1), (r2, r1), (r2, r2), then (phi_i, r_a): the vertices follow by v0 = -(r1 + r2).
        let mut blocks = [Matrix3::zeros(); 3];
        for i in 0..3 {
            let weight: f64 = (0..3).map(|c| BEND[i][c] * w[3 + c]).sum();
            let (hinge, f) = (&g.hinges[i], &g.curvatures[i]);
            let h = hinge.hessian(f, g.signs[i], weight);
            let frame = &hinge.frame;
            let n = frame.column(2);
            let ee = n * n.transpose() * h.ee_nn;
            let et = frame * h.et * frame.transpose();
            let tt = frame * h.tt * frame.transpose();
            let t = TANGENT[i];
            let e: [f64; 2] = std::array::from_fn(|a| OUTWARD[i][a] - hinge.skew * t[a]);
            for (block, (a, b)) in blocks.iter_mut().zip([(0, 0), (1, 0), (1, 1)]) {
                *block += ee * (e[a] * e[b]) + et * (e[a] * t[b]) + et.transpose() * (t[a] * e[b]) + tt * (t[a] * t[b]);
            }
            let o = frame.column(1);
            let (pe, pt) = (o * h.phi_e[0] + n * h.phi_e[1], o * h.phi_t[0] + n * h.phi_t[1]);
            let [p1, p2] = std::array::from_fn(|a| pe * e[a] + pt * t[a]);
            let row = &mut hessian[9 + i];
            for k in 0..3 {
                row[k] -= p1[k] + p2[k];
                row[3 + k] += p1[k];
                row[6 + k] += p2[k];
            }
            row[9 + i] += h.phi_phi;
        }
        let [b11, b21, b22] = blocks;
        let (b01, b02) = (b11 + b21, b21.transpose() + b22);
        let b00 = b01 + b02;
        for i in 0..3 {
            for j in 0..3 {
                hessian[3 + i][j] -= b01[(j, i)];
                hessian[6 + i][j] -= b02[(j, i)];
                hessian[6 + i][3 + j] += b21[(i, j)];
                if j <= i {
                    hessian[i][j] += b00[(i, j)];
                    hessian[3 + i][3 + j] += b11[(i, j)];
                    hessian[6 + i][6 + j] += b22[(i, j)];
                }
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
        let (positions, angles) = x.split_at_mut(3 * self.vertices);
        let at = |v: usize| Vector3::new(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
        for ((p, phi), edge) in self.directors.iter_mut().zip(angles).zip(&self.edges) {
            let t = (at(edge[1]) - at(edge[0])).normalize();
            if let Some(q) = orthonormal(p, &t) {
                let (s, c) = phi.sin_cos();
                *p = q * c + t.cross(&q) * s;
                *phi = 0.0;
            }
        }
    }

    fn turns(&self, x: &[f64], from: &[Vector3<f64>]) -> Vec<f64> {
        let at = |v: usize| Vector3::new(x[3 * v], x[3 * v + 1], x[3 * v + 2]);
        let pairs = self.directors.iter().zip(from).zip(&self.edges);
        pairs.map(|((to, from), edge)| turn(from, to, &(at(edge[1]) - at(edge[0])))).collect()
    }
}

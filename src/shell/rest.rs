//! Rest forms: growth laws as functions of a point, and how a linear element interpolates them (seed A, section 3; PHYSICS A3).
//!
//! A [`Law`] says what the rest forms are at one place of one face. The rest metric of a face is built from the rest lengths of its
//! edges, on which both faces of an edge agree, so that a smooth law does not prestress the sheet by its mesh. Nothing here stores time.

use crate::mesh::{Mesh, Topology};
use nalgebra::{Matrix2, Vector2, Vector3};

/// First and second form by components 11, 12, 22 in a face's barycentric basis (v1 - v0, v2 - v0).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forms {
    /// First form [m2].
    pub a: [f64; 3],
    /// Second form [m]; `b = -dr.dn`, so a sphere with outward normals has `b = -a/R`.
    pub b: [f64; 3],
}

impl Forms {
    /// `(1 - share) self + share other`.
    pub fn mix(&self, other: &Forms, share: f64) -> Forms {
        let mix = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|i| (1.0 - share) * p[i] + share * q[i]);
        Forms { a: mix(self.a, other.a), b: mix(self.b, other.b) }
    }

    /// Whether all components are finite and the first form is positive definite.
    pub fn is_admissible(&self) -> bool {
        let [p, q, r] = self.a;
        self.a.iter().chain(&self.b).all(|v| v.is_finite()) && p > 0.0 && r > 0.0 && p * r - q * q > 1e-14 * p * r
    }
}

/// The place a law is asked about.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// Face index.
    pub face: usize,
    /// Place in the initial shape [m].
    pub position: Vector3<f64>,
    /// `v1 - v0` and `v2 - v0` of the initial shape [m].
    pub tangents: [Vector3<f64>; 2],
    /// Initial forms there.
    pub initial: Forms,
    /// Thickness [m].
    pub thickness: f64,
}

/// A scalar of place (in the initial shape, [m]) and time [s].
pub type ScalarField = Box<dyn Fn(&Vector3<f64>, f64) -> f64>;

/// A growth law.
pub trait Law {
    /// Rest forms at a site and time. Errors: what makes them impossible there, in words.
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, String>;
}

/// Law `pullback`: forms given in the xy plane.
pub struct Pullback {
    /// First form 11, 12, 22; none for the flat metric.
    pub abar: Option<[ScalarField; 3]>,
    /// Second form; none for zero.
    pub bbar: Option<[ScalarField; 3]>,
    /// Components refer to dr, dtheta instead of dx, dy.
    pub polar: bool,
}

/// Law `linear`: swelling that varies linearly through the thickness, with or without a machine direction.
pub struct Linear {
    /// Additional moisture at the top [%].
    pub m_plus: ScalarField,
    /// Additional moisture at the bottom [%].
    pub m_minus: ScalarField,
    /// Relative change of length per percent, along the fibres if there are any.
    pub mu: f64,
    /// With a machine direction: the change across the fibres, and the fibres' direction per face by barycentric components, unit in the
    /// initial metric.
    pub fibres: Option<(f64, Vec<[f64; 2]>)>,
}

/// Value of the form (11, 12, 22) on two vectors.
fn on(form: &[f64; 3], u: Vector2<f64>, v: Vector2<f64>) -> f64 {
    form[0] * u.x * v.x + form[1] * (u.x * v.y + u.y * v.x) + form[2] * u.y * v.y
}

impl Law for Pullback {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, String> {
        let p = site.position;
        let t = site.tangents.map(|r| {
            if !self.polar {
                return Vector2::new(r.x, r.y);
            }
            let r2 = p.x * p.x + p.y * p.y;
            Vector2::new((p.x * r.x + p.y * r.y) / r2.sqrt(), (p.x * r.y - p.y * r.x) / r2)
        });
        let pulled = |form: &[f64; 3]| [on(form, t[0], t[0]), on(form, t[0], t[1]), on(form, t[1], t[1])];
        let sampled = |fields: &[ScalarField; 3]| [fields[0](&p, time), fields[1](&p, time), fields[2](&p, time)];
        let flat = [site.tangents[0], site.tangents[1]].map(|r| Vector2::new(r.x, r.y));
        let a = match &self.abar {
            Some(fields) => pulled(&sampled(fields)),
            None => [flat[0].dot(&flat[0]), flat[0].dot(&flat[1]), flat[1].dot(&flat[1])],
        };
        Ok(Forms { a, b: self.bbar.as_ref().map_or([0.0; 3], |fields| pulled(&sampled(fields))) })
    }
}

impl Law for Linear {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, String> {
        let h = site.thickness;
        let [a0, b0] = [site.initial.a, site.initial.b];
        let side = |field: &ScalarField, sign: f64, name: &str| {
            let m = field(&site.position, time);
            let stretch = |mu: f64| {
                let s = 1.0 + m * mu;
                if s > 0.0 { Ok(s) } else { Err(format!("{name} = {m} % makes 1 + m mu = {s}, which must be > 0")) }
            };
            let g: [f64; 3] = std::array::from_fn(|i| a0[i] - sign * h * b0[i]);
            let along = stretch(self.mu)?;
            Ok::<_, String>(match &self.fibres {
                None => g.map(|v| along * along * v),
                Some((mu_perp, directions)) => {
                    let t = fibre_stretch(&a0, directions[site.face], along, stretch(*mu_perp)?);
                    let g = t.transpose() * Matrix2::new(g[0], g[1], g[1], g[2]) * t;
                    [g[(0, 0)], 0.5 * (g[(0, 1)] + g[(1, 0)]), g[(1, 1)]]
                }
            })
        };
        let (top, bottom) = (side(&self.m_plus, 1.0, "m_plus")?, side(&self.m_minus, -1.0, "m_minus")?);
        Ok(Forms { a: std::array::from_fn(|i| 0.5 * (top[i] + bottom[i])), b: std::array::from_fn(|i| (bottom[i] - top[i]) / (2.0 * h)) })
    }
}

/// `Q M Q^-1` with `Q = [d d_perp]` and `M = diag(along, across)`: the stretch of a tangent vector in barycentric components. Seed A writes `T`
/// where the formula needs its inverse (PHYSICS A3).
fn fibre_stretch(a0: &[f64; 3], d: [f64; 2], along: f64, across: f64) -> Matrix2<f64> {
    let d = Vector2::new(d[0], d[1]);
    let metric = Matrix2::new(a0[0], a0[1], a0[1], a0[2]);
    let ad = metric * d;
    let perp = Vector2::new(-ad.y, ad.x);
    let perp = perp / perp.dot(&(metric * perp)).sqrt();
    // Columns of Q are orthonormal in the initial metric, so Q^-1 = Q^T a0.
    d * ad.transpose() * along + perp * (metric * perp).transpose() * across
}

/// Machine direction of each face by barycentric components, unit in the initial metric, from a vector at the face's centroid, which is
/// projected onto the face. Errors: the face where nothing is left of the vector.
pub fn machine_direction(mesh: &Mesh, vector: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Result<Vec<[f64; 2]>, String> {
    mesh.faces
        .iter()
        .enumerate()
        .map(|(f, face)| {
            let [v0, v1, v2] = face.map(|v| mesh.vertices[v]);
            let (r1, r2) = (v1 - v0, v2 - v0);
            let d = vector(&((v0 + v1 + v2) / 3.0));
            let metric = Matrix2::new(r1.dot(&r1), r1.dot(&r2), r1.dot(&r2), r2.dot(&r2));
            let c = metric
                .try_inverse()
                .map(|inverse| inverse * Vector2::new(r1.dot(&d), r2.dot(&d)))
                .filter(|c| c.x.is_finite() && c.y.is_finite());
            let on_face = c.map_or(0.0, |c| (r1 * c.x + r2 * c.y).norm());
            match c {
                Some(c) if on_face > 1e-6 * d.norm() => Ok([c.x / on_face, c.y / on_face]),
                _ => Err(format!("face {f}: the machine direction ({}, {}, {}) has no part in the face", d.x, d.y, d.z)),
            }
        })
        .collect()
}

/// How a law becomes the rest metric of a linear face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// From the rest lengths of the edges.
    Edges,
    /// From the law at the centroid (seed A).
    Centroid,
}

/// Gauss points and weights on [0, 1], exact to degree 5.
const GAUSS: [(f64, f64); 3] = [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Rest forms of the linear element, one per face, at a time [s].
///
/// `initial`: initial forms per face. `thickness`: [m] per face. With [`Sampling::Edges`] each edge's rest length is
/// `int sqrt(t.abar.t)`, `t.abar.t` being the mean of its faces', and `abar` the metric with these lengths; `bbar` is the law's at the
/// centroid. Errors: the face and what is impossible there.
pub fn linear_element_forms(
    mesh: &Mesh,
    topology: &Topology,
    law: &dyn Law,
    sampling: Sampling,
    initial: &[Forms],
    thickness: impl Fn(usize) -> f64,
    time: f64,
) -> Result<Vec<Forms>, String> {
    let site = |face: usize, position: Vector3<f64>| {
        let [v0, v1, v2] = mesh.faces[face].map(|v| mesh.vertices[v]);
        Site { face, position, tangents: [v1 - v0, v2 - v0], initial: initial[face], thickness: thickness(face) }
    };
    let ask = |face: usize, position: Vector3<f64>| law.forms(&site(face, position), time).map_err(|e| format!("face {face}: {e}"));
    let mut forms = Vec::with_capacity(mesh.faces.len());
    for (f, face) in mesh.faces.iter().enumerate() {
        forms.push(ask(f, face.iter().map(|v| mesh.vertices[*v]).sum::<Vector3<f64>>() / 3.0)?);
    }
    if sampling == Sampling::Edges {
        let mut lengths = Vec::with_capacity(topology.edges.len());
        for (edge, faces) in topology.edges.iter().zip(&topology.edge_faces) {
            let [p, q] = edge.map(|v| mesh.vertices[v]);
            let mut length = 0.0;
            for (s, weight) in GAUSS {
                let (mut square, mut count) = (0.0, 0.0);
                for side in faces.iter().flatten() {
                    let t = super::linear_free::TANGENT[side.local];
                    let t = Vector2::new(t[0], t[1]);
                    square += on(&ask(side.face, p * (1.0 - s) + q * s)?.a, t, t);
                    count += 1.0;
                }
                if !(square > 0.0) {
                    let face = faces[0].map_or(0, |s| s.face);
                    return Err(format!("face {face}: the rest metric gives an edge the squared length {square}, which must be > 0"));
                }
                length += weight * (square / count).sqrt();
            }
            lengths.push(length);
        }
        for (form, edges) in forms.iter_mut().zip(&topology.face_edges) {
            let [l0, l1, l2] = edges.map(|e| lengths[e] * lengths[e]);
            form.a = [l2, 0.5 * (l1 + l2 - l0), l1];
        }
    }
    match forms.iter().position(|f| !f.is_admissible()) {
        Some(f) => Err(format!("face {f}: the rest metric {:?} (11, 12, 22 in m2) is not positive definite", forms[f].a)),
        None => Ok(forms),
    }
}

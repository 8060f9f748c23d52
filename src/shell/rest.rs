//! Rest forms: growth laws as functions of a point (seed A, section 3; PHYSICS A3).
//!
//! A [`Law`] says what the rest forms are at one place of one face. An [`Interpolation`] asks it where an element needs it, so that a smooth
//! law does not prestress the sheet by its mesh; there is one per kind of element, in files of their own. Nothing here stores time.

use crate::mesh::Mesh;
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
pub(super) fn on(form: &[f64; 3], u: Vector2<f64>, v: Vector2<f64>) -> f64 {
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
    let metric = Matrix2::new(a0[0], a0[1], a0[1], a0[2]);
    // Unit in the metric of the face; that of the place differs where the face is curved.
    let d = Vector2::new(d[0], d[1]);
    let d = d / d.dot(&(metric * d)).sqrt();
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

/// How a law becomes the rest metric of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// In the element's own strain space: both faces of an edge agree about its rest length.
    Edges,
    /// The law's value at each integration point (seed A). Prestresses the sheet by its mesh.
    Centroid,
}

/// How an element makes rest forms of a law.
pub trait Interpolation {
    /// Rest forms at a time [s], one per integration point. Errors: the face and what is impossible there.
    fn forms(&self, law: &dyn Law, time: f64) -> Result<Vec<Forms>, String>;
}

/// The forms, if they can all be those of a shell; else the first face (of `points` integration points each) where they cannot.
pub(super) fn admissible(forms: Vec<Forms>, points: usize) -> Result<Vec<Forms>, String> {
    match forms.iter().position(|f| !f.is_admissible()) {
        Some(k) => Err(format!("face {}: the rest metric {:?} (11, 12, 22 in m2) is not positive definite", k / points, forms[k].a)),
        None => Ok(forms),
    }
}

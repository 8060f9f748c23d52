//! Rest forms: growth laws as functions of a point, and how an element interpolates them (Chen et al. 2018, section 3).
//!
//! A [`Law`] says what the rest forms are at one place of one face. An [`Interpolation`] asks it where an element needs it, so that a smooth
//! law does not prestress the sheet by its mesh; there is one per kind of element. Nothing here stores time.
//!
//! - `pullback`, `surface`, `shape`: forms that are given, in the plane, by a map, by another mesh
//! - `growth`: factors on what there is; `swelling`: of the two faces or layers of a shell; `expansion`: by a profile through the thickness;
//!   `prestress`: what is added
//! - `machine_direction`: the direction of the fibres
//! - `linear_interpolation`, `quadratic_interpolation`: what the elements make of a law

mod expansion;
mod growth;
mod linear_interpolation;
mod machine_direction;
mod prestress;
mod pullback;
mod quadratic_interpolation;
mod shape;
mod surface;
mod swelling;

pub use expansion::{Expansion, LevelField};
pub use growth::{Isotropic, Orthotropic};
pub use linear_interpolation::LinearInterpolation;
pub use machine_direction::{MachineDirection, on_faces, transported};
pub use prestress::Prestress;
pub use pullback::{Components, Pullback};
pub use quadratic_interpolation::QuadraticInterpolation;
pub use shape::OtherShape;
pub use surface::Surface;
pub use swelling::{Profile, Swelling};

use nalgebra::{Vector2, Vector3};

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
    /// Place in the face's reference triangle, whose coordinates belong to `v1 - v0` and `v2 - v0` [1].
    pub place: [f64; 2],
    /// Place in the initial shape [m].
    pub position: Vector3<f64>,
    /// Tangent vectors of the initial shape there [m], `v1 - v0` and `v2 - v0` where the face is straight.
    pub tangents: [Vector3<f64>; 2],
    /// The forms that a law starts from: those of the initial shape, or what the laws before it make of them.
    pub initial: Forms,
    /// Thickness [m].
    pub thickness: f64,
}

/// A scalar of a site and time [s].
pub type ScalarField = Box<dyn Fn(&Site, f64) -> f64>;

/// Why there are no rest forms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Impossible {
    /// Name of the law that is at fault, where it is one of several; empty else.
    pub law: &'static str,
    /// What is impossible; said by an interpolation or a driver also where and when.
    pub reason: String,
}

impl From<String> for Impossible {
    fn from(reason: String) -> Self {
        Impossible { law: "", reason }
    }
}

/// A growth law.
pub trait Law {
    /// Rest forms at a site and time. Errors: what makes them impossible there, in words.
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible>;
}

/// Laws with their names, one after the other, each starting from what the one before it makes.
pub struct Product(pub Vec<(&'static str, Box<dyn Law>)>);

impl Law for Product {
    fn forms(&self, site: &Site, time: f64) -> Result<Forms, Impossible> {
        let mut site = *site;
        for (name, law) in &self.0 {
            site.initial = law.forms(&site, time).map_err(|e| Impossible { law: name, ..e })?;
        }
        Ok(site.initial)
    }
}

/// Value of the form (11, 12, 22) on two vectors.
fn on(form: &[f64; 3], u: Vector2<f64>, v: Vector2<f64>) -> f64 {
    form[0] * u.x * v.x + form[1] * (u.x * v.y + u.y * v.x) + form[2] * u.y * v.y
}

/// The form (11, 12, 22) of a chart in the basis of a face whose tangent vectors have the components `t` in the chart.
fn pulled_back(form: &[f64; 3], t: &[Vector2<f64>; 2]) -> [f64; 3] {
    [on(form, t[0], t[0]), on(form, t[0], t[1]), on(form, t[1], t[1])]
}

/// How a law becomes the rest metric of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// In the element's own strain space: both faces of an edge agree about its rest length.
    Edges,
    /// The law's value at each integration point (Chen et al. 2018). Prestresses the sheet by its mesh.
    Centroid,
}

/// How an element makes rest forms of a law.
pub trait Interpolation {
    /// Rest forms at a time [s], one per integration point. Errors: what is impossible, in which face, where and when.
    fn forms(&self, law: &dyn Law, time: f64) -> Result<Vec<Forms>, Impossible>;

    /// Integration points per face.
    fn points(&self) -> usize;

    /// The site at a place of a face's reference triangle.
    fn site(&self, face: usize, place: [f64; 2]) -> Site;
}

/// The law at a place of a face, which errors name.
fn ask(interpolation: &dyn Interpolation, law: &dyn Law, face: usize, place: [f64; 2], time: f64) -> Result<Forms, Impossible> {
    let site = interpolation.site(face, place);
    law.forms(&site, time).map_err(|e| Impossible { reason: format!("{}: {}", place_and_time(&site, time), e.reason), ..e })
}

/// A site and a time in words.
fn place_and_time(site: &Site, time: f64) -> String {
    let [x, y, z] = site.position.map(|c| format!("{c:.5e}").parse().unwrap_or(c)).data.0[0];
    format!("face {} at ({x}, {y}, {z}) m, t = {time}", site.face)
}

/// The forms, if they can all be those of a shell; else the first face where they cannot.
pub fn admissible(interpolation: &dyn Interpolation, forms: Vec<Forms>, time: f64) -> Result<Vec<Forms>, Impossible> {
    let points = interpolation.points();
    let Some(k) = forms.iter().position(|f| !f.is_admissible()) else { return Ok(forms) };
    let place = place_and_time(&interpolation.site(k / points, [1.0 / 3.0; 2]), time);
    Err(format!("{place}: the rest metric {:?} (11, 12, 22 in m2) is not positive definite", forms[k].a).into())
}

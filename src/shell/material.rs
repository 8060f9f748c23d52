//! What a face is made of: moduli, and which law turns them into energy.
//!
//! Laws that are quadratic in the forms are matrices, made here or in the file of their own; the others are evaluated point by point by
//! `neo_hookean`, `tension_field` and `biot`. All of them have a small-strain stiffness, which is what viscosity uses. Nothing here sums over faces.

use super::biot;
use super::element::Strain;
use super::layered::{self, Bilayer};
use super::neo_hookean;
use super::orthotropic::{self, Orthotropic};
use super::rest::Forms;
use super::tension_field;

/// Thickness and moduli of one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Thickness [m].
    pub thickness: f64,
    /// Young's modulus [Pa]; of an orthotropic or layered face, a mean.
    pub youngs_modulus: f64,
    /// Poisson's ratio [1]; of an orthotropic or layered face, a mean.
    pub poissons_ratio: f64,
}

impl Material {
    /// Plane-stress Lame parameters `alpha = E nu / (1 - nu^2)` and `beta = E / (2 (1 + nu))` [Pa].
    pub fn lame(&self) -> [f64; 2] {
        lame(self.youngs_modulus, self.poissons_ratio)
    }

    /// Lame parameters of a body, `alpha = E nu / ((1 + nu) (1 - 2 nu))` and `beta = E / (2 (1 + nu))` [Pa].
    pub fn lame_of_a_body(&self) -> [f64; 2] {
        let (e, nu) = (self.youngs_modulus, self.poissons_ratio);
        [e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))]
    }
}

/// Plane-stress Lame parameters [Pa] of Young's modulus [Pa] and Poisson's ratio.
pub(super) fn lame(e: f64, nu: f64) -> [f64; 2] {
    [e * nu / (1.0 - nu * nu), e / (2.0 * (1.0 + nu))]
}

/// Which law turns moduli and forms into energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Constitution {
    /// Isotropic St. Venant-Kirchhoff in plane stress.
    #[default]
    PlaneStress,
    /// The same with the Lame parameters of a body, as Chen et al. 2018 print them: too stiff by `(1 - nu)^2 / (1 - 2 nu)` in a plate's bending.
    ThreeDimensional,
    /// Orthotropic St. Venant-Kirchhoff in plane stress.
    Orthotropic(Orthotropic),
    /// Two isotropic layers, St. Venant-Kirchhoff in plane stress.
    Bilayer(Bilayer),
    /// Compressible neo-Hookean in plane stress, integrated through the thickness.
    NeoHookean,
    /// No membrane stiffness in compression, but for the share `compression` [1] of the St. Venant-Kirchhoff energy; bending as this.
    TensionField {
        /// Share that is left, > 0 and <= 1.
        compression: f64,
    },
    /// St. Venant-Kirchhoff with a bending strain that stretch does not change, to first order.
    BiotBending,
}

/// Energy of a point and its derivatives in the six forms.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Energy; infinite where the law has none.
    pub energy: f64,
    /// First derivatives in a11, a12, a22, b11, b12, b22.
    pub stress: Strain,
    /// Second derivatives.
    pub tangent: [[f64; 6]; 6],
}

/// Second derivatives of a quadratic energy of the changes `m` of the first and `n` of the second form: in `m m`, `m n` and `n n`, each a
/// symmetric matrix (11 12 13 22 23 33) on the components 11, 12, 22.
pub(super) type Stiffness = [[f64; 6]; 3];

/// `C m` for `C` by its upper triangle.
#[inline(always)]
pub(super) fn times(c: &[f64; 6], m: [f64; 3]) -> [f64; 3] {
    [c[0] * m[0] + c[1] * m[1] + c[2] * m[2], c[1] * m[0] + c[3] * m[1] + c[4] * m[2], c[2] * m[0] + c[4] * m[1] + c[5] * m[2]]
}

/// Matrix `C` with `m.C.m / 2 = weight sqrt(det abar) (alpha/2 tr(S M)^2 + beta tr((S M)^2))`, `S = abar^-1`, `m = (M11, M12, M22)`.
pub(super) fn norm_matrix(abar: [f64; 3], [alpha, beta]: [f64; 2], weight: f64) -> [f64; 6] {
    let det = abar[0] * abar[2] - abar[1] * abar[1];
    let (p, q, r) = (abar[2] / det, -abar[1] / det, abar[0] / det);
    let w = weight * det.sqrt();
    // tr(S M) = p m1 + 2 q m2 + r m3; tr((S M)^2) = (p m1 + q m2)^2 + 2 (p m2 + q m3)(q m1 + r m2) + (q m2 + r m3)^2
    let (a, b) = (alpha * w, 2.0 * beta * w);
    [
        a * p * p + b * p * p,
        a * 2.0 * p * q + b * 2.0 * p * q,
        a * p * r + b * q * q,
        a * 4.0 * q * q + b * 2.0 * (q * q + p * r),
        a * 2.0 * q * r + b * 2.0 * q * r,
        a * r * r + b * r * r,
    ]
}

/// Factors of the matrix of a material that is alike through its thickness [m] in membrane and bending: `h/4`, `h^3/12`.
#[inline(always)]
pub(super) fn factors(h: f64) -> [f64; 2] {
    [0.25 * h, h * h * h / 12.0]
}

impl Constitution {
    /// Whether the energy is a quadratic one without coupling of membrane and bending, by one matrix for both.
    pub fn is_uncoupled(&self) -> bool {
        matches!(self, Constitution::PlaneStress | Constitution::ThreeDimensional | Constitution::Orthotropic(_))
    }

    /// The two layers, if there are any.
    pub fn layers(&self) -> Option<Bilayer> {
        if let Constitution::Bilayer(layers) = self { Some(*layers) } else { None }
    }

    /// Whether the energy is more than that of the membrane and that of bending.
    pub fn couples(&self) -> bool {
        matches!(self, Constitution::Bilayer(_) | Constitution::NeoHookean | Constitution::BiotBending)
    }

    /// The matrix of a material that is alike through its thickness, of a layered one its means'.
    pub(super) fn matrix(&self, material: &Material, abar: [f64; 3], weight: f64) -> [f64; 6] {
        match self {
            Constitution::Orthotropic(o) => orthotropic::norm_matrix(o, abar, weight),
            Constitution::ThreeDimensional => norm_matrix(abar, material.lame_of_a_body(), weight),
            _ => norm_matrix(abar, material.lame(), weight),
        }
    }

    /// Stiffness at small strain.
    pub(super) fn stiffness(&self, material: &Material, abar: [f64; 3], weight: f64) -> Stiffness {
        if let Constitution::Bilayer(b) = self {
            return layered::stiffness(b, material.thickness, abar, weight);
        }
        let c = self.matrix(material, abar, weight);
        let [membrane, bending] = factors(material.thickness);
        [c.map(|v| v * membrane), [0.0; 6], c.map(|v| v * bending)]
    }

    /// Energy and stress at `forms`; with `TANGENT` the second derivatives too, else zeros. `stiffness`: that of the point and `weight`.
    pub(super) fn respond<const TANGENT: bool>(
        &self,
        material: &Material,
        rest: &Strain,
        stiffness: &Stiffness,
        weight: f64,
        forms: &Strain,
    ) -> Response {
        match self {
            Constitution::NeoHookean => neo_hookean::respond::<TANGENT>(material, rest, weight, forms),
            Constitution::BiotBending => biot::respond::<TANGENT>(rest, stiffness, forms),
            Constitution::TensionField { compression } => {
                tension_field::respond::<TANGENT>(material, *compression, rest, stiffness, weight, forms)
            }
            _ => quadratic::<TANGENT>(rest, stiffness, forms),
        }
    }

    /// Stress and energies (membrane, bending; see [`super::Shell::energies`]) per rest area [J/m2 over the unit of the forms, J/m2]. `rest` must
    /// be admissible.
    pub fn per_area(&self, material: &Material, rest: &Forms, forms: &Forms) -> (Strain, [f64; 2]) {
        let [a, b] = [rest.a, rest.b];
        let weight = 1.0 / (a[0] * a[2] - a[1] * a[1]).sqrt();
        let [rest, forms] = [[a, b], [forms.a, forms.b]].map(|[a, b]| [a[0], a[1], a[2], b[0], b[1], b[2]]);
        let stiffness = self.stiffness(material, a, weight);
        let respond = |forms: &Strain| self.respond::<false>(material, &rest, &stiffness, weight, forms);
        (respond(&forms).stress, split(self.couples(), &rest, &forms, |forms| respond(forms).energy))
    }

    /// Whether a shell of this material can have these forms, as its own or at rest.
    pub fn admits(&self, material: &Material, forms: &Forms) -> bool {
        *self != Constitution::NeoHookean || neo_hookean::has_volume(material.thickness, forms)
    }
}

/// Membrane and bending energy: that of the present first form with the second form of the rest, and what the present second form adds. Where the
/// law does not couple them, the latter is that of the second form alone, without the round-off of a difference.
pub(super) fn split(couples: bool, rest: &Strain, forms: &Strain, energy: impl Fn(&Strain) -> f64) -> [f64; 2] {
    let membrane = energy(&std::array::from_fn(|i| if i < 3 { forms[i] } else { rest[i] }));
    if couples {
        return [membrane, energy(forms) - membrane];
    }
    [membrane, energy(&std::array::from_fn(|i| if i < 3 { rest[i] } else { forms[i] }))]
}

/// Stress of a stiffness for changes `d` of the forms.
pub(super) fn stress_of(stiffness: &Stiffness, d: &Strain) -> Strain {
    let (m, n) = ([d[0], d[1], d[2]], [d[3], d[4], d[5]]);
    let [membrane, coupling, bending] = stiffness;
    let (mm, mn) = (times(membrane, m), times(coupling, n));
    let (nm, nn) = (times(coupling, m), times(bending, n));
    std::array::from_fn(|i| if i < 3 { mm[i] + mn[i] } else { nm[i - 3] + nn[i - 3] })
}

/// All entries of a stiffness.
pub(super) fn expand(stiffness: &Stiffness) -> [[f64; 6]; 6] {
    const PLACE: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    std::array::from_fn(|i| std::array::from_fn(|j| stiffness[i / 3 + j / 3][PLACE[i % 3][j % 3]]))
}

fn quadratic<const TANGENT: bool>(rest: &Strain, stiffness: &Stiffness, forms: &Strain) -> Response {
    let d: Strain = std::array::from_fn(|i| forms[i] - rest[i]);
    let stress = stress_of(stiffness, &d);
    let energy = 0.5 * stress.iter().zip(&d).map(|(s, d)| s * d).sum::<f64>();
    Response { energy, stress, tangent: if TANGENT { expand(stiffness) } else { [[0.0; 6]; 6] } }
}

//! How the Koiter energy asks for stress and stiffness at a point: once for faces that all have quadratic laws without coupling, once for any.
//!
//! The first is one matrix a point and costs accordingly; the second evaluates each face's [`Constitution`] and holds a full tangent. Both
//! keep the rest forms, since what they keep besides follows from them. Sums over faces and elements are in `energy`.

use super::element::Strain;
use super::material::{Constitution, Material, Response, Stiffness, expand, factors, stress_of, times};
use super::projection::project_tangent;

/// Law of all faces of a shell.
pub trait Constitutive: Sync {
    /// For `points` integration points; one material a face, and one constitution a face or none at all for the default.
    fn new(materials: Vec<Material>, constitutions: Vec<Constitution>, points: usize) -> Self;

    /// Sets the rest forms of a point. `weight`: of the point in the reference triangle.
    fn set_rest(&mut self, face: usize, point: usize, rest: &Strain, weight: f64);

    /// Rest forms of a point.
    fn rest(&self, point: usize) -> &Strain;

    /// Whether membrane and bending are coupled on a face.
    fn couples(&self, face: usize) -> bool;

    /// Stress (derivative of the energy in each form) at a point for forms `eps`, without damping, and the energy [J].
    fn elastic(&self, face: usize, point: usize, eps: &Strain) -> (Strain, f64);

    /// The stress at `eps` and what the tangent there adds for a change `d`.
    fn linearised(&self, face: usize, point: usize, eps: &Strain, d: &Strain) -> Strain;

    /// Stress of the stiffness at small strain for a change `d`: what viscosity is made of.
    fn small_strain(&self, face: usize, point: usize, d: &Strain) -> Strain;

    /// Sets the rows `(T + viscous C) J`, `T` the tangent at `eps`, made positive semidefinite if `semidefinite`, and `C` the stiffness at small strain.
    fn set_rows<const N: usize>(
        &self,
        at: (usize, usize, &Strain),
        viscous: f64,
        semidefinite: bool,
        jacobian: &[[f64; N]; 6],
        rows: &mut [[f64; N]; 6],
    );
}

/// Quadratic laws without coupling of membrane and bending.
pub struct Uncoupled {
    materials: Vec<Material>,
    constitutions: Vec<Constitution>,
    /// Rest forms a11 a12 a22 b11 b12 b22 per point.
    rest: Vec<Strain>,
    /// Per point, the symmetric matrix `C` (11 12 13 22 23 33) with `h/4 m.C.m / 2` and `h^3/12 m.C.m / 2` the membrane and bending energy.
    matrix: Vec<[f64; 6]>,
}

impl Uncoupled {
    /// Membrane and bending factors `h/4` and `h^3/12` of a face.
    #[inline(always)]
    fn factors(&self, face: usize) -> [f64; 2] {
        factors(self.materials[face].thickness)
    }
}

impl Constitutive for Uncoupled {
    fn new(materials: Vec<Material>, constitutions: Vec<Constitution>, points: usize) -> Self {
        Uncoupled { materials, constitutions, rest: vec![[0.0; 6]; points], matrix: vec![[0.0; 6]; points] }
    }

    fn set_rest(&mut self, face: usize, point: usize, rest: &Strain, weight: f64) {
        let constitution = self.constitutions.get(face).copied().unwrap_or_default();
        self.rest[point] = *rest;
        self.matrix[point] = constitution.matrix(&self.materials[face], [rest[0], rest[1], rest[2]], weight);
    }

    #[inline(always)]
    fn rest(&self, point: usize) -> &Strain {
        &self.rest[point]
    }

    fn couples(&self, _: usize) -> bool {
        false
    }

    #[inline(always)]
    fn elastic(&self, face: usize, point: usize, eps: &Strain) -> (Strain, f64) {
        let rest = &self.rest[point];
        let d: [f64; 6] = std::array::from_fn(|i| eps[i] - rest[i]);
        let stress = self.small_strain(face, point, &d);
        (stress, 0.5 * stress.iter().zip(&d).map(|(s, d)| s * d).sum::<f64>())
    }

    #[inline(always)]
    fn linearised(&self, face: usize, point: usize, eps: &Strain, d: &Strain) -> Strain {
        self.elastic(face, point, &std::array::from_fn(|i| eps[i] + d[i])).0
    }

    #[inline(always)]
    fn small_strain(&self, face: usize, point: usize, d: &Strain) -> Strain {
        let (c, [membrane, bending]) = (&self.matrix[point], self.factors(face));
        let n = times(c, [d[0], d[1], d[2]]).map(|v| membrane * v);
        let m = times(c, [d[3], d[4], d[5]]).map(|v| bending * v);
        [n[0], n[1], n[2], m[0], m[1], m[2]]
    }

    #[inline(always)]
    fn set_rows<const N: usize>(
        &self,
        (face, point, _): (usize, usize, &Strain),
        viscous: f64,
        _: bool,
        jacobian: &[[f64; N]; 6],
        rows: &mut [[f64; N]; 6],
    ) {
        for (part, factor) in self.factors(face).into_iter().enumerate() {
            let c = self.matrix[point].map(|v| v * (factor * (1.0 + viscous)));
            for q in 0..N {
                let column = times(&c, std::array::from_fn(|i| jacobian[3 * part + i][q]));
                for i in 0..3 {
                    rows[3 * part + i][q] = column[i];
                }
            }
        }
    }
}

/// Any laws.
pub struct General {
    materials: Vec<Material>,
    constitutions: Vec<Constitution>,
    rest: Vec<Strain>,
    /// Stiffness at small strain, per point; of quadratic laws, at any.
    stiffness: Vec<Stiffness>,
    /// Weights of the points.
    weights: Vec<f64>,
}

impl General {
    fn constitution(&self, face: usize) -> Constitution {
        self.constitutions.get(face).copied().unwrap_or_default()
    }

    fn respond<const TANGENT: bool>(&self, face: usize, point: usize, eps: &Strain) -> Response {
        self.constitution(face).respond::<TANGENT>(
            &self.materials[face],
            &self.rest[point],
            &self.stiffness[point],
            self.weights[point],
            eps,
        )
    }
}

impl Constitutive for General {
    fn new(materials: Vec<Material>, constitutions: Vec<Constitution>, points: usize) -> Self {
        let stiffness = vec![[[0.0; 6]; 3]; points];
        General { materials, constitutions, rest: vec![[0.0; 6]; points], stiffness, weights: vec![0.0; points] }
    }

    fn set_rest(&mut self, face: usize, point: usize, rest: &Strain, weight: f64) {
        self.rest[point] = *rest;
        self.weights[point] = weight;
        self.stiffness[point] = self.constitution(face).stiffness(&self.materials[face], [rest[0], rest[1], rest[2]], weight);
    }

    fn rest(&self, point: usize) -> &Strain {
        &self.rest[point]
    }

    fn couples(&self, face: usize) -> bool {
        self.constitution(face).couples()
    }

    fn elastic(&self, face: usize, point: usize, eps: &Strain) -> (Strain, f64) {
        let response = self.respond::<false>(face, point, eps);
        (response.stress, response.energy)
    }

    fn linearised(&self, face: usize, point: usize, eps: &Strain, d: &Strain) -> Strain {
        let response = self.respond::<true>(face, point, eps);
        std::array::from_fn(|i| response.stress[i] + (0..6).map(|j| response.tangent[i][j] * d[j]).sum::<f64>())
    }

    fn small_strain(&self, _: usize, point: usize, d: &Strain) -> Strain {
        stress_of(&self.stiffness[point], d)
    }

    fn set_rows<const N: usize>(
        &self,
        (face, point, eps): (usize, usize, &Strain),
        viscous: f64,
        semidefinite: bool,
        jacobian: &[[f64; N]; 6],
        rows: &mut [[f64; N]; 6],
    ) {
        let mut tangent = self.respond::<true>(face, point, eps).tangent;
        if semidefinite && matches!(self.constitution(face), Constitution::NeoHookean | Constitution::BiotBending) {
            let rest = &self.rest[point];
            project_tangent(&mut tangent, [rest[0], rest[1], rest[2]], self.materials[face].thickness);
        }
        if viscous > 0.0 {
            let stiffness = expand(&self.stiffness[point]);
            for (row, s) in tangent.iter_mut().zip(&stiffness) {
                row.iter_mut().zip(s).for_each(|(t, s)| *t += viscous * s);
            }
        }
        for (row, t) in rows.iter_mut().zip(&tangent) {
            *row = [0.0; N];
            for (factor, j) in t.iter().zip(jacobian) {
                row.iter_mut().zip(j).for_each(|(r, j)| *r += factor * j);
            }
        }
    }
}

//! Koiter energy of a shell: membrane and bending, with Kelvin-Voigt damping, for any element (seed A, section 3; PHYSICS A2).
//!
//! Per face and integration point, with `S = abar^-1` and `||M||^2 = alpha/2 tr(M)^2 + beta tr(M^2)`:
//! `w sqrt(det abar) ( h/4 ||S (a - abar)||^2 + h^3/12 ||S (b - bbar)||^2 )`, and for damping the same of the change of `a` and `b` since
//! the last step, times `eta / dt`. Bodies of matter other than St. Venant-Kirchhoff are not here.

use super::element::{Element, Strain};
use super::rest::Forms;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::Vector3;

/// Material of one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Thickness [m].
    pub thickness: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus: f64,
    /// Poisson's ratio [1].
    pub poissons_ratio: f64,
}

impl Material {
    /// Plane-stress Lame parameters `alpha = E nu / (1 - nu^2)` and `beta = E / (2 (1 + nu))` [Pa].
    pub fn lame(&self) -> [f64; 2] {
        let (e, nu) = (self.youngs_modulus, self.poissons_ratio);
        [e * nu / (1.0 - nu * nu), e / (2.0 * (1.0 + nu))]
    }
}

/// A shell as the rest of the program sees it, whatever its element.
pub trait Shell: Potential {
    /// Number of unknowns.
    fn unknowns(&self) -> usize;
    /// Number of faces.
    fn faces(&self) -> usize;
    /// Integration points per face.
    fn points(&self) -> usize;
    /// Reference directors.
    fn directors(&self) -> &[Vector3<f64>];
    /// Puts directors back.
    fn set_directors(&mut self, directors: &[Vector3<f64>]);
    /// Stresses of the geometric stiffness, 6 per point: part of the state, since they lag.
    fn lagged(&self) -> Vec<f64>;
    /// Puts lagged stresses back.
    fn set_lagged(&mut self, lagged: &[f64]);
    /// Rest forms, one per point.
    fn set_rest(&mut self, rest: &[Forms]);
    /// Remembers the forms at `x`, the start of a step of size `dt` [s], for damping. Nothing without viscosity.
    fn start_step(&mut self, x: &[f64], dt: f64);
    /// Forms at `x`, one per point.
    fn forms(&self, x: &[f64]) -> Vec<Strain>;
    /// Tangent vectors at `x` [m], one pair per point.
    fn tangents(&self, x: &[f64]) -> Vec<[Vector3<f64>; 2]>;
    /// Energies at `x` [J]: membrane, bending.
    fn energies(&self, x: &[f64]) -> [f64; 2];
    /// Weights of the integration points in the reference triangle; they add up to 1/2.
    fn weights(&self) -> &'static [f64];
}

/// Viscous part: ratio `eta / dt` and the forms at the start of the step.
struct Damping {
    viscosity: f64,
    ratio: f64,
    start: Vec<Strain>,
}

/// Koiter energy over an element.
pub struct Koiter<E, const N: usize, const P: usize> {
    element: E,
    scatter: Scatter<N>,
    materials: Vec<Material>,
    /// Rest forms a11 a12 a22 b11 b12 b22 per point.
    rest: Vec<Strain>,
    /// Per point, the symmetric matrix `C` (11 12 13 22 23 33) with `m.C.m / 2 = w sqrt(det abar) ||S m||^2`.
    stiffness: Vec<[f64; 6]>,
    lagged: Vec<Strain>,
    /// Directors and lagged stresses to put back when an iteration fails.
    saved: (Vec<Vector3<f64>>, Vec<Strain>),
    damping: Option<Damping>,
}

/// `C m` for `C` by its upper triangle.
#[inline(always)]
fn times(c: &[f64; 6], m: [f64; 3]) -> [f64; 3] {
    [c[0] * m[0] + c[1] * m[1] + c[2] * m[2], c[1] * m[0] + c[3] * m[1] + c[4] * m[2], c[2] * m[0] + c[4] * m[1] + c[5] * m[2]]
}

/// Matrix `C` with `m.C.m / 2 = weight sqrt(det abar) (alpha/2 tr(S M)^2 + beta tr((S M)^2))`, `m = (M11, M12, M22)`.
fn norm_matrix(abar: [f64; 3], [alpha, beta]: [f64; 2], weight: f64) -> [f64; 6] {
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

/// Projects the membrane stress (11, 12, 22; derivative of the energy in a11, a12, a22) onto positive semidefinite ones in the metric `abar`.
fn project(w: &mut Strain, abar: [f64; 3]) {
    // With abar = L L^T, the physical stress is L^T W L; its negative eigenvalue is cut off.
    let l11 = abar[0].sqrt();
    let l21 = abar[1] / l11;
    let l22 = (abar[2] - l21 * l21).max(f64::MIN_POSITIVE).sqrt();
    let (w11, w12, w22) = (w[0], 0.5 * w[1], w[2]);
    let s11 = l11 * l11 * w11 + 2.0 * l11 * l21 * w12 + l21 * l21 * w22;
    let s12 = l22 * (l11 * w12 + l21 * w22);
    let s22 = l22 * l22 * w22;
    let (mean, half) = (0.5 * (s11 + s22), 0.5 * (s11 - s22));
    let radius = half.hypot(s12);
    let (low, high) = (mean - radius, mean + radius);
    if low >= 0.0 {
        return;
    }
    if high <= 0.0 {
        w[..3].fill(0.0);
        return;
    }
    // high times the projector onto its eigenvector, pulled back by L^-1.
    let scale = high / (2.0 * radius);
    let (t11, t12, t22) = (scale * (radius + half), scale * s12, scale * (radius - half));
    let (i11, i21, i22) = (1.0 / l11, -l21 / (l11 * l22), 1.0 / l22);
    w[0] = i11 * i11 * t11 + 2.0 * i11 * i21 * t12 + i21 * i21 * t22;
    w[1] = 2.0 * i22 * (i11 * t12 + i21 * t22);
    w[2] = i22 * i22 * t22;
}

impl<E: Element<N, P>, const N: usize, const P: usize> Koiter<E, N, P> {
    /// `materials`: one per face. `viscosity`: `eta` [s], if any. The rest forms are those of [`Shell::set_rest`], which must be called first.
    pub fn new(element: E, materials: Vec<Material>, viscosity: Option<f64>) -> Self {
        let points = element.faces() * P;
        let unbound = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Koiter {
            scatter: unbound,
            materials,
            rest: vec![[0.0; 6]; points],
            stiffness: vec![[0.0; 6]; points],
            lagged: vec![[0.0; 6]; points],
            saved: Default::default(),
            damping: viscosity.map(|viscosity| Damping { viscosity, ratio: 0.0, start: vec![[0.0; 6]; points] }),
            element,
        }
    }

    /// Membrane and bending factors `h/4` and `h^3/12` of a face.
    #[inline(always)]
    fn factors(&self, face: usize) -> [f64; 2] {
        let h = self.materials[face].thickness;
        [0.25 * h, h * h * h / 12.0]
    }

    /// Stress (derivative of the energy in each form) at a point for forms `eps`, without damping, and the energy.
    #[inline(always)]
    fn elastic(&self, face: usize, point: usize, eps: &Strain) -> (Strain, f64) {
        let (c, rest, [membrane, bending]) = (&self.stiffness[point], &self.rest[point], self.factors(face));
        let d: [f64; 6] = std::array::from_fn(|i| eps[i] - rest[i]);
        let n = times(c, [d[0], d[1], d[2]]).map(|v| membrane * v);
        let m = times(c, [d[3], d[4], d[5]]).map(|v| bending * v);
        let stress = [n[0], n[1], n[2], m[0], m[1], m[2]];
        (stress, 0.5 * stress.iter().zip(&d).map(|(s, d)| s * d).sum::<f64>())
    }

    /// Stress with damping, and the energy of both.
    #[inline(always)]
    fn stress(&self, face: usize, point: usize, eps: &Strain) -> (Strain, f64) {
        let (mut stress, mut energy) = self.elastic(face, point, eps);
        if let Some(damping) = &self.damping {
            let (c, start, f) = (&self.stiffness[point], &damping.start[point], self.factors(face).map(|f| f * damping.ratio));
            let d: [f64; 6] = std::array::from_fn(|i| eps[i] - start[i]);
            let n = times(c, [d[0], d[1], d[2]]).map(|v| f[0] * v);
            let m = times(c, [d[3], d[4], d[5]]).map(|v| f[1] * v);
            for (i, v) in n.into_iter().chain(m).enumerate() {
                stress[i] += v;
                energy += 0.5 * v * d[i];
            }
        }
        (stress, energy)
    }

    /// Geometry of a face at `x`.
    #[inline(always)]
    fn geometry(&self, face: usize, x: &[f64]) -> E::Geometry {
        let u = if self.bound() {
            self.scatter.gather(face, x)
        } else {
            self.element.stencil(face).map(|s| if s == usize::MAX { 0.0 } else { x[s] })
        };
        self.element.geometry(face, &u)
    }

    /// Runs a task on all faces at `x`.
    fn run(&self, x: &[f64], task: Task) -> f64 {
        pulp::Arch::new().dispatch(Faces { shell: self, x, task })
    }

    /// Energy [J].
    #[inline(always)]
    fn sum_energy(&self, x: &[f64]) -> f64 {
        let mut energy = 0.0;
        for face in 0..self.element.faces() {
            let forms = self.element.forms(&self.geometry(face, x));
            for (k, eps) in forms.iter().enumerate() {
                energy += self.stress(face, P * face + k, eps).1;
            }
        }
        energy
    }

    /// Adds the gradient; returns the energy [J].
    #[inline(always)]
    fn add_gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let mut energy = 0.0;
        for face in 0..self.element.faces() {
            let geometry = self.geometry(face, x);
            let (forms, jacobian) = (self.element.forms(&geometry), self.element.jacobian(&geometry));
            let mut gradient = [0.0; N];
            for k in 0..P {
                let (stress, e) = self.stress(face, P * face + k, &forms[k]);
                energy += e;
                for i in 0..6 {
                    for (g, j) in gradient.iter_mut().zip(&jacobian[k][i]) {
                        *g += stress[i] * j;
                    }
                }
            }
            self.scatter.add_gradient(face, &gradient, into);
        }
        energy
    }

    /// Adds gradient and Hessian; returns the energy [J].
    #[inline(always)]
    fn add_all(&self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        let mut energy = 0.0;
        let viscous = 1.0 + self.damping.as_ref().map_or(0.0, |d| d.ratio);
        for face in 0..self.element.faces() {
            let geometry = self.geometry(face, x);
            let forms = self.element.forms(&geometry);
            let jacobian = self.element.jacobian(&geometry);
            let factors = self.factors(face).map(|f| f * viscous);
            let (mut gradient, mut hessian) = ([0.0; N], [[0.0; N]; N]);
            let (mut weights, mut material) = ([[0.0; 6]; P], [[[0.0; N]; 6]; P]);
            for k in 0..P {
                let point = P * face + k;
                let (stress, e) = self.stress(face, point, &forms[k]);
                energy += e;
                weights[k] = match curvature {
                    Curvature::Mixed => self.lagged[point],
                    Curvature::Projected => {
                        let mut w = stress;
                        let rest = &self.rest[point];
                        project(&mut w, [rest[0], rest[1], rest[2]]);
                        w
                    }
                };
                for i in 0..6 {
                    for (g, j) in gradient.iter_mut().zip(&jacobian[k][i]) {
                        *g += stress[i] * j;
                    }
                }
                set_material_rows(&jacobian[k], &self.stiffness[point], factors, &mut material[k]);
            }
            add_material_stiffness(&jacobian, &material, E::STRETCHING, &mut hessian);
            self.element.hessian(&geometry, &weights, curvature == Curvature::Projected, &mut hessian);
            self.scatter.add_gradient(face, &gradient, into);
            self.scatter.add_hessian(face, &hessian, into);
        }
        energy
    }

    /// Sets the stresses that the linearised law gives after the movement `dx`.
    #[inline(always)]
    fn extrapolate_stresses(&self, x: &[f64], dx: &[f64], lagged: &mut [Strain]) {
        for face in 0..self.element.faces() {
            let geometry = self.geometry(face, x);
            let du = self.scatter.gather(face, dx);
            let (mut forms, jacobian) = (self.element.forms(&geometry), self.element.jacobian(&geometry));
            for k in 0..P {
                for i in 0..6 {
                    forms[k][i] += jacobian[k][i].iter().zip(&du).map(|(j, d)| j * d).sum::<f64>();
                }
                lagged[P * face + k] = self.stress(face, P * face + k, &forms[k]).0;
            }
        }
    }

    /// Whether the scatter has been made; before that, stencils are looked up.
    fn bound(&self) -> bool {
        self.scatter.elements() > 0
    }
}

impl<E: Element<N, P>, const N: usize, const P: usize> Potential for Koiter<E, N, P> {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        for face in 0..self.element.faces() {
            visit(&self.element.stencil(face));
        }
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        let element = &self.element;
        self.scatter = Scatter::new((0..element.faces()).map(|f| element.stencil(f)), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        self.run(x, Task::Energy)
    }

    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        self.run(x, Task::Assemble(curvature, into))
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        self.run(x, Task::Gradient(into))
    }

    fn save(&mut self) {
        self.saved.0.clear();
        self.saved.0.extend_from_slice(self.element.directors());
        self.saved.1.clear();
        self.saved.1.extend_from_slice(&self.lagged);
    }

    fn put_back(&mut self) {
        self.element.set_directors(&self.saved.0);
        self.lagged.copy_from_slice(&self.saved.1);
    }

    fn stiffness_along(&self, x: &[f64], y: &[f64]) -> f64 {
        let mut sum = 0.0;
        for face in 0..self.element.faces() {
            let jacobian = self.element.jacobian(&self.geometry(face, x));
            let (dy, factors) = (self.scatter.gather(face, y), self.factors(face));
            for k in 0..P {
                let e: [f64; 6] = std::array::from_fn(|i| jacobian[k][i].iter().zip(&dy).map(|(j, d)| j * d).sum());
                for (part, factor) in factors.into_iter().enumerate() {
                    let m = [e[3 * part], e[3 * part + 1], e[3 * part + 2]];
                    let c = times(&self.stiffness[P * face + k], m);
                    sum += factor * (c[0] * m[0] + c[1] * m[1] + c[2] * m[2]);
                }
            }
        }
        sum
    }

    fn prepare(&mut self, x: &mut [f64]) {
        self.element.reframe(x);
    }

    fn extrapolate(&mut self, x: &[f64], dx: &[f64]) {
        let mut lagged = std::mem::take(&mut self.lagged);
        self.run(x, Task::Extrapolate(dx, &mut lagged));
        self.lagged = lagged;
    }

    fn restart(&mut self, x: &[f64]) {
        for face in 0..self.element.faces() {
            let forms = self.element.forms(&self.geometry(face, x));
            for (k, eps) in forms.iter().enumerate() {
                self.lagged[P * face + k] = self.stress(face, P * face + k, eps).0;
            }
        }
    }
}

/// What is done with all faces in one go.
enum Task<'a> {
    Energy,
    Gradient(&'a mut System),
    Assemble(Curvature, &'a mut System),
    Extrapolate(&'a [f64], &'a mut [Strain]),
}

/// A loop over faces, compiled once more for the wide registers of newer processors; only what is inlined into it gets them. Operations
/// are neither reordered nor contracted, so the results are the same bit by bit.
struct Faces<'a, E, const N: usize, const P: usize> {
    shell: &'a Koiter<E, N, P>,
    x: &'a [f64],
    task: Task<'a>,
}

impl<E: Element<N, P>, const N: usize, const P: usize> pulp::WithSimd for Faces<'_, E, N, P> {
    /// Energy [J], where the task has one.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f64 {
        let Faces { shell, x, task } = self;
        match task {
            Task::Energy => shell.sum_energy(x),
            Task::Gradient(into) => shell.add_gradient(x, into),
            Task::Assemble(curvature, into) => shell.add_all(x, curvature, into),
            Task::Extrapolate(dx, lagged) => {
                shell.extrapolate_stresses(x, dx, lagged);
                0.0
            }
        }
    }
}

/// Sets the rows `f0 C J` of the membrane, then `f1 C J` of bending, of one point.
#[inline(always)]
fn set_material_rows<const N: usize>(jacobian: &[[f64; N]; 6], c: &[f64; 6], factors: [f64; 2], rows: &mut [[f64; N]; 6]) {
    for (part, factor) in factors.into_iter().enumerate() {
        let c = c.map(|v| v * factor);
        for q in 0..N {
            let column = times(&c, std::array::from_fn(|i| jacobian[3 * part + i][q]));
            for i in 0..3 {
                rows[3 * part + i][q] = column[i];
            }
        }
    }
}

/// Adds `J^T (C J)` to the lower triangle. The first `stretching` unknowns are those that the membrane rows depend on.
///
/// In tiles that stay in registers over all rows; `N` is a multiple of 6. What a tile adds above the diagonal is never read.
#[inline(always)]
fn add_material_stiffness<const N: usize, const P: usize>(
    jacobian: &[[[f64; N]; 6]; P],
    material: &[[[f64; N]; 6]; P],
    stretching: usize,
    hessian: &mut [[f64; N]; N],
) {
    const { assert!(N.is_multiple_of(6)) };
    for a in 0..N / 3 {
        for b in 0..=a / 2 {
            let first_row = if 3 * a < stretching && 6 * b < stretching { 0 } else { 3 };
            let mut tile = [[0.0; 6]; 3];
            for k in 0..P {
                for c in first_row..6 {
                    let (left, right) = (&jacobian[k][c].as_chunks::<3>().0[a], &material[k][c].as_chunks::<6>().0[b]);
                    for i in 0..3 {
                        for j in 0..6 {
                            tile[i][j] += left[i] * right[j];
                        }
                    }
                }
            }
            for i in 0..3 {
                for (h, t) in hessian[3 * a + i].as_chunks_mut::<6>().0[b].iter_mut().zip(&tile[i]) {
                    *h += t;
                }
            }
        }
    }
}

impl<E: Element<N, P>, const N: usize, const P: usize> Shell for Koiter<E, N, P> {
    fn unknowns(&self) -> usize {
        self.element.unknowns()
    }

    fn faces(&self) -> usize {
        self.element.faces()
    }

    fn points(&self) -> usize {
        P
    }

    fn directors(&self) -> &[Vector3<f64>] {
        self.element.directors()
    }

    fn set_directors(&mut self, directors: &[Vector3<f64>]) {
        self.element.set_directors(directors);
    }

    fn lagged(&self) -> Vec<f64> {
        self.lagged.iter().flatten().copied().collect()
    }

    fn set_lagged(&mut self, lagged: &[f64]) {
        for (to, from) in self.lagged.iter_mut().zip(lagged.chunks_exact(6)) {
            to.copy_from_slice(from);
        }
    }

    fn set_rest(&mut self, rest: &[Forms]) {
        for (point, forms) in rest.iter().enumerate() {
            let (face, k) = (point / P, point % P);
            let [a, b] = [forms.a, forms.b];
            self.rest[point] = [a[0], a[1], a[2], b[0], b[1], b[2]];
            self.stiffness[point] = norm_matrix(a, self.materials[face].lame(), E::WEIGHTS[k]);
        }
    }

    fn start_step(&mut self, x: &[f64], dt: f64) {
        let Some(viscosity) = self.damping.as_ref().map(|d| d.viscosity) else { return };
        let start = self.forms(x);
        self.damping = Some(Damping { viscosity, ratio: viscosity / dt, start });
    }

    fn forms(&self, x: &[f64]) -> Vec<Strain> {
        (0..self.element.faces()).flat_map(|face| self.element.forms(&self.geometry(face, x))).collect()
    }

    fn tangents(&self, x: &[f64]) -> Vec<[Vector3<f64>; 2]> {
        (0..self.element.faces()).flat_map(|face| self.element.tangents(&self.geometry(face, x))).collect()
    }

    fn weights(&self) -> &'static [f64] {
        &E::WEIGHTS
    }

    fn energies(&self, x: &[f64]) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for face in 0..self.element.faces() {
            for (k, eps) in self.element.forms(&self.geometry(face, x)).iter().enumerate() {
                let point = P * face + k;
                let (stress, _) = self.elastic(face, point, eps);
                for i in 0..6 {
                    sums[i / 3] += 0.5 * stress[i] * (eps[i] - self.rest[point][i]);
                }
            }
        }
        sums
    }
}

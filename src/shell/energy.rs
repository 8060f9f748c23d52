//! Koiter energy of a shell: membrane and bending, with Kelvin-Voigt damping, for any element (Chen et al. 2018, section 3).
//!
//! Per face and integration point, with `S = abar^-1` and `||M||^2 = alpha/2 tr(M)^2 + beta tr(M^2)`:
//! `w sqrt(det abar) ( h/4 ||S (a - abar)||^2 + h^3/12 ||S (b - bbar)||^2 )`, or what another [`Constitution`] makes of the six forms, and for
//! damping the quadratic energy at small strain of the change of `a` and `b` since the last step, times `eta / dt`. The laws are not here.

use super::constitutive::{Constitutive, General, Uncoupled};
use super::element::{Element, Strain};
use super::material::{Constitution, Material, split};
use super::projection::project_stress;
use super::rest::Forms;
use crate::sparse::{Contribution, Curvature, Numbering, Pattern, Potential, Scatter, System, collect, fill};
use nalgebra::Vector3;
use std::ops::Range;

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
    /// Sets the factors on the stiffness of the faces, > 0, one each (none at all: 1); in force from the next [`Shell::set_rest`] on.
    fn set_stiffness(&mut self, factors: Vec<f64>);
    /// Remembers the forms at `x`, the start of a step of size `dt` [s], for damping. Nothing without viscosity.
    fn start_step(&mut self, x: &[f64], dt: f64);
    /// Whether it has viscosity.
    fn is_viscous(&self) -> bool;
    /// Sets the forms, one per point, whose difference from the present ones over `dt` [s] is the rate of strain of damping. Nothing without
    /// viscosity.
    fn set_strain_start(&mut self, start: Vec<Strain>, dt: f64);
    /// Angles [rad], one per director unknown, by which the directors at `x` are turned from others of an earlier shape, about their edges.
    fn turns(&self, x: &[f64], from: &[Vector3<f64>]) -> Vec<f64>;
    /// Forms at `x`, one per point.
    fn forms(&self, x: &[f64]) -> Vec<Strain>;
    /// Tangent vectors at `x` [m], one pair per point.
    fn tangents(&self, x: &[f64]) -> Vec<[Vector3<f64>; 2]>;
    /// Energies at `x` [J]: membrane, that of the same first form with the rest's second form; bending, what the present one adds to it. For
    /// laws that couple the two, the bending part holds the coupling and may be negative.
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
pub struct Koiter<E, const N: usize, const P: usize, L = Uncoupled> {
    element: E,
    scatter: Scatter<N>,
    law: L,
    /// Factors on the stiffness of the faces; empty for 1.
    stiffness: Vec<f64>,
    lagged: Vec<Strain>,
    /// Directors and lagged stresses to put back when an iteration fails.
    saved: (Vec<Vector3<f64>>, Vec<Strain>),
    damping: Option<Damping>,
}

impl<E: Element<N, P>, const N: usize, const P: usize> Koiter<E, N, P> {
    /// Isotropic St. Venant-Kirchhoff in plane stress. `materials`: one per face. `viscosity`: `eta` [s], if any. The rest forms are those of
    /// [`Shell::set_rest`], which must be called first.
    pub fn new(element: E, materials: Vec<Material>, viscosity: Option<f64>) -> Self {
        Koiter::with_law(element, materials, Vec::new(), viscosity)
    }
}

/// A shell over an element, with the cheapest law that all its faces have. `constitutions`: one per face, or none at all for the default;
/// the rest as in [`Koiter::new`].
pub fn koiter<E: Element<N, P> + 'static, const N: usize, const P: usize>(
    element: E,
    materials: Vec<Material>,
    constitutions: Vec<Constitution>,
    viscosity: Option<f64>,
) -> Box<dyn Shell> {
    if constitutions.iter().all(Constitution::is_uncoupled) {
        Box::new(Koiter::<E, N, P, Uncoupled>::with_law(element, materials, constitutions, viscosity))
    } else {
        Box::new(Koiter::<E, N, P, General>::with_law(element, materials, constitutions, viscosity))
    }
}

impl<E: Element<N, P>, const N: usize, const P: usize, L: Constitutive> Koiter<E, N, P, L> {
    /// With a law of one's choice, which must be able to hold all `constitutions`: one per face, or none at all.
    pub fn with_law(element: E, materials: Vec<Material>, constitutions: Vec<Constitution>, viscosity: Option<f64>) -> Self {
        let points = element.faces() * P;
        let unbound = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        Koiter {
            scatter: unbound,
            law: L::new(materials, constitutions, points),
            stiffness: Vec::new(),
            lagged: vec![[0.0; 6]; points],
            saved: Default::default(),
            damping: viscosity.map(|viscosity| Damping { viscosity, ratio: 0.0, start: vec![[0.0; 6]; points] }),
            element,
        }
    }

    /// Stress with damping, and the energy of both.
    #[inline(always)]
    fn stress(&self, face: usize, point: usize, eps: &Strain) -> (Strain, f64) {
        let (mut stress, mut energy) = self.law.elastic(face, point, eps);
        energy += self.add_viscous(face, point, eps, &mut stress);
        (stress, energy)
    }

    /// Adds the stress of damping at forms `eps`; returns its energy.
    #[inline(always)]
    fn add_viscous(&self, face: usize, point: usize, eps: &Strain, stress: &mut Strain) -> f64 {
        let Some(damping) = &self.damping else { return 0.0 };
        let start = &damping.start[point];
        let d: [f64; 6] = std::array::from_fn(|i| eps[i] - start[i]);
        let mut energy = 0.0;
        for (i, v) in self.law.small_strain(face, point, &d).into_iter().enumerate() {
            let v = damping.ratio * v;
            stress[i] += v;
            energy += 0.5 * v * d[i];
        }
        energy
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

    /// Energy [J].
    fn sum_energy(&self, x: &[f64]) -> f64 {
        collect(self.element.faces(), 0.0, |faces, energies| self.run(x, faces, Task::Energy(energies))).iter().sum()
    }

    /// Runs a task on some faces at `x`.
    fn run(&self, x: &[f64], faces: Range<usize>, task: Task<N>) {
        pulp::Arch::new().dispatch(Faces { shell: self, x, faces, task });
    }

    /// Energy of one face [J].
    #[inline(always)]
    fn energy_of(&self, face: usize, x: &[f64]) -> f64 {
        let forms = self.element.forms(&self.geometry(face, x));
        let mut energy = 0.0;
        for (k, eps) in forms.iter().enumerate() {
            energy += self.stress(face, P * face + k, eps).1;
        }
        energy
    }

    /// Gradient and energy [J] of one face.
    #[inline(always)]
    fn gradient_of(&self, face: usize, x: &[f64]) -> ([f64; N], f64) {
        let geometry = self.geometry(face, x);
        let (forms, jacobian) = (self.element.forms(&geometry), self.element.jacobian(&geometry));
        let (mut gradient, mut energy) = ([0.0; N], 0.0);
        for k in 0..P {
            let (stress, e) = self.stress(face, P * face + k, &forms[k]);
            energy += e;
            for i in 0..6 {
                for (g, j) in gradient.iter_mut().zip(&jacobian[k][i]) {
                    *g += stress[i] * j;
                }
            }
        }
        (gradient, energy)
    }

    /// Sets energy [J], gradient and Hessian of one face.
    #[inline(always)]
    fn set_all(&self, face: usize, x: &[f64], curvature: Curvature, into: &mut Contribution<N>) {
        let viscous = self.damping.as_ref().map_or(0.0, |d| d.ratio);
        let semidefinite = curvature == Curvature::Projected;
        let geometry = self.geometry(face, x);
        let forms = self.element.forms(&geometry);
        let jacobian = self.element.jacobian(&geometry);
        let Contribution { energy, gradient, hessian } = into;
        (*energy, *gradient, *hessian) = (0.0, [0.0; N], [[0.0; N]; N]);
        let (mut weights, mut material) = ([[0.0; 6]; P], [[[0.0; N]; 6]; P]);
        for k in 0..P {
            let point = P * face + k;
            let (stress, e) = self.stress(face, point, &forms[k]);
            *energy += e;
            weights[k] = match curvature {
                Curvature::Mixed | Curvature::Geometric => self.lagged[point],
                Curvature::Projected => {
                    let mut w = self.lagged[point];
                    let rest = self.law.rest(point);
                    project_stress(&mut w, [rest[0], rest[1], rest[2]]);
                    w
                }
            };
            for i in 0..6 {
                for (g, j) in gradient.iter_mut().zip(&jacobian[k][i]) {
                    *g += stress[i] * j;
                }
            }
            if curvature != Curvature::Geometric {
                self.law.set_rows((face, point, &forms[k]), viscous, semidefinite, &jacobian[k], &mut material[k]);
            }
        }
        if curvature != Curvature::Geometric {
            add_material_stiffness(&jacobian, &material, E::STRETCHING, hessian);
        }
        self.element.hessian(&geometry, &weights, semidefinite, hessian);
    }

    /// Sets the stresses that the linearised law gives after the movement `dx`.
    #[inline(always)]
    fn extrapolate_stresses(&self, face: usize, x: &[f64], dx: &[f64], lagged: &mut [Strain]) {
        let geometry = self.geometry(face, x);
        let du = self.scatter.gather(face, dx);
        let (forms, jacobian) = (self.element.forms(&geometry), self.element.jacobian(&geometry));
        for k in 0..P {
            let d: Strain = std::array::from_fn(|i| jacobian[k][i].iter().zip(&du).map(|(j, d)| j * d).sum::<f64>());
            let mut stress = self.law.linearised(face, P * face + k, &forms[k], &d);
            self.add_viscous(face, P * face + k, &std::array::from_fn(|i| forms[k][i] + d[i]), &mut stress);
            lagged[k] = stress;
        }
    }

    /// What the stiffness of the material makes of a movement `v`.
    #[inline(always)]
    fn material_forces(&self, face: usize, x: &[f64], v: &[f64]) -> [f64; N] {
        let viscous = self.damping.as_ref().map_or(0.0, |d| d.ratio);
        let geometry = self.geometry(face, x);
        let dv = self.scatter.gather(face, v);
        let (forms, jacobian) = (self.element.forms(&geometry), self.element.jacobian(&geometry));
        let mut gradient = [0.0; N];
        for k in 0..P {
            let point = P * face + k;
            let d: Strain = std::array::from_fn(|i| jacobian[k][i].iter().zip(&dv).map(|(j, d)| j * d).sum::<f64>());
            let (before, after) = (self.law.elastic(face, point, &forms[k]).0, self.law.linearised(face, point, &forms[k], &d));
            let rate = self.law.small_strain(face, point, &d);
            for i in 0..6 {
                let stress = after[i] - before[i] + viscous * rate[i];
                for (g, j) in gradient.iter_mut().zip(&jacobian[k][i]) {
                    *g += stress * j;
                }
            }
        }
        gradient
    }

    /// Whether the scatter has been made; before that, stencils are looked up.
    fn bound(&self) -> bool {
        self.scatter.elements() > 0
    }
}

impl<E: Element<N, P>, const N: usize, const P: usize, L: Constitutive> Potential for Koiter<E, N, P, L> {
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
        self.sum_energy(x)
    }

    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        self.scatter.add_all(into, |faces, parts| self.run(x, faces, Task::Assemble(curvature, parts)))
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let parts = collect(self.element.faces(), ([0.0; N], 0.0), |faces, parts| self.run(x, faces, Task::Gradient(parts)));
        for (face, (gradient, _)) in parts.iter().enumerate() {
            self.scatter.add_gradient(face, gradient, into);
        }
        parts.iter().map(|(_, energy)| energy).sum()
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
            let dy = self.scatter.gather(face, y);
            for k in 0..P {
                let e: Strain = std::array::from_fn(|i| jacobian[k][i].iter().zip(&dy).map(|(j, d)| j * d).sum());
                sum += self.law.small_strain(face, P * face + k, &e).iter().zip(&e).map(|(s, e)| s * e).sum::<f64>();
            }
        }
        sum
    }

    fn add_material_forces(&self, x: &[f64], v: &[f64], into: &mut System) {
        let parts = collect(self.element.faces(), [0.0; N], |faces, parts| self.run(x, faces, Task::MaterialForces(v, parts)));
        for (face, gradient) in parts.iter().enumerate() {
            self.scatter.add_gradient(face, gradient, into);
        }
    }

    fn prepare(&mut self, x: &mut [f64]) {
        self.element.reframe(x);
    }

    fn extrapolate(&mut self, x: &[f64], dx: &[f64]) {
        let mut lagged = std::mem::take(&mut self.lagged);
        fill(&mut lagged, P, |faces, part| self.run(x, faces, Task::Extrapolate(dx, part)));
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

/// What is done with some faces in one go; one place in the slice for each face, or integration point.
enum Task<'a, const N: usize> {
    Energy(&'a mut [f64]),
    Gradient(&'a mut [([f64; N], f64)]),
    Assemble(Curvature, &'a mut [Contribution<N>]),
    Extrapolate(&'a [f64], &'a mut [Strain]),
    MaterialForces(&'a [f64], &'a mut [[f64; N]]),
}

/// A loop over faces, compiled once more for the wide registers of newer processors; only what is inlined into it gets them. Operations
/// are neither reordered nor contracted, so the results are the same bit by bit.
struct Faces<'a, E, const N: usize, const P: usize, L> {
    shell: &'a Koiter<E, N, P, L>,
    x: &'a [f64],
    faces: Range<usize>,
    task: Task<'a, N>,
}

impl<E: Element<N, P>, const N: usize, const P: usize, L: Constitutive> pulp::WithSimd for Faces<'_, E, N, P, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Faces { shell, x, faces, task } = self;
        match task {
            Task::Energy(into) => faces.zip(into).for_each(|(face, energy)| *energy = shell.energy_of(face, x)),
            Task::Gradient(into) => faces.zip(into).for_each(|(face, part)| *part = shell.gradient_of(face, x)),
            Task::MaterialForces(v, into) => faces.zip(into).for_each(|(face, part)| *part = shell.material_forces(face, x, v)),
            Task::Assemble(curvature, into) => faces.zip(into).for_each(|(face, part)| shell.set_all(face, x, curvature, part)),
            Task::Extrapolate(dx, into) => {
                faces.zip(into.chunks_exact_mut(P)).for_each(|(face, part)| shell.extrapolate_stresses(face, x, dx, part));
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

impl<E: Element<N, P>, const N: usize, const P: usize, L: Constitutive> Shell for Koiter<E, N, P, L> {
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
            let weight = E::WEIGHTS[k] * self.stiffness.get(face).copied().unwrap_or(1.0);
            self.law.set_rest(face, point, &[a[0], a[1], a[2], b[0], b[1], b[2]], weight);
        }
    }

    fn set_stiffness(&mut self, factors: Vec<f64>) {
        self.stiffness = factors;
    }

    fn start_step(&mut self, x: &[f64], dt: f64) {
        if self.is_viscous() {
            self.set_strain_start(self.forms(x), dt);
        }
    }

    fn is_viscous(&self) -> bool {
        self.damping.is_some()
    }

    fn set_strain_start(&mut self, start: Vec<Strain>, dt: f64) {
        let Some(viscosity) = self.damping.as_ref().map(|d| d.viscosity) else { return };
        self.damping = Some(Damping { viscosity, ratio: viscosity / dt, start });
    }

    fn turns(&self, x: &[f64], from: &[Vector3<f64>]) -> Vec<f64> {
        self.element.turns(x, from)
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
                let parts = split(self.law.couples(face), self.law.rest(P * face + k), eps, |e| self.law.elastic(face, P * face + k, e).1);
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
        }
        sums
    }
}

//! Solutions that round-off of the matrix has spoilt, mended.
//!
//! The stiffness of a sheet against bending is to that of its stretching as the square of its thickness to that of its span, and once it is curved
//! both are in the same entries of the matrix: of a shell of 1e-6 of its span round-off of the matrix leaves little of the bending. The product of
//! the matrix with a direction, formed from strains, has no such loss: what round-off adds to strains does no work on motions that have none. So a
//! few generalised conjugate residuals with that product, the factor being the preconditioner, give what the factor alone does not. No matrix is
//! made or factorised here.

use super::newton::Newton;
use crate::sparse::Potential;

/// Share of a movement by which a solution may be wrong before it is mended: Newton's method then still gains two digits an iteration.
const SPOILT: f64 = 1e-2;

/// Share of the movement that mending stops at.
const ENOUGH: f64 = 1e-4;

/// Most directions; few motions of the whole shell are soft enough to be spoilt.
const DIRECTIONS: usize = 16;

/// Weight of an angle [rad] beside lengths over the diameter.
const ANGLE: f64 = 0.1;

impl Newton {
    /// Mends `self.solution` and `self.dx`, the solution of `H dx = -g` at `x` by the factor of the mixed matrix there, if it is spoilt. Returns whether it was.
    pub(super) fn mend(&mut self, potentials: &[&mut dyn Potential], x: &[f64]) -> bool {
        let lengths = self.numbering.unknowns().partition_point(|u| (*u as usize) < self.settings.lengths);
        let scale = self.settings.diameter.recip();
        let product = move |u: &[f64], v: &[f64]| -> f64 {
            let part = |range: std::ops::Range<usize>| u[range.clone()].iter().zip(&v[range]).map(|(u, v)| u * v).sum::<f64>();
            scale * scale * part(0..lengths) + ANGLE * ANGLE * part(lengths..u.len())
        };
        let size = |u: &[f64]| product(u, u).sqrt();
        let add = |to: &mut [f64], share: f64, v: &[f64]| to.iter_mut().zip(v).for_each(|(t, v)| *t += share * v);
        let mut solution = self.solution.clone();
        let Some(force) = self.forces_along(potentials, x, &solution) else { return false };
        let mut rest: Vec<f64> = force.iter().zip(&self.system.gradient).map(|(f, g)| -g - f).collect();
        self.cholesky.solve(&mut rest);
        let first = size(&rest);
        if !(first > SPOILT * size(&solution)) || !first.is_finite() {
            return false;
        }
        let mut directions: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        while directions.len() < DIRECTIONS && size(&rest) > ENOUGH * size(&solution) {
            let mut direction = rest.clone();
            let Some(mut image) = self.forces_along(potentials, x, &direction) else { break };
            self.cholesky.solve(&mut image);
            for (other, its_image) in &directions {
                let share = -product(&image, its_image) / product(its_image, its_image);
                add(&mut direction, share, other);
                add(&mut image, share, its_image);
            }
            let step = product(&rest, &image) / product(&image, &image);
            if !step.is_finite() {
                break;
            }
            add(&mut solution, step, &direction);
            add(&mut rest, -step, &image);
            directions.push((direction, image));
        }
        log::trace!("solution mended along {} directions: wrong by {first:.1e}, then {:.1e}", directions.len(), size(&rest));
        if !(size(&rest) < first) || !size(&solution).is_finite() {
            return false;
        }
        self.dx.fill(0.0);
        for (value, &unknown) in solution.iter().zip(self.numbering.unknowns()) {
            self.dx[unknown as usize] = *value;
        }
        self.solution = solution;
        true
    }

    /// The mixed matrix at `x` times a direction of the free unknowns, from strains; none if a potential has no such product.
    fn forces_along(&mut self, potentials: &[&mut dyn Potential], x: &[f64], direction: &[f64]) -> Option<Vec<f64>> {
        let direction = self.spread(direction);
        let zero = vec![0.0; self.system.gradient.len()];
        let kept = std::mem::replace(&mut self.system.gradient, zero);
        let known = potentials.iter().all(|p| p.add_product(x, &direction, &mut self.system));
        let forces = std::mem::replace(&mut self.system.gradient, kept);
        known.then_some(forces)
    }
}

//! Solutions with a matrix whose own round-off hides its softest directions.
//!
//! A shell resists bending with `(h k)^2` of what it resists stretching with, `k` its wave number. In the assembled matrix of a curved shell
//! both are in the same entries, so that at a thickness of a millionth of the span the round-off of these entries and of the factor is a
//! tenth of the stiffness in bending, and all of it where slivers are folded. What a movement leaves of the forces is formed from strains instead:
//! round-off then is that of stresses, which do no work in a movement without strain. With the factor as a preconditioner few such
//! residuals are asked for; where the smallest pivot tells that the factor is accurate, none.

use super::newton::Newton;
use crate::sparse::eigen::multiply;
use crate::sparse::{Curvature, Potential};

/// Smallest pivot over its diagonal entry from which the factor itself is accurate enough.
const ACCURATE: f64 = 1e-8;

/// Error of a movement, relative to its size, that an iteration may have. Errors have waves in both directions, which a flat shell loses only by
/// half in each iteration while they are larger than its thickness.
const ERROR: f64 = 1e-6;

/// Directions that may be combined.
const DIRECTIONS: usize = 20;

impl Newton {
    /// Improves `self.dx`, the movement from `x` that was solved for with the matrix there, if that matrix needs it. `moved`: held unknowns that
    /// move, and how far. The matrix is overwritten.
    pub(super) fn refine(&mut self, potentials: &mut [&mut dyn Potential], x: &[f64], moved: &[(usize, f64)]) {
        self.matrix_error = 0.0;
        if self.smallest_pivot >= ACCURATE {
            return;
        }
        let mut prescribed = vec![0.0; x.len()];
        moved.iter().for_each(|&(i, d)| prescribed[i] = d);
        self.assemble_moving(potentials, x, Curvature::Geometric, moved);
        let forces = self.system.gradient.clone();
        // GMRES (Saad and Schultz 1986). Angles count as the movement that they make over the mesh.
        let lengths = self.numbering.unknowns().partition_point(|u| (*u as usize) < self.settings.lengths);
        let weight = self.settings.diameter * self.settings.diameter;
        let product = |u: &[f64], v: &[f64]| {
            let sum = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(u, v)| u * v).sum::<f64>();
            sum(&u[..lengths], &v[..lengths]) + weight * sum(&u[lengths..], &v[lengths..])
        };
        let add = |to: &mut [f64], share: f64, v: &[f64]| to.iter_mut().zip(v).for_each(|(t, v)| *t += share * v);
        let mut solution = std::mem::take(&mut self.solution);
        let mut rest: Vec<f64> = self.apply(potentials, x, &solution, &prescribed).iter().zip(&forces).map(|(a, f)| -f - a).collect();
        self.cholesky.solve(&mut rest);
        let (size, start) = (product(&solution, &solution).sqrt(), product(&rest, &rest).sqrt());
        let still = vec![0.0; x.len()];
        let mut left = start;
        let mut basis = vec![rest];
        // Rotations, columns of the triangle, and the right-hand side, as they are made.
        let (mut rotations, mut triangle, mut right): (Vec<[f64; 2]>, Vec<Vec<f64>>, Vec<f64>) = (Vec::new(), Vec::new(), vec![start]);
        while left > ERROR * size && left.is_finite() && basis.len() <= DIRECTIONS {
            let Some(last) = basis.last_mut() else { break };
            let norm = product(last, last).sqrt();
            last.iter_mut().for_each(|v| *v /= norm);
            let mut next = {
                let direction = &basis[basis.len() - 1];
                self.apply(potentials, x, direction, &still)
            };
            self.cholesky.solve(&mut next);
            let mut column: Vec<f64> = Vec::with_capacity(basis.len() + 1);
            for v in &basis {
                let share = product(&next, v);
                add(&mut next, -share, v);
                column.push(share);
            }
            column.push(product(&next, &next).sqrt());
            for (k, [c, s]) in rotations.iter().enumerate() {
                (column[k], column[k + 1]) = (c * column[k] + s * column[k + 1], c * column[k + 1] - s * column[k]);
            }
            let k = rotations.len();
            let radius = column[k].hypot(column[k + 1]);
            if !(radius > 0.0 && radius.is_finite()) {
                break;
            }
            let [c, s] = [column[k] / radius, column[k + 1] / radius];
            column[k] = radius;
            column.truncate(k + 1);
            rotations.push([c, s]);
            triangle.push(column);
            let value = right[k];
            right[k] = c * value;
            right.push(-s * value);
            left = (s * value).abs();
            basis.push(next);
        }
        for k in (0..triangle.len()).rev() {
            let above: f64 = (k + 1..triangle.len()).map(|j| triangle[j][k] * right[j]).sum();
            right[k] = (right[k] - above) / triangle[k][k];
            add(&mut solution, right[k], &basis[k]);
        }
        log::trace!("refined by {} directions: error {:.1e} to {:.1e} of the movement", triangle.len(), start / size, left / size);
        self.matrix_error = left / size;
        for (value, &unknown) in solution.iter().zip(self.numbering.unknowns()) {
            self.dx[unknown as usize] = *value;
        }
        self.solution = solution;
        self.system.gradient.copy_from_slice(&forces);
    }

    /// What the Hessian makes of a movement: `free` over the free unknowns, the others as in `all`. The matrix must be that of
    /// [`Curvature::Geometric`]; what it makes of `all` is not in here.
    pub(super) fn apply(&mut self, potentials: &[&mut dyn Potential], x: &[f64], free: &[f64], all: &[f64]) -> Vec<f64> {
        let mut movement = all.to_vec();
        free.iter().zip(self.numbering.unknowns()).for_each(|(v, u)| movement[*u as usize] = *v);
        self.system.gradient.fill(0.0);
        potentials.iter().for_each(|p| p.add_material_forces(x, &movement, &mut self.system));
        let geometric = multiply(&self.pattern, &self.system.matrix, free);
        self.system.gradient.iter().zip(&geometric).map(|(m, g)| m + g).collect()
    }
}

//! One step of the paper's scheme (Wu and de Melo, (33) to (35)): a linear system for the next positions.
//!
//! `A r' = g` with `A = K + mu/dt^2 + lambda/(2 dt)` and `g = f - l - k + (mu/dt^2 + lambda/(2 dt)) r + (mu/dt - lambda/2) v`, all per area, `mu` and
//! `lambda` rescaled by the area of the surface (35), and weight with `mu`; other loads are spread over the present area of their node. With constants
//! that the metric does not scale all of this is per rest area. `f` is that of the loads at the positions that the velocities lead to. Everything is taken
//! at the state that the step starts from, so positions and velocities are all that the next step reads.

use crate::cosserat::StrongForm;
use crate::error::{Error, Result};
use crate::load::Load;
use crate::sparse::general::{self, Method};
use crate::sparse::{Numbering, Pattern, Potential, System};
use nalgebra::Vector3;

/// The paper's scheme with what the nodes carry.
pub struct Strong {
    form: StrongForm,
    /// Masses [kg] and damping coefficients [kg/s] of the nodes.
    masses: Vec<f64>,
    damping: Vec<f64>,
    /// Rest areas of the nodes [m2].
    areas: Vec<f64>,
    numbering: Numbering,
    pattern: Pattern,
    /// Matrices factored so far that were unsymmetric, and that were symmetric but indefinite.
    pub lu: [u64; 2],
    /// All matrices factored so far.
    pub factorizations: u64,
}

/// What a step starts from.
pub struct From<'a> {
    /// Coordinates [m].
    pub x: &'a [f64],
    /// Velocities [m/s].
    pub v: &'a [f64],
    /// Step [s].
    pub dt: f64,
    /// Present areas of the nodes [m2].
    pub areas: &'a [f64],
    /// Which coordinates are held.
    pub held: &'a [bool],
    /// Those that move, and where to [m].
    pub targets: &'a [(usize, f64)],
}

impl Strong {
    /// `masses` [kg], `damping` [kg/s] and rest `areas` [m2] of the nodes.
    pub fn new(form: StrongForm, masses: Vec<f64>, damping: Vec<f64>, areas: Vec<f64>) -> Self {
        let numbering = Numbering::new(&vec![false; 3 * masses.len()]);
        let pattern = Pattern { column_start: vec![0], row: Vec::new() };
        Strong { form, masses, damping, areas, numbering, pattern, lu: [0; 2], factorizations: 0 }
    }

    /// Looks up where the loads' forces go, once.
    pub fn bind(&mut self, loads: &mut [&mut dyn Potential]) -> Result<()> {
        self.pattern = Pattern::new(&self.numbering, &mut |visit| loads.iter().for_each(|load| load.stencils(visit)))?;
        loads.iter_mut().for_each(|load| load.bind(&self.numbering, &self.pattern));
        Ok(())
    }

    /// The next coordinates [m], and the largest of what is left of the equations over the largest force.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn step(&mut self, from: &From, loads: &[&dyn Load]) -> Result<(Vec<f64>, f64)> {
        let dt = from.dt;
        let r: Vec<Vector3<f64>> = from.x.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
        let operator = self.form.operator(&r);
        let led: Vec<f64> = from.x.iter().zip(from.v).map(|(x, v)| x + dt * v).collect();
        let [mut weight, mut system] = [(); 2].map(|()| System::new(&self.pattern));
        for load in loads {
            load.gradient(&led, if load.follows_mass() { &mut weight } else { &mut system });
        }
        let (ratio, areas) = if self.form.is_per_present_area() {
            (from.areas.iter().sum::<f64>() / self.areas.iter().sum::<f64>(), from.areas)
        } else {
            (1.0, &*self.areas)
        };
        let (mut rows, mut right) = (operator.rows, Vec::with_capacity(r.len()));
        for node in 0..r.len() {
            let mu = self.masses[node] / self.areas[node] / ratio;
            let lambda = self.damping[node] / self.areas[node] * ratio;
            let inertia = mu / (dt * dt) + lambda / (2.0 * dt);
            rows[node].push((node, inertia));
            right.push(std::array::from_fn::<f64, 3, _>(|k| {
                let load = -system.gradient[3 * node + k] / areas[node] - weight.gradient[3 * node + k] / (self.areas[node] * ratio);
                let v = from.v[3 * node + k];
                load - operator.lagged[node][k] - operator.constants[node][k] + inertia * r[node][k] + (mu / dt - 0.5 * lambda) * v
            }));
        }
        let mut next = from.x.to_vec();
        from.targets.iter().for_each(|&(u, value)| next[u] = value);
        let scale = right.as_flattened().iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
        let holds = |k: usize| -> Vec<bool> { (0..r.len()).map(|n| from.held[3 * n + k]).collect() };
        if holds(0) == holds(1) && holds(1) == holds(2) {
            self.solve(&rows, &right, &holds(0), &mut next, [0, 1, 2])?;
        } else {
            for k in 0..3 {
                let one: Vec<[f64; 1]> = right.iter().map(|row| [row[k]]).collect();
                self.solve(&rows, &one, &holds(k), &mut next, [k])?;
            }
        }
        let mut left = 0.0f64;
        for (node, row) in rows.iter().enumerate() {
            for k in (0..3).filter(|k| !from.held[3 * node + k]) {
                left = left.max((row.iter().map(|(at, c)| c * next[3 * at + k]).sum::<f64>() - right[node][k]).abs());
            }
        }
        Ok((next, left / scale))
    }

    /// Solves for some coordinates of the nodes that are not held; those that are have their values in `next`.
    fn solve<const K: usize>(
        &mut self,
        rows: &[Vec<(usize, f64)>],
        right: &[[f64; K]],
        held: &[bool],
        next: &mut [f64],
        axes: [usize; K],
    ) -> Result<()> {
        let free: Vec<usize> = (0..rows.len()).filter(|n| !held[*n]).collect();
        if free.is_empty() {
            return Ok(());
        }
        let mut number = vec![usize::MAX; rows.len()];
        free.iter().enumerate().for_each(|(i, n)| number[*n] = i);
        let mut reduced = Vec::with_capacity(free.len());
        let mut known = Vec::with_capacity(free.len());
        for n in &free {
            let mut b = right[*n];
            let mut row = Vec::with_capacity(rows[*n].len());
            for (at, c) in &rows[*n] {
                if held[*at] {
                    b.iter_mut().zip(axes).for_each(|(b, k)| *b -= c * next[3 * at + k]);
                } else {
                    row.push((number[*at], *c));
                }
            }
            reduced.push(row);
            known.push(b);
        }
        self.factorizations += 1;
        match general::solve(&reduced, &mut known)? {
            Method::Cholesky => {}
            Method::Unsymmetric => self.lu[0] += 1,
            Method::Indefinite => self.lu[1] += 1,
        }
        for (n, values) in free.iter().zip(known) {
            values.iter().zip(axes).for_each(|(value, k)| next[3 * n + k] = *value);
        }
        if next.iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(Error::Numerical { message: "a position is not finite".into(), help: None })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosserat::{Border, Constants, Divergence, Elasticity, Grid};
    use crate::load::DeadLoad;
    use crate::model::{node_shares, quadrangles};

    fn flatten(r: &[Vector3<f64>]) -> Vec<f64> {
        r.iter().flat_map(|p| [p.x, p.y, p.z]).collect()
    }

    /// What weight adds to a step from a state that is stretched unevenly: every node falls alike.
    #[test]
    fn all_nodes_fall_with_the_same_acceleration() {
        let grid = Grid { nodes: [5, 4], spacing: [0.25, 0.3] };
        let rest: Vec<_> =
            (0..grid.len()).map(|n| grid.place(n)).map(|[i, j]| Vector3::new(0.25 * i as f64, 0.3 * j as f64, 0.0)).collect();
        let state: Vec<_> = rest.iter().map(|p| Vector3::new(p.x + 0.3 * p.x * p.x, p.y * (1.0 + 0.2 * p.x), 0.1 * p.x * p.y)).collect();
        let constants = Constants { eta: [4.0; 3], xi: [1e-2; 3], phi: [0.0; 3] };
        let [areas, present] = [&rest, &state].map(|r| node_shares(&quadrangles(&grid), &flatten(r)));
        let ratio = present.iter().sum::<f64>() / areas.iter().sum::<f64>();
        let uneven = (0..grid.len()).fold(0.0f64, |m, n| m.max((present[n] / areas[n] / ratio - 1.0).abs()));
        assert!(uneven > 0.05, "{uneven}");
        let step = |load: Option<&mut DeadLoad>| {
            let elasticity = Elasticity::Cosserat { constants, mixed: false };
            let form = StrongForm::new(grid, &rest, areas.clone(), elasticity, Border::Symmetric, Divergence::Conservative);
            let mut strong = Strong::new(form, areas.iter().map(|a| 2.0 * a).collect(), vec![0.0; grid.len()], areas.clone());
            let (x, still) = (flatten(&state), vec![0.0; 3 * grid.len()]);
            let held = vec![false; x.len()];
            let from = From { x: &x, v: &still, dt: 0.01, areas: &present, held: &held, targets: &[] };
            let mut loads: Vec<&mut dyn Load> = load.into_iter().map(|load| load as &mut dyn Load).collect();
            strong.bind(&mut loads.iter_mut().map(|load| &mut **load as &mut dyn Potential).collect::<Vec<_>>()).unwrap();
            strong.step(&from, &loads.iter().map(|load| &**load).collect::<Vec<_>>()).unwrap().0
        };
        let masses: Vec<f64> = areas.iter().map(|a| 2.0 * a).collect();
        let mut weight = DeadLoad::weight(&masses, &rest, Box::new(|_, _| Vector3::new(0.0, 0.0, -9.81)), false);
        let (with, without) = (step(Some(&mut weight)), step(None));
        for (a, b) in with.chunks_exact(3).zip(without.chunks_exact(3)) {
            assert!(((a[2] - b[2]) / (-9.81 * 1e-4) - 1.0).abs() < 1e-8, "{}", (a[2] - b[2]) / 1e-4);
        }
    }
}

//! The paper's finite differences: `scheme = "strong-form"` (Wu and de Melo, section 5).
//!
//! The force per area `-N^i|_i` of a state is written as `l + K r + k`: `l` of the terms of `phi` as a vector, the rest as an operator that is the same for
//! x, y and z and linear in the next positions, with stresses `N^ij`, `N^3i` and Christoffel symbols of the present ones. Inner first differences are forward,
//! outer ones backward; second differences `D+ D-`, the mixed one `D+1 D+2`. The normal is that of the Gauss formula, and where that says little,
//! mostly the present one, which makes the vector `k`.
//!
//! With [`Border::Paper`] every difference that reads a node outside is zero, so nodes of the first row and column get no part of the force that
//! comes through them. With [`Border::Symmetric`] there is no stress outside, and the operator is the mean of this one and its mirror images, with
//! backward inner and forward outer differences along one coordinate or both. A node on a side has half a cell, so outer differences across the side are
//! over half the spacing, and what the forces between nodes do to momentum cancels. Shear stress along a side exists in
//! half of the images, which have it twice. Neither is the derivative of an energy, and no step is small enough to make them stable for ever.
//! Time integration is not here.
//!
//! `N*` and `M` are the derivatives of (29) as they are printed, as if (29) were the energy per present area. Energy per rest area, which the variational
//! scheme takes, has these times `sqrt(G_0/G)`: under a uniaxial stretch `lambda` the force through a section is here `lambda` times that of the other, so the two converge
//! to each other at small strain only.

use super::constants::{Stiffness, stiffness};
use super::geometry::{self, Derivatives, GaussNormal, component};
use super::grid::{Border, Grid};
use super::stencil::{ALL_SENSES, Row, Sense, Senses, Stencil, apply, merged, opposite};
use super::surface::Elasticity;
use nalgebra::Vector3;

/// Form of the divergence of the stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Divergence {
    /// (22): derivative and Christoffel symbols.
    AsPrinted,
    /// `(1/sqrt G) D_i (sqrt G N^i)`.
    Conservative,
}

/// Curvature [1, times the size of the surface] at which the Gauss formula and the present normal have equal shares: far below it `B_ij` counts as zero.
const FLAT: f64 = 1e-3;

/// The internal force per area of a state [N/m2]: `K r + constant`, and what is added to it.
pub struct Operator {
    /// Rows of `K` [N/m3]; per area at rest for constants that the metric does not scale.
    pub rows: Vec<Row>,
    /// What does not depend on the next positions [N/m2]: present normals where the Gauss formula says little.
    pub constants: Vec<Vector3<f64>>,
    /// `l` [N/m2].
    pub lagged: Vec<Vector3<f64>>,
}

/// Which terms of the energy.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Terms {
    /// `eta` and `xi`.
    Own,
    /// `phi`.
    Coupling,
}

/// What is known of a node.
#[derive(Clone, Copy)]
struct Point {
    now: Derivatives,
    metric: [f64; 3],
    symbols: [[f64; 3]; 2],
    /// `sqrt G`, where the metric is regular.
    root: Option<f64>,
    normal: Vector3<f64>,
    /// `N*` and `M`.
    stress: [[f64; 3]; 2],
}

/// The surface as the paper's scheme sees it.
pub struct StrongForm {
    stencil: Stencil,
    divergence: Divergence,
    elasticity: Elasticity,
    size: f64,
    /// Rest positions [m].
    rest: Vec<Vector3<f64>>,
    /// Area of each node at rest [m2], for constants that are not those per area.
    areas: Vec<f64>,
}

impl StrongForm {
    /// A surface at rest in `positions` [m]. `areas`: rest areas of the nodes [m2].
    pub fn new(
        grid: Grid,
        positions: &[Vector3<f64>],
        areas: Vec<f64>,
        elasticity: Elasticity,
        border: Border,
        divergence: Divergence,
    ) -> Self {
        let grid = match elasticity {
            Elasticity::Cosserat { .. } => grid,
            Elasticity::Terzopoulos(_) => Grid { spacing: [1.0, 1.0], ..grid },
        };
        let size = areas.iter().sum::<f64>().sqrt();
        StrongForm { stencil: Stencil { grid, border }, divergence, elasticity, size, rest: positions.to_vec(), areas }
    }

    /// The internal force of a state.
    pub fn operator(&self, r: &[Vector3<f64>]) -> Operator {
        let senses: &[Senses] = match self.stencil.border {
            Border::Paper => &ALL_SENSES[..1],
            Border::Symmetric => &ALL_SENSES,
        };
        let nodes = self.stencil.grid.len();
        let mut sum =
            Operator { rows: vec![Vec::new(); nodes], constants: vec![Vector3::zeros(); nodes], lagged: vec![Vector3::zeros(); nodes] };
        let share = 1.0 / senses.len() as f64;
        for &sense in senses {
            let (rows, constants) = self.of_terms(r, sense, Terms::Own);
            for (node, (row, constant)) in rows.into_iter().zip(constants).enumerate() {
                sum.rows[node].extend(row.into_iter().map(|(n, c)| (n, share * c)));
                sum.constants[node] += constant * share;
            }
            if self.is_coupled() {
                let (rows, constants) = self.of_terms(r, sense, Terms::Coupling);
                for (node, (row, constant)) in rows.iter().zip(constants).enumerate() {
                    sum.lagged[node] += (apply(row, r) + constant) * share;
                }
            }
        }
        sum.rows.iter_mut().for_each(|row| *row = merged(std::mem::take(row)));
        sum
    }

    fn is_coupled(&self) -> bool {
        matches!(self.elasticity, Elasticity::Cosserat { constants, .. } if constants.phi != [0.0; 3])
    }

    fn of_terms(&self, r: &[Vector3<f64>], sense: Senses, terms: Terms) -> (Vec<Row>, Vec<Vector3<f64>>) {
        match self.elasticity {
            Elasticity::Terzopoulos(_) => (self.terzopoulos(r, sense), vec![Vector3::zeros(); self.stencil.grid.len()]),
            Elasticity::Cosserat { .. } => self.cosserat(r, sense, terms),
        }
    }

    /// `C` in the rest metric at the nearest node where that is regular.
    fn stiffness(&self, node: usize, sense: Senses) -> Stiffness {
        let Elasticity::Cosserat { constants, mixed } = &self.elasticity else { return [[0.0; 6]; 6] };
        let mut place = self.stencil.grid.place(node);
        if self.stencil.border == Border::Paper {
            place = [0, 1].map(|k| place[k].min(self.stencil.grid.nodes[k] - 2));
        }
        let metric = self.stencil.derivatives(&self.rest, self.stencil.grid.node(place[0], place[1]), sense).metric();
        stiffness(constants, &geometry::inverse(&metric), *mixed)
    }

    fn points(&self, r: &[Vector3<f64>], sense: Senses, terms: Terms) -> Vec<Point> {
        let point = |node: usize| {
            let now = self.stencil.derivatives(r, node, sense);
            let metric = now.metric();
            let det = geometry::determinant(&metric);
            let regular = det > 1e-12 * metric[0] * metric[2];
            let normal = now.normal();
            let rest = self.stencil.derivatives(&self.rest, node, sense);
            let (b, b0) = (now.curvature(&normal), rest.curvature(&rest.normal()));
            let (g0, (first, second)) = (rest.metric(), self.stencil.exists(node, sense));
            let there = [first[0], first[0] && first[1], first[1]];
            // What does not exist is at rest.
            let mut s = [0.0; 6];
            for c in 0..3 {
                s[c] = if there[c] { 0.5 * (metric[c] - g0[c]) } else { 0.0 };
                s[3 + c] = if second[c] { b0[c] - b[c] } else { 0.0 };
            }
            let c = self.stiffness(node, sense);
            let of = |m: usize| (0..6).filter(move |n| ((m < 3) == (*n < 3)) == (terms == Terms::Own));
            // Of the two mixed components each has half.
            let conjugate = |m: usize| of(m).map(|n| c[m][n] * s[n]).sum::<f64>() * if m % 3 == 1 { 0.5 } else { 1.0 };
            let stress = [0, 3].map(|from| [0, 1, 2].map(|c| if [there, second][from / 3][c] { conjugate(from + c) } else { 0.0 }));
            let symbols = if regular { now.christoffel() } else { [[0.0; 3]; 2] };
            let metric = if regular { metric } else { [1.0, 0.0, 1.0] };
            Point { now, metric, symbols, root: regular.then(|| det.sqrt()), normal, stress }
        };
        (0..self.stencil.grid.len()).map(point).collect()
    }

    /// `D_k` of the moment `M^jk`, along the edge for `j = k` and back to the node for the mixed one.
    fn moment_difference(&self, points: &[Point], node: usize, j: usize, k: usize, sense: Senses) -> f64 {
        let along = if j == k { sense[k] } else { opposite(sense[k]) };
        let c = component(j, k);
        let (here, d) = (points[node].stress[1][c], self.stencil.grid.spacing[k]);
        let there = match (self.stencil.neighbour(node, k, along), self.stencil.border) {
            (Some(next), _) => points[next].stress[1][c],
            (None, Border::Paper) => return 0.0,
            (None, Border::Symmetric) => 0.0,
        };
        let share = if j == k { 1.0 } else { self.stencil.share(node, k) };
        share * if along == Sense::Forward { (there - here) / d } else { (here - there) / d }
    }

    fn cosserat(&self, r: &[Vector3<f64>], sense: Senses, terms: Terms) -> (Vec<Row>, Vec<Vector3<f64>>) {
        let points = self.points(r, sense, terms);
        // The curve forces N^i: rows and constant vectors.
        let mut fluxes: Vec<[(Row, Vector3<f64>); 2]> = Vec::with_capacity(points.len());
        for (node, p) in points.iter().enumerate() {
            let (first, _) = self.stencil.exists(node, sense);
            let [n, m] = p.stress;
            let mixed = geometry::mixed_curvature(&p.metric, &p.now.curvature(&p.normal));
            let correction = geometry::divergence_correction(&p.symbols, &m);
            let transverse: [f64; 2] =
                [0, 1].map(|j| (0..2).map(|k| self.moment_difference(&points, node, j, k, sense)).sum::<f64>() + correction[j]);
            // Of terms that are evaluated as a vector the normal is that of (10), as where there is no metric to take it by.
            let formula = p.root.filter(|_| terms == Terms::Own).map(|_| p.now.gauss_normal(&p.normal, FLAT / self.size));
            let (normal, constant) = match &formula {
                Some(formula) => (self.normal_row(node, formula, sense), formula.constant),
                None => (Vec::new(), p.normal),
            };
            fluxes.push([0, 1].map(|i| {
                if !first[i] {
                    return Default::default();
                }
                let mut row = Vec::new();
                // Along a side the mixed components are those of the cells on one side of the node, so of one sense of two, and of that with its whole share.
                let share = self.stencil.share(node, 1 - i);
                let whole = |tensor: &[f64; 3], j: usize| tensor[component(j, i)] * if j == i { 1.0 } else { share };
                for j in 0..2 {
                    let stress = whole(&n, j) - (0..2).map(|k| mixed[j][k] * whole(&m, k)).sum::<f64>();
                    row.extend(self.stencil.first(node, j, sense).into_iter().map(|(at, c)| (at, stress * c)));
                }
                row.extend(normal.iter().map(|(at, c)| (*at, transverse[i] * c)));
                (row, constant * transverse[i])
            }));
        }
        let (mut rows, mut constants) = (vec![Vec::new(); points.len()], vec![Vector3::zeros(); points.len()]);
        for node in 0..points.len() {
            let mut add = |from: usize, i: usize, factor: f64| {
                let (row, constant) = &fluxes[from][i];
                rows[node].extend(row.iter().map(|(at, c)| (*at, -factor * c)));
                constants[node] -= constant * factor;
            };
            let contracted = geometry::contracted(&points[node].symbols);
            for i in 0..2 {
                let d = if sense[i] == Sense::Forward { 1.0 } else { -1.0 } * self.stencil.share(node, i) / self.stencil.grid.spacing[i];
                let weight = |at: usize| match self.divergence {
                    Divergence::AsPrinted => 1.0,
                    // The paper's borders have no area of their own.
                    Divergence::Conservative => points[at].root.zip(points[node].root).map_or(1.0, |(at, here)| at / here),
                };
                match (self.stencil.neighbour(node, i, opposite(sense[i])), self.stencil.border) {
                    (Some(last), _) => {
                        add(node, i, d);
                        add(last, i, -d * weight(last));
                    }
                    (None, Border::Paper) => {}
                    (None, Border::Symmetric) => add(node, i, d),
                }
                if self.divergence == Divergence::AsPrinted {
                    add(node, i, contracted[i]);
                }
            }
        }
        (rows, constants)
    }

    /// What the normal by the Gauss formula has of the positions, as a row.
    fn normal_row(&self, node: usize, formula: &GaussNormal, sense: Senses) -> Row {
        let mut row = Vec::new();
        for (ij, weight) in formula.weights.into_iter().enumerate() {
            row.extend(self.stencil.second(node, ij, sense).into_iter().map(|(at, c)| (at, c * weight)));
            for k in 0..2 {
                let factor = -formula.symbols[k][ij] * weight;
                row.extend(self.stencil.first(node, k, sense).into_iter().map(|(at, c)| (at, c * factor)));
            }
        }
        row
    }

    /// `-D_i (alpha_ij D_j r) + D_ij (beta_ij D_ij r)` over the area of a node at rest, with `alpha = 4 Phi (G - G0)` and `beta = 2 Psi (B - B0)`: (2) varied, with
    /// second derivatives in the place of normals, as there: where the surface bends away from its normal that pushes it on, and
    /// its mixed part is not that of the mirror image.
    fn terzopoulos(&self, r: &[Vector3<f64>], sense: Senses) -> Vec<Row> {
        let Elasticity::Terzopoulos(constants) = &self.elasticity else { return vec![Vec::new(); self.stencil.grid.len()] };
        let mut rows = vec![Vec::new(); self.stencil.grid.len()];
        // By transposes of the inner differences; the paper's borders have none that reads outside.
        for node in 0..self.stencil.grid.len() {
            let (now, rest) = (self.stencil.derivatives(r, node, sense), self.stencil.derivatives(&self.rest, node, sense));
            let (g, g0) = (now.metric(), rest.metric());
            let (b, b0) = (now.curvature(&now.normal()), rest.curvature(&rest.normal()));
            let (first, second) = self.stencil.exists(node, sense);
            let operators: [Row; 2] = [0, 1].map(|k| if first[k] { self.stencil.first(node, k, sense) } else { Vec::new() });
            let mut add = |left: &Row, right: &Row, factor: f64, lost: &dyn Fn([usize; 2]) -> bool| {
                for (at, c) in left.iter().filter(|(at, _)| self.stencil.border != Border::Paper || !lost(self.stencil.grid.place(*at))) {
                    rows[*at].extend(right.iter().map(|(n, d)| (*n, factor * c * d / self.areas[*at])));
                }
            };
            // Which nodes the outer difference leaves without force where it reads a node outside: D-, D+ D-, and D-1 D-2.
            let back = |k: usize| move |at: [usize; 2]| at[k] == 0;
            let both = |k: usize| move |at: [usize; 2]| at[k] == 0 || at[k] == self.stencil.grid.nodes[k] - 1;
            for i in 0..2 {
                for j in 0..2 {
                    let c = component(i, j);
                    if first[i] && first[j] {
                        add(&operators[i], &operators[j], 4.0 * constants.eta[c] * (g[c] - g0[c]), &back(i));
                    }
                    if second[c] {
                        let (operator, factor) = (self.stencil.second(node, c, sense), 2.0 * constants.xi[c] * (b[c] - b0[c]));
                        if i == j {
                            add(&operator, &operator, factor, &both(i));
                        } else {
                            add(&operator, &operator, factor, &|at| at.contains(&0));
                        }
                    }
                }
            }
        }
        rows
    }

    /// See [`Elasticity::is_per_present_area`].
    pub fn is_per_present_area(&self) -> bool {
        self.elasticity.is_per_present_area()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosserat::Constants;

    fn grid(n: usize) -> Grid {
        Grid { nodes: [n, n], spacing: [1.0 / (n as f64 - 1.0); 2] }
    }

    fn positions(grid: &Grid, f: impl Fn(f64, f64) -> Vector3<f64>) -> Vec<Vector3<f64>> {
        (0..grid.len()).map(|n| grid.place(n)).map(|[i, j]| f(grid.spacing[0] * i as f64, grid.spacing[1] * j as f64)).collect()
    }

    fn strong(grid: Grid, elasticity: Elasticity, border: Border, divergence: Divergence) -> StrongForm {
        let flat = positions(&grid, |a, b| Vector3::new(a, b, 0.0));
        StrongForm::new(grid, &flat, vec![grid.cell_area(); grid.len()], elasticity, border, divergence)
    }

    fn force(operator: &Operator, r: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let sum = |n: usize| apply(&operator.rows[n], r) + operator.constants[n] + operator.lagged[n];
        (0..r.len()).map(sum).collect()
    }

    /// Bending waves of a flat sheet: `6 xi (w_xxxx + w_yyyy) + 4 xi w_xxyy`, at second order.
    #[test]
    fn small_waves_have_the_force_of_the_plate() {
        let constants = Constants { eta: [1.0; 3], xi: [0.01; 3], phi: [0.0; 3] };
        let elasticity = Elasticity::Cosserat { constants, mixed: false };
        let pi = std::f64::consts::PI;
        for (border, divergence) in
            [(Border::Paper, Divergence::AsPrinted), (Border::Paper, Divergence::Conservative), (Border::Symmetric, Divergence::AsPrinted)]
        {
            let mut errors = Vec::new();
            for n in [11, 21, 41] {
                let grid = grid(n);
                let amplitude = 1e-5;
                let wave = positions(&grid, |a, b| Vector3::new(a, b, amplitude * (pi * a).sin() * (pi * b).sin()));
                let middle = grid.node(n / 2, n / 2);
                let force = force(&strong(grid, elasticity, border, divergence).operator(&wave), &wave)[middle];
                errors.push((force.z / (0.01 * 16.0 * pi.powi(4) * wave[middle].z) - 1.0).abs());
            }
            let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
            assert!(
                errors[0] > 1e-4 && errors[2] < 0.01 && orders.iter().all(|o| (1.8..2.2).contains(o)),
                "{border:?} {errors:?} {orders:?}"
            );
        }
    }

    /// The stretched square pulls at its border as the symmetric rule has it; the paper's leaves two sides without force.
    #[test]
    fn two_sides_of_the_paper_have_no_force() {
        let constants = Constants { eta: [2.0; 3], xi: [0.01; 3], phi: [0.0; 3] };
        let grid = grid(5);
        let stretched = positions(&grid, |a, b| Vector3::new(1.1 * a, b, 0.0));
        let elasticity = Elasticity::Cosserat { constants, mixed: false };
        let of = |border| force(&strong(grid, elasticity, border, Divergence::Conservative).operator(&stretched), &stretched);
        let (paper, symmetric) = (of(Border::Paper), of(Border::Symmetric));
        let [left, middle, right] = [0, 2, 4].map(|i| grid.node(i, 2));
        // The force through a section is 2 Phi eps r_1 = 2 * 6 * 0.105 * 1.1 per length, here over the spacing of 1/4.
        let pull = 12.0 * 0.105 * 1.1 * 4.0;
        assert_eq!(paper[left], Vector3::zeros());
        assert!((paper[right].x - pull).abs() < 1e-12 * pull && paper[middle].norm() < 1e-12 * pull);
        // There the node has half a cell.
        let half = 2.0 * pull;
        assert!((symmetric[right].x - half).abs() < 1e-12 * half && (symmetric[left].x + half).abs() < 1e-12 * half);
    }

    /// The corners of a sheared square: N^12 takes both first differences, of which the last row or column has one, so no shear comes to the last corner, and
    /// to the two beside it only that along the side whose differences it has. The symmetric rule has both everywhere.
    #[test]
    fn the_last_corner_of_the_paper_has_no_shear() {
        let constants = Constants { eta: [2.0; 3], xi: [0.01; 3], phi: [0.0; 3] };
        let grid = grid(5);
        let sheared = positions(&grid, |a, b| Vector3::new(a + 0.1 * b, b, 0.0));
        let elasticity = Elasticity::Cosserat { constants, mixed: false };
        let of = |border| force(&strong(grid, elasticity, border, Divergence::Conservative).operator(&sheared), &sheared);
        let (paper, symmetric) = (of(Border::Paper), of(Border::Symmetric));
        // eps_12 = 0.05 and eps_22 = 0.005, so N^12 = 2 eta eps_12 and N^22 = 6 eta eps_22; over the spacing of 1/4.
        let (r1, r2) = (Vector3::x(), Vector3::new(0.1, 1.0, 0.0));
        let [first, second] = [r2 * 0.2, r1 * 0.2 + r2 * 0.06].map(|n| n * 4.0);
        for (place, expected) in [([0, 0], Vector3::zeros()), ([4, 0], first), ([0, 4], second), ([4, 4], r2 * (0.06 * 4.0))] {
            let found = paper[grid.node(place[0], place[1])];
            assert!((found - expected).norm() < 1e-12, "{place:?} {found} {expected}");
        }
        // There a corner has a quarter of a cell.
        for (place, signs) in [([0, 0], [-1.0, -1.0]), ([4, 0], [1.0, -1.0]), ([0, 4], [-1.0, 1.0]), ([4, 4], [1.0, 1.0])] {
            let expected = (first * signs[0] + second * signs[1]) * 2.0;
            let found = symmetric[grid.node(place[0], place[1])];
            assert!((found - expected).norm() < 1e-12, "{place:?} {found} {expected}");
        }
    }

    /// Forces within a sheet of any shape add up to none over the areas of the nodes, of which a side has halves and a corner a quarter.
    #[test]
    fn the_symmetric_rule_keeps_momentum() {
        let constants = Constants { eta: [2.0; 3], xi: [0.01; 3], phi: [0.05; 3] };
        let grid = grid(6);
        let state = positions(&grid, |a, b| Vector3::new(1.1 * a + 0.1 * a * b, b - 0.05 * a * a, 0.3 * a * a + 0.2 * b * b * b));
        let elasticity = Elasticity::Cosserat { constants, mixed: false };
        let strong = strong(grid, elasticity, Border::Symmetric, Divergence::Conservative);
        for sense in ALL_SENSES {
            // Of (1/sqrt G) D (sqrt G N) the area is that of the present state.
            let points = strong.points(&state, sense, Terms::Own);
            let (rows, constants) = strong.cosserat(&state, sense, Terms::Own);
            let (mut sum, mut largest) = (Vector3::zeros(), 0.0f64);
            for node in 0..grid.len() {
                let cells: f64 = grid.place(node).iter().map(|at| if *at == 0 || *at == 5 { 0.5 } else { 1.0 }).product();
                let force = (apply(&rows[node], &state) + constants[node]) * cells * points[node].root.unwrap();
                sum += force;
                largest = largest.max(force.norm());
            }
            assert!(largest > 1e-2 && sum.norm() < 1e-11 * largest, "{sense:?} {sum} {largest}");
        }
    }

    /// The symmetric rule makes the mirror image of a state have the mirror image of its force.
    #[test]
    fn the_symmetric_rule_has_no_preferred_side() {
        let constants = Constants { eta: [2.0; 3], xi: [0.01; 3], phi: [0.05; 3] };
        let grid = grid(6);
        let shape = |a: f64, b: f64| Vector3::new(a + 0.1 * a * b, b - 0.05 * a * a, 0.3 * a * a + 0.2 * b);
        let state = positions(&grid, shape);
        let turned = |v: Vector3<f64>| Vector3::new(-v.x, v.y, v.z);
        let mirrored = positions(&grid, |a, b| turned(shape(1.0 - a, b)));
        let image = |node: usize| {
            let [i, j] = grid.place(node);
            grid.node(5 - i, j)
        };
        for (border, symmetric) in [(Border::Symmetric, true), (Border::Paper, false)] {
            let strong = strong(grid, Elasticity::Cosserat { constants, mixed: false }, border, Divergence::Conservative);
            let [a, b] = [&state, &mirrored].map(|r| force(&strong.operator(r), r));
            let largest = a.iter().fold(0.0f64, |m, f| m.max(f.norm()));
            let off = (0..grid.len()).fold(0.0f64, |m, n| m.max((turned(a[n]) - b[image(n)]).norm()));
            assert!(largest > 1e-3 && (off < 1e-10 * largest) == symmetric, "{border:?} {off} {largest}");
        }
    }

    /// The other model: each outer difference is lost only where it is one that reads a node outside, not the forces along a side.
    #[test]
    fn forces_along_the_sides_of_the_paper_stay() {
        let constants = Constants { eta: [2.0; 3], xi: [0.01; 3], phi: [0.0; 3] };
        let grid = grid(5);
        let of = |constants, shape: &dyn Fn(f64, f64) -> Vector3<f64>| {
            let state = positions(&grid, shape);
            force(&strong(grid, Elasticity::Terzopoulos(constants), Border::Paper, Divergence::Conservative).operator(&state), &state)
        };
        // Stretched along 1 by amounts that grow along it: every row has the force of any other.
        let stretched = of(constants, &|a, b| Vector3::new(a + 0.1 * a * a, b, 0.0));
        for i in 0..5 {
            let [side, inner] = [0, 2].map(|j| stretched[grid.node(i, j)].x);
            assert!((i == 0) == (inner == 0.0) && (side - inner).abs() < 1e-12 * (1.0 + inner.abs()), "{i} {side} {inner}");
        }
        // Bent along 1: no second difference along 1 exists at its ends, so no force of it does. The last column has no normal.
        let bent = of(Constants { eta: [0.0; 3], ..constants }, &|a, b| Vector3::new(a, b, 0.1 * a * a * a));
        for j in 0..4 {
            let along = [0, 1, 2, 3, 4].map(|i| bent[grid.node(i, j)].z != 0.0);
            assert_eq!(along, [false, true, true, true, false]);
        }
    }
}

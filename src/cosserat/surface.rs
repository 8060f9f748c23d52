//! The energy of a Cosserat surface discretised on its grid and differentiated: `scheme = "variational"`.
//!
//! Each cell sums its energy over its four corners. There `eps_11` and `eps_22` are those of the two edges that meet and `eps_12` is that of the
//! cell's centre, which are as many strains as a cell has ways to deform: no mode is free, and bent cells do not lock. `kappa_11` and
//! `kappa_22` are second differences at the nodes, `kappa_12` the cross difference of the cell, each along its own normal by central
//! differences. A border node has the `kappa` across the border of its inner neighbour. Borders are free by nature: nothing is prescribed there.
//!
//! Inertia, damping and loads are not here.

use super::constants::{Constants, Stiffness, is_positive, stiffness};
use super::geometry;
use super::grid::Grid;
use crate::math::TangentPlane;
use crate::sparse::{Curvature, Numbering, Pattern, Potential, Scatter, System};
use nalgebra::Vector3;

/// Places of the nodes that a cell reads, seen from its lower corner.
const WINDOW: [[isize; 2]; 12] = [[-1, 0], [-1, 1], [0, -1], [0, 0], [0, 1], [0, 2], [1, -1], [1, 0], [1, 1], [1, 2], [2, 0], [2, 1]];
/// The cell's corners `(a, b)` among them, as `2 a + b`.
const CORNERS: [usize; 4] = [3, 4, 7, 8];
/// Coordinates of these nodes.
const N: usize = 36;
/// Strains of a cell: `eps_11` on its two edges, `eps_22` on its two edges, `eps_12`, `kappa_11` and `kappa_22` at its corners, `kappa_12`.
const STRAINS: usize = 14;
const EPS_12: usize = 4;
const KAPPA_12: usize = 13;

/// The six strains of corner `(a, b)`, as places among those of the cell.
fn of_corner(a: usize, b: usize) -> [usize; 6] {
    [b, EPS_12, 2 + a, 5 + 2 * a + b, KAPPA_12, 9 + 2 * a + b]
}

/// How energy depends on strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elasticity {
    /// (29) and (30), or with mixed terms (27) and (28); strains are measured in metres and energy is that of rest area.
    Cosserat {
        /// Constants.
        constants: Constants,
        /// Whether to keep mixed terms.
        mixed: bool,
    },
    /// (2): constants that the metric does not scale, coordinates that count nodes. `phi` is not used.
    Terzopoulos(Constants),
}

impl Elasticity {
    /// Whether density, damping and force are per present area (35); those of the other model are per coordinates, as (1) has them.
    pub fn is_per_present_area(&self) -> bool {
        matches!(self, Elasticity::Cosserat { .. })
    }
}

/// One `n.s` with the shares of the nodes it depends on.
struct Normal {
    plane: TangentPlane,
    /// `n.s` [1/m].
    value: f64,
    /// Local node, its multiples in `r_1`, `r_2`, and its multiple in `s`.
    nodes: [(usize, [f64; 2], f64); 5],
    /// `(r^a.s) B_ap - S_p` of each.
    shares: [f64; 5],
}

/// Local number of a place.
fn local(offset: [isize; 2]) -> usize {
    WINDOW.iter().position(|w| *w == offset).unwrap_or_default()
}

/// The energy of the whole grid.
pub struct CosseratSurface {
    grid: Grid,
    /// Nodes that each cell reads; `usize::MAX` for none.
    windows: Vec<[usize; 12]>,
    /// Lower corner of each cell.
    cells: Vec<[usize; 2]>,
    /// Metric and curvature components at rest.
    rest: Vec<[f64; STRAINS]>,
    /// Quadratic form of the strains of each cell [J].
    forms: Vec<[[f64; STRAINS]; STRAINS]>,
    per_present_area: bool,
    scatter: Scatter<N>,
}

impl CosseratSurface {
    /// A surface at rest in `positions` [m], node by node. Errors: a node where the surface is not regular or its energy not positive.
    pub fn new(grid: Grid, positions: &[Vector3<f64>], elasticity: &Elasticity) -> Result<Self, String> {
        let grid = match elasticity {
            Elasticity::Cosserat { .. } => grid,
            Elasticity::Terzopoulos(_) => Grid { spacing: [1.0, 1.0], ..grid },
        };
        let cells: Vec<[usize; 2]> = grid.cells().collect();
        let windows = cells
            .iter()
            .map(|[i, j]| {
                WINDOW.map(|[a, b]| match (i.checked_add_signed(a), j.checked_add_signed(b)) {
                    (Some(i), Some(j)) if i < grid.nodes[0] && j < grid.nodes[1] => grid.node(i, j),
                    _ => usize::MAX,
                })
            })
            .collect();
        let scatter = Scatter::new(std::iter::empty(), &Numbering::new(&[]), &Pattern { column_start: vec![0], row: Vec::new() });
        let per_present_area = elasticity.is_per_present_area();
        let mut surface = CosseratSurface { grid, windows, cells, rest: Vec::new(), forms: Vec::new(), per_present_area, scatter };
        let x: Vec<f64> = positions.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        for cell in 0..surface.cells.len() {
            let (mut values, normals) = surface.measure(cell, &surface.gather(cell, &x));
            if normals.iter().any(|n| !n.value.is_finite()) {
                let [i, j] = surface.cells[cell];
                return Err(format!("the surface is not regular at cell ({i}, {j}): its tangents are parallel or vanish"));
            }
            surface.forms.push(form(&surface.grid, elasticity, &values).map_err(|e| {
                let [i, j] = surface.cells[cell];
                format!("{e} at cell ({i}, {j})")
            })?);
            // The measures are those of strains: half the metric, and the curvature with its sign turned.
            values.iter_mut().take(5).for_each(|v| *v *= 0.5);
            values.iter_mut().skip(5).for_each(|v| *v = -*v);
            surface.rest.push(values);
        }
        Ok(surface)
    }

    /// The grid, as the energy sees it.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    fn stencil(window: &[usize; 12]) -> [usize; N] {
        std::array::from_fn(|s| if window[s / 3] == usize::MAX { usize::MAX } else { 3 * window[s / 3] + s % 3 })
    }

    fn gather(&self, cell: usize, x: &[f64]) -> [Vector3<f64>; 12] {
        self.windows[cell].map(|n| if n == usize::MAX { Vector3::zeros() } else { Vector3::new(x[3 * n], x[3 * n + 1], x[3 * n + 2]) })
    }

    /// The node of the second difference along `k` for a corner of a cell, and that of its neighbours: three along the line, two across it.
    fn line(&self, cell: usize, corner: [usize; 2], k: usize) -> [(usize, [f64; 2], f64); 5] {
        let lower = self.cells[cell];
        let mut at = [lower[0] + corner[0], lower[1] + corner[1]];
        at[k] = at[k].clamp(1, self.grid.nodes[k] - 2);
        let offset = |along: isize, across: isize| {
            let mut o = [at[0] as isize - lower[0] as isize, at[1] as isize - lower[1] as isize];
            o[k] += along;
            o[1 - k] += across;
            local(o)
        };
        let [d, w] = [self.grid.spacing[k], self.grid.spacing[1 - k]];
        let (before, after, width) = if at[1 - k] == 0 {
            (0, 1, w)
        } else if at[1 - k] == self.grid.nodes[1 - k] - 1 {
            (-1, 0, w)
        } else {
            (-1, 1, 2.0 * w)
        };
        // Multiples in r_k and r_(other), put in the order of the coordinates: the plane's orientation depends on it.
        let b = |along: f64, across: f64| if k == 0 { [along, across] } else { [across, along] };
        let second = 1.0 / (d * d);
        [
            (offset(-1, 0), b(-0.5 / d, 0.0), second),
            (offset(0, 0), b(0.0, 0.0), -2.0 * second),
            (offset(1, 0), b(0.5 / d, 0.0), second),
            (offset(0, before), b(0.0, -1.0 / width), 0.0),
            (offset(0, after), b(0.0, 1.0 / width), 0.0),
        ]
    }

    /// Metric and curvature components of a cell in the order of its strains, and what the curvatures are made of.
    fn measure(&self, cell: usize, u: &[Vector3<f64>; 12]) -> ([f64; STRAINS], [Normal; 9]) {
        let mut values = [0.0; STRAINS];
        let [d1, d2] = self.grid.spacing;
        let at = |a: usize, b: usize| u[CORNERS[2 * a + b]];
        for s in 0..2 {
            values[s] = (at(1, s) - at(0, s)).norm_squared() / (d1 * d1);
            values[2 + s] = (at(s, 1) - at(s, 0)).norm_squared() / (d2 * d2);
        }
        let [r1, r2] = self.centre(u);
        values[EPS_12] = r1.dot(&r2);
        let normals: [Normal; 9] = std::array::from_fn(|m| {
            let nodes = match m {
                0..4 => self.line(cell, [m / 2, m % 2], 0),
                4..8 => self.line(cell, [(m - 4) / 2, m % 2], 1),
                _ => {
                    let of = |a: usize, b: usize| {
                        let (sa, sb) = (2.0 * a as f64 - 1.0, 2.0 * b as f64 - 1.0);
                        (CORNERS[2 * a + b], [0.5 * sa / d1, 0.5 * sb / d2], sa * sb / (d1 * d2))
                    };
                    [of(0, 0), of(0, 1), of(1, 0), of(1, 1), (CORNERS[0], [0.0; 2], 0.0)]
                }
            };
            let (mut r1, mut r2, mut s) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            for (node, b, second) in &nodes {
                r1 += u[*node] * b[0];
                r2 += u[*node] * b[1];
                s += u[*node] * *second;
            }
            let plane = TangentPlane::new(&r1, &r2);
            let c = plane.components(&s);
            let shares = nodes.map(|(_, b, second)| c[0] * b[0] + c[1] * b[1] - second);
            Normal { value: plane.normal.dot(&s), plane, nodes, shares }
        });
        for (value, normal) in values[5..].iter_mut().zip(&normals) {
            *value = normal.value;
        }
        (values, normals)
    }

    /// Tangent vectors at the centre of a cell.
    fn centre(&self, u: &[Vector3<f64>; 12]) -> [Vector3<f64>; 2] {
        let [d1, d2] = self.grid.spacing;
        let [a, b, c, d] = CORNERS.map(|n| u[n]);
        [(c - a + (d - b)) / (2.0 * d1), (b - a + (d - c)) / (2.0 * d2)]
    }

    /// Strains of a cell.
    fn strains(&self, cell: usize, values: &[f64; STRAINS]) -> [f64; STRAINS] {
        std::array::from_fn(|m| if m < 5 { 0.5 * values[m] } else { -values[m] } - self.rest[cell][m])
    }

    /// Forces conjugate to the strains.
    fn stresses(&self, cell: usize, strains: &[f64; STRAINS]) -> [f64; STRAINS] {
        self.forms[cell].map(|row| row.iter().zip(strains).map(|(c, s)| c * s).sum())
    }

    /// Derivatives of the strains in the coordinates.
    fn jacobian(&self, u: &[Vector3<f64>; 12], normals: &[Normal; 9]) -> [[f64; N]; STRAINS] {
        let mut rows = [[0.0; N]; STRAINS];
        let [d1, d2] = self.grid.spacing;
        let add = |row: &mut [f64; N], node: usize, v: Vector3<f64>| (0..3).for_each(|k| row[3 * node + k] += v[k]);
        let corner = |a: usize, b: usize| CORNERS[2 * a + b];
        for s in 0..2 {
            let e = (u[corner(1, s)] - u[corner(0, s)]) / (d1 * d1);
            add(&mut rows[s], corner(1, s), e);
            add(&mut rows[s], corner(0, s), -e);
            let e = (u[corner(s, 1)] - u[corner(s, 0)]) / (d2 * d2);
            add(&mut rows[2 + s], corner(s, 1), e);
            add(&mut rows[2 + s], corner(s, 0), -e);
        }
        let [r1, r2] = self.centre(u);
        for (node, b, _) in normals[8].nodes {
            add(&mut rows[EPS_12], node, (r2 * b[0] + r1 * b[1]) * 0.5);
        }
        for (row, normal) in rows[5..].iter_mut().zip(normals) {
            for ((node, ..), share) in normal.nodes.iter().zip(normal.shares) {
                add(row, *node, normal.plane.normal * share);
            }
        }
        rows
    }

    fn cell_gradient(&self, cell: usize, u: &[Vector3<f64>; 12]) -> ([f64; N], f64) {
        let (values, normals) = self.measure(cell, u);
        let strains = self.strains(cell, &values);
        let stresses = self.stresses(cell, &strains);
        let mut gradient = [0.0; N];
        for (row, stress) in self.jacobian(u, &normals).iter().zip(stresses) {
            gradient.iter_mut().zip(row).for_each(|(g, r)| *g += stress * r);
        }
        (gradient, 0.5 * strains.iter().zip(stresses).map(|(s, n)| s * n).sum::<f64>())
    }

    /// See [`Elasticity::is_per_present_area`].
    pub fn is_per_present_area(&self) -> bool {
        self.per_present_area
    }

    /// Whether stretching and bending have an energy together.
    pub fn is_coupled(&self) -> bool {
        self.forms.iter().any(|form| form[..5].iter().any(|row| row[5..].iter().any(|c| *c != 0.0)))
    }

    /// Energies [J] of stretching, of bending, and of both together.
    pub fn energies(&self, x: &[f64]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for cell in 0..self.cells.len() {
            let strains = self.strains(cell, &self.measure(cell, &self.gather(cell, x)).0);
            for (m, row) in self.forms[cell].iter().enumerate() {
                for (k, c) in row.iter().enumerate() {
                    let kind = if m < 5 && k < 5 {
                        0
                    } else if m >= 5 && k >= 5 {
                        1
                    } else {
                        2
                    };
                    sums[kind] += 0.5 * strains[m] * c * strains[k];
                }
            }
        }
        sums
    }
}

/// Quadratic form of the strains of a cell. `values`: rest metric and curvature.
fn form(grid: &Grid, elasticity: &Elasticity, values: &[f64; STRAINS]) -> Result<[[f64; STRAINS]; STRAINS], String> {
    let mut form = [[0.0; STRAINS]; STRAINS];
    for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let places = of_corner(a, b);
        let metric = [values[places[0]], values[places[1]], values[places[2]]];
        let (c, weight): (Stiffness, f64) = match elasticity {
            Elasticity::Cosserat { constants, mixed } => {
                let det = geometry::determinant(&metric);
                if !(det > 0.0) {
                    return Err("the rest metric is not positive".into());
                }
                (stiffness(constants, &geometry::inverse(&metric), *mixed), det.sqrt())
            }
            Elasticity::Terzopoulos(constants) => {
                // (2) has no half in its strain of the metric.
                let twice = |eta: f64| 8.0 * eta;
                let mut c = [[0.0; 6]; 6];
                for k in 0..3 {
                    let times = if k == 1 { 2.0 } else { 1.0 };
                    c[k][k] = times * twice(constants.eta[k]);
                    c[3 + k][3 + k] = times * 2.0 * constants.xi[k];
                }
                (c, 1.0)
            }
        };
        if !is_positive(&c) {
            let mut message = "the energy is not positive for every strain".to_owned();
            if let Elasticity::Cosserat { constants: Constants { eta, xi, phi }, mixed: true } = elasticity {
                message += &format!(
                    ": with mixed terms and unequal constants phi^2 < 4 eta xi in each component does not suffice (phi = {phi:?}, eta = {eta:?}, xi = {xi:?})"
                );
            }
            return Err(message);
        }
        for (m, row) in places.iter().zip(c) {
            for (k, c) in places.iter().zip(row) {
                form[*m][*k] += 0.25 * weight * grid.cell_area() * c;
            }
        }
    }
    Ok(form)
}

impl Potential for CosseratSurface {
    fn stencils(&self, visit: &mut dyn FnMut(&[usize])) {
        for window in &self.windows {
            visit(&Self::stencil(window));
        }
    }

    fn bind(&mut self, numbering: &Numbering, pattern: &Pattern) {
        self.scatter = Scatter::new(self.windows.iter().map(Self::stencil), numbering, pattern);
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let of = |cell: usize| {
            let strains = self.strains(cell, &self.measure(cell, &self.gather(cell, x)).0);
            0.5 * strains.iter().zip(self.stresses(cell, &strains)).map(|(s, n)| s * n).sum::<f64>()
        };
        (0..self.cells.len()).map(of).sum()
    }

    fn assemble(&mut self, x: &[f64], curvature: Curvature, into: &mut System) -> f64 {
        let mut energy = 0.0;
        for cell in 0..self.cells.len() {
            let u = self.gather(cell, x);
            let (values, normals) = self.measure(cell, &u);
            let strains = self.strains(cell, &values);
            let stresses = self.stresses(cell, &strains);
            let rows = self.jacobian(&u, &normals);
            let (mut gradient, mut hessian) = ([0.0; N], [[0.0; N]; N]);
            let mut products = [[0.0; N]; STRAINS];
            for (m, product) in products.iter_mut().enumerate() {
                gradient.iter_mut().zip(&rows[m]).for_each(|(g, r)| *g += stresses[m] * r);
                for (c, row) in self.forms[cell][m].iter().zip(&rows) {
                    if *c != 0.0 {
                        product.iter_mut().zip(row).for_each(|(p, r)| *p += c * r);
                    }
                }
            }
            for (row, product) in rows.iter().zip(&products) {
                for (i, r) in row.iter().enumerate() {
                    if *r != 0.0 {
                        hessian[i][..=i].iter_mut().zip(product).for_each(|(h, p)| *h += r * p);
                    }
                }
            }
            self.add_geometric(&stresses, &normals, curvature, &mut hessian);
            energy += 0.5 * strains.iter().zip(stresses).map(|(s, n)| s * n).sum::<f64>();
            self.scatter.add_gradient(cell, &gradient, into);
            self.scatter.add_hessian(cell, &hessian, into);
        }
        energy
    }

    fn gradient(&self, x: &[f64], into: &mut System) -> f64 {
        let mut energy = 0.0;
        for cell in 0..self.cells.len() {
            let (gradient, e) = self.cell_gradient(cell, &self.gather(cell, x));
            self.scatter.add_gradient(cell, &gradient, into);
            energy += e;
        }
        energy
    }

    fn stiffness_along(&self, x: &[f64], y: &[f64]) -> f64 {
        let mut sum = 0.0;
        for cell in 0..self.cells.len() {
            let u = self.gather(cell, x);
            let (_, normals) = self.measure(cell, &u);
            let along = self.gather(cell, y);
            let strains = self
                .jacobian(&u, &normals)
                .map(|row| row.chunks_exact(3).zip(along).map(|(r, y)| r[0] * y.x + r[1] * y.y + r[2] * y.z).sum::<f64>());
            sum += strains.iter().zip(self.stresses(cell, &strains)).map(|(s, n)| s * n).sum::<f64>();
        }
        sum
    }
}

impl CosseratSurface {
    /// Adds the second derivatives of the strains times the stresses to the lower triangle; for descent only those of stretched edges, which
    /// are positive.
    fn add_geometric(&self, stresses: &[f64; STRAINS], normals: &[Normal; 9], curvature: Curvature, hessian: &mut [[f64; N]; N]) {
        let [d1, d2] = self.grid.spacing;
        let mut add = |p: usize, q: usize, value: f64| {
            let (p, q) = (p.max(q), p.min(q));
            (0..3).for_each(|k| hessian[3 * p + k][3 * q + k] += value);
        };
        for s in 0..2 {
            for (stress, d, p, q) in
                [(stresses[s], d1, CORNERS[s], CORNERS[2 + s]), (stresses[2 + s], d2, CORNERS[2 * s], CORNERS[2 * s + 1])]
            {
                let stress = if curvature == Curvature::Projected { stress.max(0.0) } else { stress } / (d * d);
                add(p, p, stress);
                add(q, q, stress);
                add(p, q, -stress);
            }
        }
        if curvature == Curvature::Projected {
            return;
        }
        let nodes = &normals[8].nodes[..4];
        for (i, (p, bp, _)) in nodes.iter().enumerate() {
            for (q, bq, _) in &nodes[..=i] {
                add(*p, *q, 0.5 * stresses[EPS_12] * (bp[0] * bq[1] + bp[1] * bq[0]));
            }
        }
        for (normal, stress) in normals.iter().zip(&stresses[5..]) {
            let gradients = normal.nodes.map(|(_, b, _)| normal.plane.surface_gradient(b));
            for (i, (p, ..)) in normal.nodes.iter().enumerate() {
                for (j, (q, ..)) in normal.nodes.iter().enumerate() {
                    if p < q {
                        continue;
                    }
                    let block =
                        normal.plane.hessian(normal.value, [normal.shares[i], normal.shares[j]], [&gradients[i], &gradients[j]]) * -stress;
                    for a in 0..3 {
                        for b in 0..if p == q { a + 1 } else { 3 } {
                            hessian[3 * p + a][3 * q + b] += block[(a, b)];
                        }
                    }
                }
            }
        }
    }
}

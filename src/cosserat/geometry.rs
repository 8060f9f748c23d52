//! Geometry at one point of a surface from the derivatives of its position (Wu and de Melo, section 2).
//!
//! Symmetric tensors are arrays of the components 11, 12, 22. [`component`] finds the one of two indices, from 0. Nothing here knows how derivatives are taken.

use nalgebra::Vector3;

/// Place of the component `ij` of a symmetric tensor.
pub fn component(i: usize, j: usize) -> usize {
    i + j
}

/// Derivatives of the position at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives {
    /// `r_1`, `r_2` [1, for coordinates in metres].
    pub first: [Vector3<f64>; 2],
    /// `r_11`, `r_12`, `r_22` [1/m].
    pub second: [Vector3<f64>; 3],
}

impl Derivatives {
    /// Metric tensor `G_ij = r_i . r_j` (5).
    pub fn metric(&self) -> [f64; 3] {
        let [r1, r2] = &self.first;
        [r1.norm_squared(), r1.dot(r2), r2.norm_squared()]
    }

    /// Unit normal along `r_1 x r_2` (10); zero where the surface is not regular.
    pub fn normal(&self) -> Vector3<f64> {
        self.first[0].cross(&self.first[1]).try_normalize(0.0).unwrap_or_default()
    }

    /// Curvature tensor `B_ij = n . r_ij` (9) for a normal.
    pub fn curvature(&self, normal: &Vector3<f64>) -> [f64; 3] {
        self.second.map(|r| normal.dot(&r))
    }

    /// Christoffel symbols (15), second form: `[k][ij]`, `G^kl (r_ij . r_l)`.
    pub fn christoffel(&self) -> [[f64; 3]; 2] {
        let inverse = inverse(&self.metric());
        let lower: [[f64; 3]; 2] = [0, 1].map(|l| self.second.map(|r| r.dot(&self.first[l])));
        [0, 1].map(|k| [0, 1, 2].map(|c| (0..2).map(|l| inverse[component(k, l)] * lower[l][c]).sum()))
    }

    /// Tangential part `Gamma^k_ij r_k` of the second derivative `ij`.
    pub fn tangential(&self, symbols: &[[f64; 3]; 2], ij: usize) -> Vector3<f64> {
        self.first[0] * symbols[0][ij] + self.first[1] * symbols[1][ij]
    }

    /// Normal by the Gauss formula (14), `r_ij - Gamma^k_ij r_k = B_ij n` for three components at once, by least squares in the present metric with the present
    /// normal as one more equation: `(B^ij (r_ij - Gamma^k_ij r_k) + flat^2 n) / (B^ij B_ij + flat^2)`.
    ///
    /// The paper does not say which component to divide by. All of them leave no choice between equal ones, which round-off would make differently on
    /// the two sides of a symmetric surface. Where curvatures are far below `flat` [1/m] this is the present normal, the paper's rule for `B_ij = 0`.
    pub fn gauss_normal(&self, normal: &Vector3<f64>, flat: f64) -> GaussNormal {
        let (metric, b) = (inverse(&self.metric()), self.curvature(normal));
        let raised = |i: usize, j: usize| {
            let of = |k: usize, l: usize| metric[component(i, k)] * metric[component(j, l)] * b[component(k, l)];
            of(0, 0) + (of(0, 1) + of(1, 0)) + of(1, 1)
        };
        let weights = [raised(0, 0), 2.0 * raised(0, 1), raised(1, 1)];
        let sum = (weights[0] * b[0] + weights[2] * b[2]) + weights[1] * b[1] + flat * flat;
        GaussNormal { weights: weights.map(|w| w / sum), symbols: self.christoffel(), constant: normal * (flat * flat / sum) }
    }
}

/// The normal as a linear function of derivatives: `sum weights_ij (r_ij - symbols^k_ij r_k) + constant`, the mixed component counted twice in its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussNormal {
    /// Weights of the components [m].
    pub weights: [f64; 3],
    /// `Gamma^k_ij` as `[k][ij]`.
    pub symbols: [[f64; 3]; 2],
    /// The part of the present normal.
    pub constant: Vector3<f64>,
}

impl GaussNormal {
    /// The normal of derivatives, those that it was made of or later ones.
    pub fn of(&self, d: &Derivatives) -> Vector3<f64> {
        (0..3).map(|ij| (d.second[ij] - d.tangential(&self.symbols, ij)) * self.weights[ij]).sum::<Vector3<f64>>() + self.constant
    }
}

/// Inverse of a symmetric tensor (6): `G^ij`.
pub fn inverse(g: &[f64; 3]) -> [f64; 3] {
    let det = determinant(g);
    [g[2] / det, -g[1] / det, g[0] / det]
}

/// Determinant of a symmetric tensor (7).
pub fn determinant(g: &[f64; 3]) -> f64 {
    g[0] * g[2] - g[1] * g[1]
}

/// Mean curvature (12) [1/m].
pub fn mean_curvature(g: &[f64; 3], b: &[f64; 3]) -> f64 {
    (g[0] * b[2] - 2.0 * g[1] * b[1] + g[2] * b[0]) / (2.0 * determinant(g))
}

/// Gauss curvature (13) [1/m2].
pub fn gauss_curvature(g: &[f64; 3], b: &[f64; 3]) -> f64 {
    determinant(b) / determinant(g)
}

/// Christoffel symbols (15), first form: from the metric and its derivatives along the two coordinates, `[k][ij]`.
pub fn christoffel_of_metric(g: &[f64; 3], slopes: &[[f64; 3]; 2]) -> [[f64; 3]; 2] {
    let inverse = inverse(g);
    let d = |i: usize, j: usize, along: usize| slopes[along][component(i, j)];
    let lower = |i: usize, j: usize, l: usize| 0.5 * (d(j, l, i) + d(l, i, j) - d(i, j, l));
    [0, 1].map(|k| [(0, 0), (0, 1), (1, 1)].map(|(i, j)| (0..2).map(|l| inverse[component(k, l)] * lower(i, j, l)).sum()))
}

/// Mixed curvature `B^i_j = G^ik B_jk` (26): `[i][j]`.
pub fn mixed_curvature(g: &[f64; 3], b: &[f64; 3]) -> [[f64; 2]; 2] {
    let inverse = inverse(g);
    [0, 1].map(|i| [0, 1].map(|j| (0..2).map(|k| inverse[component(i, k)] * b[component(j, k)]).sum()))
}

/// `Gamma^i_ji`, summed over `i`: what (22) multiplies `N^j` by.
pub fn contracted(symbols: &[[f64; 3]; 2]) -> [f64; 2] {
    [0, 1].map(|j| symbols[0][component(j, 0)] + symbols[1][component(j, 1)])
}

/// What (25) adds to the divergence `M^jk_,k` of a symmetric tensor for its covariant one: `Gamma^j_lk M^lk + Gamma^k_lk M^jl`, for each `j`.
pub fn divergence_correction(symbols: &[[f64; 3]; 2], m: &[f64; 3]) -> [f64; 2] {
    let contracted = contracted(symbols);
    [0, 1].map(|j| {
        let turned = symbols[j][0] * m[0] + 2.0 * symbols[j][1] * m[1] + symbols[j][2] * m[2];
        turned + contracted[0] * m[component(j, 0)] + contracted[1] * m[component(j, 1)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of radius 2 in a skewed parametrisation; derivatives by central differences of fourth order.
    fn sphere(a: f64, b: f64) -> Vector3<f64> {
        let (u, v) = (0.4 * a + 0.2 * b * b + 0.1 * a * b, 0.3 * b - 0.15 * a);
        Vector3::new(2.0 * u.cos() * v.cos(), 2.0 * u.sin() * v.cos(), 2.0 * v.sin())
    }

    fn cylinder(a: f64, b: f64) -> Vector3<f64> {
        // Coordinates run obliquely over it.
        let (s, z) = (0.8 * a + 0.6 * b, 0.8 * b - 0.6 * a);
        Vector3::new(0.5 * (s / 0.5).sin(), z, 0.5 * (1.0 - (s / 0.5).cos()))
    }

    fn slope(f: impl Fn(f64) -> Vector3<f64>) -> Vector3<f64> {
        let h = 1e-3;
        ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
    }

    fn derivatives(r: impl Fn(f64, f64) -> Vector3<f64> + Copy, a: f64, b: f64) -> Derivatives {
        let d = |a: f64, b: f64| [slope(|h| r(a + h, b)), slope(|h| r(a, b + h))];
        let second = [slope(|h| d(a + h, b)[0]), slope(|h| d(a + h, b)[1]), slope(|h| d(a, b + h)[1])];
        Derivatives { first: d(a, b), second }
    }

    fn metric_slopes(r: impl Fn(f64, f64) -> Vector3<f64> + Copy, a: f64, b: f64) -> [[f64; 3]; 2] {
        let g = |a: f64, b: f64| Vector3::from(derivatives(r, a, b).metric());
        [slope(|h| g(a + h, b)), slope(|h| g(a, b + h))].map(|v| [v.x, v.y, v.z])
    }

    #[test]
    fn a_sphere_in_any_parametrisation() {
        for [a, b] in [[0.3, 0.2], [-0.5, 0.7], [1.0, -0.4]] {
            let d = derivatives(sphere, a, b);
            let (g, n) = (d.metric(), d.normal());
            let curvature = d.curvature(&n);
            let sign = n.dot(&sphere(a, b)).signum();
            assert!((mean_curvature(&g, &curvature) * sign + 0.5).abs() < 1e-8);
            assert!((gauss_curvature(&g, &curvature) - 0.25).abs() < 1e-8);
            for (b, g) in curvature.iter().zip(g) {
                assert!((b * sign + 0.5 * g).abs() < 1e-8, "b is -a/R");
            }
        }
    }

    #[test]
    fn a_cylinder_is_flat_within() {
        let d = derivatives(cylinder, 0.2, 0.1);
        let (g, b) = (d.metric(), d.curvature(&d.normal()));
        assert!(gauss_curvature(&g, &b).abs() < 1e-8 && (mean_curvature(&g, &b) - 1.0).abs() < 1e-8);
        assert!((g[0] - 1.0).abs() < 1e-9 && g[1].abs() < 1e-9 && (g[2] - 1.0).abs() < 1e-9);
        assert!(d.christoffel().as_flattened().iter().all(|s| s.abs() < 1e-8));
        let mixed = mixed_curvature(&g, &b);
        assert!((mixed[0][0] + mixed[1][1] - 2.0).abs() < 1e-8 && (mixed[0][0] - 1.28).abs() < 1e-8);
    }

    #[test]
    fn both_forms_of_the_christoffel_symbols_agree() {
        let (a, b) = (0.3, 0.2);
        let d = derivatives(sphere, a, b);
        let first = christoffel_of_metric(&d.metric(), &metric_slopes(sphere, a, b));
        for (x, y) in first.as_flattened().iter().zip(d.christoffel().as_flattened()) {
            assert!(x.abs() > 1e-3 && (x - y).abs() < 1e-7, "{x} {y}");
        }
    }

    #[test]
    fn the_gauss_formula_gives_the_normal_back() {
        let d = derivatives(sphere, 0.3, 0.2);
        let normal = d.normal();
        for flat in [0.0, 1e-3, 0.5, 1e3] {
            assert!((d.gauss_normal(&normal, flat).of(&d) - normal).norm() < 1e-9);
        }
        // Without curvature it is the present one, whatever the derivatives are later.
        let flat = Derivatives { second: d.second.map(|r| r - normal * normal.dot(&r)), ..d };
        let found = flat.gauss_normal(&normal, 1e-3);
        assert!(found.weights.iter().all(|w| w.abs() < 1e-6) && (found.of(&d) - normal).norm() < 1e-6);
    }

    /// Which coordinates the normal is taken in does not matter, not even that of another state.
    #[test]
    fn the_gauss_formula_has_no_preferred_component() {
        let [now, later] = [[0.3, 0.2], [0.4, 0.1]].map(|[a, b]| derivatives(sphere, a, b));
        // r(a1, a2) with a = t a'.
        let t = [[1.1, 0.3], [-0.2, 0.9]];
        let turn = |d: &Derivatives| {
            let first = [0, 1].map(|i| d.first[0] * t[0][i] + d.first[1] * t[1][i]);
            let at = |i: usize, j: usize| {
                (0..2).flat_map(|k| (0..2).map(move |l| (k, l))).map(|(k, l)| d.second[component(k, l)] * (t[k][i] * t[l][j])).sum()
            };
            Derivatives { first, second: [at(0, 0), at(0, 1), at(1, 1)] }
        };
        let normal = now.normal();
        let of = |now: &Derivatives, later: &Derivatives| now.gauss_normal(&normal, 0.1).of(later);
        let (one, other) = (of(&now, &later), of(&turn(&now), &turn(&later)));
        assert!((one - normal).norm() > 1e-2 && (one - other).norm() < 1e-10, "{one} {other}");
    }

    /// `div N = (1/sqrt G) d_i (sqrt G N^i)`, and the covariant divergence of the inverse metric vanishes.
    #[test]
    fn covariant_derivatives_are_those_of_tensors() {
        let (a, b) = (0.3, 0.2);
        let d = derivatives(sphere, a, b);
        let symbols = d.christoffel();
        let root = |a: f64, b: f64| Vector3::x() * determinant(&derivatives(sphere, a, b).metric()).sqrt();
        let slopes = [slope(|h| root(a + h, b)).x, slope(|h| root(a, b + h)).x];
        for (c, s) in contracted(&symbols).iter().zip(slopes) {
            assert!(c.abs() > 1e-3 && (c - s / root(a, b).x).abs() < 1e-7);
        }
        let raised = |a: f64, b: f64| Vector3::from(inverse(&derivatives(sphere, a, b).metric()));
        let [d1, d2] = [slope(|h| raised(a + h, b)), slope(|h| raised(a, b + h))];
        let correction = divergence_correction(&symbols, &inverse(&d.metric()));
        for (divergence, correction) in [d1[0] + d2[1], d1[1] + d2[2]].iter().zip(correction) {
            assert!(correction.abs() > 1e-3 && (divergence + correction).abs() < 1e-6, "{divergence} {correction}");
        }
    }
}

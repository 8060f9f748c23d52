//! Constant tables of the quadratic triangle: shape functions at the points where the element needs them, and the Regge interpolation of
//! its first form.
//!
//! Nodes of a face: vertices 0, 1, 2, then the midpoint of edge `i`, opposite vertex `i`, as node `3 + i`. Coordinates `(x, y)` of the
//! reference triangle belong to `v1 - v0` and `v2 - v0`. Everything is computed at compile time; nothing here depends on a mesh.

pub(super) use crate::math::quadrature::{quadratic_shape as shape, quadratic_slopes as gradient};

use super::linear_free::{OUTWARD as OUTWARD_DIRECTION, TANGENT as EDGE_DIRECTION};

/// Gauss points of an edge, in its direction of travel, on [0, 1].
pub(super) use crate::math::quadrature::GAUSS_2 as GAUSS;

/// Interior integration points.
pub(super) const POINTS: [[f64; 2]; 3] = [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]];

/// Corners of the reference triangle.
const CORNERS: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

/// `r1 = sum_p INNER[k][0][p] x_p` and `r2` at interior point `k`.
pub(super) const INNER: [[[f64; 6]; 2]; 3] = [gradient(POINTS[0]), gradient(POINTS[1]), gradient(POINTS[2])];

/// `r_11`, `r_12`, `r_22`, the same all over the face.
pub(super) const SECOND: [[f64; 6]; 3] =
    [[4.0, 4.0, 0.0, 0.0, 0.0, -8.0], [4.0, 0.0, 0.0, 4.0, -4.0, -4.0], [4.0, 0.0, 4.0, 0.0, -8.0, 0.0]];

/// Nodes on edge `i` in the face's direction of travel (start, end, middle), then those off it.
pub(super) const EDGE_NODES: [[usize; 6]; 3] = [[1, 2, 3, 0, 4, 5], [2, 0, 4, 1, 5, 3], [0, 1, 5, 2, 3, 4]];

/// Tangent of an edge at its Gauss points by its start, end and middle.
pub(super) const EDGE_TANGENT: [[f64; 3]; 2] = [edge_tangent(GAUSS[0]), edge_tangent(GAUSS[1])];

/// Tangent `T` at Gauss point `g` of edge `i`, by nodes.
pub(super) const TANGENT: [[[f64; 6]; 2]; 3] = at_edges(&EDGE_DIRECTION);

/// Outward vector `D = dr o_i` at Gauss point `g` of edge `i`, by nodes.
pub(super) const OUTWARD: [[[f64; 6]; 2]; 3] = at_edges(&OUTWARD_DIRECTION);

/// What a unit of the hinge at Gauss point `g` of edge `i` adds to `b` at interior point `k`, as a multiple of `g_i g_i^T`:
/// `-6 l_k / 2`, `l_k` the linear function that is 1 at interior point `k` and 0 at the others.
pub(super) const BEND: [[[f64; 3]; 2]; 3] = bend();

/// First form at the interior points (11, 12, 22 at point 0, then 1, 2) from the nine numbers that define it: `t.a.t` at the Gauss points
/// of edges 0, 1, 2, then the mean of a11, a12, a22 over the face.
pub(super) const REGGE: [[f64; 9]; 9] = invert(conditions());

/// The same by nodes: the derivative of component `c` in node `p` is `sum_q METRIC[c][p][q] x_q`, and half its product with `x_p`, summed,
/// the component.
pub(super) const METRIC: [[[f64; 6]; 6]; 9] = metric();

/// Place of Gauss point `g` of edge `i`.
pub(super) const fn edge_point(i: usize, g: usize) -> [f64; 2] {
    let (a, b, t) = (CORNERS[(i + 1) % 3], CORNERS[(i + 2) % 3], GAUSS[g]);
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

const fn edge_tangent(t: f64) -> [f64; 3] {
    [4.0 * t - 3.0, 4.0 * t - 1.0, 4.0 - 8.0 * t]
}

/// Derivative along `directions[i]` at the Gauss points of each edge `i`.
const fn at_edges(directions: &[[f64; 2]; 3]) -> [[[f64; 6]; 2]; 3] {
    let mut table = [[[0.0; 6]; 2]; 3];
    let mut n = 0;
    while n < 36 {
        let (i, g, p) = (n / 12, n / 6 % 2, n % 6);
        let d = gradient(edge_point(i, g));
        table[i][g][p] = directions[i][0] * d[0][p] + directions[i][1] * d[1][p];
        n += 1;
    }
    table
}

/// `l_k` at a place.
pub(super) const fn linear([x, y]: [f64; 2]) -> [f64; 3] {
    [5.0 / 3.0 - 2.0 * x - 2.0 * y, 2.0 * x - 1.0 / 3.0, 2.0 * y - 1.0 / 3.0]
}

const fn bend() -> [[[f64; 3]; 2]; 3] {
    let mut table = [[[0.0; 3]; 2]; 3];
    let mut n = 0;
    while n < 18 {
        let (i, g, k) = (n / 6, n / 3 % 2, n % 3);
        table[i][g][k] = -3.0 * linear(edge_point(i, g))[k];
        n += 1;
    }
    table
}

/// The nine numbers that define the first form, from its values at the interior points.
const fn conditions() -> [[f64; 9]; 9] {
    let mut m = [[0.0; 9]; 9];
    let mut n = 0;
    while n < 18 {
        let (i, g, k) = (n / 6, n / 3 % 2, n % 3);
        let (l, t) = (linear(edge_point(i, g))[k], EDGE_DIRECTION[i]);
        m[2 * i + g][3 * k] = l * t[0] * t[0];
        m[2 * i + g][3 * k + 1] = l * 2.0 * t[0] * t[1];
        m[2 * i + g][3 * k + 2] = l * t[1] * t[1];
        n += 1;
    }
    let mut n = 0;
    while n < 9 {
        m[6 + n % 3][n] = 1.0 / 3.0;
        n += 1;
    }
    m
}

/// Inverse by elimination with row exchanges.
const fn invert(mut m: [[f64; 9]; 9]) -> [[f64; 9]; 9] {
    let mut inverse = [[0.0; 9]; 9];
    let mut i = 0;
    while i < 9 {
        inverse[i][i] = 1.0;
        i += 1;
    }
    let mut c = 0;
    while c < 9 {
        let (mut pivot, mut r) = (c, c + 1);
        while r < 9 {
            if m[r][c].abs() > m[pivot][c].abs() {
                pivot = r;
            }
            r += 1;
        }
        (m[c], m[pivot]) = (m[pivot], m[c]);
        (inverse[c], inverse[pivot]) = (inverse[pivot], inverse[c]);
        let scale = 1.0 / m[c][c];
        let (row, inverse_row) = (m[c], inverse[c]);
        let mut r = 0;
        while r < 9 {
            let factor = if r == c { 1.0 - scale } else { m[r][c] * scale };
            let mut j = 0;
            while j < 9 {
                m[r][j] -= factor * row[j];
                inverse[r][j] -= factor * inverse_row[j];
                j += 1;
            }
            r += 1;
        }
        c += 1;
    }
    inverse
}

const fn metric() -> [[[f64; 6]; 6]; 9] {
    let mut table = [[[0.0; 6]; 6]; 9];
    let mut n = 0;
    while n < 324 {
        let (c, p, q) = (n / 36, n / 6 % 6, n % 6);
        let mut sum = 0.0;
        let mut i = 0;
        while i < 3 {
            sum += REGGE[c][2 * i] * TANGENT[i][0][p] * TANGENT[i][0][q] + REGGE[c][2 * i + 1] * TANGENT[i][1][p] * TANGENT[i][1][q];
            let [d1, d2] = INNER[i];
            sum +=
                REGGE[c][6] / 3.0 * d1[p] * d1[q] + REGGE[c][7] / 6.0 * (d1[p] * d2[q] + d2[p] * d1[q]) + REGGE[c][8] / 3.0 * d2[p] * d2[q];
            i += 1;
        }
        table[c][p][q] = 2.0 * sum;
        n += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions of a quadratic map with all its coefficients.
    fn map([x, y]: [f64; 2]) -> f64 {
        0.3 + 1.1 * x - 0.4 * y + 0.7 * x * x - 0.2 * x * y + 0.9 * y * y
    }

    fn nodes() -> [f64; 6] {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.0, 0.5], [0.5, 0.0]].map(map)
    }

    fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn tables_differentiate_a_quadratic_exactly() {
        let slope = |[x, y]: [f64; 2]| [1.1 + 1.4 * x - 0.2 * y, -0.4 - 0.2 * x + 1.8 * y];
        let u = nodes();
        for (k, p) in POINTS.into_iter().enumerate() {
            for (row, value) in INNER[k].iter().zip(slope(p)) {
                assert!((dot(row, &u) - value).abs() < 1e-14);
            }
        }
        for (row, value) in SECOND.iter().zip([1.4, -0.2, 1.8]) {
            assert!((dot(row, &u) - value).abs() < 1e-14);
        }
        for i in 0..3 {
            for g in 0..2 {
                let s = slope(edge_point(i, g));
                let along = EDGE_DIRECTION[i][0] * s[0] + EDGE_DIRECTION[i][1] * s[1];
                assert!((dot(&TANGENT[i][g], &u) - along).abs() < 1e-14);
                let short: f64 = (0..3).map(|n| EDGE_TANGENT[g][n] * u[EDGE_NODES[i][n]]).sum();
                assert!((short - along).abs() < 1e-14);
                assert!(EDGE_NODES[i][3..].iter().all(|p| TANGENT[i][g][*p].abs() < 1e-15));
            }
        }
    }

    /// A linear tensor field is its own interpolant.
    #[test]
    fn interpolation_keeps_linear_fields() {
        let field = |[x, y]: [f64; 2]| [1.0 + 0.3 * x - 0.2 * y, 0.1 - 0.5 * x + 0.4 * y, 2.0 + 0.6 * x + 0.7 * y];
        let mut values = [0.0; 9];
        for i in 0..3 {
            for g in 0..2 {
                let (a, t) = (field(edge_point(i, g)), EDGE_DIRECTION[i]);
                values[2 * i + g] = a[0] * t[0] * t[0] + 2.0 * a[1] * t[0] * t[1] + a[2] * t[1] * t[1];
            }
        }
        values[6..].copy_from_slice(&field([1.0 / 3.0, 1.0 / 3.0]));
        for (k, p) in POINTS.into_iter().enumerate() {
            for c in 0..3 {
                let value: f64 = (0..9).map(|n| REGGE[3 * k + c][n] * values[n]).sum();
                assert!((value - field(p)[c]).abs() < 1e-14, "{value} {:?}", field(p));
            }
        }
    }
}

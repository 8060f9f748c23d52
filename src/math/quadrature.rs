//! Shape functions and quadrature on the reference triangle (0, 0), (1, 0), (0, 1) and on edges.
//!
//! Nodes of the quadratic triangle: corners 0, 1, 2, then the midpoint of edge `i`, opposite corner `i`, as node `3 + i`.

/// A quadrature point of a surface of triangles with `K` nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<const K: usize> {
    /// Weight; all add up to the triangle's area, 1/2.
    pub weight: f64,
    /// Shape functions.
    pub shape: [f64; K],
    /// Their derivatives in x and y.
    pub slopes: [[f64; K]; 2],
}

/// Points and weights exact to degree 5 (Radon).
pub const RADON: [([f64; 2], f64); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_3;
    const WA: f64 = 0.066_197_076_394_253_1;
    const WB: f64 = 0.062_969_590_272_413_6;
    [
        ([1.0 / 3.0, 1.0 / 3.0], 0.1125),
        ([A, A], WA),
        ([1.0 - 2.0 * A, A], WA),
        ([A, 1.0 - 2.0 * A], WA),
        ([B, B], WB),
        ([1.0 - 2.0 * B, B], WB),
        ([B, 1.0 - 2.0 * B], WB),
    ]
};

/// Gauss points and weights on [0, 1], exact to degree 5.
pub const GAUSS: [(f64, f64); 3] = [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Gauss points on [0, 1], exact to degree 3 with weights 1/2.
pub const GAUSS_2: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Shape functions of the quadratic triangle.
pub const fn quadratic_shape([x, y]: [f64; 2]) -> [f64; 6] {
    let z = 1.0 - x - y;
    [z * (2.0 * z - 1.0), x * (2.0 * x - 1.0), y * (2.0 * y - 1.0), 4.0 * x * y, 4.0 * z * y, 4.0 * z * x]
}

/// Derivatives of the shape functions of the quadratic triangle in x and y.
pub const fn quadratic_slopes([x, y]: [f64; 2]) -> [[f64; 6]; 2] {
    let z = 1.0 - x - y;
    [
        [1.0 - 4.0 * z, 4.0 * x - 1.0, 0.0, 4.0 * y, -4.0 * y, 4.0 * (z - x)],
        [1.0 - 4.0 * z, 0.0, 4.0 * y - 1.0, 4.0 * x, 4.0 * (z - y), -4.0 * x],
    ]
}

/// The centroid: exact for what is linear on a flat triangle.
pub fn linear_triangle() -> [SurfacePoint<3>; 1] {
    [SurfacePoint { weight: 0.5, shape: [1.0 / 3.0; 3], slopes: [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]] }]
}

/// Seven points on a flat triangle, for what varies over it.
pub fn linear_radon() -> [SurfacePoint<3>; 7] {
    RADON.map(|([x, y], weight)| SurfacePoint { weight, shape: [1.0 - x - y, x, y], slopes: [[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]] })
}

/// Seven points: exact for the product of a shape function and the area vector of a curved triangle.
pub fn quadratic_triangle() -> [SurfacePoint<6>; 7] {
    RADON.map(|(place, weight)| SurfacePoint { weight, shape: quadratic_shape(place), slopes: quadratic_slopes(place) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radon_is_exact_to_degree_five() {
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        for p in 0..=5u32 {
            for q in 0..=5 - p {
                let sum: f64 = RADON.iter().map(|([x, y], w)| w * x.powi(p as i32) * y.powi(q as i32)).sum();
                let exact = factorial(p) * factorial(q) / factorial(p + q + 2);
                assert!((sum - exact).abs() < 1e-15, "x^{p} y^{q}: {sum} {exact}");
            }
        }
    }

    #[test]
    fn shapes_are_one_at_their_node_and_add_up() {
        let nodes = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.0, 0.5], [0.5, 0.0]];
        for (i, node) in nodes.into_iter().enumerate() {
            for (j, n) in quadratic_shape(node).into_iter().enumerate() {
                assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        let slopes = quadratic_slopes([0.3, 0.2]);
        assert!(slopes.iter().all(|s| s.iter().sum::<f64>().abs() < 1e-15));
    }
}

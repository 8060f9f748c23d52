//! Curvature of a triangle mesh by fitting a quadric at each vertex.
//!
//! An outside view of a result: it sees positions only and no element, so it can judge any of them.

use nalgebra::{Cholesky, Matrix2, Vector2, Vector3, Vector5};

/// Curvature of a surface at a point [1/m], with the sign of `b = -dr.dn`: a sphere with outward normals has -1/R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    /// Principal curvatures, larger first [1/m].
    pub principal: [f64; 2],
    /// Their mean [1/m].
    pub mean: f64,
    /// Their product [1/m^2].
    pub gauss: f64,
}

/// Neighbours that a fit of five coefficients should have at least: one more, so that it is a fit.
const ENOUGH: usize = 6;

/// Curvature at each vertex.
///
/// Fits `w = a u + b v + (c u^2 + 2 d u v + e v^2)/2` to the neighbours over two edges (more where these are too few), in a
/// frame along the area-weighted normal, by least squares. First order in the mesh size, second where the neighbourhood is symmetric
/// about the vertex (Cazals & Pouget 2005). NaN at a vertex without faces or whose neighbours determine no quadric.
pub fn curvature(vertices: &[Vector3<f64>], faces: &[[usize; 3]]) -> Vec<Curvature> {
    let mut neighbours = vec![Vec::new(); vertices.len()];
    let mut normals = vec![Vector3::zeros(); vertices.len()];
    for &[a, b, c] in faces {
        let normal = (vertices[b] - vertices[a]).cross(&(vertices[c] - vertices[a]));
        for [v, w, x] in [[a, b, c], [b, c, a], [c, a, b]] {
            normals[v] += normal;
            neighbours[v].extend([w, x]);
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    let none = Curvature { principal: [f64::NAN; 2], mean: f64::NAN, gauss: f64::NAN };
    let mut around = Around { seen: vec![usize::MAX; vertices.len()], list: Vec::new() };
    let at = |v: usize| fit(v, vertices, &normals[v], around.collect(v, &neighbours)).unwrap_or(none);
    (0..vertices.len()).map(at).collect()
}

/// Neighbourhoods, one after the other in the same memory.
struct Around {
    /// The vertex for which a vertex was last met.
    seen: Vec<usize>,
    list: Vec<usize>,
}

impl Around {
    /// Vertices within two edges of `v`, or within as many as it takes to have enough, without `v`.
    fn collect(&mut self, v: usize, neighbours: &[Vec<usize>]) -> &[usize] {
        self.list.clear();
        self.list.push(v);
        self.seen[v] = v;
        let (mut start, mut ring) = (0, 0);
        while start < self.list.len() && (ring < 2 || self.list.len() <= ENOUGH) {
            let end = self.list.len();
            for i in start..end {
                for &w in &neighbours[self.list[i]] {
                    if self.seen[w] != v {
                        self.seen[w] = v;
                        self.list.push(w);
                    }
                }
            }
            (start, ring) = (end, ring + 1);
        }
        &self.list[1..]
    }
}

fn fit(v: usize, vertices: &[Vector3<f64>], normal: &Vector3<f64>, around: &[usize]) -> Option<Curvature> {
    let n = normal.try_normalize(0.0)?;
    let across = Vector3::ith(n.iamin(), 1.0).cross(&n).normalize();
    let along = n.cross(&across);
    let offsets = || around.iter().map(|w| vertices[*w] - vertices[v]);
    // In units of the neighbourhood, so that all columns of the fit are of one size.
    let size = offsets().map(|d| d.norm()).fold(0.0, f64::max);
    let mut matrix = nalgebra::Matrix5::zeros();
    let mut right = Vector5::zeros();
    for d in offsets() {
        let (x, y, z) = (across.dot(&d) / size, along.dot(&d) / size, n.dot(&d) / size);
        let row = Vector5::new(x, y, 0.5 * x * x, x * y, 0.5 * y * y);
        matrix += row * row.transpose();
        right += row * z;
    }
    // A pivot as small as rounding means that the neighbours do not determine the quadric, as on a strip of one cell.
    let cholesky = Cholesky::new(matrix)?;
    if cholesky.l_dirty().diagonal().min() < 1e-6 * matrix.diagonal().max().sqrt() {
        return None;
    }
    let [a, b, c, d, e] = cholesky.solve(&right).into();
    let slope = Vector2::new(a, b);
    let first = Matrix2::identity() + slope * slope.transpose();
    let second = Matrix2::new(c, d, d, e) / (size * (1.0 + slope.norm_squared()).sqrt());
    // Both principal curvatures from one symmetric matrix: they agree to rounding where the surface bends alike in all directions.
    let inverse = Cholesky::new(first)?.l().try_inverse()?;
    let shape = inverse * second * inverse.transpose();
    let (mean, half) = (0.5 * shape.trace(), 0.5 * (shape[(0, 0)] - shape[(1, 1)]));
    let root = half.hypot(shape[(0, 1)]);
    Some(Curvature { principal: [mean + root, mean - root], mean, gauss: shape.determinant() })
}

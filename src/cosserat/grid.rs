//! A grid of nodes and the finite differences on it.
//!
//! Node `(i, j)` has number `i q + j`; `i` counts along the first material coordinate. A difference that reads a node outside the grid is zero
//! by the paper's rule, which leaves the first derivatives of one end of every line undefined; the symmetric rule takes the difference of the
//! nearest inner place instead. Only differences stand here: what they are differences of is the caller's matter.

use super::geometry::Derivatives;
use nalgebra::Vector3;
use std::ops::{Add, Mul, Sub};

/// What a difference is that reads a node outside the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// Zero (Wu and de Melo, after Terzopoulos and others 1987).
    Paper,
    /// That of the nearest place where it exists.
    Symmetric,
}

/// Nodes and spacing of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Nodes along the two material coordinates, each >= 3.
    pub nodes: [usize; 2],
    /// Distance of neighbours in the two material coordinates [m].
    pub spacing: [f64; 2],
}

impl Grid {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes[0] * self.nodes[1]
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of a node.
    pub fn node(&self, i: usize, j: usize) -> usize {
        i * self.nodes[1] + j
    }

    /// Place of a node on its lines.
    pub fn place(&self, node: usize) -> [usize; 2] {
        [node / self.nodes[1], node % self.nodes[1]]
    }

    /// Steps between the numbers of neighbours along the two coordinates.
    pub fn strides(&self) -> [usize; 2] {
        [self.nodes[1], 1]
    }

    /// Lower corners `(i, j)` of all cells, row by row.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [p, q] = self.nodes;
        (0..p - 1).flat_map(move |i| (0..q - 1).map(move |j| [i, j]))
    }

    /// Area of a cell in material coordinates [m2].
    pub fn cell_area(&self) -> f64 {
        self.spacing[0] * self.spacing[1]
    }

    /// Four corners of a cell: `(i, j)`, `(i + 1, j)`, `(i, j + 1)`, `(i + 1, j + 1)`.
    pub fn corners(&self, [i, j]: [usize; 2]) -> [usize; 4] {
        [self.node(i, j), self.node(i + 1, j), self.node(i, j + 1), self.node(i + 1, j + 1)]
    }

    /// `D+ f` along coordinate `k` at a node: `(f(next) - f) / d`.
    pub fn forward<T: Value>(&self, f: &[T], node: usize, k: usize, border: Border) -> T {
        let (at, stride) = (self.place(node)[k], self.strides()[k]);
        let from = match (at + 1 < self.nodes[k], border) {
            (true, _) => node,
            (false, Border::Symmetric) => node - stride,
            (false, Border::Paper) => return f[node] * 0.0,
        };
        (f[from + stride] - f[from]) * (1.0 / self.spacing[k])
    }

    /// `D- f` along coordinate `k` at a node: `(f - f(last)) / d`.
    pub fn backward<T: Value>(&self, f: &[T], node: usize, k: usize, border: Border) -> T {
        let (at, stride) = (self.place(node)[k], self.strides()[k]);
        let from = match (at > 0, border) {
            (true, _) => node - stride,
            (false, Border::Symmetric) => node,
            (false, Border::Paper) => return f[node] * 0.0,
        };
        (f[from + stride] - f[from]) * (1.0 / self.spacing[k])
    }

    /// `D+ D- f` along coordinate `k` at a node: the second difference.
    pub fn second<T: Value>(&self, f: &[T], node: usize, k: usize, border: Border) -> T {
        let (at, stride, last) = (self.place(node)[k], self.strides()[k], self.nodes[k] - 1);
        let at = match (at == 0, at == last, border) {
            (false, false, _) => node,
            (_, _, Border::Paper) => return f[node] * 0.0,
            (true, _, Border::Symmetric) => node + stride,
            (false, true, Border::Symmetric) => node - stride,
        };
        (f[at + stride] - f[at] - (f[at] - f[at - stride])) * (1.0 / (self.spacing[k] * self.spacing[k]))
    }

    /// Central difference along coordinate `k` at a node, at borders that of the parabola through the three nearest nodes.
    pub fn central<T: Value>(&self, f: &[T], node: usize, k: usize) -> T {
        let (at, stride, last) = (self.place(node)[k], self.strides()[k], self.nodes[k] - 1);
        let middle = node + stride - at.min(1) * stride - usize::from(at == last) * stride;
        let slope = (f[middle + stride] - f[middle - stride]) * (0.5 / self.spacing[k]);
        let bend = self.second(f, node, k, Border::Symmetric) * self.spacing[k];
        match at {
            0 => slope - bend,
            _ if at == last => slope + bend,
            _ => slope,
        }
    }

    /// Derivatives at a node by central differences; the mixed one is the mean of the cells around.
    pub fn derivatives(&self, r: &[Vector3<f64>], node: usize) -> Derivatives {
        let [i, j] = self.place(node);
        let cells = |at: usize, k: usize| at.saturating_sub(1)..(at + 1).min(self.nodes[k] - 1);
        let (mut mixed, mut count) = (Vector3::zeros(), 0.0);
        for a in cells(i, 0) {
            for b in cells(j, 1) {
                mixed += self.cross(r, self.node(a, b), Border::Paper);
                count += 1.0;
            }
        }
        let second = |k| self.second(r, node, k, Border::Symmetric);
        Derivatives { first: [self.central(r, node, 0), self.central(r, node, 1)], second: [second(0), mixed / count, second(1)] }
    }

    /// `D+1 D+2 f` at a node: the cross difference.
    pub fn cross<T: Value>(&self, f: &[T], node: usize, border: Border) -> T {
        let [mut i, mut j] = self.place(node);
        if i + 1 == self.nodes[0] || j + 1 == self.nodes[1] {
            if border == Border::Paper {
                return f[node] * 0.0;
            }
            (i, j) = (i.min(self.nodes[0] - 2), j.min(self.nodes[1] - 2));
        }
        let [a, b, c, d] = self.corners([i, j]);
        (f[d] - f[c] - (f[b] - f[a])) * (1.0 / self.cell_area())
    }
}

/// What differences are taken of: numbers and vectors.
pub trait Value: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Value for T {}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { nodes: [5, 4], spacing: [0.5, 0.25] };

    fn values(f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        (0..GRID.len()).map(|n| GRID.place(n)).map(|[i, j]| f(0.5 * i as f64, 0.25 * j as f64)).collect()
    }

    #[test]
    fn differences_of_quadratics() {
        let f = values(|x, y| 3.0 + 2.0 * x - y + 1.5 * x * x + 2.0 * x * y - 0.5 * y * y);
        let node = GRID.node(2, 1);
        // At x = 1, y = 1/4: slopes of the chords, which lie half a spacing before or behind.
        let (dx, dy) = (|x: f64| 2.0 + 3.0 * x + 0.5, |y: f64| -1.0 + 2.0 - y);
        for border in [Border::Paper, Border::Symmetric] {
            assert!((GRID.forward(&f, node, 0, border) - dx(1.25)).abs() < 1e-13);
            assert!((GRID.backward(&f, node, 0, border) - dx(0.75)).abs() < 1e-13);
            assert!((GRID.forward(&f, node, 1, border) - dy(0.375)).abs() < 1e-13);
            assert!((GRID.backward(&f, node, 1, border) - dy(0.125)).abs() < 1e-13);
            assert!((GRID.second(&f, node, 0, border) - 3.0).abs() < 1e-12);
            assert!((GRID.second(&f, node, 1, border) + 1.0).abs() < 1e-12);
            assert!((GRID.cross(&f, node, border) - 2.0).abs() < 1e-12);
        }
    }

    /// Central differences of a quadratic are exact, at borders too.
    #[test]
    fn derivatives_of_quadratics() {
        let f = |x: f64, y: f64| Vector3::new(x * x - x * y, 2.0 * x * y + y * y, x - 3.0 * y + y * y);
        let r: Vec<_> = (0..GRID.len()).map(|n| GRID.place(n)).map(|[i, j]| f(0.5 * i as f64, 0.25 * j as f64)).collect();
        for node in 0..GRID.len() {
            let [i, j] = GRID.place(node);
            let (x, y) = (0.5 * i as f64, 0.25 * j as f64);
            let d = GRID.derivatives(&r, node);
            let first = [Vector3::new(2.0 * x - y, 2.0 * y, 1.0), Vector3::new(-x, 2.0 * x + 2.0 * y, 2.0 * y - 3.0)];
            let second = [Vector3::new(2.0, 0.0, 0.0), Vector3::new(-1.0, 2.0, 0.0), Vector3::new(0.0, 2.0, 2.0)];
            assert!((0..2).all(|k| (d.first[k] - first[k]).norm() < 1e-12), "{i} {j}");
            assert!((0..3).all(|k| (d.second[k] - second[k]).norm() < 1e-11), "{i} {j}");
        }
    }

    #[test]
    fn borders_are_zero_or_the_nearest_difference() {
        let f = values(|x, y| x * x + 2.0 * x * y - y * y);
        let corner = GRID.node(4, 3);
        for k in 0..2 {
            assert_eq!(GRID.forward(&f, corner, k, Border::Paper), 0.0);
            assert_eq!(GRID.backward(&f, 0, k, Border::Paper), 0.0);
            assert_ne!(GRID.backward(&f, corner, k, Border::Paper), 0.0);
            assert_eq!(GRID.second(&f, corner, k, Border::Paper), 0.0);
            assert_eq!(GRID.second(&f, 0, k, Border::Paper), 0.0);
            let inner = corner - GRID.strides()[k];
            assert_eq!(GRID.forward(&f, corner, k, Border::Symmetric), GRID.forward(&f, inner, k, Border::Paper));
            assert_eq!(GRID.backward(&f, 0, k, Border::Symmetric), GRID.backward(&f, GRID.strides()[k], k, Border::Paper));
            assert!((GRID.second(&f, corner, k, Border::Symmetric) - [2.0, -2.0][k]).abs() < 1e-12);
            assert!((GRID.second(&f, 0, k, Border::Symmetric) - [2.0, -2.0][k]).abs() < 1e-12);
        }
        assert_eq!(GRID.cross(&f, corner, Border::Paper), 0.0);
        assert!((GRID.cross(&f, corner, Border::Symmetric) - 2.0).abs() < 1e-12);
    }
}

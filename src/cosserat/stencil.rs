//! One-sided differences on a grid as rows of coefficients: those of the paper and their mirror images.
//!
//! Inner first differences look forward or backward along each coordinate, outer ones the other way. What reads a node outside is nothing by the paper's rule and
//! the nearest difference that exists by the symmetric one.

use super::geometry::Derivatives;
use super::grid::{Border, Grid};
use nalgebra::Vector3;

/// Node and coefficient.
pub(super) type Row = Vec<(usize, f64)>;

/// Which way inner differences look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sense {
    Forward,
    Backward,
}

/// That of each coordinate.
pub(super) type Senses = [Sense; 2];

/// The paper's, and its mirror images.
pub(super) const ALL_SENSES: [Senses; 4] = [
    [Sense::Forward, Sense::Forward],
    [Sense::Backward, Sense::Forward],
    [Sense::Forward, Sense::Backward],
    [Sense::Backward, Sense::Backward],
];

/// Differences on a grid by one rule for borders.
#[derive(Clone, Copy)]
pub(super) struct Stencil {
    pub grid: Grid,
    pub border: Border,
}

impl Stencil {
    /// The neighbour of a node along `k`, in the sense or against it.
    pub fn neighbour(&self, node: usize, k: usize, sense: Sense) -> Option<usize> {
        let (at, stride) = (self.grid.place(node)[k], self.grid.strides()[k]);
        match sense {
            Sense::Forward => (at + 1 < self.grid.nodes[k]).then(|| node + stride),
            Sense::Backward => (at > 0).then(|| node - stride),
        }
    }

    /// Whether the first differences along 1 and 2, and the second ones 11, 12, 22, exist at a node.
    pub fn exists(&self, node: usize, sense: Senses) -> ([bool; 2], [bool; 3]) {
        let first = [0, 1].map(|k| self.neighbour(node, k, sense[k]).is_some());
        let both = [0, 1].map(|k| first[k] && self.neighbour(node, k, opposite(sense[k])).is_some());
        (first, [both[0], first[0] && first[1], both[1]])
    }

    /// Inner first difference as a row.
    pub fn first(&self, node: usize, k: usize, sense: Senses) -> Row {
        let d = 1.0 / self.grid.spacing[k];
        let at = match (self.neighbour(node, k, sense[k]), self.border) {
            (Some(next), _) => Some((node, next)),
            (None, Border::Paper) => None,
            (None, Border::Symmetric) => self.neighbour(node, k, opposite(sense[k])).map(|last| (last, node)),
        };
        let Some((from, to)) = at else { return Vec::new() };
        if sense[k] == Sense::Forward { vec![(from, -d), (to, d)] } else { vec![(from, d), (to, -d)] }
    }

    /// Second differences as rows: along 1, mixed, along 2.
    pub fn second(&self, node: usize, ij: usize, sense: Senses) -> Row {
        if ij != 1 {
            let k = ij / 2;
            let (at, stride, last) = (self.grid.place(node)[k], self.grid.strides()[k], self.grid.nodes[k] - 1);
            let middle = match (at == 0, at == last, self.border) {
                (false, false, _) => node,
                (_, _, Border::Paper) => return Vec::new(),
                (true, _, Border::Symmetric) => node + stride,
                (false, true, Border::Symmetric) => node - stride,
            };
            let d = 1.0 / (self.grid.spacing[k] * self.grid.spacing[k]);
            return vec![(middle - stride, d), (middle, -2.0 * d), (middle + stride, d)];
        }
        let [i, j] = self.grid.place(node);
        let low = |at: usize, k: usize| if sense[k] == Sense::Forward { Some(at) } else { at.checked_sub(1) };
        let cell = match (low(i, 0), low(j, 1), self.border) {
            (Some(a), Some(b), _) if a + 1 < self.grid.nodes[0] && b + 1 < self.grid.nodes[1] => [a, b],
            (_, _, Border::Paper) => return Vec::new(),
            (a, b, Border::Symmetric) => [a.unwrap_or(0).min(self.grid.nodes[0] - 2), b.unwrap_or(0).min(self.grid.nodes[1] - 2)],
        };
        let d = 1.0 / self.grid.cell_area();
        self.grid.corners(cell).into_iter().zip([d, -d, -d, d]).collect()
    }

    pub fn derivatives(&self, r: &[Vector3<f64>], node: usize, sense: Senses) -> Derivatives {
        Derivatives {
            first: [0, 1].map(|k| apply(&self.first(node, k, sense), r)),
            second: [0, 1, 2].map(|ij| apply(&self.second(node, ij, sense), r)),
        }
    }

    /// Cells that an outer difference along `k` would have to span, over those that a node has: its force per area is so many times larger.
    pub fn share(&self, node: usize, k: usize) -> f64 {
        let at = self.grid.place(node)[k];
        let side = at == 0 || at == self.grid.nodes[k] - 1;
        if self.border == Border::Symmetric && side { 2.0 } else { 1.0 }
    }
}

pub(super) fn opposite(sense: Sense) -> Sense {
    if sense == Sense::Forward { Sense::Backward } else { Sense::Forward }
}

pub(super) fn apply(row: &Row, r: &[Vector3<f64>]) -> Vector3<f64> {
    row.iter().map(|(at, c)| r[*at] * *c).sum()
}

/// The entries of a row by ascending nodes, each once.
pub(super) fn merged(mut row: Row) -> Row {
    row.sort_by_key(|(at, _)| *at);
    row.dedup_by(|(at, c), (kept, sum)| {
        let same = at == kept;
        if same {
            *sum += *c;
        }
        same
    });
    row
}

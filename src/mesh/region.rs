//! Named parts of a mesh and how to pick them by place. Knows positions and faces, not what a part is used for.

use super::Mesh;
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// A named part of a mesh. Any of its three lists may be empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Region {
    /// Vertex indices, ascending.
    pub vertices: Vec<usize>,
    /// Edges as vertex pairs, lower index first, ascending.
    pub edges: Vec<[usize; 2]>,
    /// Face indices, ascending.
    pub faces: Vec<usize>,
}

impl Region {
    /// Region of the given parts in any order and sense; repetitions are dropped.
    pub fn new(
        vertices: impl IntoIterator<Item = usize>,
        edges: impl IntoIterator<Item = [usize; 2]>,
        faces: impl IntoIterator<Item = usize>,
    ) -> Self {
        let mut region = Region {
            vertices: vertices.into_iter().collect(),
            edges: edges.into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect(),
            faces: faces.into_iter().collect(),
        };
        region.vertices.sort_unstable();
        region.vertices.dedup();
        region.edges.sort_unstable();
        region.edges.dedup();
        region.faces.sort_unstable();
        region.faces.dedup();
        region
    }

    /// The vertices of a path in order and the edges between neighbours; with `closed` also the edge from last to first.
    pub(crate) fn path(vertices: &[usize], closed: bool) -> Self {
        let closing = if closed { vertices.last().zip(vertices.first()).map(|(&a, &b)| [a, b]) } else { None };
        let edges = vertices.windows(2).map(|w| [w[0], w[1]]).chain(closing);
        Region::new(vertices.iter().copied(), edges, [])
    }

    /// All parts of both regions.
    pub(crate) fn union(&self, other: &Region) -> Self {
        Region::new(
            self.vertices.iter().chain(&other.vertices).copied(),
            self.edges.iter().chain(&other.edges).copied(),
            self.faces.iter().chain(&other.faces).copied(),
        )
    }
}

impl Mesh {
    /// The part of the mesh where `condition` holds at a position [m]: vertices that meet it, edges with both ends among
    /// them, faces whose centroid meets it.
    pub fn region_where(&self, mut condition: impl FnMut(Vector3<f64>) -> bool) -> Region {
        let inside: Vec<bool> = self.vertices.iter().map(|&v| condition(v)).collect();
        let mut edges = BTreeSet::new();
        let mut faces = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (face[i], face[(i + 1) % 3]);
                if inside[a] && inside[b] {
                    edges.insert([a.min(b), a.max(b)]);
                }
            }
            if condition(face.iter().map(|&v| self.vertices[v]).sum::<Vector3<f64>>() / 3.0) {
                faces.push(f);
            }
        }
        let vertices = (0..inside.len()).filter(|&v| inside[v]).collect();
        Region { vertices, edges: edges.into_iter().collect(), faces }
    }

    /// The one vertex nearest to `point` [m], the lowest index among equals; no vertex if the mesh has none.
    pub fn region_nearest(&self, point: Vector3<f64>) -> Region {
        let distance = |v: &Vector3<f64>| (v - point).norm_squared();
        let nearest = (0..self.vertices.len()).min_by(|&a, &b| distance(&self.vertices[a]).total_cmp(&distance(&self.vertices[b])));
        Region::new(nearest, [], [])
    }
}

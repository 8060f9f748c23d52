//! Triangle meshes, straight or curved: vertices, faces, midpoints of edges, named regions, fields and the edges between them.
//!
//! A [`Mesh`] is plain data that a generator ([`generate`]) or a reader ([`import`]) fills, [`validate`] accepts and `mesh.h5`
//! stores. [`Topology`] and [`Quality`] are derived from it. This module knows nothing of scenes, materials or unknowns.

pub mod conformal;
mod field;
pub mod generate;
pub mod import;
pub mod midpoints;
mod quality;
mod refine;
mod region;
mod topology;
pub mod validate;

use nalgebra::Vector3;
use std::collections::BTreeMap;

pub use field::{FieldOn, FieldSampler, MeshField};
pub use quality::Quality;
pub use refine::refine;
pub use region::Region;
pub(crate) use topology::Stars;
pub use topology::{EdgeFace, Topology};

/// An oriented triangle mesh of a surface in space, with named regions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions [m].
    pub vertices: Vec<Vector3<f64>>,
    /// Vertex indices of each face; the normal `(v1 - v0) x (v2 - v0)` points to the shell's top.
    pub faces: Vec<[usize; 3]>,
    /// Middles of the edges of curved faces [m], in the order of [`Topology::edges`]; empty for straight, flat faces. With them a
    /// face is the quadratic triangle through its six nodes. They belong to no region.
    pub midpoints: Vec<Vector3<f64>>,
    /// Named parts of the mesh.
    pub regions: BTreeMap<String, Region>,
    /// Numbers that a file brings for each node or face.
    pub fields: BTreeMap<String, MeshField>,
}

impl Mesh {
    /// Positions of all nodes [m]: the vertices, then the midpoints of the edges if faces are curved.
    pub fn nodes(&self) -> Vec<Vector3<f64>> {
        [self.vertices.as_slice(), &self.midpoints].concat()
    }

    /// The six nodes of each curved face, as indices into [`Mesh::nodes`]: the vertices `v0 v1 v2`, then the midpoints of `v0 v1`,
    /// `v1 v2`, `v2 v0` (the order of VTK and Gmsh).
    pub fn six_node_faces(&self) -> Vec<[usize; 6]> {
        let edges = Topology::new(&self.faces).face_edges;
        let node = |edge: usize| self.vertices.len() + edge;
        self.faces.iter().zip(edges).map(|([a, b, c], e)| [*a, *b, *c, node(e[2]), node(e[0]), node(e[1])]).collect()
    }

    /// Drops the vertices that are not to be kept, also from regions and fields. Every vertex of a face must be kept.
    fn keep_vertices(&mut self, keep: impl Fn(usize) -> bool) {
        let mut count = 0;
        let renumbered: Vec<Option<usize>> = (0..self.vertices.len())
            .map(|v| {
                count += usize::from(keep(v));
                keep(v).then(|| count - 1)
            })
            .collect();
        let number = |v: usize| renumbered.get(v).copied().flatten();
        for field in self.node_fields() {
            // Entries beyond those of the vertices are of midpoints, which stay.
            let entries = std::mem::take(&mut field.data);
            let kept = entries.chunks_exact(field.components).enumerate().filter(|(k, _)| renumbered.get(*k).is_none_or(Option::is_some));
            field.data = kept.flat_map(|(_, entry)| entry).copied().collect();
        }
        let mut at = 0;
        self.vertices.retain(|_| {
            at += 1;
            renumbered[at - 1].is_some()
        });
        // Numbers keep their order, so the edges, and with them the midpoints, keep theirs.
        self.faces.iter_mut().flatten().for_each(|v| *v = number(*v).unwrap_or(*v));
        for region in self.regions.values_mut() {
            region.vertices = region.vertices.iter().filter_map(|&v| number(v)).collect();
            region.edges = region.edges.iter().filter_map(|&[a, b]| Some([number(a)?, number(b)?])).collect();
        }
    }

    /// Diagonal of the axis-aligned bounding box [m]: the length that tolerances are relative to. 0 for an empty mesh.
    pub fn diameter(&self) -> f64 {
        let Some(first) = self.vertices.first() else { return 0.0 };
        let (mut low, mut high) = (*first, *first);
        for v in &self.vertices {
            low = low.inf(v);
            high = high.sup(v);
        }
        (high - low).norm()
    }
}

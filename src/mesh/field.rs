//! Named numbers on the nodes or faces of a mesh, as files bring them, and their values inside faces.
//!
//! What they mean, and in which unit, only the file's author knows. They go where their nodes and faces go: see
//! [`Mesh::drop_midpoints`] and [`super::midpoints::place`].

use super::{Mesh, Topology};
use crate::math::quadrature::quadratic_shape;

/// What the entries of a field belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum FieldOn {
    /// One entry per node: the vertices, then the midpoints if faces are curved.
    #[default]
    Nodes,
    /// One entry per face.
    Faces,
}

/// Numbers on all nodes or all faces of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshField {
    /// What its entries belong to.
    pub on: FieldOn,
    /// Numbers per entry, at least 1.
    pub components: usize,
    /// Entries, component fastest, in the unit of the file.
    pub data: Vec<f64>,
}

impl MeshField {
    /// The numbers of one entry, if there is such an entry.
    pub fn entry(&self, index: usize) -> Option<&[f64]> {
        self.data.chunks_exact(self.components.max(1)).nth(index)
    }

    /// Adds the mean of two entries as a further one.
    pub(super) fn push_mean(&mut self, entries: [usize; 2]) {
        let [a, b] = entries.map(|e| e * self.components);
        for c in 0..self.components {
            let mean = 0.5 * self.data[a + c] + 0.5 * self.data[b + c];
            self.data.push(mean);
        }
    }

    /// Adds a copy of an entry as a further one.
    pub(super) fn push_copy(&mut self, entry: usize) {
        let start = entry * self.components;
        self.data.extend_from_within(start..start + self.components);
    }
}

/// Values of one field inside faces; see [`Mesh::field_sampler`].
#[derive(Clone, Debug)]
pub struct FieldSampler {
    field: MeshField,
    entries: Entries,
}

/// The entries of a field that the value inside a face depends on.
#[derive(Clone, Debug)]
enum Entries {
    Face,
    Corners(Vec<[usize; 3]>),
    Nodes(Vec<[usize; 6]>),
}

impl FieldSampler {
    /// The field's numbers at a place of a face, as [`Mesh::field_at`] has them. `None` for a face that does not exist.
    pub fn at(&self, face: usize, place: [f64; 2]) -> Option<Vec<f64>> {
        let [x, y] = place;
        match &self.entries {
            Entries::Face => self.field.entry(face).map(<[f64]>::to_vec),
            Entries::Corners(nodes) => self.sum(nodes.get(face)?, &[1.0 - x - y, x, y]),
            Entries::Nodes(nodes) => self.sum(nodes.get(face)?, &quadratic_shape(place)),
        }
    }

    fn sum(&self, nodes: &[usize], shape: &[f64]) -> Option<Vec<f64>> {
        let mut sum = vec![0.0; self.field.components];
        for (node, weight) in nodes.iter().zip(shape) {
            sum.iter_mut().zip(self.field.entry(*node)?).for_each(|(s, v)| *s += weight * v);
        }
        Some(sum)
    }
}

impl Mesh {
    /// The numbers of a field at a place of a face: `place` are the coordinates on the reference triangle (0, 0), (1, 0), (0, 1) whose
    /// corners are the face's vertices. Linear between the vertices of straight faces, quadratic between the six nodes of curved ones,
    /// constant for a field of the faces. `None` if there is no such field or face.
    ///
    /// For one place; with curved faces it visits the whole mesh. [`Mesh::field_sampler`] serves many places.
    pub fn field_at(&self, name: &str, face: usize, place: [f64; 2]) -> Option<Vec<f64>> {
        self.field_sampler(name)?.at(face, place)
    }

    /// Prepares a field for [`FieldSampler::at`] at many places. `None` if there is no such field.
    pub fn field_sampler(&self, name: &str) -> Option<FieldSampler> {
        let field = self.fields.get(name)?.clone();
        let entries = match field.on {
            FieldOn::Faces => Entries::Face,
            FieldOn::Nodes if self.midpoints.is_empty() => Entries::Corners(self.faces.clone()),
            FieldOn::Nodes => {
                let node = |edge: usize| self.vertices.len() + edge;
                let edges = Topology::new(&self.faces).face_edges;
                Entries::Nodes(
                    self.faces.iter().zip(edges).map(|([a, b, c], e)| [*a, *b, *c, node(e[0]), node(e[1]), node(e[2])]).collect(),
                )
            }
        };
        Some(FieldSampler { field, entries })
    }

    /// Straightens the faces: forgets the midpoints and what fields have there.
    pub fn drop_midpoints(&mut self) {
        self.midpoints.clear();
        let vertices = self.vertices.len();
        self.node_fields().for_each(|field| field.data.truncate(vertices * field.components));
    }

    /// The fields of the nodes.
    pub(super) fn node_fields(&mut self) -> impl Iterator<Item = &mut MeshField> {
        self.fields.values_mut().filter(|field| field.on == FieldOn::Nodes)
    }
}

//! Edges of a triangle mesh and how faces share them. Numbers only; positions play no part.

use std::collections::HashMap;

/// Edges of a manifold triangle mesh.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Vertex pair of each edge, lower index first. This order is the edge's own direction. Edges are numbered in the
    /// order in which faces first name them.
    pub edges: Vec<[usize; 2]>,
    /// Edge indices of each face; edge `i` lies opposite vertex `i`.
    pub face_edges: Vec<[usize; 3]>,
    /// `+1` where the face runs along the edge (`v[i+1] -> v[i+2]`) in the edge's own direction, else `-1`.
    pub face_edge_signs: Vec<[f64; 3]>,
    /// The one or two faces of each edge, lower face first.
    pub edge_faces: Vec<[Option<EdgeFace>; 2]>,
}

/// One face at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeFace {
    /// Face index.
    pub face: usize,
    /// The edge's place in that face: it lies opposite the face's vertex `local`.
    pub local: usize,
}

impl Topology {
    /// Builds the edges of `faces`, each a triple of vertex indices.
    ///
    /// The faces must be those of an oriented manifold, as [`super::Mesh`] readers and generators guarantee: a third face at
    /// an edge is ignored here.
    pub fn new(faces: &[[usize; 3]]) -> Self {
        let mut index: HashMap<[usize; 2], usize> = HashMap::with_capacity(faces.len() * 3 / 2);
        let mut topology = Topology {
            edges: Vec::new(),
            face_edges: Vec::with_capacity(faces.len()),
            face_edge_signs: Vec::with_capacity(faces.len()),
            edge_faces: Vec::new(),
        };
        for (f, face) in faces.iter().enumerate() {
            let (mut of_face, mut signs) = ([0; 3], [1.0; 3]);
            for i in 0..3 {
                let (from, to) = (face[(i + 1) % 3], face[(i + 2) % 3]);
                let pair = [from.min(to), from.max(to)];
                let e = *index.entry(pair).or_insert_with(|| {
                    topology.edges.push(pair);
                    topology.edge_faces.push([None; 2]);
                    topology.edges.len() - 1
                });
                of_face[i] = e;
                signs[i] = if from < to { 1.0 } else { -1.0 };
                if let Some(free) = topology.edge_faces[e].iter_mut().find(|s| s.is_none()) {
                    *free = Some(EdgeFace { face: f, local: i });
                }
            }
            topology.face_edges.push(of_face);
            topology.face_edge_signs.push(signs);
        }
        topology
    }

    /// Whether the edge has one face only.
    pub fn is_boundary(&self, edge: usize) -> bool {
        self.edge_faces[edge][1].is_none()
    }
}

/// The faces at each vertex, packed into one list.
#[derive(Clone, Debug)]
pub(crate) struct Stars {
    start: Vec<usize>,
    faces: Vec<usize>,
}

impl Stars {
    /// Stars of `vertices` vertices; every index in `faces` must be smaller.
    pub fn new(vertices: usize, faces: &[[usize; 3]]) -> Self {
        let mut start = vec![0; vertices + 1];
        faces.iter().flatten().for_each(|&v| start[v + 1] += 1);
        for v in 0..vertices {
            start[v + 1] += start[v];
        }
        let (mut next, mut packed) = (start.clone(), vec![0; 3 * faces.len()]);
        for (f, face) in faces.iter().enumerate() {
            for &v in face {
                packed[next[v]] = f;
                next[v] += 1;
            }
        }
        Stars { start, faces: packed }
    }

    /// Faces at a vertex, ascending.
    pub fn of(&self, vertex: usize) -> &[usize] {
        &self.faces[self.start[vertex]..self.start[vertex + 1]]
    }
}

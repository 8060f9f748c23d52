//! What a mesh is like: counts, sizes, angles and how regular it is. Judges nothing; [`super::validate`] refuses.
//!
//! All measures are those of the straight faces through the vertices, also where faces are curved.

use super::{Mesh, Stars, Topology};
use nalgebra::Vector3;
use std::fmt;

/// An inner vertex counts as irregular where opposite neighbours miss its point reflection by more than this fraction of the
/// mean length of its edges.
const REFLECTION_TOLERANCE: f64 = 0.1;
/// A mesh counts as irregular if more than this fraction of its inner vertices do.
const IRREGULAR_FRACTION: f64 = 0.1;

/// Counts and measures of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of edges with one face.
    pub boundary_edges: usize,
    /// Number of connected parts of the boundary.
    pub boundary_loops: usize,
    /// Number of connected parts of the mesh.
    pub components: usize,
    /// Vertices - edges + faces: 1 for a disc, 0 for an annulus, 2 for a sphere.
    pub euler_characteristic: i64,
    /// Smallest, mean and largest edge length [m].
    pub edge_length: [f64; 3],
    /// Smallest and largest face area [m2].
    pub face_area: [f64; 2],
    /// Sum of all face areas [m2].
    pub total_area: f64,
    /// Smallest and largest angle of a face [degrees].
    pub angle: [f64; 2],
    /// Largest ratio of circumradius to twice the inradius; 1 for an equilateral face.
    pub worst_aspect_ratio: f64,
    /// Fraction of inner vertices that do not look like those of a regular triangular lattice.
    pub irregular_vertices: f64,
}

impl Quality {
    /// Measures a valid mesh; of an empty one every count is zero and the extremes are infinite.
    pub fn of(mesh: &Mesh) -> Self {
        let topology = Topology::new(&mesh.faces);
        let boundary: Vec<[usize; 2]> = (0..topology.edges.len()).filter(|&e| topology.is_boundary(e)).map(|e| topology.edges[e]).collect();
        let mut edge_length = [f64::INFINITY, 0.0, 0.0];
        for [a, b] in &topology.edges {
            let length = (mesh.vertices[*b] - mesh.vertices[*a]).norm();
            edge_length = [edge_length[0].min(length), edge_length[1] + length / topology.edges.len() as f64, edge_length[2].max(length)];
        }
        let mut quality = Quality {
            vertices: mesh.vertices.len(),
            faces: mesh.faces.len(),
            edges: topology.edges.len(),
            boundary_edges: boundary.len(),
            boundary_loops: components(mesh.vertices.len(), &boundary),
            components: components(mesh.vertices.len(), &topology.edges),
            euler_characteristic: mesh.vertices.len() as i64 - topology.edges.len() as i64 + mesh.faces.len() as i64,
            edge_length,
            face_area: [f64::INFINITY, 0.0],
            total_area: 0.0,
            angle: [f64::INFINITY, 0.0],
            worst_aspect_ratio: 0.0,
            irregular_vertices: irregular_vertices(mesh, &boundary),
        };
        for face in &mesh.faces {
            quality.add_face(face.map(|v| mesh.vertices[v]));
        }
        quality
    }

    fn add_face(&mut self, corners: [Vector3<f64>; 3]) {
        let mut lengths = [0.0; 3];
        let mut area = 0.0;
        for i in 0..3 {
            let (u, v) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            let twice_area = u.cross(&v).norm();
            let angle = twice_area.atan2(u.dot(&v)).to_degrees();
            self.angle = [self.angle[0].min(angle), self.angle[1].max(angle)];
            lengths[i] = u.norm();
            area = twice_area / 2.0;
        }
        let [a, b, c] = lengths;
        self.worst_aspect_ratio =
            self.worst_aspect_ratio.max((a / area.sqrt()) * (b / area.sqrt()) * (c / area.sqrt()) * (a + b + c) / area.sqrt() / 16.0);
        self.face_area = [self.face_area[0].min(area), self.face_area[1].max(area)];
        self.total_area += area;
    }

    /// Whether the mesh is far from a regular triangular lattice, as jittered and unstructured meshes are: averaged normals
    /// (`director = "average"`) then give wrong curvatures that refinement does not cure.
    pub fn is_irregular(&self) -> bool {
        self.irregular_vertices > IRREGULAR_FRACTION
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: String| writeln!(f, "{name:<22}{value}");
        row("vertices", self.vertices.to_string())?;
        row("faces", self.faces.to_string())?;
        row("edges", format!("{} ({} on the boundary)", self.edges, self.boundary_edges))?;
        row("components", self.components.to_string())?;
        row("boundary loops", self.boundary_loops.to_string())?;
        row("Euler characteristic", self.euler_characteristic.to_string())?;
        let [low, mean, high] = self.edge_length;
        row("edge length", format!("{low:.4e} to {high:.4e} m, mean {mean:.4e} m"))?;
        row("face area", format!("{:.4e} to {:.4e} m2, total {:.6e} m2", self.face_area[0], self.face_area[1], self.total_area))?;
        row("angles", format!("{:.2} to {:.2} degrees", self.angle[0], self.angle[1]))?;
        row("worst aspect ratio", format!("{:.3}", self.worst_aspect_ratio))?;
        let word = if self.is_irregular() { "irregular" } else { "regular" };
        write!(f, "{:<22}{word}, {:.1} % of inner vertices are irregular", "pattern", 100.0 * self.irregular_vertices)
    }
}

/// Number of connected parts that the edges make of the vertices they touch.
fn components(vertices: usize, edges: &[[usize; 2]]) -> usize {
    fn root(parent: &mut [usize], mut v: usize) -> usize {
        while parent[v] != v {
            parent[v] = parent[parent[v]];
            v = parent[v];
        }
        v
    }
    let mut parent: Vec<usize> = (0..vertices).collect();
    let mut touched = vec![false; vertices];
    for &[a, b] in edges {
        touched[a] = true;
        touched[b] = true;
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b)] = a.min(b);
    }
    (0..vertices).filter(|&v| touched[v] && parent[v] == v).count()
}

/// Fraction of inner vertices that do not have six neighbours in three pairs, each pair opposite in the tangent plane.
fn irregular_vertices(mesh: &Mesh, boundary: &[[usize; 2]]) -> f64 {
    let stars = Stars::new(mesh.vertices.len(), &mesh.faces);
    let mut inner = vec![true; mesh.vertices.len()];
    boundary.iter().flatten().for_each(|&v| inner[v] = false);
    let (mut count, mut irregular) = (0usize, 0usize);
    for v in (0..mesh.vertices.len()).filter(|&v| inner[v] && !stars.of(v).is_empty()) {
        count += 1;
        irregular += usize::from(!is_regular(mesh, v, stars.of(v)));
    }
    irregular as f64 / count.max(1) as f64
}

fn is_regular(mesh: &Mesh, vertex: usize, star: &[usize]) -> bool {
    if star.len() != 6 {
        return false;
    }
    // The two other vertices of each face, in its own sense: chained, they run round the vertex.
    let spokes: Vec<[usize; 2]> = star
        .iter()
        .filter_map(|&f| {
            let face = mesh.faces[f];
            let at = face.iter().position(|&v| v == vertex)?;
            Some([face[(at + 1) % 3], face[(at + 2) % 3]])
        })
        .collect();
    let mut ring = vec![spokes[0][0]];
    while ring.len() < 6 {
        let Some(next) = spokes.iter().find(|s| Some(&s[0]) == ring.last()) else { return false };
        ring.push(next[1]);
    }
    let home = mesh.vertices[vertex];
    let arms: Vec<Vector3<f64>> = ring.iter().map(|&v| mesh.vertices[v] - home).collect();
    let normal = (0..6).map(|k| arms[k].cross(&arms[(k + 1) % 6])).sum::<Vector3<f64>>().normalize();
    let mean = arms.iter().map(Vector3::norm).sum::<f64>() / 6.0;
    (0..3).all(|k| {
        let miss = arms[k] + arms[k + 3];
        (miss - normal * normal.dot(&miss)).norm() <= REFLECTION_TOLERANCE * mean
    })
}

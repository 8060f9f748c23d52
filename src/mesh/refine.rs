//! Uniform refinement: each face becomes four, through the middles of its edges, so that meshes of all degrees of refinement are alike.
//!
//! New vertices lie where [`super::midpoints`] puts the middles of edges, so a round boundary becomes rounder. Regions and fields come along. Nothing
//! is refined in places only.

use super::midpoints::{self, Surface};
use super::{FieldOn, Mesh, Region, Topology, generate};
use crate::error::{Error, Result};
use crate::math::quadrature::quadratic_shape;
use std::collections::HashMap;

/// Parts of a face by its six nodes, in the order of [`Mesh::six_node_faces`]: at the corners, then in the middle.
const PARTS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [4, 5, 3]];
/// Places of these nodes on the reference triangle.
const PLACES: [[f64; 2]; 6] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];

/// Splits every face into four, `times` times: face `f` becomes the faces `4 f` to `4 f + 3`.
///
/// Where the mesh has midpoints, its curved surface stays what it is and the new faces are curved pieces of it. Where it has none, edges are
/// split on `surface` and the new faces are straight. A region gets the four parts of its faces, both halves and the middle of its edges, and
/// the edges between the parts of a face all of whose sides it has. Fields of the nodes are interpolated as [`Mesh::field_at`] does; parts of
/// a face have its numbers. The mesh must be valid ([`super::validate::check`]); what becomes of curved faces must be checked again.
///
/// # Errors
/// More than [`generate::MAX_FACES`] faces, at the key `refine.times`.
pub fn refine(mesh: &mut Mesh, times: usize, surface: Surface) -> Result<()> {
    let faces = mesh.faces.len() as f64 * 4f64.powf(times as f64);
    if faces > generate::MAX_FACES as f64 {
        let message = format!("makes {faces:.3e} faces of {}, more than the {} that are allowed", mesh.faces.len(), generate::MAX_FACES);
        return Err(Error::input_with_help("refine.times", message, "refine less often"));
    }
    let curved = !mesh.midpoints.is_empty();
    for _ in 0..times {
        if curved {
            *mesh = mesh.split_curved();
        } else {
            midpoints::place(mesh, surface);
            *mesh = mesh.divided();
        }
    }
    Ok(())
}

impl Mesh {
    /// Straight faces through all nodes of a mesh with midpoints, with its regions and fields: see [`refine`].
    pub(super) fn divided(&self) -> Mesh {
        let edges = Topology::new(&self.faces).edges;
        let number: HashMap<[usize; 2], usize> = edges.into_iter().enumerate().map(|(e, edge)| (edge, self.vertices.len() + e)).collect();
        let six = self.six_node_faces();
        let faces = six.iter().flat_map(|nodes| PARTS.map(|part| part.map(|node| nodes[node]))).collect();
        let regions = self.regions.iter().map(|(name, region)| (name.clone(), divide(region, &number, &six))).collect();
        let mut fields = self.fields.clone();
        for field in fields.values_mut().filter(|field| field.on == FieldOn::Faces) {
            field.data = field.data.chunks_exact(field.components).flat_map(|entry| [entry; 4].concat()).collect();
        }
        Mesh { vertices: self.nodes(), faces, regions, fields, ..Mesh::default() }
    }

    /// The same surface of curved faces, each of which becomes four.
    fn split_curved(&self) -> Mesh {
        let mut fine = self.divided();
        let topology = Topology::new(&fine.faces);
        let places: Vec<f64> = fine.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        fine.midpoints = self.middles(&topology, 3, &places).chunks_exact(3).map(|p| [p[0], p[1], p[2]].into()).collect();
        for field in fine.node_fields() {
            let middles = self.middles(&topology, field.components, &field.data);
            field.data.extend(middles);
        }
        fine
    }

    /// Values in the middles of the edges of the divided mesh, in the order of its topology, of numbers on the nodes of this one.
    fn middles(&self, divided: &Topology, components: usize, data: &[f64]) -> Vec<f64> {
        let mut middles = vec![0.0; components * divided.edges.len()];
        for (f, nodes) in self.six_node_faces().iter().enumerate() {
            for (edges, part) in divided.face_edges[4 * f..].iter().zip(PARTS) {
                for (i, edge) in edges.iter().enumerate() {
                    let [p, q] = [1, 2].map(|k| PLACES[part[(i + k) % 3]]);
                    let [a, b, c, bc, ca, ab] = quadratic_shape([0, 1].map(|k| 0.5 * (p[k] + q[k])));
                    for component in 0..components {
                        let terms = nodes.iter().zip([a, b, c, ab, bc, ca]);
                        middles[components * edge + component] =
                            terms.map(|(node, weight)| weight * data[components * node + component]).sum();
                    }
                }
            }
        }
        middles
    }
}

/// The region of the divided mesh. `number`: the vertex in the middle of an edge; `six`: nodes of the faces.
fn divide(region: &Region, number: &HashMap<[usize; 2], usize>, six: &[[usize; 6]]) -> Region {
    let halves = || region.edges.iter().filter_map(|edge| Some((*edge, *number.get(edge)?)));
    let has = |a: usize, b: usize| region.edges.binary_search(&[a.min(b), a.max(b)]).is_ok();
    let whole = |[a, b, c, ..]: &&[usize; 6]| has(*a, *b) && has(*b, *c) && has(*c, *a);
    let inside = region.faces.iter().map(|&f| &six[f]).filter(whole).flat_map(|&[_, _, _, ab, bc, ca]| [[ab, bc], [bc, ca], [ca, ab]]);
    Region::new(
        region.vertices.iter().copied().chain(halves().map(|(_, middle)| middle)),
        halves().flat_map(|([a, b], middle)| [[a, middle], [b, middle]]).chain(inside),
        region.faces.iter().flat_map(|f| 4 * f..4 * f + 4),
    )
}

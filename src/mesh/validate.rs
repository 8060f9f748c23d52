//! What a mesh must be before anything computes on it: a finite, oriented manifold of faces with area.
//!
//! Files can hold anything, so [`check`] refuses what has no meaning and names the faces; what can be mended without a guess
//! it mends and says so. It does not judge quality: slivers are the user's own choice ([`super::Quality`] shows them).

use super::{FieldOn, Mesh, Stars, Topology};
use crate::error::{Error, Result};
use nalgebra::Vector3;

/// Faces named in a message; the rest are counted.
const NAMED: usize = 5;
/// Largest coordinate and smallest face size [m] such that their fourth powers (squares of areas) neither overflow nor vanish.
const LARGEST: f64 = 1e75;
const SMALLEST: f64 = 1e-75;
/// Least ratio of a face's area to the square of its longest edge. A sliver with an angle of 0.01 degrees has 1e-4.
const LEAST_AREA: f64 = 1e-12;

/// Farthest distance of a midpoint from the middle of its straight edge, by that edge's length; a third of a turn makes 0.29.
const FARTHEST: f64 = 0.4;
/// Where a curved face must not fold: its nodes and the element's points of integration.
const SAMPLES: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [0.5, 0.0],
    [0.5, 0.5],
    [0.0, 0.5],
    [1.0 / 6.0, 1.0 / 6.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
];

/// Refuses a mesh that is no oriented manifold; drops unused vertices. Returns warnings.
///
/// `place`: file or key that the mesh comes from, for messages. Errors: no faces; vertex indices out of range; coordinates
/// that are not finite, too large or too small; faces with a repeated vertex or without area; two faces on the same vertices;
/// edges of more than two faces; neighbours of opposite orientation; midpoints that are not one per edge, not
/// finite or far off their edges; curved faces that fold; fields of the wrong length or not finite on a face. Warnings: vertices that no face uses, edges of regions
/// that are no edges of faces (both are dropped), parts that touch in one vertex only.
pub fn check(mesh: &mut Mesh, place: &str) -> Result<Vec<String>> {
    if mesh.faces.is_empty() {
        return Err(Error::input(place, "the mesh has no faces"));
    }
    let refuse = |faces: Vec<usize>, what: &str, help: &str| {
        if faces.is_empty() { Ok(()) } else { Err(Error::input_with_help(place, format!("{what}: {}", name(mesh, &faces)), help)) }
    };
    let select = |bad: &dyn Fn(&[usize; 3]) -> bool| (0..mesh.faces.len()).filter(|&f| bad(&mesh.faces[f])).collect::<Vec<_>>();

    let range = select(&|face| face.iter().any(|&v| v >= mesh.vertices.len()));
    refuse(range, &format!("faces name vertices beyond the {} there are", mesh.vertices.len()), "the mesh is damaged; write it anew")?;
    let wild = select(&|face| face.iter().any(|&v| mesh.vertices[v].iter().any(|x| !x.is_finite())));
    refuse(wild, "coordinates are not finite", "every coordinate must be a number")?;
    let huge = select(&|face| face.iter().any(|&v| mesh.vertices[v].amax() > LARGEST));
    refuse(huge, &format!("coordinates are larger than {LARGEST:e} m"), "check the scale")?;
    let repeated = select(&|face| face[0] == face[1] || face[1] == face[2] || face[2] == face[0]);
    refuse(repeated, "faces have a repeated vertex", "remove these faces")?;
    let tiny = select(&|face| {
        let longest = longest_edge(mesh, face);
        longest > 0.0 && longest < SMALLEST
    });
    refuse(tiny, &format!("faces are smaller than {SMALLEST:e} m"), "check the scale")?;
    let flat = select(&|face| !has_area(mesh, face));
    refuse(flat, "faces have no area", "remove these faces or move their vertices apart")?;
    refuse(duplicates(mesh), "faces lie on the same vertices as another face", "keep one face of each set")?;

    let uses = EdgeUse::of(mesh);
    refuse(uses.crowded(), "edges belong to more than two faces", "the shell must be a manifold; split it or remove faces")?;
    refuse(uses.disagreeing(), "neighbouring faces have opposite orientation", "orient all faces alike")?;

    let expected = Topology::new(&mesh.faces).edges.len();
    if !mesh.midpoints.is_empty() && mesh.midpoints.len() != expected {
        let message = format!("the mesh has {} midpoints for {expected} edges", mesh.midpoints.len());
        return Err(Error::input_with_help(place, message, "give one midpoint to each edge, or none"));
    }
    check_midpoints(mesh, &refuse)?;
    check_fields(mesh, place, &refuse)?;

    let mut warnings = Vec::new();
    warnings.extend(drop_foreign_edges(mesh, &uses, place));
    warnings.extend(drop_unused_vertices(mesh, place));
    warnings.extend(touching_parts(mesh, place));
    Ok(warnings)
}

/// Refuses faces (what is wrong, what helps), unless there are none.
type Refuse<'a> = dyn Fn(Vec<usize>, &str, &str) -> Result<()> + 'a;

/// Refuses curved faces whose midpoints make no sense.
fn check_midpoints(mesh: &Mesh, refuse: &Refuse) -> Result<()> {
    if mesh.midpoints.is_empty() {
        return Ok(());
    }
    let nodes = mesh.nodes();
    let faces: Vec<[Vector3<f64>; 6]> = mesh.six_node_faces().iter().map(|face| face.map(|node| nodes[node])).collect();
    let select = |bad: &dyn Fn(&[Vector3<f64>; 6]) -> bool| (0..faces.len()).filter(|&f| bad(&faces[f])).collect::<Vec<_>>();
    let wild = select(&|face| face[3..].iter().any(|m| m.iter().any(|x| !x.is_finite())));
    refuse(wild, "midpoints of edges are not finite", "every coordinate must be a number")?;
    let far = select(&|face| (0..3).any(|i| is_far([face[i], face[(i + 1) % 3]], face[3 + i])));
    let off = format!("midpoints lie farther than {FARTHEST} edge lengths from the middle of their edges");
    refuse(far, &off, "check the order of the nodes, or refine the mesh there")?;
    refuse(select(&is_folded), "curved faces fold over", "move midpoints nearer to the middle of their edges, or refine the mesh there")
}

/// Refuses fields that lack entries or have some on faces, or on their nodes, that are no numbers.
fn check_fields(mesh: &Mesh, place: &str, refuse: &Refuse) -> Result<()> {
    if mesh.fields.is_empty() {
        return Ok(());
    }
    let nodes: Vec<Vec<usize>> = if mesh.midpoints.is_empty() {
        mesh.faces.iter().map(|face| face.to_vec()).collect()
    } else {
        mesh.six_node_faces().iter().map(|face| face.to_vec()).collect()
    };
    for (name, field) in &mesh.fields {
        let (entries, what) = match field.on {
            FieldOn::Nodes => (mesh.vertices.len() + mesh.midpoints.len(), "nodes"),
            FieldOn::Faces => (mesh.faces.len(), "faces"),
        };
        let components = field.components;
        if components == 0 || field.data.len() != entries * components {
            let message = format!("field `{name}` has {} numbers for {entries} {what} of {components} components", field.data.len());
            return Err(Error::input(place, message));
        }
        let finite: Vec<bool> = field.data.chunks_exact(components).map(|entry| entry.iter().all(|x| x.is_finite())).collect();
        let wild = (0..mesh.faces.len()).filter(|&f| match field.on {
            FieldOn::Nodes => nodes[f].iter().any(|&node| !finite[node]),
            FieldOn::Faces => !finite[f],
        });
        let help = format!("give it a number on each of the {what} that faces need, or leave it out of the file");
        refuse(wild.collect(), &format!("field `{name}` is not finite on {what} of"), &help)?;
    }
    Ok(())
}

/// `face 3 (vertices 1 2 5), face 7 (...) and 12 more`.
fn name(mesh: &Mesh, faces: &[usize]) -> String {
    let named = faces.iter().take(NAMED).map(|&f| {
        let [a, b, c] = mesh.faces[f];
        format!("face {f} (vertices {a} {b} {c})")
    });
    let mut text = named.collect::<Vec<_>>().join(", ");
    if faces.len() > NAMED {
        text += &format!(" and {} more", faces.len() - NAMED);
    }
    text
}

fn longest_edge(mesh: &Mesh, face: &[usize; 3]) -> f64 {
    (0..3).map(|i| (mesh.vertices[face[(i + 1) % 3]] - mesh.vertices[face[i]]).norm()).fold(0.0, f64::max)
}

fn has_area(mesh: &Mesh, face: &[usize; 3]) -> bool {
    let longest = longest_edge(mesh, face);
    let [a, b, c] = face.map(|v| mesh.vertices[v]);
    longest > 0.0 && ((b - a) / longest).cross(&((c - a) / longest)).norm() > 2.0 * LEAST_AREA
}

fn is_far(ends: [Vector3<f64>; 2], midpoint: Vector3<f64>) -> bool {
    (midpoint - ends[0].lerp(&ends[1], 0.5)).norm() > FARTHEST * (ends[1] - ends[0]).norm()
}

/// Whether the face turns its back to the straight face's normal, or has no area, at a node or a point of integration.
fn is_folded(face: &[Vector3<f64>; 6]) -> bool {
    let sides = [face[1] - face[0], face[2] - face[0]];
    let unit = sides[0].norm().max(sides[1].norm());
    let normal = (sides[0] / unit).cross(&(sides[1] / unit)).normalize();
    SAMPLES.iter().any(|&at| {
        let [u, v] = tangents(face, at).map(|t| t / unit);
        !(u.cross(&v).dot(&normal) > LEAST_AREA)
    })
}

/// Derivatives of a quadratic face's place, nodes in the order of [`Mesh::six_node_faces`], by its coordinates `(xi, eta)`.
fn tangents(face: &[Vector3<f64>; 6], [xi, eta]: [f64; 2]) -> [Vector3<f64>; 2] {
    let zeta = 1.0 - xi - eta;
    let [a, b, c, ab, bc, ca] = face;
    [
        b * (4.0 * xi - 1.0) - a * (4.0 * zeta - 1.0) + ab * (4.0 * (zeta - xi)) + (bc - ca) * (4.0 * eta),
        c * (4.0 * eta - 1.0) - a * (4.0 * zeta - 1.0) + ca * (4.0 * (zeta - eta)) + (bc - ab) * (4.0 * xi),
    ]
}

/// Faces on the same three vertices as another, ascending.
fn duplicates(mesh: &Mesh) -> Vec<usize> {
    let mut keys: Vec<([usize; 3], usize)> = mesh.faces.iter().enumerate().map(|(f, &face)| (sorted(face), f)).collect();
    keys.sort_unstable();
    ascending(keys.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1).flatten().map(|&(_, f)| f))
}

fn sorted(mut face: [usize; 3]) -> [usize; 3] {
    face.sort_unstable();
    face
}

fn ascending(faces: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut faces: Vec<usize> = faces.collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// Every side of every face, sorted by edge.
struct EdgeUse(Vec<Side>);

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Lower vertex first.
    edge: [usize; 2],
    face: usize,
    /// Whether the face runs from the lower to the higher vertex.
    forward: bool,
}

impl EdgeUse {
    fn of(mesh: &Mesh) -> Self {
        let sides = mesh.faces.iter().enumerate().flat_map(|(face, corners)| {
            (0..3).map(move |i| {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                Side { edge: [a.min(b), a.max(b)], face, forward: a < b }
            })
        });
        let mut sides: Vec<Side> = sides.collect();
        sides.sort_unstable();
        EdgeUse(sides)
    }

    fn edges(&self) -> impl Iterator<Item = &[Side]> {
        self.0.chunk_by(|a, b| a.edge == b.edge)
    }

    /// Faces at edges of more than two faces.
    fn crowded(&self) -> Vec<usize> {
        ascending(self.edges().filter(|sides| sides.len() > 2).flatten().map(|s| s.face))
    }

    /// Faces that run along a shared edge in the same direction.
    fn disagreeing(&self) -> Vec<usize> {
        ascending(self.edges().filter(|sides| sides.len() == 2 && sides[0].forward == sides[1].forward).flatten().map(|s| s.face))
    }

    fn contains(&self, edge: &[usize; 2]) -> bool {
        self.0.binary_search_by(|side| side.edge.cmp(edge)).is_ok()
    }
}

fn drop_foreign_edges(mesh: &mut Mesh, uses: &EdgeUse, place: &str) -> Vec<String> {
    let mut warnings = Vec::new();
    for (name, region) in &mut mesh.regions {
        let before = region.edges.len();
        region.edges.retain(|edge| uses.contains(edge));
        let dropped = before - region.edges.len();
        if dropped > 0 {
            warnings.push(format!("{place}: {dropped} edges of region `{name}` belong to no face and are dropped"));
        }
    }
    warnings
}

/// Drops vertices until every one has a face.
fn drop_unused_vertices(mesh: &mut Mesh, place: &str) -> Option<String> {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.faces.iter().flatten().for_each(|&v| used[v] = true);
    let unused = used.iter().filter(|&&u| !u).count();
    if unused == 0 {
        return None;
    }
    mesh.keep_vertices(|v| used[v]);
    Some(format!("{place}: {unused} vertices belong to no face and are dropped"))
}

/// Warns of vertices whose faces do not all hang together by edges.
fn touching_parts(mesh: &Mesh, place: &str) -> Option<String> {
    let stars = Stars::new(mesh.vertices.len(), &mesh.faces);
    let bow_ties: Vec<usize> = (0..mesh.vertices.len()).filter(|&v| fans(mesh, v, stars.of(v)) > 1).collect();
    let first = bow_ties.first()?;
    let p = mesh.vertices[*first];
    Some(format!(
        "{place}: at {} vertices faces touch that share no edge there (vertex {first} at ({}, {}, {})); such a joint turns freely",
        bow_ties.len(),
        p.x,
        p.y,
        p.z
    ))
}

/// Number of groups of faces at a vertex that hang together by edges at it: the ends of open fans, two each, or closed rings.
pub(super) fn fans(mesh: &Mesh, vertex: usize, star: &[usize]) -> usize {
    let mut spokes: Vec<[usize; 2]> = star
        .iter()
        .filter_map(|&f| {
            let face = mesh.faces[f];
            let at = face.iter().position(|&v| v == vertex)?;
            Some([face[(at + 1) % 3], face[(at + 2) % 3]])
        })
        .collect();
    let mut count = 0;
    while let Some([mut tail, mut head]) = spokes.pop() {
        count += 1;
        while let Some(k) = spokes.iter().position(|s| s[0] == head || s[1] == tail) {
            let [from, to] = spokes.swap_remove(k);
            if from == head { head = to } else { tail = from }
        }
    }
    count
}

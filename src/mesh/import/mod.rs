//! Mesh files: OBJ, PLY, STL, VTK (legacy, VTU, VTP) and Gmsh; outlines of flat shells: CSV.
//!
//! [`read`] chooses the reader by the file's extension. Readers keep the order of the file's vertices and faces, turn its
//! lengths into metres, its named groups into regions, the midside nodes of quadratic triangles into midpoints and its data arrays
//! into fields. A damaged file gives an error that names file and place: no reader
//! panics, and none reserves memory for a count that the file is too short to hold. Whether the faces make a shell is the
//! business of [`super::validate`].

mod field;
mod gmsh;
mod input;
mod obj;
mod outline;
mod ply;
mod stl;
mod vtk;
mod vtk_legacy;
mod vtk_xml;

pub use outline::read_outline;

use super::{Mesh, Region, Topology};
use crate::error::{Error, Result};
use nalgebra::Vector3;
use std::cell::Cell;
use std::panic;
use std::path::Path;
use std::sync::Once;

/// Distance between the midpoints that two faces give to their shared edge, by its length, up to which they agree.
const SAME_MIDPOINT: f64 = 1e-9;

/// Reads a mesh file and returns the mesh with warnings about what was left out or split.
///
/// `scale` turns the file's lengths into metres, > 0. Quadratic triangles (Gmsh, VTK) fill [`Mesh::midpoints`]; their midside nodes
/// are no vertices. Data arrays of VTK, PLY and Gmsh fill [`Mesh::fields`]. Errors: a file that cannot be read, of an unknown kind, damaged, with cells other than triangles and polygons, with
/// linear and quadratic elements, with midside nodes that do not fit together, with data arrays that do not fit to its points or cells, or with coordinates that are not finite.
pub fn read(path: &Path, scale: f64) -> Result<(Mesh, Vec<String>)> {
    let place = path.display().to_string();
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Error::input(place, format!("scale {scale} is not usable: expected a positive number")));
    }
    let metadata = std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
    if !metadata.is_file() {
        return Err(Error::input(place, "not a regular file"));
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    let reader = match extension.as_str() {
        "obj" => obj::read,
        "ply" => ply::read,
        "stl" => stl::read,
        "vtk" => vtk_legacy::read,
        "vtu" | "vtp" => vtk_xml::read,
        "msh" => gmsh::read,
        _ => {
            let message = format!("unknown kind of mesh file `.{extension}`: expected .obj, .ply, .stl, .vtu, .vtp, .vtk or .msh");
            return Err(Error::input(place, message));
        }
    };
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    if bytes.is_empty() {
        return Err(Error::input(place, "the file is empty"));
    }
    let soup = reader(&bytes).map_err(|fault| match fault.at {
        Some(at) => Error::input(format!("{place}: {at}"), printable(&fault.message)),
        None => Error::input(&place, printable(&fault.message)),
    })?;
    soup.finish(&place, scale)
}

/// What is wrong with a file, and where in it (`line 12`, `byte 400`), if known.
#[derive(Debug)]
struct Fault {
    at: Option<String>,
    message: String,
}

impl Fault {
    fn new(message: impl Into<String>) -> Self {
        Fault { at: None, message: message.into() }
    }

    fn at_line(line: usize, message: impl Into<String>) -> Self {
        Fault { at: Some(format!("line {line}")), message: message.into() }
    }
}

/// A message that may quote a damaged file, fit for a terminal: no control characters or bytes that are no text, and not endless.
fn printable(message: &str) -> String {
    let plain = |c: char| if c.is_control() || c == char::REPLACEMENT_CHARACTER { '?' } else { c };
    message.chars().map(plain).take(300).collect()
}

/// What a file holds, before it is checked.
#[derive(Default)]
struct Soup {
    /// Vertices hold every node of the file, midpoints too.
    mesh: Mesh,
    /// Nodes halfway along `v0 v1`, `v1 v2`, `v2 v0` of each face; empty if faces are straight.
    middles: Vec<[usize; 3]>,
    /// Whether elements are quadratic, and the number of the first, which said so.
    order: Option<(bool, u64)>,
    /// Cells of the file so far, those that are no faces included, and the number of the cell that each face was cut from.
    cells: usize,
    cell_of_face: Vec<usize>,
    fields: field::RawFields,
    /// Polygons of more than three corners, cut into triangles.
    split: usize,
    warnings: Vec<String>,
}

impl Soup {
    fn vertex(&mut self, position: [f64; 3]) {
        self.mesh.vertices.push(Vector3::from(position));
    }

    /// Adds a polygon as a fan of triangles about its first corner.
    fn polygon(&mut self, corners: &[usize]) -> Result<(), Fault> {
        let [first, rest @ ..] = corners else { return Err(Fault::new("a face has no vertices")) };
        if rest.len() < 2 {
            return Err(Fault::new(format!("face {} has {} vertices: expected at least 3", self.mesh.faces.len(), corners.len())));
        }
        self.split += usize::from(rest.len() > 2);
        self.mesh.faces.extend(rest.windows(2).map(|w| [*first, w[0], w[1]]));
        self.cell_of_face.resize(self.mesh.faces.len(), self.cells);
        self.cells += 1;
        Ok(())
    }

    /// Adds a triangle; a curved one with the nodes halfway along `v0 v1`, `v1 v2`, `v2 v0`.
    fn triangle(&mut self, corners: [usize; 3], middles: Option<[usize; 3]>) {
        self.mesh.faces.push(corners);
        self.middles.extend(middles);
        self.cell_of_face.push(self.cells);
        self.cells += 1;
    }

    /// Refuses an element (`what` it is called, its number) of another order than those before.
    fn check_order(&mut self, quadratic: bool, what: &str, number: u64) -> Result<(), Fault> {
        let (before, first) = *self.order.get_or_insert((quadratic, number));
        if before == quadratic {
            return Ok(());
        }
        let order = |quadratic| if quadratic { "quadratic" } else { "linear" };
        let message = format!("{what} {number} is {}, but {what} {first} is {}", order(quadratic), order(before));
        Err(Fault::new(format!("{message}: expected one order throughout")))
    }

    /// Turns the nodes in the middle of edges into midpoints. Every index must be in range.
    fn take_midpoints(&mut self, place: &str) -> Result<()> {
        let mesh = &mut self.mesh;
        if self.middles.is_empty() {
            return Ok(());
        }
        let mut use_of = vec![Use::None; mesh.vertices.len()];
        self.middles.iter().flatten().for_each(|&v| use_of[v] = Use::Middle);
        mesh.faces.iter().flatten().for_each(|&v| {
            if use_of[v] == Use::Middle {
                use_of[v] = Use::Both
            }
        });
        let topology = Topology::new(&mesh.faces);
        let mut found: Vec<Option<(usize, usize)>> = vec![None; topology.edges.len()];
        for (f, middles) in self.middles.iter().enumerate() {
            for (i, &node) in middles.iter().enumerate() {
                if use_of[node] == Use::Both {
                    let message = format!("face {f} has node {node}, counted from 0, in the middle of an edge, but it is a corner too");
                    return Err(Error::input_with_help(place, message, "faces must meet along whole edges"));
                }
                // The edge after corner `i` lies opposite corner `i + 2`.
                let edge = topology.face_edges[f][(i + 2) % 3];
                let (first, other) = *found[edge].get_or_insert((f, node));
                let [a, b] = topology.edges[edge];
                let gap = (mesh.vertices[node] - mesh.vertices[other]).norm();
                if gap > SAME_MIDPOINT * (mesh.vertices[a] - mesh.vertices[b]).norm() {
                    let message = format!(
                        "faces {first} and {f} disagree about the midpoint of the edge {a} {b}: nodes {other} and {node}, counted from 0"
                    );
                    return Err(Error::input_with_help(place, message, "merge the nodes of shared edges"));
                }
            }
        }
        for field in mesh.node_fields() {
            found.iter().flatten().for_each(|&(_, node)| field.push_copy(node));
        }
        mesh.midpoints = found.iter().flatten().map(|&(_, node)| mesh.vertices[node]).collect();
        mesh.keep_vertices(|v| use_of[v] != Use::Middle);
        Ok(())
    }

    /// Adds faces, and their vertices and edges, to the region of the given name.
    fn group_faces(&mut self, name: &str, faces: impl IntoIterator<Item = usize> + Clone) {
        let corners = || faces.clone().into_iter().filter_map(|f| self.mesh.faces.get(f));
        let edges = corners().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let region = Region::new(corners().flatten().copied(), edges, faces.clone());
        self.group(name, &region);
    }

    /// Adds parts to the region of the given name.
    fn group(&mut self, name: &str, parts: &Region) {
        let region = self.mesh.regions.entry(name.to_string()).or_default();
        *region = region.union(parts);
    }

    fn finish(mut self, place: &str, scale: f64) -> Result<(Mesh, Vec<String>)> {
        let count = self.mesh.vertices.len();
        if let Some((f, face)) = self.mesh.faces.iter().enumerate().find(|(_, face)| face.iter().any(|&v| v >= count)) {
            let message = format!("face {f} (vertices {} {} {}) names a vertex beyond the {count} there are", face[0], face[1], face[2]);
            return Err(Error::input(place, message));
        }
        if let Some((v, p)) = self.mesh.vertices.iter().enumerate().find(|(_, p)| p.iter().any(|x| !x.is_finite())) {
            return Err(Error::input(place, format!("vertex {v} is at ({}, {}, {}): coordinates must be finite", p.x, p.y, p.z)));
        }
        if self.mesh.faces.is_empty() {
            return Err(Error::input(place, "the file holds no faces"));
        }
        self.mesh.vertices.iter_mut().for_each(|p| *p *= scale);
        self.take_fields().map_err(|fault| Error::input(place, fault.message))?;
        self.take_midpoints(place)?;
        if self.split > 0 {
            self.warnings.push(format!("{} polygons of more than three corners are cut into triangles", self.split));
        }
        let warnings = self.warnings.into_iter().map(|w| format!("{place}: {w}")).collect();
        Ok((self.mesh, warnings))
    }
}

/// What a node of a file is for.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    None,
    Middle,
    /// Both the middle of an edge and a corner of a face.
    Both,
}

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a foreign reader that may panic on damaged input; a panic becomes a fault and prints nothing.
fn guarded<T>(read: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                usual(info);
            }
        }));
    });
    QUIET.set(true);
    // The closure owns what it builds, so nothing half-made is seen after a panic.
    let result = panic::catch_unwind(panic::AssertUnwindSafe(read));
    QUIET.set(false);
    result.unwrap_or_else(|_| Err(Fault::new("the file is damaged")))
}

//! Mesh files: OBJ, PLY, STL, VTK (legacy, VTU, VTP) and Gmsh.
//!
//! [`read`] chooses the reader by the file's extension. Readers keep the order of the file's vertices and faces, turn its
//! lengths into metres and its named groups into regions. A damaged file gives an error that names file and place: no reader
//! panics, and none reserves memory for a count that the file is too short to hold. Whether the faces make a shell is the
//! business of [`super::validate`].

mod gmsh;
mod obj;
mod ply;
mod stl;
mod vtk;

use super::{Mesh, Region};
use crate::error::{Error, Result};
use nalgebra::Vector3;
use std::cell::Cell;
use std::panic;
use std::path::Path;
use std::sync::Once;

/// Reads a mesh file and returns the mesh with warnings about what was left out or split.
///
/// `scale` turns the file's lengths into metres, > 0. Errors: a file that cannot be read, of an unknown kind, damaged, with
/// cells other than triangles and polygons, or with coordinates that are not finite.
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
        "vtk" => vtk::read_legacy,
        "vtu" | "vtp" => vtk::read_xml,
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
        Some(at) => Error::input(format!("{place}: {at}"), fault.message),
        None => Error::input(&place, fault.message),
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

/// What a file holds, before it is checked.
#[derive(Default)]
struct Soup {
    mesh: Mesh,
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
        if self.split > 0 {
            self.warnings.push(format!("{} polygons of more than three corners are cut into triangles", self.split));
        }
        let warnings = self.warnings.into_iter().map(|w| format!("{place}: {w}")).collect();
        Ok((self.mesh, warnings))
    }
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

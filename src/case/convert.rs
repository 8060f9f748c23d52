//! Meshes and snapshots as archives and back, bit by bit.
//!
//! Names given by users (regions, fields) become HDF5 names; the three things that HDF5 would misread in them are escaped.

use super::{Archive, Array, Kind};
use crate::error::Result;
use crate::mesh::{FieldOn, Mesh, MeshField, Region, Topology};
use crate::snapshot::{Association, Field, Snapshot};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;

/// The mesh as contents of `mesh.h5`: `vertices`, `faces`, `regions/NAME/{vertices,edges,faces}`, `fields/NAME` (with the attribute
/// `association`) and, if faces are curved, `midpoints`.
///
/// `quality`: named numbers to store beside it.
pub fn mesh_to_archive(mesh: &Mesh, quality: BTreeMap<String, f64>, inputs: &str) -> Archive {
    let mut archive = Archive::new(Kind::Mesh, inputs);
    archive.numbers = quality;
    put_mesh(&mut archive, mesh);
    archive
}

/// Adds a mesh's arrays to an archive.
pub fn put_mesh(archive: &mut Archive, mesh: &Mesh) {
    let places = |points: &[Vector3<f64>]| Array::rows(points.iter().flat_map(|p| [p.x, p.y, p.z]).collect(), 3).with("unit", "m");
    archive.arrays.insert("vertices".into(), places(&mesh.vertices));
    if !mesh.midpoints.is_empty() {
        archive.arrays.insert("midpoints".into(), places(&mesh.midpoints));
    }
    archive.arrays.insert("faces".into(), Array::indices(mesh.faces.iter().flatten().copied(), 3));
    for (name, region) in &mesh.regions {
        let at = format!("regions/{}", escape(name));
        let mut put = |part: &str, array| archive.arrays.insert(format!("{at}/{part}"), array);
        put("vertices", Array::indices(region.vertices.iter().copied(), 1));
        put("edges", Array::indices(region.edges.iter().flatten().copied(), 2));
        put("faces", Array::indices(region.faces.iter().copied(), 1));
    }
    for (name, field) in &mesh.fields {
        let array = Array::rows(field.data.clone(), field.components).with("association", field_place(field.on));
        archive.arrays.insert(format!("fields/{}", escape(name)), array);
    }
}

/// The mesh in an archive read from `path`. Error: [`crate::Error::Stale`] if an array is missing or an index is out of range.
pub fn mesh_from_archive(archive: &Archive, path: &Path) -> Result<Mesh> {
    mesh_in(archive).map_err(|e| archive.kind.stale(path, e))
}

fn mesh_in(archive: &Archive) -> Result<Mesh, String> {
    let places = |name: &str| -> Result<Vec<_>, String> {
        Ok(real(archive, name, 3)?.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect())
    };
    let vertices = places("vertices")?;
    let faces = whole::<3>(archive, "faces", vertices.len())?;
    let midpoints = if archive.arrays.contains_key("midpoints") { places("midpoints")? } else { Vec::new() };
    let edges = if midpoints.is_empty() { 0 } else { Topology::new(&faces).edges.len() };
    if midpoints.len() != edges {
        return Err(format!("array `midpoints` has {} rows for {edges} edges", midpoints.len()));
    }
    let mut regions = BTreeMap::new();
    for name in archive.arrays.keys().filter_map(|k| k.strip_prefix("regions/")?.strip_suffix("/vertices")) {
        let at = |part: &str| format!("regions/{name}/{part}");
        let region = Region {
            vertices: whole::<1>(archive, &at("vertices"), vertices.len())?.into_flattened(),
            edges: whole::<2>(archive, &at("edges"), vertices.len())?,
            faces: whole::<1>(archive, &at("faces"), faces.len())?.into_flattened(),
        };
        regions.insert(unescape(name), region);
    }
    let mut fields = BTreeMap::new();
    for (key, array) in &archive.arrays {
        let Some(name) = key.strip_prefix("fields/") else { continue };
        let place = array.attributes.get("association").map_or("", String::as_str);
        let on = [FieldOn::Nodes, FieldOn::Faces].into_iter().find(|on| field_place(*on) == place);
        let on = on.ok_or_else(|| format!("array `{key}` belongs to nothing known"))?;
        let entries = if on == FieldOn::Nodes { vertices.len() + midpoints.len() } else { faces.len() };
        let &[rows, components] = &array.shape[..] else { return Err(format!("array `{key}` is not of rank 2")) };
        if rows != entries {
            return Err(format!("array `{key}` has {rows} rows for {entries} entries"));
        }
        let data = real(archive, key, components)?.to_vec();
        fields.insert(unescape(name), MeshField { on, components, data });
    }
    Ok(Mesh { vertices, faces, midpoints, regions, fields })
}

/// The snapshot as contents of a checkpoint: `fields/NAME` in the order of the attribute `fields`, and `numbers`.
///
/// `keep`: whether the checkpoint stays when newer ones come.
pub fn snapshot_to_archive(snapshot: &Snapshot, keep: bool, inputs: &str) -> Archive {
    let mut archive = Archive::new(Kind::Checkpoint, inputs);
    archive.attributes.insert("keep".into(), keep.to_string());
    put_snapshot(&mut archive, snapshot);
    archive
}

/// Adds a snapshot's arrays, texts and numbers to an archive.
pub fn put_snapshot(archive: &mut Archive, snapshot: &Snapshot) {
    archive.attributes.insert("step".into(), snapshot.step.to_string());
    archive.numbers.insert("time".into(), snapshot.time);
    archive.numbers.insert("dt".into(), snapshot.dt);
    archive.attributes.insert("fields".into(), list(snapshot.fields.iter().map(|f| &f.name)));
    for field in &snapshot.fields {
        let array = Array::rows(field.data.clone(), field.components)
            .with("association", association_name(field.association))
            .with("unit", &field.unit);
        archive.arrays.insert(format!("fields/{}", escape(&field.name)), array);
    }
    let numbers = Array::rows(snapshot.numbers.iter().map(|n| n.1).collect(), 1);
    archive.arrays.insert("numbers".into(), numbers.with("names", list(snapshot.numbers.iter().map(|n| &n.0))));
}

/// The snapshot in an archive read from `path`. Error: [`crate::Error::Stale`] if a part is missing.
pub fn snapshot_from_archive(archive: &Archive, path: &Path) -> Result<Snapshot> {
    snapshot_in(archive).map_err(|e| archive.kind.stale(path, e))
}

fn snapshot_in(archive: &Archive) -> Result<Snapshot, String> {
    let text = |name: &str| archive.attributes.get(name).ok_or_else(|| format!("has no attribute `{name}`"));
    let number = |name: &str| archive.numbers.get(name).copied().ok_or_else(|| format!("has no number `{name}`"));
    let step = text("step")?.parse().map_err(|_| "has a step that is no number")?;
    let mut fields = Vec::new();
    for name in names(text("fields")?)? {
        let key = format!("fields/{}", escape(&name));
        let array = archive.array(&key)?;
        let [_, components] = array.shape[..] else { return Err(format!("array `{key}` is not of rank 2")) };
        let association = array.attributes.get("association").and_then(|a| association_named(a));
        fields.push(Field {
            association: association.ok_or_else(|| format!("array `{key}` belongs to nothing known"))?,
            components,
            unit: array.attributes.get("unit").cloned().unwrap_or_default(),
            data: array.as_f64().ok_or_else(|| format!("array `{key}` does not hold real numbers"))?.to_vec(),
            name,
        });
    }
    let array = archive.array("numbers")?;
    let names = names(array.attributes.get("names").ok_or("array `numbers` has no names")?)?;
    let values = real(archive, "numbers", 1)?;
    if names.len() != values.len() {
        return Err("array `numbers` and its names differ in length".into());
    }
    let numbers = names.into_iter().zip(values.iter().copied()).collect();
    Ok(Snapshot { step, time: number("time")?, dt: number("dt")?, fields, numbers })
}

fn real<'a>(archive: &'a Archive, name: &str, components: usize) -> Result<&'a [f64], String> {
    let array = archive.array(name)?;
    match array.as_f64() {
        Some(data) if array.shape.get(1) == Some(&components) => Ok(data),
        _ => Err(format!("array `{name}` does not hold rows of {components} real numbers")),
    }
}

/// Rows of `N` indices below `bound`.
fn whole<const N: usize>(archive: &Archive, name: &str, bound: usize) -> Result<Vec<[usize; N]>, String> {
    let data = archive.array(name)?.as_i64().ok_or_else(|| format!("array `{name}` does not hold whole numbers"))?;
    let (rows, rest) = data.as_chunks::<N>();
    let index = |i: i64| usize::try_from(i).ok().filter(|i| *i < bound);
    let rows: Option<Vec<[usize; N]>> = rows.iter().map(|row| index_row(row.map(index))).collect();
    rows.filter(|_| rest.is_empty()).ok_or_else(|| format!("array `{name}` has an index that is not below {bound}"))
}

fn index_row<const N: usize>(row: [Option<usize>; N]) -> Option<[usize; N]> {
    row.iter().all(Option::is_some).then(|| row.map(Option::unwrap_or_default))
}

fn field_place(on: FieldOn) -> &'static str {
    association_name(if on == FieldOn::Nodes { Association::Node } else { Association::Face })
}

fn association_name(association: Association) -> &'static str {
    match association {
        Association::Node => "node",
        Association::Vertex => "vertex",
        Association::Director => "director",
        Association::Face => "face",
        Association::Point => "point",
    }
}

fn association_named(name: &str) -> Option<Association> {
    use Association::{Director, Face, Node, Point, Vertex};
    [Node, Vertex, Director, Face, Point].into_iter().find(|a| association_name(*a) == name)
}

/// A list of names as one text.
fn list<'a>(names: impl Iterator<Item = &'a String>) -> String {
    serde_json::Value::from_iter(names.map(String::as_str)).to_string()
}

fn names(list: &str) -> Result<Vec<String>, String> {
    serde_json::from_str(list).map_err(|_| format!("has a list of names that cannot be read: {list}"))
}

/// A user's name as one HDF5 name: `%`, `/` and NUL escaped, and likewise a name of dots or of nothing.
fn escape(name: &str) -> String {
    if name.is_empty() {
        return "%".into();
    }
    let dots = name.chars().all(|c| c == '.');
    let special = |c: char| matches!(c, '%' | '/' | '\0') || dots;
    name.chars().map(|c| if special(c) { format!("%{:02x}", u32::from(c)) } else { c.into() }).collect()
}

fn unescape(name: &str) -> String {
    if name == "%" {
        return String::new();
    }
    ["%2f", "/", "%00", "\0", "%2e", ".", "%25", "%"].chunks_exact(2).fold(name.to_string(), |n, pair| n.replace(pair[0], pair[1]))
}

//! Surfaces and time series in the files that ParaView and VTK read.
//!
//! `.vtp` (XML PolyData, binary) or, for curved faces, `.vtu` (UnstructuredGrid) for a moment, `.pvd` for the list of moments, `units.json` for what VTK has no place for.

use super::atomic;
use crate::error::{Error, Result};
use crate::snapshot::Field;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, PolyDataPiece, UnstructuredGridPiece, Version, VertexNumbers,
    Vtk,
};

/// Cells of a surface, or of the body of a shell: indices of points.
#[derive(Clone, Copy, Debug)]
pub enum Faces<'a> {
    /// Flat triangles.
    Linear(&'a [[usize; 3]]),
    /// Quadrangles: the corners around.
    Quadrangles(&'a [[usize; 4]]),
    /// Triangles of six nodes: the corners `v0 v1 v2`, then the middles of `v0 v1`, `v1 v2`, `v2 v0`.
    Quadratic(&'a [[usize; 6]]),
    /// Prisms: a triangle, whose normal points out of the prism, then the one opposite to it, corner by corner.
    Wedges(&'a [[usize; 6]]),
}

impl Faces<'_> {
    /// Extension of the file that holds such a surface: `vtp` (PolyData), or `vtu` (UnstructuredGrid), as VTK has no curved polygons.
    pub fn extension(&self) -> &'static str {
        match self {
            Faces::Linear(_) | Faces::Quadrangles(_) => "vtp",
            Faces::Quadratic(_) | Faces::Wedges(_) => "vtu",
        }
    }

    fn len(&self) -> usize {
        match self {
            Faces::Linear(faces) => faces.len(),
            Faces::Quadrangles(faces) => faces.len(),
            Faces::Quadratic(faces) | Faces::Wedges(faces) => faces.len(),
        }
    }

    fn numbers(&self) -> VertexNumbers {
        let (nodes, size): (&[usize], u64) = match self {
            Faces::Linear(faces) => (faces.as_flattened(), 3),
            Faces::Quadrangles(faces) => (faces.as_flattened(), 4),
            Faces::Quadratic(faces) | Faces::Wedges(faces) => (faces.as_flattened(), 6),
        };
        VertexNumbers::XML {
            connectivity: nodes.iter().map(|v| *v as u64).collect(),
            offsets: (1..=self.len() as u64).map(|n| size * n).collect(),
        }
    }
}

/// A triangle surface with fields.
///
/// A field's name becomes the array's name. Symmetric tensors of six components are in VTK's order, XX YY ZZ XY YZ XZ.
#[derive(Clone, Debug)]
pub struct Surface<'a> {
    /// Node positions [m].
    pub points: &'a [Vector3<f64>],
    /// The faces between them.
    pub faces: Faces<'a>,
    /// Fields with one entry per node.
    pub point_data: Vec<Field>,
    /// Fields with one entry per face.
    pub cell_data: Vec<Field>,
}

impl Surface<'_> {
    /// Writes the file whole or not at all; `path` should end in [`Faces::extension`].
    ///
    /// Errors: [`Error::Input`] for a field whose length is not that of its entries, [`Error::Io`].
    pub fn write(self, path: &Path) -> Result<()> {
        let cannot = |message: String| Error::input(path.display().to_string(), message);
        let attributes = |fields: Vec<Field>, entries: usize| {
            let attribute = |field: Field| {
                if field.data.len() != entries * field.components {
                    let (name, length) = (&field.name, field.data.len());
                    return Err(cannot(format!("field `{name}` has {length} numbers for {entries} entries of {}", field.components)));
                }
                let array = DataArray::scalars(field.name, field.components as u32).with_data(field.data);
                Ok(Attribute::DataArray(array))
            };
            fields.into_iter().map(attribute).collect::<Result<Vec<_>>>()
        };
        let data =
            Attributes { point: attributes(self.point_data, self.points.len())?, cell: attributes(self.cell_data, self.faces.len())? };
        let points: Vec<f64> = self.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let (points, numbers) = (points.into(), self.faces.numbers());
        let data = match self.faces {
            Faces::Linear(_) | Faces::Quadrangles(_) => {
                DataSet::inline(PolyDataPiece { points, polys: Some(numbers), data, ..Default::default() })
            }
            Faces::Quadratic(_) | Faces::Wedges(_) => {
                let kind = if matches!(self.faces, Faces::Wedges(_)) { CellType::Wedge } else { CellType::QuadraticTriangle };
                let cells = Cells { cell_verts: numbers, types: vec![kind; self.faces.len()] };
                DataSet::inline(UnstructuredGridPiece { points, cells, data })
            }
        };
        let file = Vtk { version: Version::new((1, 0)), title: String::new(), byte_order: ByteOrder::LittleEndian, data, file_path: None };
        let mut xml = Vec::new();
        file.write_xml(&mut xml).map_err(|e| cannot(format!("cannot be written as VTK: {e}")))?;
        atomic::write(path, &xml)
    }
}

/// Writes a `.pvd` file: the time [s] and the name of each file, relative to the `.pvd`; `inputs`: hash of what they were made from, in a
/// comment. Errors: [`Error::Io`].
pub fn write_series(path: &Path, files: &[(f64, String)], inputs: Option<&str>) -> Result<()> {
    let mut xml = String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n");
    if let Some(hash) = inputs {
        xml.push_str(&format!("{INPUTS}{hash} -->\n"));
    }
    xml.push_str("  <Collection>\n");
    for (time, file) in files {
        xml.push_str(&format!("    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{}\"/>\n", xml_text(file)));
    }
    xml.push_str("  </Collection>\n</VTKFile>\n");
    atomic::write(path, xml.as_bytes())
}

/// Start of the comment that tells what a series was made from.
const INPUTS: &str = "  <!-- inputs ";

/// The hash that [`write_series`] put into a `.pvd` file, if it did.
pub fn made_from(path: &Path) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().find_map(|line| Some(line.strip_prefix(INPUTS)?.strip_suffix(" -->")?.to_owned()))
}

/// Writes `units.json`: the unit of each array by its name. Errors: [`Error::Io`].
pub fn write_units(path: &Path, units: &BTreeMap<String, String>) -> Result<()> {
    let json = serde_json::to_vec_pretty(units).map_err(|e| Error::io("write", path, e.into()))?;
    atomic::write(path, &json)
}

/// Text as the value of an XML attribute.
fn xml_text(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML knows no other control characters than these, not even escaped.
            '\t' | '\n' | '\r' => escaped.push_str(&format!("&#{};", u32::from(c))),
            c if c.is_control() => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

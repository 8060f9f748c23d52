//! VTK files: legacy (`.vtk`, text and binary) and XML (`.vtu`, `.vtp`). Points, polygonal cells and quadratic triangles; data arrays are
//! skipped.

use super::{Fault, Soup, guarded};
use vtkio::model::{CellType, DataSet, IOBuffer, Piece, PolyDataPiece, UnstructuredGridPiece, VertexNumbers};

/// Section heads of a legacy file and how many counts follow.
const SECTIONS: [(&str, usize); 7] =
    [("POINTS", 1), ("CELLS", 2), ("CELL_TYPES", 1), ("POLYGONS", 2), ("LINES", 2), ("VERTICES", 2), ("TRIANGLE_STRIPS", 2)];

pub fn read_legacy(bytes: &[u8]) -> Result<Soup, Fault> {
    if !bytes.starts_with(b"# vtk DataFile Version") {
        return Err(Fault::at_line(1, "not a legacy VTK file: expected `# vtk DataFile Version`"));
    }
    let end = ["POINT_DATA", "CELL_DATA"].iter().filter_map(|word| heads(bytes, word).next()).min().unwrap_or(bytes.len());
    check_sections(bytes, end)?;
    guarded(|| collect(vtkio::Vtk::parse_legacy_be(&bytes[..end])))
}

pub fn read_xml(bytes: &[u8]) -> Result<Soup, Fault> {
    guarded(|| collect(vtkio::Vtk::parse_xml(bytes)))
}

/// Offsets of the lines that start with a word.
fn heads<'a>(bytes: &'a [u8], word: &'a str) -> impl Iterator<Item = usize> + 'a {
    let starts = std::iter::once(0).chain(bytes.iter().enumerate().filter(|&(_, &b)| b == b'\n').map(|(k, _)| k + 1));
    starts.filter(move |&k| bytes.get(k..k + word.len()).is_some_and(|w| w.eq_ignore_ascii_case(word.as_bytes())))
}

/// Refuses kinds of data sets and counts that the reader would reserve memory for unseen.
fn check_sections(bytes: &[u8], end: usize) -> Result<(), Fault> {
    let words = |at: usize| {
        let line = &bytes[at..bytes.len().min(at + 200)];
        let line = line.split(|&b| b == b'\n').next().unwrap_or(line);
        String::from_utf8_lossy(line).split_whitespace().map(str::to_uppercase).collect::<Vec<_>>()
    };
    let line_of = |at: usize| bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1;
    let Some(at) = heads(bytes, "DATASET").next() else { return Err(Fault::new("the file has no line `DATASET`")) };
    let kind = words(at).get(1).cloned().unwrap_or_default();
    if kind != "POLYDATA" && kind != "UNSTRUCTURED_GRID" {
        return Err(Fault::at_line(line_of(at), format!("data set `{kind}` is not supported: expected POLYDATA or UNSTRUCTURED_GRID")));
    }
    if let Some(at) = heads(bytes, "OFFSETS").find(|&at| at < end) {
        let message = "cells by offsets (version 5 and later) are not supported: save as .vtu, or as version 4.2";
        return Err(Fault::at_line(line_of(at), message));
    }
    for (word, counts) in SECTIONS {
        for at in heads(bytes, word).filter(|&at| at < end) {
            let line = words(at);
            // A longer word that starts the same (CELLS, CELL_TYPES) is a section of its own.
            if line.first().is_none_or(|first| first != word) {
                continue;
            }
            for count in line.iter().skip(1).take(counts) {
                let fits = count.parse::<u64>().is_ok_and(|n| n <= bytes.len() as u64);
                if !fits {
                    let message = format!("{word} announces {count} entries in a file of {} bytes", bytes.len());
                    return Err(Fault::at_line(line_of(at), message));
                }
            }
        }
    }
    Ok(())
}

fn collect(parsed: Result<vtkio::Vtk, vtkio::Error>) -> Result<Soup, Fault> {
    let mut soup = Soup::default();
    match parsed.map_err(|e| Fault::new(e.to_string()))?.data {
        DataSet::PolyData { pieces, .. } => {
            for piece in pieces {
                add_poly_data(&mut soup, inline(piece)?)?;
            }
        }
        DataSet::UnstructuredGrid { pieces, .. } => {
            for piece in pieces {
                add_grid(&mut soup, inline(piece)?)?;
            }
        }
        _ => return Err(Fault::new("this kind of data set is not supported: expected PolyData or UnstructuredGrid")),
    }
    Ok(soup)
}

fn inline<P>(piece: Piece<P>) -> Result<P, Fault> {
    match piece {
        Piece::Inline(piece) => Ok(*piece),
        _ => Err(Fault::new("parallel files that refer to others are not supported")),
    }
}

/// Adds points; returns the number there were before.
fn add_points(soup: &mut Soup, points: IOBuffer) -> Result<usize, Fault> {
    let first = soup.mesh.vertices.len();
    let coordinates = points.cast_into::<f64>().ok_or_else(|| Fault::new("points are not numbers"))?;
    if coordinates.len() % 3 != 0 {
        return Err(Fault::new(format!("{} coordinates do not make points of three", coordinates.len())));
    }
    coordinates.chunks_exact(3).for_each(|p| soup.vertex([p[0], p[1], p[2]]));
    Ok(first)
}

fn add_poly_data(soup: &mut Soup, piece: PolyDataPiece) -> Result<(), Fault> {
    let first = add_points(soup, piece.points)?;
    if piece.strips.is_some_and(|strips| strips.num_cells() > 0) {
        return Err(Fault::new("triangle strips are not supported: save as triangles"));
    }
    if let Some(polygons) = piece.polys {
        for (k, corners) in cells(polygons)?.iter().enumerate() {
            add_polygon(soup, first, corners).map_err(|f| Fault::new(format!("cell {k}: {}", f.message)))?;
        }
    }
    Ok(())
}

fn add_grid(soup: &mut Soup, piece: UnstructuredGridPiece) -> Result<(), Fault> {
    let first = add_points(soup, piece.points)?;
    let cells = cells(piece.cells.cell_verts)?;
    if cells.len() != piece.cells.types.len() {
        return Err(Fault::new(format!("{} cells have {} types", cells.len(), piece.cells.types.len())));
    }
    let mut skipped = 0;
    for (k, (corners, kind)) in cells.iter().zip(&piece.cells.types).enumerate() {
        let fits = match kind {
            CellType::Triangle => corners.len() == 3,
            CellType::Quad => corners.len() == 4,
            CellType::QuadraticTriangle => corners.len() == 6,
            CellType::Polygon => true,
            CellType::Vertex | CellType::PolyVertex | CellType::Line | CellType::PolyLine | CellType::QuadraticEdge => {
                skipped += 1;
                continue;
            }
            _ => return Err(Fault::new(format!("cell {k} is of type {kind:?} ({}): expected triangles", *kind as u8))),
        };
        if !fits {
            return Err(Fault::new(format!("cell {k} is of type {kind:?} but has {} points", corners.len())));
        }
        let quadratic = *kind == CellType::QuadraticTriangle;
        soup.check_order(quadratic, "cell", k as u64)?;
        let added = if quadratic { add_quadratic(soup, first, corners) } else { add_polygon(soup, first, corners) };
        added.map_err(|f| Fault::new(format!("cell {k}: {}", f.message)))?;
    }
    if skipped > 0 {
        soup.warnings.push(format!("{skipped} cells that are points or lines are left out"));
    }
    Ok(())
}

fn add_polygon(soup: &mut Soup, first: usize, corners: &[u64]) -> Result<(), Fault> {
    let corners = points(soup, first, corners)?;
    soup.polygon(&corners)
}

fn add_quadratic(soup: &mut Soup, first: usize, nodes: &[u64]) -> Result<(), Fault> {
    let nodes = points(soup, first, nodes)?;
    let [a, b, c, ab, bc, ca] = nodes[..] else { return Err(Fault::new(format!("{} points: expected 6", nodes.len()))) };
    soup.mesh.faces.push([a, b, c]);
    soup.middles.push([ab, bc, ca]);
    Ok(())
}

/// Vertices of a piece whose points start at `first`.
fn points(soup: &Soup, first: usize, numbers: &[u64]) -> Result<Vec<usize>, Fault> {
    let beyond = |v: &u64| Fault::new(format!("point {v} is out of range"));
    let shifted = |v: &u64| usize::try_from(*v).ok().and_then(|v| v.checked_add(first)).filter(|&v| v < soup.mesh.vertices.len());
    numbers.iter().map(|v| shifted(v).ok_or_else(|| beyond(v))).collect()
}

/// Point lists of cells.
fn cells(numbers: VertexNumbers) -> Result<Vec<Vec<u64>>, Fault> {
    let mut cells = Vec::new();
    match numbers {
        VertexNumbers::Legacy { num_cells, vertices } => {
            let mut rest = vertices.as_slice();
            while let [count, tail @ ..] = rest {
                let Some((corners, next)) = tail.split_at_checked(*count as usize) else {
                    return Err(Fault::new(format!("cell {} announces {count} points, {} follow", cells.len(), tail.len())));
                };
                cells.push(corners.iter().map(|&v| u64::from(v)).collect());
                rest = next;
            }
            if cells.len() != num_cells as usize {
                return Err(Fault::new(format!("{num_cells} cells are announced, {} are there", cells.len())));
            }
        }
        VertexNumbers::XML { connectivity, offsets } => {
            let mut start = 0;
            for (k, &end) in offsets.iter().enumerate() {
                let corners = usize::try_from(end).ok().and_then(|end| connectivity.get(start..end));
                cells.push(
                    corners.ok_or_else(|| Fault::new(format!("cell {k} ends at offset {end}, which is out of order or range")))?.to_vec(),
                );
                start += cells[k].len();
            }
        }
    }
    Ok(cells)
}

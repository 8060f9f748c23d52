//! Legacy VTK files (`.vtk`), text and binary, cells by counts (to version 4) or by offsets (version 5).
//!
//! Format: "VTK File Formats", part "Simple Legacy Formats". Points and cells; data arrays are skipped.

use super::input::{Coding, Input};
use super::vtk::{Cells, Kind, add_points, whole};
use super::{Fault, Soup};

pub fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let mut input = Input { bytes, at: 0, coding: Coding::Text };
    if !bytes.starts_with(b"# vtk DataFile Version") {
        return Err(input.fault("not a legacy VTK file: expected `# vtk DataFile Version`"));
    }
    next_line(&mut input);
    next_line(&mut input);
    let binary = match input.word()?.to_uppercase().as_str() {
        "ASCII" => false,
        "BINARY" => true,
        other => return Err(input.fault(format!("`{other}` is neither ASCII nor BINARY"))),
    };
    let mut file = File { input, binary };
    let (mut points, mut polygons, mut cells, mut types) = (Vec::new(), Cells::default(), Cells::default(), None);
    while let Ok(section) = file.input.word() {
        match section.to_uppercase().as_str() {
            "DATASET" => {
                let kind = file.input.word()?.to_uppercase();
                if kind != "POLYDATA" && kind != "UNSTRUCTURED_GRID" {
                    let message = format!("data set `{kind}` is not supported: expected POLYDATA or UNSTRUCTURED_GRID");
                    return Err(file.input.fault(message));
                }
            }
            "POINTS" => {
                let count = file.input.count("points")?;
                let kind = file.kind()?;
                points = file.numbers(3 * count, kind)?;
            }
            "POLYGONS" => polygons = file.cells()?,
            "CELLS" => cells = file.cells()?,
            "LINES" | "VERTICES" => drop(file.cells()?),
            "TRIANGLE_STRIPS" => {
                if !file.cells()?.ends.is_empty() {
                    return Err(file.input.fault("triangle strips are not supported: save as triangles"));
                }
            }
            "CELL_TYPES" => {
                let count = file.input.count("cell types")?;
                types = Some(file.numbers(count, Kind::Signed(4))?);
            }
            "METADATA" => {
                // Ends with an empty line.
                if !file.input.skip_past(b"\n\n") {
                    file.input.at = bytes.len();
                }
            }
            "FIELD" => file.skip_field()?,
            "POINT_DATA" | "CELL_DATA" => break,
            other => return Err(file.input.fault(format!("unknown section `{other}`"))),
        }
    }
    let mut soup = Soup::default();
    let first = add_points(&mut soup, &points);
    polygons.add_to(&mut soup, first, None)?;
    if !cells.ends.is_empty() {
        cells.add_to(&mut soup, first, Some(types.as_deref().unwrap_or(&[])))?;
    }
    Ok(soup)
}

fn next_line(input: &mut Input) {
    let rest = &input.bytes[input.at..];
    input.at += rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |k| k + 1);
}

struct File<'a> {
    input: Input<'a>,
    binary: bool,
}

impl File<'_> {
    fn kind(&mut self) -> Result<Kind, Fault> {
        let word = self.input.word()?;
        Ok(match word.to_lowercase().as_str() {
            "char" | "vtktypeint8" => Kind::Signed(1),
            "unsigned_char" | "vtktypeuint8" => Kind::Unsigned(1),
            "short" | "vtktypeint16" => Kind::Signed(2),
            "unsigned_short" | "vtktypeuint16" => Kind::Unsigned(2),
            "int" | "vtktypeint32" => Kind::Signed(4),
            "unsigned_int" | "vtktypeuint32" => Kind::Unsigned(4),
            "long" | "vtktypeint64" | "vtkidtype" => Kind::Signed(8),
            "unsigned_long" | "vtktypeuint64" => Kind::Unsigned(8),
            "float" => Kind::Float(4),
            "double" => Kind::Float(8),
            _ => return Err(self.input.fault(format!("`{word}` is no known kind of number"))),
        })
    }

    /// The given count of numbers, from the next line on if binary.
    fn numbers(&mut self, count: u64, kind: Kind) -> Result<Vec<f64>, Fault> {
        if self.binary {
            self.input.end_line();
            let bytes = self.input.take(count.saturating_mul(kind.size() as u64))?;
            return Ok(kind.numbers(bytes, true));
        }
        let mut numbers = Vec::new();
        for _ in 0..count {
            numbers.push(self.input.number("a number")?);
        }
        Ok(numbers)
    }

    fn cells(&mut self) -> Result<Cells, Fault> {
        let (count, size) = (self.input.count("cells")?, self.input.count("entries of cells")?);
        let start = self.input.at;
        if self.input.word().is_ok_and(|word| word.eq_ignore_ascii_case("OFFSETS")) {
            let kind = self.kind()?;
            let offsets = self.numbers(count, kind)?;
            let word = self.input.word()?;
            if !word.eq_ignore_ascii_case("CONNECTIVITY") {
                return Err(self.input.fault(format!("`{word}` where CONNECTIVITY is expected")));
            }
            let kind = self.kind()?;
            let connectivity = self.numbers(size, kind)?;
            // The first offset is where the first cell starts.
            return Ok(Cells { connectivity, ends: offsets.into_iter().skip(1).collect() });
        }
        self.input.at = start;
        let entries = self.numbers(size, Kind::Signed(4))?;
        let mut cells = Cells::default();
        let mut rest = entries.as_slice();
        while let [corners, tail @ ..] = rest {
            let Some((own, next)) = whole(*corners).and_then(|n| tail.split_at_checked(n)) else {
                let message = format!("cell {} announces {corners} points, but {} entries follow", cells.ends.len(), tail.len());
                return Err(self.input.fault(message));
            };
            cells.connectivity.extend_from_slice(own);
            cells.ends.push(cells.connectivity.len() as f64);
            rest = next;
        }
        if cells.ends.len() as u64 != count {
            return Err(self.input.fault(format!("{count} cells are announced, {} are there", cells.ends.len())));
        }
        Ok(cells)
    }

    /// `name arrays`, then for each array `name components tuples kind` and its numbers.
    fn skip_field(&mut self) -> Result<(), Fault> {
        self.input.word()?;
        for _ in 0..self.input.count("arrays")? {
            self.input.word()?;
            let (components, tuples) = (self.input.count("components")?, self.input.count("tuples")?);
            let kind = self.kind()?;
            self.numbers(components.saturating_mul(tuples), kind)?;
        }
        Ok(())
    }
}

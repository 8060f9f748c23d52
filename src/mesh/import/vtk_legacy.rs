//! Legacy VTK files (`.vtk`), text and binary, cells by counts (to version 4) or by offsets (version 5).
//!
//! Format: "VTK File Formats", part "Simple Legacy Formats". Points, cells and their data arrays.

use super::input::{Coding, Input};
use super::vtk::{Cells, Kind, add_points, whole};
use super::{Fault, Soup};
use crate::mesh::FieldOn;

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
    let mut file = File { input, binary, text: None };
    let (mut lines, mut arrays) = (0, Vec::new());
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
            "LINES" | "VERTICES" => lines += file.cells()?.ends.len(),
            "TRIANGLE_STRIPS" => {
                if !file.cells()?.ends.is_empty() {
                    return Err(file.input.fault("triangle strips are not supported: save as triangles"));
                }
            }
            "CELL_TYPES" => {
                let count = file.input.count("cell types")?;
                types = Some(file.numbers(count, Kind::Signed(4))?);
            }
            "METADATA" => file.skip_metadata(),
            "FIELD" => drop(file.field()?),
            kind @ ("POINT_DATA" | "CELL_DATA") => {
                let on = if kind == "POINT_DATA" { FieldOn::Nodes } else { FieldOn::Faces };
                let entries = file.input.size()?;
                arrays.extend(file.data(entries)?.into_iter().map(|array| (on, array)));
            }
            other => return Err(file.input.fault(format!("unknown section `{other}`"))),
        }
        if file.text.is_some() {
            break;
        }
    }
    let mut soup = Soup::default();
    if let Some(name) = file.text {
        soup.warnings.push(format!("the array `{name}` holds no numbers: it and what follows it in the file are left out"));
    }
    let first = add_points(&mut soup, &points);
    soup.cells = lines;
    polygons.add_to(&mut soup, first, None)?;
    if !cells.ends.is_empty() {
        cells.add_to(&mut soup, first, Some(types.as_deref().unwrap_or(&[])))?;
    }
    for (on, array) in arrays {
        let entries = if on == FieldOn::Nodes { soup.mesh.vertices.len() } else { soup.cells };
        soup.field(&array.name, on, array.components as usize, entries, array.data)?;
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
    /// Name of an array that holds text or bits, where reading ends.
    text: Option<String>,
}

struct Array {
    name: String,
    components: u64,
    data: Vec<f64>,
}

impl File<'_> {
    /// The kind of numbers of an array; none, and a note of the name, if it holds text or bits.
    fn kind_or_text(&mut self, name: &str) -> Result<Option<Kind>, Fault> {
        let start = self.input.at;
        if ["string", "utf8_string", "bit", "variant"].contains(&self.input.word()?.to_lowercase().as_str()) {
            self.text = Some(name.to_owned());
            return Ok(None);
        }
        self.input.at = start;
        self.kind().map(Some)
    }

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
    fn field(&mut self) -> Result<Vec<Array>, Fault> {
        self.input.word()?;
        let mut arrays = Vec::new();
        for _ in 0..self.input.count("arrays")? {
            let name = self.name()?;
            let (components, tuples) = (self.input.count("components")?, self.input.count("tuples")?);
            let Some(kind) = self.kind_or_text(&name)? else { break };
            let data = self.numbers(components.saturating_mul(tuples), kind)?;
            arrays.push(Array { name, components, data });
        }
        Ok(arrays)
    }

    /// The arrays of a section `POINT_DATA` or `CELL_DATA` with the given number of entries, up to the next such section, the end of the
    /// file or an array of text, which cannot be skipped.
    fn data(&mut self, entries: u64) -> Result<Vec<Array>, Fault> {
        let mut arrays = Vec::new();
        while self.text.is_none() {
            let start = self.input.at;
            let Ok(word) = self.input.word() else { break };
            let attribute = word.to_uppercase();
            // Components that the word fixes.
            let fixed = match attribute.as_str() {
                "POINT_DATA" | "CELL_DATA" => {
                    self.input.at = start;
                    break;
                }
                "METADATA" => {
                    self.skip_metadata();
                    continue;
                }
                "FIELD" => {
                    arrays.extend(self.field()?);
                    continue;
                }
                "LOOKUP_TABLE" => {
                    self.input.word()?;
                    let size = self.input.count("colours")?;
                    self.numbers(size.saturating_mul(4), Kind::Unsigned(1))?;
                    continue;
                }
                "COLOR_SCALARS" => {
                    self.input.word()?;
                    let size = self.input.count("components")?;
                    self.numbers(size.saturating_mul(entries), Kind::Unsigned(1))?;
                    continue;
                }
                "SCALARS" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
                "VECTORS" | "NORMALS" => 3,
                "TENSORS" => 9,
                "TENSORS6" => 6,
                "TEXTURE_COORDINATES" => 0,
                _ => return Err(self.input.fault(format!("unknown kind of data `{word}`"))),
            };
            let name = self.name()?;
            let mut components = if fixed == 0 { self.input.count("components")? } else { fixed };
            let Some(kind) = self.kind_or_text(&name)? else { break };
            if attribute == "SCALARS" {
                let after_kind = self.input.at;
                let mut word = self.input.word()?;
                if let Ok(count) = word.parse() {
                    components = count;
                    word = self.input.word()?;
                }
                if !word.eq_ignore_ascii_case("LOOKUP_TABLE") {
                    self.input.at = after_kind;
                    return Err(self.input.fault(format!("`{word}` where LOOKUP_TABLE is expected")));
                }
                self.input.word()?;
            }
            let data = self.numbers(entries.saturating_mul(components), kind)?;
            arrays.push(Array { name, components, data });
        }
        Ok(arrays)
    }

    /// Ends with an empty line.
    fn skip_metadata(&mut self) {
        if !self.input.skip_past(b"\n\n") {
            self.input.at = self.input.bytes.len();
        }
    }

    /// A name, in which `%20` stands for a blank and the like.
    fn name(&mut self) -> Result<String, Fault> {
        let word = self.input.word()?;
        let (mut bytes, mut rest) = (Vec::new(), word.as_bytes());
        while let [first, tail @ ..] = rest {
            let code = tail.get(..2).filter(|_| *first == b'%').and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
            bytes.push(code.unwrap_or(*first));
            rest = if code.is_some() { &tail[2..] } else { tail };
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

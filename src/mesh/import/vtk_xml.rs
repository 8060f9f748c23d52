//! XML VTK files (`.vtu`, `.vtp`): arrays as text, base64 or raw, inline or appended, plain or with zlib.
//!
//! Format: "VTK XML Formats" of the VTK documentation. Points, cells and their data arrays. Raw appended data makes a
//! file that is no XML, so tags are scanned here up to where that data begins.

use super::vtk::{Cells, Kind, add_points, whole};
use super::{Fault, Soup};
use crate::mesh::FieldOn;
use flate2::read::ZlibDecoder;
use std::collections::HashMap;
use std::io::Read;

pub fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let file = File::scan(bytes)?;
    let mut soup = Soup::default();
    for piece in &file.pieces {
        let count = |key: &str| piece.attributes.get(key).and_then(|n| n.parse::<u64>().ok()).unwrap_or(0);
        if count("NumberOfStrips") > 0 {
            return Err(Fault::new("triangle strips are not supported: save as triangles"));
        }
        let Some(points) = piece.array("Points", None) else { return Err(Fault::new("a piece has no points")) };
        let coordinates = file.decode(points)?;
        if coordinates.len() % 3 != 0 || coordinates.len() as u64 / 3 != count("NumberOfPoints") {
            let message = format!("{} coordinates for {} points of three", coordinates.len(), count("NumberOfPoints"));
            return Err(Fault::new(message));
        }
        let first = add_points(&mut soup, &coordinates);
        let section = if file.grid { "Cells" } else { "Polys" };
        let named = |name: &str| piece.array(section, Some(name)).map(|array| file.decode(array)).transpose();
        let cells = Cells { connectivity: named("connectivity")?.unwrap_or_default(), ends: named("offsets")?.unwrap_or_default() };
        let key = if file.grid { "NumberOfCells" } else { "NumberOfPolys" };
        if cells.ends.len() as u64 != count(key) {
            return Err(Fault::new(format!("{} offsets for {} cells", cells.ends.len(), count(key))));
        }
        let types = if file.grid { Some(named("types")?.unwrap_or_default()) } else { None };
        // Cells of poly data are counted from its points and lines on.
        let before = soup.cells;
        if !file.grid {
            soup.cells += ["NumberOfVerts", "NumberOfLines"].map(|key| count(key).min(bytes.len() as u64) as usize).iter().sum::<usize>();
        }
        cells.add_to(&mut soup, first, types.as_deref())?;
        for array in &piece.arrays {
            let (on, entries) = match array.section.as_str() {
                "PointData" => (FieldOn::Nodes, soup.mesh.vertices.len() - first),
                "CellData" => (FieldOn::Faces, soup.cells - before),
                _ => continue,
            };
            let name = unescape(array.attributes.get("Name").map_or("", String::as_str));
            if array.attributes.get("type").is_some_and(|kind| kind == "String" || kind == "Bit") {
                soup.warnings.push(format!("the array `{name}` holds no numbers and is left out"));
                continue;
            }
            let components = array.attributes.get("NumberOfComponents").map_or(Some(1), |n| n.parse().ok()).unwrap_or(0);
            soup.field(&name, on, components, entries, file.decode(array)?)?;
        }
    }
    Ok(soup)
}

/// What the tags of a file say.
struct File<'a> {
    /// Whether it is an unstructured grid; else poly data.
    grid: bool,
    big_endian: bool,
    /// Bytes of the numbers that tell the length of a block.
    header: usize,
    compressed: bool,
    pieces: Vec<Piece>,
    /// Appended data from its first byte on, and whether it is base64.
    appended: Option<(&'a [u8], bool)>,
}

struct Piece {
    attributes: HashMap<String, String>,
    arrays: Vec<Array>,
}

impl Piece {
    fn array(&self, section: &str, name: Option<&str>) -> Option<&Array> {
        let named = |array: &&Array| name.is_none() || array.attributes.get("Name").map(String::as_str) == name;
        self.arrays.iter().filter(|array| array.section == section).find(named)
    }
}

struct Array {
    /// Element that holds it: `Points`, `Cells`, ...
    section: String,
    attributes: HashMap<String, String>,
    text: Vec<u8>,
}

impl<'a> File<'a> {
    fn scan(bytes: &'a [u8]) -> Result<Self, Fault> {
        let line = |at: usize| bytes[..at].iter().filter(|&&b| b == b'\n').count() + 1;
        let mut file = File { grid: false, big_endian: false, header: 4, compressed: false, pieces: Vec::new(), appended: None };
        let mut open: Vec<String> = Vec::new();
        let mut started = false;
        let mut at = 0;
        while at < bytes.len() {
            let rest = &bytes[at..];
            let text = rest.iter().position(|&b| b == b'<').unwrap_or(rest.len());
            if open.last().is_some_and(|name| name == "DataArray")
                && let Some(array) = file.pieces.last_mut().and_then(|piece| piece.arrays.last_mut())
            {
                array.text.extend_from_slice(&rest[..text]);
            }
            at += text;
            let Some(tag) = bytes.get(at + 1..) else { break };
            let Some(length) = tag.iter().position(|&b| b == b'>') else {
                return Err(Fault::at_line(line(at), "a tag is not closed: the file is truncated"));
            };
            let place = at;
            let tag = String::from_utf8_lossy(&tag[..length]).into_owned();
            at += length + 2;
            if tag.starts_with(['?', '!']) {
                continue;
            }
            if let Some(name) = tag.strip_prefix('/') {
                if open.pop().as_deref() != Some(name.trim()) {
                    return Err(Fault::at_line(line(place), format!("`</{name}>` closes nothing that is open")));
                }
                continue;
            }
            let name = tag.split([' ', '\t', '\n', '\r', '/']).next().unwrap_or("").to_string();
            let attributes = attributes(&tag);
            match name.as_str() {
                "VTKFile" => {
                    started = true;
                    file.head(&attributes).map_err(|message| Fault::at_line(line(place), message))?;
                }
                _ if !started => return Err(Fault::at_line(line(place), "not a VTK file: expected the element VTKFile")),
                "AppendedData" => {
                    let start = bytes[at..].iter().position(|&b| b == b'_').map(|k| at + k + 1);
                    let Some(start) = start else { return Err(Fault::at_line(line(place), "appended data must start with `_`")) };
                    file.appended = Some((&bytes[start..], attributes.get("encoding").is_some_and(|e| e == "base64")));
                    return Ok(file);
                }
                "Piece" => file.pieces.push(Piece { attributes, arrays: Vec::new() }),
                "DataArray" => {
                    let section = open.last().cloned().unwrap_or_default();
                    if let Some(piece) = file.pieces.last_mut() {
                        piece.arrays.push(Array { section, attributes, text: Vec::new() });
                    }
                }
                _ => {}
            }
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
        if !started || !open.is_empty() {
            return Err(Fault::new(format!("the file is no VTK file or truncated: {} elements are left open", open.len())));
        }
        Ok(file)
    }

    /// Takes over what the element `VTKFile` says of the whole file.
    fn head(&mut self, attributes: &HashMap<String, String>) -> Result<(), String> {
        let attribute = |key: &str| attributes.get(key).map_or("", String::as_str);
        self.grid = match attribute("type") {
            "UnstructuredGrid" => true,
            "PolyData" => false,
            kind => return Err(format!("data set `{kind}` is not supported: expected PolyData or UnstructuredGrid")),
        };
        self.big_endian = attribute("byte_order") == "BigEndian";
        self.header = if attribute("header_type") == "UInt64" { 8 } else { 4 };
        self.compressed = match attribute("compressor") {
            "" => false,
            "vtkZLibDataCompressor" => true,
            _ => return Err("only zlib compression is supported: save with zlib or without".into()),
        };
        Ok(())
    }

    /// The numbers of an array.
    fn decode(&self, array: &Array) -> Result<Vec<f64>, Fault> {
        let attribute = |key: &str| array.attributes.get(key).map_or("", String::as_str);
        let fault = |message: String| Fault::new(format!("array `{}` of {}: {message}", attribute("Name"), array.section));
        let kind = match attribute("type") {
            "Int8" => Kind::Signed(1),
            "UInt8" => Kind::Unsigned(1),
            "Int16" => Kind::Signed(2),
            "UInt16" => Kind::Unsigned(2),
            "Int32" => Kind::Signed(4),
            "UInt32" => Kind::Unsigned(4),
            "Int64" => Kind::Signed(8),
            "UInt64" => Kind::Unsigned(8),
            "Float32" => Kind::Float(4),
            "Float64" => Kind::Float(8),
            other => return Err(fault(format!("`{other}` is no known kind of number"))),
        };
        let bytes = match attribute("format") {
            "ascii" => {
                let text = String::from_utf8_lossy(&array.text);
                return text.split_ascii_whitespace().map(|w| w.parse().map_err(|_| fault(format!("`{w}` is not a number")))).collect();
            }
            "binary" => self.unpack(array.text.trim_ascii(), true),
            "appended" => {
                let Some((data, base64)) = self.appended else { return Err(fault("the file has no appended data".into())) };
                let data = attribute("offset").parse().ok().and_then(|offset: usize| data.get(offset..));
                self.unpack(data.ok_or_else(|| fault(format!("offset `{}` is out of range", attribute("offset"))))?, base64)
            }
            other => return Err(fault(format!("format `{other}` is not known"))),
        };
        Ok(kind.numbers(&bytes.ok_or_else(|| fault("the data are damaged or cut short".into()))?, self.big_endian))
    }

    /// The bytes of an array: a header with lengths, then the data; base64 encodes the header of compressed data by itself.
    fn unpack(&self, data: &[u8], base64: bool) -> Option<Vec<u8>> {
        let header = |bytes: &[u8]| -> Option<Vec<usize>> {
            Kind::Unsigned(self.header).numbers(bytes, self.big_endian).into_iter().map(whole).collect()
        };
        let (start, _) = take(data, base64, self.header)?;
        let first = *header(&start)?.first()?;
        if !self.compressed {
            let (mut bytes, _) = take(data, base64, self.header.checked_add(first)?)?;
            return Some(bytes.split_off(self.header));
        }
        if first == 0 {
            return Some(Vec::new());
        }
        // Number of blocks, size of a block, size of the last one, then the packed size of each.
        let (lengths, used) = take(data, base64, first.checked_add(3)?.checked_mul(self.header)?)?;
        let lengths = header(&lengths)?;
        let packed_sizes = lengths.get(3..)?;
        let total = packed_sizes.iter().try_fold(0usize, |sum, &n| sum.checked_add(n))?;
        let (packed, _) = take(data.get(used..)?, base64, total)?;
        let (mut bytes, mut at) = (Vec::new(), 0);
        for &size in packed_sizes {
            ZlibDecoder::new(packed.get(at..at + size)?).take(lengths[1] as u64).read_to_end(&mut bytes).ok()?;
            at += size;
        }
        Some(bytes)
    }
}

/// The first `count` bytes, decoded if need be, and the length of what they were made from.
fn take(data: &[u8], base64: bool, count: usize) -> Option<(Vec<u8>, usize)> {
    if !base64 {
        return data.get(..count).map(|bytes| (bytes.to_vec(), count));
    }
    // Four letters make three bytes.
    let letters = count.div_ceil(3).checked_mul(4)?;
    let mut bytes = Vec::new();
    for group in data.get(..letters)?.chunks_exact(4) {
        let mut bits = 0u32;
        for &letter in group {
            let value = match letter {
                b'A'..=b'Z' => letter - b'A',
                b'a'..=b'z' => letter - b'a' + 26,
                b'0'..=b'9' => letter - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                // Padding only fills a group whose end is cut off below.
                b'=' => 0,
                _ => return None,
            };
            bits = bits << 6 | u32::from(value);
        }
        bytes.extend_from_slice(&bits.to_be_bytes()[1..]);
    }
    bytes.truncate(count);
    Some((bytes, letters))
}

/// Text of an attribute without the five escapes of XML.
fn unescape(text: &str) -> String {
    ["&lt;", "<", "&gt;", ">", "&quot;", "\"", "&apos;", "'", "&amp;", "&"]
        .chunks_exact(2)
        .fold(text.to_owned(), |text, pair| text.replace(pair[0], pair[1]))
}

/// The attributes `key="value"` of a tag.
fn attributes(tag: &str) -> HashMap<String, String> {
    let mut attributes = HashMap::new();
    let mut rest = tag;
    while let Some((before, after)) = rest.split_once('=') {
        let key = before.split_whitespace().last().unwrap_or("").to_string();
        let after = after.trim_start();
        let Some(quote) = after.chars().next().filter(|c| matches!(c, '"' | '\'')) else { break };
        let Some((value, next)) = after[1..].split_once(quote) else { break };
        attributes.insert(key, value.to_string());
        rest = next;
    }
    attributes
}

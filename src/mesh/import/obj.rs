//! Wavefront OBJ: `v` and `f` lines; groups (`g`) and objects (`o`) become regions, everything else is skipped.
//!
//! Read here and not by a library because those keep single precision and tear faces of different groups apart.

use super::{Fault, Soup};
use std::collections::BTreeMap;

pub fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let mut soup = Soup::default();
    let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let (mut object, mut active) = (Vec::new(), Vec::new());
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let at = |message: String| Fault::at_line(number + 1, message);
        let text = String::from_utf8_lossy(line);
        let mut words = text.split('#').next().unwrap_or("").split_whitespace();
        match words.next() {
            Some("v") => {
                let mut position = [0.0; 3];
                for x in &mut position {
                    let word = words.next().ok_or_else(|| at("a vertex needs three coordinates".into()))?;
                    *x = word.parse().map_err(|_| at(format!("`{word}` is not a number")))?;
                }
                soup.vertex(position);
            }
            Some("f") => {
                let corners = words.map(|word| corner(word, soup.mesh.vertices.len()).map_err(at)).collect::<Result<Vec<_>, _>>()?;
                let first = soup.mesh.faces.len();
                soup.polygon(&corners).map_err(|fault| at(fault.message))?;
                for name in object.iter().chain(&active) {
                    groups.entry(String::clone(name)).or_default().extend(first..soup.mesh.faces.len());
                }
            }
            Some("g") => active = words.map(String::from).collect(),
            Some("o") => object = words.map(String::from).collect::<Vec<_>>(),
            _ => {}
        }
    }
    for (name, faces) in groups {
        soup.group_faces(&name, faces);
    }
    Ok(soup)
}

/// Index of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`: from 1 on, or from the last vertex backwards if negative.
fn corner(word: &str, vertices: usize) -> Result<usize, String> {
    let number = word.split('/').next().unwrap_or("");
    let index: i64 = number.parse().map_err(|_| format!("`{word}` is not a corner of a face"))?;
    let from_zero = if index < 0 { vertices as i128 + i128::from(index) } else { i128::from(index) - 1 };
    usize::try_from(from_zero).map_err(|_| format!("vertex {index} is out of range: there are {vertices} so far"))
}

//! STL, text and binary. Corners at exactly the same place become one vertex.

use super::{Fault, Soup, guarded};
use std::collections::HashMap;
use std::io::Cursor;

pub fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let mut bytes = bytes.to_vec();
    // Some binary files start with `solid` too: only their length tells them apart.
    if let Some(count) = bytes.get(80..84).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]))
        && bytes.len() as u64 == 84 + 50 * u64::from(count)
    {
        bytes[..80].fill(0);
    } else if bytes.trim_ascii_start().starts_with(b"solid") {
        // The reader wants a name and no blanks before the first word.
        let start = bytes.len() - bytes.trim_ascii_start().len() + b"solid".len();
        bytes = [b"solid ", &bytes[start..]].concat();
        if let Some(end) = find(&bytes, b"endsolid")
            && find(&bytes[end..], b"facet").is_some()
        {
            return Err(Fault::new("the file holds more than one solid: write each to a file of its own"));
        }
    } else {
        let counted = bytes.get(80..84).map_or(0, |c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]));
        return Err(Fault::new(format!("neither text STL nor binary: {} bytes do not hold {counted} faces", bytes.len())));
    }
    guarded(|| {
        let mut cursor = Cursor::new(&bytes);
        let mut soup = Soup::default();
        let mut index = HashMap::new();
        for (f, triangle) in stl_io::create_stl_reader(&mut cursor).map_err(|e| Fault::new(e.to_string()))?.enumerate() {
            let triangle = triangle.map_err(|e| Fault::new(format!("face {f}: {e}")))?;
            let mut corners = [0; 3];
            for (corner, vertex) in corners.iter_mut().zip(triangle.vertices) {
                // Adding zero makes -0 and 0 one place.
                let position = vertex.0.map(|x| f64::from(x) + 0.0);
                *corner = *index.entry(position.map(f64::to_bits)).or_insert_with(|| {
                    soup.vertex(position);
                    soup.mesh.vertices.len() - 1
                });
            }
            soup.triangle(corners, None);
        }
        Ok(soup)
    })
}

fn find(bytes: &[u8], word: &[u8]) -> Option<usize> {
    bytes.windows(word.len()).position(|w| w == word)
}

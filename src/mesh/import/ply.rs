//! PLY, text and binary: elements `vertex` (x, y, z) and `face` (vertex_indices or vertex_index); others are skipped. Their further
//! scalar properties are fields; lists are left out.

use super::{Fault, Soup, guarded};
use crate::mesh::FieldOn;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult, PropertyType};

pub fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    guarded(|| {
        let parser = Parser::<Element>::new();
        let mut reader = Reader::new(bytes);
        let header = parser.read_header(&mut reader).map_err(fault)?;
        let mut soup = Soup::default();
        for (name, definition) in &header.elements {
            // An element takes a byte at least, so a larger count is false; without properties it would take none for ever.
            if definition.count > bytes.len() {
                let message = format!("the header announces {} of element `{name}` in a file of {} bytes", definition.count, bytes.len());
                return Err(Fault::new(message));
            }
            let has = |property: &str| definition.properties.contains_key(&property.to_string());
            if name == "vertex" && !["x", "y", "z"].into_iter().all(has) {
                return Err(Fault::new("element `vertex` lacks one of the properties x, y, z"));
            }
            if name == "face" && !["vertex_indices", "vertex_index"].into_iter().any(has) {
                return Err(Fault::new("element `face` lacks the property vertex_indices"));
            }
            let elements = parser.read_payload_for_element(&mut reader, definition, &header).map_err(fault)?;
            for (k, element) in elements.iter().enumerate() {
                match name.as_str() {
                    "vertex" => soup.vertex(element.position),
                    "face" => {
                        let corners =
                            element.corners.as_deref().ok_or_else(|| Fault::new(format!("face {k} has a negative vertex index")))?;
                        soup.polygon(corners)?;
                    }
                    _ => {}
                }
            }
            let on = match name.as_str() {
                "vertex" => FieldOn::Nodes,
                "face" => FieldOn::Faces,
                _ => continue,
            };
            let scalars =
                definition.properties.iter().filter(|(name, p)| axis(name).is_none() && matches!(p.data_type, PropertyType::Scalar(_)));
            for (k, (name, _)) in scalars.enumerate() {
                // Cells of more than one face are one element still.
                let data = elements.iter().filter_map(|element| element.others.get(k).copied()).collect();
                soup.field(name, on, 1, elements.len(), data)?;
            }
        }
        Ok(soup)
    })
}

fn fault(error: ParseError) -> Fault {
    let message = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    match error.line() {
        Some(line) => Fault::at_line(line, message),
        None => Fault::new(message),
    }
}

/// A vertex or a face.
struct Element {
    position: [f64; 3],
    /// Vertex indices; `None` if one is negative.
    corners: Option<Vec<usize>>,
    /// Further scalars in the order of the header.
    others: Vec<f64>,
}

fn axis(name: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|&axis| axis == name)
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Element { position: [0.0; 3], corners: Some(Vec::new()), others: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = axis(name) {
            let Some(value) = scalar(&property) else { return PropertyAccessResult::UnsupportedType };
            self.position[axis] = value;
            return PropertyAccessResult::Set;
        }
        if name == "vertex_indices" || name == "vertex_index" {
            self.corners = match property {
                Property::ListChar(list) => indices(list),
                Property::ListUChar(list) => indices(list),
                Property::ListShort(list) => indices(list),
                Property::ListUShort(list) => indices(list),
                Property::ListInt(list) => indices(list),
                Property::ListUInt(list) => indices(list),
                _ => return PropertyAccessResult::UnsupportedType,
            };
            return PropertyAccessResult::Set;
        }
        let Some(value) = scalar(&property) else { return PropertyAccessResult::Ignored };
        self.others.push(value);
        PropertyAccessResult::Set
    }
}

fn indices<T: TryInto<usize>>(list: Vec<T>) -> Option<Vec<usize>> {
    list.into_iter().map(|index| index.try_into().ok()).collect()
}

fn scalar(property: &Property) -> Option<f64> {
    match *property {
        Property::Char(x) => Some(x.into()),
        Property::UChar(x) => Some(x.into()),
        Property::Short(x) => Some(x.into()),
        Property::UShort(x) => Some(x.into()),
        Property::Int(x) => Some(x.into()),
        Property::UInt(x) => Some(x.into()),
        Property::Float(x) => Some(x.into()),
        Property::Double(x) => Some(x),
        _ => None,
    }
}

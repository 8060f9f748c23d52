//! Fields of a file on their way to the mesh: entries by the file's own nodes and cells, turned into entries of nodes and faces.

use super::{Fault, Soup, printable};
use crate::mesh::{FieldOn, MeshField};

/// Numbers of components of what becomes a field: scalars, pairs, vectors, symmetric tensors and tensors.
const COMPONENTS: [usize; 5] = [1, 2, 3, 6, 9];

/// The fields that a file names, before its cells are known to be faces.
#[derive(Default)]
pub struct RawFields(Vec<(String, MeshField)>);

impl RawFields {
    /// Adds entries to the field of that name, which pieces of a file share.
    fn add(&mut self, name: &str, on: FieldOn, components: usize, data: Vec<f64>) -> Result<(), Fault> {
        match self.0.iter_mut().find(|(n, field)| n == name && field.on == on) {
            Some((_, field)) if field.components != components => {
                Err(Fault::new(format!("field `{name}` has {} components in one place, {components} in another", field.components)))
            }
            Some((_, field)) => {
                field.data.extend(data);
                Ok(())
            }
            None => {
                self.0.push((name.to_owned(), MeshField { on, components, data }));
                Ok(())
            }
        }
    }
}

impl Soup {
    /// Adds an array of a file as a field of its nodes, or its cells in the order of their numbers; an array that is no field is left
    /// out with a warning. `entries`: how many the array must have.
    pub fn field(&mut self, name: &str, on: FieldOn, components: usize, entries: usize, data: Vec<f64>) -> Result<(), Fault> {
        let name = printable(name);
        if name.is_empty() || !COMPONENTS.contains(&components) {
            self.warnings.push(format!("the array `{name}` of {components} components is left out"));
            return Ok(());
        }
        if data.len() != entries.saturating_mul(components) {
            let what = if on == FieldOn::Nodes { "points" } else { "cells" };
            let message = format!("field `{name}` has {} numbers for {entries} {what} of {components} components", data.len());
            return Err(Fault::new(message));
        }
        self.fields.add(&name, on, components, data)
    }

    /// Gives the fields to the mesh, whose vertices are still the file's nodes: each face has the entry of the cell that it was cut from.
    ///
    /// Pieces of a file must agree on their fields. A field of the faces that has the name of one of the nodes is renamed.
    pub fn take_fields(&mut self) -> Result<(), Fault> {
        let mut fields = std::mem::take(&mut self.fields.0);
        fields.sort_by_key(|(_, field)| field.on);
        for (mut name, mut field) in fields {
            let (entries, what) = match field.on {
                FieldOn::Nodes => (self.mesh.vertices.len(), "points"),
                FieldOn::Faces => (self.cells, "cells"),
            };
            if field.data.len() != entries * field.components {
                let count = field.data.len() / field.components;
                return Err(Fault::new(format!("field `{name}` has {count} entries for {entries} {what}: is it there in every piece?")));
            }
            if field.on == FieldOn::Faces {
                let of_cell = |&cell: &usize| field.entry(cell).unwrap_or_default();
                field.data = self.cell_of_face.iter().flat_map(of_cell).copied().collect();
                while self.mesh.fields.contains_key(&name) {
                    let taken = name.clone();
                    name.push_str("_faces");
                    self.warnings.push(format!("points and cells both have a field `{taken}`: that of the cells is called `{name}`"));
                }
            }
            self.mesh.fields.insert(name, field);
        }
        Ok(())
    }
}

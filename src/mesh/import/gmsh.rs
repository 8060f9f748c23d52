//! Gmsh `.msh`, versions 2.2 and 4.1, text and binary, with physical groups as regions and views as fields.
//!
//! Format: the Gmsh reference manual, "MSH file format" and "MSH file format version 2 (legacy)". Linear or
//! quadratic triangles and lines, and points, only. A group of points gives vertices; of lines, edges and their vertices; of triangles, faces with vertices and edges.

use super::input::{Coding, Input};
use super::{Fault, Soup};
use crate::mesh::{FieldOn, Region};
use std::collections::{BTreeMap, HashMap};

const POINT: i64 = 15;
const LINE: i64 = 1;
const TRIANGLE: i64 = 2;
const QUADRATIC_LINE: i64 = 8;
const QUADRATIC_TRIANGLE: i64 = 9;

pub fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let mut file = File { input: Input { bytes, at: 0, coding: Coding::Text }, ..File::default() };
    while let Some(section) = file.input.next_section() {
        let at = file.input.at;
        match section.as_str() {
            "MeshFormat" => file.format()?,
            "PhysicalNames" => file.names()?,
            "Entities" if file.version == Version::V4 => file.entities()?,
            "Nodes" | "Elements" if file.version == Version::Unknown => {
                return Err(file.input.fault("the section MeshFormat is missing"));
            }
            "Nodes" => file.nodes()?,
            "Elements" => file.elements()?,
            "NodeData" => file.view(FieldOn::Nodes)?,
            "ElementData" => file.view(FieldOn::Faces)?,
            "ElementNodeData" | "ParametricNodes" | "Parametrizations" | "PartitionedEntities" => {
                file.soup.warnings.push(format!("section {section} is left out"));
            }
            _ => {}
        }
        let end = format!("$End{section}");
        if !file.input.skip_past(end.as_bytes()) {
            file.input.at = at;
            return Err(file.input.fault(format!("`{end}` is missing: the file is truncated")));
        }
    }
    if file.version == Version::Unknown {
        return Err(Fault::new("not a Gmsh file: the section MeshFormat is missing"));
    }
    file.regions();
    file.fields()?;
    Ok(file.soup)
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Version {
    #[default]
    Unknown,
    V2,
    V4,
}

/// A physical group: dimension and tag.
type Group = (i64, i64);

#[derive(Default)]
struct File<'a> {
    input: Input<'a>,
    version: Version,
    names: BTreeMap<Group, String>,
    /// Groups of each entity (dimension, tag); version 4 only.
    entities: HashMap<(i64, i64), Vec<Group>>,
    /// Vertex index of each node tag.
    node: HashMap<u64, usize>,
    /// First face on given nodes and the groups it came with: version 2 repeats an element for every further group.
    face: HashMap<[usize; 6], (usize, Vec<Group>)>,
    groups: BTreeMap<Group, Parts>,
    /// What each element tag stands for: a face, or an element of another kind.
    element: HashMap<u64, Option<usize>>,
    views: Vec<View>,
    soup: Soup,
}

/// Numbers on tagged nodes or elements.
struct View {
    name: String,
    on: FieldOn,
    components: usize,
    entries: Vec<(u64, Vec<f64>)>,
}

#[derive(Default)]
struct Parts {
    vertices: Vec<usize>,
    edges: Vec<[usize; 2]>,
    faces: Vec<usize>,
}

impl File<'_> {
    fn format(&mut self) -> Result<(), Fault> {
        let version = self.input.word()?;
        self.version = match version.as_str() {
            "2.2" | "2.1" | "2" | "2.0" => Version::V2,
            "4.1" => Version::V4,
            _ => return Err(self.input.fault(format!("version `{version}` is not supported: save as 4.1 or 2.2"))),
        };
        let binary = self.input.word()?;
        let size = self.input.word()?;
        if binary == "0" {
            return Ok(());
        }
        if binary != "1" || size != "8" {
            return Err(self.input.fault(format!("file type `{binary}` with data size `{size}` is not supported")));
        }
        self.input.end_line();
        self.input.coding = Coding::LittleEndian;
        let one = self.input.int()?;
        if one == 1 {
            return Ok(());
        }
        if one == i64::from(1i32.swap_bytes()) {
            self.input.coding = Coding::BigEndian;
            return Ok(());
        }
        Err(self.input.fault("the byte order is not recognised"))
    }

    /// Text in every kind of file: `dimension tag "name"`.
    fn names(&mut self) -> Result<(), Fault> {
        let coding = std::mem::replace(&mut self.input.coding, Coding::Text);
        for _ in 0..self.input.count("names")? {
            let group = (self.input.int()?, self.input.int()?);
            let name = self.input.quoted()?;
            self.names.insert(group, name);
        }
        self.input.coding = coding;
        Ok(())
    }

    fn entities(&mut self) -> Result<(), Fault> {
        self.input.end_line();
        let counts =
            [self.input.count("points")?, self.input.count("curves")?, self.input.count("surfaces")?, self.input.count("volumes")?];
        for (dimension, count) in counts.into_iter().enumerate() {
            let dimension = dimension as i64;
            for _ in 0..count {
                let tag = self.input.int()?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    self.input.real()?;
                }
                let mut groups = Vec::new();
                for _ in 0..self.input.count("physical groups")? {
                    // A negative tag asks for the opposite orientation, which is no part of a group here.
                    groups.push((dimension, self.input.int()?.abs()));
                }
                if dimension > 0 {
                    for _ in 0..self.input.count("bounding entities")? {
                        self.input.int()?;
                    }
                }
                self.entities.insert((dimension, tag), groups);
            }
        }
        Ok(())
    }

    fn nodes(&mut self) -> Result<(), Fault> {
        self.input.end_line();
        if self.version == Version::V2 {
            for _ in 0..self.input.text_count("nodes")? {
                let tag = self.input.int()? as u64;
                let position = [self.input.real()?, self.input.real()?, self.input.real()?];
                self.add_node(tag, position)?;
            }
            return Ok(());
        }
        let blocks = self.input.count("blocks of nodes")?;
        for _ in 0..3 {
            self.input.size()?;
        }
        for _ in 0..blocks {
            let dimension = self.input.int()?;
            self.input.int()?;
            let parametric = self.input.int()? != 0;
            let count = self.input.count("nodes")?;
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(self.input.size()?);
            }
            for tag in tags {
                let position = [self.input.real()?, self.input.real()?, self.input.real()?];
                for _ in 0..if parametric { dimension.clamp(0, 3) } else { 0 } {
                    self.input.real()?;
                }
                self.add_node(tag, position)?;
            }
        }
        Ok(())
    }

    fn add_node(&mut self, tag: u64, position: [f64; 3]) -> Result<(), Fault> {
        if position.iter().any(|x| !x.is_finite()) {
            return Err(self.input.fault(format!("node {tag} has a coordinate that is not finite")));
        }
        if self.node.insert(tag, self.soup.mesh.vertices.len()).is_some() {
            return Err(self.input.fault(format!("node {tag} occurs twice")));
        }
        self.soup.vertex(position);
        Ok(())
    }

    fn elements(&mut self) -> Result<(), Fault> {
        self.input.end_line();
        match (self.version, self.input.coding) {
            (Version::V4, _) => self.elements_v4(),
            (_, Coding::Text) => {
                for _ in 0..self.input.count("elements")? {
                    let (tag, kind, tags) = (self.input.int()? as u64, self.input.int()?, self.input.int()?);
                    let groups = self.groups_v2(kind, tags)?;
                    self.add_element(tag, kind, &groups)?;
                }
                Ok(())
            }
            _ => {
                let mut left = self.input.text_count("elements")?;
                while left > 0 {
                    let (kind, count, tags) = (self.input.int()?, self.input.int()?, self.input.int()?);
                    if count < 1 || count as u64 > left {
                        return Err(self.input.fault(format!("a block announces {count} elements where {left} are left")));
                    }
                    for _ in 0..count {
                        let tag = self.input.int()? as u64;
                        let groups = self.groups_v2(kind, tags)?;
                        self.add_element(tag, kind, &groups)?;
                    }
                    left -= count as u64;
                }
                Ok(())
            }
        }
    }

    /// The tags of an element of version 2: the first is its physical group, 0 for none.
    fn groups_v2(&mut self, kind: i64, tags: i64) -> Result<Vec<Group>, Fault> {
        let mut groups = Vec::new();
        for k in 0..tags {
            let tag = self.input.int()?.abs();
            if k == 0 && tag != 0 {
                groups.push((dimension(kind), tag));
            }
        }
        Ok(groups)
    }

    fn elements_v4(&mut self) -> Result<(), Fault> {
        let blocks = self.input.count("blocks of elements")?;
        for _ in 0..3 {
            self.input.size()?;
        }
        for _ in 0..blocks {
            let entity = (self.input.int()?, self.input.int()?);
            let kind = self.input.int()?;
            let groups = self.entities.get(&entity).cloned().unwrap_or_default();
            for _ in 0..self.input.count("elements")? {
                let tag = self.input.size()?;
                self.add_element(tag, kind, &groups)?;
            }
        }
        Ok(())
    }

    /// Reads the nodes of an element and puts it into its groups.
    fn add_element(&mut self, tag: u64, kind: i64, groups: &[Group]) -> Result<(), Fault> {
        let (corners, middles) = match kind {
            POINT => (1, 0),
            LINE => (2, 0),
            TRIANGLE => (3, 0),
            QUADRATIC_LINE => (2, 1),
            QUADRATIC_TRIANGLE => (3, 3),
            _ => {
                let name = kind_name(kind);
                return Err(self
                    .input
                    .fault(format!("element {tag} is a {name} (type {kind}), which is not supported: expected triangles")));
            }
        };
        if kind != POINT {
            self.soup.check_order(middles > 0, "element", tag).map_err(|f| self.input.fault(f.message))?;
        }
        let mut nodes = [0; 6];
        for vertex in &mut nodes[..corners + middles] {
            let node = if self.version == Version::V4 { self.input.size()? } else { self.input.int()? as u64 };
            let known = self.node.get(&node).copied();
            *vertex = known.ok_or_else(|| self.input.fault(format!("element {tag} names node {node}, which does not exist")))?;
        }
        let mut face = None;
        if corners == 3 {
            let next = self.soup.mesh.faces.len();
            let (first, with) = self.face.entry(nodes).or_insert_with(|| (next, Vec::new()));
            let repeated = *first < next && !groups.is_empty() && groups.iter().all(|g| !with.contains(g));
            with.extend_from_slice(groups);
            if repeated {
                face = Some(*first);
            } else {
                let [a, b, c, ab, bc, ca] = nodes;
                self.soup.triangle([a, b, c], (middles > 0).then_some([ab, bc, ca]));
                face = Some(next);
            }
        }
        self.element.insert(tag, face);
        for group in groups {
            let parts = self.groups.entry(*group).or_default();
            parts.vertices.extend_from_slice(&nodes[..corners]);
            parts.edges.extend((corners == 2).then_some([nodes[0], nodes[1]]));
            parts.faces.extend(face);
        }
        Ok(())
    }

    /// A view at one time: texts (its name first), reals, whole numbers (step, components, entries) and its entries.
    fn view(&mut self, on: FieldOn) -> Result<(), Fault> {
        let coding = std::mem::replace(&mut self.input.coding, Coding::Text);
        let mut name = None;
        for _ in 0..self.input.count("texts")? {
            self.input.end_line();
            let text = self.input.quoted()?;
            name.get_or_insert(text);
        }
        for _ in 0..self.input.count("real numbers")? {
            self.input.real()?;
        }
        let mut whole = Vec::new();
        for _ in 0..self.input.count("whole numbers")? {
            whole.push(self.input.int()?);
        }
        let &[_, components, entries, ..] = &whole[..] else {
            return Err(self.input.fault("a view needs a step, a number of components and a number of entries"));
        };
        self.input.end_line();
        self.input.coding = coding;
        let name = name.unwrap_or_default();
        let components = usize::try_from(components).ok().filter(|n| (1..=9).contains(n));
        let components =
            components.ok_or_else(|| self.input.fault(format!("view `{name}` has {} components: expected 1 to 9", whole[1])))?;
        let mut view = View { name, on, components, entries: Vec::new() };
        for _ in 0..entries {
            let tag = self.input.int()? as u64;
            let values = (0..components).map(|_| self.input.real()).collect::<Result<_, _>>()?;
            view.entries.push((tag, values));
        }
        self.views.push(view);
        Ok(())
    }

    /// Gives the views to the mesh; of a view at several times the last one counts.
    fn fields(&mut self) -> Result<(), Fault> {
        let mut views: Vec<View> = Vec::new();
        for view in std::mem::take(&mut self.views) {
            match views.iter_mut().find(|v| v.name == view.name && v.on == view.on) {
                Some(earlier) => {
                    self.soup.warnings.push(format!("view `{}` is there at several times: the last one is read", view.name));
                    *earlier = view;
                }
                None => views.push(view),
            }
        }
        for View { name, on, components, entries } in views {
            let (count, what) = match on {
                FieldOn::Nodes => (self.soup.mesh.vertices.len(), "node"),
                FieldOn::Faces => (self.soup.mesh.faces.len(), "element"),
            };
            // What has no entry is not finite, which is refused where a face needs it.
            let mut data = vec![f64::NAN; count * components];
            let mut faces_too = on == FieldOn::Nodes;
            for (tag, values) in entries {
                let index = match on {
                    FieldOn::Nodes => self.node.get(&tag).map(|&node| Some(node)),
                    FieldOn::Faces => self.element.get(&tag).copied(),
                };
                let index = index.ok_or_else(|| Fault::new(format!("view `{name}` names {what} {tag}, which does not exist")))?;
                if let Some(index) = index {
                    data[index * components..][..components].copy_from_slice(&values);
                    faces_too = true;
                }
            }
            if faces_too {
                self.soup.field(&name, on, components, count, data)?;
            } else {
                self.soup.warnings.push(format!("view `{name}` has no value on a triangle and is left out"));
            }
        }
        Ok(())
    }

    fn regions(&mut self) {
        for ((dimension, tag), parts) in std::mem::take(&mut self.groups) {
            let name = self.names.get(&(dimension, tag)).cloned().unwrap_or_else(|| format!("physical-{dimension}-{tag}"));
            if parts.faces.is_empty() {
                self.soup.group(&name, &Region::new(parts.vertices, parts.edges, []));
            } else {
                self.soup.group_faces(&name, parts.faces);
            }
        }
    }
}

fn dimension(kind: i64) -> i64 {
    match kind {
        POINT => 0,
        LINE | QUADRATIC_LINE => 1,
        _ => 2,
    }
}

fn kind_name(kind: i64) -> &'static str {
    match kind {
        3 => "quadrangle",
        4 => "tetrahedron",
        5 => "hexahedron",
        6 => "prism",
        7 => "pyramid",
        10 | 16 => "second-order quadrangle",
        11 => "second-order tetrahedron",
        20 | 21 => "third-order triangle",
        _ => "cell of another kind",
    }
}

//! Mesh files of every kind, written in memory for the tests of the readers.

use std::fmt::Write as _;
use thinshell::mesh::generate::{Pattern, rectangle};
use thinshell::mesh::{FieldOn, Mesh, MeshField, Topology};
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, PolyDataPiece, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

/// A small curved mesh whose coordinates single precision holds exactly, without regions.
pub fn sample() -> Mesh {
    let mut mesh = rectangle([3.0, 2.0], [6, 4], Pattern::Alternating, 0.0, 0).unwrap();
    mesh.vertices.iter_mut().for_each(|p| p.z = p.x * p.y);
    mesh.regions.clear();
    mesh
}

/// The sample with scalars, a vector, a symmetric tensor and a tensor on its nodes, and scalars and a pair on its faces. A name has a blank.
pub fn sample_with_fields() -> Mesh {
    with_fields(sample())
}

/// Fields whose every number is another one.
pub fn with_fields(mut mesh: Mesh) -> Mesh {
    let (nodes, faces) = (mesh.nodes().len(), mesh.faces.len());
    for (k, (name, on, components)) in [
        ("heat", FieldOn::Nodes, 1),
        ("wind", FieldOn::Nodes, 3),
        ("strain of it", FieldOn::Nodes, 6),
        ("gradient", FieldOn::Nodes, 9),
        ("colour", FieldOn::Faces, 1),
        ("grain", FieldOn::Faces, 2),
    ]
    .into_iter()
    .enumerate()
    {
        let entries = if on == FieldOn::Nodes { nodes } else { faces };
        let data = (0..entries * components).map(|i| 0.25 * i as f64 - 1000.0 * k as f64).collect();
        mesh.fields.insert(name.to_owned(), MeshField { on, components, data });
    }
    mesh
}

/// The fields on nodes or faces, node entries with midpoints first.
fn fields(mesh: &Mesh, on: FieldOn) -> Vec<(String, usize, Vec<f64>)> {
    let first = mesh.vertices.len();
    let mut list = Vec::new();
    for (name, field) in mesh.fields.iter().filter(|(_, field)| field.on == on) {
        let mut data = field.data.clone();
        if on == FieldOn::Nodes {
            data.rotate_left(first * field.components);
        }
        list.push((name.clone(), field.components, data));
    }
    list
}

/// As arrays of VTK, with the names as legacy files have them or not.
fn attributes(mesh: &Mesh, legacy: bool) -> Attributes {
    let list = |on| {
        let attribute = |(name, n, data): (String, usize, Vec<f64>)| {
            let name = if legacy { name.replace(' ', "%20") } else { name };
            match n {
                3 => Attribute::vectors(name).with_data(data),
                9 => Attribute::tensors(name).with_data(data),
                6 => Attribute::generic(name, 6).with_data(data),
                n => Attribute::scalars(name, n as u32).with_data(data),
            }
        };
        fields(mesh, on).into_iter().map(attribute).collect()
    };
    Attributes { point: list(FieldOn::Nodes), cell: list(FieldOn::Faces) }
}

/// Every kind of file: extension and bytes.
pub fn all(mesh: &Mesh) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("obj", obj(mesh)),
        ("ply", ply(mesh, "ascii")),
        ("ply", ply(mesh, "binary_little_endian")),
        ("ply", ply(mesh, "binary_big_endian")),
        ("stl", stl_text(mesh)),
        ("stl", stl_binary(mesh)),
        ("vtk", vtk_legacy(mesh, true)),
        ("vtk", vtk_legacy(mesh, false)),
        ("vtu", vtk_xml(grid(mesh, false))),
        ("vtp", vtk_xml(poly_data(mesh, false))),
        ("msh", Gmsh { version: 2, binary: false }.write(mesh)),
        ("msh", Gmsh { version: 2, binary: true }.write(mesh)),
        ("msh", Gmsh { version: 4, binary: false }.write(mesh)),
        ("msh", Gmsh { version: 4, binary: true }.write(mesh)),
    ]
}

/// Every kind of file that holds curved faces: extension and bytes. Midpoints come before vertices, so a reader that takes the first
/// points for vertices fails.
pub fn all_quadratic(mesh: &Mesh) -> Vec<(&'static str, Vec<u8>)> {
    let gmsh = |version, binary| ("msh", Gmsh { version, binary }.write(mesh));
    let legacy = |text| ("vtk", vtk_legacy_of(curved_grid(mesh, true), text));
    vec![legacy(true), legacy(false), ("vtu", vtk_xml(quadratic_grid(mesh))), gmsh(2, false), gmsh(2, true), gmsh(4, false), gmsh(4, true)]
}

/// The mesh's nodes with midpoints first, as coordinates, and its faces on them.
fn midpoints_first(mesh: &Mesh) -> (Vec<[f64; 3]>, Vec<[usize; 6]>) {
    let nodes = mesh.midpoints.iter().chain(&mesh.vertices).map(|p| [p.x, p.y, p.z]).collect();
    let (n, m) = (mesh.vertices.len(), mesh.midpoints.len());
    let faces = mesh.six_node_faces().iter().map(|face| face.map(|v| if v < n { v + m } else { v - n })).collect();
    (nodes, faces)
}

pub fn quadratic_grid(mesh: &Mesh) -> DataSet {
    curved_grid(mesh, false)
}

fn curved_grid(mesh: &Mesh, legacy: bool) -> DataSet {
    let (nodes, faces) = midpoints_first(mesh);
    let cell_verts = VertexNumbers::XML {
        connectivity: faces.iter().flatten().map(|&v| v as u64).collect(),
        offsets: (1..=faces.len() as u64).map(|k| 6 * k).collect(),
    };
    let cells = Cells { cell_verts, types: vec![CellType::QuadraticTriangle; faces.len()] };
    DataSet::inline(UnstructuredGridPiece { points: nodes.into_flattened().into(), cells, data: attributes(mesh, legacy) })
}

pub fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("# comment\n");
    mesh.vertices.iter().for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap());
    text += "g skin\n";
    for (f, [a, b, c]) in mesh.faces.iter().enumerate() {
        // Both ways to count.
        let n = mesh.vertices.len();
        if f % 2 == 0 {
            writeln!(text, "f {}/1/1 {}//2 {}", a + 1, b + 1, c + 1).unwrap();
        } else {
            writeln!(text, "f -{} -{} -{}", n - a, n - b, n - c).unwrap();
        }
    }
    text.into_bytes()
}

pub fn ply(mesh: &Mesh, format: &str) -> Vec<u8> {
    let scalars = |on| fields(mesh, on).into_iter().filter(|(_, n, _)| *n == 1).collect::<Vec<_>>();
    let (on_vertices, on_faces) = (scalars(FieldOn::Nodes), scalars(FieldOn::Faces));
    let header = |list: &[(String, usize, Vec<f64>)]| list.iter().map(|(name, ..)| format!("property double {name}\n")).collect::<String>();
    let mut file = format!(
        "ply\nformat {format} 1.0\ncomment test\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         property uchar red\n{}element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
        mesh.vertices.len(),
        header(&on_vertices),
        mesh.faces.len(),
        header(&on_faces)
    )
    .into_bytes();
    let big = format.ends_with("big_endian");
    let mut put = |mut little: Vec<u8>| {
        if big {
            little.reverse();
        }
        file.extend(little);
    };
    if format == "ascii" {
        let mut text = String::new();
        let further =
            |list: &[(String, usize, Vec<f64>)], k: usize| list.iter().map(|(.., data)| format!(" {}", data[k])).collect::<String>();
        for (k, p) in mesh.vertices.iter().enumerate() {
            writeln!(text, "{} {} {} 7{}", p.x, p.y, p.z, further(&on_vertices, k)).unwrap();
        }
        for (k, f) in mesh.faces.iter().enumerate() {
            writeln!(text, "3 {} {} {}{}", f[0], f[1], f[2], further(&on_faces, k)).unwrap();
        }
        file.extend(text.into_bytes());
        return file;
    }
    for (k, p) in mesh.vertices.iter().enumerate() {
        p.iter().for_each(|x| put(x.to_le_bytes().to_vec()));
        put(vec![7]);
        on_vertices.iter().for_each(|(.., data)| put(data[k].to_le_bytes().to_vec()));
    }
    for (k, face) in mesh.faces.iter().enumerate() {
        put(vec![3]);
        face.iter().for_each(|&v| put((v as i32).to_le_bytes().to_vec()));
        on_faces.iter().for_each(|(.., data)| put(data[k].to_le_bytes().to_vec()));
    }
    file
}

pub fn stl_text(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("solid\n");
    for face in &mesh.faces {
        text += "facet normal 0 0 1\nouter loop\n";
        face.map(|v| mesh.vertices[v]).iter().for_each(|p| writeln!(text, "vertex {} {} {}", p.x, p.y, p.z).unwrap());
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid\n").into_bytes()
}

/// Starts with `solid`, as files of some programs do though they are binary.
pub fn stl_binary(mesh: &Mesh) -> Vec<u8> {
    let mut file = b"solid but binary".to_vec();
    file.resize(80, b' ');
    file.extend((mesh.faces.len() as u32).to_le_bytes());
    for face in &mesh.faces {
        file.extend([0u8; 12]);
        face.iter().for_each(|&v| mesh.vertices[v].iter().for_each(|&x| file.extend((x as f32).to_le_bytes())));
        file.extend([0u8; 2]);
    }
    file
}

fn points(mesh: &Mesh) -> vtkio::IOBuffer {
    mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect::<Vec<f64>>().into()
}

fn numbers(mesh: &Mesh) -> VertexNumbers {
    VertexNumbers::XML {
        connectivity: mesh.faces.iter().flatten().map(|&v| v as u64).collect(),
        offsets: (1..=mesh.faces.len() as u64).map(|k| 3 * k).collect(),
    }
}

fn grid(mesh: &Mesh, legacy: bool) -> DataSet {
    let cells = Cells { cell_verts: numbers(mesh), types: vec![CellType::Triangle; mesh.faces.len()] };
    DataSet::inline(UnstructuredGridPiece { points: points(mesh), cells, data: attributes(mesh, legacy) })
}

fn poly_data(mesh: &Mesh, legacy: bool) -> DataSet {
    let data = attributes(mesh, legacy);
    DataSet::inline(PolyDataPiece { points: points(mesh), polys: Some(numbers(mesh)), data, ..PolyDataPiece::default() })
}

fn document(data: DataSet, version: (u8, u8)) -> Vtk {
    Vtk { version: Version::new(version), title: "test".into(), byte_order: ByteOrder::BigEndian, data, file_path: None }
}

fn vtk_xml(data: DataSet) -> Vec<u8> {
    let mut file = Vec::new();
    document(data, (1, 0)).write_xml(&mut file).unwrap();
    file
}

pub fn vtk_legacy(mesh: &Mesh, text: bool) -> Vec<u8> {
    vtk_legacy_of(if text { poly_data(mesh, true) } else { grid(mesh, true) }, text)
}

fn vtk_legacy_of(data: DataSet, text: bool) -> Vec<u8> {
    let document = document(data, (4, 2));
    if text {
        let mut file = String::new();
        document.write_legacy_ascii(&mut file).unwrap();
        return file.into_bytes();
    }
    let mut file = Vec::new();
    document.write_legacy(&mut file).unwrap();
    file
}

/// Gmsh files with the groups `corner` (vertex 0), `side` (the edges 0-1, 1-2) and an unnamed surface 7 of the first two faces;
/// the other faces belong to no group.
#[derive(Clone, Copy)]
pub struct Gmsh {
    pub version: u8,
    pub binary: bool,
}

impl Gmsh {
    pub fn write(self, mesh: &Mesh) -> Vec<u8> {
        let mut file = Bytes { binary: self.binary, data: Vec::new() };
        let version = if self.version == 2 { "2.2" } else { "4.1" };
        file.text(&format!("$MeshFormat\n{version} {} 8\n", u8::from(self.binary)));
        if self.binary {
            file.int(1);
        }
        file.text(
            "\n$EndMeshFormat\n$Comments\nanything\n$EndComments\n$PhysicalNames\n2\n0 4 \"corner\"\n1 5 \"side\"\n$EndPhysicalNames\n",
        );
        // Node tags start at 10, so a reader that takes tags for indices fails.
        let node = |v: usize| v as i64 + 10;
        let (nodes, curved) = midpoints_first(mesh);
        let quadratic = !mesh.midpoints.is_empty();
        let offset = mesh.midpoints.len();
        let edges = Topology::new(&mesh.faces).edges;
        let line = |a: usize, b: usize| {
            let middle = edges.iter().position(|&e| e == [a, b]).filter(|_| quadratic);
            (1, 1, 5, [a + offset, b + offset].into_iter().chain(middle).collect())
        };
        // Dimension, entity, group and corners of each element.
        let mut elements: Vec<(i64, i64, i64, Vec<usize>)> = vec![(0, 1, 4, vec![offset]), line(0, 1), line(1, 2)];
        elements.extend(mesh.faces.iter().enumerate().map(|(f, face)| {
            let (entity, group) = if f < 2 { (1, 7) } else { (2, 0) };
            (2, entity, group, if quadratic { curved[f].to_vec() } else { face.to_vec() })
        }));
        let kind = |dimension: i64| if quadratic { [15, 8, 9] } else { [15, 1, 2] }[dimension as usize];
        if self.version == 2 {
            file.text(&format!("$Nodes\n{}\n", nodes.len()));
            for (v, p) in nodes.iter().enumerate() {
                file.int(node(v));
                p.iter().for_each(|&x| file.real(x));
                file.newline();
            }
            file.text(&format!("$EndNodes\n$Elements\n{}\n", elements.len()));
            for (tag, (dimension, entity, group, corners)) in elements.iter().enumerate() {
                if self.binary {
                    [kind(*dimension), 1, 2, tag as i64 + 1].into_iter().for_each(|x| file.int(x));
                } else {
                    [tag as i64 + 1, kind(*dimension), 2].into_iter().for_each(|x| file.int(x));
                }
                file.int(*group);
                file.int(*entity);
                corners.iter().for_each(|&v| file.int(node(v)));
                file.newline();
            }
            file.text("\n$EndElements\n");
            file.views(mesh);
            return file.data;
        }
        file.text("$Entities\n");
        [1, 1, 2, 0].into_iter().for_each(|n| file.size(n));
        file.newline();
        for (dimension, entity, group) in [(0, 1, 4), (1, 1, 5), (2, 1, 7), (2, 2, 0)] {
            file.int(entity);
            (0..if dimension == 0 { 3 } else { 6 }).for_each(|_| file.real(0.5));
            file.size(u64::from(group != 0));
            if group != 0 {
                file.int(group);
            }
            if dimension > 0 {
                file.size(1);
                file.int(-1);
            }
            file.newline();
        }
        let n = nodes.len() as u64;
        file.text("\n$EndEntities\n$Nodes\n");
        [1, n, 10, n + 9].into_iter().for_each(|x| file.size(x));
        [2, 1, 0].into_iter().for_each(|x| file.int(x));
        file.size(n);
        (0..n).for_each(|v| file.size(v + 10));
        for p in &nodes {
            p.iter().for_each(|&x| file.real(x));
            file.newline();
        }
        file.text("\n$EndNodes\n$Elements\n");
        let m = elements.len() as u64;
        [4, m, 1, m].into_iter().for_each(|x| file.size(x));
        let mut tag = 0;
        for block in elements.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            [block[0].0, block[0].1, kind(block[0].0)].into_iter().for_each(|x| file.int(x));
            file.size(block.len() as u64);
            for (.., corners) in block {
                tag += 1;
                file.size(tag);
                corners.iter().for_each(|&v| file.size(node(v) as u64));
                file.newline();
            }
        }
        file.text("\n$EndElements\n");
        file.views(mesh);
        file.data
    }
}

struct Bytes {
    binary: bool,
    data: Vec<u8>,
}

impl Bytes {
    fn text(&mut self, text: &str) {
        self.data.extend(text.as_bytes());
    }
    /// Fields as views. Faces are the elements from tag 4 on.
    fn views(&mut self, mesh: &Mesh) {
        for (section, on, first) in [("NodeData", FieldOn::Nodes, 10), ("ElementData", FieldOn::Faces, 4)] {
            for (name, n, data) in fields(mesh, on) {
                self.text(&format!("${section}\n1\n\"{name}\"\n1\n0.5\n3\n0\n{n}\n{}\n", data.len() / n));
                for (k, entry) in data.chunks_exact(n).enumerate() {
                    self.int(first + k as i64);
                    entry.iter().for_each(|&x| self.real(x));
                    self.newline();
                }
                self.text(&format!("\n$End{section}\n"));
            }
        }
    }
    fn newline(&mut self) {
        if !self.binary {
            self.text("\n");
        }
    }
    fn int(&mut self, x: i64) {
        if self.binary { self.data.extend((x as i32).to_le_bytes()) } else { self.text(&format!("{x} ")) }
    }
    fn size(&mut self, x: u64) {
        if self.binary { self.data.extend(x.to_le_bytes()) } else { self.text(&format!("{x} ")) }
    }
    fn real(&mut self, x: f64) {
        if self.binary { self.data.extend(x.to_le_bytes()) } else { self.text(&format!("{x} ")) }
    }
}

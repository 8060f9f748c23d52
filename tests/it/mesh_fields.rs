//! Fields of mesh files: every format gives back what was written, cells that are cut or nodes that move take theirs with them, and what
//! cannot be a field is refused by name.

use crate::mesh_files::{self, sample_with_fields, with_fields};
use crate::pipeline_support::{Sandbox, text};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::io::Write;
use thinshell::case::{self, Archive, Kind};
use thinshell::mesh::midpoints::{self, Surface};
use thinshell::mesh::{FieldOn, Mesh, MeshField, import, validate};

fn read(extension: &str, bytes: &[u8]) -> thinshell::Result<(Mesh, Vec<String>)> {
    let mut file = tempfile::Builder::new().suffix(&format!(".{extension}")).tempfile().unwrap();
    file.write_all(bytes).unwrap();
    let place = file.path().display().to_string();
    let (mut mesh, mut warnings) = import::read(file.path(), 2.0)?;
    warnings.extend(validate::check(&mut mesh, &place)?);
    Ok((mesh, warnings))
}

fn refusal(extension: &str, bytes: impl AsRef<[u8]>, field: &str) -> String {
    let error = read(extension, bytes.as_ref()).expect_err("must be refused");
    assert_eq!(error.exit_code(), 2);
    let message = error.to_string();
    assert!(message.contains(&format!(".{extension}")) && message.contains(&format!("`{field}`")), "names file and field: {message}");
    message
}

#[test]
fn every_format_round_trips() {
    let mesh = sample_with_fields();
    assert_eq!(mesh.fields.len(), 6);
    for (k, (extension, bytes)) in mesh_files::all(&mesh).into_iter().enumerate() {
        let (back, warnings) = read(extension, &bytes).unwrap_or_else(|e| panic!("{k} {extension}: {e}"));
        assert_eq!(warnings, Vec::<String>::new(), "{k} {extension}");
        let mut expected = mesh.fields.clone();
        match extension {
            "obj" | "stl" => expected.clear(),
            "ply" => {
                expected.retain(|_, f| f.components == 1);
                let red = MeshField { on: FieldOn::Nodes, components: 1, data: vec![7.0; mesh.vertices.len()] };
                expected.insert("red".into(), red);
            }
            _ => {}
        }
        assert_eq!(back.fields, expected, "{k} {extension}");
    }
}

/// The sample with midpoints off the middle of their edges, so that none equals the mean of the ends.
fn curved() -> Mesh {
    let mut mesh = mesh_files::sample();
    midpoints::place(&mut mesh, Surface::Plane);
    mesh.midpoints.iter_mut().for_each(|p| p.z += 0.0625);
    with_fields(mesh)
}

#[test]
fn nodes_that_become_midpoints_keep_their_values() {
    let mesh = curved();
    for (k, (extension, bytes)) in mesh_files::all_quadratic(&mesh).into_iter().enumerate() {
        let (back, warnings) = read(extension, &bytes).unwrap_or_else(|e| panic!("{k} {extension}: {e}"));
        assert!(warnings.is_empty(), "{k} {extension}: {warnings:?}");
        assert_eq!(back.fields, mesh.fields, "{k} {extension}");
        let mut straight = back.clone();
        straight.drop_midpoints();
        assert!(straight.midpoints.is_empty());
        for (name, field) in &straight.fields {
            let entries = if field.on == FieldOn::Nodes { mesh.vertices.len() } else { mesh.faces.len() };
            assert_eq!(field.data, mesh.fields[name].data[..entries * field.components], "{name}");
        }
    }
}

#[test]
fn new_midpoints_get_the_mean_of_the_ends() {
    let mut mesh = sample_with_fields();
    let before = mesh.fields.clone();
    for surface in [Surface::Smooth, Surface::Plane] {
        midpoints::place(&mut mesh, surface);
        validate::check(&mut mesh, "sample").unwrap();
        let edges = thinshell::mesh::Topology::new(&mesh.faces).edges;
        for (name, field) in &mesh.fields {
            let old = &before[name];
            assert_eq!(field.data[..old.data.len()], old.data, "{name}");
            if field.on == FieldOn::Faces {
                assert_eq!(field, old);
                continue;
            }
            for (e, [a, b]) in edges.iter().enumerate() {
                let (a, b) = (old.entry(*a).unwrap(), old.entry(*b).unwrap());
                let mean: Vec<f64> = a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
                assert_eq!(field.entry(mesh.vertices.len() + e).unwrap(), mean, "{name} at edge {e}");
            }
        }
    }
}

#[test]
fn values_inside_faces_follow_the_nodes() {
    // A quadratic function of the place, which curved faces give back and straight ones only at their corners.
    let mut mesh = mesh_files::sample();
    let value = |p: &Vector3<f64>| vec![1.0 + p.x - 2.0 * p.y, p.x * p.x - p.x * p.y + 3.0 * p.y * p.y];
    mesh.vertices.iter_mut().for_each(|p| p.z = 0.0);
    midpoints::place(&mut mesh, Surface::Plane);
    let data = mesh.nodes().iter().flat_map(value).collect();
    mesh.fields.insert("f".into(), MeshField { on: FieldOn::Nodes, components: 2, data });
    let data = (0..mesh.faces.len()).map(|f| f as f64).collect();
    mesh.fields.insert("g".into(), MeshField { on: FieldOn::Faces, components: 1, data });
    let mut straight = mesh.clone();
    straight.drop_midpoints();
    let at = |face: usize, [x, y]: [f64; 2]| {
        let [a, b, c] = mesh.faces[face].map(|v| mesh.vertices[v]);
        a * (1.0 - x - y) + b * x + c * y
    };
    let mut bend: f64 = 0.0;
    for face in 0..mesh.faces.len() {
        for place in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.2, 0.3], [0.5, 0.5], [0.1, 0.7]] {
            let exact = value(&at(face, place));
            let curved = mesh.field_at("f", face, place).unwrap();
            let flat = straight.field_at("f", face, place).unwrap();
            assert!(curved.iter().zip(&exact).all(|(a, b)| (a - b).abs() < 1e-13), "face {face} {place:?}: {curved:?} {exact:?}");
            assert!((flat[0] - exact[0]).abs() < 1e-13);
            bend = bend.max((flat[1] - exact[1]).abs());
            assert_eq!(mesh.field_at("g", face, place), Some(vec![face as f64]));
        }
    }
    assert!(bend > 1e-2, "linear interpolation must differ: {bend}");
    assert_eq!(mesh.field_at("h", 0, [0.0; 2]), None);
    assert_eq!(mesh.field_at("f", mesh.faces.len(), [0.0; 2]), None);
    assert_eq!(mesh.field_at("g", mesh.faces.len(), [0.0; 2]), None);
}

/// A quadrangle, a line and a triangle; point 5 belongs to no face.
const MIXED: &str = "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 9 9 9\n\
    CELLS 3 12\n2 0 1\n4 0 1 2 3\n3 1 4 2\nCELL_TYPES 3\n3\n9\n5\n";

#[test]
fn cut_polygons_and_dropped_vertices() {
    let data = "CELL_DATA 3\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3\nPOINT_DATA 6\nSCALARS a int 1\nLOOKUP_TABLE default\n0 1 2 3 4 nan\n\
        VECTORS v double\n0 0 0 1 1 1 2 2 2 3 3 3 4 4 4 5 5 5\nMETADATA\nINFORMATION 0\n\nTENSORS6 s float\n";
    let zeros = "0 ".repeat(36);
    let (mesh, warnings) = read("vtk", format!("{MIXED}{data}{zeros}\n").as_bytes()).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
    assert_eq!(mesh.fields["a"].data, [0.0, 1.0, 2.0, 3.0, 4.0], "point 5 goes with its entry, which is no number");
    assert_eq!(mesh.fields["a_faces"], MeshField { on: FieldOn::Faces, components: 1, data: vec![2.0, 2.0, 3.0] });
    assert_eq!(mesh.fields["v"].entry(4).unwrap(), [4.0; 3]);
    assert_eq!((mesh.fields["s"].components, mesh.fields["s"].data.len()), (6, 30));
    assert!(warnings.iter().any(|w| w.contains("`a_faces`")), "{warnings:?}");

    // Poly data count cells from their points and lines on.
    let polydata = "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n\
        POLYGONS 1 5\n4 0 1 2 3\nLINES 2 6\n2 0 1 2 1 2\nCELL_DATA 3\nFIELD all 2\na 1 3 int\n7 8 9\nnames 1 3 string\nx\ny\nz\n";
    let (mesh, warnings) = read("vtk", polydata.as_bytes()).unwrap();
    assert_eq!(mesh.fields["a"].data, [9.0, 9.0]);
    assert!(warnings.iter().any(|w| w.contains("`names` holds no numbers")), "{warnings:?}");
    let vtp = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfLines=\"2\" NumberOfPolys=\"1\">\
        <CellData><DataArray type=\"Int32\" Name=\"a &lt; b\" format=\"ascii\">7 8 9</DataArray>\
        <DataArray type=\"Float32\" Name=\"rgba\" NumberOfComponents=\"4\" format=\"ascii\">1 1 1 1 1 1 1 1 1 1 1 1</DataArray>\
        <DataArray type=\"String\" Name=\"names\" format=\"ascii\">97 0 97 0 97 0</DataArray></CellData>\
        <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>\
        <Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
        <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray></Polys></Piece></PolyData></VTKFile>";
    let (mesh, warnings) = read("vtp", vtp.as_bytes()).unwrap();
    assert_eq!(mesh.fields.keys().collect::<Vec<_>>(), ["a < b"]);
    assert_eq!(mesh.fields["a < b"].data, [9.0, 9.0]);
    assert!(
        warnings.iter().any(|w| w.contains("`rgba` of 4 components")) && warnings.iter().any(|w| w.contains("`names`")),
        "{warnings:?}"
    );

    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
        property list uchar int vertex_indices\nproperty uchar kind\nproperty list uchar float uv\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 5 1 0.5\n";
    assert_eq!(read("ply", ply.as_bytes()).unwrap().0.fields["kind"].data, [5.0, 5.0]);
}

#[test]
fn vtk_pieces_put_their_fields_together() {
    let piece = |shift: f64, field: &str| {
        format!(
            "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><PointData>{field}</PointData><Points><DataArray type=\"Float32\" \
             NumberOfComponents=\"3\" format=\"ascii\">{shift} 0 0 {} 0 0 {shift} 1 0</DataArray></Points><Polys>\
             <DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\" \
             format=\"ascii\">3</DataArray></Polys></Piece>",
            shift + 1.0
        )
    };
    let array = |values: &str, n: usize| {
        format!("<DataArray type=\"Float64\" Name=\"t\" NumberOfComponents=\"{n}\" format=\"ascii\">{values}</DataArray>")
    };
    let file = |pieces: &[String]| format!("<VTKFile type=\"PolyData\"><PolyData>{}</PolyData></VTKFile>", pieces.concat());
    let (mesh, _) = read("vtp", file(&[piece(0.0, &array("1 2 3", 1)), piece(5.0, &array("4 5 6", 1))]).as_bytes()).unwrap();
    assert_eq!(mesh.fields["t"].data, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let message = refusal("vtp", file(&[piece(0.0, &array("1 2 3", 1)), piece(5.0, "")]), "t");
    assert!(message.contains("3 entries for 6 points"), "{message}");
    let message = refusal("vtp", file(&[piece(0.0, &array("1 2 3", 1)), piece(5.0, &array("4 5 6 7 8 9", 2))]), "t");
    assert!(message.contains("1 components") && message.contains("2 in another"), "{message}");
    let message = refusal("vtp", file(&[piece(0.0, &array("1 2", 1))]), "t");
    assert!(message.contains("2 numbers for 3 points"), "{message}");
    let message = refusal("vtp", file(&[piece(0.0, &array("1 inf 3", 1))]), "t");
    assert!(message.contains("not finite") && message.contains("face 0"), "{message}");
}

#[test]
fn gmsh_views() {
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 5 5 5\n$EndNodes\n\
        $Elements\n2\n7 1 2 0 1 1 2\n8 2 2 0 1 1 2 3\n$EndElements\n";
    let view = |section: &str, components: i64, entries: &str| {
        let count = entries.lines().count();
        format!("${section}\n1\n\"my view\"\n1\n0.0\n3\n0\n{components}\n{count}\n{entries}\n$End{section}\n")
    };
    let file = |views: &[String]| format!("{head}{}", views.concat());
    let (mesh, warnings) =
        read("msh", file(&[view("NodeData", 1, "3 0.5\n1 1\n2 2"), view("ElementData", 3, "7 1 2 3\n8 4 5 6")]).as_bytes()).unwrap();
    // Node 4 has neither a face nor a value.
    assert_eq!(mesh.fields["my view"].data, [1.0, 2.0, 0.5]);
    assert_eq!(mesh.fields["my view_faces"].data, [4.0, 5.0, 6.0]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    let (mesh, warnings) =
        read("msh", file(&[view("NodeData", 1, "1 1\n2 2\n3 3"), view("NodeData", 1, "1 4\n2 5\n3 6")]).as_bytes()).unwrap();
    assert_eq!(mesh.fields["my view"].data, [4.0, 5.0, 6.0]);
    assert!(warnings.iter().any(|w| w.contains("several times")), "{warnings:?}");
    let (mesh, warnings) = read("msh", file(&[view("ElementData", 1, "7 1")]).as_bytes()).unwrap();
    assert!(mesh.fields.is_empty() && warnings.iter().any(|w| w.contains("no value on a triangle")), "{warnings:?}");

    for (views, part) in [
        (view("NodeData", 1, "1 1\n2 2"), "not finite on nodes of: face 0"),
        (view("NodeData", 1, "1 1\n9 2"), "names node 9, which does not exist"),
        (view("ElementData", 1, "9 2"), "names element 9, which does not exist"),
        (view("NodeData", 0, "1 1"), "0 components"),
        (view("NodeData", -3, "1 1"), "-3 components"),
    ] {
        let message = refusal("msh", file(&[views]), "my view");
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
    for (views, part) in [
        ("$NodeData\n1\nno quotes\n0\n3\n0 1 0\n$EndNodeData\n", "line 18: expected a name in double quotes"),
        ("$NodeData\n1\n\"a\"\n0\n1\n0\n$EndNodeData\n", "a step, a number of components and a number of entries"),
        ("$NodeData\n1\n\"a\"\n0\n3\n0\n1\n9999999\n1 1\n$EndNodeData\n", "`$EndNodeData` is not a whole number"),
        ("$NodeData\n1\n\"a\"\n0\n3\n0\n1\n1\n1 1\n", "`$EndNodeData` is missing"),
    ] {
        let error = read("msh", format!("{head}{views}").as_bytes()).expect_err("must be refused").to_string();
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    }
}

#[test]
fn wrong_fields_are_refused() {
    for (data, field, part) in [
        ("POINT_DATA 5\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3 4 5\n", "a", "5 numbers for 6 points"),
        ("CELL_DATA 4\nFIELD f 1\nb 2 4 float\n1 2 3 4 5 6 7 8\n", "b", "8 numbers for 3 cells of 2 components"),
        ("POINT_DATA 6\nNORMALS n float\n0 0 0 0 0 0 0 0 0 0 0 nan 0 0 0 0 0 0\n", "n", "not finite on nodes of: face 1 (vertices 0 2 3)"),
        ("CELL_DATA 3\nSCALARS a float\nLOOKUP_TABLE default\n1 2 inf\n", "a", "not finite on faces of: face 2"),
        ("CELL_DATA 3\nSCALARS a float\n1 2 inf\n", "2", "where LOOKUP_TABLE is expected"),
        ("CELL_DATA 3\nSCULPTURES a float\n1 2 inf\n", "SCULPTURES", "unknown kind of data"),
        ("CELL_DATA 3\nVECTORS a quad\n1 2 inf\n", "quad", "no known kind of number"),
    ] {
        let message = refusal("vtk", format!("{MIXED}{data}"), field);
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
    let mesh = sample_with_fields();
    let mut wild = mesh.clone();
    wild.fields.get_mut("heat").unwrap().data[3] = f64::NAN;
    assert!(refusal("ply", mesh_files::ply(&wild, "binary_big_endian"), "heat").contains("not finite on nodes of: face"));
    let mut short = mesh.clone();
    short.fields.get_mut("wind").unwrap().data.pop();
    let message = validate::check(&mut short, "by hand").unwrap_err().to_string();
    assert!(message.contains("by hand") && message.contains("`wind`") && message.contains("3 components"), "{message}");
    let mut none = mesh;
    none.fields.insert("none".into(), MeshField::default());
    assert!(validate::check(&mut none, "by hand").unwrap_err().to_string().contains("`none`"));
}

#[test]
fn mesh_file_keeps_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.h5");
    for mut mesh in [sample_with_fields(), curved()] {
        mesh.fields.get_mut("heat").unwrap().data[..4].copy_from_slice(&[-0.0, f64::NAN, f64::MIN_POSITIVE / 3.0, f64::INFINITY]);
        for name in ["a/b", "%2f", "..", ""] {
            let field = mesh.fields["wind"].clone();
            mesh.fields.insert(name.into(), field);
        }
        case::mesh_to_archive(&mesh, BTreeMap::new(), "in").write(&path).unwrap();
        let archive = Archive::read_for(&path, Kind::Mesh, "in").unwrap();
        let back = case::mesh_from_archive(&archive, &path).unwrap();
        assert_eq!(back.fields.keys().collect::<Vec<_>>(), mesh.fields.keys().collect::<Vec<_>>());
        for (name, field) in &mesh.fields {
            let bits = |f: &MeshField| f.data.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(
                (field.on, field.components, bits(field)),
                (back.fields[name].on, back.fields[name].components, bits(&back.fields[name]))
            );
        }
        assert_eq!(archive.arrays["fields/colour"].attributes["association"], "face");
        for (damage, part) in [
            (Box::new(|a: &mut case::Array| a.attributes.clear()) as Box<dyn Fn(&mut case::Array)>, "belongs to nothing known"),
            (Box::new(|a| a.shape = vec![1, a.shape[0] * a.shape[1]]), "rows for"),
            (Box::new(|a| a.shape = vec![a.shape[0] * a.shape[1]]), "rank 2"),
        ] {
            let mut bad = archive.clone();
            damage(bad.arrays.get_mut("fields/grain").unwrap());
            let message = case::mesh_from_archive(&bad, &path).unwrap_err().to_string();
            assert!(message.contains("fields/grain") && message.contains(part), "{message}");
        }
    }
    let plain = case::mesh_to_archive(&mesh_files::sample(), BTreeMap::new(), "in");
    assert!(!plain.arrays.keys().any(|name| name.starts_with("fields")));
}

/// A scene on a mesh file with a node field that has the name of a computed one, and a face field.
fn exported(element: &str) -> (Vec<String>, Mesh) {
    let scene = format!(
        "[mesh.file]\npath = \"sample.vtk\"\n[shell]\nelement = \"{element}\"\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n\
         [[region]]\nname = \"end\"\nwhere = \"x < 0.6\"\n[[pin]]\nregion = \"end\"\n[statics]\nsteps = 1\n"
    );
    let sandbox = Sandbox::new(&scene);
    let mut mesh = mesh_files::sample();
    let data: Vec<f64> = (0..mesh.vertices.len()).map(|v| v as f64).collect();
    mesh.fields.insert("displacement".into(), MeshField { on: FieldOn::Nodes, components: 1, data });
    let data = (0..2 * mesh.faces.len()).map(|f| f as f64).collect();
    mesh.fields.insert("grain".into(), MeshField { on: FieldOn::Faces, components: 2, data });
    std::fs::write(sandbox.path("sample.vtk"), mesh_files::vtk_legacy(&mesh, true)).unwrap();
    let output = sandbox.output(&["all", "scene.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let extension = if element == "linear" { "vtp" } else { "vtu" };
    let file = sandbox.case("vtk").join(sandbox.newest().0.replace("h5", extension));
    let (exported, warnings) = import::read(&file, 1.0).unwrap();
    let units: BTreeMap<String, String> = serde_json::from_slice(&std::fs::read(sandbox.case("vtk/units.json")).unwrap()).unwrap();
    assert_eq!(units["displacement"], "m");
    assert!(!units.contains_key("displacement_initial") && !units.contains_key("grain"));
    (warnings, exported)
}

#[test]
fn exported_as_they_are() {
    for element in ["linear", "quadratic"] {
        let (_, mesh) = exported(element);
        let initial = &mesh.fields["displacement_initial"];
        assert_eq!((initial.on, initial.components), (FieldOn::Nodes, 1));
        assert!(initial.data.iter().take(35).enumerate().all(|(v, x)| *x == v as f64), "{initial:?}");
        assert_eq!(initial.data.len(), mesh.nodes().len());
        assert_eq!(mesh.fields["displacement"].components, 3);
        let grain = &mesh.fields["grain"];
        assert_eq!((grain.on, grain.components), (FieldOn::Faces, 2));
        assert!(grain.data.iter().enumerate().all(|(f, x)| *x == f as f64));
    }
}

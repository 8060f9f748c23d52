//! Mesh files: what is read equals what was written, and what cannot be read is refused with its place.

use crate::mesh_files::{self, Gmsh, sample, sample_with_fields};
use proptest::prelude::*;
use std::io::Write;
use thinshell::Result;
use thinshell::mesh::{Mesh, Region, import, validate};

fn read(extension: &str, bytes: &[u8], scale: f64) -> Result<(Mesh, Vec<String>)> {
    let mut file = tempfile::Builder::new().suffix(&format!(".{extension}")).tempfile().unwrap();
    file.write_all(bytes).unwrap();
    import::read(file.path(), scale)
}

fn refusal(extension: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = read(extension, bytes.as_ref(), 1.0).expect_err("must be refused");
    assert_eq!(error.exit_code(), 2);
    let text = error.to_string();
    assert!(text.contains(&format!(".{extension}")), "names the file: {text}");
    text
}

/// The mesh with vertices in the order in which faces first name them, as formats without vertices give it.
fn in_face_order(mesh: &Mesh) -> Mesh {
    let mut number = std::collections::HashMap::new();
    let mut vertices = Vec::new();
    let faces = mesh.faces.iter().map(|face| {
        face.map(|v| {
            *number.entry(v).or_insert_with(|| {
                vertices.push(mesh.vertices[v]);
                vertices.len() - 1
            })
        })
    });
    Mesh { faces: faces.collect(), vertices, ..Mesh::default() }
}

#[test]
fn every_format_round_trips() {
    let expected = sample();
    for (k, (extension, bytes)) in mesh_files::all(&expected).into_iter().enumerate() {
        let (mut mesh, warnings) = read(extension, &bytes, 1.0).unwrap_or_else(|e| panic!("{k} {extension}: {e}"));
        assert!(warnings.is_empty(), "{k} {extension}: {warnings:?}");
        let reference = if extension == "stl" { in_face_order(&expected) } else { expected.clone() };
        assert_eq!((&mesh.vertices, &mesh.faces), (&reference.vertices, &reference.faces), "{k} {extension}");
        assert_eq!(validate::check(&mut mesh, "sample").unwrap(), Vec::<String>::new(), "{k} {extension}");
    }
}

#[test]
fn scale_turns_lengths_into_metres() {
    let expected = sample();
    let (mesh, _) = read("obj", &mesh_files::obj(&expected), 0.001).unwrap();
    assert!(mesh.vertices.iter().zip(&expected.vertices).all(|(a, b)| *a == b * 0.001));
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(read("obj", &mesh_files::obj(&expected), scale).is_err());
    }
}

#[test]
fn gmsh_groups_become_regions() {
    let mesh = sample();
    let (f0, f1) = (mesh.faces[0], mesh.faces[1]);
    let sides = [f0, f1].into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    for version in [2, 4] {
        for binary in [false, true] {
            let (read, _) = read("msh", &Gmsh { version, binary }.write(&mesh), 1.0).unwrap();
            assert_eq!(read.regions.keys().collect::<Vec<_>>(), ["corner", "physical-2-7", "side"]);
            assert_eq!(read.regions["corner"], Region::new([0], [], []));
            assert_eq!(read.regions["side"], Region::new([0, 1, 2], [[0, 1], [1, 2]], []));
            assert_eq!(read.regions["physical-2-7"], Region::new(f0.into_iter().chain(f1), sides.clone(), [0, 1]));
        }
    }
}

#[test]
fn gmsh_2_repeats_an_element_for_each_of_its_groups() {
    let nodes = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n";
    let (mesh, _) = read("msh", format!("{nodes}$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 2 1 1 2 3\n$EndElements\n").as_bytes(), 1.0).unwrap();
    assert_eq!(mesh.faces.len(), 1);
    assert_eq!(mesh.regions["physical-2-1"].faces, [0]);
    assert_eq!(mesh.regions["physical-2-2"].faces, [0]);
    // The same group twice is no such repetition.
    let (mut twice, _) =
        read("msh", format!("{nodes}$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 1 1 1 2 3\n$EndElements\n").as_bytes(), 1.0).unwrap();
    assert!(validate::check(&mut twice, "twice").unwrap_err().to_string().contains("face 0 (vertices 0 1 2), face 1"));
}

#[test]
fn gmsh_big_endian_is_read() {
    let mesh = sample();
    let little = Gmsh { version: 2, binary: true }.write(&mesh);
    // Swap the one, the nodes and the elements; the rest is text.
    let find = |word: &str| little.windows(word.len()).position(|w| w == word.as_bytes()).unwrap() + word.len();
    let mut big = little.clone();
    let one = find("2.2 1 8\n");
    big[one..one + 4].reverse();
    let mut at = find(&format!("$Nodes\n{}\n", mesh.vertices.len()));
    for _ in &mesh.vertices {
        for size in [4, 8, 8, 8] {
            big[at..at + size].reverse();
            at += size;
        }
    }
    let elements = find(&format!("$Elements\n{}\n", mesh.faces.len() + 3));
    let end = find("\n$EndElements") - "\n$EndElements".len();
    big[elements..end].chunks_exact_mut(4).for_each(<[u8]>::reverse);
    assert_eq!(read("msh", &big, 1.0).unwrap().0, read("msh", &little, 1.0).unwrap().0);
}

#[test]
fn obj_groups_become_regions_and_polygons_become_fans() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\no sheet\ng left\nf 1 2 3 4\ng right\nf 2 5 3\n";
    let (mesh, warnings) = read("obj", text.as_bytes(), 1.0).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("1 polygons"), "{warnings:?}");
    assert_eq!(mesh.regions["left"].faces, [0, 1]);
    assert_eq!(mesh.regions["right"].edges, [[1, 2], [1, 4], [2, 4]]);
    assert_eq!(mesh.regions["sheet"].faces, [0, 1, 2]);
}

#[test]
fn legacy_vtk_with_quads_and_data_arrays() {
    let text = "# vtk DataFile Version 3.0\ntest\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n0 0 0 1 0 0 1 1 0 0 1 0 2 0 0\n\
                CELLS 3 12\n4 0 1 2 3\n3 1 4 2\n2 0 1\nCELL_TYPES 3\n9\n5\n3\nCELL_DATA 3\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3\n";
    let (mesh, warnings) = read("vtk", text.as_bytes(), 1.0).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        refusal("vtk", text.replace("\n5\n", "\n10\n").replace("3 1 4 2", "4 1 4 2 0").replace("3 12", "3 13"))
            .contains("cell 1: a tetrahedron (type 10)")
    );
}

/// Files that VTK itself wrote, from `data/mesh`.
fn files_of_vtk() -> Vec<std::path::PathBuf> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/mesh");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<_> = paths.filter(|path| path.extension().is_some_and(|e| e != "md")).collect();
    assert_eq!(files.len(), 7);
    files
}

#[test]
fn files_of_vtk_hold_the_same_mesh() {
    let meshes: Vec<_> = files_of_vtk().iter().map(|path| import::read(path, 1.0).unwrap_or_else(|e| panic!("{e}"))).collect();
    let (expected, _) = &meshes[0];
    assert_eq!((expected.vertices.len(), expected.faces.len()), (25, 32));
    assert!((thinshell::mesh::Quality::of(expected).total_area - 1.0).abs() < 1e-6);
    assert!(meshes.iter().all(|(mesh, warnings)| mesh == expected && warnings.is_empty()));
}

#[test]
fn damaged_files_of_vtk_never_panic() {
    for path in files_of_vtk() {
        let extension = path.extension().unwrap().to_str().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for k in 0..400 {
            let mut damaged = bytes.clone();
            let at = k * 7919 % bytes.len();
            damaged[at] = damaged[at].wrapping_add(1 + (k % 255) as u8);
            damaged.truncate(if k % 3 == 0 { bytes.len() - k } else { bytes.len() });
            if let Ok((mut mesh, _)) = read(extension, &damaged, 1.0) {
                let _ = validate::check(&mut mesh, "damaged");
            }
        }
    }
}

#[test]
fn stl_merges_zeros_of_both_signs() {
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                facet normal 0 0 1\nouter loop\nvertex -0 1 0\nvertex 1 -0.0 0\nvertex 1 1 0\nendloop\nendfacet\nendsolid a\n";
    assert_eq!(read("stl", text.as_bytes(), 1.0).unwrap().0.faces, [[0, 1, 2], [2, 1, 3]]);
    assert!(refusal("stl", format!("{text}{text}")).contains("more than one solid"));
}

#[test]
fn refusals_name_the_place() {
    let msh = |nodes: &str, elements: &str| {
        format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n$EndNodes\n$Elements\n{elements}\n$EndElements\n")
    };
    let three = "3\n1 0 0 0\n2 1 0 0\n3 0 1 0";
    let cases: Vec<(&str, String, &[&str])> = vec![
        ("xyz", "x".into(), &["unknown kind", ".obj"]),
        ("obj", String::new(), &["empty"]),
        ("obj", "v 0 0 0\n".into(), &["no faces"]),
        ("obj", "v 0 0 0\nv 0 0 x\n".into(), &["line 2", "`x`"]),
        ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n".into(), &["face 0", "beyond the 3"]),
        ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n".into(), &["line 4", "vertex -4"]),
        ("obj", "v 0 0 0\nv 1 0 0\nf 1 2\n".into(), &["line 3", "2 vertices"]),
        ("obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n".into(), &["vertex 1", "finite"]),
        ("obj", "v 0 0 0\nv 1 0 0\nv 0 1e999 0\nf 1 2 3\n".into(), &["vertex 2", "finite"]),
        ("ply", "plx\n".into(), &["line 1"]),
        (
            "ply",
            "ply\nformat ascii 1.0\nelement vertex 1000000000000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n".into(),
            &["1000000000000000000", "`vertex`"],
        ),
        ("ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n".into(), &["`vertex`", "x, y, z"]),
        ("stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n".into(), &["face 0"]),
        ("stl", "garbage".into(), &["neither text STL nor binary"]),
        ("vtk", "garbage".into(), &["line 1", "DataFile"]),
        ("vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 9 9 9\n".into(), &["line 4", "STRUCTURED_POINTS"]),
        ("vtk", "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 1000000000000000000 float\n".into(), &["line 5", "1000000000000000000 points"]),
        ("vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 3\n".into(), &["cell 0", "point 3"]),
        ("vtk", "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2\n".into(), &["cell 0", "its end 4"]),
        ("vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1\n".into(), &["line 7", "too early"]),
        ("vtu", "<a/>".into(), &["line 1", "VTKFile"]),
        ("vtu", "<VTKFile type=\"ImageData\">".into(), &["line 1", "`ImageData`"]),
        ("vtp", "<VTKFile type=\"PolyData\" compressor=\"vtkLZ4DataCompressor\">".into(), &["zlib"]),
        ("vtu", "<VTKFile".into(), &[]),
        ("msh", "garbage".into(), &["MeshFormat"]),
        ("msh", "$MeshFormat\n4.0 0 8\n$EndMeshFormat\n".into(), &["line 2", "`4.0`"]),
        ("msh", "$Nodes\n1\n".into(), &["line 1", "MeshFormat"]),
        ("msh", msh("1000000000000000000\n", ""), &["line 5", "1000000000000000000 nodes"]),
        ("msh", msh(three, "1\n17 9 2 0 1 1 2 3 1 2 3"), &["face 0", "in the middle of an edge"]),
        ("msh", msh(three, "1\n17 20 2 0 1 1 2 3 1 2 3 1 2 3"), &["line 12", "element 17", "third-order triangle (type 20)"]),
        ("msh", msh(three, "1\n17 2 2 0 1 1 2 9"), &["line 12", "element 17", "node 9"]),
        ("msh", msh("1\n1 0 0 inf", "0"), &["line 6", "node 1", "not finite"]),
        ("msh", msh("2\n1 0 0 0\n1 0 0 0", "0"), &["line 7", "node 1 occurs twice"]),
        ("msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n".into(), &["$EndNodes", "truncated"]),
    ];
    for (extension, text, parts) in cases {
        let message = refusal(extension, &text);
        for part in parts {
            assert!(message.contains(part), "`{part}` is missing in: {message}");
        }
    }
    let missing = import::read(std::path::Path::new("no/such.obj"), 1.0).unwrap_err();
    assert!(missing.to_string().contains("cannot read no/such.obj"));
    let folder = tempfile::Builder::new().suffix(".obj").tempdir().unwrap();
    assert!(import::read(folder.path(), 1.0).unwrap_err().to_string().contains("not a regular file"));
}

#[test]
fn binary_counts_beyond_the_file_are_refused() {
    let mesh = sample();
    let mut stl = mesh_files::stl_binary(&mesh);
    stl[..5].fill(b'x');
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refusal("stl", &stl).contains(&u32::MAX.to_string()));
    let mut msh = Gmsh { version: 4, binary: true }.write(&mesh);
    let at = msh.windows(7).position(|w| w == b"$Nodes\n").unwrap() + 7 + 32 + 12;
    msh[at..at + 8].copy_from_slice(&10u64.pow(18).to_le_bytes());
    let message = refusal("msh", &msh);
    assert!(message.contains("1000000000000000000 nodes") && message.contains("byte "), "{message}");
    let mut msh = Gmsh { version: 2, binary: true }.write(&mesh);
    let at = msh.windows(10).position(|w| w == b"$Elements\n").unwrap() + 13 + 4;
    msh[at..at + 4].copy_from_slice(&i32::MAX.to_le_bytes());
    assert!(refusal("msh", &msh).contains("2147483647 elements"));
}

/// Every prefix of the valid files: an error, or a mesh where only trailing blanks or data are cut.
#[test]
fn truncated_files_never_panic() {
    for (extension, bytes) in mesh_files::all(&sample_with_fields()) {
        let step = bytes.len() / 60 + 1;
        for end in (0..bytes.len()).step_by(step) {
            if let Ok((mut mesh, _)) = read(extension, &bytes[..end], 1.0) {
                let _ = validate::check(&mut mesh, "cut");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_panic(kind in 0usize..14, edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8), cut in any::<prop::sample::Index>(), cuts in any::<bool>()) {
        let (extension, mut bytes) = mesh_files::all(&sample_with_fields()).swap_remove(kind);
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cuts {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok((mut mesh, _)) = read(extension, &bytes, 1.0) {
            let _ = validate::check(&mut mesh, "damaged");
        }
    }

    #[test]
    fn garbage_is_refused(kind in prop::sample::select(vec!["obj", "ply", "stl", "vtk", "vtu", "vtp", "msh"]), bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(read(kind, &bytes, 1.0).is_err());
    }
}

//! Curved faces: midpoints on surfaces, files of quadratic triangles both ways, and what is refused.

use crate::mesh_files::{self, sample};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::io::Write;
use thinshell::Result;
use thinshell::case::vtk::{Faces, Surface as VtkSurface};
use thinshell::mesh::generate::{Pattern, annulus, cylinder, disc, rectangle, rectangle_delaunay, sphere_cap};
use thinshell::mesh::midpoints::{Surface, place};
use thinshell::mesh::{FieldOn, Mesh, MeshField, Region, Topology, import, validate};
use thinshell::snapshot::{Association, Field};

const PATTERNS: [Pattern; 3] = [Pattern::Diagonal, Pattern::Alternating, Pattern::CrissCross];

fn read(extension: &str, bytes: &[u8], scale: f64) -> Result<(Mesh, Vec<String>)> {
    let mut file = tempfile::Builder::new().suffix(&format!(".{extension}")).tempfile().unwrap();
    file.write_all(bytes).unwrap();
    import::read(file.path(), scale)
}

fn refusal<T: std::fmt::Debug>(result: Result<T>, parts: &[&str]) {
    let error = result.expect_err("must be refused");
    assert_eq!(error.exit_code(), 2);
    let text = error.to_string();
    parts.iter().for_each(|part| assert!(text.contains(part), "`{part}` is missing in: {text}"));
}

/// The sample with midpoints off their straight edges that single precision holds exactly.
fn curved_sample() -> Mesh {
    let mut mesh = sample();
    place(&mut mesh, Surface::Plane);
    for (e, m) in mesh.midpoints.iter_mut().enumerate() {
        *m += Vector3::new((e % 3) as f64, (e % 4) as f64, (e % 5) as f64) / 64.0;
    }
    mesh
}

fn placed(mesh: Result<Mesh>, surface: Surface) -> Mesh {
    let mut mesh = mesh.unwrap();
    place(&mut mesh, surface);
    assert_eq!(mesh.midpoints.len(), Topology::new(&mesh.faces).edges.len());
    let (vertices, midpoints) = (mesh.vertices.clone(), mesh.midpoints.clone());
    assert_eq!(validate::check(&mut mesh, "placed").unwrap(), Vec::<String>::new());
    assert_eq!((&mesh.vertices, &mesh.midpoints), (&vertices, &midpoints));
    mesh
}

fn assert_near(a: Vector3<f64>, b: Vector3<f64>, size: f64) {
    assert!((a - b).norm() < 1e-14 * size, "{a} {b}");
}

/// Area [m2] of curved faces in the xy plane, exactly.
fn flat_area(mesh: &Mesh) -> f64 {
    let nodes = mesh.nodes();
    let twice = |a: Vector3<f64>, b: Vector3<f64>| a.x * b.y - a.y * b.x;
    mesh.six_node_faces()
        .iter()
        .map(|face| {
            let [a, b, c, ab, bc, ca] = face.map(|v| nodes[v]);
            // A parabola over a chord encloses two thirds of (chord x sagitta).
            let segment = |p: Vector3<f64>, q: Vector3<f64>, m: Vector3<f64>| twice(m - p, q - p) * 2.0 / 3.0;
            twice(b - a, c - a) / 2.0 + segment(a, b, ab) + segment(b, c, bc) + segment(c, a, ca)
        })
        .sum()
}

#[test]
fn nodes_are_vertices_then_midpoints() {
    let mesh = placed(rectangle([3.0, 2.0], [3, 2], Pattern::Alternating, 0.0, 0), Surface::Plane);
    let nodes = mesh.nodes();
    assert_eq!(nodes.len(), mesh.vertices.len() + mesh.midpoints.len());
    for (face, corners) in mesh.six_node_faces().iter().zip(&mesh.faces) {
        assert_eq!(face[..3], corners[..]);
        for i in 0..3 {
            assert_near(nodes[face[3 + i]], (nodes[face[i]] + nodes[face[(i + 1) % 3]]) / 2.0, 1.0);
        }
    }
}

#[test]
fn annulus_has_round_circles() {
    for (slit, pattern) in [false, true].into_iter().flat_map(|s| PATTERNS.map(|p| (s, p))) {
        let areas = [8, 16, 32].map(|around| {
            let mesh = placed(annulus([1.0, 2.0], [2, around], slit, pattern), Surface::Annulus);
            for (edge, m) in Topology::new(&mesh.faces).edges.iter().zip(&mesh.midpoints) {
                let [a, b] = edge.map(|v| mesh.vertices[v]);
                assert!((m.norm() - (a.norm() + b.norm()) / 2.0).abs() < 1e-14);
                // The same angle to both ends, and on their side.
                assert!((m.dot(&a) / a.norm() - m.dot(&b) / b.norm()).abs() < 1e-14);
                assert!(m.dot(&(a + b)) > 0.0);
            }
            (flat_area(&mesh) - 3.0 * PI).abs()
        });
        assert!((areas[0] / areas[1]).log2() > 3.5 && (areas[1] / areas[2]).log2() > 3.5, "{areas:?}");
    }
}

#[test]
fn disc_has_a_round_rim_and_straight_spokes() {
    let areas = [1, 2, 4].map(|rings| {
        let mesh = placed(disc(0.3, rings), Surface::Disc { radius: 0.3 });
        let topology = Topology::new(&mesh.faces);
        for (e, (&[a, b], m)) in topology.edges.iter().zip(&mesh.midpoints).enumerate() {
            if topology.is_boundary(e) {
                assert!((m.norm() - 0.3).abs() < 1e-15);
            } else {
                assert_near(*m, (mesh.vertices[a] + mesh.vertices[b]) / 2.0, 0.3);
            }
        }
        (flat_area(&mesh) - 0.09 * PI).abs()
    });
    assert!((areas[0] / areas[1]).log2() > 3.5 && (areas[1] / areas[2]).log2() > 3.5, "{areas:?}");
}

#[test]
fn cylinder_and_sphere_hold_their_midpoints() {
    for (angle, cells) in [(360.0, [3, 2]), (360.0, [16, 3]), (150.0, [1, 1]), (270.0, [5, 2])] {
        for pattern in PATTERNS {
            let mesh = placed(cylinder(2.0, 3.0, angle, cells, pattern), Surface::Cylinder { radius: 2.0 });
            for (edge, m) in Topology::new(&mesh.faces).edges.iter().zip(&mesh.midpoints) {
                let [a, b] = edge.map(|v| mesh.vertices[v]);
                assert!((m.xy().norm() - 2.0).abs() < 1e-14);
                assert!((m.z - (a.z + b.z) / 2.0).abs() < 1e-14);
                assert!((m.xy().dot(&a.xy()) - m.xy().dot(&b.xy())).abs() < 1e-13);
                assert!(m.xy().dot(&(a + b).xy()) > 0.0);
            }
        }
    }
    for half_angle in [20.0, 90.0, 150.0] {
        let mesh = placed(sphere_cap(0.5, half_angle, 4), Surface::Sphere { radius: 0.5 });
        for (edge, m) in Topology::new(&mesh.faces).edges.iter().zip(&mesh.midpoints) {
            let [a, b] = edge.map(|v| mesh.vertices[v]);
            assert!((m.norm() - 0.5).abs() < 1e-15);
            assert!(((m - a).norm() - (m - b).norm()).abs() < 1e-15);
        }
    }
}

#[test]
fn ends_without_a_middle_direction_stay_straight() {
    // An edge through the axis, and one that ends on it.
    let vertices = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from).to_vec();
    let mut mesh = Mesh { vertices, faces: vec![[0, 1, 2], [1, 0, 3]], ..Mesh::default() };
    for surface in [Surface::Annulus, Surface::Cylinder { radius: 1.0 }, Surface::Sphere { radius: 1.0 }] {
        place(&mut mesh, surface);
        let edge = Topology::new(&mesh.faces).edges.iter().position(|&e| e == [0, 1]).unwrap();
        assert_eq!(mesh.midpoints[edge], Vector3::zeros());
        assert!(mesh.nodes().iter().flatten().all(|x| x.is_finite()));
    }
}

/// Orders at which an error falls when the number of cells doubles.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// A flat mesh in the unit square, rolled onto a cylinder of radius 1 whose axis lies across its diagonal.
fn rolled(mut mesh: Mesh) -> Mesh {
    for p in &mut mesh.vertices {
        let (along, across) = ((p.x + p.y) / 2f64.sqrt(), (p.y - p.x) / 2f64.sqrt());
        *p = Vector3::new(along.cos(), along.sin(), across);
    }
    mesh
}

fn on_sphere(mut mesh: Mesh) -> Mesh {
    mesh.vertices.iter_mut().for_each(|p| *p = Vector3::new(p.x - 0.4, p.y - 0.6, 1.0).normalize());
    mesh
}

fn largest(mesh: Mesh, distance: impl Fn(&Vector3<f64>) -> f64) -> f64 {
    placed(Ok(mesh), Surface::Smooth).midpoints.iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn smooth_midpoints_approach_the_surface_with_fourth_order() {
    let sphere = |p: &Vector3<f64>| (p.norm() - 1.0).abs();
    let tube = |p: &Vector3<f64>| (p.xy().norm() - 1.0).abs();
    let square = |n: usize, jitter: f64| rectangle([1.0, 1.0], [n, n], Pattern::Alternating, jitter, 7).unwrap();
    let levels = [8, 16, 32];
    let closed = |n: usize| cylinder(1.0, 2.0, 360.0, [3 * n, n], Pattern::Diagonal).unwrap();
    let cases = [
        ("sphere cap", levels.map(|n| largest(sphere_cap(1.0, 70.0, n).unwrap(), sphere))),
        ("closed cylinder", levels.map(|n| largest(closed(n), tube))),
        ("rolled square", levels.map(|n| largest(rolled(square(n, 0.0)), tube))),
        ("square on the sphere", levels.map(|n| largest(on_sphere(square(n, 0.0)), sphere))),
    ];
    for (name, errors) in cases {
        println!("{name} {errors:?}");
        assert!(orders(&errors).iter().all(|&o| o >= 3.5), "{name}: {errors:?} {:?}", orders(&errors));
    }
    // Irregular meshes are not refined alike everywhere: the order over two doublings.
    let irregular = [
        ("jittered", [8, 32].map(|n| largest(rolled(square(n, 0.3)), tube))),
        ("jittered sphere", [8, 32].map(|n| largest(on_sphere(square(n, 0.3)), sphere))),
        ("unstructured", [8, 32].map(|n| largest(rolled(rectangle_delaunay([1.0, 1.0], [n, n], None, 3).unwrap()), tube))),
    ];
    for (name, errors) in irregular {
        println!("{name} {errors:?}");
        assert!(orders(&errors)[0] / 2.0 >= 3.5, "{name}: {errors:?}");
    }
}

#[test]
fn smooth_fits_keep_planes_and_narrow_strips() {
    let straight = |mesh: &Mesh| {
        let edges = Topology::new(&mesh.faces).edges;
        edges.iter().zip(&mesh.midpoints).map(|(&[a, b], m)| (m - (mesh.vertices[a] + mesh.vertices[b]) / 2.0).norm()).fold(0.0, f64::max)
    };
    let mut flat = rectangle([1.0, 1.0], [6, 6], Pattern::Diagonal, 0.3, 1).unwrap();
    flat.vertices.iter_mut().for_each(|p| p.z = 0.3 * p.x - 2.0 * p.y);
    assert!(straight(&placed(Ok(flat), Surface::Smooth)) < 1e-14);
    // One cell across, and a single face.
    let strip = cylinder(1.0, 0.1, 120.0, [24, 1], Pattern::Diagonal);
    let strip = placed(strip, Surface::Smooth);
    let error = strip.midpoints.iter().map(|p| (p.xy().norm() - 1.0).abs()).fold(0.0, f64::max);
    let sagitta = 1.0 - (TAU / 3.0 / 48.0).cos();
    assert!(error < 0.05 * sagitta, "{error} {sagitta}");
    let face = Mesh { vertices: vec![Vector3::x(), Vector3::y(), Vector3::z()], faces: vec![[0, 1, 2]], ..Mesh::default() };
    assert!(straight(&placed(Ok(face), Surface::Smooth)) < 1e-15);
    // A roof: no midpoint leaves its two planes by much.
    let mut roof = rectangle([2.0, 2.0], [10, 10], Pattern::Diagonal, 0.0, 0).unwrap();
    roof.vertices.iter_mut().for_each(|p| p.z = -(p.x - 1.0).abs());
    assert!(straight(&placed(Ok(roof), Surface::Smooth)) < 1e-14);
}

#[test]
fn quadratic_files_round_trip() {
    let expected = curved_sample();
    for (k, (extension, bytes)) in mesh_files::all_quadratic(&expected).into_iter().enumerate() {
        let (mut mesh, warnings) = read(extension, &bytes, 1.0).unwrap_or_else(|e| panic!("{k} {extension}: {e}"));
        assert!(warnings.is_empty(), "{k} {extension}: {warnings:?}");
        assert_eq!((&mesh.vertices, &mesh.faces), (&expected.vertices, &expected.faces), "{k} {extension}");
        assert_eq!(mesh.midpoints, expected.midpoints, "{k} {extension}");
        assert_eq!(validate::check(&mut mesh, "sample").unwrap(), Vec::<String>::new(), "{k} {extension}");
        let (scaled, _) = read(extension, &bytes, 0.25).unwrap();
        assert!(scaled.nodes().iter().zip(expected.nodes()).all(|(a, b)| *a == b * 0.25));
        if extension == "msh" {
            let (f0, f1) = (mesh.faces[0], mesh.faces[1]);
            let sides = [f0, f1].into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
            assert_eq!(mesh.regions["corner"], Region::new([0], [], []));
            assert_eq!(mesh.regions["side"], Region::new([0, 1, 2], [[0, 1], [1, 2]], []));
            assert_eq!(mesh.regions["physical-2-7"], Region::new(f0.into_iter().chain(f1), sides, [0, 1]));
        }
    }
}

#[test]
fn linear_files_have_no_midpoints() {
    for (extension, bytes) in mesh_files::all(&sample()) {
        assert!(read(extension, &bytes, 1.0).unwrap().0.midpoints.is_empty());
    }
}

/// Two curved faces over the unit square, as Gmsh 2.2.
fn two_faces(elements: &str) -> Result<(Mesh, Vec<String>)> {
    let nodes = [
        (1, "0 0 0"),
        (2, "1 0 0"),
        (3, "1 1 0"),
        (4, "0 1 0"),
        (5, "0.5 0 0"),
        (6, "1 0.5 0"),
        (7, "0.5 0.5 0.1"),
        (8, "0.5 1 0"),
        (9, "0 0.5 0"),
        (10, "0.5 0.5 0.2"),
        (11, "0.5 0.5 0.1"),
    ];
    let nodes: String = nodes.iter().map(|(tag, at)| format!("{tag} {at}\n")).collect();
    let count = elements.lines().count();
    let text =
        format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n11\n{nodes}$EndNodes\n$Elements\n{count}\n{elements}\n$EndElements\n");
    read("msh", text.as_bytes(), 1.0)
}

#[test]
fn elements_that_do_not_fit_together_are_refused() {
    let lower = "21 9 2 0 1 1 2 3 5 6 7";
    let (mesh, _) = two_faces(&format!("{lower}\n22 9 2 0 1 1 3 4 7 8 9")).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.midpoints[1], Vector3::new(0.5, 0.5, 0.1));
    // A duplicate of the node in the same place is no contradiction; one elsewhere is.
    assert_eq!(two_faces(&format!("{lower}\n22 9 2 0 1 1 3 4 11 8 9")).unwrap().0.midpoints, mesh.midpoints);
    refusal(two_faces(&format!("{lower}\n22 9 2 0 1 1 3 4 10 8 9")), &["faces 0 and 1 disagree", "edge 0 2"]);
    refusal(two_faces(&format!("{lower}\n22 2 2 0 1 1 3 4")), &["element 22 is linear", "element 21 is quadratic"]);
    refusal(two_faces(&format!("20 1 2 0 1 1 2\n{lower}")), &["element 21 is quadratic", "element 20 is linear"]);
    refusal(two_faces(&format!("{lower}\n22 9 2 0 1 5 2 4 7 8 9")), &["face 0 has node 4", "corner"]);
    refusal(two_faces("21 9 2 0 1 1 2 3 5 6 99"), &["element 21", "node 99"]);
    // The order of other programs: midpoints opposite the corners.
    let (mut wrong, _) = two_faces("21 9 2 0 1 1 2 3 6 7 5").unwrap();
    refusal(validate::check(&mut wrong, "wrong"), &["farther than 0.4", "face 0 (vertices"]);
    let vtk = |cells: &str| {
        let head =
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 double\n0 0 0 1 0 0 0 1 0 .5 0 0 .5 .5 0 0 .5 0\n";
        read("vtk", format!("{head}{cells}").as_bytes(), 1.0)
    };
    assert_eq!(vtk("CELLS 2 11\n6 0 1 2 3 4 5\n3 0 1 3\nCELL_TYPES 2\n22\n21\n").unwrap().0.midpoints.len(), 3);
    refusal(vtk("CELLS 2 11\n6 0 1 2 3 4 5\n3 0 1 3\nCELL_TYPES 2\n22\n5\n"), &["cell 1 is linear", "cell 0 is quadratic"]);
    refusal(vtk("CELLS 1 6\n5 0 1 2 3 4\nCELL_TYPES 1\n22\n"), &["cell 0", "5 points"]);
    refusal(vtk("CELLS 1 7\n6 0 1 2 3 4 6\nCELL_TYPES 1\n22\n"), &["cell 0", "point 6"]);
}

#[test]
fn midpoints_without_sense_are_refused_by_face() {
    let check = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = curved_sample();
        change(&mut mesh);
        validate::check(&mut mesh, "mesh.file")
    };
    assert!(check(&|_| {}).is_ok());
    refusal(check(&|m| m.midpoints.truncate(7)), &["mesh.file", "7 midpoints", "edges"]);
    refusal(check(&|m| m.midpoints.push(Vector3::zeros())), &["midpoints for"]);
    refusal(check(&|m| m.midpoints[1].y = f64::NAN), &["not finite", "face 0 (vertices"]);
    refusal(check(&|m| m.midpoints[1].z = f64::INFINITY), &["not finite", "face 0 (vertices"]);
    refusal(check(&|m| m.midpoints[1].z += 1e300), &["farther", "face 0 (vertices"]);
    let one = |shift: [[f64; 2]; 3]| {
        let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from).to_vec();
        let mut mesh = Mesh { vertices, faces: vec![[0, 1, 2]], ..Mesh::default() };
        place(&mut mesh, Surface::Plane);
        // Edges are numbered as the face names them: 1 2, 2 0, 0 1.
        for (m, [x, y]) in mesh.midpoints.iter_mut().zip(shift) {
            *m += Vector3::new(x, y, 0.0);
        }
        validate::check(&mut mesh, "one")
    };
    assert!(one([[0.0; 2]; 3]).is_ok());
    // A node beyond the quarter of its edge folds the corner; one pushed into the face folds the side.
    assert!(one([[0.0; 2], [0.0; 2], [0.24, 0.0]]).is_ok());
    refusal(one([[0.0; 2], [0.0; 2], [0.26, 0.0]]), &["fold", "face 0 (vertices 0 1 2)"]);
    refusal(one([[0.0; 2], [0.0; 2], [-0.25, 0.0]]), &["fold"]);
    refusal(one([[0.0; 2], [0.0; 2], [0.0, 0.3]]), &["fold"]);
    assert!(one([[0.0; 2], [0.0; 2], [0.0, -0.3]]).is_ok());
    refusal(one([[0.0; 2], [0.0; 2], [0.0, -0.41]]), &["farther"]);
    for scale in [1e-30, 1e30] {
        let mut mesh = curved_sample();
        mesh.vertices.iter_mut().chain(&mut mesh.midpoints).for_each(|p| *p *= scale);
        assert!(validate::check(&mut mesh, "scaled").is_ok(), "{scale}");
    }
}

#[test]
fn dropping_vertices_leaves_midpoints_with_their_edges() {
    let expected = curved_sample();
    let mut mesh = expected.clone();
    // Unused vertices before, among and after the others.
    for at in [0, 7, mesh.vertices.len() + 2] {
        mesh.vertices.insert(at, Vector3::new(9.0, 9.0, 9.0));
        mesh.faces.iter_mut().flatten().for_each(|v| *v += usize::from(*v >= at));
    }
    assert!(validate::check(&mut mesh, "gaps").unwrap()[0].contains("3 vertices"));
    assert_eq!(mesh, expected);
}

#[test]
fn vtk_files_hold_curved_faces() {
    let mesh = curved_sample();
    let folder = tempfile::tempdir().unwrap();
    let (points, faces) = (mesh.nodes(), mesh.six_node_faces());
    let faces = Faces::Quadratic(&faces);
    assert_eq!((faces.extension(), Faces::Linear(&mesh.faces).extension()), ("vtu", "vtp"));
    let path = folder.path().join("state").with_extension(faces.extension());
    let field = |association, count: usize| Field {
        name: format!("{association:?}"),
        association,
        components: 2,
        unit: "m".into(),
        data: (0..2 * count).map(|i| i as f64 / 3.0).collect(),
    };
    let (of_points, of_faces) = (field(Association::Node, points.len()), field(Association::Face, mesh.faces.len()));
    let surface = |data: &Field| VtkSurface { points: &points, faces, point_data: vec![data.clone()], cell_data: vec![of_faces.clone()] };
    refusal(surface(&field(Association::Node, mesh.vertices.len())).write(&path), &["Node"]);
    assert!(!path.exists());
    surface(&of_points).write(&path).unwrap();
    let (back, warnings) = import::read(&path, 1.0).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let fields = [(FieldOn::Nodes, &of_points), (FieldOn::Faces, &of_faces)]
        .map(|(on, f)| (f.name.clone(), MeshField { on, components: f.components, data: f.data.clone() }));
    assert_eq!(back, Mesh { fields: fields.into(), ..mesh });
    use vtkio::model::{Attribute, DataSet, Piece};
    let DataSet::UnstructuredGrid { mut pieces, .. } = vtkio::Vtk::import(&path).unwrap().data else { panic!("no grid") };
    let Some(Piece::Inline(piece)) = pieces.pop() else { panic!("no piece") };
    for (attributes, field) in [(piece.data.point, of_points), (piece.data.cell, of_faces)] {
        let Some(Attribute::DataArray(array)) = attributes.into_iter().next() else { panic!("no array") };
        assert_eq!((array.name, array.data.into_vec::<f64>().unwrap()), (field.name, field.data));
    }
}

#[test]
fn truncated_quadratic_files_never_panic() {
    for (extension, bytes) in mesh_files::all_quadratic(&curved_sample()) {
        for end in (0..bytes.len()).step_by(bytes.len() / 60 + 1) {
            if let Ok((mut mesh, _)) = read(extension, &bytes[..end], 1.0) {
                let _ = validate::check(&mut mesh, "cut");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_quadratic_files_never_panic(kind in 0usize..7, edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8), cut in any::<prop::sample::Index>(), cuts in any::<bool>()) {
        let (extension, mut bytes) = mesh_files::all_quadratic(&curved_sample()).swap_remove(kind);
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cuts {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok((mut mesh, _)) = read(extension, &bytes, 1.0)
            && validate::check(&mut mesh, "damaged").is_ok()
        {
            prop_assert!(mesh.midpoints.is_empty() || mesh.midpoints.len() == Topology::new(&mesh.faces).edges.len());
        }
    }
}

//! Conformal maps to the plane: exact maps with their rate of convergence, isometries to round-off, and what is refused.

use crate::pipeline_support::{Sandbox, text, with};
use nalgebra::{Matrix2, Rotation2, Rotation3, Vector2, Vector3};
use std::f64::consts::{PI, TAU};
use thinshell::case::{self, Archive, Kind};
use thinshell::mesh::conformal::{Flattened, Onto, flatten};
use thinshell::mesh::generate::{Pattern, Triangulation, annulus, cylinder, disc, outline, rectangle, sphere_cap};
use thinshell::mesh::{Mesh, MeshField, Topology};

const DISC: Onto = Onto::Disc { radius: 1.5 };

fn edges(mesh: &Mesh) -> Vec<[usize; 2]> {
    Topology::new(&mesh.faces).edges
}

fn is_boundary(mesh: &Mesh) -> Vec<bool> {
    let topology = Topology::new(&mesh.faces);
    let mut on = vec![false; mesh.vertices.len()];
    (0..topology.edges.len()).filter(|&e| topology.is_boundary(e)).for_each(|e| topology.edges[e].iter().for_each(|&v| on[v] = true));
    on
}

/// Rates of errors on meshes each twice as fine as the one before.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|w| (w[0] / w[1]).log2()).collect()
}

fn assert_order(what: &str, errors: &[f64], least: f64) {
    println!("{what}: {errors:?}, orders {:.2?}", orders(errors));
    assert!(orders(errors).iter().all(|&order| order >= least), "{what}: {errors:?} has orders {:?}", orders(errors));
}

/// Singular values of the map of each face from space to the plane, larger first.
fn stretches(mesh: &Mesh, flat: &Flattened) -> Vec<[f64; 2]> {
    let of = |face: &[usize; 3]| {
        let [a, b, c] = face.map(|v| mesh.vertices[v]);
        let (u, v) = (b - a, c - a);
        let first = u.normalize();
        let second = u.cross(&v).cross(&u).normalize();
        let from = Matrix2::new(u.norm(), v.dot(&first), 0.0, v.dot(&second));
        let [a, b, c] = face.map(|v| flat.nodes[v]);
        let to = Matrix2::from_columns(&[b - a, c - a]);
        let values = (to * from.try_inverse().unwrap()).singular_values();
        [values.max(), values.min()]
    };
    mesh.faces.iter().map(of).collect()
}

fn area(mesh: &Mesh, face: &[usize; 3]) -> f64 {
    let [a, b, c] = face.map(|v| mesh.vertices[v]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// Mean over the area of the ratio of the stretches less 1: 0 for a conformal map.
fn quasi_conformal_error(mesh: &Mesh, flat: &Flattened) -> f64 {
    let total: f64 = mesh.faces.iter().map(|f| area(mesh, f)).sum();
    mesh.faces.iter().zip(stretches(mesh, flat)).map(|(f, [most, least])| area(mesh, f) * (most / least - 1.0)).sum::<f64>() / total
}

/// Mean over all corners of the change of a face's angle [rad].
fn angle_distortion(mesh: &Mesh, flat: &Flattened) -> f64 {
    let plane: Vec<Vector3<f64>> = flat.nodes.iter().map(|p| Vector3::new(p.x, p.y, 0.0)).collect();
    let angle = |p: &[Vector3<f64>], [a, b, c]: [usize; 3]| (p[b] - p[a]).angle(&(p[c] - p[a]));
    let corners = || mesh.faces.iter().flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]);
    corners().map(|corner| (angle(&mesh.vertices, corner) - angle(&plane, corner)).abs()).sum::<f64>() / corners().count() as f64
}

/// Largest miss of `e^((s_i + s_j) / 2)` against the ratio of lengths of the edges whose ends meet the condition.
fn length_error(mesh: &Mesh, flat: &Flattened, inside: impl Fn(&Vector3<f64>) -> bool) -> f64 {
    let of = |[a, b]: [usize; 2]| {
        let ratio = (mesh.vertices[a] - mesh.vertices[b]).norm() / (flat.nodes[a] - flat.nodes[b]).norm();
        ((0.5 * (flat.log_scale[a] + flat.log_scale[b])).exp() / ratio - 1.0).abs()
    };
    edges(mesh).into_iter().filter(|e| e.iter().all(|&v| inside(&mesh.vertices[v]))).map(of).fold(0.0, f64::max)
}

#[test]
fn spherical_cap_becomes_its_stereographic_projection() {
    let (radius, half) = (2.0, 70f64.to_radians());
    let (mut scale, mut place, mut length) = (vec![], vec![], vec![]);
    for rings in [8, 16, 32] {
        let mesh = sphere_cap(radius, half.to_degrees(), rings).unwrap();
        let flat = flatten(&mesh, DISC).unwrap();
        let (mut off_scale, mut off_place) = (0f64, 0f64);
        for (v, p) in mesh.vertices.iter().enumerate() {
            let t = (p.z / radius).clamp(-1.0, 1.0).acos();
            let exact = (2.0 * radius * (0.5 * half).tan() * (0.5 * t).cos().powi(2) / 1.5).ln();
            off_scale = off_scale.max((flat.log_scale[v] - exact).abs());
            let r = 1.5 * (0.5 * t).tan() / (0.5 * half).tan();
            let exact = p.xy().try_normalize(1e-12).unwrap_or_default() * r;
            off_place = off_place.max((flat.nodes[v] - exact).norm());
        }
        scale.push(off_scale);
        place.push(off_place);
        length.push(length_error(&mesh, &flat, |_| true));
    }
    assert_order("log scale", &scale, 1.7);
    assert_order("places", &place, 1.7);
    assert_order("lengths", &length, 1.7);
}

fn ellipse(rings: usize) -> Mesh {
    let mut mesh = disc(1.0, rings).unwrap();
    mesh.vertices.iter_mut().for_each(|p| p.x *= 1.6);
    mesh
}

#[test]
fn flat_ellipse_and_square_onto_the_disc() {
    let inside = |p: &Vector3<f64>| (p.x / 1.6).hypot(p.y) < 0.75;
    let of = |mesh: Mesh| {
        let flat = flatten(&mesh, DISC).unwrap();
        for (v, on) in is_boundary(&mesh).into_iter().enumerate() {
            let r = flat.nodes[v].norm();
            assert!(if on { (r - 1.5).abs() < 1e-14 } else { r < 1.5 }, "vertex {v} at {r}");
        }
        let errors = [quasi_conformal_error(&mesh, &flat), angle_distortion(&mesh, &flat), length_error(&mesh, &flat, inside)];
        // Symmetric shapes keep their centre and their axes.
        assert!(flat.nodes.iter().sum::<Vector2<f64>>().norm() < 0.05 * flat.nodes.len() as f64);
        errors
    };
    let ellipses = [8, 16, 32].map(|rings| of(ellipse(rings)));
    assert_order("ellipse, lengths inside", &ellipses.map(|e| e[2]), 1.7);
    assert_order("ellipse, ratio of stretches", &ellipses.map(|e| e[0]), 0.9);
    assert_order("ellipse, angles", &ellipses.map(|e| e[1]), 0.9);
    // The corners, where the map is not smooth, take part.
    let squares = [8, 16, 32].map(|n| of(rectangle([2.0, 2.0], [n, n], Pattern::CrissCross, 0.1, 3).unwrap()));
    assert_order("square, ratio of stretches", &squares.map(|e| e[0]), 0.8);
    assert_order("square, angles", &squares.map(|e| e[1]), 0.8);
}

#[test]
fn stretches_agree_with_the_scale() {
    let mesh = ellipse(32);
    let flat = flatten(&mesh, DISC).unwrap();
    for (face, [most, least]) in mesh.faces.iter().zip(stretches(&mesh, &flat)) {
        let s = face.iter().map(|&v| flat.log_scale[v]).sum::<f64>() / 3.0;
        assert!((most * s.exp() - 1.0).abs() < 0.15 && (least * s.exp() - 1.0).abs() < 0.15, "{most} {least} {}", s.exp());
    }
    // Twice the disc, half the metric.
    let double = flatten(&mesh, Onto::Disc { radius: 3.0 }).unwrap();
    let shift = flat.log_scale.iter().zip(&double.log_scale).map(|(a, b)| (a - b - 2f64.ln()).abs()).fold(0.0, f64::max);
    assert!(shift < 1e-10, "{shift}");
}

#[test]
fn flat_meshes_keep_their_shape_on_the_natural_boundary() {
    let flat_mesh = rectangle([3.0, 1.0], [12, 5], Pattern::Alternating, 0.3, 5).unwrap();
    let turned = |axis: Vector3<f64>| {
        let turn = Rotation3::new(axis);
        Mesh { vertices: flat_mesh.vertices.iter().map(|p| turn * p + Vector3::new(5.0, -3.0, 2.0)).collect(), ..flat_mesh.clone() }
    };
    for mesh in [flat_mesh.clone(), turned(Vector3::new(0.3, 1.1, -0.4)), turned(Vector3::new(PI, 0.0, 0.0))] {
        let flat = flatten(&mesh, Onto::Natural).unwrap();
        assert!(flat.log_scale.iter().all(|s| s.abs() < 1e-12), "{:?}", flat.log_scale);
        for [a, b] in edges(&mesh) {
            let (space, plane) = ((mesh.vertices[a] - mesh.vertices[b]).norm(), (flat.nodes[a] - flat.nodes[b]).norm());
            assert!((space / plane - 1.0).abs() < 1e-11, "{space} {plane}");
        }
        // Distances between any two vertices: no piece is turned against the others.
        for (p, q) in mesh.vertices.iter().zip(&flat.nodes) {
            assert!(((p - mesh.vertices[7]).norm() - (q - flat.nodes[7]).norm()).abs() < 1e-11);
        }
    }
    // In the xy plane it is only shifted.
    let flat = flatten(&flat_mesh, Onto::Natural).unwrap();
    let shift = flat.nodes[0] - flat_mesh.vertices[0].xy();
    assert!(flat_mesh.vertices.iter().zip(&flat.nodes).all(|(p, q)| (q - p.xy() - shift).norm() < 1e-11));
}

#[test]
fn half_cylinder_is_unrolled() {
    let mesh = cylinder(0.5, 2.0, 180.0, [14, 6], Pattern::Diagonal).unwrap();
    let flat = flatten(&mesh, Onto::Natural).unwrap();
    assert!(flat.log_scale.iter().all(|s| s.abs() < 1e-12));
    for [a, b] in edges(&mesh) {
        let (space, plane) = ((mesh.vertices[a] - mesh.vertices[b]).norm(), (flat.nodes[a] - flat.nodes[b]).norm());
        assert!((space / plane - 1.0).abs() < 1e-11, "{space} {plane}");
    }
    // The image is a rectangle, not only faces that fit together: its sides and diagonals, whichever way it is turned.
    let arc = 14.0 * (PI / 28.0).sin();
    let corners: Vec<usize> = (0..mesh.vertices.len())
        .filter(|&v| mesh.vertices[v].y.abs() < 1e-9 && (mesh.vertices[v].z.abs() < 1e-9 || (mesh.vertices[v].z - 2.0).abs() < 1e-9))
        .collect();
    assert_eq!(corners.len(), 4);
    let mut distances: Vec<f64> =
        (0..4).flat_map(|i| (0..i).map(move |j| [i, j])).map(|[i, j]| (flat.nodes[corners[i]] - flat.nodes[corners[j]]).norm()).collect();
    distances.sort_by(f64::total_cmp);
    for (d, exact) in distances.iter().zip([arc, arc, 2.0, 2.0, arc.hypot(2.0), arc.hypot(2.0)]) {
        assert!((d - exact).abs() < 1e-10, "{distances:?} {arc}");
    }
}

#[test]
fn shallow_cap_on_its_natural_boundary() {
    // By symmetry the map is the stereographic one with s = 0 at the rim.
    let half = 40f64.to_radians();
    let errors = [8, 16, 32].map(|rings| {
        let mesh = sphere_cap(1.0, half.to_degrees(), rings).unwrap();
        let flat = flatten(&mesh, Onto::Natural).unwrap();
        let exact = |p: &Vector3<f64>| 2.0 * ((0.5 * p.z.min(1.0).acos()).cos() / (0.5 * half).cos()).ln();
        let off = mesh.vertices.iter().zip(&flat.log_scale).map(|(p, s)| (s - exact(p)).abs()).fold(0.0, f64::max);
        let rim = mesh.vertices.iter().zip(&flat.nodes).map(|(p, q)| {
            let r = half.sin() * (0.5 * p.z.min(1.0).acos()).tan() / (0.5 * half).tan();
            (q.norm() - r).abs()
        });
        [off, rim.fold(0.0, f64::max)]
    });
    assert_order("log scale", &errors.map(|e| e[0]), 1.7);
    assert_order("places", &errors.map(|e| e[1]), 1.7);
}

#[test]
fn one_cell_and_slender_shapes() {
    // No vertex inside: the boundary carries the map.
    for mesh in [
        rectangle([1.0, 1.0], [1, 1], Pattern::Diagonal, 0.0, 0).unwrap(),
        rectangle([3.0, 1.0], [3, 1], Pattern::Diagonal, 0.0, 0).unwrap(),
    ] {
        for onto in [DISC, Onto::Natural] {
            flatten(&mesh, onto).unwrap();
        }
    }
    // Behind a neck images shrink by `e^(-pi length/width)`, so meshes must resolve the width.
    let slender = [2, 4, 8].map(|n| {
        let mesh = outline(
            "slender",
            &[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]],
            &[],
            Triangulation { size: 0.3 / n as f64, min_angle: 25.0 },
        )
        .unwrap();
        quasi_conformal_error(&mesh, &flatten(&mesh, DISC).unwrap())
    });
    assert_order("slender, ratio of stretches", &slender, 0.8);
}

fn refused(mesh: &Mesh, onto: Onto, parts: &[&str]) {
    let error = flatten(mesh, onto).expect_err("must be refused");
    assert_eq!(error.exit_code(), 2);
    let message = error.to_string();
    assert!(parts.iter().all(|part| message.contains(part)), "{parts:?} are missing in: {message}");
}

#[test]
fn what_is_no_disc_is_refused() {
    let ring = annulus([0.5, 1.0], [2, 12], false, Pattern::Diagonal).unwrap();
    refused(&ring, DISC, &["flatten", "2 boundaries", "Euler characteristic 0"]);
    let square = rectangle([1.0, 1.0], [2, 2], Pattern::Diagonal, 0.0, 0).unwrap();
    let n = square.vertices.len();
    let mut parts = square.clone();
    parts.vertices.extend(square.vertices.iter().map(|p| p + Vector3::x() * 2.0));
    parts.faces.extend(square.faces.iter().map(|f| f.map(|v| v + n)));
    refused(&parts, DISC, &["2 parts"]);
    // Joined at one corner: one part, one boundary, Euler characteristic 1.
    let last = square.vertices.iter().position(|p| p.x == 1.0 && p.y == 1.0).unwrap();
    let mut joined = square.clone();
    joined.vertices.extend(square.vertices[1..].iter().map(|p| p + Vector3::new(1.0, 1.0, 0.0)));
    joined.faces.extend(square.faces.iter().map(|f| f.map(|v| if v == 0 { last } else { v + n - 1 })));
    refused(&joined, DISC, &[&format!("at vertex {last} faces touch")]);
    let tetrahedron = Mesh {
        vertices: vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()],
        faces: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        ..Mesh::default()
    };
    refused(&tetrahedron, Onto::Natural, &["0 boundaries"]);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&square, Onto::Disc { radius }, &["flatten.radius", "must be > 0"]);
    }
    let mut named = square.clone();
    named.fields.insert("conformal_factor".into(), MeshField::default());
    assert!(named.clone().flatten(DISC).unwrap_err().to_string().contains("`conformal_factor` already"));
    // Two squares joined by a strip of 1 by 0.02: the far one would be of size e^(-50 pi).
    let dumbbell = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 0.49],
        [2.0, 0.49],
        [2.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [2.0, 1.0],
        [2.0, 0.51],
        [1.0, 0.51],
        [1.0, 1.0],
        [0.0, 1.0],
    ];
    let dumbbell = outline("dumbbell", &dumbbell, &[], Triangulation { size: 0.05, min_angle: 25.0 }).unwrap();
    refused(&dumbbell, DISC, &["flatten", "without area in the plane, first face"]);
}

/// A scene on a cap, with its table `[flatten]` or none.
fn cap(element: &str, flatten: &str) -> String {
    format!(
        "[mesh.sphere-cap]\nradius = 1.0\nhalf_angle = 80.0\nrings = 6\n{flatten}\n[[region]]\nname = \"core\"\nwhere = \"r < 0.3\"\n\
         [[region]]\nname = \"edge\"\nnearest = [0.7, 0, 0]\n[shell]\nelement = \"{element}\"\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n[[pin]]\n\
         region = \"rim\"\n[statics]\nsteps = 1\n"
    )
}

fn mesh_of(sandbox: &Sandbox) -> Mesh {
    let path = sandbox.case("mesh.h5");
    case::mesh_from_archive(&Archive::read(&path, Kind::Mesh).unwrap(), &path).unwrap()
}

#[test]
fn scenes_flatten_their_mesh() {
    let table = "[flatten]\nonto = \"disc\"\nradius = 0.7";
    let sandbox = Sandbox::new(&cap("quadratic", table));
    let (said, _) = sandbox.ok(&["check", "scene.toml"]);
    assert!(said.contains("flatten   disc, lengths were"), "{said}");
    sandbox.ok(&["all", "scene.toml"]);
    let mesh = mesh_of(&sandbox);
    let original = sphere_cap(1.0, 80.0, 6).unwrap();
    assert_eq!((&mesh.faces, &mesh.regions["rim"]), (&original.faces, &original.regions["rim"]));
    assert!(mesh.nodes().iter().all(|p| p.z == 0.0));
    for [a, b, c] in &mesh.faces {
        assert!((mesh.vertices[*b] - mesh.vertices[*a]).cross(&(mesh.vertices[*c] - mesh.vertices[*a])).z > 0.0);
    }
    let (n, factor, position) = (mesh.vertices.len(), &mesh.fields["conformal_factor"], &mesh.fields["original_position"]);
    assert_eq!((factor.data.len(), position.data.len()), (mesh.nodes().len(), 3 * mesh.nodes().len()));
    let topology = Topology::new(&mesh.faces);
    for e in 0..topology.edges.len() {
        if topology.is_boundary(e) {
            assert!((mesh.midpoints[e].norm() - 0.7).abs() < 1e-14);
        }
        // The midpoints of the cap lie on the sphere, not on its chords.
        assert!((Vector3::from_column_slice(position.entry(n + e).unwrap()).norm() - 1.0).abs() < 1e-14);
    }
    // Midpoints are part of the map: they are as near to the stereographic projection as vertices are, and so is their factor.
    let half = 80f64.to_radians();
    let miss = |nodes: std::ops::Range<usize>| {
        let of = |k: usize| {
            let t = position.entry(k).unwrap()[2].clamp(-1.0, 1.0).acos();
            let r = (mesh.nodes()[k].norm() - 0.7 * (0.5 * t).tan() / (0.5 * half).tan()).abs();
            r.max((factor.data[k] - (2.0 * (0.5 * half).tan() * (0.5 * t).cos().powi(2) / 0.7).ln()).abs())
        };
        nodes.map(of).fold(0.0, f64::max)
    };
    let (vertices, midpoints) = (miss(0..n), miss(n..mesh.nodes().len()));
    println!("largest miss at vertices {vertices:.2e}, at midpoints {midpoints:.2e}");
    assert!(vertices < 0.01 && midpoints < 0.01);
    for (v, p) in original.vertices.iter().enumerate() {
        assert_eq!(position.entry(v).unwrap(), p.as_slice());
    }
    let core = &mesh.regions["core"].vertices;
    assert!(!core.is_empty() && (0..n).all(|v| core.contains(&v) == (mesh.vertices[v].norm() < 0.3)));
    assert!((mesh.vertices[mesh.regions["edge"].vertices[0]] - Vector3::x() * 0.7).norm() < 0.1);
    let frame = sandbox.case("vtk").join(sandbox.newest().0.replace("h5", "vtu"));
    let (exported, _) = thinshell::mesh::import::read(&frame, 1.0).unwrap();
    assert_eq!((&exported.fields["conformal_factor"], &exported.fields["original_position"]), (factor, position));
    let units: serde_json::Value = serde_json::from_slice(&std::fs::read(sandbox.case("vtk/units.json")).unwrap()).unwrap();
    assert_eq!((&units["conformal_factor"], &units["original_position"]), (&"1".into(), &"m".into()));

    // Another radius is another mesh; without one the disc has the area of the cap.
    sandbox.rewrite(&cap("quadratic", "[flatten]\nonto = \"disc\""));
    assert!(sandbox.fails(2, &["setup", "scene.toml"]).contains("other inputs"));
    sandbox.ok(&["mesh", "scene.toml"]);
    let radius = mesh_of(&sandbox).vertices.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let total: f64 = original.faces.iter().map(|f| area(&original, f)).sum();
    assert!((PI * radius * radius / total - 1.0).abs() < 1e-12);
    sandbox.rewrite(&cap("linear", "[flatten]\nonto = \"natural\""));
    sandbox.ok(&["mesh", "scene.toml"]);
    let natural = mesh_of(&sandbox);
    assert!(natural.midpoints.is_empty() && natural.fields["original_position"].data.len() == 3 * n);
}

#[test]
fn without_the_table_nothing_is_left_of_it() {
    let sandbox = Sandbox::new(&cap("linear", ""));
    let output = sandbox.output(&["all", "scene.toml", "-vv"]);
    let log = text(&output.stderr) + &text(&output.stdout) + &sandbox.ok(&["check", "scene.toml"]).0;
    assert_eq!(output.status.code(), Some(0), "{log}");
    assert!(!log.contains("flatten"), "{log}");
    assert!(mesh_of(&sandbox).fields.is_empty());
    let record = std::fs::read_to_string(sandbox.case("case.toml")).unwrap();
    assert!(!record.contains("flatten"), "{record}");
    let frame = text(&std::fs::read(sandbox.case("vtk").join(sandbox.newest().0.replace("h5", "vtp"))).unwrap());
    assert!(!frame.contains("conformal") && !frame.contains("original_position"));
}

#[test]
fn scenes_that_cannot_be_flattened() {
    for (scene, part) in [
        (cap("linear", "[flatten]\nonto = \"natural\"\nradius = 1.0"), "needs `onto = \"disc\"`"),
        (cap("linear", "[flatten]\nonto = \"disc\"\nradius = -1.0"), "must be > 0 [m]"),
        (cap("linear", "[flatten]\nonto = \"square\""), "`square` is not a choice here"),
        (cap("linear", "[flatten]\n"), "flatten.onto: this key is missing"),
        (cap("linear", "[flatten]\nonto = \"disc\"").replace("half_angle = 80.0", "half_angle = 80.0 # cap"), ""),
    ] {
        let sandbox = Sandbox::new(&scene);
        if part.is_empty() {
            sandbox.ok(&["mesh", "scene.toml"]);
            continue;
        }
        let error = sandbox.fails(2, &["mesh", "scene.toml"]);
        assert!(error.contains(part), "`{part}` is missing in: {error}");
    }
    // Faces alone in a corner are told.
    let square = cap("linear", "[flatten]\nonto = \"disc\"")
        .replace("[mesh.sphere-cap]\nradius = 1.0\nhalf_angle = 80.0\nrings = 6", "[mesh.rectangle]\nsize = [1, 1]\ncells = [4, 4]");
    let (_, said) = Sandbox::new(&square).ok(&["mesh", "scene.toml"]);
    assert!(said.contains("2 faces have two sides on the boundary"), "{said}");
    // A tent whose top is next to one of its three corners: that corner stands for nearly all of it.
    let shell = "[shell]\nelement = \"linear\"\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n[statics]\nsteps = 1\n";
    let tent = Sandbox::new(&format!("[mesh.file]\npath = \"tent.obj\"\n[flatten]\nonto = \"disc\"\n{shell}"));
    let corners = "v 0 0 0\nv 1 -0.01 0\nv 1 0.01 0\nv 0.1 0 0.05\n";
    std::fs::write(tent.path("tent.obj"), format!("{corners}f 1 2 4\nf 2 3 4\nf 3 1 4\n")).unwrap();
    let error = tent.fails(2, &["mesh", "scene.toml"]);
    let (start, middle) = ("flatten: the boundary vertex at (0.0000e0, 0.0000e0, 0.0000e0) m has ", " % of the weight in the mean");
    assert!(error.contains(start) && error.contains(middle) && error.contains("half or more"), "{error}");
    let ring = "[mesh.annulus]\nradii = [0.5, 1.0]\ncells = [2, 12]\n[flatten]\nonto = \"disc\"\n[shell]\nthickness = 0.01\nyoungs_modulus = 1e6\n\
                poissons_ratio = 0.3\n[statics]\nsteps = 1\n";
    let error = Sandbox::new(ring).fails(2, &["mesh", "scene.toml"]);
    assert!(error.contains("flatten") && error.contains("2 boundaries"), "{error}");
}

/// The outline of the contiguous states on a disc, which then grows back by the factor of the map.
fn states(element: &str, size: f64) -> String {
    let scene = include_str!("../../configs/analytic/us_outline.toml");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/data/outline/contiguous_us.csv");
    let scene = with(scene, "../../data/outline/contiguous_us.csv", file);
    let scene = with(&scene, "size = 0.03", &format!("size = {size}"));
    with(&scene, "\"quadratic\"", &format!("{element:?}"))
}

#[test]
fn contiguous_states_become_a_disc() {
    let sandbox = Sandbox::new(&states("linear", 0.04));
    sandbox.ok(&["mesh", "scene.toml"]);
    let mesh = mesh_of(&sandbox);
    let original: Vec<Vector3<f64>> = mesh.fields["original_position"].data.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let shape = Mesh { vertices: original, ..mesh.clone() };
    let total: f64 = shape.faces.iter().map(|f| area(&shape, f)).sum();
    assert!((total / PI - 1.0).abs() < 1e-5, "{total}");
    let flat =
        Flattened { nodes: mesh.vertices.iter().map(Vector3::xy).collect(), log_scale: mesh.fields["conformal_factor"].data.clone() };
    for (v, on) in is_boundary(&mesh).into_iter().enumerate() {
        let r = flat.nodes[v].norm();
        assert!(if on { (r - 1.0).abs() < 1e-5 } else { r < 1.0 }, "vertex {v} at {r}");
    }
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| flat.nodes[v]);
        assert!((b - a).perp(&(c - a)) > 0.0);
    }
    // Florida and Maine are shrunk enormously.
    assert!(flat.log_scale.iter().copied().fold(f64::MIN, f64::max) > 10.0);
    let (ratio, length) = (quasi_conformal_error(&shape, &flat), length_error(&shape, &flat, |p| p.norm() < 0.45));
    println!("{} faces, ratio of stretches {ratio:.3}, lengths {length:.3}", mesh.faces.len());
    assert!(ratio < 0.15 && length < 0.02, "{ratio} {length}");
}

/// Lets the mesh of a scene grow; the root of the mean square of the distance of its nodes to their original places after the best turn [m].
fn miss_after_growth(scene: &str) -> f64 {
    let sandbox = Sandbox::new(scene);
    sandbox.ok(&["all", "scene.toml"]);
    let position = &mesh_of(&sandbox).fields["original_position"];
    let original: Vec<Vector3<f64>> = position.data.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let name = sandbox.newest().0;
    let frame = ["vtp", "vtu"].map(|ending| sandbox.case("vtk").join(name.replace("h5", ending))).into_iter().find(|path| path.exists());
    let grown = thinshell::mesh::import::read(&frame.unwrap(), 1.0).unwrap().0.nodes();
    assert_eq!(grown.len(), original.len());
    assert!(grown.iter().all(|p| p.z.abs() < 1e-6));
    let centred = |points: &[Vector3<f64>]| {
        let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        points.iter().map(|p| (p - mean).xy()).collect::<Vec<_>>()
    };
    let (p, q) = (centred(&grown), centred(&original));
    let (dot, cross): (f64, f64) = p.iter().zip(&q).fold((0.0, 0.0), |(d, c), (p, q)| (d + p.dot(q), c + p.perp(q)));
    let turn = Rotation2::new(cross.atan2(dot));
    (p.iter().zip(&q).map(|(p, q)| (turn * p - q).norm_squared()).sum::<f64>() / p.len() as f64).sqrt()
}

#[test]
fn discs_grow_into_the_contiguous_states() {
    let misses = [0.04, 0.025].map(|size| miss_after_growth(&with(&states("linear", size), "steps = 10", "steps = 6")));
    println!("contiguous states: {misses:?}");
    assert!(misses[1] < 0.0055 && misses[1] < 0.75 * misses[0], "{misses:?}");
}

#[test]
fn discs_grow_into_ellipses() {
    let points: Vec<[f64; 2]> = (0..48).map(|k| TAU * f64::from(k) / 48.0).map(|t| [1.6 * t.cos(), t.sin()]).collect();
    for (element, least) in [("linear", 1.5), ("quadratic", 1.4)] {
        let misses = [0.24, 0.12, 0.06].map(|size| {
            let scene = with(&states(element, size), "file = ", &format!("points = {points:?} # "));
            miss_after_growth(&with(&scene, "steps = 10", "steps = 2"))
        });
        assert_order(&format!("ellipse, {element}"), &misses, least);
    }
}

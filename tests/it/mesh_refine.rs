//! Faces split into four: what a mesh was it stays, only finer; its regions and fields come along; ladders of such meshes.

use crate::mesh_files::{self, sample};
use crate::pipeline_support::{Sandbox, with};
use nalgebra::Vector3;
use serde_json::Value;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use thinshell::mesh::generate::{Pattern, Triangulation, annulus, cylinder, disc, outline, rectangle, rectangle_delaunay, sphere_cap};
use thinshell::mesh::midpoints::{self, Surface};
use thinshell::mesh::{FieldOn, Mesh, MeshField, Quality, Region, Topology, refine, validate};

fn refined(mesh: &Mesh, times: usize, surface: Surface) -> Mesh {
    let mut fine = mesh.clone();
    refine(&mut fine, times, surface).unwrap();
    assert_eq!(fine.faces.len(), mesh.faces.len() * 4usize.pow(times as u32));
    let before = fine.clone();
    assert_eq!(validate::check(&mut fine, "refined").unwrap(), Vec::<String>::new());
    assert!(fine == before, "the check mends nothing");
    let (coarse, now) = (Quality::of(mesh), Quality::of(&fine));
    assert_eq!(
        (now.components, now.boundary_loops, now.euler_characteristic, now.boundary_edges),
        (coarse.components, coarse.boundary_loops, coarse.euler_characteristic, coarse.boundary_edges << times)
    );
    fine
}

/// Places as whole numbers of a small length, so that they can be compared whatever their order.
fn places(mesh: &Mesh, vertices: &[usize]) -> BTreeSet<[i64; 3]> {
    vertices.iter().map(|&v| std::array::from_fn(|k| (1e9 * mesh.vertices[v][k]).round() as i64)).collect()
}

#[test]
fn structured_meshes_become_those_of_smaller_cells() {
    let pairs = [
        (
            rectangle([3.0, 2.0], [3, 2], Pattern::Diagonal, 0.0, 0),
            rectangle([3.0, 2.0], [12, 8], Pattern::Diagonal, 0.0, 0),
            Surface::Plane,
        ),
        (annulus([1.0, 2.0], [2, 7], false, Pattern::Diagonal), annulus([1.0, 2.0], [8, 28], false, Pattern::Diagonal), Surface::Annulus),
        (annulus([1.0, 2.0], [2, 7], true, Pattern::Diagonal), annulus([1.0, 2.0], [8, 28], true, Pattern::Diagonal), Surface::Annulus),
        (
            cylinder(2.0, 3.0, 360.0, [5, 2], Pattern::Diagonal),
            cylinder(2.0, 3.0, 360.0, [20, 8], Pattern::Diagonal),
            Surface::Cylinder { radius: 2.0 },
        ),
        (
            cylinder(2.0, 3.0, 100.0, [5, 2], Pattern::Diagonal),
            cylinder(2.0, 3.0, 100.0, [20, 8], Pattern::Diagonal),
            Surface::Cylinder { radius: 2.0 },
        ),
    ];
    for (coarse, expected, surface) in pairs {
        let (coarse, expected) = (coarse.unwrap(), expected.unwrap());
        let fine = refined(&coarse, 2, surface);
        let all = |mesh: &Mesh| (0..mesh.vertices.len()).collect::<Vec<_>>();
        assert_eq!(places(&fine, &all(&fine)), places(&expected, &all(&expected)));
        let centroids = |mesh: &Mesh| {
            let of = |face: &[usize; 3]| face.iter().map(|&v| mesh.vertices[v]).sum::<Vector3<f64>>() / 3.0;
            mesh.faces.iter().map(|face| std::array::from_fn::<i64, 3, _>(|k| (1e9 * of(face)[k]).round() as i64)).collect::<BTreeSet<_>>()
        };
        assert_eq!(centroids(&fine), centroids(&expected));
        assert!(!expected.regions.is_empty() && fine.regions.keys().eq(expected.regions.keys()));
        for (name, region) in &expected.regions {
            let (found, ends) = (&fine.regions[name], |mesh: &Mesh, edges: &[[usize; 2]]| {
                edges.iter().map(|edge| places(mesh, edge)).collect::<BTreeSet<_>>()
            });
            assert_eq!(found.vertices.len(), region.vertices.len(), "{name}");
            assert_eq!(places(&fine, &found.vertices), places(&expected, &region.vertices), "{name}");
            assert_eq!(ends(&fine, &found.edges), ends(&expected, &region.edges), "{name}");
        }
    }
}

#[test]
fn round_boundaries_become_rounder() {
    for times in [1, 3] {
        let fine = refined(&disc(0.3, 2).unwrap(), times, Surface::Disc { radius: 0.3 });
        let count = 12 << times;
        // The area of a regular polygon: its corners lie on the circle, evenly.
        let exact = 0.5 * count as f64 * 0.09 * (2.0 * PI / count as f64).sin();
        assert!((Quality::of(&fine).total_area / exact - 1.0).abs() < 1e-12);
        assert_eq!((fine.regions["rim"].vertices.len(), fine.regions["rim"].edges.len()), (count, count));
        assert_eq!(fine.regions["center"], Region::new([0], [], []));

        let angle = 70f64.to_radians();
        let fine = refined(&sphere_cap(0.5, 70.0, 3).unwrap(), times, Surface::Sphere { radius: 0.5 });
        assert!(fine.vertices.iter().all(|p| (p.norm() - 0.5).abs() < 1e-14));
        let rim = &fine.regions["rim"].vertices;
        assert_eq!(rim.len(), 18 << times);
        assert!(rim.iter().all(|&v| (fine.vertices[v].z - 0.5 * angle.cos()).abs() < 1e-14));
        let coarse = (Quality::of(&sphere_cap(0.5, 70.0, 3).unwrap()).total_area / (0.5 * PI * (1.0 - angle.cos())) - 1.0).abs();
        let error = (Quality::of(&fine).total_area / (0.5 * PI * (1.0 - angle.cos())) - 1.0).abs();
        assert!(error < 1.1 * coarse / 4f64.powi(times as i32), "{error} of {coarse}");
    }
}

#[test]
fn irregular_faces_are_similar_to_those_they_came_from() {
    let triangulation = Triangulation { size: 0.3, min_angle: 25.0 };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let hole = vec![vec![[0.3, 0.3], [0.6, 0.3], [0.4, 0.6]]];
    for mesh in [
        rectangle([2.0, 1.0], [4, 3], Pattern::Diagonal, 0.3, 5),
        rectangle_delaunay([2.0, 1.0], [4, 3], None, 5),
        outline("points", &square, &hole, triangulation),
    ] {
        let mesh = mesh.unwrap();
        let fine = refined(&mesh, 2, Surface::Plane);
        let sides = |mesh: &Mesh, face: &[usize; 3]| {
            let mut sides: [f64; 3] = std::array::from_fn(|i| (mesh.vertices[face[i]] - mesh.vertices[face[(i + 1) % 3]]).norm());
            sides.sort_by(f64::total_cmp);
            sides
        };
        for (f, face) in fine.faces.iter().enumerate() {
            let (part, whole) = (sides(&fine, face), sides(&mesh, &mesh.faces[f / 16]));
            assert!((0..3).all(|i| (4.0 * part[i] / whole[i] - 1.0).abs() < 1e-12), "{part:?} of {whole:?}");
        }
        assert!((Quality::of(&fine).total_area / Quality::of(&mesh).total_area - 1.0).abs() < 1e-12);
        // A boundary edge has four parts; one of the outline belongs to its region.
        for (name, region) in &mesh.regions {
            assert_eq!(fine.regions[name].edges.len(), 4 * region.edges.len(), "{name}");
            assert_eq!(fine.regions[name].vertices.len(), region.vertices.len() + 3 * region.edges.len(), "{name}");
        }
    }
}

#[test]
fn regions_get_the_parts_of_what_they_had() {
    let mut mesh = rectangle([2.0, 1.0], [2, 1], Pattern::Diagonal, 0.0, 0).unwrap();
    let of_cell = mesh.region_where(|p| p.x < 1.1);
    let [a, b, c] = mesh.faces[0];
    mesh.regions = [
        ("cell".to_owned(), of_cell.clone()),
        ("face without sides".to_owned(), Region::new([a], [], [0])),
        ("two sides".to_owned(), Region::new([a, b, c], [[a, b], [b, c]], [0])),
        ("vertices".to_owned(), Region::new([a, b], [], [])),
        ("empty".to_owned(), Region::default()),
    ]
    .into();
    let fine = refined(&mesh, 1, Surface::Plane);
    let cell = &fine.regions["cell"];
    // What the condition of the region finds on the finer mesh, whose edges are half as long.
    assert_eq!(*cell, fine.region_where(|p| p.x < 1.1));
    assert_eq!((cell.vertices.len(), cell.edges.len(), cell.faces.len()), (9, 16, 8));
    assert_eq!(fine.regions["face without sides"], Region::new([a], [], [0, 1, 2, 3]));
    let two = &fine.regions["two sides"];
    assert_eq!((two.vertices.len(), two.edges.len(), two.faces.len()), (5, 4, 4));
    assert_eq!(fine.regions["vertices"], mesh.regions["vertices"]);
    assert_eq!(fine.regions["empty"], Region::default());
}

/// A function of the place on the reference triangle of each face, as a field of the nodes, and the number of the face.
fn numbered(mut mesh: Mesh) -> Mesh {
    let data = mesh.nodes().iter().flat_map(|p| [p.x, p.y, p.z, p.x - 3.0 * p.y * p.z + 1.0]).collect();
    mesh.fields.insert("wind".into(), MeshField { on: FieldOn::Nodes, components: 4, data });
    let data = (0..mesh.faces.len()).flat_map(|f| [f as f64, -1.0]).collect();
    mesh.fields.insert("grain".into(), MeshField { on: FieldOn::Faces, components: 2, data });
    mesh
}

#[test]
fn fields_and_curved_faces_stay_what_they_are() {
    let straight = numbered(sample());
    let mut curved = sample();
    midpoints::place(&mut curved, Surface::Plane);
    for (e, m) in curved.midpoints.iter_mut().enumerate() {
        *m += Vector3::new((e % 3) as f64, (e % 4) as f64, (e % 5) as f64) / 64.0;
    }
    let curved = numbered(curved);
    // Places of the corners of the parts: at the corners of the face, and the one in the middle, which is turned around.
    let parts = [
        [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]],
        [[0.5, 0.0], [1.0, 0.0], [0.5, 0.5]],
        [[0.0, 0.5], [0.5, 0.5], [0.0, 1.0]],
        [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]],
    ];
    for mesh in [straight, curved] {
        let fine = refined(&mesh, 1, Surface::Plane);
        assert_eq!(fine.midpoints.is_empty(), mesh.midpoints.is_empty());
        let (wind, was) = (fine.field_sampler("wind").unwrap(), mesh.field_sampler("wind").unwrap());
        for f in 0..fine.faces.len() {
            assert_eq!(fine.field_at("grain", f, [0.3, 0.3]), mesh.field_at("grain", f / 4, [0.3, 0.3]));
            for [x, y] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.2, 0.3], [0.5, 0.5], [0.0, 0.25]] {
                let [a, b, c] = parts[f % 4];
                let place = [0, 1].map(|k| (1.0 - x - y) * a[k] + x * b[k] + y * c[k]);
                let (now, before) = (wind.at(f, [x, y]).unwrap(), was.at(f / 4, place).unwrap());
                assert!(now.iter().zip(&before).all(|(n, b)| (n - b).abs() < 1e-13), "face {f}: {now:?} {before:?}");
            }
        }
        // Its first three numbers are the place itself.
        for (p, entry) in fine.nodes().iter().zip(fine.fields["wind"].data.chunks_exact(4)) {
            assert!((0..3).all(|k| (p[k] - entry[k]).abs() < 1e-14));
        }
        assert_eq!(fine.nodes().len() * 4, fine.fields["wind"].data.len());
    }
}

#[test]
fn a_file_on_a_smooth_surface_is_split_on_it() {
    // The error of places is of fourth order in the length of the file's edges, and does not grow with further splits.
    let errors = [6, 12].map(|rings| {
        let mut mesh = sphere_cap(1.0, 60.0, rings).unwrap();
        mesh.regions.clear();
        let boundary = |mesh: &Mesh| {
            let topology = Topology::new(&mesh.faces);
            let edges = (0..topology.edges.len()).filter(|&e| topology.is_boundary(e));
            edges.flat_map(|e| topology.edges[e]).collect::<BTreeSet<_>>()
        };
        let off = |mesh: &Mesh| mesh.vertices.iter().map(|p| (p.norm() - 1.0).abs()).fold(0.0, f64::max);
        let [once, thrice] = [1, 3].map(|times| refined(&mesh, times, Surface::Smooth));
        assert_eq!(boundary(&once).len(), 12 * rings);
        assert!(off(&thrice) < 2.0 * off(&once), "{} {}", off(&thrice), off(&once));
        off(&thrice)
    });
    let sag = 1.0 - (0.5 * (60f64 / 12.0).to_radians()).cos();
    assert!((errors[0] / errors[1]).log2() > 3.5 && errors[1] < 0.05 * sag, "{errors:?} {sag}");
}

#[test]
fn too_many_faces_are_refused() {
    let mesh = disc(1.0, 20).unwrap();
    for times in [7, 12, usize::MAX] {
        let mut fine = mesh.clone();
        let error = refine(&mut fine, times, Surface::Plane).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("refine.times") && error.to_string().contains("faces of 2400"), "{error}");
        assert!(fine == mesh);
    }
}

const CURL: &str = include_str!("../../configs/analytic/smallest_curl.toml");

fn report(sandbox: &Sandbox, name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(sandbox.case(name)).unwrap()).unwrap()
}

#[test]
fn a_scene_may_refine_its_mesh() {
    for element in ["linear", "quadratic"] {
        let set = format!("shell.element='{element}'");
        let value = |change: &[&str]| {
            let sandbox = Sandbox::new(CURL);
            sandbox.ok(&[&["all", "scene.toml", "-q", "--set", &set][..], change].concat());
            let report = report(&sandbox, "report.json");
            (report["faces"].as_u64().unwrap(), report["expectations"][0]["value"].as_f64().unwrap())
        };
        let (faces, split) = value(&["--set", "refine.times=2"]);
        let (as_many, cells) = value(&["--set", "mesh.rectangle.cells=[24, 8]"]);
        assert_eq!((faces, as_many), (384, 384));
        // The same mesh in another order.
        assert!((split / cells - 1.0).abs() < 1e-6, "{split} {cells}");
    }
    let sandbox = Sandbox::new(CURL);
    sandbox.ok(&["mesh", "scene.toml", "-q"]);
    let message = sandbox.fails(2, &["setup", "scene.toml", "-q", "--set", "refine.times=1"]);
    assert!(message.contains("mesh.h5"), "{message}");
    let (out, _) = sandbox.ok(&["check", "scene.toml", "--set", "refine.times=1"]);
    assert!(out.contains("refine    each face into 4") && out.contains("96 faces"), "{out}");
    assert!(!sandbox.ok(&["check", "scene.toml"]).0.contains("refine"));
    let message = sandbox.fails(2, &["mesh", "scene.toml", "-q", "--set", "refine.times=11"]);
    assert!(message.contains("refine.times = 11") && message.contains("makes 1.007e8 faces of 24"), "{message}");
}

#[test]
fn faces_are_split_before_they_are_flattened() {
    let cap = "[mesh.sphere-cap]\nradius = 0.5\nhalf_angle = 50\nrings = 4\n[flatten]\nonto = \"disc\"\nradius = 0.4\n[shell]\nthickness = 1e-3\n\
               youngs_modulus = 1e9\npoissons_ratio = 0.3\n[statics]\n";
    let sandbox = Sandbox::new(cap);
    for element in ["linear", "quadratic"] {
        let set = ["--set", "refine.times=1", "--set", &format!("shell.element='{element}'")];
        sandbox.ok(&[&["mesh", "scene.toml", "-q"][..], &set].concat());
        let archive = thinshell::case::Archive::read(&sandbox.case("mesh.h5"), thinshell::case::Kind::Mesh).unwrap();
        let mesh = thinshell::case::mesh_from_archive(&archive, &sandbox.case("mesh.h5")).unwrap();
        assert_eq!(mesh.faces.len(), 4 * 96);
        let rim = &mesh.regions["rim"].vertices;
        assert!(rim.len() == 48 && rim.iter().all(|&v| (mesh.vertices[v].norm() - 0.4).abs() < 1e-9));
        let original = &mesh.fields["original_position"];
        assert_eq!(original.data.len(), 3 * mesh.nodes().len());
        assert!(original.data.chunks_exact(3).all(|p| (Vector3::new(p[0], p[1], p[2]).norm() - 0.5).abs() < 1e-14));
    }
}

/// A strip as a file, and the same strip longer by a tenth, with a scene on the one whose rest shape is the other.
fn from_files() -> Sandbox {
    let scene = "[mesh.file]\npath = \"strip.vtk\"\n[rest.shape.file]\npath = \"longer.vtk\"\n[shell]\nthickness = 0.01\nyoungs_modulus = 1e6\n\
                 poissons_ratio = 0.3\n[[region]]\nname = \"a\"\nnearest = [0, 0, 0]\n[[region]]\nname = \"b\"\nnearest = [3, 0, 0]\n[[region]]\n\
                 name = \"c\"\nnearest = [0, 2, 0]\n[[pin]]\nregion = \"a\"\n[[pin]]\nregion = \"b\"\ncomponents = [\"y\", \"z\"]\n[[pin]]\n\
                 region = \"c\"\ncomponents = [\"z\"]\n[statics]\n[[report.expect]]\nname = \"length\"\n\
                 measure = { displacement = { at = [3, 0, 0], axis = \"x\" } }\nreference = 0.3\ntolerance = 1e-9\nsource = \"exact\"\n";
    let sandbox = Sandbox::new(scene);
    let mut strip = rectangle([3.0, 2.0], [3, 2], Pattern::Diagonal, 0.25, 1).unwrap();
    strip.regions.clear();
    let mut longer = strip.clone();
    longer.vertices.iter_mut().for_each(|p| p.x *= 1.1);
    for (name, mesh) in [("strip.vtk", &strip), ("longer.vtk", &longer)] {
        std::fs::write(sandbox.path(name), mesh_files::vtk_legacy(mesh, true)).unwrap();
    }
    sandbox
}

#[test]
fn files_are_refined_with_their_rest_shapes() {
    for element in ["linear", "quadratic"] {
        let sandbox = from_files();
        sandbox.ok(&["all", "scene.toml", "-q", "--set", "refine.times=2", "--set", &format!("shell.element='{element}'")]);
        assert_eq!(report(&sandbox, "report.json")["faces"], 12 * 16);
    }
}

#[test]
fn files_have_ladders() {
    let ladder = "[report.ladder]\nmeasure = { displacement = { at = [3, 0, 0], axis = \"x\" } }\nreference = 0.3\nresolutions = [1, 2, 4]\n\
                  refinement = \"split\"\nelements = [\"linear\", \"quadratic\"]\n[[report.ladder.expect]]\nlargest_error = 1e-9\n\
                  meets = [\"length\"]\nsource = \"exact\"\n";
    let sandbox = from_files();
    let text = std::fs::read_to_string(sandbox.path("scene.toml")).unwrap() + ladder;
    sandbox.rewrite(&text);
    sandbox.ok(&["report", "--ladder", "scene.toml", "-q"]);
    let rows = report(&sandbox, "ladder.json");
    let faces: Vec<_> = rows.as_array().unwrap().iter().map(|row| row["faces"].as_u64().unwrap()).collect();
    assert_eq!(faces, [12, 48, 192, 12, 48, 192]);
    // An expectation that only the finest is asked for, of each kind.
    sandbox.rewrite(&with(&text, "reference = 0.3\ntolerance", "reference = 0.4\ntolerance"));
    let message = sandbox.fails(1, &["report", "--ladder", "scene.toml", "-q"]);
    assert!(message.contains("expectations of the ladder missed: 2"), "{message}");
    let rows = report(&sandbox, "ladder.json");
    assert!(rows[2]["missed"][0].as_str().unwrap().starts_with("length 0.3") && rows[1].get("missed").is_none(), "{rows}");
    // A finer run for what an expectation is about, of which it is expected then.
    let expect = "[[report.ladder.expect]]\nelement = \"linear\"\nlargest_error = 1e-9\nfurther = [8]\nsource = \"exact\"\n";
    let text = with(&text, "resolutions = [1, 2, 4]", "resolutions = [1, 4]") + expect;
    sandbox.rewrite(&with(&text, "reference = 0.3\ntolerance", "reference = 0.4\ntolerance"));
    let message = sandbox.fails(1, &["report", "--ladder", "scene.toml", "-q"]);
    assert!(message.contains("expectations of the ladder missed: 2"), "{message}");
    let rows = report(&sandbox, "ladder.json");
    let faces: Vec<_> = rows.as_array().unwrap().iter().map(|row| row["faces"].as_u64().unwrap()).collect();
    assert_eq!(faces, [12, 192, 768, 12, 192]);
    let missed: Vec<_> = (0..5).filter(|i| rows[*i].get("missed").is_some()).collect();
    assert_eq!(missed, [2, 4]);
    for (from, to, expected) in [
        ("further = [8]", "further = [6]", "report.ladder.expect.1.further.0 = 6: must be the first times 2, 4, 8, ..."),
        ("further = [8]", "further = [4]", "report.ladder.expect.1.further.0 = 4: must be larger than the one before"),
        ("resolutions = [1, 4]", "resolutions = [2, 4]", "report.ladder.resolutions.0 = 2: must be 1, since the mesh is a file's"),
        ("refinement = \"split\"\n", "", "report.ladder.refinement: must be \"split\", since the mesh is a file's"),
    ] {
        sandbox.rewrite(&with(&text, from, to));
        let message = sandbox.fails(2, &["report", "--ladder", "scene.toml", "-q"]);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn split_ladders_count_the_order_of_the_two_finest() {
    // A mesh drawn anew has as many faces but others.
    let ladder = |refinement: &str| {
        let sandbox = Sandbox::new(CURL);
        let set = ["--set", "report.ladder.resolutions=[1, 2, 4]", "--set", "report.ladder.directors=['free-tan']"];
        let jitter = ["--set", "mesh.rectangle.jitter=0.25", "--set", &format!("report.ladder.refinement='{refinement}'")];
        sandbox.ok(&[&["report", "--ladder", "scene.toml", "-q"][..], &set, &jitter].concat());
        report(&sandbox, "ladder.json")
    };
    let (anew, split) = (ladder("anew"), ladder("split"));
    assert_eq!(anew[0]["error"], split[0]["error"]);
    assert!((0..3).all(|i| anew[i]["faces"] == split[i]["faces"]));
    assert!(anew[2]["error"] != split[2]["error"]);
    // Similar faces: each longest edge is half of the one before.
    let longest = |i: usize| split[i]["longest_edge"].as_f64().unwrap();
    assert!((1..3).all(|i| (longest(i - 1) / longest(i) - 2.0).abs() < 1e-12));

    let (pair, fitted) = (split[2]["order"].as_f64().unwrap(), split[2]["fitted_order"].as_f64().unwrap());
    assert!((pair - fitted).abs() > 1e-3, "{pair} {fitted}");
    let least = 0.5 * (pair + fitted);
    for (refinement, passes) in [("split", pair > least), ("anew", anew[2]["fitted_order"].as_f64().unwrap() > least)] {
        let expect = format!("refinement = '{refinement}'\n[[report.ladder.expect]]\nleast_order = {least}\nsource = 'between'\n");
        let head = with(CURL, "resolutions = [1, 2]\ndirectors = [\"free-tan\", \"average\"]", "resolutions = [1, 2, 4]");
        let sandbox = Sandbox::new(&(with(&head, "cells = [6, 2]", "cells = [6, 2]\njitter = 0.25") + &expect));
        let code = sandbox.output(&["report", "--ladder", "scene.toml", "-q"]).status.code();
        assert_eq!(code, Some(i32::from(!passes)), "{refinement} {least}");
    }
}

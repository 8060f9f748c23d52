//! Generators: Euler characteristics, areas, orientation, regions, angles, seeds, refused arguments.

use nalgebra::Vector3;
use std::f64::consts::PI;
use thinshell::Result;
use thinshell::mesh::generate::{Pattern, Triangulation, annulus, cylinder, disc, outline, rectangle, rectangle_delaunay, sphere_cap};
use thinshell::mesh::{Mesh, Quality, Topology, validate};

const POINTS: &str = "mesh.outline.points";
const PATTERNS: [Pattern; 3] = [Pattern::Diagonal, Pattern::Alternating, Pattern::CrissCross];

fn normal_and_centroid(mesh: &Mesh, face: &[usize; 3]) -> (Vector3<f64>, Vector3<f64>) {
    let [a, b, c] = face.map(|v| mesh.vertices[v]);
    ((b - a).cross(&(c - a)), (a + b + c) / 3.0)
}

/// Valid, with the Euler characteristic and boundary loops given, and every normal along `outward` of the centroid.
#[track_caller]
fn assert_sound(mut mesh: Mesh, euler: i64, loops: usize, outward: impl Fn(Vector3<f64>) -> Vector3<f64>) {
    assert_eq!(validate::check(&mut mesh, "mesh").unwrap(), Vec::<String>::new());
    let quality = Quality::of(&mesh);
    assert_eq!((quality.euler_characteristic, quality.boundary_loops, quality.components), (euler, loops, 1));
    for face in &mesh.faces {
        let (normal, centroid) = normal_and_centroid(&mesh, face);
        assert!(normal.dot(&outward(centroid)) > 0.0);
    }
    let topology = Topology::new(&mesh.faces);
    let is_edge = |edge: &[usize; 2]| topology.edges.contains(edge);
    assert!(mesh.regions.values().all(|r| r.edges.iter().all(is_edge)));
}

fn up(_: Vector3<f64>) -> Vector3<f64> {
    Vector3::z()
}

fn radial(p: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(p.x, p.y, 0.0)
}

#[test]
fn every_shape_is_sound() {
    for pattern in PATTERNS {
        assert_sound(rectangle([2.0, 1.0], [5, 3], pattern, 0.0, 0).unwrap(), 1, 1, up);
        assert_sound(rectangle([2.0, 1.0], [1, 1], pattern, 0.45, 3).unwrap(), 1, 1, up);
        assert_sound(rectangle([2.0, 1.0], [15, 13], pattern, 0.45, 3).unwrap(), 1, 1, up);
        assert_sound(annulus([0.5, 1.0], [1, 3], false, pattern).unwrap(), 0, 2, up);
        assert_sound(annulus([0.5, 1.0], [2, 8], true, pattern).unwrap(), 1, 1, up);
        assert_sound(cylinder(0.5, 2.0, 360.0, [3, 1], pattern).unwrap(), 0, 2, radial);
        assert_sound(cylinder(0.5, 2.0, 360.0, [8, 3], pattern).unwrap(), 0, 2, radial);
        assert_sound(cylinder(0.5, 2.0, 300.0, [8, 3], pattern).unwrap(), 1, 1, radial);
    }
    assert_sound(rectangle_delaunay([2.0, 1.0], [10, 6], None, 0).unwrap(), 1, 1, up);
    assert_sound(rectangle_delaunay([2.0, 1.0], [1, 1], None, 0).unwrap(), 1, 1, up);
    for rings in [1, 2, 7] {
        assert_sound(disc(0.3, rings).unwrap(), 1, 1, up);
        assert_sound(sphere_cap(0.3, 120.0, rings).unwrap(), 1, 1, |p| if rings == 1 { up(p) } else { p });
    }
}

#[test]
fn rectangle_has_the_documented_layout() {
    let mesh = rectangle([3.0, 2.0], [3, 2], Pattern::Diagonal, 0.0, 0).unwrap();
    let mut faces = Vec::new();
    for i in 0..3 {
        for j in 0..2 {
            let a = i * 3 + j;
            let b = a + 3;
            assert_eq!(mesh.vertices[a], Vector3::new(i as f64, j as f64, 0.0));
            faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    assert_eq!(mesh.faces, faces);
    assert_eq!(mesh.regions["left"].vertices, [0, 1, 2]);
    assert_eq!(mesh.regions["right"].edges, [[9, 10], [10, 11]]);
    assert_eq!(mesh.regions["bottom"].vertices, [0, 3, 6, 9]);
    assert_eq!(mesh.regions["top"].vertices, [2, 5, 8, 11]);
    assert_eq!(mesh.regions["boundary"].edges.len(), 10);
    assert_eq!(rectangle([0.3, 0.1], [3, 3], Pattern::Diagonal, 0.0, 0).unwrap().vertices[15], Vector3::new(0.3, 0.1, 0.0));
}

#[test]
fn flat_areas_are_exact() {
    let area = |mesh: Result<Mesh>| Quality::of(&mesh.unwrap()).total_area;
    for pattern in PATTERNS {
        assert!((area(rectangle([0.7, 0.3], [9, 7], pattern, 0.3, 5)) / 0.21 - 1.0).abs() < 1e-13);
    }
    assert!((area(rectangle_delaunay([0.7, 0.3], [20, 10], None, 5)) / 0.21 - 1.0).abs() < 1e-13);
    // A regular hexagon with a square cut out.
    let hexagon: Vec<[f64; 2]> = (0..6).map(|k| (PI / 3.0 * k as f64).sin_cos()).map(|(s, c)| [c, s]).collect();
    let square = vec![[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]];
    let exact = 1.5 * 3f64.sqrt() - 0.04;
    assert!((area(outline(POINTS, &hexagon, &[square], Triangulation { size: 0.1, min_angle: 25.0 })) / exact - 1.0).abs() < 1e-12);
}

/// The error against the true area falls at second order.
#[test]
fn curved_areas_converge() {
    type Family = (&'static str, f64, fn(usize) -> Result<Mesh>);
    let families: [Family; 4] = [
        ("disc", PI, |n| disc(1.0, n)),
        ("annulus", PI * 0.75, |n| annulus([0.5, 1.0], [n, 6 * n], false, Pattern::Alternating)),
        ("cylinder", 4.0 * PI, |n| cylinder(1.0, 2.0, 360.0, [6 * n, 2 * n], Pattern::Diagonal)),
        ("sphere cap", 2.0 * PI, |n| sphere_cap(1.0, 90.0, n)),
    ];
    for (name, exact, mesh) in families {
        let error = |n| (Quality::of(&mesh(n).unwrap()).total_area - exact).abs();
        let rate = (error(10) / error(20)).log2();
        assert!((rate - 2.0).abs() < 0.1, "{name}: {rate}");
    }
}

#[test]
fn regions_lie_where_they_are_named() {
    let on = |mesh: &Mesh, name: &str, condition: &dyn Fn(Vector3<f64>) -> bool| {
        let region = &mesh.regions[name];
        let expected = mesh.region_where(condition);
        assert_eq!(region.vertices, expected.vertices, "{name}");
        assert!(region.edges.iter().all(|e| expected.edges.contains(e)), "{name}");
    };
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    for delaunay in [false, true] {
        let mesh = if delaunay {
            rectangle_delaunay([2.0, 1.0], [10, 5], None, 1)
        } else {
            rectangle([2.0, 1.0], [10, 5], Pattern::CrissCross, 0.2, 1)
        };
        let mesh = mesh.unwrap();
        on(&mesh, "left", &|p| p.x == 0.0);
        on(&mesh, "right", &|p| p.x == 2.0);
        on(&mesh, "bottom", &|p| p.y == 0.0);
        on(&mesh, "top", &|p| p.y == 1.0);
        assert_eq!(mesh.regions["boundary"].edges.len(), Quality::of(&mesh).boundary_edges);
        assert_eq!(mesh.regions["boundary"].vertices.len(), mesh.regions["boundary"].edges.len());
    }
    let mesh = disc(0.5, 6).unwrap();
    on(&mesh, "rim", &|p| near(p.norm(), 0.5));
    on(&mesh, "center", &|p| p.norm() == 0.0);
    assert_eq!(mesh.regions["rim"].edges.len(), 36);
    let mesh = annulus([0.5, 1.0], [4, 12], false, Pattern::Diagonal).unwrap();
    on(&mesh, "inner", &|p| near(p.norm(), 0.5));
    on(&mesh, "outer", &|p| near(p.norm(), 1.0));
    assert_eq!(mesh.regions.len(), 2);
    let mesh = annulus([0.5, 1.0], [4, 12], true, Pattern::Diagonal).unwrap();
    let side = |name: &str| mesh.regions[name].vertices.iter().map(|&v| mesh.vertices[v]).collect::<Vec<_>>();
    assert_eq!(side("slit-start"), side("slit-end"));
    assert!(side("slit-start").iter().all(|p| p.y == 0.0 && p.x > 0.0));
    assert!(mesh.regions["slit-start"].vertices.iter().all(|v| !mesh.regions["slit-end"].vertices.contains(v)));
    assert_eq!(mesh.regions["slit-end"].edges.len(), 4);
    let mesh = cylinder(0.5, 2.0, 90.0, [6, 4], Pattern::Alternating).unwrap();
    on(&mesh, "bottom", &|p| p.z == 0.0);
    on(&mesh, "top", &|p| p.z == 2.0);
    on(&mesh, "start", &|p| p.y == 0.0);
    on(&mesh, "end", &|p| near(p.x, 0.0));
    let mesh = sphere_cap(0.5, 60.0, 5).unwrap();
    on(&mesh, "rim", &|p| near(p.z, 0.25));
    on(&mesh, "apex", &|p| p.z == 0.5);
    assert_eq!(cylinder(0.5, 2.0, 360.0, [6, 4], Pattern::Diagonal).unwrap().regions.len(), 2);
}

#[test]
fn delaunay_faces_are_near_equilateral_and_as_many_as_asked_for() {
    for seed in 0..4 {
        let mesh = rectangle_delaunay([1.0, 0.5], [40, 20], None, seed).unwrap();
        let quality = Quality::of(&mesh);
        assert!(quality.angle[0] >= 25.0, "seed {seed}: {}", quality.angle[0]);
        assert!((quality.faces as f64 / 1600.0 - 1.0).abs() < 0.02, "seed {seed}: {}", quality.faces);
        assert!(quality.face_area[1] < 2.5 * quality.total_area / quality.faces as f64);
        // No direction is preferred: a large part of the vertices have five or seven neighbours, not six.
        let mut faces_at = vec![0; mesh.vertices.len()];
        mesh.faces.iter().flatten().for_each(|&v| faces_at[v] += 1);
        let inner: Vec<usize> = (0..faces_at.len()).filter(|v| !mesh.regions["boundary"].vertices.contains(v)).collect();
        let odd = inner.iter().filter(|&&v| faces_at[v] != 6).count();
        assert!(odd > inner.len() / 10, "{odd} of {}", inner.len());
    }
    let coarse = Triangulation { size: 0.1, min_angle: 20.0 };
    let quality = Quality::of(&rectangle_delaunay([1.0, 0.5], [1, 1], Some(coarse), 0).unwrap());
    assert!((quality.edge_length[1] / 0.1 - 1.0).abs() < 0.1, "{}", quality.edge_length[1]);
}

#[test]
fn seeds_decide() {
    let jittered = |seed| rectangle([1.0, 1.0], [8, 8], Pattern::Diagonal, 0.25, seed).unwrap();
    assert_eq!(jittered(1), jittered(1));
    assert_ne!(jittered(1), jittered(2));
    let scattered = |seed| rectangle_delaunay([1.0, 1.0], [8, 8], None, seed).unwrap();
    assert_eq!(scattered(1), scattered(1));
    assert_ne!(scattered(1), scattered(2));
}

#[test]
fn jitter_moves_inner_vertices_by_its_fraction_of_the_cell() {
    let regular = rectangle([2.0, 1.0], [10, 10], Pattern::Diagonal, 0.0, 1).unwrap();
    let jittered = rectangle([2.0, 1.0], [10, 10], Pattern::Diagonal, 0.25, 1).unwrap();
    let moved: Vec<Vector3<f64>> = regular.vertices.iter().zip(&jittered.vertices).map(|(a, b)| b - a).collect();
    let boundary = &regular.regions["boundary"].vertices;
    assert!(boundary.iter().all(|&v| moved[v].norm() == 0.0));
    assert_eq!(moved.iter().filter(|m| m.norm() == 0.0).count(), boundary.len());
    let largest = |k: usize| moved.iter().map(|m| m[k].abs()).fold(0.0, f64::max);
    assert!(largest(0) <= 0.05 && largest(0) > 0.04, "{}", largest(0));
    assert!(largest(1) <= 0.025 && largest(1) > 0.02, "{}", largest(1));
}

#[test]
fn outlines_with_holes_and_thin_necks() {
    let t = Triangulation { size: 0.1, min_angle: 25.0 };
    let square = |x: f64, y: f64, a: f64| vec![[x, y], [x + a, y], [x + a, y + a], [x, y + a]];
    let plate = outline(POINTS, &square(0.0, 0.0, 1.0), &[square(0.1, 0.1, 0.3), square(0.6, 0.6, 0.2)], t).unwrap();
    assert_eq!(plate.regions.keys().collect::<Vec<_>>(), ["hole-0", "hole-1", "outline"]);
    let length = |name: &str| plate.regions[name].edges.iter().map(|[a, b]| (plate.vertices[*a] - plate.vertices[*b]).norm()).sum::<f64>();
    for (name, expected) in [("outline", 4.0), ("hole-0", 1.2), ("hole-1", 0.8)] {
        assert!((length(name) - expected).abs() < 1e-12, "{name}: {}", length(name));
    }
    assert!(Quality::of(&plate).angle[0] >= 24.0, "{}", Quality::of(&plate).angle[0]);
    assert_sound(plate, -1, 3, up);
    // The same polygon drawn the other way round has the same faces up to their order.
    let mut reversed = square(0.0, 0.0, 1.0);
    reversed.reverse();
    assert_sound(outline(POINTS, &reversed, &[], t).unwrap(), 1, 1, up);
    // A neck much narrower than the target size.
    let neck = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.49], [2.0, 0.49], [2.0, 0.51], [1.0, 0.51], [1.0, 1.0], [0.0, 1.0]];
    let mesh = outline(POINTS, &neck, &[], t).unwrap();
    assert!(Quality::of(&mesh).angle[0] >= 24.9, "{}", Quality::of(&mesh).angle[0]);
    assert_sound(mesh, 1, 1, up);
    // Far from the origin, and a star with corners sharper than the angle asked for.
    assert_sound(outline(POINTS, &square(1e4, -1e4, 1.0), &[], t).unwrap(), 1, 1, up);
    let star: Vec<[f64; 2]> =
        (0..10).map(|k| (if k % 2 == 0 { 1.0 } else { 0.2 }, PI * k as f64 / 5.0)).map(|(r, a)| [r * a.cos(), r * a.sin()]).collect();
    assert_sound(outline(POINTS, &star, &[], t).unwrap(), 1, 1, up);
}

#[track_caller]
fn refused(mesh: Result<Mesh>, parts: &[&str]) {
    let error = mesh.expect_err("must be refused");
    assert_eq!(error.exit_code(), 2);
    for part in parts {
        assert!(error.to_string().contains(part), "`{part}` is missing in: {error}");
    }
}

#[test]
fn bad_arguments_are_refused_with_their_key() {
    let d = Pattern::Diagonal;
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200, 1e200] {
        refused(rectangle([bad, 1.0], [1, 1], d, 0.0, 0), &["mesh.rectangle.size"]);
        refused(rectangle_delaunay([1.0, bad], [1, 1], None, 0), &["mesh.rectangle.size"]);
        refused(disc(bad, 3), &["mesh.disc.radius"]);
        refused(annulus([0.5, bad], [1, 3], false, d), &["mesh.annulus.radii"]);
        refused(cylinder(bad, 1.0, 360.0, [3, 1], d), &["mesh.cylinder.radius"]);
        refused(cylinder(1.0, bad, 360.0, [3, 1], d), &["mesh.cylinder.length"]);
        refused(sphere_cap(bad, 30.0, 3), &["mesh.sphere-cap.radius"]);
        let t = Triangulation { size: bad, min_angle: 25.0 };
        refused(rectangle_delaunay([1.0, 1.0], [1, 1], Some(t), 0), &["mesh.rectangle.triangulation.size"]);
    }
    refused(rectangle([1.0, 1.0], [0, 1], d, 0.0, 0), &["mesh.rectangle.cells", "0"]);
    refused(rectangle([1.0, 1.0], [10_000, 10_000], d, 0.0, 0), &["mesh.rectangle.cells", "2.000e8 faces"]);
    refused(rectangle([1.0, 1.0], [usize::MAX, 2], d, 0.0, 0), &["mesh.rectangle.cells"]);
    for jitter in [-0.1, 0.46, f64::NAN] {
        refused(rectangle([1.0, 1.0], [2, 2], d, jitter, 0), &["mesh.rectangle.jitter"]);
    }
    refused(rectangle_delaunay([1.0, 1.0], [10_000, 10_000], None, 0), &["faces"]);
    refused(disc(1.0, 0), &["mesh.disc.rings"]);
    refused(disc(1.0, 5000), &["mesh.disc.rings", "faces"]);
    refused(annulus([1.0, 0.5], [1, 3], false, d), &["mesh.annulus.radii"]);
    refused(annulus([0.5, 1.0], [1, 2], false, d), &["mesh.annulus.cells", "2"]);
    for angle in [0.0, -10.0, 361.0, f64::NAN] {
        refused(cylinder(1.0, 1.0, angle, [3, 1], d), &["mesh.cylinder.angle"]);
    }
    refused(cylinder(1.0, 1.0, 360.0, [2, 1], d), &["mesh.cylinder.cells"]);
    refused(cylinder(1.0, 1.0, 200.0, [1, 1], d), &["mesh.cylinder.cells"]);
    for angle in [0.0, 180.0, f64::NAN] {
        refused(sphere_cap(1.0, angle, 3), &["mesh.sphere-cap.half_angle"]);
    }
}

#[test]
fn bad_outlines_are_refused_with_their_corner() {
    let t = Triangulation { size: 0.1, min_angle: 25.0 };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let hole = |x: f64, y: f64, a: f64| vec![[x, y], [x + a, y], [x, y + a]];
    refused(outline(POINTS, &square[..2], &[], t), &["mesh.outline.points", "at least 3"]);
    refused(outline(POINTS, &[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]], &[], t), &["mesh.outline.points", "point 1"]);
    refused(outline(POINTS, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]], &[], t), &["corner (0, 0) occurs twice"]);
    refused(outline(POINTS, &[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], &[], t), &["mesh.outline.points", "meets another side"]);
    refused(outline(POINTS, &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], &[], t), &["mesh.outline.points"]);
    // A corner on another side, and a side that runs back along another.
    refused(outline(POINTS, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.0], [0.0, 1.0]], &[], t), &["meets another side or corner"]);
    refused(outline(POINTS, &[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]], &[], t), &["meets another side or corner"]);
    // Exactly, the corner (0, 5e-5) lies beside the side it should lie on; the face between them is rounding alone.
    let touching = [[-2.5e-5, 0.0], [0.0, 2.5e-5], [-5e-5, 7.500000000000001e-5], [-2.5e-5, 5e-5]];
    refused(outline(POINTS, &touching, &[], Triangulation { size: 2.5e-4, ..t }), &["mesh.outline.points"]);
    refused(outline(POINTS, &square, &[hole(2.0, 2.0, 0.1)], t), &["mesh.outline.holes[0]", "outside"]);
    refused(outline(POINTS, &square, &[hole(0.9, 0.5, 0.3)], t), &["meets another side"]);
    refused(
        outline(POINTS, &square, &[hole(0.1, 0.1, 0.5), hole(0.2, 0.2, 0.1)], t),
        &["mesh.outline.holes[1]", "inside mesh.outline.holes[0]"],
    );
    refused(outline(POINTS, &square, &[hole(0.1, 0.1, 0.5), hole(0.2, 0.2, 0.5)], t), &["meets another side"]);
    refused(outline(POINTS, &square, &[vec![[-1.0, -1.0], [3.0, -1.0], [0.5, 4.0]]], t), &["mesh.outline.holes[0]", "outside"]);
    refused(outline(POINTS, &square, &[], Triangulation { size: 1e-5, ..t }), &["mesh.outline.triangulation.size", "faces"]);
    refused(outline(POINTS, &square, &[], Triangulation { size: 1e-10, ..t }), &["mesh.outline.triangulation.size"]);
    refused(outline(POINTS, &square, &[], Triangulation { min_angle: 31.0, ..t }), &["mesh.outline.triangulation.min_angle"]);
}

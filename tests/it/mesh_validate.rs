//! What is refused as no shell, with the faces named, and what is only warned of; regions by place; regularity.

use nalgebra::Vector3;
use thinshell::mesh::generate::{Pattern, annulus, cylinder, disc, rectangle, rectangle_delaunay, sphere_cap};
use thinshell::mesh::{Mesh, Quality, Region, validate};

fn mesh(vertices: &[[f64; 3]], faces: &[[usize; 3]]) -> Mesh {
    Mesh { vertices: vertices.iter().map(|&p| Vector3::from(p)).collect(), faces: faces.to_vec(), ..Mesh::default() }
}

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

#[track_caller]
fn refused(mut mesh: Mesh, parts: &[&str]) {
    let before = mesh.clone();
    let message = validate::check(&mut mesh, "part.msh").expect_err("must be refused").to_string();
    assert!(message.starts_with("part.msh: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
    assert!(mesh.vertices.len() == before.vertices.len() && mesh.faces == before.faces, "a refused mesh stays as it was");
}

#[test]
fn refusals_name_the_faces() {
    refused(Mesh::default(), &["no faces"]);
    refused(mesh(&SQUARE, &[[0, 1, 2], [0, 2, 4]]), &["beyond the 4", "face 1 (vertices 0 2 4)"]);
    let mut wild = mesh(&SQUARE, &[[0, 1, 2], [0, 2, 3]]);
    wild.vertices[3].y = f64::NAN;
    refused(wild.clone(), &["not finite", "face 1"]);
    wild.vertices[3].y = 1e151;
    refused(wild, &["larger", "face 1"]);
    refused(mesh(&SQUARE.map(|p| p.map(|x| x * 1e-100)), &[[0, 1, 2]]), &["smaller", "face 0"]);
    refused(mesh(&SQUARE, &[[0, 1, 2], [0, 2, 2]]), &["repeated vertex", "face 1 (vertices 0 2 2)"]);
    let mut flat = mesh(&SQUARE, &[[0, 1, 2], [0, 2, 3]]);
    flat.vertices[3] = Vector3::new(0.5, 0.5, 0.0);
    refused(flat.clone(), &["no area", "face 1"]);
    flat.vertices[3] = flat.vertices[0];
    refused(flat, &["no area", "face 1"]);
    refused(mesh(&SQUARE, &[[0, 1, 2], [0, 2, 3], [2, 0, 1]]), &["same vertices", "face 0 (vertices 0 1 2), face 2 (vertices 2 0 1)"]);
    refused(mesh(&SQUARE, &[[0, 1, 2], [0, 3, 2]]), &["opposite orientation", "face 0", "face 1"]);
    let book = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[3], [0.5, 0.5, 1.0]];
    refused(mesh(&book, &[[0, 1, 2], [0, 2, 3], [0, 2, 4]]), &["more than two faces", "face 0", "face 1", "face 2"]);
}

#[test]
fn long_lists_are_counted() {
    let mut broken = rectangle([1.0, 1.0], [4, 4], Pattern::Diagonal, 0.0, 0).unwrap();
    broken.faces[3..20].iter_mut().for_each(|face| face[2] = face[0]);
    let message = validate::check(&mut broken, "x").unwrap_err().to_string();
    assert!(message.contains("face 3 ") && message.contains("face 7 ") && !message.contains("face 8 "), "{message}");
    assert!(message.ends_with("and 12 more"), "{message}");
}

#[test]
fn slivers_are_the_users_choice() {
    // Aspect ratio 1e4, and an angle of 0.01 degrees.
    for height in [1e-4, 0.01f64.to_radians().tan()] {
        let mut sliver = mesh(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, height, 0.0]], &[[0, 1, 2]]);
        assert!(validate::check(&mut sliver, "x").unwrap().is_empty());
    }
}

#[test]
fn unused_vertices_are_dropped_and_regions_follow() {
    let mut m = mesh(&[[9.0; 3], SQUARE[0], [8.0; 3], SQUARE[1], SQUARE[2]], &[[1, 3, 4]]);
    m.regions.insert("side".into(), Region::new([0, 1, 3], [[1, 3], [0, 1], [2, 4]], [0]));
    let warnings = validate::check(&mut m, "x").unwrap();
    assert_eq!(m.faces, [[0, 1, 2]]);
    assert_eq!(m.vertices, SQUARE[..3].iter().map(|&p| Vector3::from(p)).collect::<Vec<_>>());
    assert_eq!(m.regions["side"], Region::new([0, 1], [[0, 1]], [0]));
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("2 edges of region `side`") && warnings[1].contains("2 vertices"), "{warnings:?}");
}

#[test]
fn parts_that_touch_in_a_vertex_are_warned_of() {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, -1.0, 0.0]];
    let warnings = validate::check(&mut mesh(&vertices, &[[0, 1, 2], [0, 3, 4]]), "x").unwrap();
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("1 vertices") && warnings[0].contains("vertex 0 at (0, 0, 0)"), "{warnings:?}");
    // Fans found in any order of faces are still one fan.
    for pattern in [Pattern::Diagonal, Pattern::Alternating, Pattern::CrissCross] {
        let mut m = annulus([1.0, 2.0], [3, 12], true, pattern).unwrap();
        m.faces.reverse();
        m.faces.rotate_left(7);
        assert!(validate::check(&mut m, "x").unwrap().is_empty());
    }
}

#[test]
fn regions_by_place() {
    let m = rectangle([2.0, 1.0], [4, 2], Pattern::Diagonal, 0.0, 0).unwrap();
    let left = m.region_where(|p| p.x < 1e-9);
    assert_eq!((&left.vertices, &left.edges), (&m.regions["left"].vertices, &m.regions["left"].edges));
    assert!(left.faces.is_empty());
    let half = m.region_where(|p| p.x < 1.01);
    assert_eq!(half.vertices.len(), 9);
    assert_eq!(half.faces, (0..8).collect::<Vec<_>>());
    assert_eq!(half.edges.len(), 9 + 8 - 1);
    assert_eq!(m.region_where(|_| true).edges.len(), Quality::of(&m).edges);
    assert_eq!(m.region_where(|_| false), Region::default());
    assert_eq!(m.region_nearest(Vector3::new(5.0, 0.4, 3.0)), Region::new([13], [], []));
    assert_eq!(Mesh::default().region_nearest(Vector3::zeros()), Region::default());
}

#[test]
fn quality_tells_regular_from_irregular() {
    let regular = |m: thinshell::Result<Mesh>| !Quality::of(&m.unwrap()).is_irregular();
    assert!(regular(rectangle([1.0, 1.0], [12, 12], Pattern::Diagonal, 0.0, 0)));
    assert!(regular(rectangle([10.0, 1.0], [20, 20], Pattern::Diagonal, 0.0, 0)));
    assert!(regular(cylinder(1.0, 2.0, 360.0, [24, 12], Pattern::Diagonal)));
    assert!(regular(disc(1.0, 40)));
    assert!(regular(sphere_cap(1.0, 60.0, 40)));
    for jitter in [0.1, 0.25, 0.45] {
        assert!(!regular(rectangle([1.0, 1.0], [12, 12], Pattern::Diagonal, jitter, 1)), "{jitter}");
    }
    assert!(!regular(rectangle([1.0, 1.0], [12, 12], Pattern::Alternating, 0.0, 0)));
    assert!(!regular(rectangle([1.0, 1.0], [12, 12], Pattern::CrissCross, 0.0, 0)));
    assert!(!regular(rectangle_delaunay([1.0, 1.0], [12, 12], None, 0)));
}

#[test]
fn quality_of_one_right_triangle() {
    let q = Quality::of(&mesh(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]], &[[0, 1, 2]]));
    assert_eq!((q.vertices, q.faces, q.edges, q.boundary_edges, q.boundary_loops, q.components), (3, 1, 3, 3, 1, 1));
    assert_eq!(q.euler_characteristic, 1);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
    close(q.edge_length[0], 3.0);
    close(q.edge_length[1], 4.0);
    close(q.edge_length[2], 5.0);
    close(q.total_area, 6.0);
    close(q.angle[0], 0.75f64.atan().to_degrees());
    close(q.angle[1], 90.0);
    // Circumradius 5/2, inradius 1.
    close(q.worst_aspect_ratio, 1.25);
    let table = q.to_string();
    for word in ["Euler characteristic  1", "6.000000e0 m2", "36.87 to 90.00 degrees", "regular"] {
        assert!(table.contains(word), "{table}");
    }
}

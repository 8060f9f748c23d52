//! The machine direction: where its kinds point.

use crate::physics_case::set_up;
use nalgebra::Vector3;
use thinshell::mesh::Mesh;

const ANNULUS: &str = "[mesh.annulus]\nradii = [0.4, 1.0]\ncells = [4, 24]";
const CYLINDER: &str = "[mesh.cylinder]\nradius = 0.5\nlength = 1.0\nangle = 250\ncells = [20, 6]\npattern = \"alternating\"";

/// A direction in space and the place where it holds.
type Arrow = (Vector3<f64>, Vector3<f64>);

/// Mesh, and the direction of each face at its centroid.
fn directions(mesh: &str, table: &str) -> (Mesh, Vec<Arrow>) {
    let text = format!(
        "{mesh}\n[shell]\nelement = \"linear\"\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n[machine-direction]\n{table}\n[statics]\n"
    );
    let (mesh, setup, _) = set_up(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let found = setup.machine_direction.unwrap();
    let list = mesh.faces.iter().zip(&found).map(|(face, d)| {
        let [a, b, c] = face.map(|v| mesh.vertices[v]);
        ((b - a) * d[0] + (c - a) * d[1], (a + b + c) / 3.0)
    });
    let list = list.collect();
    (mesh, list)
}

fn assert_along(mesh: &str, table: &str, expected: impl Fn(&Vector3<f64>) -> Vector3<f64>) {
    for (d, p) in directions(mesh, table).1 {
        assert!((d.norm() - 1.0).abs() < 1e-12);
        assert!((d - expected(&p).normalize()).norm() < 1e-9, "{table} at {p:?}: {d:?}");
    }
}

#[test]
fn directions_in_the_plane() {
    assert_along(ANNULUS, "vector = [1, 2, 5]", |_| Vector3::new(1.0, 2.0, 0.0));
    assert_along(ANNULUS, "angle = \"90 + 10 * x\"", |p| {
        let angle = (90.0 + 10.0 * p.x).to_radians();
        Vector3::new(angle.cos(), angle.sin(), 0.0)
    });
    assert_along(ANNULUS, "radial = {}", |p| *p);
    assert_along(ANNULUS, "radial = { center = [2, -1] }", |p| p - Vector3::new(2.0, -1.0, 0.0));
    assert_along(ANNULUS, "azimuthal = {}", |p| Vector3::new(-p.y, p.x, 0.0));
    assert_along(ANNULUS, "gradient = \"x^2 + 3 * x * y + theta\"", |p| {
        let r2 = p.xy().norm_squared();
        Vector3::new(2.0 * p.x + 3.0 * p.y - p.y / r2, 3.0 * p.x + p.x / r2, 0.0)
    });
    assert_along(ANNULUS, "transport = { from = [0.7, 0, 0], vector = [1, 3, 0] }", |_| Vector3::new(1.0, 3.0, 0.0));
}

/// On a cylinder, which can be unrolled, a transported direction keeps its angle to the axis: exactly, on the facets.
#[test]
fn transport_keeps_the_angle_to_the_axis_of_a_cylinder() {
    let (_, list) = directions(CYLINDER, "transport = { from = [0.5, 0, 0.5], vector = [0, 1, 1] }");
    let along = list[0].0.z;
    assert!(along > 0.5 && along < 0.9);
    for (d, p) in list {
        let around = Vector3::new(-p.y, p.x, 0.0).normalize();
        assert!((d.z - along).abs() < 1e-9 && d.dot(&around) > 0.5, "{p:?}: {d:?}");
    }
}

#[test]
fn impossible_directions_are_refused() {
    for (mesh, table, words) in [
        (ANNULUS, "vector = [0, 0, 1]", vec!["face 0", "no part in the face"]),
        (ANNULUS, "gradient = 3", vec!["face 0", "no part in the face"]),
        (ANNULUS, "field = \"grain\"", vec!["machine-direction.field", "there is no field 'grain'"]),
        (ANNULUS, "transport = { from = [0, 0, 9], vector = [1, 0, 0] }", vec!["machine-direction.transport.from"]),
        (
            CYLINDER,
            "transport = { from = [0.5, 0.02, 0.1], vector = [0.99405633822232, 0.10886687485196, 0] }",
            vec!["no part in the face"],
        ),
    ] {
        let text = format!(
            "{mesh}\n[shell]\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n[machine-direction]\n{table}\n[statics]\n"
        );
        let error = set_up(&text).err().map(|e| format!("{} {e}", e.exit_code())).unwrap_or_default();
        assert!(error.starts_with("2 ") && words.iter().all(|w| error.contains(w)), "{table}: {error}");
    }
}

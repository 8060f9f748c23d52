//! Fields of the mesh in rest shapes and fibres: what they make is exact, what they break is told. Ramps in time.

use crate::physics_case::{matrix, run, set_up, six_pins};
use nalgebra::{Matrix2, Rotation2, Vector3};
use std::path::Path;

/// A grid of 4 x 3 squares of side 0.1, each cut in two.
fn grid() -> (Vec<Vector3<f64>>, Vec<[usize; 3]>) {
    let vertices = (0..=4).flat_map(|i| (0..=3).map(move |j| Vector3::new(0.1 * f64::from(i), 0.1 * f64::from(j), 0.0))).collect();
    let square = |a: usize| [[a, a + 4, a + 5], [a, a + 5, a + 1]];
    (vertices, (0..4).flat_map(|i| (0..3).flat_map(move |j| square(4 * i + j))).collect())
}

/// Writes the grid with a field of its vertices (`POINT`) or faces (`CELL`), each value 1 or 3 numbers.
fn write<const N: usize>(path: &Path, on: &str, values: &[[f64; N]]) {
    let (vertices, faces) = grid();
    let mut text = format!("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS {} double\n", vertices.len());
    vertices.iter().for_each(|p| text += &format!("{:?} {:?} {:?}\n", p.x, p.y, p.z));
    text += &format!("POLYGONS {} {}\n", faces.len(), 4 * faces.len());
    faces.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\n"));
    let kind = if N == 3 { "VECTORS g double" } else { "SCALARS g double 1\nLOOKUP_TABLE default" };
    text += &format!("{on}_DATA {}\n{kind}\n", values.len());
    values.iter().for_each(|value| text += &(value.map(|v| format!("{v:?}")).join(" ") + "\n"));
    std::fs::write(path, text).unwrap();
}

/// A scene on the mesh of that file.
fn scene(path: &Path, element: &str, tables: &str) -> String {
    format!(
        "[mesh.file]\npath = {:?}\n[shell]\nelement = \"{element}\"\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n\
         density = 1000.0\n{tables}\n[dynamics]\ndt = 1.0\nend = 1.0\n",
        path.display().to_string()
    )
}

const ELEMENTS: [&str; 2] = ["linear", "quadratic"];

/// A direction that no axis of the mesh has, different at each place.
fn fibre(p: &Vector3<f64>) -> [f64; 3] {
    [1.0 + 3.0 * p.x, 0.4 - 5.0 * p.y, 0.7]
}

#[test]
fn the_machine_direction_of_a_field_is_that_of_its_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.vtk");
    let (vertices, faces) = grid();
    let centroid = |face: &[usize; 3]| face.iter().map(|v| vertices[*v]).sum::<Vector3<f64>>() / 3.0;
    // A linear field is the same given at vertices or at centroids.
    for on in ["POINT", "CELL"] {
        let values: Vec<[f64; 3]> =
            if on == "POINT" { vertices.iter().map(fibre).collect() } else { faces.iter().map(centroid).map(|p| fibre(&p)).collect() };
        write(&path, on, &values);
        for element in ELEMENTS {
            let (mesh, setup, _) = set_up(&scene(&path, element, "[machine-direction]\nfield = \"g\"")).unwrap();
            for (face, d) in mesh.faces.iter().zip(setup.machine_direction.unwrap()) {
                let [a, b, c] = face.map(|v| mesh.vertices[v]);
                let [x, y, _] = fibre(&centroid(face));
                let exact = Vector3::new(x, y, 0.0).normalize();
                assert!(((b - a) * d[0] + (c - a) * d[1] - exact).norm() < 1e-12, "{on} {element}: {d:?} {exact:?}");
            }
        }
    }
}

/// Factors and an angle for each face: `abar = R diag(f1^2, f2^2) R^T` in space.
#[test]
fn growth_by_two_factors_and_an_angle_of_each_face() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.vtk");
    let count = grid().1.len();
    // Degrees; a hundredth of them is the factor across.
    let angle = |face: usize| 7.0 * face as f64 + 10.0;
    write(&path, "CELL", &(0..count).map(|f| [angle(f)]).collect::<Vec<_>>());
    let law = "[rest]\nsampling = \"centroid\"\n[rest.orthotropic]\nangle = { field = \"g\" }\n\
               factors = [1.3, { field = \"g\", times = \"0.01\" }]\n";
    for element in ELEMENTS {
        let (mesh, setup, _) = set_up(&scene(&path, element, law)).unwrap();
        let points = setup.rest_forms.len() / count;
        for (k, (rest, initial)) in setup.rest_forms.iter().zip(&setup.initial_forms).enumerate() {
            let face = k / points;
            let [a, b, c] = mesh.faces[face].map(|v| mesh.vertices[v]);
            let t = Matrix2::from_columns(&[(b - a).xy(), (c - a).xy()]);
            let turn = *Rotation2::new(angle(face).to_radians()).matrix();
            let exact = t.transpose() * turn * Matrix2::new(1.69, 0.0, 0.0, (0.01 * angle(face)).powi(2)) * turn.transpose() * t;
            assert!((matrix(initial.a) - exact).norm() > 0.1 * exact.norm());
            assert!((matrix(rest.a) - exact).norm() < 1e-12 * exact.norm(), "{element}, face {face}: {:?} {exact}", rest.a);
            assert!(rest.b.iter().all(|b| b.abs() < 1e-14));
        }
    }
}

#[test]
fn fields_that_break_growth_are_told_with_the_face_and_the_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.vtk");
    for (bad, law, words) in [
        (-0.2, "[rest.orthotropic]\nfactors = [{ field = \"g\" }, 1]\nangle = 0", "the growth factor -0.2 must be positive"),
        (1e4, "[rest.isotropic]\ns = { field = \"g\", times = \"0.5 - t\" }", "s = 5000 makes the factor e^(2s) = inf"),
        (-0.2, "[rest]\nsampling = \"centroid\"\n[rest.prestress]\ntimes = { field = \"g\" }", "the rest metric [-0.00"),
    ] {
        write(&path, "CELL", &(0..grid().1.len()).map(|f| [if f == 7 { bad } else { 1.0 }]).collect::<Vec<_>>());
        for element in ELEMENTS {
            let error = set_up(&scene(&path, element, law)).err().unwrap_or_else(|| panic!("{law}"));
            let told = error.to_string();
            assert!(
                error.exit_code() == 2 && told.starts_with("rest") && told.contains("face 7 at (") && told.contains(words),
                "{element}: {told}"
            );
        }
    }
}

/// The share of a law in force: of both forms at the start, and of the metric at each step of a sheet that is free to follow.
#[test]
fn ramps_mix_the_initial_forms_with_those_of_the_law() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.vtk");
    write(&path, "CELL", &vec![[1.0]; grid().1.len()]);
    for element in ELEMENTS {
        let law = "[rest.pullback]\nabar = [1.4, 0.2, 0.8]\nbbar = [3, \"x\", -1]\n";
        let forms = |ramp: &str| set_up(&scene(&path, element, &format!("[rest]\nramp = {ramp}\n{law}"))).unwrap().1;
        let (whole, part) = (forms("1"), forms("\"0.3 + 0.1 * t\""));
        for ((whole, part), initial) in whole.rest_forms.iter().zip(&part.rest_forms).zip(&whole.initial_forms) {
            assert!((0..3).any(|i| (whole.a[i] - initial.a[i]).abs() > 1e-4) && (0..3).any(|i| (whole.b[i] - initial.b[i]).abs() > 1e-3));
            for i in 0..3 {
                assert!((part.a[i] - 0.7 * initial.a[i] - 0.3 * whole.a[i]).abs() < 1e-16, "{element}: {part:?} {whole:?}");
                assert!((part.b[i] - 0.7 * initial.b[i] - 0.3 * whole.b[i]).abs() < 1e-15, "{element}: {part:?} {whole:?}");
            }
        }
        let case = run(&format!(
            "[mesh.rectangle]\nsize = [0.2, 0.1]\ncells = [4, 2]\n{}[shell]\nelement = \"{element}\"\nthickness = 1e-3\nyoungs_modulus = 1e6\n\
             poissons_ratio = 0.3\n[rest]\nramp = \"t^2\"\n[rest.isotropic]\ns = 0.2\n[solver]\ntolerance = 1e-12\n[statics]\nsteps = 4\n",
            six_pins(0.1, 0.05, 0.05, 0.05)
        ));
        let centre = case.vertex(0.1, 0.05, 0.0).0;
        let states = case.states();
        assert_eq!(states.len(), 5);
        for state in states {
            let stretch = (1.0 + state.time.powi(2) * (0.4f64.exp() - 1.0)).sqrt();
            for (now, before) in crate::physics_case::points(&state, "position").iter().zip(&case.mesh.nodes()) {
                assert!((now - centre - (before - centre) * stretch).norm() < 1e-10, "{element} at {}: {now} {before}", state.time);
            }
        }
    }
}

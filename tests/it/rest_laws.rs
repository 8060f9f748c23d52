//! Each growth law against its formula, for both elements, and products of laws.

use crate::physics_case::{matrix, set_up};
use nalgebra::{Matrix2, Vector2, Vector3};
use thinshell::mesh::{Mesh, Topology};
use thinshell::shell::rest::Forms;

const H: f64 = 0.02;

/// Mesh, initial forms and rest forms of a scene with this mesh and these rest tables.
fn laws(mesh: &str, element: &str, rest: &str) -> (Mesh, Vec<Forms>, Vec<Forms>) {
    let text = format!(
        "{mesh}\n[shell]\nelement = \"{element}\"\nthickness = {H}\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\ndensity = 1000.0\n{rest}\n\
         [dynamics]\ndt = 1.0\nend = 1.0\n"
    );
    let (mesh, setup, _) = set_up(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    (mesh, setup.initial_forms, setup.rest_forms)
}

const SQUARE: &str = "[mesh.rectangle]\nsize = [0.7, 0.5]\ncells = [6, 5]\npattern = \"alternating\"\njitter = 0.2";
const CYLINDER: &str = "[mesh.cylinder]\nradius = 0.5\nlength = 1.0\nangle = 100\ncells = [6, 5]";
const ELEMENTS: [&str; 2] = ["linear", "quadratic"];

fn assert_close(found: [f64; 3], expected: [f64; 3], tolerance: f64, what: &str) {
    let size = expected.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(size > 0.0, "{what}: the expected form vanishes");
    assert_within(found, expected, tolerance * size, what);
}

/// Largest component of second forms, which vanish on some faces of a faceted cylinder.
fn bend(forms: &[Forms]) -> f64 {
    let largest = forms.iter().flat_map(|f| f.b).fold(0.0f64, |m, b| m.max(b.abs()));
    assert!(largest > 0.0);
    largest
}

fn assert_within(found: [f64; 3], expected: [f64; 3], tolerance: f64, what: &str) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{what}: {found:?} instead of {expected:?}");
    }
}

/// Mean and Gauss curvature of forms.
fn curvatures(f: &Forms) -> [f64; 2] {
    let shape = matrix(f.a).try_inverse().unwrap() * matrix(f.b);
    [0.5 * shape.trace(), shape.determinant()]
}

#[test]
fn isotropic() {
    for element in ELEMENTS {
        let (_, initial, rest) = laws(CYLINDER, element, "[rest.isotropic]\ns = 0.1");
        for (i, r) in initial.iter().zip(&rest) {
            assert_close(r.a, i.a.map(|a| 0.2f64.exp() * a), 1e-12, element);
            assert_within(r.b, i.b, 1e-12 * bend(&initial), element);
        }
    }
}

/// `gbar+- = (1 + m mu)^2 (a0 -+ 2/3 h b0)`, `abar = (gbar+ + gbar-)/2`, `bbar = 3/(4h) (gbar- - gbar+)`.
#[test]
fn bilayer() {
    for element in ELEMENTS {
        let (_, initial, rest) = laws(CYLINDER, element, "[rest.bilayer]\nm_plus = 3\nm_minus = -2\nmu = [0.01, 0.02]");
        for (i, r) in initial.iter().zip(&rest) {
            let side = |f: f64, sign: f64| -> [f64; 3] { std::array::from_fn(|c| f * f * (i.a[c] - sign * 2.0 / 3.0 * H * i.b[c])) };
            let (top, bottom) = (side(1.03, 1.0), side(0.96, -1.0));
            let b: [f64; 3] = std::array::from_fn(|c| 0.75 / H * (bottom[c] - top[c]));
            assert_within(r.b, b, 1e-12 * bend(&rest), element);
            // The metric's edges are interpolated, which is exact on straight faces only.
            let a: [f64; 3] = std::array::from_fn(|c| 0.5 * (top[c] + bottom[c]));
            assert_close(r.a, a, 2e-3, element);
        }
        // A wetted top makes the top convex: negative curvature on a flat sheet.
        let (_, _, rest) = laws(SQUARE, element, "[rest.bilayer]\nm_plus = 3\nm_minus = 0\nmu = [0.01, 0.01]");
        assert!(rest.iter().all(|f| curvatures(f)[0] < -1.0));
    }
}

/// Growth by two factors is what both faces swelling alike across and along the fibres makes; with equal factors, on a flat sheet, it is isotropic.
#[test]
fn orthotropic() {
    let direction = "[machine-direction]\nangle = \"20 + 30 * x\"\n";
    for element in ELEMENTS {
        for mesh in [SQUARE, CYLINDER] {
            let fibres = if mesh == SQUARE { direction } else { "[machine-direction]\nvector = [0.2, 0.1, 1]\n" };
            let growth = laws(mesh, element, &format!("{fibres}[rest.orthotropic]\nfactors = [1.2, \"0.9\"]"));
            let swelling = laws(mesh, element, &format!("{fibres}[rest.linear]\nm_plus = 10\nm_minus = 10\nmu = 0.02\nmu_perp = -0.01"));
            for (g, s) in growth.2.iter().zip(&swelling.2) {
                assert_close(g.a, s.a, 1e-12, element);
                if mesh == CYLINDER {
                    assert_within(g.b, s.b, 1e-10 * bend(&growth.2), element);
                }
            }
            let moved = growth.1.iter().zip(&growth.2).map(|(i, g)| (g.a[0] / i.a[0] - 1.0).abs()).fold(0.0, f64::max);
            assert!(moved > 0.05);
        }
        let equal = laws(SQUARE, element, "[rest.orthotropic]\nfactors = [1.25, 1.25]\nangle = \"100 * y\"");
        for (i, g) in equal.1.iter().zip(&equal.2) {
            assert_close(g.a, i.a.map(|a| 1.5625 * a), 1e-12, element);
        }
    }
}

/// Growth along and across the radii of a ring of a few long and curved faces: at the Gauss points of each edge the rest metric has, along the edge,
/// what the law makes of the curved edge there.
#[test]
fn orthotropic_on_curved_faces() {
    let ring = "[mesh.annulus]\nradii = [0.03, 1]\ncells = [5, 12]\npattern = \"alternating\"\n[machine-direction]\nradial = {}";
    let (mesh, initial, rest) = laws(ring, "quadratic", "[rest.orthotropic]\nfactors = [0.9, 1.05]");
    let topology = Topology::new(&mesh.faces);
    let corner = [Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];
    // t.a.t of the linear functions through the three integration points.
    let along = |forms: &[Forms], place: Vector2<f64>, t: Vector2<f64>| -> f64 {
        let (x, y) = (2.0 * place.x - 1.0 / 3.0, 2.0 * place.y - 1.0 / 3.0);
        forms.iter().zip([1.0 - x - y, x, y]).map(|(f, weight)| weight * t.dot(&(matrix(f.a) * t))).sum()
    };
    let mut curved = 0;
    for (face, vertices) in mesh.faces.iter().enumerate() {
        for i in 0..3 {
            let (from, to) = ((i + 1) % 3, (i + 2) % 3);
            let [a, b, m] = [mesh.vertices[vertices[from]], mesh.vertices[vertices[to]], mesh.midpoints[topology.face_edges[face][i]]];
            curved += usize::from(((a + b) * 0.5 - m).norm() > 1e-3);
            for s in [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()] {
                let position = a * ((1.0 - s) * (1.0 - 2.0 * s)) + m * (4.0 * s * (1.0 - s)) + b * (s * (2.0 * s - 1.0));
                let tangent = a * (4.0 * s - 3.0) + m * (4.0 - 8.0 * s) + b * (4.0 * s - 1.0);
                let radial = tangent.dot(&position.normalize());
                let expected = 0.81 * radial * radial + 1.05 * 1.05 * (tangent.norm_squared() - radial * radial);
                let (place, t) = (corner[from] * (1.0 - s) + corner[to] * s, corner[to] - corner[from]);
                let found = along(&rest[3 * face..][..3], place, t);
                assert!((found - expected).abs() < 1e-12 * expected, "face {face}, edge {i}: {found} instead of {expected}");
                assert!((along(&initial[3 * face..][..3], place, t) - expected).abs() > 1e-3 * expected);
            }
        }
    }
    assert!(curved > 0);
}

/// A surface given by its map has the forms that are known of it.
#[test]
fn surfaces() {
    for element in ELEMENTS {
        let map = "[rest.surface]\nposition = [\"0.3 * sin(x / 0.3)\", \"y\", \"0.3 * (1 - cos(x / 0.3))\"]";
        let (_, _, mapped) = laws(SQUARE, element, map);
        let (_, _, given) = laws(SQUARE, element, "[rest.pullback]\nbbar = [\"1 / 0.3\", 0, 0]");
        for (m, g) in mapped.iter().zip(&given) {
            assert_close(m.a, g.a, 1e-12, element);
            assert_close(m.b, g.b, 1e-11, element);
        }
        let disc = "[mesh.disc]\nradius = 0.8\nrings = 4";
        let (_, _, sphere) = laws(disc, element, "[rest.surface.sphere]\nradius = 1.3");
        let metric = "[rest.pullback]\nabar = [1, 0, \"1.3^2 * sin(r / 1.3)^2\"]\ncomponents = \"polar\"";
        let (_, _, given) = laws(disc, element, metric);
        for (s, g) in sphere.iter().zip(&given) {
            assert_close(s.a, g.a, 1e-12, element);
        }
        let [mean, gauss] = curvatures(&sphere[40]);
        assert!((mean + 1.0 / 1.3).abs() < 0.05 && (gauss - 1.0 / 1.69).abs() < 0.05, "outward: {mean} {gauss}");
    }
}

/// Curvatures of the presets at the integration points, without interpolation of the metric, to round-off.
#[test]
fn presets_are_exact() {
    let place = |mesh: &Mesh, face: usize| mesh.faces[face].iter().map(|v| mesh.vertices[*v]).sum::<Vector3<f64>>() / 3.0;
    let sampled = |law: &str| laws(SQUARE, "linear", &format!("[rest]\nsampling = \"centroid\"\n{law}"));
    let (mesh, _, torus) = sampled("[rest.surface.torus]\nradii = [1.0, 0.4]");
    for (f, form) in torus.iter().enumerate() {
        let v = place(&mesh, f).y / 0.4;
        let expected = v.cos() / (0.4 * (1.0 + 0.4 * v.cos()));
        let [mean, gauss] = curvatures(form);
        assert!((gauss - expected).abs() < 1e-10 && mean < 0.0, "{gauss} {expected}");
    }
    for form in sampled("[rest.surface.sphere]\nradius = 1.3").2 {
        assert_close(form.b.map(|b| -1.3 * b), form.a, 1e-12, "outward: b = -a / R");
    }
    let family = [0.0, 30.0, 90.0].map(|turn| sampled(&format!("[rest.surface.catenoid]\nwaist = 0.6\nturn = {turn}")).2);
    let helicoid = sampled("[rest.surface.helicoid]\nwaist = 0.6").2;
    assert_eq!(family[2], helicoid);
    for (f, form) in family[0].iter().enumerate() {
        let c = (place(&mesh, f).y / 0.6).cosh();
        for other in family.iter() {
            assert_close(other[f].a, form.a, 1e-12, "one metric");
            let [mean, gauss] = curvatures(&other[f]);
            assert!(mean.abs() < 1e-10 && (gauss + 1.0 / (0.36 * c.powi(4))).abs() < 1e-10, "{mean} {gauss}");
        }
        assert!((form.b[0] - helicoid[f].b[0]).abs() > 1e-4, "the family turns its second form");
    }
}

/// Laws follow one another: each starts from what the one before it makes.
#[test]
fn products() {
    let factor = |m: f64| (1.0 + 0.01 * m) * (1.0 + 0.01 * m);
    for element in ELEMENTS {
        let (_, _, base) = laws(SQUARE, element, "[rest.pullback]\nbbar = [2, 0.5, \"x\"]");
        let all = "[rest.pullback]\nbbar = [2, 0.5, \"x\"]\n[rest.isotropic]\ns = 0.2\n[rest.linear]\nm_plus = 4\nm_minus = 1\nmu = 0.01\n\
                   [rest.prestress]\ntimes = 0.9\nplus_b = [0, 0, 1.5]";
        let (mesh, initial, product) = laws(SQUARE, element, all);
        let points = product.len() / mesh.faces.len();
        for (k, p) in product.iter().enumerate() {
            let (a, b) = (initial[k].a.map(|a| 0.4f64.exp() * a), base[k].b);
            let sides = [1.0, -1.0].map(|sign| -> [f64; 3] {
                let m = if sign > 0.0 { 4.0 } else { 1.0 };
                std::array::from_fn(|c| factor(m) * (a[c] - sign * H * b[c]))
            });
            let [r1, r2] = [1, 2].map(|i| mesh.vertices[mesh.faces[k / points][i]] - mesh.vertices[mesh.faces[k / points][0]]);
            let plus = [r1.y * r1.y, r1.y * r2.y, r2.y * r2.y].map(|v| 1.5 * v);
            let expected: [f64; 3] = std::array::from_fn(|c| (sides[1][c] - sides[0][c]) / (2.0 * H) + plus[c]);
            assert_close(p.b, expected, 1e-11, element);
            let expected: [f64; 3] = std::array::from_fn(|c| 0.45 * (sides[0][c] + sides[1][c]));
            assert_close(p.a, expected, 2e-3, element);
        }
    }
}

/// Stretching in the plane: what is added to the metric is the added tensor.
#[test]
fn prestress() {
    for element in ELEMENTS {
        let (mesh, initial, rest) = laws(SQUARE, element, "[rest.prestress]\nplus_a = [0.1, 0.02, -0.05]");
        let points = rest.len() / mesh.faces.len();
        for (k, (i, r)) in initial.iter().zip(&rest).enumerate() {
            let face = mesh.faces[k / points];
            let [r1, r2] = [1, 2].map(|i| (mesh.vertices[face[i]] - mesh.vertices[face[0]]).xy());
            let t = Matrix2::from_columns(&[r1, r2]);
            let plus = t.transpose() * Matrix2::new(0.1, 0.02, 0.02, -0.05) * t;
            assert_close(r.a, [i.a[0] + plus[(0, 0)], i.a[1] + plus[(0, 1)], i.a[2] + plus[(1, 1)]], 1e-12, element);
        }
    }
}

/// The forms of another mesh file are those that the mesh would start with; a field of the mesh sets the growth that an expression does.
#[test]
fn another_shape_and_fields_of_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let (flat, bent) = (folder.path().join("flat.vtk"), folder.path().join("bent.vtk"));
    let grid: Vec<[f64; 2]> = (0..=4).flat_map(|i| (0..=3).map(move |j| [0.1 * f64::from(i), 0.1 * f64::from(j)])).collect();
    let faces: Vec<[usize; 3]> = (0..4)
        .flat_map(|i| (0..3).flat_map(move |j| [[4 * i + j, 4 * i + j + 4, 4 * i + j + 5], [4 * i + j, 4 * i + j + 5, 4 * i + j + 1]]))
        .collect();
    let write = |path: &std::path::Path, place: &dyn Fn(&[f64; 2]) -> [f64; 3]| {
        let mut text = format!("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS {} double\n", grid.len());
        grid.iter().map(place).for_each(|[x, y, z]| text += &format!("{x:?} {y:?} {z:?}\n"));
        text += &format!("POLYGONS {} {}\n", faces.len(), 4 * faces.len());
        faces.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\n"));
        text += &format!("POINT_DATA {}\nSCALARS s double 1\nLOOKUP_TABLE default\n", grid.len());
        grid.iter().for_each(|[x, y]| text += &format!("{:?}\n", 0.3 * x - 0.2 * y));
        std::fs::write(path, text).unwrap();
    };
    write(&flat, &|[x, y]| [*x, *y, 0.0]);
    write(&bent, &|[x, y]| [1.1 * x, *y, x * x + 0.3 * x * y]);
    let file = |path: &std::path::Path| format!("[mesh.file]\npath = {:?}\n", path.display().to_string());
    for element in ELEMENTS {
        let (_, expected, _) = laws(&file(&bent), element, "");
        let (_, initial, rest) = laws(&file(&flat), element, &format!("[rest.shape.file]\npath = {:?}", bent.display().to_string()));
        let moved = initial.iter().zip(&expected).map(|(i, e)| (i.a[0] / e.a[0] - 1.0).abs()).fold(0.0, f64::max);
        assert!(moved > 0.1);
        for (r, e) in rest.iter().zip(&expected) {
            assert_close(r.a, e.a, 1e-12, element);
            assert_within(r.b, e.b, 1e-12 * bend(&expected), element);
        }
        let (_, _, field) = laws(&file(&flat), element, "[rest.isotropic]\ns = { field = \"s\" }");
        let (_, _, given) = laws(&file(&flat), element, "[rest.isotropic]\ns = \"0.3 * x - 0.2 * y\"");
        let (_, _, times) = laws(&file(&flat), element, "[rest.isotropic]\ns = { field = \"s\", times = \"2 * (1 + x)\" }");
        let (_, _, doubled) = laws(&file(&flat), element, "[rest.isotropic]\ns = \"2 * (1 + x) * (0.3 * x - 0.2 * y)\"");
        for (f, g) in times.iter().zip(&doubled) {
            assert_close(f.a, g.a, 1e-12, element);
        }
        for (f, g) in field.iter().zip(&given) {
            assert_close(f.a, g.a, 1e-12, element);
        }
    }
    // A shape of other faces.
    let other = format!(
        "{SQUARE}\n[shell]\nthickness = 0.01\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n[rest.shape.file]\npath = {:?}\n[statics]\n",
        bent.display().to_string()
    );
    let error = set_up(&other).err().map(|e| format!("{} {e}", e.exit_code())).unwrap_or_default();
    assert!(error.starts_with("2 ") && error.contains("bent.vtk") && error.contains("its faces are not those of the mesh"), "{error}");
}

#[test]
fn impossible_growth_names_the_face_and_the_value() {
    for (law, words) in [
        ("[rest.isotropic]\ns = \"800 * x\"", vec!["face ", "e^(2s)"]),
        ("[rest.orthotropic]\nfactors = [\"x - 0.3\", 1]\nangle = 0", vec!["face ", "growth factor -0."]),
        ("[rest.bilayer]\nm_plus = -60\nm_minus = 0\nmu = [0.02, 0.01]", vec!["face ", "m_plus = -60 % makes 1 + m mu = -0."]),
        ("[rest.prestress]\nplus_a = [-2, 0, 0]", vec!["face ", "m"]),
        ("[rest.surface]\nposition = [\"x\", \"x\", \"x\"]", vec!["face ", "no normal at"]),
        ("[rest.pullback]\nabar = [1, 1.5, 1]", vec!["face ", "positive definite"]),
        ("[rest.shape]\nfield = \"none\"", vec!["rest.shape.field", "there is no field 'none'"]),
        ("[rest.isotropic]\ns = { field = \"none\" }", vec!["rest.isotropic.s", "there is no field 'none'"]),
    ] {
        let text = format!(
            "{SQUARE}\n[shell]\nthickness = {H}\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n{law}\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[statics]\n"
        );
        let error = set_up(&text).err().map(|e| format!("{} {e}", e.exit_code())).unwrap_or_default();
        assert!(error.starts_with("2 ") && words.iter().all(|w| error.contains(w)), "{law}: {error}");
    }
}

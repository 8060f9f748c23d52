//! Swelling laws: which side becomes convex, how far, and along which axis (Chen et al. 2018, section 3).

use crate::physics_case::{Case, matrix, run, set_up, six_pins};
use nalgebra::{Matrix2, Rotation3, Vector3};
use thinshell::report::cylinder_distance;

const THICKNESS: f64 = 1e-3;
const MU: f64 = 1e-4;

/// A square sheet of side 0.05 whose fibres make `angle` degrees with x, wet by `top` and `bottom` percent; it swells along the fibres only.
fn sheet(angle: f64, top: f64, bottom: f64) -> String {
    format!(
        "[mesh.rectangle]\nsize = [0.05, 0.05]\ncells = [16, 16]\npattern = \"criss-cross\"\n{}\
         [shell]\nelement = \"linear\"\nthickness = {THICKNESS}\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
         [rest.linear]\nm_plus = {top}\nm_minus = {bottom}\nmu = {MU}\nmu_perp = 0.0\n[machine-direction]\nangle = {angle:?}\n[statics]\nsteps = 3\n",
        six_pins(0.025, 0.025, 0.003125, 0.003125)
    )
}

/// Exact stretch along the fibres and radius of the curl: on a flat sheet `abar = A dd + ee`, `bbar = B dd` is a cylinder of radius A / |B|.
fn exact(top: f64, bottom: f64) -> (f64, f64) {
    let [p, m] = [top, bottom].map(|m| (1.0 + m * MU).powi(2));
    let (a, b) = (0.5 * (p + m), (m - p) / (2.0 * THICKNESS));
    (a.sqrt(), a / b.abs())
}

/// Largest distance from the exact cylinder, relative to the sheet's size; its axis is orthogonal to the fibres.
fn distance(case: &Case, angle: f64, stretch: f64, radius: f64) -> f64 {
    // Turned so that the fibres lie along x, and stretched along them.
    let turn = Rotation3::new(Vector3::z() * -angle.to_radians());
    let place = |p: &Vector3<f64>| {
        let q = turn * (p - Vector3::new(0.025, 0.025, 0.0));
        Vector3::new(q.x * stretch, q.y, 0.0)
    };
    let initial: Vec<_> = case.mesh.vertices.iter().map(place).collect();
    cylinder_distance(&initial, &case.end, radius)
}

/// Mean height of the rim above the centre along the normal there; negative where the top is convex.
fn rise(case: &Case) -> f64 {
    let rim = &case.mesh.regions["boundary"].vertices;
    let centre = case.vertex(0.025, 0.025, 0.0).1;
    rim.iter().map(|v| case.end[*v].z - centre.z).sum::<f64>() / rim.len() as f64
}

#[test]
fn the_wet_side_becomes_convex_along_the_fibres() {
    for (angle, top, bottom) in [(0.0, 120.0, 0.0), (0.0, 0.0, 120.0), (90.0, 120.0, 0.0), (45.0, 120.0, 0.0), (45.0, -60.0, 60.0)] {
        let case = run(&sheet(angle, top, bottom));
        let (stretch, radius) = exact(top, bottom);
        let (error, rise) = (distance(&case, angle, stretch, radius), rise(&case));
        let wrong_axis = distance(&case, angle + 90.0, stretch, radius);
        println!("fibres {angle}, moisture {top} {bottom}: radius {radius}, error {error:e}, rise {rise:e}, wrong axis {wrong_axis:e}");
        assert!(rise * (top - bottom) < 0.0 && rise.abs() > 1e-3 * 0.05, "{rise}");
        assert!(error < 1e-3, "fibres at {angle} degrees: {error}");
        // The same measure tells a cylinder about the other axis apart.
        assert!(wrong_axis > 20.0 * error, "{wrong_axis}");
    }
}

/// In the limit of small strains the curvature is `mu (m+ - m-) / h`, with an error of the order of the strain.
#[test]
fn curvature_of_small_swelling() {
    let relative = |m: f64| exact(m, 0.0).1 * MU * m / THICKNESS - 1.0;
    let scene = |m: f64| {
        sheet(0.0, m, 0.0)
            .replace("[statics]\nsteps = 3", "[dynamics]\ndt = 1.0\nend = 1.0")
            .replace("thickness", "density = 1.0\nthickness")
    };
    for m in [1.0, 10.0] {
        let (mesh, setup, _) = set_up(&scene(m)).unwrap();
        for (f, forms) in setup.rest_forms.iter().enumerate() {
            let [v0, v1, v2] = mesh.faces[f].map(|v| mesh.vertices[v]);
            let t = Matrix2::from_columns(&[(v1 - v0).xy(), (v2 - v0).xy()]).try_inverse().unwrap();
            let (a, b) = (t.transpose() * matrix(forms.a) * t, t.transpose() * matrix(forms.b) * t);
            let curvature = b[(0, 0)] / a[(0, 0)];
            assert!((curvature * THICKNESS / (-MU * m) - 1.0).abs() < 1.01 * MU * m, "{curvature}");
            assert!(b[(1, 1)].abs() < 1e-10 * b[(0, 0)].abs() && (a[(1, 1)] - 1.0).abs() < 1e-12);
        }
    }
    assert!((relative(10.0) / relative(1.0) - 10.0).abs() < 0.1);
}

/// Fibres along x, along y and at any angle on a flat square: `abar = diag((1 + m mu)^2, (1 + m mu_perp)^2)` in their frame.
#[test]
fn machine_direction_stretches_along_and_across_the_fibres() {
    let (mu, mu_perp, m) = (0.003, -0.002, 20.0);
    for angle in [0.0, 90.0, 30.0, -77.0] {
        let scene = format!(
            "[mesh.rectangle]\nsize = [1.0, 1.0]\ncells = [3, 3]\njitter = 0.3\n[shell]\nelement = \"linear\"\nthickness = 0.01\ndensity = 1.0\nyoungs_modulus = 1.0\npoissons_ratio = 0.3\n\
             [rest.linear]\nm_plus = {m}\nm_minus = {m}\nmu = {mu}\nmu_perp = {mu_perp}\n[machine-direction]\nangle = {angle:?}\n[dynamics]\ndt = 1.0\nend = 1.0\n"
        );
        for sampling in ["edges", "centroid"] {
            let (mesh, setup, _) = set_up(&format!("{scene}[rest]\nsampling = \"{sampling}\"\n")).unwrap();
            for (f, forms) in setup.rest_forms.iter().enumerate() {
                let [v0, v1, v2] = mesh.faces[f].map(|v| mesh.vertices[v]);
                let (s, c) = f64::to_radians(angle).sin_cos();
                let q = Matrix2::new(c, -s, s, c);
                let t = Matrix2::from_columns(&[(v1 - v0).xy(), (v2 - v0).xy()]).try_inverse().unwrap() * q;
                let a = t.transpose() * matrix(forms.a) * t;
                let expected = Matrix2::new((1.0 + m * mu) * (1.0 + m * mu), 0.0, 0.0, (1.0 + m * mu_perp) * (1.0 + m * mu_perp));
                assert!((a - expected).norm() < 1e-12, "{sampling} {angle}: {a} {expected}");
                assert!(forms.b.iter().all(|b| b.abs() < 1e-12));
            }
        }
    }
}

/// On a curved sheet without growth the law is the initial shape: `gbar+- = a0 -+ h b0` must come back as `a0, b0`.
#[test]
fn no_moisture_changes_nothing_on_a_curved_shell() {
    let (_, setup, _) = set_up(
        "[mesh.cylinder]\nradius = 0.1\nlength = 0.2\nangle = 150.0\ncells = [8, 6]\n[shell]\nelement = \"linear\"\nthickness = 0.01\ndensity = 1.0\nyoungs_modulus = 1.0\npoissons_ratio = 0.3\n\
         [rest.linear]\nm_plus = 0.0\nm_minus = 0.0\nmu = 0.01\nmu_perp = 0.02\n[machine-direction]\nvector = [0.0, 1.0, 1.0]\n[dynamics]\ndt = 1.0\nend = 1.0\n",
    )
    .unwrap();
    // A face in a corner can be as flat as its neighbours; most are not.
    assert!(setup.initial_forms.iter().filter(|f| f.b.iter().any(|b| b.abs() > 1e-4)).count() > 80);
    for (rest, initial) in setup.rest_forms.iter().zip(&setup.initial_forms) {
        let scale = initial.a[0] + initial.a[2];
        for i in 0..3 {
            assert!((rest.a[i] - initial.a[i]).abs() < 1e-13 * scale, "{rest:?} {initial:?}");
            assert!((rest.b[i] - initial.b[i]).abs() < 1e-13 * scale / 0.01, "{rest:?} {initial:?}");
        }
    }
}

#[test]
fn swelling_to_nothing_is_refused_with_the_face() {
    let scene = sheet(0.0, 0.0, 0.0).replace("m_plus = 0", "m_plus = \"if(x > 0.04, -99, 0)\"").replace(&format!("mu = {MU}"), "mu = 0.02");
    let Err(error) = set_up(&scene) else { panic!("a sheet of negative length was accepted") };
    assert_eq!(error.exit_code(), 2);
    let text = error.to_string();
    assert!(text.contains("face ") && text.contains("m_plus") && text.contains("1 + m mu"), "{text}");
}

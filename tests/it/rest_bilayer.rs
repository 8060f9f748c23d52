//! Law `bilayer` on shells that are made of two layers: forms of least energy, Timoshenko's bimetal.

use crate::physics_case::{matrix, run, set_up, six_pins};
use nalgebra::Matrix2;
use thinshell::report::cylinder_distance;
use thinshell::shell::rest::Forms;

const H: f64 = 1e-3;

/// Timoshenko's (1925) curvature of a bimetal whose layers differ by `strain`: ratios `m` of their thicknesses, `n` of their moduli.
fn timoshenko(strain: f64, m: f64, n: f64) -> f64 {
    6.0 * strain * (1.0 + m).powi(2) / (H * (3.0 * (1.0 + m).powi(2) + (1.0 + m * n) * (m * m + 1.0 / (m * n))))
}

/// Keys of two layers with thicknesses and moduli of the ratios `m` and `n`, top to bottom.
fn layers(m: f64, n: f64) -> String {
    let top = H * m / (1.0 + m);
    format!("bilayer = {{ top_thickness = {top:?}, top = {{ youngs_modulus = {:?} }} }}\n", 1e9 * n)
}

/// A rectangle of these sides of the given material whose layers grow by these strains along x, and across it; statics if `steps`.
fn sheet(element: &str, size: [f64; 2], material: &str, [top, bottom]: [f64; 2], across: &str) -> String {
    format!(
        "[mesh.rectangle]\nsize = {size:?}\ncells = [8, 4]\njitter = 0.2\n{}\
         [shell]\nelement = \"{element}\"\nthickness = {H:?}\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n{material}\
         [rest.bilayer]\nm_plus = 1\nm_minus = 1\nmu = [{top:?}, {bottom:?}]\n{across}[statics]\nsteps = 1\n",
        six_pins(0.5 * size[0], 0.5 * size[1], size[0] / 8.0, size[1] / 4.0)
    )
}

/// Rest forms at the end of a scene's statics, which a start of dynamics shows.
fn rest_forms(scene: &str) -> (thinshell::mesh::Mesh, Vec<Forms>) {
    let scene =
        scene.replace("[statics]\nsteps = 1\n", "[dynamics]\ndt = 1.0\nend = 1.0\n").replace("[shell]\n", "[shell]\ndensity = 1.0\n");
    let (mesh, setup, _) = set_up(&scene).unwrap();
    (mesh, setup.rest_forms)
}

const ALONG: &str = "mu_perp = [0, 0]\n[machine-direction]\nvector = [1, 0, 0]\n";
const OBLIQUE: &str = "mu_perp = [0.03, -0.01]\n[machine-direction]\nvector = [1, 2, 0]\n";

fn largest(forms: &[Forms], part: fn(&Forms) -> [f64; 3]) -> f64 {
    forms.iter().flat_map(part).fold(0.0, |m, v| m.max(v.abs()))
}

fn differences(p: &[Forms], q: &[Forms]) -> [f64; 2] {
    let of = |part: fn(&Forms) -> [f64; 3]| {
        let pairs = p.iter().zip(q).flat_map(|(p, q)| part(p).into_iter().zip(part(q)));
        pairs.map(|(p, q)| (p - q).abs()).fold(0.0, f64::max) / largest(q, part)
    };
    [of(|f| f.a), of(|f| f.b)]
}

#[test]
fn equal_layers_swell_like_a_shell_of_one_material() {
    for element in ["linear", "quadratic"] {
        for across in ["", ALONG, OBLIQUE] {
            let forms = |material: &str| rest_forms(&sheet(element, [0.1, 0.05], material, [0.02, -0.01], across)).1;
            let ([one, equal], other) = (["", &layers(1.0, 1.0)].map(forms), forms(&layers(0.5, 1.0)));
            // Curved at all.
            assert!(largest(&one, |f| f.b) / largest(&one, |f| f.a) > 0.005 / H);
            assert!(differences(&equal, &one).iter().all(|d| *d < 1e-13), "{element}: {:?}", differences(&equal, &one));
            assert!(differences(&other, &one)[1] > 1e-2, "{:?}", differences(&other, &one));
        }
    }
}

/// On a curved shell the second forms agree as well; the first ones differ by `h b0 / 12` times the difference of the growths, since the law for
/// one material (Chen et al. 2018) weights the curvature there as in the second form.
#[test]
fn equal_layers_of_a_curved_shell() {
    let scene = |material: &str| {
        format!(
            "[mesh.cylinder]\nradius = 0.02\nlength = 0.03\ncells = [24, 4]\n\
             [shell]\nthickness = {H:?}\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n{material}\
             [rest.bilayer]\nm_plus = 1\nm_minus = 1\nmu = [0.02, -0.01]\n[statics]\nsteps = 1\n"
        )
    };
    let initial = set_up(&scene("")).unwrap().1.initial_forms;
    let [one, equal] = [String::new(), layers(1.0, 1.0)].map(|material| rest_forms(&scene(&material)).1);
    let [a, b] = differences(&equal, &one);
    let excess = (1.02f64.powi(2) - 0.99f64.powi(2)) * H / 12.0 * largest(&initial, |f| f.b) / largest(&one, |f| f.a);
    assert!(b < 1e-12, "{b}");
    assert!(a > 0.3 * excess && a < 1.01 * excess, "{a} {excess}");
}

/// The rest forms themselves: `kappa` along x, and across it too where the layers grow alike in all directions.
#[test]
fn rest_forms_of_a_bimetal_have_timoshenkos_curvature() {
    for (m, n) in [(0.5, 4.0), (2.0, 4.0), (0.25, 0.3), (3.0, 1.5), (1.0, 5.0)] {
        for (across, both) in [("", true), (ALONG, false)] {
            let error = |strain: f64| {
                let (mesh, forms) = rest_forms(&sheet("linear", [0.1, 0.05], &layers(m, n), [0.0, strain], across));
                let kappa = timoshenko(strain, m, n);
                let errors = forms.iter().zip(&mesh.faces).map(|(form, face)| {
                    let [v0, v1, v2] = face.map(|v| mesh.vertices[v]);
                    let t = Matrix2::from_columns(&[(v1 - v0).xy(), (v2 - v0).xy()]).try_inverse().unwrap();
                    let (a, b) = (t.transpose() * matrix(form.a) * t, t.transpose() * matrix(form.b) * t);
                    let (x, y) = (b[(0, 0)] / a[(0, 0)] / kappa, b[(1, 1)] / a[(1, 1)] / kappa);
                    // Bent towards the top, since the bottom has grown.
                    (x - 1.0).abs().max((y - f64::from(u8::from(both))).abs())
                });
                errors.fold(0.0, f64::max)
            };
            let errors = [1e-2, 1e-3, 1e-4].map(|strain| error(strain) / strain);
            println!("m {m} n {n} both {both}: relative errors over the strain {errors:?}");
            // Of the order of the strain, and that exactly.
            assert!(errors.iter().all(|e| *e < 3.0) && (errors[2] / errors[1] - 1.0).abs() < 0.05, "m {m} n {n}: {errors:?}");
        }
    }
}

/// A strip that grows along itself relaxes to a cylinder without stress.
#[test]
fn a_strip_of_two_metals_curls() {
    let (m, n, strain) = (0.25, 4.0, 1e-3);
    let radius = 1.0 / timoshenko(strain, m, n);
    for element in ["linear", "quadratic"] {
        let case = run(&sheet(element, [0.1, 0.02], &layers(m, n), [0.0, strain], ALONG).replace("[8, 4]", "[16, 4]"));
        let distance = |radius| cylinder_distance(&case.mesh.vertices, &case.end[..case.mesh.vertices.len()], radius);
        let [exact, other] = [radius, 1.3 * radius].map(distance);
        // The cylinder is of the initial length, which has grown by less than the strain.
        println!("{element}: radius {radius}, distance {exact:e}, to a larger one {other:e}");
        assert!(exact < 0.5 * strain && other > 5.0 * exact, "{element}: {exact} {other}");
        let [membrane, bending] = ["membrane_energy_J", "bending_energy_J"].map(|name| case.last(name));
        // Over the energy of bending it flat.
        let flat = 1e9 * H.powi(3) / 12.0 * 0.5 * radius.powi(-2) * 0.1 * 0.02;
        assert!((membrane + bending).abs() < 1e-4 * flat, "{element}: {membrane} {bending} {flat}");
    }
}

/// A plate that grows alike in all directions becomes a part of a sphere, as long as it rises by much less than its thickness.
#[test]
fn a_plate_of_two_metals_becomes_a_cap() {
    let (m, n, strain) = (0.25, 4.0, 1e-6);
    let scene = sheet("quadratic", [0.04, 0.03], &layers(m, n), [0.0, strain], "");
    let case = run(&scene.replace("[statics]", "[solver]\ntolerance = 1e-14\n[statics]").replace("jitter = 0.2\n", ""));
    let kappa = timoshenko(strain, m, n);
    let centre = case.vertex(0.02, 0.015, 0.0);
    for (x, y) in [(0.0, 0.0), (0.0, 0.03), (0.0, 0.015), (0.02, 0.0)] {
        // The mean of two opposite places, which a tilt does not change.
        let ends = [case.vertex(x, y, 0.0), case.vertex(0.04 - x, 0.03 - y, 0.0)];
        let rise = 0.5 * (ends[0].1.z + ends[1].1.z) - centre.1.z;
        let exact = 0.5 * kappa * (ends[0].0 - centre.0).norm_squared();
        println!("({x}, {y}): rise {rise:e}, exact {exact:e}");
        assert!((rise / exact - 1.0).abs() < 1e-3, "{rise} {exact}");
    }
}

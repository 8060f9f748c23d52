//! Laws of the material: derivatives, projections, limits in which one law is another, exact solutions at one point.

use crate::finite_differences::{bind, compare, crumple, dense, patch};
use nalgebra::{DMatrix, Matrix2, Matrix3, Rotation2, Vector3};
use thinshell::mesh::Topology;
use thinshell::shell::rest::Forms;
use thinshell::shell::{
    Bilayer, Constitution, Director, General, Koiter, Layer, LayerMetric, LinearFree, Material, Measure, Orthotropic, QuadraticFree, Shell,
    Uncoupled, koiter, rest_forms,
};
use thinshell::sparse::Curvature;

const SHEET: Material = Material { thickness: 0.3, youngs_modulus: 3.0, poissons_ratio: 0.3 };
const BILAYER: Bilayer = Bilayer { top_thickness: 0.1, youngs_moduli: [3.0, 1.0], poissons_ratios: [0.3, 0.1] };

fn wood(direction: [f64; 2]) -> Orthotropic {
    Orthotropic { youngs_moduli: [5.0, 2.0], poissons_ratio: 0.4, shear_modulus: 0.7, direction }
}

/// All laws.
fn laws() -> [(&'static str, Constitution); 7] {
    [
        ("plane stress", Constitution::PlaneStress),
        ("three-dimensional", Constitution::ThreeDimensional),
        ("orthotropic", Constitution::Orthotropic(wood([0.4, 0.9]))),
        ("bilayer", Constitution::Bilayer(BILAYER)),
        ("neo-hookean", Constitution::NeoHookean),
        ("tension field", Constitution::TensionField { compression: 0.05 }),
        ("Biot's bending", Constitution::BiotBending),
    ]
}

/// A crumpled shell of one law with its state, on the linear or the quadratic element.
fn crumpled(quadratic: bool, law: Constitution, viscosity: Option<f64>, stretch: [f64; 3]) -> (Box<dyn Shell>, Vec<f64>) {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let middles: Vec<_> = topology.edges.iter().map(|[a, b]| 0.5 * (mesh.vertices[*a] + mesh.vertices[*b])).collect();
    let free = vec![Director::Free; topology.edges.len()];
    let (nodes, angles, points) = if quadratic { ([&mesh.vertices[..], &middles].concat(), 2, 3) } else { (mesh.vertices.clone(), 1, 1) };
    let unknowns = 3 * nodes.len() + angles * topology.edges.len();
    let (x, mut rest, mut materials) = crumple(&nodes, unknowns, mesh.faces.len(), points, if quadratic { 0.05 } else { 0.1 });
    rest.iter_mut().for_each(|forms| forms.a.iter_mut().zip(stretch).for_each(|(a, s)| *a *= s));
    // A thickness at which the curvatures of the patch are those of a shell.
    materials.iter_mut().for_each(|m| m.thickness *= 0.3);
    let laws = vec![law; mesh.faces.len()];
    let mut shell = if quadratic {
        koiter(QuadraticFree::new(&mesh, &topology, &middles, Measure::Tan, &free), materials, laws, viscosity)
    } else {
        koiter(LinearFree::new(&mesh, &topology, Measure::Tan, &free), materials, laws, viscosity)
    };
    shell.set_rest(&rest);
    let start: Vec<f64> = x.iter().enumerate().map(|(i, x)| x + 0.01 * (i as f64).sin()).collect();
    shell.start_step(&start, 0.2);
    (shell, x)
}

#[test]
fn derivatives() {
    for (name, law) in laws() {
        for (quadratic, viscosity) in [(false, None), (false, Some(0.3)), (true, None), (true, Some(0.3))] {
            println!("{name}, quadratic {quadratic}, viscosity {viscosity:?}");
            let (mut shell, x) = crumpled(quadratic, law, viscosity, [1.0; 3]);
            compare(&mut *shell, &x);
        }
    }
}

/// Slack, wrinkled and taut, each over nearly all of the patch.
#[test]
fn derivatives_of_the_tension_field_in_each_state() {
    let law = Constitution::TensionField { compression: 0.05 };
    let count = |shell: &dyn Shell, x: &[f64], rest: [f64; 2]| {
        // Larger and smaller principal stress over E / (1 - nu^2) of St. Venant-Kirchhoff.
        let states = shell.forms(x).into_iter().map(|e| {
            let metric = Matrix2::new(1.1 * rest[0], 0.0, 0.0, 1.3 * rest[1]);
            let strain = (metric.try_inverse().unwrap() * Matrix2::new(e[0], e[1], e[1], e[2]) - Matrix2::identity()) * 0.5;
            let (mean, det) = (0.5 * strain.trace(), strain.determinant());
            let radius = (mean * mean - det).max(0.0).sqrt();
            let (e1, e2) = (mean + radius, mean - radius);
            if e1 <= 0.0 { 0 } else { 1 + usize::from(e2 + 0.3 * e1 > 0.0) }
        });
        states.fold([0; 3], |mut counts, state| {
            counts[state] += 1;
            counts
        })
    };
    for (state, scale) in [(0, [6.0, 6.0]), (1, [0.6, 9.2]), (2, [0.1, 0.1])] {
        for quadratic in [false, true] {
            let (mut shell, x) = crumpled(quadratic, law, None, [scale[0], 0.0, scale[1]]);
            let counts = count(&*shell, &x, scale);
            assert!(10 * counts[state] >= 9 * counts.iter().sum::<usize>(), "{counts:?}");
            compare(&mut *shell, &x);
        }
    }
}

fn smallest(shell: &mut dyn Shell, x: &[f64], curvature: Curvature) -> f64 {
    let (pattern, mut system) = bind(shell, x.len());
    shell.restart(x);
    shell.assemble(x, curvature, &mut system);
    let rows = dense(&pattern, &system.matrix);
    let values = DMatrix::from_fn(x.len(), x.len(), |i, j| 0.5 * (rows[i][j] + rows[j][i])).symmetric_eigenvalues();
    values.min() / values.max()
}

/// What descent on the energy relies on, in compression and bent.
#[test]
fn the_projected_hessian_is_positive_semidefinite() {
    for (name, law) in laws() {
        for quadratic in [false, true] {
            for stretch in [[1.8; 3], [0.6, 0.5, 2.0]] {
                let (mut shell, x) = crumpled(quadratic, law, None, stretch);
                let exact = smallest(&mut *shell, &x, Curvature::Mixed);
                let projected = smallest(&mut *shell, &x, Curvature::Projected);
                println!("{name} {quadratic} {stretch:?}: {exact:e} {projected:e}");
                assert!(exact < -1e-4 && projected > -1e-12, "{name}: {exact} {projected}");
            }
        }
    }
}

/// A law alone at one point: energy density and stress resultants per rest area.
fn at(law: Constitution, material: &Material, rest: &Forms, forms: &Forms) -> ([f64; 6], f64) {
    let (stress, [membrane, bending]) = law.per_area(material, rest, forms);
    (stress, membrane + bending)
}

const REST: Forms = Forms { a: [1.3, 0.4, 0.9], b: [0.2, -0.1, 0.3] };
const BENT: Forms = Forms { a: [1.5, 0.3, 0.8], b: [0.5, 0.2, -0.1] };

fn close(a: &[f64; 6], b: &[f64; 6], tolerance: f64) {
    let scale = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(scale > 1e-3 && a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance * scale), "{a:?} {b:?}");
}

#[test]
fn orthotropic_with_equal_moduli_is_isotropic_in_any_direction() {
    let (isotropic, energy) = at(Constitution::PlaneStress, &SHEET, &REST, &BENT);
    for direction in [[1.0, 0.0], [0.0, -2.0], [1e-3, 2e-3], [-3.0, 1.0]] {
        let equal = Orthotropic { youngs_moduli: [3.0, 3.0], poissons_ratio: 0.3, shear_modulus: 3.0 / 2.6, direction };
        let (stress, e) = at(Constitution::Orthotropic(equal), &SHEET, &REST, &BENT);
        close(&isotropic, &stress, 1e-14);
        assert!((e / energy - 1.0).abs() < 1e-14);
        assert!((equal.means()[0] - 3.0).abs() < 1e-15 && equal.means()[1] == 0.3);
        // The check is one of directions as well.
        let (other, _) = at(Constitution::Orthotropic(Orthotropic { youngs_moduli: [3.3, 3.0], ..equal }), &SHEET, &REST, &BENT);
        assert!(other.iter().zip(&isotropic).any(|(a, b)| (a - b).abs() > 1e-3));
    }
}

/// Pulled along and across the fibres, and sheared, in a skew basis.
#[test]
fn orthotropic_moduli_are_those_along_and_across_the_fibres() {
    let h = SHEET.thickness;
    // Columns: tangent vectors in a plane whose first axis lies at 30 degrees.
    let t = Matrix2::new(1.2, 0.3, -0.2, 0.9);
    let axes = *Rotation2::new(0.52).matrix();
    let direction = t.try_inverse().unwrap() * axes.column(0);
    let law = Constitution::Orthotropic(wood([direction.x, direction.y]));
    let form = |m: Matrix2<f64>| {
        let m = t.transpose() * axes * m * axes.transpose() * t;
        [m[(0, 0)], m[(0, 1)], m[(1, 1)]]
    };
    let rest = Forms { a: form(Matrix2::identity()), b: [0.0; 3] };
    let (e1, e2, nu12, g) = (5.0, 2.0, 0.4, 0.7);
    let s = 1e-3;
    for (strain, stress) in [
        // Stress e1 s along, none across; the same the other way round; pure shear.
        (Matrix2::new(s, 0.0, 0.0, -nu12 * s), Matrix2::new(e1 * s, 0.0, 0.0, 0.0)),
        (Matrix2::new(-nu12 * e2 / e1 * s, 0.0, 0.0, s), Matrix2::new(0.0, 0.0, 0.0, e2 * s)),
        (Matrix2::new(0.0, s, s, 0.0), Matrix2::new(0.0, 2.0 * g * s, 2.0 * g * s, 0.0)),
    ] {
        let expected = t.try_inverse().unwrap() * axes * stress * axes.transpose() * t.try_inverse().unwrap().transpose();
        let tensor = |d: &[f64]| Matrix2::new(d[0], 0.5 * d[1], 0.5 * d[1], d[2]);
        let (found, _) = at(law, &SHEET, &rest, &Forms { a: form(Matrix2::identity() + 2.0 * strain), ..rest });
        assert!((tensor(&found[..3]) * 2.0 - expected * h).norm() < 1e-12 * s, "{found:?} {expected}");
        let (found, _) = at(law, &SHEET, &rest, &Forms { b: form(strain), ..rest });
        assert!((tensor(&found[3..]) - expected * (h.powi(3) / 12.0)).norm() < 1e-12 * s, "{found:?} {expected}");
    }
}

#[test]
fn the_lame_parameter_of_a_body_is_that_of_the_paper() {
    let plain = Forms { a: [1.0, 0.0, 1.0], b: [0.0; 3] };
    let bent = Forms { b: [1.0, 0.0, 0.0], ..plain };
    let (e, nu) = (SHEET.youngs_modulus, SHEET.poissons_ratio);
    for (law, factor) in
        [(Constitution::PlaneStress, 1.0 / (1.0 - nu * nu)), (Constitution::ThreeDimensional, (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)))]
    {
        let (stress, _) = at(law, &SHEET, &plain, &bent);
        assert!((stress[3] / (e * factor * SHEET.thickness.powi(3) / 12.0) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn equal_layers_are_one() {
    let (one, energy) = at(Constitution::PlaneStress, &SHEET, &REST, &BENT);
    for top_thickness in [0.15, 0.02, 0.29] {
        let law = Bilayer { top_thickness, youngs_moduli: [3.0; 2], poissons_ratios: [0.3; 2] };
        let (two, e) = at(Constitution::Bilayer(law), &SHEET, &REST, &BENT);
        close(&one, &two, 1e-14);
        assert!((e / energy - 1.0).abs() < 1e-14);
    }
    let (other, _) = at(Constitution::Bilayer(BILAYER), &SHEET, &REST, &BENT);
    assert!(other.iter().zip(&one).any(|(a, b)| (a - b).abs() > 0.1 * b.abs()));
}

/// Energy of layers at one point by a quadrature through the thickness that is exact for it.
fn layered_energy(layers: &[Layer; 2], own: impl Fn(usize, f64) -> Matrix2<f64>, a0: Matrix2<f64>, forms: &Forms) -> f64 {
    let h = layers[0].thickness + layers[1].thickness;
    let inverse = a0.try_inverse().unwrap();
    let m = |f: [f64; 3]| Matrix2::new(f[0], f[1], f[1], f[2]);
    let starts = [0.5 * h - layers[0].thickness, -0.5 * h];
    let mut sum = 0.0;
    for (k, layer) in layers.iter().enumerate() {
        let (e, nu) = (layer.youngs_modulus, layer.poissons_ratio);
        for (at, weight) in [(0.5 - 0.15f64.sqrt(), 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + 0.15f64.sqrt(), 5.0 / 18.0)] {
            let z = starts[k] + at * layer.thickness;
            let strain = inverse * (m(forms.a) - m(forms.b) * (2.0 * z) - own(k, z)) * 0.5;
            let density = e / (2.0 * (1.0 - nu * nu)) * (nu * strain.trace().powi(2) + (1.0 - nu) * (strain * strain).trace());
            sum += weight * layer.thickness * density;
        }
    }
    sum
}

#[test]
fn the_layers_energy_is_that_of_its_layers() {
    let layers = BILAYER.layers(SHEET.thickness);
    let m = |f: [f64; 3]| Matrix2::new(f[0], f[1], f[1], f[2]);
    let exact = layered_energy(&layers, |_, z| m(REST.a) - m(REST.b) * (2.0 * z), m(REST.a), &BENT);
    let (_, energy) = at(Constitution::Bilayer(BILAYER), &SHEET, &REST, &BENT);
    assert!((energy / exact - 1.0).abs() < 1e-13, "{energy} {exact}");
}

#[test]
fn rest_forms_of_layers_have_the_least_energy() {
    let a0 = [1.3, 0.4, 0.9];
    let m = |f: [f64; 3]| Matrix2::new(f[0], f[1], f[1], f[2]);
    let own = [
        LayerMetric { middle: [1.5, 0.3, 1.0], slope: [0.2, -0.3, 0.4] },
        LayerMetric { middle: [1.2, 0.5, 1.1], slope: [-0.6, 0.1, 0.3] },
    ];
    let layers = [
        Layer { thickness: 0.1, youngs_modulus: 3.0, poissons_ratio: 0.3 },
        Layer { thickness: 0.25, youngs_modulus: 1.0, poissons_ratio: -0.2 },
    ];
    let middles = [0.125, -0.05];
    let energy = |forms: &Forms| layered_energy(&layers, |k, z| m(own[k].middle) + m(own[k].slope) * (z - middles[k]), m(a0), forms);
    let best = rest_forms(&layers, &own, a0);
    let least = energy(&best);
    assert!(least > 0.0);
    for i in 0..6 {
        for d in [1e-3, -1e-3] {
            let mut other = best;
            if i < 3 {
                other.a[i] += d
            } else {
                other.b[i - 3] += d
            }
            let mut mirrored = best;
            if i < 3 {
                mirrored.a[i] -= d
            } else {
                mirrored.b[i - 3] -= d
            }
            let (e, f) = (energy(&other), energy(&mirrored));
            // A quadratic's minimum: it grows alike on both sides.
            assert!(e > least && ((e - f) / (e - least)).abs() < 1e-6, "{i}: {e} {f} {least}");
        }
    }
}

/// Equal layers: `abar = (g+ + g-)/2`, `bbar = 3/(4h) (g- - g+)`, and no growth changes nothing.
#[test]
fn rest_forms_of_equal_layers() {
    let (a0, b0, h) = ([1.3, 0.4, 0.9], [0.2, -0.1, 0.3], 0.2);
    let layers = [Layer { thickness: 0.1, youngs_modulus: 3.0, poissons_ratio: 0.3 }; 2];
    let (top, bottom) = ([1.5, 0.3, 1.0], [1.2, 0.5, 1.1]);
    let flat = |middle| LayerMetric { middle, slope: [0.0; 3] };
    let found = rest_forms(&layers, &[flat(top), flat(bottom)], a0);
    for i in 0..3 {
        assert!((found.a[i] - 0.5 * (top[i] + bottom[i])).abs() < 1e-14);
        assert!((found.b[i] - 0.75 / h * (bottom[i] - top[i])).abs() < 1e-13);
    }
    let shifted = |z: f64| LayerMetric { middle: std::array::from_fn(|i| a0[i] - 2.0 * z * b0[i]), slope: b0.map(|b| -2.0 * b) };
    for layers in
        [layers, [Layer { thickness: 0.05, youngs_modulus: 7.0, ..layers[0] }, Layer { thickness: 0.15, poissons_ratio: 0.1, ..layers[1] }]]
    {
        let z = [0.5 * layers[1].thickness, -0.5 * layers[0].thickness];
        let found = rest_forms(&layers, &z.map(shifted), a0);
        for i in 0..3 {
            assert!((found.a[i] - a0[i]).abs() < 1e-14 && (found.b[i] - b0[i]).abs() < 1e-13, "{found:?}");
        }
    }
}

/// Curvature of a plate whose top layer grows by `strain` in all directions (Timoshenko 1925; equal Poisson's ratios).
fn timoshenko(strain: f64, h: f64, m: f64, n: f64) -> f64 {
    let square = (1.0 + m).powi(2);
    6.0 * strain * square / (h * (3.0 * square + (1.0 + m * n) * (m * m + 1.0 / (m * n))))
}

#[test]
fn a_bimetal_bends_as_timoshenko_says() {
    let (h, a0) = (2e-3, [1.3, 0.4, 0.9]);
    for (m, n) in [(1.0, 1.0), (0.5, 3.0), (2.0, 0.1), (0.1, 20.0)] {
        let errors: Vec<f64> = [1e-3, 1e-4]
            .iter()
            .map(|strain| {
                let t = h / (1.0 + m);
                let layers = [(h - t, n * 1e9), (t, 1e9)];
                let layers = layers.map(|(thickness, youngs_modulus)| Layer { thickness, youngs_modulus, poissons_ratio: 0.3 });
                let flat = |s: f64| LayerMetric { middle: a0.map(|a| (1.0 + s) * (1.0 + s) * a), slope: [0.0; 3] };
                let found = rest_forms(&layers, &[flat(*strain), flat(0.0)], a0);
                let kappa = timoshenko(*strain, h, m, n);
                // Isotropic, and the top convex: b = -kappa a.
                let curvature: Vec<f64> = (0..3).map(|i| -found.b[i] / found.a[i]).collect();
                assert!(curvature.iter().all(|k| (k / curvature[0] - 1.0).abs() < 1e-10));
                (curvature[0] / kappa - 1.0).abs()
            })
            .collect();
        assert!(errors[0] < 2e-3 && errors[1] < 0.11 * errors[0], "{m} {n}: {errors:?}");
    }
}

/// Relative difference of energies from St. Venant-Kirchhoff at a strain of some size.
fn difference(direction: &Forms, size: f64) -> f64 {
    let rest = Forms { a: [1.3, 0.4, 0.9], b: [0.0; 3] };
    let mix = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|i| p[i] + size * q[i]);
    let forms = Forms { a: mix(rest.a, direction.a), b: mix(rest.b, direction.b) };
    let [rubber, linear] = [Constitution::NeoHookean, Constitution::PlaneStress].map(|law| at(law, &SHEET, &rest, &forms).1);
    (rubber / linear - 1.0).abs()
}

/// The difference is of the order of the strain where the strain has a sign, and of its square in bending, where it has both.
#[test]
fn neo_hookean_is_st_venant_kirchhoff_at_small_strain() {
    for (name, direction, order) in [
        ("membrane", Forms { a: [0.7, -0.2, 0.4], b: [0.0; 3] }, 1.0),
        ("shear", Forms { a: [0.3, 0.9, -0.4], b: [0.0; 3] }, 1.0),
        ("bending", Forms { a: [0.0; 3], b: [0.7, -0.2, 0.4] }, 2.0),
        ("both", Forms { a: [0.1, 0.3, 0.2], b: [0.7, -0.2, 0.4] }, 1.0),
    ] {
        let errors: Vec<f64> = [1e-1, 1e-2, 1e-3].iter().map(|size| difference(&direction, *size)).collect();
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log10()).collect();
        println!("{name}: {errors:?}, orders {orders:?}");
        assert!(errors[2] < 1e-2 && (orders[1] - order).abs() < 0.1, "{name}: {errors:?} {orders:?}");
        // No digits are lost on the way to nothing.
        assert!(difference(&direction, 1e-8) < 1e-7, "{name}");
    }
}

/// Thickness and width of a sheet pulled by `stretch` along, from the condition that neither carries stress: both stretch alike, by `s`, with
/// `mu (s^2 - 1) + lambda ln(stretch s^2) = 0`; nominal stress `mu (l - 1/l) + lambda ln(J) / l`.
#[test]
fn a_rubber_sheet_under_uniaxial_pull_is_exact() {
    for nu in [0.0, 0.3, 0.45, 0.499, -0.2] {
        let material = Material { poissons_ratio: nu, ..SHEET };
        let (e, h) = (material.youngs_modulus, material.thickness);
        let (mu, lambda) = (e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
        for l in [0.6, 0.9, 1.1, 1.5, 3.0f64] {
            let free = |s: f64| mu * (s * s - 1.0) + lambda * (l * s * s).ln();
            let (mut low, mut high) = (if lambda < 0.0 { (-lambda / mu).sqrt() } else { 1e-3 }, 10.0);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if free(middle) > 0.0 { high = middle } else { low = middle }
            }
            let s = 0.5 * (low + high);
            let rest = Forms { a: [1.0, 0.0, 1.0], b: [0.0; 3] };
            let (stress, energy) = at(Constitution::NeoHookean, &material, &rest, &Forms { a: [l * l, 0.0, s * s], ..rest });
            let nominal = mu * (l - 1.0 / l) + lambda * (l * s * s).ln() / l;
            // dW/da11 = h P / (2 l).
            assert!((2.0 * l * stress[0] / h - nominal).abs() < 1e-11 * e, "nu {nu} l {l}: {} {nominal}", 2.0 * l * stress[0] / h);
            assert!(stress[2].abs() < 1e-11 * e * h, "nu {nu} l {l}: {stress:?}");
            let j = (l * s * s).ln();
            let exact = 0.5 * mu * (l * l + 2.0 * s * s - 3.0 - 2.0 * j) + 0.5 * lambda * j * j;
            assert!((energy / h - exact).abs() < 1e-12 * exact.max(e), "nu {nu} l {l}");
        }
    }
}

#[test]
fn a_rubber_sheet_turned_inside_out_has_no_energy() {
    let rest = Forms { a: [1.0, 0.0, 1.0], b: [0.0; 3] };
    for forms in [
        Forms { a: [-1.0, 0.0, 1.0], ..rest },
        Forms { a: [-1.0, 0.0, -1.0], ..rest },
        Forms { a: [1.0, 2.0, 1.0], ..rest },
        Forms { b: [10.0, 0.0, 0.0], ..rest },
    ] {
        assert!(at(Constitution::NeoHookean, &SHEET, &rest, &forms).0[0].is_nan());
        assert!(!Constitution::NeoHookean.admits(&SHEET, &forms));
        assert!(Constitution::PlaneStress.admits(&SHEET, &forms));
    }
    assert!(Constitution::NeoHookean.admits(&SHEET, &rest));
}

/// Energy and stress of the tension field on the way from slack to taut: no jumps, and the right values in each state.
#[test]
fn the_tension_field_is_continuous_and_right_in_each_state() {
    let c = 0.01;
    let law = Constitution::TensionField { compression: c };
    let rest = Forms { a: [1.3, 0.4, 0.9], b: [0.0; 3] };
    let (e, nu, h) = (SHEET.youngs_modulus, SHEET.poissons_ratio, SHEET.thickness);
    // Columns: a frame that is orthonormal at rest, turned by some angle.
    let metric = Matrix2::new(1.3, 0.4, 0.4, 0.9);
    let l = metric.cholesky().unwrap().l();
    let stretched = |e1: f64, e2: f64| {
        let turn = *Rotation2::new(0.7).matrix();
        let m = l * (Matrix2::identity() + turn * Matrix2::new(e1, 0.0, 0.0, e2) * turn.transpose() * 2.0) * l.transpose();
        Forms { a: [m[(0, 0)], m[(0, 1)], m[(1, 1)]], ..rest }
    };
    let psi = |e1: f64, e2: f64| h * e / (2.0 * (1.0 - nu * nu)) * (e1 * e1 + e2 * e2 + 2.0 * nu * e1 * e2);
    for (e1, e2, relaxed) in
        [(0.1, 0.02, psi(0.1, 0.02)), (0.1, -0.01, psi(0.1, -0.01)), (0.1, -0.2, 0.5 * h * e * 0.01), (-0.05, -0.1, 0.0)]
    {
        let (_, energy) = at(law, &SHEET, &rest, &stretched(e1, e2));
        let expected = (1.0 - c) * relaxed + c * psi(e1, e2);
        assert!((energy / expected - 1.0).abs() < 1e-12, "{e1} {e2}: {energy} {expected}");
    }
    // Across both borders: e2 = -nu e1 and e1 = 0.
    for (border, across) in [([0.1, -0.03], [0.0, 1.0]), ([0.0, -0.1], [1.0, 0.0])] {
        let jumps: Vec<f64> = [1e-4, 1e-5]
            .iter()
            .map(|d| {
                let side = |s: f64| at(law, &SHEET, &rest, &stretched(border[0] + s * d * across[0], border[1] + s * d * across[1]));
                let ((s1, e1), (s2, e2)) = (side(1.0), side(-1.0));
                assert!((e1 - e2).abs() < 2.0 * d * h * e, "{border:?}");
                s1.iter().zip(&s2).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()))
            })
            .collect();
        // The stress differs by the step, not by a jump.
        assert!(jumps[0] > 0.0 && jumps[1] < 0.11 * jumps[0], "{border:?} {jumps:?}");
    }
    let all = Constitution::TensionField { compression: 1.0 };
    let [tension, linear] = [all, Constitution::PlaneStress].map(|law| at(law, &SHEET, &REST, &Forms { a: [0.9, 0.3, 0.8], ..BENT }));
    close(&linear.0, &tension.0, 1e-14);
}

/// The general evaluation gives what the fast one gives, for all laws that have both, in energies, gradient, matrix and lagged stresses.
#[test]
fn the_general_evaluation_is_the_fast_one() {
    let mesh = patch();
    let topology = Topology::new(&mesh.faces);
    let free = vec![Director::Free; topology.edges.len()];
    let (x, rest, materials) = crumple(&mesh.vertices, 3 * mesh.vertices.len() + topology.edges.len(), mesh.faces.len(), 1, 0.1);
    let dx: Vec<f64> = (0..x.len()).map(|i| 0.01 * (i as f64).cos()).collect();
    for (_, law) in laws().into_iter().filter(|(_, law)| law.is_uncoupled()) {
        let element = || LinearFree::new(&mesh, &topology, Measure::Tan, &free);
        let laws = vec![law; mesh.faces.len()];
        let mut fast: Koiter<_, 12, 1, Uncoupled> = Koiter::with_law(element(), materials.clone(), laws.clone(), Some(0.3));
        let mut general: Koiter<_, 12, 1, General> = Koiter::with_law(element(), materials.clone(), laws, Some(0.3));
        let mut results = Vec::new();
        for shell in [&mut fast as &mut dyn Shell, &mut general] {
            shell.set_rest(&rest);
            shell.start_step(&x, 0.2);
            let (_, mut system) = bind(shell, x.len());
            shell.restart(&x);
            shell.extrapolate(&x, &dx);
            let moved: Vec<f64> = x.iter().zip(&dx).map(|(x, d)| x + d).collect();
            shell.assemble(&moved, Curvature::Mixed, &mut system);
            results.push([
                shell.lagged(),
                system.gradient,
                system.matrix,
                shell.energies(&moved).to_vec(),
                vec![shell.stiffness_along(&x, &dx)],
            ]);
        }
        for (a, b) in results[0].iter().zip(&results[1]) {
            let scale = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            assert!(scale > 0.0 && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-13 * scale));
        }
    }
}

/// The lagged stress of the mixed iteration follows the linearised law.
#[test]
fn lagged_stresses_follow_the_tangent() {
    for (name, law) in laws() {
        let (mut shell, x) = crumpled(false, law, None, [1.0; 3]);
        bind(&mut *shell, x.len());
        let errors: Vec<f64> = [1e-3, 1e-4]
            .iter()
            .map(|size| {
                let dx: Vec<f64> = (0..x.len()).map(|i| size * (i as f64).cos()).collect();
                shell.restart(&x);
                shell.extrapolate(&x, &dx);
                let lagged = shell.lagged();
                let moved: Vec<f64> = x.iter().zip(&dx).map(|(x, d)| x + d).collect();
                shell.restart(&moved);
                lagged.iter().zip(shell.lagged()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()))
            })
            .collect();
        // What is left is of second order.
        assert!(errors[0] > 0.0 && errors[1] < 0.012 * errors[0], "{name}: {errors:?}");
    }
}

/// The shell's energies add up, and are the fields' densities times the areas.
#[test]
fn energies_add_up() {
    for (name, law) in laws() {
        let (shell, x) = crumpled(true, law, None, [1.0; 3]);
        let [membrane, bending] = shell.energies(&x);
        let all = shell.energy(&x);
        assert!(membrane > 0.0 && (membrane + bending - all).abs() < 1e-13 * all.abs(), "{name}: {membrane} {bending} {all}");
        assert!(law.couples() || bending > 0.0);
    }
}

/// Components of stress and moment in space: of a sheet in the xy plane, pulled along x and bent about y.
#[test]
fn fields_show_each_law() {
    let r = [Vector3::new(1.2, -0.2, 0.0), Vector3::new(0.3, 0.9, 0.0)];
    let t = Matrix2::new(1.2, 0.3, -0.2, 0.9);
    let form = |m: Matrix2<f64>| {
        let m = t.transpose() * m * t;
        [m[(0, 0)], m[(0, 1)], m[(1, 1)]]
    };
    let rest = Forms { a: form(Matrix2::identity()), b: [0.0; 3] };
    let (s, k) = (1e-6, 1e-6);
    let forms = Forms { a: form(Matrix2::new(1.0 + 2.0 * s, 0.0, 0.0, 1.0)), b: form(Matrix2::new(k, 0.0, 0.0, 0.0)) };
    let direction = t.try_inverse().unwrap().column(0).into_owned();
    let (h, e, nu) = (SHEET.thickness, SHEET.youngs_modulus, SHEET.poissons_ratio);
    let d = h.powi(3) / 12.0;
    let plate = e / (1.0 - nu * nu);
    let fibres = 5.0 / (1.0 - 0.4 * 0.4 * 0.4);
    let q = |k: usize| BILAYER.youngs_moduli[k] / (1.0 - BILAYER.poissons_ratios[k].powi(2));
    // Layers: from 0.05 to 0.15 and from -0.15 to 0.05.
    let moment = |n: i32| (q(0) * (0.15f64.powi(n) - 0.05f64.powi(n)) + q(1) * (0.05f64.powi(n) - (-0.15f64).powi(n))) / f64::from(n);
    for (law, n11, m11) in [
        (Constitution::PlaneStress, plate * h * s, plate * d * k),
        (Constitution::Orthotropic(wood([direction.x, direction.y])), fibres * h * s, fibres * d * k),
        (Constitution::Bilayer(BILAYER), moment(1) * s - moment(2) * k, moment(3) * k - moment(2) * s),
        (Constitution::NeoHookean, plate * h * s, plate * d * k),
        (Constitution::TensionField { compression: 0.1 }, plate * h * s, plate * d * k),
        (Constitution::BiotBending, plate * h * s, plate * d * k),
    ] {
        let fields = thinshell::shell::fields::at_point(&r, &forms, &rest, &SHEET, &law);
        let [n, m]: [Matrix3<f64>; 2] = [fields.membrane_stress * h, fields.bending_moment];
        assert!((n[(0, 0)] / n11 - 1.0).abs() < 1e-5 && (m[(0, 0)] / m11 - 1.0).abs() < 1e-5, "{law:?}: {n} {n11}, {m} {m11}");
        let energy = fields.membrane_energy_density + fields.bending_energy_density;
        assert!((energy / (0.5 * (n11 * s + m11 * k)) - 1.0).abs() < 1e-5, "{law:?}: {energy}");
    }
}

/// Stretched by 1 + e with a turn k per length at rest: the bending strain is k (1 - 3 e^2 / 2), so that it is no reason to stretch, in any direction and
/// whatever the coordinates.
#[test]
fn biots_bending_does_not_stretch() {
    let t = Matrix2::new(1.3, 0.2, 0.0, 0.8);
    let form = |m: Matrix2<f64>| {
        let m = t.transpose() * m * t;
        [m[(0, 0)], m[(0, 1)], m[(1, 1)]]
    };
    let rest = Forms { a: form(Matrix2::identity()), b: form(Matrix2::new(0.1, 0.0, 0.0, 0.0)) };
    let k = 0.9;
    let at = |law: Constitution, e: f64| {
        let l = 1.0 + e;
        let forms = Forms { a: form(Matrix2::new(l * l, 0.0, 0.0, 1.0)), b: form(Matrix2::new(l * k, 0.0, 0.0, 0.0)) };
        law.per_area(&SHEET, &rest, &forms).1
    };
    let slope = |law: Constitution| (at(law, 1e-4).iter().sum::<f64>() - at(law, -1e-4).iter().sum::<f64>()) / 2e-4;
    let bending = at(Constitution::BiotBending, 0.0).iter().sum::<f64>();
    assert!(slope(Constitution::BiotBending).abs() < 1e-5 * bending, "{:e} {bending:e}", slope(Constitution::BiotBending));
    assert!(slope(Constitution::PlaneStress) > 0.5 * bending);
    // Without stretch it is St. Venant-Kirchhoff.
    let [own, koiter] = [Constitution::BiotBending, Constitution::PlaneStress].map(|law| at(law, 0.0)[1]);
    assert!((own / koiter - 1.0).abs() < 1e-12 && own > 0.0);
}

//! Laws driven by a profile through the thickness, against sums over many thin layers and against the laws for two sides.

use nalgebra::{Matrix2, Vector3};
use thinshell::shell::Bilayer;
use thinshell::shell::rest::{Expansion, Forms, Law, MachineDirection, Profile, Site, Swelling};

const H: f64 = 2e-3;

/// A curved, sheared site.
fn site() -> Site {
    Site {
        face: 0,
        place: [0.2, 0.3],
        position: Vector3::zeros(),
        tangents: [Vector3::new(1.0, 0.2, 0.0), Vector3::new(-0.3, 0.8, 0.0)],
        initial: Forms { a: [1.04, -0.14, 0.73], b: [0.9, 0.4, -1.3] },
        thickness: H,
    }
}

fn flat() -> Site {
    let site = site();
    Site { initial: Forms { b: [0.0; 3], ..site.initial }, ..site }
}

fn fibres() -> MachineDirection {
    MachineDirection::PerFace(vec![[0.7, 0.5]])
}

/// The law for values on equidistant levels.
fn law(values: &[f64], mu: [f64; 2], across: Option<[f64; 2]>, layers: Vec<Option<Bilayer>>) -> Expansion {
    let (n, values) = (values.len() - 1, values.to_vec());
    Expansion {
        quantity: ["moisture", "%"],
        levels: (0..=n).map(|i| i as f64 / n as f64).collect(),
        value: Box::new(move |_, level| values[level]),
        mu,
        fibres: across.map(|mu| (mu, fibres())),
        layers,
    }
}

/// The law of the two sides.
fn sides(curved: bool, profile: Profile, top: f64, bottom: f64, mu: [f64; 2], across: Option<[f64; 2]>) -> Forms {
    let moisture: [thinshell::shell::rest::ScalarField; 2] = [Box::new(move |_, _| top), Box::new(move |_, _| bottom)];
    let site = if curved { site() } else { flat() };
    Swelling { profile, moisture, mu, fibres: across.map(|mu| (mu, fibres())), prescribed: false }.forms(&site, 0.0).unwrap()
}

fn matrix(m: [f64; 3]) -> Matrix2<f64> {
    Matrix2::new(m[0], m[1], m[1], m[2])
}

/// `1/h int gbar dz` and `-6/h^3 int z gbar dz` by the midpoint rule, with `F` from its eigenvectors.
fn by_layers(site: &Site, u: impl Fn(f64) -> f64, mu: [f64; 2]) -> [Matrix2<f64>; 2] {
    let (a, d) = (matrix(site.initial.a), nalgebra::Vector2::new(0.7, 0.5));
    // The tensors d d^T a / (d.a.d) and its complement project onto the fibres and across them.
    let along = d * (a * d).transpose() / d.dot(&(a * d));
    let across = Matrix2::identity() - along;
    let count = 4000;
    let mut sums = [Matrix2::zeros(); 2];
    for k in 0..count {
        let z = H * ((k as f64 + 0.5) / count as f64 - 0.5);
        let m = u(z / H + 0.5);
        let f = along * (1.0 + mu[0] * m) + across * (1.0 + mu[1] * m);
        let g = f.transpose() * (a - matrix(site.initial.b) * (2.0 * z)) * f;
        sums[0] += g / count as f64;
        sums[1] -= g * (6.0 * z / (H * H) / count as f64);
    }
    sums
}

fn distance(a: &Matrix2<f64>, b: &Matrix2<f64>) -> f64 {
    (a - b).norm() / b.norm()
}

#[test]
fn a_profile_has_the_moments_of_its_thin_layers() {
    let values = [3.0, -1.0, 0.5, 7.0, 2.0];
    let u = |x: f64| {
        let i = ((4.0 * x) as usize).min(3);
        values[i] + (values[i + 1] - values[i]) * (4.0 * x - i as f64)
    };
    let (mu, across) = (0.02, -0.035);
    let site = site();
    let forms = law(&values, [mu; 2], Some([across; 2]), Vec::new()).forms(&site, 0.0).unwrap();
    let [a, b] = by_layers(&site, u, [mu, across]);
    // Swelling has changed both forms by much more than what is left.
    assert!(distance(&a, &matrix(site.initial.a)) > 1e-2 && distance(&b, &matrix(site.initial.b)) > 1.0);
    assert!(distance(&matrix(forms.a), &a) < 1e-6, "{}", distance(&matrix(forms.a), &a));
    assert!(distance(&matrix(forms.b), &b) < 1e-6, "{}", distance(&matrix(forms.b), &b));
}

#[test]
fn nothing_swells_without_moisture() {
    let site = site();
    let forms = law(&[0.0; 4], [0.1; 2], Some([0.2; 2]), Vec::new()).forms(&site, 0.0).unwrap();
    for (now, before) in forms.a.iter().chain(&forms.b).zip(site.initial.a.iter().chain(&site.initial.b)) {
        assert_eq!(now, before);
    }
}

/// The law `linear` to first order in the strain: what differs falls with its square. On a curved shell this holds for the second form; the
/// row weights curvature in the first one three times as much (`h (g- - g+) b0 / 2` for a third of it), by `h b0` times the difference of the growths.
#[test]
fn a_linear_profile_is_the_law_linear_to_first_order() {
    for (curved, across) in [(false, None), (true, None), (false, Some([-0.5; 2])), (true, Some([-0.5; 2]))] {
        let difference = |strain: f64| {
            let across = across.map(|mu: [f64; 2]| mu.map(|mu| mu * strain));
            let law = law(&[-1.0, 0.5, 2.0], [strain; 2], across, Vec::new());
            let all = if curved { law.forms(&site(), 0.0) } else { law.forms(&flat(), 0.0) }.unwrap();
            let two = sides(curved, Profile::Linear, 2.0, -1.0, [strain; 2], across);
            let start = site().initial;
            assert!(distance(&matrix(two.b), &matrix(start.b)) > 10.0 * strain, "the law changes the second form");
            [distance(&matrix(all.a), &matrix(two.a)), distance(&matrix(all.b), &matrix(two.b)) * matrix(two.b).norm()]
        };
        let (coarse, fine) = (difference(1e-3), difference(5e-4));
        for i in usize::from(curved)..2 {
            let order = (coarse[i] / fine[i]).log2();
            // On a flat shell the second forms are the same altogether.
            assert!(order > 1.9 || (!curved && i == 1 && coarse[i] < 1e-12), "part {i}: order {order} from {coarse:?} to {fine:?}");
        }
    }
}

/// A jump at mid-thickness, by layers that swell differently under the same moisture, is the row `bilayer` exactly.
#[test]
fn two_halves_are_the_law_bilayer() {
    for across in [None, Some([0.01, 0.03])] {
        let mu = [0.02, -0.01];
        let all = law(&[1.0; 6], mu, across, Vec::new()).forms(&flat(), 0.0).unwrap();
        let two = sides(false, Profile::Bilayer(Vec::new()), 1.0, 1.0, mu, across);
        assert!(distance(&matrix(two.a), &matrix(flat().initial.a)) > 1e-3 && matrix(two.b).norm() > 1.0);
        assert!(distance(&matrix(all.a), &matrix(two.a)) < 1e-14 && distance(&matrix(all.b), &matrix(two.b)) < 1e-13);
    }
}

#[test]
fn layers_of_their_own_moduli_have_the_forms_of_least_energy() {
    let layers = vec![Some(Bilayer { top_thickness: 0.2 * H, youngs_moduli: [1e9, 2e10], poissons_ratios: [0.2, 0.4] })];
    let mu = [0.02, -0.01];
    let all = law(&[1.0; 4], mu, Some([0.0, 0.01]), layers.clone()).forms(&flat(), 0.0).unwrap();
    let two = sides(false, Profile::Bilayer(layers.clone()), 1.0, 1.0, mu, Some([0.0, 0.01]));
    let alike = sides(false, Profile::Bilayer(Vec::new()), 1.0, 1.0, mu, Some([0.0, 0.01]));
    assert!(distance(&matrix(alike.b), &matrix(two.b)) > 0.05, "the moduli matter");
    assert!(distance(&matrix(all.a), &matrix(two.a)) < 1e-13 && distance(&matrix(all.b), &matrix(two.b)) < 1e-12);
    // Without moisture a curved layered shell keeps its forms.
    let dry = law(&[0.0; 4], mu, None, layers).forms(&site(), 0.0).unwrap();
    let start = site().initial;
    assert!(distance(&matrix(dry.a), &matrix(start.a)) < 1e-13 && distance(&matrix(dry.b), &matrix(start.b)) < 1e-12);
}

#[test]
fn what_would_shrink_to_nothing_is_refused_with_the_value() {
    let error = law(&[0.0, -30.0, 0.0], [0.05; 2], None, Vec::new()).forms(&site(), 0.0).unwrap_err().reason;
    assert!(error.contains("-30 %") && error.contains("> 0"), "{error}");
}

//! A rest metric taken by the edges' lengths does not prestress the sheet; taken at centroids it does.

use crate::physics_case::{Kind, capped, forms, free, model, shell, unknowns};
use nalgebra::Vector3;
use thinshell::mesh::{Mesh, Topology, generate};
use thinshell::model::RestDriver;
use thinshell::shell::rest::{Components, Pullback, Sampling, ScalarField, Site};
use thinshell::shell::{LinearInterpolation, Material};

/// Energy over `E h^3` of the annulus r in [0.1, 1.1] with the metric of the unit sphere and no rest curvature, relaxed from the exact cap.
fn energy(pattern: generate::Pattern, cells: [usize; 2], h: f64, sampling: Sampling) -> f64 {
    let flat = generate::annulus([0.1, 1.1], cells, false, pattern).unwrap();
    let cap = capped(&flat, 1.0);
    let material = Material { thickness: h, youngs_modulus: 1.0, poissons_ratio: 0.3 };
    let shell = shell(Kind::Tan, &cap, &free(&cap), material);
    let rest = forms(&shell.forms(&unknowns(&*shell, &cap)));
    let field = |f: fn(f64) -> f64| -> ScalarField { Box::new(move |site: &Site, _| f(site.position.xy().norm())) };
    let law =
        Pullback { abar: Some([field(|_| 1.0), field(|_| 0.0), field(|r| r.sin() * r.sin())]), bbar: None, components: Components::Polar };
    let topology = Topology::new(&flat.faces);
    let thickness = vec![h; flat.faces.len()];
    let interpolation = LinearInterpolation { mesh: flat.clone(), topology, sampling, initial: rest.clone(), thickness };
    let driver = RestDriver::new(Box::new(law), false, Box::new(interpolation), None, rest.clone());
    let mut model = model(shell, &cap, rest, Some(driver), six_of(&cap));
    model.advance(1.0, 1.0).unwrap();
    model.energies().iter().map(|(_, e)| e).sum::<f64>() / h.powi(3)
}

/// Six coordinates that hold a free cap: at the outer rim on +x, +y and -x.
fn six_of(mesh: &Mesh) -> Vec<usize> {
    let [a, b, c] = [Vector3::x(), Vector3::y(), -Vector3::x()].map(|d| mesh.region_nearest(2.0 * d).vertices[0]);
    vec![3 * a, 3 * a + 1, 3 * a + 2, 3 * b + 2, 3 * c + 1, 3 * c + 2]
}

/// Measured with an implementation of its own, 12 x 64 cells; the exact cap has the bending energy of the reference file, so that the minimum
/// cannot be higher: sampling at centroids exceeds it by what the mesh prestresses.
#[test]
fn rest_lengths_of_edges_do_not_prestress_the_sheet() {
    use generate::Pattern::{Alternating, Diagonal};
    let reference: toml::Table = include_str!("../../data/reference/nonlinear_shells.toml").parse().unwrap();
    let cap = reference["spherical_metric_annulus"]["cap_bending_energy_over_h3"].as_float().unwrap();
    for (pattern, h, sampling, expected) in [
        (Diagonal, 0.03, Sampling::Edges, 0.3434),
        (Alternating, 0.03, Sampling::Edges, 0.3434),
        (Alternating, 0.01, Sampling::Edges, 0.3698),
        (Alternating, 0.03, Sampling::Centroid, 0.464),
    ] {
        let energy = energy(pattern, [12, 64], h, sampling);
        println!("{pattern:?} h {h} {sampling:?}: {energy}");
        assert!((energy / expected - 1.0).abs() < 0.005, "{pattern:?} {h} {sampling:?}: {energy}");
        assert_eq!(energy < cap, sampling == Sampling::Edges);
    }
}

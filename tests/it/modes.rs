//! Vibration about the flat rest state: the lowest frequencies tell whether stiffness, inertia and supports of the elements belong together.
//!
//! Plates have flexural rigidity, mass per area and size 1, so that angular frequencies are the dimensionless `omega a^2 sqrt(rho h / D)`.

use crate::physics_case::{forms, rate};
use nalgebra::{DMatrix, Vector3};
use serde::Deserialize;
use std::f64::consts::PI;
use thinshell::mesh::generate::{Pattern as Cells, disc, rectangle};
use thinshell::mesh::midpoints::{Surface, place};
use thinshell::mesh::{Mesh, Topology};
use thinshell::shell::{Director, Inertia, Inertial, Koiter, LinearFree, MassKind, Material, Measure, QuadraticFree, Shell};
use thinshell::sparse::{Cholesky, Curvature, Kind, Numbering, Pattern, System};

const THICKNESS: f64 = 1e-3;
const POISSON: f64 = 0.3;

#[derive(Deserialize)]
struct Published {
    free_vibration: Frequencies,
}

#[derive(Deserialize)]
struct Frequencies {
    free_disc_nu_0_3_n2: f64,
    simply_supported_square: [f64; 3],
    cantilever_square_nu_0_3: [f64; 3],
}

fn published() -> Frequencies {
    toml::from_str::<Published>(include_str!("../../data/reference/nonlinear_shells.toml")).unwrap().free_vibration
}

/// A plate at rest.
struct Plate {
    shell: Box<dyn Shell>,
    inertia: Box<dyn Inertial>,
    x: Vec<f64>,
    held: Vec<bool>,
}

/// Plate over a mesh, quadratic where it has midpoints. `hold`: components held at a place; `clamp`: whether the director of an edge with
/// its middle at a place is held.
fn plate(mesh: &Mesh, mass: MassKind, hold: impl Fn(&Vector3<f64>) -> [bool; 3], clamp: impl Fn(&Vector3<f64>) -> bool) -> Plate {
    let topology = Topology::new(&mesh.faces);
    let clamped: Vec<bool> = topology.edges.iter().map(|[a, b]| clamp(&mesh.vertices[*a].lerp(&mesh.vertices[*b], 0.5))).collect();
    let supports: Vec<Director> = clamped.iter().map(|c| if *c { Director::Clamped } else { Director::Free }).collect();
    let youngs_modulus = 12.0 * (1.0 - POISSON * POISSON) / THICKNESS.powi(3);
    let materials = vec![Material { thickness: THICKNESS, youngs_modulus, poissons_ratio: POISSON }; mesh.faces.len()];
    let quadratic = !mesh.midpoints.is_empty();
    let mut shell: Box<dyn Shell> = if quadratic {
        Box::new(Koiter::new(QuadraticFree::new(mesh, &topology, &mesh.midpoints, Measure::Tan, &supports), materials, None))
    } else {
        Box::new(Koiter::new(LinearFree::new(mesh, &topology, Measure::Tan, &supports), materials, None))
    };
    let nodes = mesh.nodes();
    let mut x: Vec<f64> = nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(shell.unknowns(), 0.0);
    let rest = forms(&shell.forms(&x));
    let roots: Vec<f64> = rest.iter().map(|f| (f.a[0] * f.a[2] - f.a[1] * f.a[1]).sqrt()).collect();
    shell.set_rest(&rest);
    shell.restart(&x);
    let mut inertia: Box<dyn Inertial> = if quadratic {
        let matrices = roots.chunks_exact(3).map(|r| mass.quadratic([r[0], r[1], r[2]])).collect();
        Box::new(Inertia::<6, 18>::new(six_nodes(mesh, &topology), matrices))
    } else {
        Box::new(Inertia::<3, 9>::new(mesh.faces.clone(), roots.iter().map(|r| mass.linear(0.5 * r)).collect()))
    };
    inertia.start_step(&x, &vec![0.0; 3 * nodes.len()], 1.0);
    let per_edge = if quadratic { 2 } else { 1 };
    let mut held: Vec<bool> = nodes.iter().flat_map(hold).collect();
    held.extend(clamped.iter().flat_map(|c| vec![*c; per_edge]));
    Plate { shell, inertia, x, held }
}

/// Nodes of each face in the order of the shape functions.
fn six_nodes(mesh: &Mesh, topology: &Topology) -> Vec<[usize; 6]> {
    let middles = topology.face_edges.iter().map(|edges| edges.map(|e| mesh.vertices.len() + e));
    mesh.faces.iter().zip(middles).map(|([a, b, c], [d, e, f])| [*a, *b, *c, d, e, f]).collect()
}

/// `A y` for a symmetric matrix by its lower triangle.
fn multiply(pattern: &Pattern, matrix: &[f64], y: &[f64]) -> Vec<f64> {
    let mut z = vec![0.0; y.len()];
    for j in 0..y.len() {
        for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
            let i = pattern.row[k] as usize;
            z[i] += matrix[k] * y[j];
            if i != j {
                z[j] += matrix[k] * y[i];
            }
        }
    }
    z
}

impl Plate {
    /// Stiffness and mass over the free unknowns.
    fn matrices(&mut self) -> (Pattern, Vec<f64>, Vec<f64>) {
        let numbering = Numbering::new(&self.held);
        let pattern = Pattern::new(&numbering, &mut |visit| {
            self.shell.stencils(visit);
            self.inertia.stencils(visit);
        })
        .unwrap();
        self.shell.bind(&numbering, &pattern);
        self.inertia.bind(&numbering, &pattern);
        let (mut stiffness, mut mass) = (System::new(&pattern), System::new(&pattern));
        assert_eq!(self.shell.assemble(&self.x, Curvature::Mixed, &mut stiffness), 0.0);
        assert_eq!(self.inertia.assemble(&self.x, Curvature::Mixed, &mut mass), 0.0);
        (pattern, stiffness.matrix, mass.matrix)
    }

    /// The lowest `count` angular frequencies, by subspace iteration. `shift`: added to their squares, above 0 for free bodies. Directors
    /// have no mass: they follow the nodes.
    fn frequencies(&mut self, count: usize, shift: f64) -> Vec<f64> {
        let (pattern, stiffness, mass) = self.matrices();
        let matrix: Vec<f64> = stiffness.iter().zip(&mass).map(|(k, m)| k + shift * m).collect();
        let mut cholesky = Cholesky::new(&pattern).unwrap();
        cholesky.refactor(&pattern, &matrix, Kind::Llt).unwrap();
        let (n, size) = (pattern.len(), count + 8);
        // Any vectors that are not orthogonal to the modes do.
        let mut vectors = DMatrix::from_fn(n, size, |i, j| ((i * (2 * j + 3)) as f64 * 0.618).sin());
        let mut squares = vec![f64::INFINITY; size];
        for _ in 0..100 {
            let mut forces = DMatrix::zeros(n, size);
            let mut moved = DMatrix::zeros(n, size);
            for j in 0..size {
                let force = multiply(&pattern, &mass, vectors.column(j).as_slice());
                forces.column_mut(j).copy_from_slice(&force);
                let mut y = force;
                cholesky.solve(&mut y);
                moved.column_mut(j).copy_from_slice(&y);
            }
            let mut carried = DMatrix::zeros(n, size);
            for j in 0..size {
                carried.column_mut(j).copy_from_slice(&multiply(&pattern, &mass, moved.column(j).as_slice()));
            }
            // Ritz: the small problem K' q = (omega^2 + shift) M' q, as that of an ordinary symmetric matrix.
            let lower = (moved.transpose() * &carried).cholesky().unwrap().l();
            let inverse = lower.try_inverse().unwrap();
            let eigen = (&inverse * (moved.transpose() * &forces) * inverse.transpose()).symmetric_eigen();
            let mut order: Vec<usize> = (0..size).collect();
            order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
            let ritz = inverse.transpose() * &eigen.eigenvectors;
            vectors = &moved * DMatrix::from_fn(size, size, |i, j| ritz[(i, order[j])]);
            let now: Vec<f64> = order.iter().map(|k| eigen.eigenvalues[*k]).collect();
            let change = now.iter().zip(&squares).take(count).map(|(a, b)| (a - b).abs() / a).fold(0.0, f64::max);
            squares = now;
            if change < 1e-9 {
                return squares[..count].iter().map(|s| (s - shift).max(0.0).sqrt()).collect();
            }
        }
        panic!("the subspace iteration did not converge");
    }
}

fn square(cells: usize, quadratic: bool) -> Mesh {
    let mut mesh = rectangle([1.0, 1.0], [cells, cells], Cells::Alternating, 0.0, 0).unwrap();
    if quadratic {
        place(&mut mesh, Surface::Plane);
    }
    mesh
}

/// The flat plate's bending does not couple to what is held in the plane.
fn simply_supported(mesh: &Mesh, mass: MassKind) -> Plate {
    let rim = |p: &Vector3<f64>| [p.x, p.y].iter().any(|c| c.min(1.0 - c).abs() < 1e-9);
    plate(mesh, mass, |p| [rim(p); 3], |_| false)
}

fn cantilever(mesh: &Mesh, mass: MassKind) -> Plate {
    let left = |p: &Vector3<f64>| p.x.abs() < 1e-9;
    plate(mesh, mass, |p| [left(p); 3], left)
}

fn free_disc(rings: usize, mass: MassKind) -> (Mesh, Plate) {
    let mut mesh = disc(1.0, rings).unwrap();
    place(&mut mesh, Surface::Disc { radius: 1.0 });
    let plate = plate(&mesh, mass, |_| [false; 3], |_| false);
    (mesh, plate)
}

/// Relative errors of the first frequencies; the second and third of a simply supported square are one and the same.
fn supported_errors(found: &[f64]) -> [f64; 3] {
    let [a, b, c] = published().simply_supported_square;
    assert!((found[1] - found[2]).abs() < 0.02 * b, "{found:?}");
    [found[0] / a - 1.0, 0.5 * (found[1] + found[2]) / b - 1.0, found[3] / c - 1.0]
}

fn cantilever_errors(found: &[f64]) -> [f64; 3] {
    let exact = published().cantilever_square_nu_0_3;
    std::array::from_fn(|i| found[i] / exact[i] - 1.0)
}

fn assert_small(name: &str, errors: &[f64], tolerance: f64) {
    assert!(errors.iter().all(|e| e.abs() < tolerance), "{name}: {errors:?}");
}

#[test]
fn a_simply_supported_square() {
    let found = simply_supported(&square(8, true), MassKind::Consistent).frequencies(4, 0.0);
    assert_small("quadratic", &supported_errors(&found), 1e-3);
    let lumped = simply_supported(&square(8, true), MassKind::Lumped).frequencies(4, 0.0);
    assert_small("quadratic, lumped", &supported_errors(&lumped), 0.01);
}

#[test]
fn a_cantilevered_square() {
    let found = cantilever(&square(8, true), MassKind::Consistent).frequencies(3, 0.0);
    assert_small("quadratic", &cantilever_errors(&found), 1e-3);
    let lumped = cantilever(&square(8, true), MassKind::Lumped).frequencies(3, 0.0);
    assert_small("quadratic, lumped", &cantilever_errors(&lumped), 0.01);
}

/// Six rigid motions, then a pair of modes with two nodal diameters.
#[test]
fn a_free_disc() {
    let exact = published().free_disc_nu_0_3_n2;
    for (mass, tolerance) in [(MassKind::Consistent, 1e-3), (MassKind::Lumped, 0.01)] {
        let found = free_disc(6, mass).1.frequencies(9, 1.0);
        assert!(found[5] < 1e-3 && found[8] > 1.2 * exact, "{found:?}");
        assert_small(&format!("{mass:?}"), &[found[6] / exact - 1.0, found[7] / exact - 1.0], tolerance);
        assert!((found[6] - found[7]).abs() < 1e-3 * exact, "{found:?}");
    }
}

/// The linear element goes to the same frequencies, with second order.
#[test]
fn the_linear_element_converges() {
    let sizes = [8, 16, 32];
    let supported = sizes.map(|n| supported_errors(&simply_supported(&square(n, false), MassKind::Consistent).frequencies(4, 0.0)));
    let clamped = sizes.map(|n| cantilever_errors(&cantilever(&square(n, false), MassKind::Consistent).frequencies(3, 0.0)));
    for mode in 0..3 {
        let (s, c) = (supported.map(|e| e[mode].abs()), clamped.map(|e| e[mode].abs()));
        assert!([rate(&s), rate(&c)].iter().all(|r| (1.7..2.3).contains(r)), "mode {mode}: {s:?} {c:?}");
        assert!(s[2] < 6e-3 && c[2] < 6e-3, "mode {mode}: {s:?} {c:?}");
    }
}

/// Mass of all in the direction of an axis.
fn total(pattern: &Pattern, matrix: &[f64], lengths: usize, axis: usize) -> f64 {
    let along: Vec<f64> = (0..pattern.len()).map(|i| f64::from(u8::from(i < lengths && i % 3 == axis))).collect();
    multiply(pattern, matrix, &along).iter().zip(&along).map(|(m, a)| m * a).sum()
}

/// Lumped mass is diagonal and positive, and all the mass is there.
#[test]
fn mass_is_conserved() {
    let mut mesh = rectangle([1.0, 1.0], [3, 3], Cells::Diagonal, 0.3, 5).unwrap();
    place(&mut mesh, Surface::Plane);
    let lengths = 3 * mesh.nodes().len();
    for mass in [MassKind::Consistent, MassKind::Lumped] {
        let (pattern, _, matrix) = plate(&mesh, mass, |_| [false; 3], |_| false).matrices();
        for axis in 0..3 {
            let total = total(&pattern, &matrix, lengths, axis);
            assert!((total - 1.0).abs() < 1e-13, "{mass:?}: {total}");
        }
        for j in 0..pattern.len() {
            let column = &matrix[pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize];
            let coupled = column[1..].iter().any(|m| *m != 0.0);
            assert!(
                (j < lengths && column[0] > 0.01 / lengths as f64) || (j >= lengths && column[0] == 0.0),
                "{mass:?} {j}: {}",
                column[0]
            );
            assert!(!coupled || mass == MassKind::Consistent);
        }
        assert_eq!(mass == MassKind::Consistent, matrix.iter().filter(|m| **m != 0.0).count() > lengths);
    }
}

/// The mass of curved faces is that of their rest forms, whose area goes to that of the disc with fourth order.
#[test]
fn mass_of_curved_faces() {
    let errors = [3, 6, 12].map(|rings| {
        let totals = [MassKind::Consistent, MassKind::Lumped].map(|mass| {
            let (mesh, mut plate) = free_disc(rings, mass);
            let (pattern, _, matrix) = plate.matrices();
            total(&pattern, &matrix, 3 * mesh.nodes().len(), 0)
        });
        assert!((totals[0] - totals[1]).abs() < 1e-13 * totals[0], "{totals:?}");
        (totals[0] / PI - 1.0).abs()
    });
    assert!(errors[0] < 1e-4 && rate(&errors) > 3.7, "{errors:?}");
}

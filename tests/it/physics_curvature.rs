//! Curvature and bending energy of exact surfaces: sign, value and rate of convergence (Chen et al. 2018, section 3).

use crate::physics_case::{Kind, capped, forms, free, matrix, model, principal, rate, rates, rolled, shell, unknowns};
use nalgebra::Vector3;
use thinshell::mesh::{Mesh, Topology, generate};
use thinshell::shell::{Director, Material};

const RADIUS: f64 = 0.8;
const MATERIAL: Material = Material { thickness: 0.05, youngs_modulus: 3.0, poissons_ratio: 0.3 };

/// A surface, its principal curvatures for outward normals, and the outward normal at a point near it.
struct Surface {
    lay: fn(&Mesh, f64) -> Mesh,
    curvatures: [f64; 2],
    normal: fn(&Vector3<f64>) -> Vector3<f64>,
}

const CYLINDER: Surface = Surface { lay: rolled, curvatures: [-1.0 / RADIUS, 0.0], normal: |p| Vector3::new(p.x, 0.0, p.z).normalize() };
const SPHERE: Surface = Surface { lay: capped, curvatures: [-1.0 / RADIUS; 2], normal: |p| p.normalize() };

/// A square of side 1 around the origin; sizes halve with `level`.
fn square(level: u32, pattern: generate::Pattern, jitter: f64) -> Mesh {
    let n = 6 << level;
    let mut mesh = generate::rectangle([1.0, 1.0], [n, n], pattern, jitter, 5).unwrap();
    mesh.vertices.iter_mut().for_each(|v| *v -= Vector3::new(0.5, 0.5, 0.0));
    mesh
}

fn delaunay(level: u32) -> Mesh {
    let n = 6 << level;
    let mut mesh = generate::rectangle_delaunay([1.0, 1.0], [n, n], None, 3).unwrap();
    mesh.vertices.iter_mut().for_each(|v| *v -= Vector3::new(0.5, 0.5, 0.0));
    mesh
}

/// Largest error of the principal curvatures over faces without a boundary edge, relative to 1/R.
fn error(surface: &Surface, mesh: &Mesh, strains: &[[f64; 6]]) -> f64 {
    let topology = Topology::new(&mesh.faces);
    let inner = topology.face_edges.iter().map(|edges| edges.iter().all(|e| !topology.is_boundary(*e)));
    let errors = strains.iter().zip(inner).filter(|(_, inner)| *inner).flat_map(|(e, _)| {
        let k = principal(e);
        [0, 1].map(|i| (k[i] - surface.curvatures[i]).abs() * RADIUS)
    });
    errors.fold(0.0, f64::max)
}

/// Directors from the face normals, as a shell starts with: exact in the limit where the mesh is regular.
#[test]
fn initial_forms_have_the_curvature_of_the_surface() {
    for surface in [&CYLINDER, &SPHERE] {
        let errors: Vec<f64> = (0..3)
            .map(|level| {
                let mesh = (surface.lay)(&square(level, generate::Pattern::Diagonal, 0.0), RADIUS);
                let shell = shell(Kind::Tan, &mesh, &free(&mesh), MATERIAL);
                error(surface, &mesh, &shell.forms(&unknowns(&*shell, &mesh)))
            })
            .collect();
        println!("initial forms: {errors:?} {:?}", rates(&errors));
        assert!(rate(&errors) > 0.9 && errors[2] < 0.05, "{errors:?}");
    }
}

/// With the surface's own normals on the edges every mesh has its curvature: the factor 2 and the sign, whatever the triangles.
#[test]
fn exact_directors_give_the_curvature_on_irregular_meshes() {
    for surface in [&CYLINDER, &SPHERE] {
        for (name, flat) in [("jittered", (|l| square(l, generate::Pattern::Alternating, 0.25)) as fn(u32) -> Mesh), ("delaunay", delaunay)]
        {
            let errors: Vec<f64> = (0..3)
                .map(|level| {
                    let mesh = (surface.lay)(&flat(level), RADIUS);
                    let held = normals(surface, &mesh, |_| true);
                    let shell = shell(Kind::Tan, &mesh, &held, MATERIAL);
                    error(surface, &mesh, &shell.forms(&unknowns(&*shell, &mesh)))
                })
                .collect();
            println!("exact directors {name}: {errors:?} {:?}", rates(&errors));
            assert!(rate(&errors) > 0.75 && errors[2] < 0.1, "{name} {errors:?}");
        }
    }
}

/// Directors along the surface's normals at the middles of the edges that `which` picks.
fn normals(surface: &Surface, mesh: &Mesh, which: impl Fn(usize) -> bool) -> Vec<Director> {
    let topology = Topology::new(&mesh.faces);
    let middle = |[a, b]: [usize; 2]| 0.5 * (mesh.vertices[a] + mesh.vertices[b]);
    let support =
        |(e, pair): (usize, &[usize; 2])| if which(e) { Director::Held((surface.normal)(&middle(*pair))) } else { Director::Free };
    topology.edges.iter().enumerate().map(support).collect()
}

/// Bending energy of vertices on the exact surface with flat rest curvature, inner directors relaxed. The boundary's directors
/// are the surface's, for a free boundary would relax its moment.
#[test]
fn relaxed_directors_give_the_exact_bending_energy() {
    let [alpha, beta] = MATERIAL.lame();
    let h = MATERIAL.thickness;
    let reference: toml::Table = include_str!("../../data/reference/nonlinear_shells.toml").parse().unwrap();
    assert_eq!(reference["exact_energy"]["cylinder"].as_str(), Some("h^3/12 (alpha/2 + beta) / R^2"));
    assert_eq!(reference["exact_energy"]["sphere"].as_str(), Some("h^3/12 (2 alpha + 2 beta) / R^2"));
    let stiffness = MATERIAL.youngs_modulus * h.powi(3) / (12.0 * (1.0 - MATERIAL.poissons_ratio.powi(2)));
    let cylinder = h.powi(3) / 12.0 * (0.5 * alpha + beta) / RADIUS.powi(2);
    // The plate's bending stiffness, not that of a three-dimensional law.
    assert!((cylinder - 0.5 * stiffness / RADIUS.powi(2)).abs() < 1e-14 * cylinder);
    let sphere = h.powi(3) / 12.0 * (2.0 * alpha + 2.0 * beta) / RADIUS.powi(2);
    for (name, surface, exact) in [("cylinder", &CYLINDER, cylinder), ("sphere", &SPHERE, sphere)] {
        for (pattern, flat) in [
            ("diagonal", (|l| square(l, generate::Pattern::Diagonal, 0.0)) as fn(u32) -> Mesh),
            ("jittered", |l| square(l, generate::Pattern::Alternating, 0.25)),
            ("delaunay", delaunay),
        ] {
            for kind in [Kind::Sin, Kind::Tan] {
                let errors: Vec<f64> = (0..3).map(|level| (relaxed_energy(kind, surface, &flat(level)) / exact - 1.0).abs()).collect();
                println!("energy {name} {pattern} {kind:?}: {errors:?} {:?}", rates(&errors));
                assert!(rate(&errors) > 1.9 && errors[2] < 2e-3, "{name} {pattern} {kind:?} {errors:?}");
            }
        }
    }
}

/// Bending energy per rest area [J/m2] after the directors have relaxed. The rest metric is flat where the surface can be unrolled, else the mesh's own.
fn relaxed_energy(kind: Kind, surface: &Surface, flat: &Mesh) -> f64 {
    let mesh = (surface.lay)(flat, RADIUS);
    let unrolled = if surface.curvatures[1] == 0.0 { flat } else { &mesh };
    let topology = Topology::new(&mesh.faces);
    let supports = normals(surface, &mesh, |e| topology.is_boundary(e));
    let shell = shell(kind, &mesh, &supports, MATERIAL);
    let mut rest = forms(&shell.forms(&unknowns(&*shell, unrolled)));
    rest.iter_mut().for_each(|f| f.b = [0.0; 3]);
    let area: f64 = rest.iter().map(|f| 0.5 * matrix(f.a).determinant().sqrt()).sum();
    let lengths = 3 * mesh.vertices.len();
    let held = (0..lengths).chain((0..supports.len()).filter(|e| topology.is_boundary(*e)).map(|e| lengths + e));
    let mut model = model(shell, &mesh, rest, None, held);
    model.advance(1.0, 1.0).unwrap();
    let energies = model.energies();
    energies.iter().find(|(name, _)| *name == "bending_energy_J").unwrap().1 / area
}

//! What the directors of edges promise: freedom from their frames, and folds that do not invert.

use crate::physics_case::{Kind, forms, free, rolled, shell, unknowns};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use thinshell::mesh::{Mesh, Topology, generate};
use thinshell::shell::{Director, Material};

const MATERIAL: Material = Material { thickness: 0.1, youngs_modulus: 2.0, poissons_ratio: 0.25 };

/// A director is a vector in space: a shell that re-frames after every step and one that was given the directors themselves agree.
#[test]
fn frames_leave_the_energy_alone_over_many_steps() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    let mesh = rolled(&generate::rectangle([2.0, 1.0], [6, 3], generate::Pattern::Alternating, 0.2, 4).unwrap(), 1.0);
    let topology = Topology::new(&mesh.faces);
    let lengths = 3 * mesh.vertices.len();
    for kind in [Kind::Sin, Kind::Tan] {
        let mut framed = shell(kind, &mesh, &free(&mesh), MATERIAL);
        let mut x = unknowns(&*framed, &mesh);
        framed.set_rest(&forms(&framed.forms(&x)));
        for step in 0..20 {
            // Any motion with any change of directors; the last steps turn the whole shell far from where it was.
            for (i, value) in x.iter_mut().enumerate() {
                *value += if i < lengths { rng.random_range(-0.01..0.01) } else { rng.random_range(-0.05..0.05) };
            }
            let turn = nalgebra::Rotation3::new(Vector3::new(0.3, -0.2, 0.25));
            let turned: Vec<Vector3<f64>> = framed.directors().iter().map(|p| turn * p).collect();
            framed.set_directors(&turned);
            let before_turn = framed.forms(&x);
            assert!(before_turn.iter().flatten().all(|e| e.is_finite()));
            for p in x[..lengths].chunks_exact_mut(3) {
                let q = turn * Vector3::new(p[0], p[1], p[2]);
                p.copy_from_slice(q.as_slice());
            }
            let before = framed.energy(&x);
            framed.prepare(&mut x);
            let after = framed.energy(&x);
            assert!(before > 0.0 && (before - after).abs() < 1e-12 * before, "{kind:?} step {step}: {before} {after}");
            assert!(x[lengths..].iter().all(|phi| *phi == 0.0));
            for (p, [a, b]) in framed.directors().iter().zip(&topology.edges) {
                let t = Vector3::new(x[3 * b] - x[3 * a], x[3 * b + 1] - x[3 * a + 1], x[3 * b + 2] - x[3 * a + 2]).normalize();
                assert!((p.norm() - 1.0).abs() < 1e-14 && p.dot(&t).abs() < 1e-14);
            }
            let mut given = shell(kind, &mesh, &free(&mesh), MATERIAL);
            given.set_directors(framed.directors());
            for (p, q) in given.forms(&x).iter().flatten().zip(framed.forms(&x).iter().flatten()) {
                assert!((p - q).abs() < 1e-14);
            }
        }
    }
}

/// Two faces on the x axis, folded upwards by `fold` [rad], each with its edge 0 on the axis.
fn hinge(fold: f64) -> Mesh {
    let (s, c) = (0.5 * fold).sin_cos();
    Mesh {
        vertices: vec![Vector3::zeros(), Vector3::x(), Vector3::new(0.5, -c, s), Vector3::new(0.5, c, s)],
        faces: vec![[2, 1, 0], [3, 0, 1]],
        ..Mesh::default()
    }
}

/// Folding further always costs more with the measure `tan`, also beyond right angles; with `sin` the cost levels off.
#[test]
fn a_fold_costs_more_the_further_it_goes() {
    let flat = hinge(0.0);
    let energy = |kind: Kind, fold: f64| {
        // The folded mesh's own directors: the mean normal between the faces, by symmetry the equilibrium, and the faces' own at the rim.
        let folded = hinge(fold);
        let mut shell = shell(kind, &folded, &free(&folded), MATERIAL);
        let mut rest = forms(&shell.forms(&unknowns(&*shell, &flat)));
        rest.iter_mut().for_each(|f| f.b = [0.0; 3]);
        shell.set_rest(&rest);
        shell.energies(&unknowns(&*shell, &folded))[1]
    };
    let folds: Vec<f64> = (1..=179).map(|degrees| f64::from(degrees).to_radians()).collect();
    let tan: Vec<f64> = folds.iter().map(|f| energy(Kind::Tan, *f)).collect();
    let sin: Vec<f64> = folds.iter().map(|f| energy(Kind::Sin, *f)).collect();
    assert!(tan.windows(2).all(|e| e[1] > e[0]));
    // tan^2(89.5 / 2 deg) against tan^2 (45 deg): the hinge of 179 degrees has more than 1e4 times the energy of 90 degrees.
    assert!(tan[178] > 1e4 * tan[89] && sin[178] < 2.0 * sin[89] * (1.0 + 1e-9), "{} {}", tan[178] / tan[89], sin[178] / sin[89]);
    // Small folds are the same hinge: sin and tan agree to second order in the angle.
    assert!((tan[0] / sin[0] - 1.0).abs() < 1e-3 && tan[0] > 0.0);
}

/// A face that turns past the director that holds it, from 0 to 170 degrees: the energy keeps growing beyond the right angle.
#[test]
fn a_face_beyond_its_director_does_not_invert() {
    let flat = hinge(0.0);
    let single = Mesh { vertices: flat.vertices.clone(), faces: vec![[3, 0, 1]], ..Mesh::default() };
    let topology = Topology::new(&single.faces);
    let mut supports = free(&single);
    supports[topology.face_edges[0][0]] = Director::Held(Vector3::z());
    let energy = |kind: Kind, degrees: f64| {
        let mut shell = shell(kind, &single, &supports, MATERIAL);
        shell.set_rest(&forms(&shell.forms(&unknowns(&*shell, &single))));
        let mut turned = single.clone();
        let (s, c) = degrees.to_radians().sin_cos();
        turned.vertices[3] = Vector3::new(0.5, c, s);
        let mut x = unknowns(&*shell, &turned);
        // Free directors turn with the face.
        let edges = topology.face_edges[0];
        let normal = Vector3::new(0.0, -s, c);
        let mut directors = shell.directors().to_vec();
        directors[edges[1]] = normal;
        directors[edges[2]] = normal;
        shell.set_directors(&directors);
        shell.prepare(&mut x);
        shell.energies(&x)[1]
    };
    let tan: Vec<f64> = (0..=17).map(|i| energy(Kind::Tan, 10.0 * f64::from(i))).collect();
    assert!(tan[0] < 1e-20 && tan.windows(2).all(|e| e[1] > e[0]), "{tan:?}");
    // The sine does invert: at 170 degrees it costs no more than at 10.
    let [low, high] = [10.0, 170.0].map(|degrees| energy(Kind::Sin, degrees));
    assert!((high / low - 1.0).abs() < 1e-9, "{low} {high}");
}

//! Comparison of derivatives with finite differences, and a crumpled patch to compare them on.

use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use thinshell::mesh::Mesh;
use thinshell::shell::Material;
use thinshell::shell::rest::Forms;
use thinshell::sparse::{Curvature, Numbering, Pattern, Potential, System};

/// A crumpled patch of eight faces with an inner vertex, edge lengths about 1.
pub fn patch() -> Mesh {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut mesh = Mesh::default();
    for i in 0..3 {
        for j in 0..3 {
            let mut shift = || rng.random_range(-0.15..0.15);
            mesh.vertices.push(Vector3::new(i as f64 + shift(), j as f64 + shift(), 2.0 * shift()));
        }
    }
    for i in 0..2 {
        for j in 0..2 {
            let (a, b) = (3 * i + j, 3 * i + j + 3);
            mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

/// Binds a potential with no unknown held.
pub fn bind(potential: &mut dyn Potential, unknowns: usize) -> (Pattern, System) {
    let numbering = Numbering::new(&vec![false; unknowns]);
    let pattern = Pattern::new(&numbering, &mut |visit| potential.stencils(visit)).unwrap();
    potential.bind(&numbering, &pattern);
    let system = System::new(&pattern);
    (pattern, system)
}

/// All entries of a symmetric matrix.
pub fn dense(pattern: &Pattern, values: &[f64]) -> Vec<Vec<f64>> {
    let n = pattern.len();
    let mut m = vec![vec![0.0; n]; n];
    for j in 0..n {
        for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
            let i = pattern.row[k] as usize;
            m[i][j] = values[k];
            m[j][i] = values[k];
        }
    }
    m
}

/// Compares gradient with energy and Hessian with gradient by central differences at `x`.
pub fn compare(potential: &mut dyn Potential, x: &[f64]) {
    let n = x.len();
    let (pattern, mut system) = bind(potential, n);
    potential.restart(x);
    let energy = potential.assemble(x, Curvature::Mixed, &mut system);
    assert!(energy > 0.0 && (energy - potential.energy(x)).abs() <= 1e-13 * energy);
    let (gradient, hessian) = (system.gradient.clone(), dense(&pattern, &system.matrix));
    let scale = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
    let stiff = hessian.iter().flatten().fold(0.0f64, |m, g| m.max(g.abs()));
    assert!(gradient.iter().all(|g| g.abs() > 1e-9 * scale), "a component of the gradient vanishes");
    let step = 1e-6;
    for i in 0..n {
        let mut shifted = x.to_vec();
        let mut at = |d: f64| {
            shifted[i] = x[i] + d;
            system.clear();
            let e = potential.gradient(&shifted, &mut system);
            (e, system.gradient.clone())
        };
        let ((e1, g1), (e2, g2)) = (at(step), at(-step));
        let difference = (e1 - e2) / (2.0 * step);
        assert!((difference - gradient[i]).abs() < 2e-8 * scale, "gradient {i}: {difference} {}", gradient[i]);
        for j in 0..n {
            let difference = (g1[j] - g2[j]) / (2.0 * step);
            assert!((difference - hessian[i][j]).abs() < 1e-8 * stiff, "Hessian {i} {j}: {difference} {}", hessian[i][j]);
        }
        assert!(hessian[i].iter().any(|h| h.abs() > 1e-6 * stiff));
    }
    compare_parts(potential, x, &hessian);
}

/// Compares what a Hessian makes of a movement with what its two parts make of it: forces from strains, and the matrix without the material.
fn compare_parts(potential: &mut dyn Potential, x: &[f64], hessian: &[Vec<f64>]) {
    let (pattern, mut system) = bind(potential, x.len());
    potential.assemble(x, Curvature::Geometric, &mut system);
    let geometric = dense(&pattern, &system.matrix);
    let v: Vec<f64> = (0..x.len()).map(|i| (0.618_034 * (i + 1) as f64).fract() - 0.5).collect();
    system.clear();
    potential.add_material_forces(x, &v, &mut system);
    let times = |matrix: &[Vec<f64>], i: usize| matrix[i].iter().zip(&v).map(|(m, v)| m * v).sum::<f64>();
    let scale = (0..x.len()).map(|i| times(hessian, i).abs()).fold(0.0, f64::max);
    assert!(scale > 0.0);
    for i in 0..x.len() {
        let (whole, parts) = (times(hessian, i), times(&geometric, i) + system.gradient[i]);
        assert!((whole - parts).abs() < 1e-12 * scale, "{i}: {whole} {parts}");
    }
}

/// A state up to `reach` away from the initial nodes and from angles zero, with rest forms, `points` a face, and materials that are
/// those of nothing in particular.
pub fn crumple(nodes: &[Vector3<f64>], unknowns: usize, faces: usize, points: usize, reach: f64) -> (Vec<f64>, Vec<Forms>, Vec<Material>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut x: Vec<f64> = nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(unknowns, 0.0);
    x.iter_mut().for_each(|x| *x += rng.random_range(-reach..reach));
    let rest = (0..points * faces)
        .map(|_| Forms { a: [1.1, rng.random_range(0.2..0.5), 1.3], b: [0.1, rng.random_range(-0.3..0.3), -0.2] })
        .collect();
    let materials =
        (0..faces).map(|_| Material { thickness: rng.random_range(0.5..1.0), youngs_modulus: 3.0, poissons_ratio: 0.3 }).collect();
    (x, rest, materials)
}

//! The discrete energy of a Cosserat surface: derivatives, invariance, convergence, what is refused.

use nalgebra::Vector3;
use thinshell::cosserat::{Constants, CosseratSurface, Elasticity, Grid};
use thinshell::sparse::{Curvature, Numbering, Pattern, Potential, System};

const CONSTANTS: Constants = Constants { eta: [3.0, 2.5, 2.0], xi: [0.2, 0.3, 0.1], phi: [0.5, -0.3, 0.4] };

fn grid(p: usize, q: usize) -> Grid {
    Grid { nodes: [p, q], spacing: [1.0 / (p as f64 - 1.0), 0.8 / (q as f64 - 1.0)] }
}

fn positions(grid: &Grid, f: impl Fn(f64, f64) -> Vector3<f64>) -> Vec<Vector3<f64>> {
    (0..grid.len()).map(|n| grid.place(n)).map(|[i, j]| f(grid.spacing[0] * i as f64, grid.spacing[1] * j as f64)).collect()
}

fn flat(positions: &[Vector3<f64>]) -> Vec<f64> {
    positions.iter().flat_map(|p| [p.x, p.y, p.z]).collect()
}

fn dome(a: f64, b: f64) -> Vector3<f64> {
    Vector3::new(a + 0.1 * b, b - 0.05 * a * a, 0.3 * a * a - 0.2 * a * b + 0.25 * b * b)
}

/// A bent sheet with a ripple, so that no derivative vanishes by chance.
fn rippled(grid: &Grid) -> Vec<f64> {
    let mut x = flat(&positions(grid, |a, b| Vector3::new(1.1 * a - 0.2 * b, 0.9 * b + 0.1 * a * b, 0.4 * a * a + 0.3 * a * b)));
    x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.01 * (1.7 * i as f64).sin());
    x
}

fn assembled(surface: &mut CosseratSurface, x: &[f64]) -> Result<(Pattern, System, f64), thinshell::Error> {
    let numbering = Numbering::new(&vec![false; x.len()]);
    let pattern = Pattern::new(&numbering, &mut |visit| surface.stencils(visit))?;
    surface.bind(&numbering, &pattern);
    let mut system = System::new(&pattern);
    let energy = surface.assemble(x, Curvature::Mixed, &mut system);
    Ok((pattern, system, energy))
}

#[test]
fn derivatives_are_those_of_the_energy() -> Result<(), Box<dyn std::error::Error>> {
    for elasticity in [
        Elasticity::Cosserat { constants: CONSTANTS, mixed: false },
        Elasticity::Cosserat { constants: CONSTANTS, mixed: true },
        Elasticity::Terzopoulos(CONSTANTS),
    ] {
        // Three nodes are the fewest, where every node is at a border or between two.
        for (p, q) in [(3, 3), (5, 4)] {
            let grid = grid(p, q);
            let mut surface = CosseratSurface::new(grid, &positions(&grid, dome), &elasticity)?;
            let x = rippled(&grid);
            let (pattern, system, energy) = assembled(&mut surface, &x)?;
            assert!((energy - surface.energy(&x)).abs() < 1e-12 * energy && energy > 1e-3);
            assert!((surface.energies(&x).iter().sum::<f64>() - energy).abs() < 1e-12 * energy);
            let largest = system.gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
            let stiffest = system.matrix.iter().fold(0.0f64, |m, g| m.max(g.abs()));
            let at = |i: usize, h: f64| {
                let mut x = x.clone();
                x[i] += h;
                x
            };
            let gradient = |x: &[f64]| {
                let mut into = System::new(&pattern);
                surface.gradient(x, &mut into);
                into.gradient
            };
            let h = 1e-6;
            for i in 0..x.len() {
                let difference = (surface.energy(&at(i, h)) - surface.energy(&at(i, -h))) / (2.0 * h);
                assert!(system.gradient[i] != 0.0 && (difference - system.gradient[i]).abs() < 1e-7 * largest, "{i}");
                let (up, down) = (gradient(&at(i, h)), gradient(&at(i, -h)));
                for k in pattern.column_start[i] as usize..pattern.column_start[i + 1] as usize {
                    let row = pattern.row[k] as usize;
                    let difference = (up[row] - down[row]) / (2.0 * h);
                    assert!((difference - system.matrix[k]).abs() < 1e-6 * stiffest, "{row} {i}: {difference} {}", system.matrix[k]);
                }
            }
            let nonzero = system.matrix.iter().filter(|v| v.abs() > 1e-6 * stiffest).count();
            assert!(2 * nonzero > system.matrix.len());
        }
    }
    Ok(())
}

#[test]
fn rest_and_rigid_motions_have_no_energy() -> Result<(), String> {
    let grid = grid(6, 5);
    let surface = CosseratSurface::new(grid, &positions(&grid, dome), &Elasticity::Cosserat { constants: CONSTANTS, mixed: false })?;
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 2.0);
    let moved: Vec<_> = positions(&grid, dome).iter().map(|p| turn * p + Vector3::new(1.0, 2.0, -3.0)).collect();
    let scale = surface.energy(&rippled(&grid));
    assert!(scale > 1e-3 && surface.energy(&flat(&moved)) < 1e-24 * scale.max(1.0));
    Ok(())
}

/// Energy of a sheet that is rolled obliquely without stretch, over the exact one; and the order at which it comes there.
#[test]
fn the_bending_of_a_rolled_sheet_converges() -> Result<(), String> {
    let (radius, thin) = (0.4, Constants { eta: [1.0; 3], xi: [1e-4; 3], phi: [0.0; 3] });
    let rolled = |a: f64, b: f64| {
        let (s, z) = (0.8 * a + 0.6 * b, 0.8 * b - 0.6 * a);
        Vector3::new(radius * (s / radius).sin(), z, radius * (1.0 - (s / radius).cos()))
    };
    // kappa = -(c^2, c s, s^2) / R; (29) counts 11 and 22 three times, 12 twice.
    let exact = 0.8e-4 * (3.0 * 0.64f64.powi(2) + 2.0 * 0.48f64.powi(2) + 3.0 * 0.36f64.powi(2)) / (radius * radius);
    let mut errors = Vec::new();
    for n in [9, 17, 33] {
        let grid = grid(n, n);
        let elasticity = Elasticity::Cosserat { constants: thin, mixed: false };
        let surface = CosseratSurface::new(grid, &positions(&grid, |a, b| Vector3::new(a, b, 0.0)), &elasticity)?;
        let [_, bending, both] = surface.energies(&flat(&positions(&grid, rolled)));
        assert_eq!(both, 0.0);
        errors.push((bending / exact - 1.0).abs());
    }
    let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    assert!(errors[0] > 1e-5 && orders.iter().all(|o| (1.8..2.3).contains(o)), "{errors:?} {orders:?}");
    Ok(())
}

#[test]
fn folded_and_indefinite_surfaces_are_refused() {
    let grid = grid(4, 4);
    let elasticity = Elasticity::Cosserat { constants: CONSTANTS, mixed: false };
    let line = positions(&grid, |a, _| Vector3::new(a, 0.0, 0.0));
    assert!(CosseratSurface::new(grid, &line, &elasticity).is_err_and(|e| e.contains("cell (0, 0)")));
    let bad = Elasticity::Cosserat { constants: Constants { phi: [2.0; 3], ..CONSTANTS }, mixed: false };
    assert!(CosseratSurface::new(grid, &positions(&grid, dome), &bad).is_err_and(|e| e.contains("not positive")));
}

//! Motion of surfaces on grids: what is conserved, what only falls, and how fast small waves swing.

use nalgebra::Vector3;
use thinshell::cosserat::{Border, Constants, CosseratSurface, Divergence, Elasticity, Grid, StrongForm};
use thinshell::load::Drag;
use thinshell::model::{GridModel, GridParts, HeldUnknown, Model, RoundTable, Strong, node_shares, quadrangles};
use thinshell::shell::Inertia;

const PI: f64 = std::f64::consts::PI;

struct Case {
    n: usize,
    constants: Constants,
    damping: Option<f64>,
    strong: Option<(Border, Divergence)>,
    /// Whether the border is held across the sheet and along it.
    held: bool,
    velocity: fn(f64, f64) -> Vector3<f64>,
    table: Option<RoundTable>,
    /// Whether the constants are those of the other model.
    terzopoulos: bool,
}

const SOFT: Constants = Constants { eta: [4.0; 3], xi: [1e-2; 3], phi: [5e-2; 3] };

/// A flat square of 1 m and 1 kg.
fn model(case: &Case) -> GridModel {
    let n = case.n;
    let grid = Grid { nodes: [n, n], spacing: [1.0 / (n as f64 - 1.0); 2] };
    let positions: Vec<_> =
        (0..grid.len()).map(|k| grid.place(k)).map(|[i, j]| Vector3::new(i as f64, j as f64, 0.0) * grid.spacing[0]).collect();
    let elasticity = if case.terzopoulos {
        Elasticity::Terzopoulos(case.constants)
    } else {
        Elasticity::Cosserat { constants: case.constants, mixed: false }
    };
    let x: Vec<f64> = positions.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let masses = node_shares(&quadrangles(&grid), &x);
    let border = |node: &usize| grid.place(*node).iter().any(|at| *at == 0 || *at == n - 1);
    let held = (0..grid.len()).filter(|node| case.held && border(node)).flat_map(|node| (0..3).map(move |k| 3 * node + k));
    let damping: Vec<f64> = masses.iter().map(|m| m * case.damping.unwrap_or(0.0)).collect();
    let strong = case.strong.map(|(border, divergence)| {
        let form = StrongForm::new(grid, &positions, masses.clone(), elasticity, border, divergence);
        Strong::new(form, masses.clone(), damping.clone(), masses.clone())
    });
    let parts = GridParts {
        grid,
        surface: CosseratSurface::new(grid, &positions, &elasticity).unwrap(),
        inertia: Some(Box::new(Inertia::<1, 3>::new((0..grid.len()).map(|n| [n]).collect(), masses.iter().map(|m| [[*m]]).collect()))),
        drag: case.damping.filter(|_| strong.is_none()).map(|_| Drag::new(damping)),
        strong,
        loads: Vec::new(),
        held: held.map(|unknown| HeldUnknown { unknown, start: x[unknown], motion: None }).collect(),
        velocities: positions.iter().map(|p| (case.velocity)(p.x, p.y)).collect(),
        positions,
        table: case.table,
    };
    GridModel::new(parts, 2f64.sqrt(), 1e-11, 30).unwrap()
}

fn total(model: &GridModel) -> f64 {
    model.energies().iter().map(|(_, e)| e).sum()
}

#[test]
fn a_damped_free_sheet_loses_energy_in_every_step() {
    let velocity = |x: f64, y: f64| Vector3::new(0.4 * y, -0.3 * x * x, 2.0 * (3.0 * x).sin() * y);
    let mut model =
        model(&Case { n: 7, constants: SOFT, damping: Some(0.5), strong: None, held: false, velocity, table: None, terzopoulos: false });
    let mut energies = vec![total(&model)];
    for step in 1..=60 {
        model.advance(0.02, 0.02 * f64::from(step)).unwrap();
        energies.push(total(&model));
    }
    assert!(energies.windows(2).all(|e| e[1] <= e[0] * (1.0 + 1e-12)), "{energies:?}");
    assert!(energies[60] < 0.5 * energies[0] && energies[60] > 0.0);
}

#[test]
fn a_free_sheet_keeps_its_momentum() {
    let velocity = |x: f64, y: f64| Vector3::new(0.4 * y, -0.3 * x * x, 2.0 * (3.0 * x).sin() * y);
    let mut model =
        model(&Case { n: 7, constants: SOFT, damping: None, strong: None, held: false, velocity, table: None, terzopoulos: false });
    let before = model.momentum().unwrap();
    for step in 1..=40 {
        model.advance(0.02, 0.02 * f64::from(step)).unwrap();
    }
    let after = model.momentum().unwrap();
    assert!(before.norm() > 0.1 && (after - before).norm() < 1e-8 * before.norm(), "{before} {after}");
}

/// Angular frequency of the lowest wave of a sheet whose border is held, by the time at which its middle comes back.
fn frequency(n: usize, strong: Option<(Border, Divergence)>) -> f64 {
    let velocity = |x: f64, y: f64| Vector3::z() * (1e-6 * (PI * x).sin() * (PI * y).sin());
    let constants = Constants { phi: [0.0; 3], ..SOFT };
    let mut model = model(&Case { n, constants, damping: None, strong, held: true, velocity, table: None, terzopoulos: false });
    let exact = (16.0 * 1e-2 * PI.powi(4)).sqrt();
    // First order in time, and far finer than in space.
    let dt = 2.0 * PI / exact / 800.0;
    let middle = 3 * (n / 2 * n + n / 2) + 2;
    let mut last = 0.0;
    for step in 1.. {
        model.advance(dt, dt * f64::from(step)).unwrap();
        let z = model.unknowns()[middle];
        if z < 0.0 {
            return PI / (dt * (f64::from(step) - 1.0 + last / (last - z)));
        }
        last = z;
    }
    unreachable!()
}

/// A flat sheet: `mu w_tt = -(6 xi (w_xxxx + w_yyyy) + 4 xi w_xxyy)`.
#[test]
fn small_waves_swing_as_those_of_a_plate() {
    let exact = (16.0 * 1e-2 * PI.powi(4)).sqrt();
    for strong in [None, Some((Border::Paper, Divergence::AsPrinted)), Some((Border::Symmetric, Divergence::Conservative))] {
        let errors = [5, 9].map(|n| (frequency(n, strong) / exact - 1.0).abs());
        let order = (errors[0] / errors[1]).log2();
        assert!(errors[1] > 1e-4 && errors[1] < 0.04 && (1.7..2.4).contains(&order), "{strong:?} {errors:?} {order}");
    }
}

/// A square thrown up to a dome keeps the eight symmetries of the square; where components of the curvature are equal nothing may be decided by round-off.
#[test]
fn the_symmetric_rule_keeps_the_symmetries_of_a_square() {
    let n = 8;
    let velocity = |x: f64, y: f64| Vector3::z() * (4.0 * (PI * x).sin() * (PI * y).sin());
    for divergence in [Divergence::AsPrinted, Divergence::Conservative] {
        let strong = Some((Border::Symmetric, divergence));
        let mut model =
            model(&Case { n, constants: SOFT, damping: Some(0.5), strong, held: false, velocity, table: None, terzopoulos: false });
        for step in 1..=12 {
            model.advance(0.01, 0.01 * f64::from(step)).unwrap();
        }
        let at = |[i, j]: [usize; 2]| {
            Vector3::from_column_slice(&model.unknowns()[3 * (n * i + j)..3 * (n * i + j) + 3]) - Vector3::new(0.5, 0.5, 0.0)
        };
        let (mut off, mut moved) = (0.0f64, 0.0f64);
        for node in (0..n).flat_map(|i| (0..n).map(move |j| [i, j])) {
            let p = at(node);
            moved = moved.max(p.z.abs());
            for symmetry in 0..8 {
                let (mut place, mut image) = (node, p);
                for k in (0..2).filter(|k| symmetry >> k & 1 == 1) {
                    place[k] = n - 1 - place[k];
                    image[k] = -image[k];
                }
                if symmetry & 4 != 0 {
                    place.swap(0, 1);
                    image.swap_rows(0, 1);
                }
                off = off.max((at(place) - image).norm());
            }
        }
        assert!(moved > 0.05 && off < 1e-8, "{divergence:?} {off} {moved}");
    }
}

/// What sticks to a table from the start does not move, whatever the initial velocity.
#[test]
fn nodes_on_the_table_start_at_rest() {
    let table = Some(RoundTable { centre: Vector3::new(0.5, 0.5, 0.0), radius: 0.4 });
    let velocity = |_: f64, _: f64| Vector3::new(0.1, 0.2, 0.3);
    let state =
        model(&Case { n: 7, constants: SOFT, damping: None, strong: None, held: false, velocity, table, terzopoulos: false }).snapshot();
    let [stuck, v] = ["stuck", "velocity"].map(|name| &state.field(name).unwrap().data);
    assert!(stuck.contains(&1.0) && stuck.contains(&0.0));
    for (stuck, v) in stuck.iter().zip(v.chunks_exact(3)) {
        assert_eq!(v.iter().all(|v| *v == 0.0), *stuck == 1.0);
    }
}

/// Damping per present area grows with the area by (35), so its total with the square of it; that of the other model does not know the area.
#[test]
fn damping_follows_the_area_of_a_cosserat_surface_alone() {
    let velocity = |_: f64, _: f64| Vector3::new(0.0, 0.0, 2.0);
    for (terzopoulos, share) in [(false, 1.5f64.powi(4)), (true, 1.0)] {
        let constants = Constants { phi: [0.0; 3], ..SOFT };
        for strong in [None, Some((Border::Symmetric, Divergence::Conservative))] {
            let mut model = model(&Case { n: 5, constants, damping: Some(0.5), strong, held: false, velocity, table: None, terzopoulos });
            let mut state = model.snapshot();
            let position = state.fields.iter_mut().find(|field| field.name == "position").unwrap();
            position.data.iter_mut().for_each(|x| *x *= 1.5);
            model.restore(&state).unwrap();
            let dt = 1e-3;
            model.advance(dt, dt).unwrap();
            let after = model.momentum().unwrap().z;
            // Implicit Euler, or the mean of the velocities before and after.
            let c = 0.5 * share * dt;
            let expected = if strong.is_some() { 2.0 * (1.0 - 0.5 * c) / (1.0 + 0.5 * c) } else { 2.0 / (1.0 + c) };
            assert!((after - expected).abs() < 1e-9, "{terzopoulos} {strong:?} {after} {expected}");
        }
    }
}

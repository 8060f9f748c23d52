//! Unstable equilibria: found by their lowest mode, left for stable ones, and reached by disturbances that are told by a seed.

use crate::physics_case::{Case, Kind, forms, free, model, points, principal, run, set_up, shell, six_pins, try_run, unknowns};
use crate::pipeline_support::{Sandbox, with};
use nalgebra::{DMatrix, Vector3};
use std::f64::consts::PI;
use std::fs;
use thinshell::mesh::generate::{Pattern as Cells, rectangle};
use thinshell::mesh::{Mesh, Topology};
use thinshell::report::vertex_areas;
use thinshell::shell::{Koiter, Material, Measure, QuadraticFree, Shell};
use thinshell::sparse::{Curvature, Numbering, Pattern, System};

const MATERIAL: &str = "youngs_modulus = 1e9\npoissons_ratio = 0.3\n";

/// A strip of length 1 and width 1/4 between hinges that takes a share `factor` of Euler's load, `pi^2 E h^3 / 12` per width.
fn column(factor: &str, steps: usize) -> Case {
    let (h, modulus) = (5e-3_f64, 1e9);
    let critical = PI.powi(2) * modulus * h.powi(3) / 12.0;
    run(&format!(
        "[mesh.rectangle]\nsize = [1.0, 0.25]\ncells = [12, 3]\n[shell]\nthickness = {h:?}\nyoungs_modulus = {modulus:?}\npoissons_ratio = 0.0\n\
         [[region]]\nname = \"corner\"\nnearest = [0, 0, 0]\n[[pin]]\nregion = \"left\"\ncomponents = [\"x\", \"z\"]\n\
         [[pin]]\nregion = \"right\"\ncomponents = [\"z\"]\n[[pin]]\nregion = \"corner\"\ncomponents = [\"y\"]\n\
         [[edge-load]]\nregion = \"right\"\nforce = [-{critical:?}, 0, 0]\nfactor = \"{factor}\"\n[statics]\nsteps = {steps}\nstable = true\n"
    ))
}

/// Largest height of the mid-line [m].
fn rise(states: &[Vector3<f64>]) -> f64 {
    states.iter().fold(0.0, |m, p| m.max(p.z.abs()))
}

/// Mid-height over length of the elastica between hinges under `load` times Euler's: `load = (2 K / pi)^2`, height `k / K`.
fn elastica(load: f64) -> f64 {
    let complete = |k: f64| {
        let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
        for _ in 0..30 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        PI / (2.0 * a)
    };
    let (mut low, mut high) = (0.0, 0.999);
    for _ in 0..60 {
        let k = 0.5 * (low + high);
        if (2.0 * complete(k) / PI).powi(2) < load { low = k } else { high = k }
    }
    low / complete(low)
}

#[test]
fn a_column_buckles_at_eulers_load_and_becomes_the_elastica() {
    let case = column("0.985 + 0.03 * t", 3);
    let states: Vec<f64> = case.states().iter().map(|s| rise(&points(s, "position"))).collect();
    let (switches, lowest, before) =
        (case.column("branch_switches"), case.column("lowest_eigenvalue"), case.column("lowest_eigenvalue_before"));
    println!("heights {states:?}, switches {switches:?}, lowest {lowest:?}, before {before:?}");
    // 0.995 stays straight and 1.005 does not, nor 1.015.
    assert_eq!(case.column("time_s").len(), 3);
    assert!(states[1] < 1e-9 && lowest[0] > 0.0 && switches[0] == 0.0 && before[0] == lowest[0]);
    assert!(before[1] < 0.0 && lowest[1] > 0.0 && switches[1..] == [1.0, 1.0]);
    for (state, load) in [(2, 1.005), (3, 1.015)] {
        let exact = elastica(load);
        println!("load {load}: height {} exact {exact}", states[state]);
        assert!((states[state] / exact - 1.0).abs() < 0.02, "{} {exact}", states[state]);
    }
    // Far beyond, at once.
    let case = column("1.3 * t", 1);
    println!("height {} exact {}, {} factorisations", rise(&case.end), elastica(1.3), case.last("factorizations"));
    assert!((rise(&case.end) / elastica(1.3) - 1.0).abs() < 0.01);
    assert!(case.last("lowest_eigenvalue") > 0.0 && case.last("negative_pivots") == 0.0);
}

/// A free disc of radius 0.1 with natural curvature `t` times `k` both ways.
fn disc(k: &str, steps: usize, statics: &str) -> String {
    format!(
        "[mesh.disc]\nradius = 0.1\nrings = 8\n{}[shell]\nthickness = 1e-3\n{MATERIAL}[rest.pullback]\nabar = [1, 0, 1]\nbbar = [\"{k}\", 0, \"{k}\"]\n\
         [statics]\nsteps = {steps}\n{statics}\n",
        six_pins(0.0, 0.0, 0.0125, 0.0125)
    )
}

/// Principal curvatures around the vertex nearest to a place of the initial shape, the larger in size first: means over its faces.
fn at(case: &Case, x: f64, y: f64) -> [f64; 2] {
    let mesh = &case.mesh;
    let material = Material { thickness: 1e-3, youngs_modulus: 1e9, poissons_ratio: 0.3 };
    let element = QuadraticFree::new(mesh, &Topology::new(&mesh.faces), &mesh.midpoints, Measure::Tan, &free(mesh));
    let mut shell = Koiter::new(element, vec![material; mesh.faces.len()], None);
    let last = case.states().pop().unwrap();
    shell.set_directors(&points(&last, "director"));
    let mut state: Vec<f64> = last.field("position").unwrap().data.clone();
    state.resize(shell.unknowns(), 0.0);
    let forms = shell.forms(&state);
    let vertex = mesh.region_nearest(Vector3::new(x, y, 0.0)).vertices[0];
    let around = mesh.faces.iter().enumerate().filter(|(_, face)| face.contains(&vertex));
    let curvatures: Vec<[f64; 2]> =
        around.flat_map(|(f, _)| (3 * f..3 * f + 3).map(|k| principal(&forms[k])).collect::<Vec<_>>()).collect();
    let mean = [0, 1].map(|i| curvatures.iter().map(|k| k[i]).sum::<f64>() / curvatures.len() as f64);
    if mean[0].abs() > mean[1].abs() { mean } else { [mean[1], mean[0]] }
}

#[test]
fn a_disc_with_natural_curvature_is_a_cap_then_a_cylinder() {
    let reference: toml::Table = include_str!("../../data/reference/nonlinear_shells.toml").parse().unwrap();
    let exact = reference["disc_natural_curvature"]["c_nu_0_3"].as_float().unwrap();
    // In units of h/a^2 = 0.1 per metre: from 5 to 6.
    let case = run(&disc("0.1 * (5 + t)", 10, "stable = true"));
    let (times, before, switches) = (case.column("time_s"), case.column("lowest_eigenvalue_before"), case.column("branch_switches"));
    let i = before.iter().position(|l| *l < 0.0).unwrap();
    let share = before[i - 1] / (before[i - 1] - before[i]);
    let found = 5.0 + times[i - 1] + share * (times[i] - times[i - 1]);
    println!("{before:?}: onset {found} exact {exact}; {} factorisations", case.last("factorizations"));
    assert!((found / exact - 1.0).abs() < 0.01, "{found}");
    assert!(switches[i - 1] == 0.0 && switches[i] > 0.0);
    // Below, a cap: both curvatures alike.
    let cap = run(&disc("0.5 * t", 2, "stable = true"));
    let [k1, k2] = at(&cap, 0.0, 0.0);
    println!("cap {k1} {k2}");
    assert!((k1 / k2 - 1.0).abs() < 0.02 && k1 > 0.1);
    // Far above, a cylinder that tends to the one without stretching: what is missing is at the edges, over a width of sqrt(h/k).
    let missing = [3.0, 12.0].map(|k| {
        let bent = run(&disc(&format!("{k} * t"), 8, "stable = true"));
        let [k1, k2] = at(&bent, 0.0, 0.0);
        println!("cylinder {k1} {k2}, {} factorisations", bent.last("factorizations"));
        assert!(k2.abs() < 0.04 * k1 && bent.last("lowest_eigenvalue") > 0.0 && bent.last("branch_switches") > 0.0);
        1.0 - k1 / (1.3 * k)
    });
    println!("missing {missing:?}");
    assert!(missing[1] > 0.0 && missing[1] < 0.05 && missing[1] < 0.7 * missing[0], "{missing:?}");
}

/// The scene of the onset passes. On a finer mesh the disc may turn about its axis with less resistance than round-off of the forces makes
/// movement: Newton's method ends there, the mode is told to be neutral, and the steps that follow are as long as those before.
#[test]
fn a_neutral_equilibrium_is_kept_and_told() {
    let scene = include_str!("../../configs/analytic/disc_curvature.toml");
    Sandbox::new(scene).ok(&["all", "scene.toml"]);
    let fine = Sandbox::new(&with(scene, "rings = 8", "rings = 12"));
    let (out, _) = fine.ok(&["all", "scene.toml"]);
    assert!(["The last equilibrium is stable", "neutral within round-off"].iter().any(|verdict| out.contains(verdict)), "{out}");
    let history = fs::read_to_string(fine.case("history.csv")).unwrap();
    let rows: Vec<Vec<&str>> = history.lines().map(|line| line.split(',').collect()).collect();
    let last = |name: &str| rows[rows.len() - 1][rows[0].iter().position(|c| *c == name).unwrap()].parse::<f64>().unwrap();
    let (before, lowest) = (last("lowest_eigenvalue_before"), last("lowest_eigenvalue"));
    assert!(before < -100.0 && lowest.abs() < 1e-4 * before.abs() && last("branch_switches") == 1.0, "{history}");
    let beyond = "0.5619 * (1.005 + 0.01 * t)";
    let scene = with(scene, "\"0.5619 * (0.97 + 0.04 * t)\", 0, \"0.5619 * (0.97 + 0.04 * t)\"", &format!("\"{beyond}\", 0, \"{beyond}\""));
    let case = run(&with(&with(&scene, "rings = 8", "rings = 16"), "steps = 2", "steps = 3"));
    let (times, eigenvalues) = (case.column("time_s"), case.column("lowest_eigenvalue"));
    println!("{eigenvalues:?}, residuals {:?}, movements {:?}", case.column("residual"), case.column("increment_m"));
    assert!(times.len() == 3 && case.column("halvings") == [0.0; 3] && case.last("branch_switches") == 1.0);
    assert!(eigenvalues.iter().all(|l| l.abs() < 1e-4) && case.column("residual").iter().all(|r| *r < 1e-15));
}

/// A square of side 0.1 that would bend to `k` along x and `other` along y, and can do only one of them.
fn square(cells: usize, k: f64, other: f64, statics: &str) -> String {
    let cell = 0.1 / cells as f64;
    format!(
        "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [{cells}, {cells}]\npattern = \"alternating\"\n{}[shell]\nthickness = 1e-3\n{MATERIAL}\
         [rest.pullback]\nbbar = [\"{k} * t\", 0, \"{other} * t\"]\n[statics]\nsteps = 8\n{statics}\n",
        six_pins(0.05, 0.05, cell, cell)
    )
}

#[test]
fn frustrated_squares_find_their_cylinders() {
    let perturbation = "stable = true\nperturbation = { amplitude = 1e-5, seed = 1 }";
    for (other, factor) in [(20.0, 1.3), (-20.0, 0.7)] {
        let case = run(&square(8, 20.0, other, perturbation));
        let [k1, k2] = at(&case, 0.05, 0.05);
        println!("{other}: {k1} {k2}, {} factorisations, lowest {}", case.last("factorizations"), case.last("lowest_eigenvalue"));
        assert!((k1.abs() / (factor * 20.0) - 1.0).abs() < 0.05 && k2.abs() < 0.02 * k1.abs(), "{k1} {k2}");
        assert!(case.last("lowest_eigenvalue") > 0.0 && case.last("negative_pivots") == 0.0);
        // The cap or saddle that an undisturbed square stays has more energy.
        let stuck = run(&square(8, 20.0, other, ""));
        let energy = |case: &Case| case.last("membrane_energy_J") + case.last("bending_energy_J");
        println!("energy {} instead of {}", energy(&case), energy(&stuck));
        assert!(stuck.last("negative_pivots") > 0.0);
        assert!(energy(&case) < 0.9 * energy(&stuck));
    }
}

#[test]
fn a_seed_tells_the_disturbance() {
    let scene = |seed: u64| square(8, 20.0, 20.0, &format!("perturbation = {{ amplitude = 2e-5, seed = {seed} }}"));
    let (mesh, setup, first) = set_up(&scene(3)).unwrap();
    let (_, _, again) = set_up(&scene(3)).unwrap();
    let (_, plain, undisturbed) = set_up(&square(8, 20.0, 20.0, "")).unwrap();
    assert_eq!(first, again);
    assert_ne!(first.field("position"), set_up(&scene(4)).unwrap().2.field("position"));
    // The rest shape is that of the undisturbed mesh.
    assert_eq!(setup.rest_forms, plain.rest_forms);
    let moves: Vec<Vector3<f64>> = points(&first, "position").iter().zip(mesh.nodes()).map(|(p, q)| p - q).collect();
    assert!((rise(&moves) - 2e-5).abs() < 1e-18 && moves.iter().all(|d| d.x == 0.0 && d.y == 0.0));
    let held: Vec<usize> = setup.held.iter().filter(|h| h.unknown % 3 == 2).map(|h| h.unknown / 3).collect();
    assert!(held.len() == 3 && held.iter().all(|n| moves[*n].z == 0.0));
    // Directors follow the shape.
    assert_ne!(first.field("director"), undisturbed.field("director"));
    assert!(points(&first, "director").iter().all(|d| (d.norm() - 1.0).abs() < 1e-14 && d.z > 0.99));
    // A disturbance alone is enough where the first step goes past the branch: a flat disc with the metric of a sphere.
    let sphere = |statics: &str| {
        let flat = disc("0", 2, statics);
        run(&with(&flat, "abar = [1, 0, 1]\nbbar = [\"0\", 0, \"0\"]", "abar = [1, 0, \"(0.1*sin(r/0.1))^2\"]\ncomponents = \"polar\""))
    };
    assert_eq!(sphere("perturbation = { amplitude = 1e-3 }").last("negative_pivots"), 0.0);
    assert!(sphere("").last("negative_pivots") > 0.0);
}

#[test]
fn impossible_disturbances_are_told() {
    let scene = |pins: &str, statics: &str| {
        format!(
            "[mesh.rectangle]\nsize = [0.1, 0.1]\ncells = [2, 2]\n[[region]]\nname = \"everything\"\nwhere = \"1\"\n[shell]\nthickness = 1e-3\n\
             {MATERIAL}{pins}[statics]\n{statics}\n"
        )
    };
    let all = "[[pin]]\nregion = \"everything\"\ncomponents = [\"z\"]\n";
    let message = set_up(&scene(all, "perturbation = { amplitude = 1e-5 }")).unwrap_err().to_string();
    assert!(message.contains("statics.perturbation") && message.contains("no node free"), "{message}");
    for (statics, key) in [
        ("perturbation = { amplitude = 0 }", "statics.perturbation.amplitude"),
        ("perturbation = { amplitude = nan }", "statics.perturbation.amplitude"),
        ("stable = true\n[[moment]]\nregion = \"left\"\nmoment = [0, 1, 0]", "statics.stable"),
        ("[output]\nlowest_mode = true", "output.lowest_mode"),
    ] {
        let message = thinshell::scene::parse("scene.toml", &scene("", statics), &[]).unwrap_err().to_string();
        assert!(message.contains(key), "{key}: {message}");
    }
}

/// Switches happen in the first half; whether the run was stopped before, between or after does not show.
#[test]
fn resumed_runs_are_the_same_bit_by_bit() {
    let disturbed = "stable = true\nperturbation = { amplitude = 1e-6, seed = 5 }";
    let scene = square(4, 20.0, 20.0, disturbed) + "[output]\nlowest_mode = true\n";
    let whole = Sandbox::new(&scene).prepared();
    let (_, said) = whole.ok(&["run", "scene.toml"]);
    assert!(said.contains("branch switched at load factor"), "{said}");
    for pieces in [&[1][..], &[1, 1, 2]] {
        let parts = Sandbox::new(&scene).prepared();
        pieces.iter().for_each(|n: &i32| drop(parts.ok(&["run", "scene.toml", "--stop-after", &n.to_string()])));
        parts.ok(&["run", "scene.toml"]);
        assert!(parts.result() == whole.result(), "{pieces:?}: {:?} {:?}", parts.history(), whole.history());
    }
    whole.ok(&["export", "scene.toml"]);
    let (out, _) = whole.ok(&["report", "scene.toml"]);
    assert!(out.contains("branch switched at load factor"), "{out}");
    assert!(out.contains("The last equilibrium is stable: lowest eigenvalue"), "{out}");
    let text = String::from_utf8_lossy(&fs::read(whole.case("vtk/step_00000008.vtu")).unwrap()).into_owned();
    assert!(text.contains("Name=\"lowest_mode\""));
}

/// Stiffness over the free unknowns of a shell whose rest forms are `rest`, dense.
fn dense(shell: &mut dyn Shell, x: &[f64], held: &[bool]) -> DMatrix<f64> {
    let numbering = Numbering::new(held);
    let pattern = Pattern::new(&numbering, &mut |visit| shell.stencils(visit)).unwrap();
    shell.bind(&numbering, &pattern);
    shell.restart(x);
    let mut system = System::new(&pattern);
    shell.assemble(x, Curvature::Mixed, &mut system);
    let mut matrix = DMatrix::zeros(pattern.len(), pattern.len());
    for j in 0..pattern.len() {
        for k in pattern.column_start[j] as usize..pattern.column_start[j + 1] as usize {
            let i = pattern.row[k] as usize;
            matrix[(i, j)] = system.matrix[k];
            matrix[(j, i)] = system.matrix[k];
        }
    }
    matrix
}

/// A flat plate held around its rim and swollen, which buckles: eigenvalues of the flat state and of the buckled one against dense ones.
#[test]
fn the_lowest_eigenvalue_is_that_of_the_dense_matrix() {
    let mesh: Mesh = rectangle([1.0, 0.8], [5, 4], Cells::Alternating, 0.1, 2).unwrap();
    let material = Material { thickness: 0.02, youngs_modulus: 1.0, poissons_ratio: 0.3 };
    let make = || shell(Kind::Tan, &mesh, &free(&mesh), material);
    let flat = unknowns(&*make(), &mesh);
    let mut rest = forms(&make().forms(&flat));
    rest.iter_mut().for_each(|f| f.a = f.a.map(|a| 1.02 * a));
    let topology = Topology::new(&mesh.faces);
    let mut held = vec![false; flat.len()];
    let rim = topology.edges.iter().enumerate().filter(|(e, _)| topology.is_boundary(*e)).flat_map(|(_, ends)| ends);
    rim.for_each(|v| held[3 * v..3 * v + 3].fill(true));
    let held_list = || held.iter().enumerate().filter(|(_, h)| **h).map(|(i, _)| i);
    let areas = vertex_areas(&mesh.vertices, &mesh.faces);
    // Angles have no mass: what is left of the stiffness once they have found their places.
    let lowest = |matrix: &DMatrix<f64>| {
        let free: Vec<usize> = (0..flat.len()).filter(|i| !held[*i]).collect();
        let n = free.iter().filter(|i| **i < 3 * mesh.vertices.len()).count();
        let (k, c, d) =
            (matrix.view((0, 0), (n, n)), matrix.view((n, 0), (free.len() - n, n)), matrix.view((n, n), (free.len() - n, free.len() - n)));
        let condensed = k - c.transpose() * d.into_owned().cholesky().expect("angles are stable").solve(&c.into_owned());
        let scaled = DMatrix::from_fn(n, n, |i, j| condensed[(i, j)] / (areas[free[i] / 3] * areas[free[j] / 3]).sqrt());
        scaled.symmetric_eigen().eigenvalues.min()
    };
    let mut at_flat = make();
    at_flat.set_rest(&rest);
    let matrix = dense(&mut *at_flat, &flat, &held);
    let exact = lowest(&matrix);
    let negative = matrix.symmetric_eigen().eigenvalues.iter().filter(|l| **l < 0.0).count();
    let stuck = model(make(), &mesh, rest.clone(), None, held_list()).advance(1.0, 1.0).unwrap().solved;
    assert!(negative > 1 && stuck.negative_pivots == negative && stuck.stability.is_none(), "{negative} {stuck:?}");

    let mut model = model(make(), &mesh, rest.clone(), None, held_list());
    model.leave_unstable(&areas, true);
    let solved = model.advance(1.0, 1.0).unwrap().solved;
    let stability = solved.stability.unwrap();
    println!("{negative} negative; flat {exact}; {stability:?}");
    assert!(exact < 0.0 && (stability.before / exact - 1.0).abs() < 1e-6);
    assert!(stability.switches > 0 && solved.negative_pivots == 0 && stability.lowest > 0.0);
    let mut buckled = make();
    buckled.set_rest(&rest);
    buckled.set_directors(&points(&model.snapshot(), "director"));
    let exact = lowest(&dense(&mut *buckled, model.unknowns(), &held));
    assert!((stability.lowest / exact - 1.0).abs() < 1e-6, "{} {exact}", stability.lowest);
    // Its mode is there too, the largest coordinate 1.
    let mode = &model.snapshot().field("lowest_mode").unwrap().data.clone();
    assert!((mode.iter().fold(0.0f64, |m, v| m.max(v.abs())) - 1.0).abs() < 1e-14);
}

/// A scene can expect the lowest eigenvalue, and one without `stable` has none.
#[test]
fn the_lowest_eigenvalue_can_be_expected() {
    let expect = "[[report.expect]]\nname = \"stable\"\nmeasure = { history = { column = \"lowest_eigenvalue\" } }\nreference = 1e6\ntolerance = 1e6\nsource = \"none\"\n";
    let case = run(&(square(4, 5.0, 0.0, "stable = true") + expect));
    assert!(case.column("lowest_eigenvalue").iter().all(|l| *l > 0.0) && case.last("branch_switches") == 0.0);
    let message = try_run(&(square(4, 5.0, 0.0, "") + expect)).err().unwrap().to_string();
    assert!(message.contains("no column 'lowest_eigenvalue'"), "{message}");
}

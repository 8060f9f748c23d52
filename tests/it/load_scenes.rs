//! Scenes under forces, edge loads and pressure: equilibrium, beam and membrane theory, factors in time, and what is refused.

use crate::finite_differences::bind;
use crate::physics_case::{Case, forms, points, run};
use crate::pipeline_support::{DYNAMIC, STATIC, Sandbox, with};
use nalgebra::Vector3;
use thinshell::mesh::Topology;
use thinshell::shell::fields::{PointFields, at_point};
use thinshell::shell::{Director, Koiter, LinearFree, Measure, QuadraticFree, Shell};
use thinshell::stage;

const ELEMENTS: [&str; 2] = ["linear", "quadratic"];

/// The shell of a case at its end, and its unknowns.
fn shell_at_end(case: &Case) -> (Box<dyn Shell>, Vec<f64>) {
    let (mesh, topology) = (&case.mesh, Topology::new(&case.mesh.faces));
    let (setup, _) = stage::setup::load(&case.job).unwrap();
    let free = vec![Director::Free; topology.edges.len()];
    let mut shell: Box<dyn Shell> = if mesh.midpoints.is_empty() {
        Box::new(Koiter::new(LinearFree::new(mesh, &topology, Measure::Tan, &free), setup.materials, None))
    } else {
        Box::new(Koiter::new(QuadraticFree::new(mesh, &topology, &mesh.midpoints, Measure::Tan, &free), setup.materials, None))
    };
    shell.set_rest(&setup.initial_forms);
    shell.set_directors(&points(case.states().last().unwrap(), "director"));
    let mut x: Vec<f64> = case.end.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    x.resize(shell.unknowns(), 0.0);
    (shell, x)
}

/// What has to act on each node to keep the shell where it ended [N]: the loads, and the reactions of the supports.
fn acting(case: &Case) -> Vec<Vector3<f64>> {
    let (mut shell, x) = shell_at_end(case);
    let (_, mut system) = bind(&mut *shell, x.len());
    shell.gradient(&x, &mut system);
    system.gradient[..3 * case.end.len()].chunks_exact(3).map(|g| Vector3::new(g[0], g[1], g[2])).collect()
}

/// Fields of each integration point, with the initial centre of its face.
fn fields(case: &Case) -> Vec<(Vector3<f64>, PointFields)> {
    let (shell, x) = shell_at_end(case);
    let (setup, _) = stage::setup::load(&case.job).unwrap();
    let (tangents, forms) = (shell.tangents(&x), forms(&shell.forms(&x)));
    (0..forms.len())
        .map(|i| {
            let face = i / shell.points();
            let place = case.mesh.faces[face].iter().map(|v| case.mesh.vertices[*v]).sum::<Vector3<f64>>() / 3.0;
            (place, at_point(&tangents[i], &forms[i], &setup.initial_forms[i], &setup.materials[face], &setup.constitution(face)))
        })
        .collect()
}

const LENGTH: f64 = 10.0;
const RIGIDITY: f64 = 100.0;

/// A strip of width 1 and rigidity `E I` = 100, clamped at x = 0, nu = 0.
fn cantilever(element: &str, cells: [usize; 2], rest: &str) -> Case {
    run(&format!(
        "[mesh.rectangle]\nsize = [{LENGTH:?}, 1.0]\ncells = {cells:?}\n[solver]\ntolerance = 1e-13\n\
         [shell]\nelement = \"{element}\"\nthickness = 0.1\nyoungs_modulus = 1.2e6\npoissons_ratio = 0.0\n\
         [[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n{rest}"
    ))
}

/// Sum of what acts at an end, and that at each of its nodes.
fn at_end(case: &Case, x: f64) -> (Vector3<f64>, Vec<Vector3<f64>>) {
    let acting = acting(case);
    let there: Vec<_> = case.mesh.nodes().iter().zip(&acting).filter(|(p, _)| (p.x - x).abs() < 1e-9).map(|(_, f)| *f).collect();
    (there.iter().sum(), there)
}

#[test]
fn a_cantilever_under_little_load_is_a_beam() {
    let force = 3e-4;
    let deflection = force * LENGTH.powi(3) / (3.0 * RIGIDITY);
    for (element, cells) in [("linear", [40, 4]), ("quadratic", [10, 1])] {
        let vertices = (cells[1] + 1) as f64;
        for (load, column) in [
            (format!("[[edge-load]]\nregion = \"right\"\nforce = [0, 0, {force:?}]\n"), "edge_load_energy_J"),
            (format!("[[force]]\nregion = \"right\"\nforce = [0, 0, {:?}]\n", force / vertices), "force_energy_J"),
        ] {
            let case = cantilever(element, cells, &format!("{load}[statics]\nsteps = 1\n"));
            let tip: Vec<f64> =
                case.mesh.nodes().iter().zip(&case.end).filter(|(p, _)| (p.x - LENGTH).abs() < 1e-9).map(|(p, q)| q.z - p.z).collect();
            let mean = tip.iter().sum::<f64>() / tip.len() as f64;
            assert!((mean / deflection - 1.0).abs() < 5e-3, "{element} {column}: {mean} {deflection}");
            // The load does the work F w, half of which is stored.
            let (work, stored) = (-case.last(column), case.last("membrane_energy_J") + case.last("bending_energy_J"));
            assert!((work / (force * mean) - 1.0).abs() < 2e-3, "{element} {column}: {work}");
            assert!((stored / work - 0.5).abs() < 1e-5, "{element} {column}: {stored} {work}");
            let ((right, shares), (left, _)) = (at_end(&case, LENGTH), at_end(&case, 0.0));
            assert!((right.z / force - 1.0).abs() < 1e-6 && (left.z / force + 1.0).abs() < 1e-6, "{element} {column}: {right} {left}");
            let expected: Vec<f64> = match (element, column) {
                ("quadratic", "edge_load_energy_J") => vec![1.0 / 6.0, 1.0 / 6.0, 4.0 / 6.0],
                ("quadratic", _) => vec![0.5, 0.5, 0.0],
                (_, "edge_load_energy_J") => vec![0.125, 0.25, 0.25, 0.25, 0.125],
                _ => vec![0.2; 5],
            };
            for (share, expected) in shares.iter().zip(&expected) {
                assert!((share.z / force - expected).abs() < 1e-6, "{element} {column}: {shares:?}");
            }
        }
    }
}

/// A hemisphere of radius 1. `rim`: its support.
fn hemisphere(element: &str, rings: usize, pressure: f64, rim: &str) -> Case {
    run(&format!(
        "[mesh.sphere-cap]\nradius = 1.0\nhalf_angle = 90.0\nrings = {rings}\n\
         [shell]\nelement = \"{element}\"\nthickness = {THICKNESS}\nyoungs_modulus = {YOUNG:?}\npoissons_ratio = 0.3\n\
         {rim}[[pressure]]\npressure = {pressure:?}\n[statics]\nsteps = 1\n"
    ))
}

const THICKNESS: f64 = 0.01;
const YOUNG: f64 = 1e7;
const SYMMETRIC: &str = "[[region]]\nname = \"side\"\nnearest = [1, 0, 0]\n[[pin]]\nregion = \"rim\"\ncomponents = [\"z\"]\n\
    director = { symmetry = [0, 0, 1] }\n[[pin]]\nregion = \"apex\"\ncomponents = [\"x\", \"y\"]\n[[pin]]\nregion = \"side\"\ncomponents = [\"y\"]\n";
const CLAMPED: &str = "[[pin]]\nregion = \"rim\"\ndirector = \"clamped\"\n";

/// The membrane stress is `p R / (2 h)` in all directions: all over a half whose rim is a plane of symmetry, and away from a clamped rim.
/// The linear element's error, of second order, is largest at the six corners of that rim, where four faces meet, mirrored ones counted,
/// instead of six; they are left out.
#[test]
fn a_sphere_under_little_pressure_is_a_membrane() {
    let pressure = 20.0;
    let stress = pressure / (2.0 * THICKNESS);
    let swelling = stress * (1.0 - 0.3) / YOUNG;
    for (element, rings, tolerance) in [("linear", 24, 0.02), ("quadratic", 12, 0.002)] {
        for (name, rim, from) in [("symmetric", SYMMETRIC, if element == "linear" { 0.2 } else { 0.0 }), ("clamped", CLAMPED, 0.5)] {
            for sign in [1.0, -1.0] {
                let case = hemisphere(element, rings, sign * pressure, rim);
                let fields: Vec<PointFields> = fields(&case).into_iter().filter(|(p, _)| p.z > from).map(|(_, f)| f).collect();
                assert!(fields.len() > 3 * rings * rings / 2);
                for field in fields {
                    // The third principal stress is the vanishing one along the normal.
                    let (sum, square) = (field.membrane_stress.trace(), field.membrane_stress.norm_squared());
                    let radius = (0.5 * square - 0.25 * sum * sum).max(0.0).sqrt();
                    for principal in [0.5 * sum + radius, 0.5 * sum - radius] {
                        assert!((principal - sign * stress).abs() < tolerance * stress, "{element} {name}: {principal} of {stress}");
                    }
                }
                for (p, q) in case.mesh.nodes().iter().zip(&case.end).filter(|(p, _)| name == "symmetric" && p.z >= from) {
                    let out = (q - p).dot(p) / (sign * swelling);
                    assert!((out - 1.0).abs() < tolerance, "{element}: {out} at {p:?}");
                }
            }
        }
    }
}

/// On a square of side 1, held at its boundary, a patch of 4 x 4 cells inside is loaded.
#[test]
fn the_reactions_carry_the_pressure_on_a_region() {
    for element in ELEMENTS {
        let case = run(&format!(
            "[mesh.rectangle]\nsize = [1.0, 1.0]\ncells = [8, 8]\n[solver]\ntolerance = 1e-13\n[[region]]\nname = \"patch\"\n\
             where = \"abs(x - 0.5) < 0.25 && abs(y - 0.5) < 0.25\"\n[[pin]]\nregion = \"boundary\"\n\
             [shell]\nelement = \"{element}\"\nthickness = 0.01\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
             [[pressure]]\nregion = \"patch\"\npressure = 2.0\n[statics]\nsteps = 1\n"
        ));
        let rim = |p: &Vector3<f64>| [p.x, p.y].iter().any(|c| c.min(1.0 - c).abs() < 1e-9);
        let acting = acting(&case);
        let nodes = case.mesh.nodes();
        let (held, loaded): (Vec<_>, Vec<_>) = nodes.iter().zip(&acting).partition(|(p, _)| rim(p));
        let sum = |list: &[(&Vector3<f64>, &Vector3<f64>)]| list.iter().map(|(_, f)| f.z).sum::<f64>();
        // The patch keeps its projected area but for what its rim moves along the plane.
        assert!((sum(&loaded) - 0.5).abs() < 1e-6 && (sum(&held) + 0.5).abs() < 1e-6, "{element}");
        for (p, f) in loaded {
            assert!((p.x - 0.5).abs().max((p.y - 0.5).abs()) < 0.25 + 1e-9 || f.norm() < 1e-7, "{element}: {f:?} at {p:?}");
        }
    }
}

/// In statics a load without a factor grows with the load factor, others go as they say; the answer to little load is linear.
#[test]
fn factors_in_load_steps() {
    type Exact = fn(f64) -> f64;
    let factors: [(&str, Exact); 3] = [("", |t| t), ("factor = \"t^2\"\n", |t| t * t), ("factor = \"1 - 0.5 * t\"\n", |t| 1.0 - 0.5 * t)];
    for load in [
        "[[force]]\nregion = \"right\"\nforce = [0, 0, 1e-5]\n",
        "[[edge-load]]\nregion = \"right\"\nforce = [0, 0, 2e-5]\n",
        "[[pressure]]\npressure = 1e-6\n",
    ] {
        let ends = factors.map(|(factor, exact)| {
            let case = cantilever("linear", [10, 1], &format!("{load}{factor}[statics]\nsteps = 4\n"));
            let tip = case.mesh.region_nearest(Vector3::new(LENGTH, 0.0, 0.0)).vertices[0];
            let states = case.states();
            let last = points(states.last().unwrap(), "position")[tip].z;
            assert!(states.len() == 5 && last > 1e-6);
            for state in &states[1..] {
                let ratio = points(state, "position")[tip].z / last;
                assert!((ratio - exact(state.time) / exact(1.0)).abs() < 1e-6, "{load}{factor}: {ratio} at {}", state.time);
            }
            last / exact(1.0)
        });
        assert!(ends.iter().all(|end| (end / ends[0] - 1.0).abs() < 1e-6), "{load}: {ends:?}");
    }
}

/// In motion a load without a factor is there at once. The momentum of a free plate is the impulse of implicit Euler's steps.
#[test]
fn factors_in_motion() {
    let (dt, steps, mass) = (1e-3, 10u32, 0.06 * 0.02 * 1e-3 * 1000.0);
    for (load, total) in [
        ("[[force]]\nregion = \"left\"\nforce = [1e-4, 2e-4, 0]\n", Vector3::new(3e-4, 6e-4, 0.0)),
        ("[[edge-load]]\nregion = \"right\"\nforce = [1e-2, 0, 2e-2]\n", Vector3::new(2e-4, 0.0, 4e-4)),
        ("[[pressure]]\npressure = 0.5\n", Vector3::new(0.0, 0.0, 6e-4)),
    ] {
        for (factor, impulse) in [("", 10.0), ("factor = \"1000 * t\"\n", 55.0)] {
            for element in ELEMENTS {
                let case = run(&format!(
                    "[mesh.rectangle]\nsize = [0.06, 0.02]\ncells = [6, 2]\n[solver]\ntolerance = 1e-13\n\
                     [shell]\nelement = \"{element}\"\nmass = \"lumped\"\nthickness = 1e-3\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\ndensity = 1000.0\n\
                     {load}{factor}[dynamics]\ndt = {dt}\nend = {}\n",
                    dt * f64::from(steps)
                ));
                // Lumped masses of straight faces of equal size: a third of each for the vertices; 3 and 16 of 57 for the six nodes.
                let share = mass / case.mesh.faces.len() as f64;
                let mut masses = vec![0.0; case.end.len()];
                let topology = Topology::new(&case.mesh.faces);
                for (face, edges) in case.mesh.faces.iter().zip(&topology.face_edges) {
                    let part = if case.mesh.midpoints.is_empty() { 1.0 / 3.0 } else { 3.0 / 57.0 };
                    face.iter().for_each(|v| masses[*v] += part * share);
                    if !case.mesh.midpoints.is_empty() {
                        edges.iter().for_each(|e| masses[case.mesh.vertices.len() + e] += 16.0 / 57.0 * share);
                    }
                }
                let last = case.states().pop().unwrap();
                let momentum: Vector3<f64> = points(&last, "velocity").iter().zip(&masses).map(|(v, m)| v * *m).sum();
                let error = (momentum - total * (impulse * dt)).norm() / (total.norm() * impulse * dt);
                assert!(error < 1e-6, "{element} {load}{factor}: {momentum:?} {total:?}");
            }
        }
    }
}

const LOADS: [(&str, &str, &str); 3] = [
    ("force", "[[force]]\nregion = \"right\"\nforce = [0, 0, 1e-4]\n", "force_energy_J"),
    ("edge-load", "[[edge-load]]\nregion = \"right\"\nforce = [0, 0, 1e-3]\n", "edge_load_energy_J"),
    ("pressure", "[[pressure]]\npressure = 0.1\n", "pressure_energy_J"),
];

#[test]
fn loads_that_are_refused() {
    let point = "[[region]]\nname = \"corner\"\nnearest = [0.06, 0.02, 0]\n";
    let refused = |scene: &str, words: &[&str]| {
        let sandbox = Sandbox::new(scene);
        for verb in ["check", "all"] {
            let message = sandbox.fails(2, &[verb, "scene.toml"]);
            assert!(words.iter().all(|w| message.contains(w)), "{verb}: {words:?} are not in {message}");
            assert_eq!(sandbox.names("."), ["scene.toml"]);
        }
        if sandbox.output(&["mesh", "scene.toml", "-q"]).status.success() {
            let (before, message) = (sandbox.names("cases/scene"), sandbox.fails(2, &["setup", "scene.toml"]));
            assert!(words.iter().all(|w| message.contains(w)), "setup: {words:?} are not in {message}");
            assert_eq!(sandbox.names("cases/scene"), before);
        }
    };
    for (key, load, _) in LOADS {
        // The second of two tables is the wrong one.
        let scene = |change: &str| format!("{STATIC}{point}{load}{load}{change}");
        let region = format!("{key}.1.region");
        let elsewhere = |name: &str| match key {
            "pressure" => scene(&format!("region = \"{name}\"\n")),
            _ => format!("{STATIC}{point}{load}{}", with(load, "right", name)),
        };
        refused(&elsewhere("rihgt"), &[&region, "there is no region 'rihgt'", "right"]);
        match key {
            "edge-load" => refused(&elsewhere("corner"), &[&region, "region 'corner' has no edges"]),
            "pressure" => refused(&elsewhere("corner"), &[&region, "region 'corner' has no faces"]),
            _ => {}
        }
        refused(&scene("factor = \"t +\"\n"), &[&format!("{key}.1.factor")]);
        refused(&scene("factor = \"x\"\n"), &[&format!("{key}.1.factor"), "x"]);
        refused(&scene("factor = \"1 / t\"\n"), &[&format!("{key}.1.factor"), "inf"]);
        refused(&scene("factor = \"sqrt(0.5 - t)\"\n"), &[&format!("{key}.1.factor"), "NaN"]);
        refused(&scene("magnitude = 1.0\n"), &["magnitude"]);
    }
    let infinite = [("force", "force = [0, 0, 1e-4]", "force = [0, inf, 0]"), ("edge-load", "force = [0, 0, 1e-3]", "force = [0, 0, nan]")];
    for ((key, load, _), (_, from, to)) in LOADS.into_iter().zip(infinite) {
        refused(&format!("{STATIC}{}", with(load, from, to)), &[&format!("{key}.0.force")]);
    }
    refused(&format!("{STATIC}[[pressure]]\npressure = inf\n"), &["pressure.0.pressure"]);
}

#[test]
fn absent_loads_leave_no_column() {
    for base in [STATIC, DYNAMIC] {
        let columns = |scene: &str| {
            let sandbox = Sandbox::new(scene);
            sandbox.ok(&["all", "scene.toml", "-q"]);
            sandbox.history()[0].split(',').map(str::to_owned).collect::<Vec<_>>()
        };
        let without = columns(base);
        assert!(without.iter().any(|c| c == "gravity_energy_J"));
        for (_, load, column) in LOADS {
            assert!(!without.iter().any(|c| c == column));
            let mut with_it = columns(&format!("{base}{load}{load}"));
            // A pressure on free edges has no energy.
            let count = usize::from(column != "pressure_energy_J");
            assert_eq!(with_it.iter().filter(|c| *c == column).count(), count, "two tables of one kind share their column: {with_it:?}");
            with_it.retain(|c| c != column);
            assert_eq!(with_it, without);
        }
    }
}

/// A slice of a long tube under outside pressure, whose ends are planes of symmetry: it has an energy, by which its flat state is left beyond
/// `p = 3 D / R^3`.
#[test]
fn a_pressed_ring_becomes_an_oval() {
    let ring = |pressure: &str| {
        let region = |name: &str, x: f64, y: f64| format!("[[region]]\nname = \"{name}\"\nnearest = [{x}, {y}, 0]\n");
        let pin = |region: &str, component: &str| format!("[[pin]]\nregion = \"{region}\"\ncomponents = [\"{component}\"]\n");
        let end = |name: &str| format!("{}director = {{ symmetry = [0, 0, 1] }}\n", pin(name, "z"));
        format!(
            "[mesh.cylinder]\nradius = 1.0\nlength = 0.1\ncells = [48, 1]\n[shell]\nthickness = 1e-2\nyoungs_modulus = 12e6\npoissons_ratio = 0.0\n\
             {}{}{}{}{}{}{}{}[[pressure]]\npressure = {pressure}\n[statics]\nsteps = 1\nstable = true\n",
            region("a", 1.0, 0.0),
            region("b", -1.0, 0.0),
            region("c", 0.0, 1.0),
            end("top"),
            end("bottom"),
            pin("a", "y"),
            pin("b", "y"),
            pin("c", "x")
        )
    };
    let [below, above] = ["-2.7", "-3.5"].map(|pressure| run(&ring(pressure)));
    assert!(below.last("branch_switches") == 0.0 && below.last("lowest_eigenvalue") > 0.0 && below.last("pressure_energy_J") > 0.0);
    // The turn of an oval along the tube is neutral but for the mesh.
    assert!(above.last("branch_switches") >= 1.0 && above.last("lowest_eigenvalue").abs() < 1e-4);
    assert!(above.displacement(1.0, 0.0, 0.0).norm() > 0.1, "{}", above.displacement(1.0, 0.0, 0.0));
    // The energy is the pressure times the area enclosed, 0.1 wide.
    let area = below.last("pressure_energy_J") / (2.7 * 0.1);
    assert!((area / std::f64::consts::PI - 1.0).abs() < 1e-3, "{area}");
}

/// A pressure has no energy on free edges, nor where it is not finite between the surface and what that is seen from: nothing tells stable states
/// then, and all else goes without.
#[test]
fn stable_states_under_a_pressure_need_its_energy() {
    let still = with(STATIC, "motion = { z = \"0.01 * t\" }\n", "");
    let held = "[[pin]]\nregion = \"boundary\"\n";
    let beneath = "[[pressure]]\npressure = \"sqrt(x - 5e-4)\"\n";
    for (load, words) in [
        ("[[pressure]]\npressure = 0.1\n".to_owned(), Some("neither held nor in planes of symmetry")),
        (format!("{held}{beneath}"), Some("not finite beneath the surface")),
        (format!("{held}[[pressure]]\npressure = 0.1\n"), None),
    ] {
        let sandbox = Sandbox::new(&format!("{}{load}", with(&still, "steps = 8", "steps = 8\nstable = true")));
        match words {
            Some(words) => {
                let message = sandbox.fails(2, &["check", "scene.toml"]);
                let flat = message.split_whitespace().collect::<Vec<_>>().join(" ");
                assert!(flat.contains("statics.stable") && flat.contains(words), "{message}");
            }
            None => drop(sandbox.ok(&["check", "scene.toml"])),
        }
        let sandbox = Sandbox::new(&format!("{still}{load}"));
        sandbox.ok(&["all", "scene.toml", "-q"]);
        assert_eq!(sandbox.history()[0].contains("pressure_energy_J"), words.is_none());
    }
}

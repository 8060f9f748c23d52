//! Loads that are spread over faces: forces per area and volume, pressure that varies, wind; alone and in scenes.

use crate::finite_differences::{bind, compare, patch};
use crate::physics_case::{points, rate, run};
use crate::pipeline_support::{DYNAMIC, STATIC, Sandbox};
use nalgebra::Vector3;
use thinshell::load::{Load, Pressure, SpreadLoad, SurfacePiece, Wind};
use thinshell::math::quadrature::{linear_radon, quadratic_triangle};
use thinshell::mesh::{Mesh, Topology};
use thinshell::sparse::Potential;

/// Vertices and bent midpoints of the patch, and its six-node faces.
fn curved(mesh: &Mesh) -> (Vec<Vector3<f64>>, Vec<[usize; 6]>) {
    let topology = Topology::new(&mesh.faces);
    let middle =
        |[a, b]: &[usize; 2]| mesh.vertices[*a].lerp(&mesh.vertices[*b], 0.5) + Vector3::new(0.02, -0.03, 0.05) * (a + 2 * b) as f64 * 0.1;
    let nodes = mesh.vertices.iter().copied().chain(topology.edges.iter().map(middle)).collect();
    let node = |e: usize| mesh.vertices.len() + e;
    let faces = mesh.faces.iter().zip(&topology.face_edges).map(|([a, b, c], [d, e, f])| [*a, *b, *c, node(*d), node(*e), node(*f)]);
    (nodes, faces.collect())
}

fn flat(nodes: &[Vector3<f64>]) -> Vec<f64> {
    nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

/// Force of each node: the negative gradient.
fn forces(potential: &mut dyn Potential, x: &[f64]) -> Vec<Vector3<f64>> {
    let (_, mut system) = bind(potential, x.len());
    potential.gradient(x, &mut system);
    system.gradient.chunks_exact(3).map(|g| -Vector3::new(g[0], g[1], g[2])).collect()
}

/// Resultant and moment of a force per area that is linear in place, on two straight faces: by the moments of area of triangles.
#[test]
fn a_spread_force_has_the_resultant_and_moment_of_its_field() {
    let corners = [Vector3::new(0.1, 0.0, 0.3), Vector3::new(1.2, 0.1, 0.2), Vector3::new(0.9, 1.1, 0.5), Vector3::new(-0.2, 0.8, 0.4)];
    let field = |p: &Vector3<f64>, t: f64| Vector3::new(1.0 + p.x, t * p.y, 2.0 - p.z);
    let (mut exact, mut moment, mut pieces) = (Vector3::zeros(), Vector3::zeros(), Vec::new());
    let time = 0.7;
    for face in [[0usize, 1, 2], [0, 2, 3]] {
        let [a, b, c] = face.map(|v| corners[v]);
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        // Exact to second degree: the middles of the edges.
        for p in [a.lerp(&b, 0.5), b.lerp(&c, 0.5), c.lerp(&a, 0.5)] {
            exact += field(&p, time) * (area / 3.0);
            moment += p.cross(&field(&p, time)) * (area / 3.0);
        }
        for point in linear_radon() {
            let place = a * point.shape[0] + b * point.shape[1] + c * point.shape[2];
            let shares = face.iter().copied().zip(point.shape.map(|n| n * 2.0 * area * point.weight)).collect();
            pieces.push(SurfacePiece { place, shares });
        }
    }
    let mut load = SpreadLoad::new(pieces, Box::new(field), true);
    load.set_factor(-0.5);
    let x = flat(&corners);
    let at_start = forces(&mut load, &x);
    load.set_time(time);
    let found = forces(&mut load, &x);
    assert!((at_start[1] - found[1]).norm() > 1e-3, "the field goes with time");
    let sum: Vector3<f64> = found.iter().sum();
    let turn: Vector3<f64> = found.iter().zip(&corners).map(|(f, p)| p.cross(f)).sum();
    assert!(exact.norm() > 1.0 && (sum + 0.5 * exact).norm() < 1e-13, "{sum:?} {exact:?}");
    assert!(moment.norm() > 0.3 && (turn + 0.5 * moment).norm() < 1e-13, "{turn:?} {moment:?}");
    // The energy is linear in place, with this gradient.
    let shifted: Vec<f64> = x.iter().enumerate().map(|(i, x)| x + 0.1 * (i as f64).sin()).collect();
    let work: f64 = found.iter().enumerate().map(|(i, f)| (0..3).map(|k| f[k] * (shifted[3 * i + k] - x[3 * i + k])).sum::<f64>()).sum();
    assert!(work.abs() > 1e-3 && (load.energy(&x) - load.energy(&shifted) - work).abs() < 1e-13);
    assert!(load.fault(0.0, 1.0).is_none());
    let broken = SpreadLoad::new(
        vec![SurfacePiece { place: corners[0], shares: vec![(0, 1.0)] }],
        Box::new(|_, t| Vector3::new(1.0 / (1.0 - t), 0.0, 0.0)),
        true,
    );
    assert!(broken.fault(0.5, 1.0).is_none());
    let (name, reason) = broken.fault(1.0, 1.0).unwrap();
    assert!(name == "force" && reason.contains("inf"), "{reason}");
}

/// A closed surface of eight curved faces.
fn ball() -> (Vec<Vector3<f64>>, Vec<[usize; 6]>) {
    let vertices: Vec<_> = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|v| [v, -v]).map(|v| v * 1.1).collect();
    let faces = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    curved(&Mesh { vertices, faces, ..Mesh::default() })
}

/// The derivatives of a liquid's pressure, and Archimedes: the force on a closed surface is the weight of what it displaces.
#[test]
fn pressure_that_varies_with_the_present_place() {
    let (nodes, faces) = ball();
    let x: Vec<f64> = flat(&nodes).iter().enumerate().map(|(i, x)| x + 0.03 * (1.7 * i as f64).sin() + 0.2).collect();
    let slope = Vector3::new(0.3, -0.2, -1.5);
    // On straight faces the quadrature is exact, and so are the derivatives.
    let corners = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let value = Box::new(move |p: &Vector3<f64>, t: f64| t + slope.dot(p));
    let mut straight = Pressure::<3, 9>::varying(corners, linear_radon().to_vec(), value, &nodes, 2.0);
    straight.set_factor(-0.6);
    straight.set_time(2.0);
    compare(&mut straight, &x[..18]);
    let make = |value: thinshell::load::ScalarField| {
        let mut pressure = Pressure::<6, 18>::varying(faces.clone(), quadratic_triangle().to_vec(), value, &nodes, 2.0);
        pressure.set_factor(-0.6);
        pressure.set_time(2.0);
        pressure
    };
    let mut liquid = make(Box::new(move |p, t| t + slope.dot(p)));
    let mut uniform = Pressure::<6, 18>::new(faces.clone(), quadratic_triangle().to_vec(), 1.0);
    let volume = -uniform.energy(&x);
    let force: Vector3<f64> = forces(&mut liquid, &x).iter().sum();
    assert!(volume > 1.0 && (force + 0.6 * volume * slope).norm() < 1e-3 * volume, "{force:?} {volume}");
    // The same pressure as a field is the same load.
    let mut constant = make(Box::new(|_, _| 1.0));
    uniform.set_factor(-0.6);
    let pairs = forces(&mut constant, &x).into_iter().zip(forces(&mut uniform, &x));
    assert!(pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) < 1e-14 && (constant.energy(&x) - uniform.energy(&x)).abs() < 1e-13);
}

#[test]
fn derivatives_of_drag() {
    let mesh = patch();
    let (nodes, faces) = curved(&mesh);
    let air = |p: &Vector3<f64>, t: f64| Vector3::new(3.0 + p.y, -2.0 * t, 4.0 - p.x);
    let mut wind = Wind::<6, 18>::new(faces, quadratic_triangle().to_vec(), &nodes, Box::new(air), 1.3, [1.1, 0.4]);
    let (start, dt) = (flat(&nodes), 0.5);
    assert_eq!(wind.energy(&start), 0.0, "no step has started");
    wind.start_step([&start, &start], 0.25, dt);
    let x: Vec<f64> = start.iter().enumerate().map(|(i, x)| x + 0.2 * (0.9 * i as f64).sin()).collect();
    compare(&mut wind, &x);
    // A plate that moves with the air feels nothing.
    let mut still = Wind::<3, 9>::new(
        mesh.faces.clone(),
        linear_radon().to_vec(),
        &mesh.vertices,
        Box::new(|_, _| Vector3::new(1.0, 2.0, 3.0)),
        1.3,
        [1.1, 0.4],
    );
    let start = flat(&mesh.vertices);
    still.start_step([&start, &start], 0.0, dt);
    let along: Vec<f64> = start.iter().enumerate().map(|(i, x)| x + dt * (1 + i % 3) as f64).collect();
    assert!(still.energy(&start) > 1.0 && still.energy(&along) < 1e-12);
}

/// A plate that falls flat reaches the velocity at which the drag carries its weight; along the sheet, that of friction.
#[test]
fn a_falling_plate_reaches_its_terminal_velocity() {
    for element in ["linear", "quadratic"] {
        for (gravity, normal, tangential) in [("[0, 0, -9.81]", 1.5, 0.0), ("[0, -9.81, 0]", 1.0, 0.25)] {
            let case = run(&format!(
                "[mesh.rectangle]\nsize = [0.2, 0.1]\ncells = [2, 1]\n[shell]\nelement = \"{element}\"\nthickness = 1e-3\nyoungs_modulus = 1e9\n\
                 poissons_ratio = 0.3\ndensity = 500.0\n[gravity]\nacceleration = {gravity}\n[[wind]]\ndensity = 1.2\nnormal = {normal}\n\
                 tangential = {tangential}\n[dynamics]\ndt = 0.2\nend = 8.0\n"
            ));
            let coefficient: f64 = if tangential > 0.0 { tangential } else { normal };
            let exact = (2.0 * 500.0 * 1e-3 * 9.81 / (1.2 * coefficient)).sqrt();
            for v in points(case.states().last().unwrap(), "velocity") {
                assert!((v.norm() / exact - 1.0).abs() < 1e-4, "{element}: {v:?} {exact}");
            }
        }
    }
}

/// Integrators and their orders.
const INTEGRATORS: [(&str, f64); 5] = [
    ("integrator = \"implicit-euler\"", 1.0),
    ("integrator = \"bdf2\"", 2.0),
    ("integrator = \"generalised-alpha\"\nspectral_radius = 1.0", 2.0),
    ("integrator = \"generalised-alpha\"\nspectral_radius = 0.8", 2.0),
    ("integrator = \"generalised-alpha\"\nspectral_radius = 0.0", 2.0),
];

/// A rigid sheet that still air stops: `v' = -k v^2`, `v = v_0 / (1 + k v_0 t)`.
#[test]
fn still_air_stops_a_sheet_with_the_order_of_the_method() {
    for (integrator, order) in INTEGRATORS {
        let errors = [20.0, 40.0, 80.0].map(|steps| {
            let case = run(&format!(
                "[mesh.rectangle]\nsize = [0.2, 0.1]\ncells = [2, 1]\n[solver]\ntolerance = 1e-13\n[shell]\nelement = \"linear\"\nthickness = 1e-3\n\
                 youngs_modulus = 1e9\npoissons_ratio = 0.3\ndensity = 500.0\n[[wind]]\ndensity = 1.0\nnormal = 1.0\n[output]\ninterval = 1.0\n\
                 [dynamics]\ndt = {:?}\nend = 1.0\nvelocity = [0, 0, 2]\n{integrator}\n",
                1.0 / steps
            ));
            // k = 1 / m, so that k v_0 = 2 / s.
            (case.end[0].z - 3f64.ln()).abs().max((points(case.states().last().unwrap(), "velocity")[0].z - 2.0 / 3.0).abs())
        });
        let rate = rate(&errors);
        assert!((rate - order).abs() < 0.12 && errors[2] > 1e-6, "{integrator}: {errors:?}, rate {rate}");
    }
}

/// A curved patch that turns and bends in the wind, so that its areas and normals change; so soft that steps resolve all its vibrations.
#[test]
fn wind_on_a_turning_surface_has_the_order_of_the_method() {
    for (integrator, order) in INTEGRATORS {
        let ends = [40.0, 80.0, 160.0].map(|steps| {
            run(&format!(
                "[mesh.cylinder]\nradius = 0.05\nlength = 0.06\nangle = 100.0\ncells = [3, 2]\n[solver]\ntolerance = 1e-13\n[shell]\nelement = \"linear\"\n\
                 thickness = 1e-3\ndensity = 900.0\nyoungs_modulus = 1e3\npoissons_ratio = 0.3\n[[wind]]\ndensity = 200.0\nnormal = 1.0\ntangential = 0.2\n\
                 velocity = [\"1 + 20*z\", 0, \"2*sin(100*t)\"]\n[output]\ninterval = 0.02\n\
                 [dynamics]\ndt = {:?}\nend = 0.02\nvelocity = [\"-20*y\", \"20*x\", \"20*y\"]\n{integrator}\n",
                0.02 / steps
            ))
            .end
        });
        let differences: Vec<f64> =
            ends.windows(2).map(|pair| pair[0].iter().zip(&pair[1]).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)).collect();
        let rate = rate(&differences);
        assert!((rate - order).abs() < 0.17 && differences[1] > 1e-7, "{integrator}: {differences:?}, rate {rate}");
    }
}

const PLATE: &str = "[mesh.rectangle]\nsize = [1.0, 0.5]\ncells = [4, 2]\n[solver]\ntolerance = 1e-13\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n\
    [output]\nreactions = true\n[statics]\nsteps = 2\n";

/// The reactions carry each spread load, and its moment about the support.
#[test]
fn reactions_carry_spread_loads() {
    let area = 0.5;
    for element in ["linear", "quadratic"] {
        let shell =
            format!("[shell]\nelement = \"{element}\"\nthickness = 0.01\nyoungs_modulus = 1e10\npoissons_ratio = 0.0\ndensity = 2.0\n");
        for (load, force, moment) in [
            // A moment about y of a vertical force f at a distance x is -x f.
            ("[[surface-load]]\nforce = [0, 0, \"3 * x\"]\n", area * 1.5, -area),
            ("[[body-force]]\nforce = [0, 0, 200]\n", area * 2.0, -area),
            ("[gravity]\nacceleration = [0, 0, \"12 * x\"]\n", area * 0.12, -area * 0.08),
            ("[[pressure]]\npressure = \"3 * x\"\n", area * 1.5, -area),
            ("[[surface-load]]\nforce = [0, 0, \"4 * t\"]\n", area * 4.0, -area * 2.0),
        ] {
            let case = run(&format!("{PLATE}{shell}{load}"));
            let state = case.states().pop().unwrap();
            let reactions = points(&state, "reaction");
            let sum: Vector3<f64> = reactions.iter().sum();
            assert!((sum.z / force + 1.0).abs() < 1e-6, "{element} {load}: {sum:?} {force}");
            let forces: f64 = reactions.iter().zip(&case.end).map(|(f, p)| p.cross(f).y).sum();
            // Edges at the left run along y, either way.
            let topology = Topology::new(&case.mesh.faces);
            let moments = &state.field("reaction_moment").unwrap().data;
            let count = moments.len() / topology.edges.len();
            let of = |(i, m): (usize, &f64)| {
                let [a, b] = topology.edges[i / count];
                m * (case.mesh.vertices[b].y - case.mesh.vertices[a].y).signum()
            };
            let couples: f64 = moments.iter().enumerate().filter(|(_, m)| **m != 0.0).map(of).sum();
            // Weights are those of masses in the vertices of linear faces, which are exact for the resultant alone.
            let tolerance = if element == "linear" && load.contains("gravity") { 0.05 } else { 1e-5 };
            let error = (forces + couples) / moment + 1.0;
            assert!(couples.abs() > 0.1 * moment.abs() && error.abs() < tolerance, "{element} {load}: {forces} {couples} {moment}");
        }
    }
}

#[test]
fn absent_spread_loads_leave_no_column() {
    let columns = |scene: &str| {
        let sandbox = Sandbox::new(scene);
        sandbox.ok(&["all", "scene.toml", "-q"]);
        sandbox.history()[0].split(',').map(str::to_owned).collect::<Vec<_>>()
    };
    let without = columns(STATIC);
    for (load, column) in [
        ("[[surface-load]]\nforce = [0, 0, 0.1]\n", "surface_load_energy_J"),
        ("[[body-force]]\nforce = [0, 1, \"x\"]\n", "body_force_energy_J"),
    ] {
        let mut with_it = columns(&format!("{STATIC}{load}{load}"));
        assert!(!without.iter().any(|c| c == column) && with_it.iter().filter(|c| *c == column).count() == 1, "{with_it:?}");
        with_it.retain(|c| c != column);
        assert_eq!(with_it, without);
    }
    // Drag has no energy.
    assert_eq!(columns(&format!("{DYNAMIC}[[wind]]\nvelocity = [1, 0, 0]\n")), columns(DYNAMIC));
}

#[test]
fn spread_loads_that_are_refused() {
    for (scene, words) in [
        (format!("{STATIC}[[surface-load]]\nforce = [0, 0, inf]\n"), "surface-load.0.force.2"),
        (format!("{STATIC}[[surface-load]]\nforce = [0, 0, \"1 / x\"]\nregion = \"nowhere\"\n"), "there is no region 'nowhere'"),
        (format!("{STATIC}[[surface-load]]\nforce = [0, 0, \"log(x)\"]\n"), "surface-load.0.force.2"),
        (format!("{STATIC}[[surface-load]]\nforce = [0, 0, \"sqrt(0.5 - t)\"]\n"), "surface-load.0.force"),
        (format!("{STATIC}[[body-force]]\nforce = [0, 0, 1]\nregion = \"left\"\n"), "region 'left' has no faces"),
        (format!("{STATIC}[[body-force]]\nforce = [0, 0, 1]\nfactor = \"x\"\n"), "body-force.0.factor"),
        (format!("{STATIC}[[wind]]\n"), "wind.0: needs [dynamics]"),
        (format!("{DYNAMIC}[[wind]]\nnormal = 0\n"), "has no effect"),
        (format!("{DYNAMIC}[[wind]]\nnormal = -1\n"), "wind.0.normal"),
        (format!("{DYNAMIC}[[wind]]\ndensity = 0\n"), "wind.0.density"),
        (format!("{DYNAMIC}[[wind]]\nvelocity = [0, 0, \"ln(-1 - t)\"]\n"), "wind.0.velocity"),
        (format!("{STATIC}[[pressure]]\npressure = \"sqrt(x - 0.01)\"\n"), "pressure.0.pressure"),
    ] {
        let sandbox = Sandbox::new(&scene);
        let message = sandbox.fails(2, &["all", "scene.toml"]);
        assert!(message.contains(words), "{words} is not in {message}");
        assert_eq!(sandbox.names("."), ["scene.toml"]);
    }
}

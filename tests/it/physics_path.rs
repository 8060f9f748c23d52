//! Paths of shells by arc length: a deep arch against the exact elastica, all that may follow the load factor, files and reports of a path.

use crate::physics_case::{Case, points, run, try_run};
use crate::pipeline_support::{Sandbox, with};

/// A clamped and hinged arch of 215 degrees, radius 100 and bending stiffness 1e6 per width under a line load of 1000 per width at its crown.
/// Held along the cylinder, it is the plane elastica but for its extension.
fn arch(cells: usize, statics: &str) -> String {
    format!(
        r#"
[mesh.cylinder]
radius = 100.0
length = 10.0
angle = 215.0
cells = [{cells}, 1]
[shell]
thickness = 1.0
youngs_modulus = 12e6
poissons_ratio = 0.0
[[region]]
name = "crown"
where = "abs(theta - 107.5 * PI / 180) < 1e-3"
[[pin]]
region = "start"
director = "clamped"
[[pin]]
region = "end"
[[pin]]
region = "bottom"
components = ["z"]
director = {{ symmetry = [0, 0, 1] }}
[[pin]]
region = "top"
components = ["z"]
director = {{ symmetry = [0, 0, 1] }}
[[edge-load]]
region = "crown"
force = [300.7057995, -953.7169507, 0]
{statics}
"#
    )
}

const ALONG: &str = "[statics]\nsteps = 10\n[statics.arc-length]\nmost_steps = 20\n";

#[test]
fn a_deep_arch_buckles_at_the_load_of_the_elastica() {
    // The limit load of the inextensible elastica, clamped at one end and hinged at the other, over EI / R^2 is 8.9731.
    let reports = "[[report.expect]]\nname = 'limit load'\nmeasure = 'load-factor'\nlimit-point = 1\nreference = 0.89731\ntolerance = 1.8e-3\nsource = 'elastica'\n\
        [[report.expect]]\nname = 'crown there'\nmeasure = { displacement = { at = [-30.07057995, 95.37169507, 0], axis = 'x' } }\nlimit-point = 1\nreference = -24.113\ntolerance = 0.2\nsource = 'elastica'\n\
        [[report.expect]]\nname = 'load at half'\nmeasure = 'load-factor'\npassage = { measure = 'load-factor', value = 0.5, number = 2 }\nreference = 0.5\ntolerance = 1e-6\nsource = 'itself'\n\
        [report.path]\nmeasures = [{ name = 'energy', measure = { energy = { part = 'bending' } } }]\n";
    let sandbox = Sandbox::new(&(arch(40, ALONG) + reports));
    let output = sandbox.output(&["all", "scene.toml"]);
    println!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0));
    let report: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(sandbox.case("report.json")).unwrap()).unwrap();
    let states = sandbox.names("cases/scene/run").len();
    assert_eq!(report["path"]["columns"], serde_json::json!(["step", "t", "energy"]));
    assert_eq!(report["path"]["rows"].as_array().unwrap().len(), states);
    let table = std::fs::read_to_string(sandbox.case("path.csv")).unwrap();
    assert!(table.starts_with("step,t,energy\n0.0,0.0,") && table.lines().count() == states + 1, "{table}");
    // The load factor comes back down, and every state is in the series in its order.
    let factors: Vec<f64> = report["path"]["rows"].as_array().unwrap().iter().map(|row| row[1].as_f64().unwrap()).collect();
    assert!(factors.windows(2).any(|t| t[1] < t[0]));
    let series = std::fs::read_to_string(sandbox.case("vtk/case.pvd")).unwrap();
    let times: Vec<f64> = series.split("timestep=\"").skip(1).map(|t| t.split('"').next().unwrap().parse().unwrap()).collect();
    assert_eq!(times, (0..states).map(|n| n as f64).collect::<Vec<_>>());
    // A longer path goes on from where the shorter one ended.
    let (_, err) = sandbox.ok(&["run", "scene.toml", "--set", "statics.arc-length.most_steps=22"]);
    assert!(err.contains("going on") && sandbox.names("cases/scene/run").len() == states + 2, "{err}");
}

#[test]
fn a_resumed_path_is_the_same() {
    let scene = arch(16, "[statics]\nsteps = 5\n[statics.arc-length]\nmost_steps = 12\n");
    let whole = Sandbox::new(&scene).prepared();
    whole.ok(&["run", "scene.toml"]);
    let parts = Sandbox::new(&scene).prepared();
    for piece in ["1", "1", "5"] {
        parts.ok(&["run", "scene.toml", "--stop-after", piece]);
    }
    let (out, _) = parts.ok(&["status", "scene.toml"]);
    assert!(out.contains("unfinished"), "{out}");
    parts.ok(&["run", "scene.toml"]);
    assert_eq!(whole.history(), parts.history());
    assert!(whole.result() == parts.result());
    assert_eq!(whole.newest().0, "step_00000012.h5");
    let (out, _) = parts.ok(&["status", "scene.toml"]);
    assert!(out.contains("done: 12 steps"), "{out}");
    // Adaptive load steps too.
    let scene = arch(16, "[statics]\nsteps = 20\n[statics.adaptive]\n[output]\ninterval = 0.25\n")
        .replace("force = [300", "force = [150")
        .replace("-953", "-450");
    let whole = Sandbox::new(&scene).prepared();
    whole.ok(&["run", "scene.toml"]);
    let parts = Sandbox::new(&scene).prepared();
    for piece in ["1", "2"] {
        parts.ok(&["run", "scene.toml", "--stop-after", piece]);
    }
    parts.ok(&["run", "scene.toml"]);
    assert!(whole.result() == parts.result());
    assert!(whole.history().len() < 16, "{:?}", whole.history());
}

#[test]
fn a_path_ends_on_the_load_factor_one_or_at_a_displacement() {
    let along = run(&arch(16, "[statics]\nsteps = 5\n[statics.arc-length]\n").replace("[300.7", "[200.7").replace("-953.7", "-636.7"));
    let ahead = run(&arch(16, "[statics]\nsteps = 10\n").replace("[300.7", "[200.7").replace("-953.7", "-636.7"));
    assert_eq!(along.last("time_s"), 1.0);
    let worst = along.end.iter().zip(&ahead.end).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    let way: f64 = along.last("arc_length_m");
    println!(
        "{} steps, {} factorisations, difference {worst:e} m, way {way} m",
        along.column("time_s").len(),
        along.last("factorizations")
    );
    assert!(worst < 1e-6 && way > 5.0);
    let until = "until = { at = [-30.07, 95.37, 0], axis = \"y\", displacement = -40 }";
    let case = run(&arch(16, &format!("{ALONG}{until}\n")));
    let (before, after) = (crown(&case, case.states().len() - 2), crown(&case, case.states().len() - 1));
    assert!(before > -40.0 && after <= -40.0, "{before} {after}");
}

/// Displacement of the crown along y in a state.
fn crown(case: &Case, state: usize) -> f64 {
    let v = case.mesh.region_nearest(nalgebra::Vector3::new(-30.07057995, 95.3716950, 0.0)).vertices[0];
    points(&case.states()[state], "position")[v].y - case.mesh.vertices[v].y
}

/// A quarter of a hinged roof of thickness 12.7 under a force at its centre, or with the centre moved.
fn roof(centre: &str, statics: &str) -> Case {
    run(&format!(
        "[mesh.cylinder]\nradius = 2540.0\nlength = 254.0\nangle = 5.729577951308232\ncells = [6, 6]\npattern = \"alternating\"\n\
         [shell]\nthickness = 12.7\nyoungs_modulus = 3102.75\npoissons_ratio = 0.3\n[[region]]\nname = \"centre\"\nnearest = [2540, 0, 0]\n\
         [[pin]]\nregion = \"start\"\ncomponents = [\"y\"]\ndirector = {{ symmetry = [0, 1, 0] }}\n\
         [[pin]]\nregion = \"bottom\"\ncomponents = [\"z\"]\ndirector = {{ symmetry = [0, 0, 1] }}\n[[pin]]\nregion = \"end\"\n{centre}\n{statics}"
    ))
}

/// Past the limit point, where no load holds the roof, a moved support does: the same states, and the load is the slope of their energy.
#[test]
fn a_path_by_arc_length_is_the_path_by_displacement() {
    let energies = |case: &Case| -> Vec<f64> {
        let [a, b] = ["membrane_energy_J", "bending_energy_J"].map(|name| case.column(name));
        a.iter().zip(b).map(|(a, b)| a + b).collect()
    };
    let force = "[[force]]\nregion = \"centre\"\nforce = [-750, 0, 0]";
    let along = roof(force, "[statics]\nsteps = 20\n[statics.arc-length]\nmost_steps = 60\n");
    let centre = along.mesh.region_nearest(nalgebra::Vector3::new(2540.0, 0.0, 0.0)).vertices[0];
    let sunk: Vec<f64> = along.states()[1..].iter().map(|state| 2540.0 - points(state, "position")[centre].x).collect();
    let (ways, factors) = (along.column("arc_length_m"), along.column("time_s"));
    let limit = thinshell::report::path::limit_point(&ways, &factors, 1).unwrap();
    let (peak, at) = (limit.of(&factors), limit.of(&sunk));
    println!("limit load {peak} at {at}, {} factorisations", along.last("factorizations"));
    // Sze, Liu and Lo (2004): 0.7421 at 11.293; this mesh is coarse.
    assert!((peak / 0.7421 - 1.0).abs() < 0.01 && (at / 11.293 - 1.0).abs() < 0.05);
    assert_eq!(along.last("time_s"), 1.0);
    for depth in [8.0, 17.0] {
        let moved = [0.99, 1.01].map(|share| {
            let pin = format!("[[pin]]\nregion = \"centre\"\ncomponents = [\"x\"]\nmotion = {{ x = \"-{:?} * t\" }}", share * depth);
            *energies(&roof(&pin, "[statics]\nsteps = 4\n")).last().unwrap()
        });
        let place = thinshell::report::path::passage(&ways, &sunk, depth, 1).unwrap();
        let (load, energy) = (place.of(&factors), place.of(&energies(&along)));
        let (slope, mean) = ((moved[1] - moved[0]) / (0.02 * depth * 750.0), 0.5 * (moved[0] + moved[1]));
        println!("at {depth}: load {load} and {slope}, energy {energy} and {mean}");
        assert!((load / slope - 1.0).abs() < 3e-3 && (energy / mean - 1.0).abs() < 1e-3);
    }
}

/// A short first step changes the load factor by what it was asked to, to first order, if the derivative by the factor is right: of loads that are
/// and are not linear in it, follower pressure, moved and turned supports, and growth.
#[test]
fn everything_that_follows_the_load_factor_has_its_derivative() {
    let plate = "[mesh.rectangle]\nsize = [1.0, 0.3]\ncells = [4, 2]\n[shell]\nthickness = 0.02\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\ndensity = 1000.0\n";
    let clamp = "[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n";
    let parts = [
        ("gravity", format!("{clamp}[gravity]\n")),
        ("force", format!("{clamp}[[edge-load]]\nregion = \"right\"\nforce = [0, 0, 300]\nfactor = \"sin(t) + t^2\"\n")),
        ("pressure", format!("{clamp}[[pressure]]\npressure = 100.0\n")),
        ("motion", format!("{clamp}[[pin]]\nregion = \"right\"\nmotion = {{ z = \"0.1 * t\" }}\n")),
        ("turn", "[[pin]]\nregion = \"left\"\ndirector = { rotation = { axis = [0, 1, 0], angle = \"30 * t\" } }\n".to_owned()),
        ("growth", format!("{clamp}[rest.pullback]\nbbar = [\"t + t^2\", 0, 0]\n")),
        ("ramp", format!("{clamp}[rest.isotropic]\ns = \"0.01 * z + 0.01\"\n[[pin]]\nregion = \"right\"\n[gravity]\nfactor = \"t\"\n")),
    ];
    for (name, part) in parts {
        let errors = [1e-2, 5e-3].map(|dt| {
            let steps = (1.0 / dt) as usize;
            let case = run(&format!("{plate}{part}[statics]\nsteps = {steps}\n[statics.arc-length]\nmost_steps = 1\n"));
            (case.column("time_s")[0] / dt - 1.0).abs()
        });
        println!("{name}: {errors:?}");
        assert!(errors[0] < 0.15 && (errors[1] < 0.6 * errors[0] || errors[1] < 1e-6), "{name} {errors:?}");
    }
    let e = try_run(&format!("{plate}{clamp}[statics]\nsteps = 3\n[statics.arc-length]\n")).err().unwrap().to_string();
    assert!(e.contains("moves nothing"), "{e}");
}

#[test]
fn wrong_input_is_refused() {
    let sandbox = Sandbox::new(&arch(16, ALONG));
    for (set, words) in [
        ("statics.arc-length.iterations=1", "2 to 100"),
        ("statics.arc-length.longest=0.5", ">= 1"),
        ("statics.arc-length.most_steps=0", "1 to 100000"),
        ("statics.arc-length.until={at=[0,0,0],axis='z',displacement=0}", "not 0"),
        ("statics.arc-length.until={at=[9000,0,0],axis='z',displacement=1}", "statics.arc-length.until"),
        ("statics.end=2", "load factor"),
        ("statics.stable=true", "unstable"),
        ("statics.adaptive={}", "its own steps"),
        ("output.interval=0.1", "only grows"),
        ("report.expect=[{name='n',measure='load-factor',reference=0,tolerance=1,source='s',time=0.5}]", "more than once"),
        ("report.expect=[{name='n',measure='load-factor',reference=0,tolerance=1,source='s',limit-point=0}]", "1 or more"),
        (
            "report.expect=[{name='n',measure='load-factor',reference=0,tolerance=1,source='s',limit-point=1,passage={measure='load-factor',value=1}}]",
            "at most one",
        ),
        (
            "report.expect=[{name='n',measure='load-factor',reference=0,tolerance=1,source='s',passage={measure={history={column='no'}},value=1}}]",
            "no column",
        ),
        ("report.path={measures=[]}", "must not be empty"),
        ("report.path={measures=[{name='t',measure='load-factor'}]}", "a column of this name"),
    ] {
        let message = sandbox.fails(2, &["all", "scene.toml", "--set", set]);
        assert!(message.contains(words), "{set}: {message}");
    }
    let sandbox = Sandbox::new(&with(&arch(16, ALONG), "[statics.arc-length]\nmost_steps = 20", "[statics.adaptive]"));
    for (set, words) in [
        ("statics.adaptive.iterations=101", "2 to 100"),
        ("statics.adaptive.shortest=0.5", "longer than the first step"),
        ("statics.adaptive.longest=0.01", "shorter than the first step"),
        ("report.expect=[{name='n',measure='load-factor',reference=0,tolerance=1,source='s',limit-point=1}]", "needs [statics.arc-length]"),
    ] {
        let message = sandbox.fails(2, &["check", "scene.toml", "--set", set]);
        assert!(message.contains(words), "{set}: {message}");
    }
}

//! No numbers, however extreme, make the program panic, hang, or leave with a code it does not document.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, text};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

/// Numbers at the edges of what a double holds, and of what is meant.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "1e-3",
    "0.3",
    "1e-300",
    "-1e-300",
    "1e300",
    "-1e300",
    "1e-160",
    "1e160",
    "5e-324",
    "1.7e308",
    "1e-16",
    "1e16",
    "1e-100",
    "1e100",
    "1e-14",
    "1e-2",
    "0.499999999",
    "-0.999999999",
    "360",
    "nan",
    "inf",
    "-inf",
    "'nan'",
    "'x / 0'",
    "'0 / 0'",
    "'1e300 * t'",
    "'exp(1000 * t)'",
    "'1 / t'",
    "'ln(-t)'",
    "'1e200 * x * 1e200'",
    "'if(t > 0.001, 0 / 0, 0)'",
    "'sin(1e300 * x)'",
    "'x'",
    "'-t'",
    "true",
    "'text'",
    "[1]",
    "9223372036854775807",
];

/// Keys that hold numbers or expressions, with scenes that have them.
const KEYS: &[&str] = &[
    "mesh.rectangle.size.0",
    "mesh.rectangle.size.1",
    "mesh.rectangle.cells.0",
    "mesh.rectangle.cells.1",
    "mesh.rectangle.jitter",
    "mesh.rectangle.seed",
    "shell.thickness",
    "shell.youngs_modulus",
    "shell.poissons_ratio",
    "shell.density",
    "shell.compression",
    "shell.bilayer.top_thickness",
    "shell.viscosity",
    "rest.ramp",
    "rest.linear.m_plus",
    "rest.linear.m_minus",
    "rest.linear.mu",
    "rest.pullback.bbar.0",
    "rest.pullback.bbar.1",
    "rest.pullback.bbar.2",
    "gravity.acceleration.2",
    "gravity.factor",
    "pin.0.motion.z",
    "dynamics.dt",
    "dynamics.end",
    "dynamics.velocity.0",
    "dynamics.velocity.2",
    "statics.steps",
    "solver.tolerance",
    "solver.max_iterations",
    "solver.max_halvings",
    "output.interval",
];

/// Whole tables of other kinds.
const TABLES: &[&str] = &[
    "shell.director='average'",
    "shell.director='free-sin'",
    "shell.mass='lumped'",
    "shell.material='neo-hookean'",
    "shell.material='tension-field'",
    "shell.lame='three-d'",
    "shell.bilayer={top_thickness=1e-4, top={youngs_modulus=1e200}}",
    "shell.region=[{region='boundary', material='neo-hookean'}]",
    "shell.orthotropic={youngs_moduli=[1e200, 1], poissons_ratio=1, shear_modulus=1e-200}",
    "pin=[]",
    "pin=[{region='boundary', director='clamped'}]",
    "pin.0.director={symmetry=[1, 0, 0]}",
    "rest.sampling='centroid'",
    "rest.linear={m_plus=1, m_minus=0, mu=0.01, mu_perp=0.1}",
    "machine-direction={vector=[1e-300, 1, 0]}",
    "machine-direction={angle='1e300'}",
    "machine-direction={gradient='atan2(y, 0*x)'}",
    "machine-direction={radial={}}",
    "machine-direction={transport={from=[0,0,0], vector=[0,0,1]}}",
    "rest.bilayer={m_plus=1, m_minus=0, mu=[0.01, 1e200]}",
    "rest.isotropic={s='1e9*x'}",
    "rest.orthotropic={factors=[0, 'ln(x)'], angle='1/x'}",
    "rest.surface={position=['sqrt(x)', 'x', 0]}",
    "rest.surface={sphere={radius=1e-300}}",
    "rest.surface={catenoid={waist=1e-4, turn=45}}",
    "rest.prestress={times=0}",
    "rest.prestress={plus_a=[-1, 0, -1]}",
    "rest.shape={field='none'}",
    "rest.pullback={abar=['1', 0, '1e-300']}",
    "rest.pullback={abar=['1e300', 0, 1e300]}",
    "rest.pullback={components='polar', bbar=[1, 0, 1]}",
    "mesh={rectangle={size=[1e-90, 1e90], cells=[2, 2]}}",
    "mesh={rectangle={size=[0.06, 0.02], cells=[6, 2], pattern='delaunay'}}",
    "mesh={disc={radius=1e-30, rings=2}}",
    "mesh={disc={radius=1, rings=1}}",
    "mesh={sphere-cap={radius=1e20, half_angle=1e-6, rings=2}}",
    "mesh={sphere-cap={radius=1, half_angle=179.99999, rings=3}}",
    "mesh={cylinder={radius=1e-3, length=1e20, cells=[3, 1]}}",
    "mesh={annulus={radii=[1, 1.0000000000000002], cells=[1, 3]}}",
    "mesh={annulus={radii=[1, 2], cells=[1, 3], slit=true}}",
    "mesh={outline={points=[[0, 0], [1, 0], [0.5, 1e-300]], triangulation={size=0.1}}}",
    "mesh={outline={points=[[0, 0], [1e100, 0], [0, 1]], triangulation={size=1e99}}}",
    "mesh={rectangle={size=[1, 1], cells=[1, 1]}}",
    "mesh={rectangle={size=[1e-3, 1e3], cells=[1, 3], pattern='criss-cross'}}",
    "output={}",
    "region=[{name='r', nearest=[1e300, -1e300, 0]}]",
    "region=[{name='r', where='1 / (x - 0.03)'}]",
];

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

/// Runs with a time limit.
fn limited(sandbox: &Sandbox, arguments: &[&str]) -> Output {
    let mut child = sandbox.command(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let stderr = child.stderr.take().unwrap();
    let reader = std::thread::spawn(move || std::io::read_to_string(stderr).unwrap());
    let deadline = Instant::now() + Duration::from_secs(30);
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return Output { status, stdout: Vec::new(), stderr: reader.join().unwrap().into_bytes() };
        }
        if Instant::now() > deadline {
            child.kill().unwrap();
            panic!("{arguments:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Runs the verbs one after the other while they succeed; returns how many did.
fn try_scene(scene: &str, overrides: &[String]) -> usize {
    let sandbox = Sandbox::new(scene);
    let set: Vec<&str> = overrides.iter().flat_map(|o| ["--set", o.as_str()]).collect();
    let verbs: [&[&str]; 6] = [
        &["check", "scene.toml"],
        &["mesh", "scene.toml"],
        &["setup", "scene.toml"],
        &["run", "scene.toml", "--stop-after", "2"],
        &["export", "scene.toml"],
        &["status", "scene.toml"],
    ];
    for (done, verb) in verbs.iter().enumerate() {
        let arguments = [verb, &set[..]].concat();
        let output = limited(&sandbox, &arguments);
        let err = text(&output.stderr);
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 2)) || code == Some(3) && verb[0] == "run", "{arguments:?}: {code:?} {err}");
        assert!(!err.contains("panicked"), "{arguments:?}: {err}");
        assert_eq!(err.matches("error: ").count(), usize::from(code != Some(0)), "{arguments:?}: {err}");
        if code == Some(2) {
            // What `check` accepts, meshes and sets up.
            assert!(verb[0] == "check" || verb[0] == "run", "{arguments:?}: {err}");
            assert!(verb[0] != "check" || sandbox.names(".") == ["scene.toml"], "{arguments:?} wrote something");
        }
        if code != Some(0) {
            return done;
        }
    }
    verbs.len()
}

fn try_many(seed: u64, count: usize) -> usize {
    let mut random = Random(seed);
    let mut whole = 0;
    for _ in 0..count {
        let scene = if random.below(2) == 0 { DYNAMIC } else { STATIC };
        let mut overrides: Vec<String> = Vec::new();
        for _ in 0..=random.below(3) {
            if random.below(4) == 0 {
                overrides.push(random.pick(TABLES).into());
            } else {
                overrides.push(format!("{}={}", random.pick(KEYS), random.pick(NUMBERS)));
            }
        }
        whole += usize::from(try_scene(scene, &overrides) == 6);
    }
    whole
}

#[test]
fn extreme_numbers() {
    let whole = try_many(3, 100);
    assert!(whole > 10, "only {whole} scenes ran; the rest was refused");
}

#[test]
fn each_number_that_may_be_anything() {
    // Keys whose every finite value is a fair question.
    let mut whole = 0;
    for key in
        ["shell.youngs_modulus", "shell.thickness", "gravity.acceleration.2", "rest.pullback.bbar.0", "pin.0.motion.z", "shell.density"]
    {
        for number in ["1e-300", "1e-30", "1e30", "1e300"] {
            whole += usize::from(try_scene(STATIC, &[format!("{key}={number}"), "solver.max_halvings=1".into()]) == 6);
        }
    }
    assert!(whole > 2, "{whole}");
}

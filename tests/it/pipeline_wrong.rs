//! Scenes whose faults only their mesh, their steps or the disk can tell: one clear error, and nothing written.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, with};
use std::fs;

const REGIONS: &str = "
[[region]]
name = 'corner'
nearest = [0.06, 0.02, 0]
[[region]]
name = 'half'
where = 'x > 0.025'
";

/// Each stage that can meet the fault refuses it with these words and leaves no file.
fn assert_refused(scene: &str, overrides: &[&str], words: &[&str]) {
    let sandbox = Sandbox::new(scene);
    let set: Vec<&str> = overrides.iter().flat_map(|o| ["--set", o]).collect();
    for verb in ["check", "all", "run"] {
        let message = sandbox.fails(2, &[&[verb, "scene.toml"][..], &set].concat());
        assert!(verb == "run" || words.iter().all(|w| message.contains(w)), "{overrides:?}: {words:?} are not in {message}");
    }
    assert_eq!(sandbox.names("."), ["scene.toml"], "{overrides:?}: something was written");
    // With a mesh there, `setup` meets it and leaves the folder as it was.
    if sandbox.output(&[&["mesh", "scene.toml", "-q"][..], &set].concat()).status.success() {
        let before = sandbox.names("cases/scene");
        sandbox.fails(2, &[&["setup", "scene.toml"][..], &set].concat());
        assert_eq!(sandbox.names("cases/scene"), before, "{overrides:?}");
    } else {
        assert_eq!(sandbox.names("."), ["scene.toml"], "{overrides:?}: something was written");
    }
}

#[test]
fn regions_that_are_not_there_or_not_enough() {
    let scene = format!("{DYNAMIC}{REGIONS}");
    for (change, words) in [
        ("pin.0.region='lefd'", &["pin.0", "there is no region 'lefd'", "left", "half"][..]),
        ("shell.region=[{region='lefd', density=2}]", &["shell.region.0", "there is no region 'lefd'", "left"]),
        ("shell.region=[{region='corner', density=2}]", &["shell.region.0", "region 'corner' has no faces"]),
        ("region.1.where='x > 1'", &["region.1.where", "'half' is empty"]),
        ("region.1.name='left'", &["region.1.name", "has a region 'left' already"]),
        ("pin.0.region='corner'", &["pin.0.director", "has no edges"]),
        ("region.1.where='0 / (x - 0.06)'", &["region.1.where", "is not a number at (0.06, "]),
    ] {
        assert_refused(&scene, &[change], words);
    }
}

#[test]
fn supports_that_contradict() {
    let scene = format!("{DYNAMIC}{REGIONS}");
    assert_refused(&scene, &["pin.0.director={symmetry=[0, 1, 0]}"], &["pin.0.director", "does not lie in the plane of symmetry"]);
    assert_refused(&scene, &["pin.0.director={symmetry=[0, 0, 1]}"], &["pin.0.director", "tangent to the plane of symmetry"]);
    let two = format!("{scene}[[pin]]\nregion = 'bottom'\nmotion = {{ z = '0.01 * t' }}\n");
    assert_refused(&two, &[], &["pin.1", "coordinate z of node 0 is held by another pin too"]);
    let agree = with(&two, "motion = { z = '0.01 * t' }", "");
    assert_refused(&agree, &[], &["pin.1", "held by another pin too, and one of them moves it"]);
}

#[test]
fn missing_density() {
    assert_refused(&with(DYNAMIC, "density = 1000.0\n", ""), &[], &["shell.density", "[dynamics] needs it"]);
    assert_refused(&with(STATIC, "density = 1000.0\n", ""), &[], &["shell.density", "[gravity] needs it"]);
}

#[test]
fn what_is_not_a_number_somewhere() {
    for (change, words) in [
        ("rest.linear.m_plus='1 / (x - x)'", &["rest", "face 0"][..]),
        ("rest.linear.m_plus='sqrt(0.03 - x)'", &["rest", "face "]),
        ("rest.linear.m_minus='-1000'", &["rest.linear", "m_minus = -1000 %", "bone dry"]),
        ("rest.linear={m_plus=0, m_minus=-50, mu=0.02}", &["rest.linear", "m_minus = -50 %", "must be > 0"]),
        ("rest.ramp='1 / t'", &["rest", "ramp is inf at t = 0"]),
        ("rest.linear.mu=1e200", &["rest", "face "]),
        ("pin.0.motion.z='ln(-t)'", &["pin.0.motion.z", "coordinate z of node", "t = 0"]),
        ("dynamics.velocity=[0, 'sqrt(0.03 - x)', 0]", &["dynamics.velocity", "is not finite at vertex "]),
        ("gravity.factor='1 / t'", &["gravity.factor", "is inf at t = 0"]),
    ] {
        assert_refused(DYNAMIC, &[change], words);
    }
    let law = with(DYNAMIC, "mu = 0.01", "mu = 0.01\nmu_perp = 0.02\n[machine-direction]\nangle = 'sqrt(0.03 - x)'");
    assert_refused(&law, &[], &["machine-direction", "face "]);
    let vertical = with(DYNAMIC, "mu = 0.01", "mu = 0.01\nmu_perp = 0.02\n[machine-direction]\nvector = [0, 0, 1]");
    assert_refused(&vertical, &[], &["machine-direction", "has no part in the face"]);
    for (change, words) in [
        ("rest.pullback.bbar=['1 / (x - x)', 0, 0]", &["rest", "face 0"][..]),
        ("rest.pullback.abar=['0.03 - x', 0, 1]", &["rest", "face "]),
        ("rest.pullback.abar=[1, 2, 1]", &["rest", "face ", "not positive definite"]),
        ("pin.0.motion.z='sqrt(0.5 - t)'", &["pin.0.motion.z", "t = 1"]),
        ("gravity.factor='sqrt(0.5 - t)'", &["gravity.factor", "t = 1"]),
    ] {
        assert_refused(STATIC, &[change], words);
    }
}

/// What becomes impossible on the way is an error of the input too; the states before it stay.
#[test]
fn what_is_not_a_number_at_some_time() {
    for (change, words) in [
        ("rest.linear.m_plus='sqrt(0.021 - t)'", &["rest.linear: face "][..]),
        ("rest.ramp='sqrt(0.021 - t)'", &["rest: the ramp is NaN"]),
        ("pin.0.motion.z='sqrt(0.021 - t) - sqrt(0.021)'", &["pin.0.motion.z = ", "the motion of coordinate z of node "]),
        ("gravity.factor='sqrt(0.021 - t)'", &["gravity.factor = ", "is NaN"]),
    ] {
        let sandbox = Sandbox::new(DYNAMIC);
        sandbox.ok(&["check", "scene.toml", "--set", change]);
        for verb in ["all", "run"] {
            let message = sandbox.fails(2, &[verb, "scene.toml", "--set", change]);
            assert!(words.iter().all(|w| message.contains(w)) && message.contains("t = 0.022"), "{change}: {message}");
            assert!(message.contains("the last good state is in cases/scene/run/step_00000010.h5"), "{message}");
            assert_eq!(sandbox.newest().0, "step_00000010.h5");
            assert!(!message.contains("trying"), "smaller steps were tried: {message}");
        }
    }
}

#[test]
fn a_mechanism_and_steps_that_fail_exit_with_3() {
    let free =
        with(&with(STATIC, "[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\nmotion = { z = \"0.01 * t\" }", ""), "[gravity]", "");
    let sandbox = Sandbox::new(&free).prepared();
    let message = sandbox.fails(3, &["run", "scene.toml"]);
    assert!(message.contains("mechanism") && message.contains("hold it by pins"), "{message}");
    assert_eq!(sandbox.newest().0, "step_00000000.h5");

    // Two steps work, then nothing can follow the pin that tears it.
    let sandbox = Sandbox::new(&with(STATIC, "0.01 * t", "if(t > 0.3, 1e6 * y, 0)")).prepared();
    let set = ["--set", "solver.max_halvings=2", "--set", "solver.max_iterations=5"];
    let message = sandbox.fails(3, &[&["run", "scene.toml"][..], &set].concat());
    assert!(message.contains("failed at its smallest size") && message.contains("step_0000000"), "{message}");
    assert_eq!(message.matches("warning: the step from ").count(), 2, "{message}");
    let newest = sandbox.newest();
    assert!(newest.0.as_str() >= "step_00000002.h5" && message.contains(&newest.0), "{message}");
    sandbox.fails(3, &[&["run", "scene.toml"][..], &set].concat());
    assert!(sandbox.newest() == newest);
}

#[test]
fn meshes_that_are_too_large_are_refused_at_once() {
    for change in [
        "mesh.rectangle.cells=[10000, 10000]",
        "mesh={disc={radius=1, rings=5000}}",
        "mesh={sphere-cap={radius=1, half_angle=90, rings=5000}}",
        "mesh={annulus={radii=[1, 2], cells=[10000, 10000]}}",
        "mesh={cylinder={radius=1, length=1, cells=[10000, 10000]}}",
        "mesh={outline={points=[[0, 0], [1, 0], [0, 1]], triangulation={size=1e-9}}}",
        "mesh={rectangle={size=[1, 1], cells=[2, 2], pattern='delaunay', triangulation={size=1e-9}}}",
        "mesh={rectangle={size=[1, 1], cells=[10000, 10000], pattern='delaunay'}}",
    ] {
        let started = std::time::Instant::now();
        assert_refused(DYNAMIC, &[change], &["mesh", "more than the"]);
        assert!(started.elapsed().as_secs_f64() < 5.0, "{change} took {:?}", started.elapsed());
    }
}

#[test]
fn runs_without_end_are_refused() {
    for change in ["dynamics.dt=1e-300", "dynamics.end=1e300", "output.interval=1e-20"] {
        assert_refused(DYNAMIC, &[change], &["steps to the end", "must be at most 1e8"]);
    }
}

#[test]
fn a_file_in_place_of_a_folder() {
    for name in ["cases", "cases/scene", "cases/scene/run", "cases/scene/vtk", "cases/scene/case.toml/x"] {
        let sandbox = Sandbox::new(STATIC);
        let path = sandbox.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "in the way").unwrap();
        let message = sandbox.fails(2, &["all", "scene.toml", "-q"]);
        assert!(message.contains("error: cannot ") && message.contains("cases"), "{name}: {message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "in the way");
    }
    let sandbox = Sandbox::new(STATIC);
    fs::create_dir_all(sandbox.case("mesh.h5/x")).unwrap();
    assert!(sandbox.fails(2, &["all", "scene.toml", "-q"]).contains("error: cannot "));
}

#[test]
#[cfg(target_os = "linux")]
fn folders_that_cannot_be_written() {
    let sandbox = Sandbox::new(STATIC);
    for case in ["/proc/thinshell", "/dev/null/x", "/dev/null"] {
        for verb in ["mesh", "all"] {
            let message = sandbox.fails(2, &[verb, "scene.toml", "-q", "--case", case]);
            assert!(message.contains("error: cannot ") && message.contains(case), "{message}");
        }
    }
    assert!(sandbox.fails(2, &["schema", "--log", "/dev/full/x"]).contains("cannot open"));
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = sandbox.command(&["schema"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

/// Steps that fail each time they have grown again are an error before all of the way has been gone so; a run that is resumed counts those before.
#[test]
fn a_run_that_goes_on_halving_ends_in_an_error() {
    let scene = "[mesh.rectangle]\nsize = [0.1, 0.02]\ncells = [4, 1]\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n\
         [rest.pullback]\nbbar = [\"PI / 0.1\", 0, 0]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[statics]\nsteps = 2\n\
         [solver]\nmax_iterations = 1\n";
    let whole = Sandbox::new(scene).prepared();
    let message = whole.fails(3, &["run", "scene.toml"]);
    assert!(message.contains("failed, and with it 49 steps so far, where a run that has come so far may have 48: "), "{message}");
    assert!(message.contains("did not contract") && message.contains(&whole.newest().0), "{message}");
    let parts = Sandbox::new(scene).prepared();
    for piece in ["1", "7"] {
        parts.ok(&["run", "scene.toml", "--stop-after", piece]);
    }
    assert!(parts.fails(3, &["run", "scene.toml"]).contains("and with it 49 steps so far"));
    assert_eq!(whole.history(), parts.history());
    // A little more work for each step, and all of the way is gone.
    whole.ok(&["run", "scene.toml", "--restart", "--set", "solver.max_iterations=2"]);
}

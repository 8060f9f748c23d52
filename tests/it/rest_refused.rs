//! Growth that no shell can have: told with the face and the value when it shows, and what a case holds already stays as it is.

use crate::pipeline_support::Sandbox;
use std::collections::BTreeMap;
use std::path::Path;

/// A strip clamped at one end with this material and rest shape, in eight load steps.
fn strip(element: &str, material: &str, rest: &str) -> String {
    format!(
        "[mesh.rectangle]\nsize = [0.06, 0.02]\ncells = [6, 2]\n[[region]]\nname = \"far\"\nwhere = \"x > 0.03\"\n\
         [[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[shell]\nelement = \"{element}\"\nthickness = 1e-3\nyoungs_modulus = 1e8\n\
         poissons_ratio = 0.3\n{material}\n{rest}\n[statics]\nsteps = 8\n"
    )
}

/// All files below a folder with their contents.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path.display().to_string(), std::fs::read(&path).unwrap());
        }
    }
    found
}

/// Laws that are possible at the start and at the end, and not in between; what is said of them at load factor 0.375.
const ON_THE_WAY: &[(&str, &str, &[&str])] = &[
    ("", "[rest.pullback]\nabar = [\"if(BAD, -0.1, 1)\", 0, 1]", &["face 12 at (", "the rest metric "]),
    (
        "",
        "[rest]\nsampling = \"centroid\"\n[rest.pullback]\nabar = [1, \"if(BAD, 1.5, 0)\", 1]",
        &["face 12 at (", "the rest metric [", "not positive definite"],
    ),
    (
        "",
        "[rest]\nramp = \"if(t > 0.3 && t < 0.9, 3, t)\"\n[rest.pullback]\nabar = [\"if(x > 0.03, 0.6, 1)\", 0, 1]",
        &["face 12 at (", "the rest metric [", "where the ramp is 3"],
    ),
    ("", "[rest.isotropic]\ns = \"if(BAD, 1e4, 0.01 * t)\"", &["face 12 at (", "s = 10000 makes the factor e^(2s) = inf"]),
    (
        "",
        "[rest.orthotropic]\nfactors = [\"if(BAD, -0.25, 1 + 0.01 * t)\", 1]\nangle = 20",
        &["face 12 at (", "the growth factor -0.25 must be positive"],
    ),
    ("", "[rest.linear]\nm_plus = \"if(BAD, -60, t)\"\nm_minus = 0\nmu = 0.02", &["face 12 at (", "m_plus = -60 % makes 1 + m mu = -0."]),
    (
        "bilayer = { top_thickness = 3e-4 }",
        "[rest.bilayer]\nm_plus = 0\nm_minus = \"if(BAD, -60, t)\"\nmu = [0.01, 0.02]",
        &["face 12 at (", "m_minus = -60 % makes 1 + m mu = -0."],
    ),
    ("", "[rest.prestress]\ntimes = \"if(BAD, -1, 1)\"", &["face 12 at (", "the rest metric "]),
    (
        "[[shell.region]]\nregion = \"far\"\nmaterial = \"neo-hookean\"",
        "[rest.pullback]\nbbar = [\"if(BAD, 3000, t)\", 0, 0]",
        &["face 12 is bent more sharply than its thickness of 0.001 m allows for a neo-hookean shell"],
    ),
];

#[test]
fn what_becomes_impossible_on_the_way_leaves_the_states_before_it() {
    for element in ["linear", "quadratic"] {
        for (material, rest, words) in ON_THE_WAY {
            let sandbox = Sandbox::new(&strip(element, material, &rest.replace("BAD", "t > 0.3 && t < 0.9 && x > 0.03")));
            sandbox.ok(&["check", "scene.toml"]);
            let message = sandbox.fails(2, &["all", "scene.toml"]);
            assert!(message.contains(": rest") && message.contains("t = 0.375"), "{element} {rest}: {message}");
            assert!(words.iter().all(|w| message.contains(w)), "{element} {rest}: {words:?} are not in {message}");
            assert!(message.contains("the last good state is in cases/scene/run/step_00000002.h5"), "{message}");
            assert!(!message.contains("trying"), "smaller steps were tried: {message}");
            let before = files(&sandbox.case(""));
            assert_eq!(before.keys().filter(|name| name.contains("step_")).count(), 3);
            for verb in ["run", "all"] {
                sandbox.fails(2, &[verb, "scene.toml"]);
                assert!(files(&sandbox.case("")) == before, "{element} {rest}: {verb} changed the case");
            }
        }
    }
}

#[test]
fn a_finished_case_stays_as_it_is_when_its_scene_becomes_impossible() {
    let good = |element: &str| strip(element, "", "[rest.pullback]\nbbar = [1, 0, 0]");
    let wood = "orthotropic = { youngs_moduli = [1e6, 4e6], poissons_ratio = 0.6, shear_modulus = 1e6 }";
    for element in ["linear", "quadratic"] {
        let sandbox = Sandbox::new(&good(element));
        sandbox.ok(&["all", "scene.toml", "-q"]);
        let before = files(&sandbox.case(""));
        for (material, rest, words) in [
            ("", "[rest.pullback]\nabar = [\"1 - 40 * x\", 0, 1]", &[": rest", "face 8 at (", "the rest metric "][..]),
            ("", "[rest.pullback]\nabar = [1, 1.5, 1]", &[": rest", "face 0 at (", "the rest metric [", "not positive definite"]),
            ("", "[rest.pullback]\nabar = [\"1 - 1.9 * t^2\", 0, 1]", &[": rest", "face 0 at (", "the rest metric "]),
            (
                "",
                "[rest.linear]\nm_plus = -50\nm_minus = 0\nmu = 0.01\nmu_perp = 0.03\n[machine-direction]\nangle = 20",
                &[": rest", "face 0 at (", "m_plus = -50 % makes 1 + m mu = -0.5"],
            ),
            (wood, "[machine-direction]\nangle = 0", &["|nu12| < sqrt(E1 / E2) = 0.5 is violated"]),
            (&format!("[[shell.region]]\nregion = \"far\"\n{wood}"), "[machine-direction]\nangle = 0", &["is violated", "(region 'far')"]),
        ] {
            let material = material.to_owned();
            let mut scene = strip(element, &material, rest);
            if material == wood {
                scene = scene.replace("youngs_modulus = 1e8\npoissons_ratio = 0.3\n", "");
            }
            sandbox.rewrite(&scene);
            for verb in ["check", "setup", "run", "all"] {
                let message = sandbox.fails(2, &[verb, "scene.toml"]);
                assert!(verb == "run" || words.iter().all(|w| message.contains(w)), "{verb}: {words:?} are not in {message}");
                assert!(files(&sandbox.case("")) == before, "{rest}: {verb} changed the case");
            }
        }
        sandbox.rewrite(&good(element));
        sandbox.ok(&["report", "scene.toml"]);
    }
}

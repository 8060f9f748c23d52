//! The stage `modes`: vibration and buckling against beams and strings, files, and what is refused; and reactions as measures.

use crate::physics_case::{Case, run};
use crate::pipeline_support::{STATIC, Sandbox};
use std::f64::consts::PI;
use thinshell::stage;

/// A strip of length 1 and rigidity 1 per width, mass 1 per area, its ends held on hinges in the xz plane, with a force `n` per width along x. Cylindrical bending
/// only, nu = 0.
fn beam(element: &str, cells: &str, n: f64, modes: &str) -> Case {
    run(&format!(
        "[mesh.rectangle]\nsize = [1.0, 0.1]\ncells = {cells}\n[shell]\nelement = \"{element}\"\nthickness = 1e-3\nyoungs_modulus = 12e9\n\
         poissons_ratio = 0.0\ndensity = 1000.0\n[[pin]]\nregion = \"left\"\n[[pin]]\nregion = \"right\"\ncomponents = [\"y\", \"z\"]\n\
         [[edge-load]]\nregion = \"right\"\nforce = [{n:?}, 0, 0]\n[statics]\nsteps = 1\n[modes]\n{modes}"
    ))
}

fn values(case: &Case) -> Vec<f64> {
    stage::modes::run(&case.job).unwrap();
    stage::modes::load(&case.job).unwrap().unwrap().values
}

/// `omega^2 = (n pi)^4 + (n pi)^2 N`, in tension, without load, under compression, and past the first critical load.
#[test]
fn prestress_changes_the_frequencies_of_a_beam() {
    for n in [200.0, 0.0, -0.5 * PI * PI, -1.5 * PI * PI] {
        let found = values(&beam("quadratic", "[12, 1]", n, "kind = \"vibration\"\ncount = 3\n"));
        for (i, f) in found.iter().enumerate() {
            let k = PI * (i + 1) as f64;
            let square = k.powi(4) + k * k * n;
            let exact = square.signum() * square.abs().sqrt() / (2.0 * PI);
            assert!((f / exact - 1.0).abs() < 2e-3, "N = {n}, mode {}: {f} {exact}", i + 1);
        }
    }
}

/// The factors on the load are those of Euler, n^2 pi^2; in tension there are none.
#[test]
fn a_beam_buckles_as_euler_says() {
    for (element, cells, tolerance) in [("quadratic", "[12, 1]", 2e-3), ("linear", "[40, 4]", 2e-2)] {
        let case = beam(element, cells, -0.01, "kind = \"buckling\"\ncount = 3\n");
        for (i, factor) in values(&case).iter().enumerate() {
            let exact = 100.0 * (PI * (i + 1) as f64).powi(2);
            assert!((factor / exact - 1.0).abs() < tolerance, "{element} {}: {factor} {exact}", i + 1);
        }
    }
    let pulled = beam("quadratic", "[6, 1]", 0.01, "kind = \"buckling\"\n");
    let message = stage::modes::run(&pulled.job).unwrap_err().to_string();
    assert!(message.contains("no factor on the load"), "{message}");
    // From a shift the same values.
    let near = beam("quadratic", "[12, 1]", -0.01, "kind = \"buckling\"\nshift = 900\ncount = 1\n");
    assert!((values(&near)[0] / (100.0 * PI * PI) - 1.0).abs() < 1e-3);
    let past = beam("quadratic", "[12, 1]", -0.01, "kind = \"buckling\"\nshift = 2000\n");
    let message = stage::modes::run(&past.job).unwrap_err().to_string();
    assert!(message.contains("unstable already, in 1 directions"), "{message}");
}

/// A tall strip tips over at the force of a beam whose clamp hinders warping, `4.0126 sqrt(EI GJ) / L^2` and 0.826 % of it, on a mesh so fine that the assembled
/// stiffness, which is in the stretching of the strip, has lost 0.1 % of that.
#[test]
fn a_tall_strip_tips_over_on_a_fine_mesh() {
    let case = run("[mesh.rectangle]\nsize = [1.0, 0.02]\ncells = [200, 8]\n[shell]\nthickness = 2e-4\nyoungs_modulus = 12e9\n\
         poissons_ratio = 0.0\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[[edge-load]]\nregion = \"right\"\nforce = [0, -1e-4, 0]\n\
         [statics]\nsteps = 1\n[modes]\nkind = \"buckling\"\ncount = 1\n");
    let factor = values(&case)[0];
    assert!((factor / 457.725 - 1.0).abs() < 3e-4, "{factor}");
}

/// Frequencies of a clamped plate go with its thickness, which is far less than its stretching would let them be told.
#[test]
fn frequencies_of_the_thinnest_plates() {
    let of = |thickness: f64| {
        values(&run(&format!(
            "[mesh.rectangle]\nsize = [1.0, 1.0]\ncells = [6, 6]\n[shell]\nthickness = {thickness:?}\nyoungs_modulus = 1e9\n\
             poissons_ratio = 0.3\ndensity = 1000.0\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[statics]\nsteps = 0\n\
             [modes]\nkind = \"vibration\"\ncount = 4\n"
        )))
    };
    let thick = of(1e-3);
    for thickness in [1e-5, 1e-6, 1e-8] {
        for (thin, thick) in of(thickness).iter().zip(&thick) {
            let ratio = thin / thick * 1e-3 / thickness;
            assert!((ratio - 1.0).abs() < 1e-5, "{thickness:e}: {thin} Hz, {ratio}");
        }
    }
}

/// A stretched sheet wrinkles along the pull: that the load stiffens other directions ten thousand times more does not hide it.
#[test]
fn a_stretched_sheet_wrinkles() {
    let case = run("[mesh.rectangle]\nsize = [0.25, 0.1]\ncells = [20, 20]\n[shell]\nthickness = 1e-4\nyoungs_modulus = 1e6\n\
         poissons_ratio = 0.45\n[[pin]]\nregion = \"left\"\n[[pin]]\nregion = \"right\"\nmotion = { x = \"0.025 * t\" }\n[statics]\nsteps = 2\n\
         [modes]\nkind = \"buckling\"\ncount = 2\n");
    let found = values(&case);
    println!("{found:?}");
    assert!(found.iter().all(|factor| *factor > 0.0 && *factor < 1.0), "{found:?}");
}

const FREE: &str = "[mesh.disc]\nradius = 1.0\nrings = 4\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1.092e10\npoissons_ratio = 0.3\n\
    density = 1000.0\n[statics]\nsteps = 0\n[modes]\nkind = \"vibration\"\ncount = 8\n[[report.expect]]\nname = \"two diameters\"\n\
    measure = { frequency = { mode = 7 } }\nreference = 0.85275\ntolerance = 0.01\nsource = \"5.358 / (2 pi)\"\n";

/// A free disc: six rigid motions, then a pair; all files; nothing is done twice.
#[test]
fn a_free_disc_through_all_stages() {
    let sandbox = Sandbox::new(FREE);
    let (out, _) = sandbox.ok(&["all", "scene.toml"]);
    assert!(
        out.contains("passed") && out.contains("Lowest modes of vibration: 0, 0, 0, 0, 0, 0, 0.85") && out.contains("which is round-off)"),
        "{out}"
    );
    let list: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(sandbox.case("modes.json")).unwrap()).unwrap();
    let value = |i: usize| list[i]["frequency_Hz"].as_f64().unwrap();
    assert!((0..6).all(|i| value(i) == 0.0) && (value(6) / value(7) - 1.0).abs() < 1e-3, "{list}");
    let files = sandbox.names("cases/scene/vtk");
    for name in ["mode_0001.vtu", "mode_0008.vtu", "modes.pvd", "modes.json"] {
        assert!(files.iter().any(|f| f == name), "{files:?}");
    }
    let stamp = |name: &str| std::fs::metadata(sandbox.case(name)).unwrap().modified().unwrap();
    let before = stamp("modes.h5");
    assert!(sandbox.ok(&["status", "scene.toml"]).0.contains("modes   done"));
    sandbox.ok(&["all", "scene.toml", "-q"]);
    assert_eq!(before, stamp("modes.h5"));
    // Another table, other modes; the run stays.
    let run = stamp("run/step_00000000.h5");
    sandbox.ok(&["all", "scene.toml", "-q", "--set", "modes.count=7"]);
    assert!(before != stamp("modes.h5") && run == stamp("run/step_00000000.h5"));
    assert!(!sandbox.names("cases/scene/vtk").iter().any(|f| f == "mode_0008.vtu"));
    // The same bits again.
    let bytes = std::fs::read(sandbox.case("modes.h5")).unwrap();
    std::fs::remove_file(sandbox.case("modes.h5")).unwrap();
    sandbox.ok(&["modes", "scene.toml", "-q", "--set", "modes.count=7"]);
    assert!(bytes == std::fs::read(sandbox.case("modes.h5")).unwrap());
}

#[test]
fn modes_that_are_absent_or_refused() {
    let sandbox = Sandbox::new(STATIC);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    assert!(!sandbox.names("cases/scene").iter().any(|name| name.starts_with("modes")));
    assert!(!sandbox.ok(&["status", "scene.toml"]).0.contains("modes"));
    assert!(sandbox.fails(2, &["modes", "scene.toml"]).contains("has no such table"));
    let measured =
        "[[report.expect]]\nname = \"f\"\nmeasure = { frequency = { mode = 5 } }\nreference = 1.0\ntolerance = 1.0\nsource = \"s\"\n";
    for (scene, words) in [
        (format!("{STATIC}[modes]\nkind = \"vibration\"\ncount = 0\n"), "modes.count"),
        (format!("{STATIC}[modes]\nkind = \"vibration\"\nshift = 0\n"), "modes.shift"),
        (format!("{STATIC}[modes]\nkind = \"buckling\"\nshift = -1\n"), "modes.shift"),
        (format!("{STATIC}[modes]\nkind = \"sound\"\n"), "modes.kind"),
        (format!("{STATIC}{measured}"), "needs [modes]"),
        (format!("{STATIC}[modes]\nkind = \"buckling\"\n{measured}"), "needs [modes] with `kind = \"vibration\"`"),
        (format!("{STATIC}[modes]\nkind = \"vibration\"\n{measured}"), "frequency.mode"),
        (FREE.replace("density = 1000.0\n", ""), "[modes] needs it"),
        (FREE.replace("vibration", "buckling"), "statics.steps"),
        (STATIC.replace("steps = 8", "steps = 0"), "statics.steps"),
    ] {
        let sandbox = Sandbox::new(&scene);
        let message = sandbox.fails(2, &["check", "scene.toml"]);
        assert!(message.contains(words), "{words} is not in {message}");
    }
}

/// A strip turned to a quarter circle by its right end: moments, and no force, act on both ends; and the measures of a load.
#[test]
fn reactions_as_measures() {
    let scene = "[mesh.rectangle]\nsize = [1.0, 0.2]\ncells = [8, 1]\n[shell]\nthickness = 0.01\nyoungs_modulus = 12e6\npoissons_ratio = 0.0\n\
        [output]\nreactions = true\n[statics]\nsteps = 4\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n";
    let expect = |name: &str, measure: &str, reference: f64, tolerance: f64| {
        format!(
            "[[report.expect]]\nname = \"{name}\"\nmeasure = {measure}\nreference = {reference:?}\ntolerance = {tolerance:?}\nsource = \"statics\"\n"
        )
    };
    // Rigidity 1 per width: the moment about y is the curvature times the width.
    let moment = PI / 2.0 * 0.2;
    let turned = format!(
        "{scene}[[pin]]\nregion = \"right\"\ncomponents = []\ndirector = {{ rotation = {{ axis = [0, -1, 0], angle = \"90 * t\" }} }}\n{}{}{}{}",
        expect("right", "{ reaction-moment = { region = \"right\", axis = \"y\" } }", -moment, 2e-3 * moment),
        expect("left", "{ reaction-moment = { region = \"left\", axis = \"y\" } }", moment, 2e-3 * moment),
        expect("half", "{ reaction-moment = { region = \"left\", axis = \"y\" } }\ntime = 0.5", 0.5 * moment, 1e-3 * moment),
        expect("force", "{ reaction = { region = \"left\", axis = \"z\" } }", 0.0, 1e-5 * moment),
    );
    let loaded = format!(
        "{scene}[[edge-load]]\nregion = \"right\"\nforce = [0, 1e-3, -2e-3]\n{}{}{}{}",
        expect("across", "{ reaction = { region = \"left\", axis = \"y\" } }", -2e-4, 2e-8),
        expect("up", "{ reaction = { region = \"left\", axis = \"z\" } }", 4e-4, 4e-8),
        expect("free end", "{ reaction = { region = \"right\", axis = \"z\" } }", 0.0, 0.0),
        expect("lever", "{ reaction-moment = { region = \"left\", axis = \"y\", about = [0.25, 0, 0] } }", -0.75 * 4e-4, 4e-8),
    );
    for text in [&turned, &loaded] {
        let sandbox = Sandbox::new(text);
        let (out, _) = sandbox.ok(&["all", "scene.toml"]);
        assert!(out.contains("passed"), "{out}");
        let without = text.replace("reactions = true\n", "");
        let message = Sandbox::new(&without).fails(2, &["check", "scene.toml"]);
        assert!(message.contains("needs `reactions = true` in [output]"), "{message}");
        // They are in the checkpoints and among the fields, and a resumed run ends with the same bits.
        let parts = Sandbox::new(text).prepared();
        parts.ok(&["run", "scene.toml", "--stop-after", "2", "-q"]);
        parts.ok(&["run", "scene.toml", "-q"]);
        assert!(parts.newest() == sandbox.newest());
        let vtk = std::fs::read_to_string(sandbox.case("vtk/step_00000004.vtu")).unwrap();
        assert!(vtk.contains("Name=\"reaction\""));
    }
    assert!(
        Sandbox::new(&loaded.replace("\"left\", axis = \"y\" }", "\"lft\", axis = \"y\" }"))
            .fails(2, &["check", "scene.toml"])
            .contains("'lft'")
    );
}

//! What a scene does not name leaves no trace: no dataset, no column, no array, no line.

use super::pipeline_support::{DYNAMIC, STATIC, Sandbox, text, with};
use std::collections::BTreeSet;
use std::fs;

/// Names in the files of a case and words of its log.
struct Traces {
    setup: BTreeSet<String>,
    checkpoint: BTreeSet<String>,
    columns: BTreeSet<String>,
    arrays: BTreeSet<String>,
    log: String,
}

fn datasets(path: &std::path::Path) -> BTreeSet<String> {
    fn collect(group: &hdf5::Group, found: &mut BTreeSet<String>) {
        found.extend(group.datasets().unwrap().iter().map(|d| d.name().trim_start_matches('/').to_owned()));
        // The numbers of a snapshot have names too.
        for dataset in group.datasets().unwrap() {
            if let Ok(names) = dataset.attr("names").and_then(|a| a.read_scalar::<hdf5::types::VarLenUnicode>()) {
                found.extend(serde_json::from_str::<Vec<String>>(&names).unwrap());
            }
        }
        group.groups().unwrap().iter().for_each(|g| collect(g, found));
    }
    let mut found = BTreeSet::new();
    collect(&hdf5::File::open(path).unwrap(), &mut found);
    found
}

fn traces(scene: &str) -> Traces {
    let sandbox = Sandbox::new(scene);
    let output = sandbox.output(&["all", "scene.toml", "-vv"]);
    let log = text(&output.stderr) + &text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{log}");
    let newest = sandbox.newest().0;
    let frame = sandbox.case("vtk").join(newest.replace(".h5", ".vtp"));
    let vtk = text(&fs::read(frame).unwrap());
    let arrays = vtk.split("Name=\"").skip(1).filter_map(|rest| rest.split('"').next()).map(str::to_owned).collect();
    let columns = sandbox.history()[0].split(',').map(str::to_owned).collect();
    Traces { setup: datasets(&sandbox.case("setup.h5")), checkpoint: datasets(&sandbox.case("run").join(newest)), columns, arrays, log }
}

impl Traces {
    fn all(&self) -> impl Iterator<Item = &String> {
        self.setup.iter().chain(&self.checkpoint).chain(&self.columns).chain(&self.arrays)
    }

    /// Names with one of these words in them, and lines of the log with one.
    fn of(&self, words: &[&str]) -> Vec<String> {
        let has = |text: &str| words.iter().any(|w| text.to_lowercase().contains(w));
        let lines = self.log.lines().filter(|l| has(l)).map(str::to_owned);
        self.all().filter(|n| has(n)).cloned().chain(lines).collect()
    }
}

/// The scene with the part shows these words; the one without does not, and has nothing that the other has not.
fn assert_traceless(with: &str, without: &str, words: &[&str]) {
    let (with, without) = (traces(with), traces(without));
    assert!(!with.of(words).is_empty(), "{words:?} are not shown by the scene that has the part");
    assert_eq!(without.of(words), Vec::<String>::new(), "{words:?}");
    for (a, b) in [
        (&with.setup, &without.setup),
        (&with.checkpoint, &without.checkpoint),
        (&with.columns, &without.columns),
        (&with.arrays, &without.arrays),
    ] {
        assert!(b.is_subset(a), "the absence of {words:?} adds {:?}", b.difference(a));
    }
}

const PIN: &str = "[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\nmotion = { z = \"0.002 * sin(60 * t)\" }\n";

#[test]
fn gravity() {
    assert_traceless(DYNAMIC, &with(DYNAMIC, "[gravity]\nfactor = \"cos(50 * t)\"", ""), &["gravity"]);
    let weightless = with(&with(STATIC, "[gravity]\n", ""), "density = 1000.0\n", "");
    assert_traceless(STATIC, &weightless, &["gravity"]);
    assert!(traces(STATIC).setup.contains("density") && !traces(&weightless).setup.contains("density"));
}

#[test]
fn motion_in_time() {
    let resting = with(
        &with(DYNAMIC, "[dynamics]\ndt = 2e-3\nend = 0.04\nvelocity = [0, \"x\", 0]", "[statics]\nsteps = 4"),
        "viscosity = 0.01\n",
        "",
    );
    // What is slow enough for four steps through equilibria.
    let resting = [("20 * t", "t"), ("40 * t", "t"), ("50 * t", "t"), ("60 * t", "t")].iter().fold(resting, |s, (a, b)| with(&s, a, b));
    assert_traceless(DYNAMIC, &resting, &["velocity", "kinetic"]);
}

#[test]
fn growth() {
    let law = "[rest]\nramp = \"min(1, 20 * t)\"\n[rest.linear]\nm_plus = \"3 * sin(40 * t + 30 * x)\"\nm_minus = \"-2 * t\"\nmu = 0.01\n";
    assert_traceless(DYNAMIC, &with(DYNAMIC, law, ""), &["moisture", "swelling"]);
    // Another law has no moisture either.
    assert_traceless(DYNAMIC, &with(DYNAMIC, law, "[rest.pullback]\nbbar = [10, 0, 0]\n"), &["moisture"]);
}

#[test]
fn a_machine_direction() {
    let fibres = with(DYNAMIC, "mu = 0.01", "mu = 0.01\nmu_perp = 0.03\n[machine-direction]\nvector = [1, 1, 0]");
    assert_traceless(&fibres, DYNAMIC, &["machine"]);
}

#[test]
fn supports() {
    assert_traceless(DYNAMIC, &with(DYNAMIC, PIN, ""), &["held_"]);
    // A pin without directors keeps none.
    let hinge = with(DYNAMIC, "director = \"clamped\"\n", "");
    assert_traceless(DYNAMIC, &hinge, &["held_director"]);
}

#[test]
fn materials() {
    let rubber = with(STATIC, "density", "material = \"neo-hookean\"\ndensity");
    assert_traceless(&rubber, STATIC, &["constitution"]);
}

#[test]
fn viscosity() {
    let (with_it, without) = (traces(DYNAMIC), traces(&with(DYNAMIC, "viscosity = 0.01\n", "")));
    assert_eq!(without.of(&["visc", "damp"]), Vec::<String>::new());
    for (a, b) in [
        (&with_it.setup, &without.setup),
        (&with_it.checkpoint, &without.checkpoint),
        (&with_it.columns, &without.columns),
        (&with_it.arrays, &without.arrays),
    ] {
        assert!(b.is_subset(a));
    }
}

#[test]
fn directors() {
    assert_traceless(
        DYNAMIC,
        &with(&with(DYNAMIC, "[shell]", "[shell]\ndirector = \"average\""), "director = \"clamped\"\n", ""),
        &["director"],
    );
}

#[test]
fn stability_and_disturbances() {
    let resting = with(STATIC, "steps = 8", "steps = 3");
    let stable = with(&resting, "steps = 3", "steps = 3\nstable = true") + "[output]\nlowest_mode = true\n";
    assert_traceless(&stable, &resting, &["lowest_", "branch_switches"]);
    // A disturbance is in the first state and nowhere else.
    let disturbed = with(&resting, "steps = 3", "steps = 3\nperturbation = { amplitude = 1e-5 }");
    let (with_it, without) = (traces(&disturbed), traces(&resting));
    assert!(with_it.of(&["disturb", "perturb"]).is_empty() && with_it.all().eq(without.all()));
}

#[test]
fn moisture_that_diffuses() {
    let scene = with(DYNAMIC, "m_plus = \"3 * sin(40 * t + 30 * x)\"\nm_minus = \"-2 * t\"\n", "");
    let law = "[rest]\nramp = \"min(1, 20 * t)\"\n[rest.linear]\nmu = 0.01\n";
    let table =
        "[moisture]\nlayers = 2\ndiffusivity = { through = 1e-6, along = 1e-6 }\n[[moisture.boundary]]\nside = \"top\"\nvalue = 3\n";
    let wet = with(&scene, law, &format!("{table}[rest.linear]\nmu = 0.01\n"));
    assert_traceless(&wet, &with(&with(&wet, table, ""), "[rest.linear]\nmu = 0.01\n", ""), &["moisture", "diffus"]);
    let warm = |scene: &str| scene.replace("[moisture]", "[heat]").replace("[[moisture.", "[[heat.");
    let law = "[rest.linear]\nmu = 0.01\n";
    let hot = with(&warm(&wet), law, "[rest.thermal]\nexpansion = 0.01\n");
    assert_traceless(
        &hot,
        &with(&with(&hot, &warm(table), ""), "[rest.thermal]\nexpansion = 0.01\n", ""),
        &["heat", "temperature", "thermal"],
    );
}

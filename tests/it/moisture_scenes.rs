//! Scenes in which moisture or heat diffuses and drives the shell: rest shape, stiffness, mass, files, refusals.

use super::pipeline_support::{Sandbox, text};
use std::collections::BTreeMap;

/// A sheet that lies free on six supports, wetted on top, through equilibria; `T = D t / h^2` is 0.1 per second.
const WETTED: &str = r#"
title = "wetted"
[mesh.rectangle]
size = [0.02, 0.01]
cells = [4, 2]
[[region]]
name = "corner"
nearest = [0, 0, 0]
[[region]]
name = "ahead"
nearest = [0.02, 0, 0]
[[region]]
name = "aside"
nearest = [0, 0.01, 0]
[shell]
thickness = 1e-3
youngs_modulus = 1e9
poissons_ratio = 0.3
[machine-direction]
vector = [0, 1, 0]
[moisture]
layers = 4
diffusivity = { through = 1e-7, along = 1e-7 }
[[moisture.boundary]]
side = "top"
value = 10
[rest.linear]
mu = 0
mu_perp = 1e-4
[[pin]]
region = "corner"
[[pin]]
region = "ahead"
components = ["y", "z"]
[[pin]]
region = "aside"
components = ["z"]
[statics]
steps = 10
end = 1.0
"#;

fn with(scene: &str, from: &str, to: &str) -> String {
    assert!(scene.contains(from), "{from}");
    scene.replacen(from, to, 1)
}

fn ran(scene: &str) -> Sandbox {
    let sandbox = Sandbox::new(scene);
    let output = sandbox.output(&["all", "scene.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", text(&output.stderr), text(&output.stdout));
    sandbox
}

/// The last row of the history by its columns.
fn last(sandbox: &Sandbox) -> BTreeMap<String, f64> {
    let history = sandbox.history();
    let columns = history[0].split(',').map(str::to_owned);
    columns.zip(history.last().unwrap().split(',').map(|v| v.parse().unwrap())).collect()
}

/// Coordinates of the nodes at the end.
fn positions(sandbox: &Sandbox) -> Vec<f64> {
    let file = hdf5::File::open(sandbox.case("run").join(sandbox.newest().0)).unwrap();
    file.dataset("fields/position").unwrap().read_raw::<f64>().unwrap()
}

/// What a scene refuses, and how.
fn refused(scene: &str) -> String {
    let sandbox = Sandbox::new(scene);
    let output = sandbox.output(&["check", "scene.toml"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    said
}

/// Curvature over strain and thickness, and its exact value: with the top held at 1 and the bottom sealed
/// `u = 1 - sum 2 (-1)^n / q cos(q x) exp(-q^2 T)`, `q = (n + 1/2) pi`, `x` from the bottom; the curl is `12 int (x - 1/2) u dx`.
fn exact_curl(t: f64) -> f64 {
    let sum = |n: i32| {
        let q = (f64::from(n) + 0.5) * std::f64::consts::PI;
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        // int (x - 1/2) cos(q x) dx over [0, 1] = sin(q) / (2 q) + (cos(q) - 1) / q^2, with cos(q) = 0.
        2.0 * sign / q * (-q * q * t).exp() * (0.5 * sign / q - 1.0 / (q * q))
    };
    -12.0 * (0..200).map(sum).sum::<f64>()
}

#[test]
fn the_series_is_the_published_one() {
    for (t, curl) in [(0.01, 0.55703), (0.05, 0.91414), (0.1, 0.95446), (0.3, 0.63290), (1.0, 0.11270)] {
        assert!((exact_curl(t) - curl).abs() < 1e-5, "{t}: {}", exact_curl(t));
    }
}

#[test]
fn a_wetted_sheet_curls_away_from_the_water_as_the_series_says() {
    let curl = exact_curl(0.1);
    // Wetting the top makes it convex: the smaller principal curvature, along the strip.
    let expect = format!(
        "[[report.expect]]\nname = \"curl\"\nmeasure = {{ field = {{ name = \"principal-curvatures\", component = 1, statistic = \"mean\" }} }}\n\
         reference = {:?}\ntolerance = {:?}\nsource = \"series\"\n",
        -curl,
        0.01 * curl
    );
    let fine = with(WETTED, "layers = 4", "layers = 8\nscheme = \"sdirk2\"\ndt = 1e-3");
    ran(&(fine.clone() + &expect));
    // The expectation can fail: dry paper.
    let dry = Sandbox::new(&(with(&fine, "value = 10", "value = 0") + &expect));
    assert_eq!(dry.output(&["all", "scene.toml"]).status.code(), Some(1));
}

#[test]
fn the_balance_is_in_the_history() {
    let history = last(&ran(WETTED));
    let (total, top) = (history["moisture_total_pct_m3"], history["moisture_in_top_pct_m3"]);
    assert!(total > 0.1 * 10.0 * 2e-4 * 1e-3, "{total}");
    assert!((total - top).abs() < 1e-13 * total && history["moisture_in_rim_pct_m3"] == 0.0);
    assert_eq!(history["moisture_overshoot_pct"], 0.0);
}

#[test]
fn a_stopped_run_ends_with_the_same_bits() {
    // The sheet rises off the wet ground as it curls: some of its top stays wet, some does not.
    let wet = |below: &str| last(&ran(&with(WETTED, "value = 10", &format!("value = 10\n{below}"))))["moisture_total_pct_m3"];
    assert!(wet("below = 2e-5") < 0.9 * wet("") && wet("below = 2e-5") > 0.1 * wet(""));
    for more in ["", "[heat]\ndiffusivity = { through = 1e-8, along = 0 }\nscheme = \"sdirk2\"\ndt = 0.03\nsource = \"sin(9 * t) * x\"\n"] {
        let scene = with(WETTED, "value = 10", "value = \"10 * sin(3 * t)\"\nuntil = 0.77\nbelow = 2e-5") + more;
        let whole = ran(&scene);
        let parts = Sandbox::new(&scene);
        for stage in [&["mesh", "scene.toml"][..], &["setup", "scene.toml"]] {
            assert_eq!(parts.output(stage).status.code(), Some(0));
        }
        for _ in 0..4 {
            assert_eq!(parts.output(&["run", "scene.toml", "--stop-after", "3"]).status.code(), Some(0));
        }
        assert_eq!(parts.newest().0, whole.newest().0);
        assert!(parts.newest().1 == whole.newest().1, "the last checkpoints differ");
    }
}

#[test]
fn moisture_softens() {
    // A sheet under a line load, wet through from the start: its deflection goes with the inverse of the factor.
    let deflection = |stiffness: &str| {
        let load = "[[edge-load]]\nregion = \"right\"\nforce = [0, 0, 0.01]\n[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n";
        let scene = with(WETTED, "[statics]", &format!("{load}[statics]"));
        let pins = scene[scene.find("[[pin]]\nregion = \"corner\"").unwrap()..scene.find("[[edge-load]]").unwrap()].to_owned();
        let scene = with(&with(&scene, &pins, ""), "layers = 4", &format!("layers = 4\ninitial = 10\n{stiffness}"));
        let scene = with(&scene, "mu = 0\nmu_perp = 1e-4", "mu = 0");
        let expect = "[[report.expect]]\nname = \"tip\"\nmeasure = { displacement = { at = [0.02, 0.005, 0], axis = \"z\" } }\nreference = 0\ntolerance = 1\nsource = \"shown\"\n";
        let sandbox = ran(&(scene + expect));
        let report: serde_json::Value = serde_json::from_slice(&std::fs::read(sandbox.case("report.json")).unwrap()).unwrap();
        report["expectations"][0]["value"].as_f64().unwrap()
    };
    let (dry, wet) = (deflection(""), deflection("stiffness = \"1 / (1 + 0.1 * u)\""));
    assert!(dry > 1e-7 && (wet / dry - 2.0).abs() < 1e-3, "{wet} / {dry}");
}

#[test]
fn water_has_weight_and_brings_momentum_but_no_force() {
    // A free sheet that drifts while its mass doubles keeps its velocity.
    let moving = with(WETTED, "[statics]\nsteps = 10\nend = 1.0", "[dynamics]\ndt = 0.1\nend = 1.0\nvelocity = [0.5, 0, 0]");
    let pins = moving[moving.find("[[pin]]").unwrap()..moving.find("[dynamics]").unwrap()].to_owned();
    let free = with(&moving, &pins, "");
    let heavier = "layers = 4\nadded_density = 5000\nsource = 20";
    let free = with(&with(&free, "layers = 4", heavier), "poissons_ratio = 0.3", "poissons_ratio = 0.3\ndensity = 1000.0");
    let free = with(&with(&free, "mu_perp = 1e-4", "mu_perp = 0"), "[[moisture.boundary]]\nside = \"top\"\nvalue = 10\n", "");
    let history = last(&ran(&free));
    // 1 kg/m2 at the start and u = 20 % at the end: 5000 kg/m3 times 0.2 times 1 mm more.
    let energy = 0.5 * 2.0 * 2e-4 * 0.25;
    assert!((history["kinetic_energy_J"] / energy - 1.0).abs() < 1e-9, "{} {energy}", history["kinetic_energy_J"]);
    let still = with(&free, "added_density = 5000\n", "");
    assert!((last(&ran(&still))["kinetic_energy_J"] / energy - 0.5).abs() < 1e-9);
}

#[test]
fn weight_follows_the_mass() {
    // A free sheet falls with g while its mass doubles; one that is held sags twice as far.
    let start = with(WETTED, "[[moisture.boundary]]\nside = \"top\"\nvalue = 10\n", "[gravity]\n");
    let start = with(&with(&start, "mu_perp = 1e-4", "mu_perp = 0"), "poissons_ratio = 0.3", "poissons_ratio = 0.3\ndensity = 1000.0");
    let pins = start[start.find("[[pin]]").unwrap()..start.find("[statics]").unwrap()].to_owned();
    let heavier = with(&start, "layers = 4", "layers = 4\nadded_density = 5000\nsource = 20");
    let falling = with(&with(&heavier, &pins, ""), "[statics]\nsteps = 10\nend = 1.0", "[dynamics]\ndt = 0.01\nend = 0.1");
    let history = last(&ran(&falling));
    // After 0.1 s u = 2 %, so that the mass is 1.1 times 1 kg/m2 on 2e-4 m2; implicit Euler has the velocity g t exactly if weight is g times mass. What is
    // added while it falls has the shell's velocity.
    let energy = 0.5 * 1.1 * 2e-4 * (9.80665f64 * 0.1).powi(2);
    assert!((history["kinetic_energy_J"] / energy - 1.0).abs() < 1e-9, "{} {energy}", history["kinetic_energy_J"]);
    let clamped = "[[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n";
    let sag = |scene: &str| -last(&ran(&with(scene, &pins, clamped)))["gravity_energy_J"];
    // The energy of weight goes with the square of the mass, 2 kg/m2 at the end.
    let ratio = sag(&heavier) / sag(&start);
    assert!((ratio - 4.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn layers_of_their_own_moduli_swell_alike_by_both_laws() {
    let layered =
        with(WETTED, "poissons_ratio = 0.3", "poissons_ratio = 0.3\nbilayer = { top_thickness = 3e-4, top = { youngs_modulus = 1e10 } }");
    let bilayer = with(&layered, "[rest.linear]\nmu = 0\nmu_perp = 1e-4", "[rest.bilayer]\nmu = [0, 0]\nmu_perp = [1e-4, 1e-4]");
    let shape = |scene: &str| positions(&ran(scene));
    let (linear, bilayer, plain) = (shape(&layered), shape(&bilayer), shape(WETTED));
    assert_eq!(linear, bilayer);
    // The front is in the stiff layer, which matters.
    assert!(linear.iter().zip(&plain).any(|(a, b)| (a - b).abs() > 1e-6));
    // A bimetal in heat: equal temperatures, layers that expand differently, Timoshenko's curvature 24 e / (16 h) for equal layers.
    let bimetal = WETTED.replace("[moisture]", "[heat]\ninitial = 10").replace("[[moisture.boundary]]\nside = \"top\"\nvalue = 10\n", "");
    let law = "[rest.thermal]\nexpansion = 0\nexpansion_perp = 2e-4\nbottom = { expansion = 0, expansion_perp = 1e-4 }\n";
    let bimetal = with(&bimetal, "[rest.linear]\nmu = 0\nmu_perp = 1e-4\n", law);
    let expect = "[[report.expect]]\nname = \"curvature\"\nmeasure = { field = { name = \"principal-curvatures\", component = 1, statistic = \"mean\" } }\n\
                  reference = -1.5\ntolerance = 0.005\nsource = \"Timoshenko, to first order in the strain\"\n";
    ran(&(bimetal + expect));
}

#[test]
fn a_step_that_failed_leaves_no_trace() {
    // Growth that one step cannot follow: it is halved; smaller steps from the start on end with the same bits.
    let thin = with(&with(WETTED, "thickness = 1e-3", "thickness = 1e-4"), "through = 1e-7", "through = 1e-9");
    let thin = with(&with(&thin, "value = 10", "value = \"40 * t\""), "mu_perp = 1e-4", "mu_perp = 1e-2");
    let sudden = with(&thin, "steps = 10\nend = 1.0", "steps = 1\nend = 0.5");
    let halvings =
        |sandbox: &Sandbox| sandbox.history().iter().skip(1).map(|row| row.split(',').nth(3).unwrap().parse::<f64>().unwrap()).sum::<f64>();
    let forced = ran(&sudden);
    let halved = halvings(&forced);
    assert!(halved > 0.0, "the step did not fail: {:?}", forced.history());
    let first = forced.history()[1].split(',').nth(2).unwrap().parse::<f64>().unwrap();
    let free = ran(&with(&sudden, "steps = 1", &format!("steps = {}", (0.5 / first).round())));
    assert_eq!(free.history()[1].split(',').nth(3), Some("0.0"));
    // The state after the first accepted step.
    let field = |sandbox: &Sandbox, name: &str| {
        let file = hdf5::File::open(sandbox.case("run/step_00000001.h5")).unwrap();
        file.dataset(&format!("fields/{name}")).unwrap().read_raw::<f64>().unwrap()
    };
    for name in ["moisture", "position", "director", "lagged_stress"] {
        assert_eq!(field(&forced, name), field(&free, name), "{name}");
    }
}

#[test]
fn load_steps_end_where_they_would_without_halvings() {
    let thin = with(&with(WETTED, "thickness = 1e-3", "thickness = 1e-4"), "through = 1e-7", "through = 1e-9");
    let thin = with(&with(&thin, "value = 10", "value = \"40 * min(t, 0.5)\""), "mu_perp = 1e-4", "mu_perp = 1e-2");
    let sandbox = ran(&with(&thin, "steps = 10\nend = 1.0", "steps = 5\nend = 2.5"));
    let column = |place: usize| -> Vec<f64> {
        sandbox.history().iter().skip(1).map(|row| row.split(',').nth(place).unwrap().parse().unwrap()).collect()
    };
    // Two halvings or more, after which steps that only grow again would go past the ends.
    assert!(column(3)[0] >= 2.0, "{:?}", column(3));
    let times = column(1);
    assert!([0.5, 1.0, 1.5, 2.0, 2.5].iter().all(|end| times.contains(end)), "{times:?}");
    // All are kept.
    assert_eq!(sandbox.names("cases/scene/run").len(), times.len() + 1);
}

#[test]
fn the_ways_of_the_paper_are_there() {
    // One layer, consistent mass, the law as printed: the curl exp(-3 T) at T = 0.1 (small steps), where 8 layers have 0.954.
    let paper = with(WETTED, "layers = 4", "layers = 1\nmass = \"consistent\"\nseen = \"faces\"\ndt = 1e-4");
    let paper =
        with(&with(&paper, "mu = 0\n", "mu = 0\nprofile = \"sides\"\n"), "[rest.linear]", "[rest]\nsampling = \"centroid\"\n[rest.linear]");
    let expect = format!(
        "[[report.expect]]\nname = \"curl\"\nmeasure = {{ field = {{ name = \"principal-curvatures\", component = 1, statistic = \"mean\" }} }}\n\
         reference = {:?}\ntolerance = 2e-3\nsource = \"one linear prism\"\n",
        -(-0.3f64).exp()
    );
    ran(&(paper + &expect));
    // Wetting one end only, what faces see differs from what places see.
    let end = with(WETTED, "value = 10", "value = 10\nregion = \"end\"")
        .replace("[[pin]]\nregion = \"corner\"", "[[region]]\nname = \"end\"\nwhere = \"x > 0.014\"\n[[pin]]\nregion = \"corner\"");
    let (places, faces) = (positions(&ran(&end)), positions(&ran(&with(&end, "layers = 4", "layers = 4\nseen = \"faces\""))));
    assert!(places != faces && places.iter().zip(&faces).all(|(a, b)| (a - b).abs() < 1e-4));
}

#[test]
fn fluxes_and_air_bring_what_they_say() {
    // 1e-5 % m/s through the bottom for 0.4 s, and through the rim nothing.
    let painted = with(WETTED, "side = \"top\"\nvalue = 10", "side = \"bottom\"\nflux = 1e-2\nfrom = 0.1\nuntil = 0.5");
    let history = last(&ran(&painted));
    let brought = 1e-2 * 0.4 * 2e-4;
    assert!((history["moisture_in_bottom_pct_m3"] / brought - 1.0).abs() < 1e-12, "{history:?}");
    assert!((history["moisture_total_pct_m3"] / brought - 1.0).abs() < 1e-12);
    // Dry air at the rim: what leaves, leaves through the rim. Where D is 0 nothing enters beyond the surface.
    let drying = with(WETTED, "side = \"top\"\nvalue = 10", "side = \"rim\"\nexchange = { coefficient = 1e-4, outside = 0 }");
    let drying = with(&drying, "layers = 4", "layers = 4\ninitial = 10");
    let slow = "[[moisture.region]]\nregion = \"end\"\ndiffusivity = { through = 0, along = 0 }\n[[region]]\nname = \"end\"\nwhere = \"x > 0.009\"\n";
    let wetted = |region: &str| last(&ran(&with(WETTED, "[rest.linear]", &format!("{region}[rest.linear]"))))["moisture_total_pct_m3"];
    let (all, part) = (wetted(""), wetted(slow));
    assert!(part < 0.9 * all && part > 0.2 * all, "{part} of {all}");
    let lost = |scene: &str| {
        let history = last(&ran(scene));
        // The rest shape at the start has swollen by 10 times 1e-4 in one direction.
        let lost = 10.0 * 2e-7 * 1.001 - history["moisture_total_pct_m3"];
        let (rim, top) = (history["moisture_in_rim_pct_m3"], history["moisture_in_top_pct_m3"]);
        assert!((lost + rim).abs() < 1e-12 * 2e-6 && top == 0.0, "{lost} {rim} {top}");
        lost
    };
    assert!(lost(&drying) > 1e-8);
}

#[test]
fn heat_expands_by_its_own_name() {
    let law = "[rest.linear]\nmu = 0\nmu_perp = 1e-4\n";
    let scene = WETTED.replace("[moisture]", "[heat]").replace("[[moisture.", "[[heat.");
    let scene = with(&scene, law, "[rest.thermal]\nexpansion = 0\nexpansion_perp = 1e-4\n");
    let (warm, wet) = (ran(&scene), ran(WETTED));
    assert_eq!(positions(&warm), positions(&wet));
    assert!(last(&warm).contains_key("heat_total_Km3") && !last(&warm).contains_key("moisture_total_pct_m3"));
}

#[test]
fn prisms_are_exported_with_the_body_s_volume() {
    let sandbox = ran(&with(WETTED, "layers = 4", "layers = 4\nprisms = true"));
    let series = text(&std::fs::read(sandbox.case("vtk/moisture_prisms.pvd")).unwrap());
    assert_eq!(series.matches("<DataSet").count(), 11);
    let first = text(&std::fs::read(sandbox.case("vtk/moisture_prisms_00000000.vtu")).unwrap());
    assert!((volume(&sandbox.case("vtk/moisture_prisms_00000000.vtu")) / 2e-7 - 1.0).abs() < 1e-12);
    // Curled, the shell has its volume still, but for what the faces cut off.
    assert!((volume(&sandbox.case("vtk/moisture_prisms_00000010.vtu")) / 2e-7 - 1.0).abs() < 2e-3);
    assert!(first.contains("NumberOfPoints=\"75\"") && first.contains("NumberOfCells=\"64\"") && first.contains("\"moisture\""), "{first}");
    assert!(!ran(WETTED).case("vtk/moisture_prisms.pvd").exists());
}

/// Volume of the wedges of a file [m3]: a flipped one counts negative.
fn volume(path: &std::path::Path) -> f64 {
    use vtkio::model::{DataSet, Piece, VertexNumbers};
    let DataSet::UnstructuredGrid { pieces, .. } = vtkio::Vtk::import(path).unwrap().data else { panic!("not a grid") };
    let Piece::Inline(piece) = &pieces[0] else { panic!("not inline") };
    let points: Vec<f64> = piece.points.clone().cast_into().unwrap();
    let point = |i: usize| nalgebra::Vector3::new(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    let VertexNumbers::XML { connectivity, .. } = &piece.cells.cell_verts else { panic!("not XML") };
    let wedge = |nodes: &[u64]| {
        let p: Vec<_> = nodes.iter().map(|n| point(*n as usize)).collect();
        let area = |i: usize| (p[i + 1] - p[i]).cross(&(p[i + 2] - p[i])) * 0.5;
        let height = (0..3).map(|i| p[i + 3] - p[i]).sum::<nalgebra::Vector3<f64>>() / 3.0;
        // The first triangle's normal points out, away from the second one.
        -0.5 * (area(0) + area(3)).dot(&height)
    };
    connectivity.chunks_exact(6).map(wedge).sum()
}

#[test]
fn what_is_wrong_is_refused_with_its_key() {
    let cases: [(&str, &str, &[&str]); 27] = [
        ("value = 10", "exchange = { coefficient = 0, outside = 1 }", &["moisture.boundary.0.exchange.coefficient", "> 0"]),
        ("layers = 4", "layers = 4\ndt = 0", &["moisture.dt", "> 0"]),
        ("layers = 4", "layers = 4\ndt = 1e-12", &["moisture.dt", "steps"]),
        ("layers = 4", "layers = 4\nlevels = [0, 1]", &["moisture.layers", "`levels`"]),
        ("layers = 4", "layers = 4\ninitial = nan", &["moisture.initial"]),
        (
            "[statics]",
            "[[moisture.region]]\nregion = \"no\"\ndiffusivity = { through = 0, along = 0 }\n[statics]",
            &["moisture.region.0", "'no'"],
        ),
        (
            "[statics]",
            "[heat]\nadded_density = 1\ndiffusivity = { through = 0, along = 0 }\n[statics]",
            &["heat.added_density", "[moisture] only"],
        ),
        ("[rest.linear]", "[rest]\nramp = \"t\"\n[rest.linear]", &["rest.ramp", "[moisture]"]),
        ("[statics]", "[rest.thermal]\nexpansion = 1e-3\n[statics]", &["rest.thermal", "[heat]"]),
        ("value = 10", "value = 10\nfrom = -5\nuntil = -1", &["moisture.boundary.0.until", "after the start"]),
        ("value = 10", "value = 10\nflux = 1", &["moisture.boundary.0", "exactly one"]),
        ("value = 10", "value = \"1 / x\"", &["moisture", "vertex 0"]),
        ("side = \"top\"", "side = \"topp\"", &["moisture.boundary.0.side"]),
        ("side = \"top\"", "side = \"top\"\nregion = \"corner\"", &["moisture.boundary.0.region", "corner", "no faces"]),
        ("side = \"top\"", "side = \"rim\"\nregion = \"no\"", &["moisture.boundary.0.region", "'no'"]),
        ("value = 10", "value = 10\nfrom = 2\nuntil = 1", &["moisture.boundary.0.until"]),
        ("layers = 4", "layers = 0", &["moisture.layers"]),
        ("layers = 4", "levels = [0, 0.5, 0.4, 1]", &["moisture.levels", "ascend"]),
        ("layers = 4", "initial = \"ln(x)\"", &["moisture.initial", "vertex 0"]),
        ("through = 1e-7", "through = -1e-7", &["moisture.diffusivity.through"]),
        ("layers = 4", "added_density = 1000", &["moisture.added_density", "density"]),
        ("mu_perp = 1e-4", "mu_perp = -0.2", &["rest", "face", "%", "> 0"]),
        ("layers = 4", "initial = \"if(x > 0, -101, 0)\"", &["moisture.initial", "-101 %", "vertex 3", "bone dry"]),
        ("value = 10", "value = -101", &["moisture", "given value at vertex 0", "-101", "bone dry"]),
        ("value = 10", "exchange = { coefficient = 1e-6, outside = \"-1001 * t\" }", &["outside value", "vertex 0", "bone dry"]),
        ("mu = 0\n", "mu = 0\nm_plus = 1\n", &["rest.linear.m_plus", "[moisture]"]),
        ("end = 1.0", "", &["moisture", "needs time"]),
    ];
    for (from, to, words) in cases {
        // The law across the fibres sees the first values.
        let said = match to {
            // What depends on time and place is found on the way.
            _ if ["value = \"1 / x\"", "value = -101", "mu_perp = -0.2"].contains(&to) || to.contains("-1001 * t") => {
                let sandbox = Sandbox::new(&with(WETTED, from, to));
                let output = sandbox.output(&["all", "scene.toml"]);
                assert_eq!(output.status.code(), Some(2), "{to}");
                text(&output.stderr)
            }
            _ => refused(&with(WETTED, from, to)),
        };
        for word in words {
            assert!(said.contains(word), "{to}: `{word}` is not in {said}");
        }
    }
    let softened = with(WETTED, "layers = 4", "layers = 4\nstiffness = \"1 - u / 2\"");
    let sandbox = Sandbox::new(&softened);
    let output = sandbox.output(&["all", "scene.toml"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    assert!(said.contains("moisture") && said.contains("face") && said.contains("stiffness"), "{said}");
}

#[test]
fn every_key_survives_the_way_to_text_and_back() {
    let both = WETTED.replace("[statics]\nsteps = 10\nend = 1.0", "[dynamics]\ndt = 0.1\nend = 1.0");
    let boundaries = "[[moisture.boundary]]\nside = \"bottom\"\nregion = \"left\"\nflux = \"x * t\"\nfrom = 0.1\nuntil = 0.2\nbelow = 1e-3\n\
                      [[moisture.boundary]]\nside = \"rim\"\nexchange = { coefficient = 1e-6, outside = \"sin(t)\" }\n\
                      [[moisture.region]]\nregion = \"left\"\ndiffusivity = { through = 1e-9, along = 1e-8, across = 0 }\n\
                      [heat]\nlevels = [0, 0.1, 1]\nmass = \"consistent\"\nscheme = \"sdirk2\"\ndt = 0.01\nseen = \"faces\"\n\
                      initial = { field = \"warmth\", times = \"zeta\" }\nsource = \"x * zeta * t\"\nstiffness = \"exp(-u)\"\nprisms = true\n\
                      diffusivity = { through = 1e-9, along = 1e-8, across = 0 }\n\
                      [rest.thermal]\nexpansion = -1e-3\nexpansion_perp = 2e-3\n";
    let scene = with(&both, "[rest.linear]\n", &format!("{boundaries}[rest.linear]\nprofile = \"sides\"\n"));
    let scene = with(&scene, "layers = 4", "layers = 4\nspacing = \"uniform\"\nadded_density = 100\ninitial = \"x + zeta\"");
    let scene = with(&scene, "poissons_ratio = 0.3", "poissons_ratio = 0.3\ndensity = 1000.0");
    let read = thinshell::scene::parse("scene.toml", &scene, &[]).unwrap().0;
    let written = thinshell::scene::to_toml(&read);
    assert_eq!(thinshell::scene::parse("scene.toml", &written, &[]).unwrap().0, read, "{written}");
}

//! Measures as scenes ask for them, by the real program, on shapes whose answer is known.

use super::pipeline_support::Sandbox;
use serde_json::Value;
use std::collections::BTreeMap;

/// A cap of a sphere that nothing moves.
fn cap(element: &str, rings: usize) -> String {
    format!(
        r#"
[mesh.sphere-cap]
radius = 0.5
half_angle = 60
rings = {rings}
[[region]]
name = "inside"
where = "r < 0.2"
[shell]
element = "{element}"
thickness = 1e-3
youngs_modulus = 1e9
poissons_ratio = 0.3
[[pin]]
region = "rim"
[statics]
steps = 1
"#
    )
}

/// A strip that curls into a quarter of a cylinder.
const CURL: &str = r#"
[mesh.rectangle]
size = [0.06, 0.02]
cells = [6, 2]
[[region]]
name = "origin"
nearest = [0.0, 0.0, 0.0]
[[region]]
name = "side"
nearest = [0.0, 0.02, 0.0]
[[region]]
name = "ahead"
nearest = [0.01, 0.0, 0.0]
[shell]
thickness = 1e-3
youngs_modulus = 1e9
poissons_ratio = 0.3
[rest.pullback]
bbar = ["0.5 * PI / 0.06", 0, 0]
[[pin]]
region = "origin"
[[pin]]
region = "side"
components = ["x", "z"]
[[pin]]
region = "ahead"
components = ["z"]
[statics]
steps = 4
"#;

/// Values of the measures at a time or at the end, by the place in the list.
fn measured(scene: &str, measures: &[(&str, Option<f64>)]) -> Vec<f64> {
    let mut text = scene.to_owned();
    for (i, (measure, time)) in measures.iter().enumerate() {
        let time = time.map_or(String::new(), |t| format!("time = {t}\n"));
        text +=
            &format!("[[report.expect]]\nname = \"{i}\"\nmeasure = {measure}\nreference = 0\ntolerance = 1e300\nsource = \"none\"\n{time}");
    }
    let sandbox = Sandbox::new(&text);
    sandbox.ok(&["all", "scene.toml", "-q"]);
    let report: Value = serde_json::from_str(&std::fs::read_to_string(sandbox.case("report.json")).unwrap()).unwrap();
    let values: BTreeMap<usize, f64> = report["expectations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| (e["name"].as_str().unwrap().parse().unwrap(), e["value"].as_f64().unwrap()))
        .collect();
    values.into_values().collect()
}

fn near(found: f64, exact: f64, relative: f64) {
    assert!((found / exact - 1.0).abs() < relative, "{found} is not {exact}");
}

#[test]
fn a_sphere_at_rest() {
    for element in ["linear", "quadratic"] {
        let values = measured(
            &cap(element, 12),
            &[
                ("{ curvature-square = { of = 'mean' } }", None),
                ("{ curvature-square = { of = 'gauss', weighting = 'area' } }", None),
                ("{ curvature-square = { of = 'mean', weighting = 'sum' } }", None),
                ("{ curvature-square = { of = 'gauss', weighting = 'sum' } }", None),
                ("{ waves = { region = 'rim' } }", None),
                ("{ wave-amplitude = { region = 'rim' } }", None),
                ("{ energy = { over = 'E * h^3' } }", None),
                ("{ surface-distance = { position = ['x', 'y', 'sqrt(0.25 - r^2)'] } }", None),
                ("{ surface-distance = { position = ['x', 'y', 'sqrt(0.25 - r^2)'], kind = 'hausdorff' } }", None),
                ("{ distance-between = { a = [0.433, 0, 0.25], b = [-0.433, 0, 0.25] } }", None),
                ("{ field = { name = 'mean-curvature', statistic = 'median' } }", None),
                ("{ field = { name = 'mean-curvature', statistic = 'mean', region = 'inside' } }", None),
                ("{ field = { name = 'displacement', statistic = 'median', region = 'inside' } }", None),
            ],
        );
        // Twelve rings have 3 * 12 * 13 + 1 vertices, and 24 rings as many as twelve have nodes.
        let nodes = if element == "linear" { 469.0 } else { 1801.0 };
        eprintln!("{values:?}");
        // A fit's error is of second order in the distance of nodes, and larger at the rim, where neighbours lie on one side.
        let error = if element == "linear" { 0.04 } else { 0.01 };
        near(values[0], 4.0, 0.5 * error);
        near(values[1], 16.0, error);
        near(values[2], 4.0 * nodes, 0.5 * error);
        near(values[3], 16.0 * nodes, error);
        assert!(values[4] == 0.0 && values[5] == 0.0 && values[6].abs() < 1e-12, "{values:?}");
        // Where r is taken the square root of, rounding is a little larger.
        assert!(values[7] < 1e-12, "{values:?}");
        let (sag, deep) = (0.5 * (1.0 - (0.5 * 60f64.to_radians() / 12.0).cos()), 1e-5);
        let bound = if element == "linear" { 2.0 * sag } else { deep };
        assert!(values[8] > 1e-9 && values[8] < bound, "{values:?}");
        near(values[9], 2.0 * 0.5 * 60f64.to_radians().sin(), 1e-12);
        near(values[10], -2.0, error);
        near(values[11], -2.0, error);
        assert!(values[12].abs() < 1e-12, "{values:?}");
    }
}

#[test]
fn a_region_restricts_statistics() {
    // Thickness is a field of the faces that differs between regions.
    let scene = CURL.replace("[rest.pullback]", "[[shell.region]]\nregion = \"far\"\nthickness = 2e-3\n[rest.pullback]");
    let scene = scene.replace("[shell]\n", "[[region]]\nname = \"far\"\nwhere = \"x > 0.02\"\n[shell]\n");
    let field = |statistic: &str, region: &str| format!("{{ field = {{ name = 'thickness', statistic = '{statistic}'{region} }} }}");
    let measures =
        [field("mean", ""), field("median", ""), field("min", ", region = 'far'"), field("min", ""), field("median", ", region = 'far'")];
    let measures: Vec<_> = measures.iter().map(|m| (m.as_str(), None)).collect();
    let values = measured(&scene, &measures);
    near(values[0], (1e-3 + 2.0 * 2e-3) / 3.0, 1e-9);
    for (value, exact) in values[1..].iter().zip([2e-3, 2e-3, 1e-3, 2e-3]) {
        near(*value, exact, 1e-12);
    }
}

#[test]
fn a_curled_strip() {
    let radius = 0.06 / (0.5 * std::f64::consts::PI);
    let position = format!("['{radius} * sin(x / {radius})', 'y', '{radius} * (1 - cos(x / {radius}))']");
    let values = measured(
        CURL,
        &[
            (&format!("{{ cylinder-distance = {{ radius = {radius} }} }}"), None),
            (&format!("{{ surface-distance = {{ position = {position} }} }}"), None),
            (&format!("{{ surface-distance = {{ position = {position}, kind = 'hausdorff' }} }}"), None),
            ("{ energy = {} }", None),
            ("{ energy = { part = 'bending' } }", None),
            ("{ energy = { part = 'membrane' } }", None),
            ("{ energy-ratio = {} }", None),
            ("{ energy = { over = 'E * h^3 * (1 - nu^2)' } }", None),
            ("{ history = { column = 'bending_energy_J' } }", None),
            ("{ energy = { part = 'bending' } }", Some(0.5)),
            ("{ energy = {} }", Some(0.0)),
            ("{ energy-ratio = { part = 'bending' } }", Some(0.5)),
        ],
    );
    // The map is that of the other measure, which is relative to the length; nodes are the worst places of this shape.
    near(values[1], 0.06 * values[0], 1e-6);
    assert!(values[2] < 1.5 * values[1] && values[2] > 0.1 * values[1], "{values:?}");
    near(values[3], values[4] + values[5], 1e-12);
    near(values[4], values[8], 1e-6);
    // Flat in the rest forms of the end: E h^3 / 24 / (1 - nu^2) k^2 times the area; half of the growth has a quarter of it.
    let curvature = 1.0 / radius;
    let flat = 1e9 * 1e-9 / 24.0 / (1.0 - 0.09) * curvature * curvature * 0.06 * 0.02;
    near(values[6], values[3] / flat, 1e-9);
    assert!(values[6] < 1e-4, "{values:?}");
    near(values[7], values[3] / (1.0 - 0.09), 1e-12);
    assert_eq!(values[10], 0.0);
    near(values[11], values[9] / (0.25 * flat), 1e-9);
}

/// A flat square of side 1 whose original shape was larger by a tenth, as a mesh file with a field of that name.
fn flattened(field: &str) -> Sandbox {
    let mut file = String::from("# vtk DataFile Version 3.0\nflattened\nASCII\nDATASET POLYDATA\nPOINTS 9 double\n");
    let places: Vec<[f64; 2]> = (0..9).map(|i| [0.5 * f64::from(i % 3), 0.5 * f64::from(i / 3)]).collect();
    places.iter().for_each(|[x, y]| file += &format!("{x} {y} 0\n"));
    file += "POLYGONS 8 32\n";
    for corner in [0, 1, 3, 4] {
        file += &format!("3 {} {} {}\n3 {} {} {}\n", corner, corner + 1, corner + 4, corner, corner + 4, corner + 3);
    }
    file += &format!("POINT_DATA 9\nVECTORS {field} double\n");
    // Turned by a right angle and moved far away, which the fit takes back.
    places.iter().for_each(|[x, y]| file += &format!("7 {} {}\n", 1.1 * x, 1.1 * y));
    let scene = r#"
[mesh.file]
path = "flat.vtk"
[[region]]
name = "all"
where = "1"
[shell]
element = "linear"
thickness = 1e-3
youngs_modulus = 1e9
poissons_ratio = 0.3
[[pin]]
region = "all"
[statics]
steps = 1
"#;
    let expect = |name: &str, measure: &str, reference: f64| {
        format!(
            "[[report.expect]]\nname = '{name}'\nmeasure = {{ original-distance = {measure} }}\nreference = {reference}\ntolerance = 1e-9\nsource = 'exact'\n"
        )
    };
    let corner = 0.05 * 2f64.sqrt();
    let text = scene.to_owned()
        + &expect("nodes", "{}", corner)
        + &expect("relative", "{ over = 2.0 }", 0.5 * corner)
        + &expect("surface", "{ kind = 'hausdorff', mirror = true }", corner);
    let sandbox = Sandbox::new(&text);
    std::fs::write(sandbox.path("flat.vtk"), file).unwrap();
    sandbox
}

#[test]
fn a_flattened_mesh_knows_its_original_shape() {
    flattened("original_position").ok(&["all", "scene.toml", "-q"]);
    let message = flattened("another").fails(2, &["all", "scene.toml", "-q"]);
    assert!(message.contains("report.expect.0.measure.original-distance = {}: there is no field 'original_position'"), "{message}");
    assert!(message.contains("the mesh has: another"), "{message}");
}

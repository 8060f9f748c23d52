//! Right scenes: defaults, overrides, the way back to text, and values that look like a slip of the unit.

use thinshell::Error;
use thinshell::scene::{self, Expr, MeshTable, PinDirector, Scene};

const FULL: &str = include_str!("full.toml");
const SMALLEST: &str =
    "[mesh.disc]\nradius = 1\nrings = 3\n[shell]\nthickness = 1e-3\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n[statics]\n";

const MESHES: [&str; 8] = [
    "rectangle = { size = [1, 2], cells = [3, 4], pattern = \"delaunay\", seed = 7, triangulation = { size = 0.1 } }",
    "disc = { radius = 1, rings = 3 }",
    "annulus = { radii = [1, 2], cells = [1, 3], slit = true }",
    "cylinder = { radius = 1, length = 1, angle = 90, cells = [1, 1], pattern = \"alternating\" }",
    "sphere-cap = { radius = 1, half_angle = 90, rings = 2 }",
    "outline = { points = [[0, 0], [9, 0], [0, 9]], holes = [[[1, 1], [2, 1], [1, 2]]], triangulation = { size = 1 } }",
    "outline = { file = \"a/b.csv\", triangulation = { size = 1 } }\n[flatten]\nonto = \"disc\"\nradius = 2.5",
    "file = { path = \"a/b.obj\", scale = 0.001 }",
];

fn parse(text: &str, overrides: &[&str]) -> Result<Scene, Error> {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    scene::parse("scene.toml", text, &overrides).map(|(scene, _)| scene)
}

#[test]
fn text_is_lost_by_no_scene() {
    let meshes = MESHES.iter().map(|mesh| SMALLEST.replace("[mesh.disc]\nradius = 1\nrings = 3", &format!("[mesh]\n{mesh}")));
    for text in meshes.chain([FULL.to_owned(), SMALLEST.to_owned()]) {
        let read = parse(&text, &[]).unwrap();
        let written = scene::to_toml(&read);
        assert_eq!(parse(&written, &[]).unwrap(), read, "{written}");
    }
    let written = scene::to_toml(&parse(SMALLEST, &[]).unwrap());
    for default in ["steps = 4", "tolerance = ", "max_iterations = 25", "director = \"free-tan\"", "mass = \"consistent\""] {
        assert!(written.contains(default), "{default} is not in {written}");
    }
}

#[test]
fn overrides_set_what_they_name() {
    let overrides = [
        "shell.thickness=1e-4",
        "mesh.rectangle.cells=[40, 8]",
        "mesh.rectangle.cells.1=9",
        "pin.0.region=bottom",
        "pin.1.components=['x']",
        "rest.ramp=t^2",
        "report.expect.0.measure.displacement.at.2=0.5",
        "solver.max_halvings = 3",
        "gravity.acceleration=[1, 2, 3]",
    ];
    let scene = parse(FULL, &overrides).unwrap();
    assert_eq!(scene.shell.thickness, 1e-4);
    let MeshTable::Rectangle(rectangle) = &scene.mesh else { panic!("not a rectangle") };
    assert_eq!(rectangle.cells, [40, 9]);
    assert_eq!(scene.pins[0].region, "bottom");
    assert_eq!(scene.pins[1].components.len(), 1);
    assert_eq!(scene.pins[1].director, Some(PinDirector::Symmetry([1.0, 0.0, 0.0])));
    assert_eq!(scene.rest.unwrap().ramp, Some(Expr::Text("t^2".to_owned())));
    assert_eq!(scene.solver.max_halvings, 3);
    assert_eq!(scene.solver.tolerance, 1e-8);
    assert_eq!(scene.gravity.unwrap().acceleration, [1.0, 2.0, 3.0].map(Expr::Number));
    // Tables that are not there are made, and the text shows them.
    let (scene, source) = scene::parse("s", SMALLEST, &["output.interval=2".to_owned()]).unwrap();
    assert_eq!(scene.output.interval, Some(2.0));
    assert_eq!(parse(source.text(), &[]).unwrap(), scene);
    let (_, source) = scene::parse("s", FULL, &["shell.thickness=1e-4".to_owned()]).unwrap();
    assert!(source.text().contains("thickness = 1e-4 # one millimetre"), "{}", source.text());
}

#[test]
fn wrong_overrides_are_named() {
    for (text, expected) in [
        ("shell.thickness", "`key=value` expected"),
        ("=1", "names joined by dots"),
        ("shell..thickness=1", "names joined by dots"),
        ("shell.thickness=", "no value"),
        ("shell.thickness=[1", "unclosed array"),
        ("shell.thickness=-1", "shell.thickness = -1 (from --set): must be > 0 [m]"),
        ("shell.thicknes=1", "shell.thicknes (from --set): unknown key"),
        ("shell.thickness=thin", "expected a number, found string \"thin\""),
        ("shell.thickness.x=1", "`shell.thickness` is a float, it has no keys"),
        ("pin.2.region=left", "`pin` has 2 entries"),
        ("pin.left.region=left", "`pin` has 2 entries"),
        ("mesh.disc.radius=1", "exactly one kind"),
        ("report.expect.0.measure.displacement.at.1=nan", "report.expect.0.measure.displacement.at"),
        ("shell=1", "shell = 1 (from --set): expected a table"),
        (&format!("{}x=1", "a.".repeat(1000)), "names joined by dots"),
    ] {
        let error = parse(FULL, &[text]).unwrap_err();
        assert!(matches!(error, Error::Scene(_)) && error.to_string().contains(expected), "{text}: {error}");
        assert_eq!(error.exit_code(), 2);
    }
    let error = parse(FULL, &["solver.max_halvings=3", "shell.thickness=-1"]).unwrap_err();
    let Error::Scene(error) = error else { panic!("{error}") };
    let place = error.span.unwrap();
    assert_eq!((error.text.name(), &error.text.inner()[place.offset()..]), ("--set", "-1"));
}

#[test]
fn slips_of_the_unit_are_suspected() {
    assert_eq!(scene::suspicions(&parse(FULL, &[]).unwrap()), Vec::<String>::new());
    for (text, key) in [
        ("shell.thickness=0.3", "shell.thickness"),
        ("shell.thickness=0.021", "shell.thickness"),
        ("shell.region.0.thickness=0.021", "shell.region.0.thickness"),
        ("shell.youngs_modulus=3", "shell.youngs_modulus"),
        ("shell.youngs_modulus=1e14", "shell.youngs_modulus"),
        ("shell.density=0.08", "shell.density"),
        ("shell.density=1e6", "shell.density"),
        ("mesh.rectangle.size=[2000, 3000]", "mesh"),
        ("dynamics.dt=2", "dynamics.dt"),
    ] {
        let found = scene::suspicions(&parse(FULL, &[text]).unwrap());
        assert!(found.len() == 1 && found[0].contains(key), "{text}: {found:?}");
    }
}

//! Materials from the scene to the report: each runs, is what the setup keeps, bends as it should, and wrong ones are refused.

use crate::physics_case::{run, set_up};
use crate::pipeline_support::{STATIC, Sandbox, text, with};
use thinshell::shell::Constitution;
use thinshell::stage;

/// A machine direction at an angle from the x axis.
fn fibres(degrees: f64) -> String {
    format!("[machine-direction]\nangle = {degrees:?}\n")
}

/// A cantilever of width 1 under a small force at its end: its rigidity times 12 over the cube of the thickness [Pa], by the end's deflection.
fn modulus(element: &str, material: &str, rest: &str) -> f64 {
    let (length, h, force) = (10.0f64, 0.1f64, 3e-4);
    let cells = if element == "linear" { "[40, 4]" } else { "[10, 1]" };
    let case = run(&format!(
        "[mesh.rectangle]\nsize = [{length:?}, 1.0]\ncells = {cells}\n[solver]\ntolerance = 1e-13\n\
         [shell]\nelement = \"{element}\"\nthickness = {h}\n{material}\
         [[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[[edge-load]]\nregion = \"right\"\nforce = [0, 0, {force:?}]\n{rest}[statics]\nsteps = 1\n"
    ));
    let tip: Vec<f64> =
        case.mesh.nodes().iter().zip(&case.end).filter(|(p, _)| (p.x - length).abs() < 1e-9).map(|(p, q)| q.z - p.z).collect();
    let mean = tip.iter().sum::<f64>() / tip.len() as f64;
    let (work, stored) = (-case.last("edge_load_energy_J"), case.last("membrane_energy_J") + case.last("bending_energy_J"));
    assert!((stored / work - 0.5).abs() < 1e-4, "{material}: {stored} {work}");
    force * length.powi(3) / (3.0 * mean) * 12.0 / h.powi(3)
}

/// A narrow strip bends by Young's modulus along it: `E1` with the fibres, `E2` across them, the compliance turned by the angle between.
#[test]
fn an_orthotropic_cantilever_bends_by_the_modulus_along_it() {
    let (e1, e2, nu, g) = (5e6f64, 1.25e6f64, 0.3f64, 0.9e6f64);
    let material = format!("orthotropic = {{ youngs_moduli = [{e1:?}, {e2:?}], poissons_ratio = {nu}, shear_modulus = {g:?} }}\n");
    for (element, tolerance) in [("linear", 0.01), ("quadratic", 0.01)] {
        for (degrees, expected) in [(0.0, e1), (90.0, e2)] {
            let found = modulus(element, &material, &fibres(degrees));
            println!("{element} {degrees}: {found} {expected}");
            assert!((found / expected - 1.0).abs() < tolerance, "{element} {degrees}: {found} {expected}");
        }
        // Obliquely the strip twists as it bends, which the mean deflection of its end does not show.
        let (s, c) = 30f64.to_radians().sin_cos();
        let compliance = c.powi(4) / e1 + s.powi(4) / e2 + s * s * c * c * (1.0 / g - 2.0 * nu / e1);
        let found = modulus(element, &material, &fibres(30.0));
        println!("{element} 30: {found} {}", 1.0 / compliance);
        assert!((found * compliance - 1.0).abs() < 0.05, "{element}: {found} {}", 1.0 / compliance);
    }
}

/// A wide strip that cannot bend across: `E1 / (1 - nu12 nu21)`.
#[test]
fn an_orthotropic_plate_bends_by_its_plate_modulus() {
    let (e1, e2, nu, g) = (5e6f64, 1.25e6f64, 0.6f64, 0.9e6f64);
    for (degrees, along) in [(0.0, e1), (90.0, e2)] {
        // The sides are planes of symmetry: of an endless plate.
        let side = |name: &str, place: &str| {
            format!(
                "[[region]]\nname = \"{name}\"\nwhere = \"{place}\"\n[[pin]]\nregion = \"{name}\"\ncomponents = [\"y\"]\ndirector = {{ symmetry = [0, 1, 0] }}\n"
            )
        };
        let sides = side("low", "y < 1e-9") + &side("high", "y > 1 - 1e-9");
        let material = format!("orthotropic = {{ youngs_moduli = [{e1:?}, {e2:?}], poissons_ratio = {nu}, shear_modulus = {g:?} }}\n");
        let found = modulus("quadratic", &material, &format!("{sides}{}", fibres(degrees)));
        let expected = along / (1.0 - nu * nu * e2 / e1);
        assert!((found / expected - 1.0).abs() < 5e-3, "{degrees}: {found} {expected}");
    }
}

/// Two layers: the modulus of the beam about its neutral axis, which lies off the middle.
#[test]
fn a_bilayer_cantilever_bends_about_its_neutral_axis() {
    let (top, e) = (0.03f64, [4e6, 1e6]);
    let t = [top, 0.1 - top];
    // Heights of the layers' middles over the bottom.
    let y = [t[1] + 0.5 * t[0], 0.5 * t[1]];
    let axis = (e[0] * t[0] * y[0] + e[1] * t[1] * y[1]) / (e[0] * t[0] + e[1] * t[1]);
    let rigidity: f64 = (0..2).map(|k| e[k] * (t[k].powi(3) / 12.0 + t[k] * (y[k] - axis).powi(2))).sum();
    let expected = rigidity * 12.0 / 0.1f64.powi(3);
    let material = format!(
        "poissons_ratio = 0.0\nbilayer = {{ top_thickness = {top}, top = {{ youngs_modulus = {:?} }}, bottom = {{ youngs_modulus = {:?} }} }}\n",
        e[0], e[1]
    );
    for element in ["linear", "quadratic"] {
        let found = modulus(element, &material, "");
        assert!((found / expected - 1.0).abs() < 5e-3, "{element}: {found} {expected}");
    }
}

#[test]
fn rubber_and_cloth_bend_like_the_plain_material_at_small_strain() {
    for material in ["material = \"neo-hookean\"\n", "material = \"tension-field\"\ncompression = 0.5\n"] {
        let [found, plain] =
            [material, ""].map(|m| modulus("quadratic", &format!("youngs_modulus = 1.2e6\npoissons_ratio = 0.3\n{m}"), ""));
        assert!((found / plain - 1.0).abs() < 1e-3, "{material}: {found} {plain}");
    }
}

const RUBBER: &str = "[mesh.rectangle]\nsize = [1.0, 0.5]\ncells = [4, 2]\njitter = 0.2\n[solver]\ntolerance = 1e-12\n\
    [shell]\nelement = \"ELEMENT\"\nthickness = 0.05\nyoungs_modulus = 1e6\npoissons_ratio = 0.45\nmaterial = \"neo-hookean\"\n\
    [[region]]\nname = \"low\"\nwhere = \"y < 1e-9\"\n[[region]]\nname = \"all\"\nwhere = \"x > -1\"\n\
    [[pin]]\nregion = \"left\"\ncomponents = [\"x\"]\n[[pin]]\nregion = \"low\"\ncomponents = [\"y\"]\n[[pin]]\nregion = \"all\"\ncomponents = [\"z\"]\n\
    [[pin]]\nregion = \"right\"\ncomponents = [\"x\"]\nmotion = { x = \"t\" }\n[statics]\nsteps = 4\n";

/// Pulled to twice its length, a sheet of rubber becomes as narrow and stores as much as the exact solution says.
#[test]
fn a_rubber_sheet_is_pulled_to_twice_its_length() {
    let (e, nu, l) = (1e6, 0.45, 2.0f64);
    let (mu, lambda) = (e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
    let (mut low, mut high) = (0.1, 2.0);
    for _ in 0..100 {
        let s: f64 = 0.5 * (low + high);
        if mu * (s * s - 1.0) + lambda * (l * s * s).ln() > 0.0 { high = s } else { low = s }
    }
    let j: f64 = (l * low * low).ln();
    let exact = 0.5 * 0.05 * (0.5 * mu * (l * l + 2.0 * low * low - 3.0 - 2.0 * j) + 0.5 * lambda * j * j);
    for element in ["linear", "quadratic"] {
        let case = run(&RUBBER.replace("ELEMENT", element));
        let narrow = case.vertex(1.0, 0.5, 0.0).1.y / 0.5;
        assert!((narrow - low).abs() < 1e-9, "{element}: {narrow} {low}");
        let stored = case.last("membrane_energy_J") + case.last("bending_energy_J");
        assert!((stored / exact - 1.0).abs() < 1e-9, "{element}: {stored} {exact}");
        assert!(case.last("bending_energy_J").abs() < 1e-12 * exact);
    }
}

/// A sheet that is sheared flat wrinkles: with no stiffness in compression it stores less than St. Venant-Kirchhoff, and more than nothing.
#[test]
fn a_sheared_tension_field_stores_the_energy_of_its_tension() {
    let scene = |material: &str| {
        format!(
            "[mesh.rectangle]\nsize = [1.0, 1.0]\ncells = [4, 4]\n[shell]\nelement = \"linear\"\nthickness = 1e-3\nyoungs_modulus = 1e6\npoissons_ratio = 0.3\n{material}\
             [[region]]\nname = \"all\"\nwhere = \"x > -1\"\n[[region]]\nname = \"rim\"\nwhere = \"x < 1e-9 || y < 1e-9 || x > 1 - 1e-9 || y > 1 - 1e-9\"\n\
             [[pin]]\nregion = \"all\"\ncomponents = [\"z\"]\n[[pin]]\nregion = \"rim\"\ncomponents = [\"x\"]\nmotion = {{ x = \"0.1 * y * t\" }}\n\
             [[pin]]\nregion = \"rim\"\ncomponents = [\"y\"]\n[statics]\nsteps = 2\n"
        )
    };
    // Green strain [[0, g/2], [g/2, g^2/2]] all over.
    let (e, nu, h, c, g) = (1e6, 0.3, 1e-3, 0.01, 0.1f64);
    let radius = (0.25 * g * g).hypot(0.5 * g);
    let (e1, e2) = (0.25 * g * g + radius, 0.25 * g * g - radius);
    let psi = h * e / (2.0 * (1.0 - nu * nu)) * (e1 * e1 + e2 * e2 + 2.0 * nu * e1 * e2);
    assert!(e2 < -nu * e1);
    let taut = run(&scene("")).last("membrane_energy_J");
    let wrinkled = run(&scene("material = \"tension-field\"\ncompression = 0.01\n")).last("membrane_energy_J");
    assert!((taut / psi - 1.0).abs() < 1e-9, "{taut} {psi}");
    let expected = (1.0 - c) * 0.5 * e * h * e1 * e1 + c * psi;
    assert!((wrinkled / expected - 1.0).abs() < 1e-9, "{wrinkled} {expected}");
}

/// All verbs on a small scene of each material, at rest and in motion with viscosity, through restart, export and report.
#[test]
fn every_material_goes_through_all_verbs() {
    let still = with(STATIC, "steps = 8", "steps = 2");
    let moving = with(&with(&still, "density", "viscosity = 0.01\ndensity"), "[statics]\nsteps = 2", "[dynamics]\ndt = 0.02\nend = 0.06");
    for material in [
        "lame = \"three-d\"",
        "bilayer = { top_thickness = 3e-4, top = { youngs_modulus = 3e8 } }",
        "material = \"neo-hookean\"",
        "material = \"tension-field\"\ncompression = 0.1",
        "[[shell.region]]\nregion = \"far\"\nmaterial = \"neo-hookean\"",
    ] {
        for scene in [&still, &moving] {
            for element in ["linear", "quadratic"] {
                let region = "[[region]]\nname = \"far\"\nwhere = \"x > 0.03\"\n";
                let place = if material.starts_with('[') { "[rest.pullback]" } else { "density" };
                let scene = with(&with(scene, place, &format!("{material}\n{place}")), "[gravity]", &format!("{region}[gravity]"));
                let sandbox = Sandbox::new(&with(&scene, "element = \"linear\"", &format!("element = \"{element}\"")));
                let output = sandbox.output(&["all", "scene.toml"]);
                let message = text(&output.stderr);
                assert_eq!(output.status.code(), Some(0), "{material}: {message}");
                assert_eq!(message.contains("too stiff"), material.contains("three-d"), "{message}");
                let whole = sandbox.result();
                sandbox.ok(&["run", "scene.toml", "--restart", "--stop-after", "1", "-q"]);
                sandbox.ok(&["run", "scene.toml", "-q"]);
                assert!(whole == sandbox.result(), "{material}: a run that was stopped is another");
            }
        }
    }
}

/// What the setup keeps comes back bit by bit, and of the default nothing is kept.
#[test]
fn the_setup_keeps_the_laws() {
    let region = "[[region]]\nname = \"far\"\nwhere = \"x > 0.03\"\n[[region]]\nname = \"near\"\nwhere = \"x < 0.01\"\n";
    let scene = with(STATIC, "[rest.pullback]\nbbar = [\"30 * t\", 0, \"10 * x\"]\n", &format!("{region}{}", fibres(30.0)));
    let law = "orthotropic = { youngs_moduli = [3e8, 1.1e8], poissons_ratio = 0.3, shear_modulus = 0.7e8 }";
    let regions = "[[shell.region]]\nregion = \"far\"\nbilayer = { top_thickness = 0.3e-3, bottom = { poissons_ratio = 0.1 } }\n\
        [[shell.region]]\nregion = \"near\"\nthickness = 0.7e-3\nmaterial = \"tension-field\"\n";
    for (scene, kept) in [(with(&scene, "[gravity]", &format!("{regions}[gravity]")), true), (scene.clone(), false)] {
        let scene = if kept { with(&scene, "youngs_modulus", &format!("{law}\nyoungs_modulus")) } else { scene };
        let (_, made, _) = set_up(&scene).unwrap();
        let sandbox = Sandbox::new(&scene).prepared();
        let has = hdf5::File::open(sandbox.case("setup.h5")).unwrap().member_names().unwrap().join(" ").contains("constitution");
        assert_eq!((has, made.constitutions.is_empty()), (kept, !kept));
        let file = sandbox.path("scene.toml");
        let job = stage::Job::read(&file, Some(&sandbox.case("")), &[], true).unwrap();
        let (loaded, _) = stage::setup::load(&job).unwrap();
        assert_eq!(loaded.materials, made.materials);
        assert_eq!(loaded.constitutions, made.constitutions);
        if kept {
            let count = |is: fn(&Constitution) -> bool| made.constitutions.iter().filter(|c| is(c)).count();
            let kinds = [
                count(|c| matches!(c, Constitution::Orthotropic(_))),
                count(|c| matches!(c, Constitution::Bilayer(b) if b.youngs_moduli == [1e8; 2] && b.poissons_ratios == [0.3, 0.1])),
                count(|c| *c == Constitution::TensionField { compression: 1e-3 }),
            ];
            assert_eq!(kinds, [8, 12, 4], "{:?}", made.constitutions);
        }
    }
}

/// Parts of a scene that say what the shell is made of, and what is wrong with them.
const WRONG: &[(&str, &str)] = &[
    ("thickness = 0.1", "shell.youngs_modulus: this key is missing"),
    ("thickness = 0.1\nyoungs_modulus = 1e6", "shell.poissons_ratio: this key is missing"),
    ("thickness = 0.1\nE\nmaterial = \"rubber\"", "shell.material = \"rubber\": `rubber` is not a choice here"),
    ("thickness = 0.1\nE\nlame = \"2d\"", "shell.lame = \"2d\": `2d` is not a choice here"),
    (
        "thickness = 0.1\nE\nmaterial = \"neo-hookean\"\nlame = \"three-d\"",
        "shell.lame = \"three-d\": exists for `stvk` only, not for `neo-hookean`",
    ),
    ("thickness = 0.1\nE\ncompression = 0.1", "shell.compression = 0.1: exists for `tension-field` only"),
    ("thickness = 0.1\nE\nmaterial = \"tension-field\"\ncompression = 0", "shell.compression = 0: must be > 0 and <= 1"),
    ("thickness = 0.1\nE\nmaterial = \"tension-field\"\ncompression = 1.1", "shell.compression = 1.1: must be > 0 and <= 1"),
    ("thickness = 0.1\nWOOD\nmaterial = \"neo-hookean\"", "exists for `stvk` only, not for `neo-hookean`"),
    ("thickness = 0.1\nWOOD\nlame = \"three-d\"", "shell.lame = \"three-d\": has no meaning with `orthotropic` or `bilayer`"),
    (
        "thickness = 0.1\nE\nWOOD\nbilayer = { top_thickness = 0.05 }",
        "shell.bilayer = { top_thickness = 0.05 }: cannot be combined with `orthotropic`",
    ),
    ("thickness = 0.1\nWOOD", "shell.orthotropic: needs the table [machine-direction]"),
    (
        "thickness = 0.1\northotropic = { youngs_moduli = [1e6, 4e6], poissons_ratio = 0.5, shear_modulus = 1e6 }",
        "|nu12| < sqrt(E1 / E2) = 0.5 is violated (E1 = 1e6 Pa, E2 = 4e6 Pa)",
    ),
    (
        "thickness = 0.1\northotropic = { youngs_moduli = [1e6, 0], poissons_ratio = 0.5, shear_modulus = 1e6 }",
        "shell.orthotropic.youngs_moduli.1 = 0: must be > 0 [Pa]",
    ),
    (
        "thickness = 0.1\northotropic = { youngs_moduli = [1e6, 1e6], poissons_ratio = 0.5, shear_modulus = -1 }",
        "shell.orthotropic.shear_modulus = -1: must be > 0 [Pa]",
    ),
    (
        "thickness = 0.1\northotropic = { youngs_moduli = [1e6, 1e6], poissons_ratio = nan, shear_modulus = 1 }",
        "shell.orthotropic.poissons_ratio = nan: must be finite",
    ),
    (
        "thickness = 0.1\nE\n[[shell.region]]\nregion = \"far\"\northotropic = { youngs_moduli = [1e6, 4e6], poissons_ratio = -0.6, shear_modulus = 1e6 }",
        "|nu12| < sqrt(E1 / E2) = 0.5 is violated (E1 = 1e6 Pa, E2 = 4e6 Pa) (region 'far')",
    ),
    ("thickness = 0.1\nE\n[[shell.region]]\nregion = \"far\"\nyoungs_modulus = -1", "shell.region.0.youngs_modulus = -1: must be > 0 [Pa]"),
    (
        "thickness = 0.1\nE\n[[shell.region]]\nregion = \"far\"\npoissons_ratio = 0.5",
        "shell.region.0.poissons_ratio = 0.5: must be > -1 and < 0.5",
    ),
    (
        "thickness = 0.1\nE\nbilayer = { top_thickness = 0.1 }",
        "shell.bilayer.top_thickness = 0.1: must be less than the thickness of the shell there, 0.1 m",
    ),
    ("thickness = 0.1\nE\nbilayer = { top_thickness = 0 }", "shell.bilayer.top_thickness = 0: must be > 0 [m]"),
    (
        "thickness = 0.1\nE\nbilayer = { top_thickness = 0.05, top = { poissons_ratio = 0.5 } }",
        "shell.bilayer.top.poissons_ratio = 0.5: must be > -1 and < 0.5",
    ),
    ("thickness = 0.1\nE\nbilayer = { top_thickness = 0.05, middle = {} }", "shell.bilayer.middle: unknown key"),
    (
        "thickness = 0.1\nbilayer = { top_thickness = 0.05, top = { youngs_modulus = 1e6, poissons_ratio = 0.3 } }",
        "shell.youngs_modulus: this key is missing, and a layer without its own needs it",
    ),
    (
        "thickness = 0.1\nE\nmaterial = \"neo-hookean\"\n[[shell.region]]\nregion = \"far\"\nlame = \"three-d\"",
        "shell.region.0.lame = \"three-d\": exists for `stvk` only, not for `neo-hookean` (region 'far')",
    ),
    (
        "thickness = 0.1\nE\nbilayer = { top_thickness = 0.05 }\n[[shell.region]]\nregion = \"far\"\nthickness = 0.02",
        "must be less than the thickness of the shell there, 0.02 m (region 'far')",
    ),
    (
        "thickness = 0.1\nE\n[[shell.region]]\nregion = \"far\"\nthickness = 0.02\n[[shell.region]]\nregion = \"tip\"\nbilayer = { top_thickness = 0.05 }",
        "shell.region.1.bilayer.top_thickness: must be less than the thickness of the shell there, 0.02 m (region 'tip')",
    ),
    (
        "thickness = 0.1\nE\n[[shell.region]]\nregion = \"far\"\nWOOD\nyoungs_modulus = 1e6",
        "`youngs_modulus` and `poissons_ratio` have no effect here, the material is `orthotropic`",
    ),
    (
        "thickness = 0.1\nE\nmaterial = \"neo-hookean\"\n[rest.pullback]\nbbar = [20, 0, 0]",
        "bent more sharply than its thickness of 0.1 m allows for a neo-hookean shell",
    ),
];

#[test]
fn wrong_materials_are_refused() {
    for (shell, expected) in WRONG {
        let shell = shell
            .replace("\nE", "\nyoungs_modulus = 1e6\npoissons_ratio = 0.3")
            .replace("WOOD", "orthotropic = { youngs_moduli = [2e6, 1e6], poissons_ratio = 0.3, shear_modulus = 1e6 }");
        let scene = format!(
            "[mesh.rectangle]\nsize = [1, 1]\ncells = [4, 2]\n[[region]]\nname = \"far\"\nwhere = \"x > 0.4\"\n[[region]]\nname = \"tip\"\nwhere = \"x > 0.7\"\n\
             [[pin]]\nregion = \"left\"\ndirector = \"clamped\"\n[statics]\n[shell]\n{shell}\n"
        );
        let sandbox = Sandbox::new(&scene);
        let message = sandbox.fails(2, &["check", "scene.toml"]);
        // Between them stands the value.
        let (key, words) = expected.split_once(": ").unwrap_or((expected, ""));
        assert!(message.contains(key) && message.contains(words), "{shell}\nexpected {expected}\nfound {message}");
    }
}

/// What `check` says of the materials.
#[test]
fn check_names_the_materials() {
    let scene = with(STATIC, "density", "material = \"tension-field\"\ndensity");
    let regions = "[[region]]\nname = \"far\"\nwhere = \"x > 0.03\"\n[[shell.region]]\nregion = \"far\"\nbilayer = { top_thickness = 3e-4, top = { youngs_modulus = 3e8 } }\n";
    let sandbox = Sandbox::new(&with(&scene, "[gravity]", &format!("{regions}[gravity]")));
    let (said, _) = sandbox.ok(&["check", "scene.toml"]);
    assert!(said.contains("tension-field, 1e8 Pa, nu 0.3"), "{said}");
    assert!(said.contains("far, bilayer, top 0.0003 m, 3e8 Pa, nu 0.3, bottom 1e8 Pa, nu 0.3"), "{said}");
    let (said, _) = Sandbox::new(STATIC).ok(&["check", "scene.toml"]);
    assert!(said.contains("linear free-tan, 0.001 m, 1e8 Pa, nu 0.3"), "{said}");
}

//! `check`: makes mesh and setup in memory and says which parts a scene has and how large it is. Writes no file.

use super::{Job, mesh as mesh_stage, print, report, setup};
use crate::error::Result;
use crate::mesh::{Mesh, conformal};
use crate::scene::{
    Composition, Diffusion, Expr, FlattenOnto, Integrator, Lame, MachineDirection, Material, MeshTable, Method, ModeKind, PinDirector,
    Rest, Scene, Shell, SpreadForce,
};

/// Ways in which a body that nothing holds moves without strain.
const FREE_BODY: usize = 6;

/// Prints the parts of the scene, one a line, and the numbers of vertices, faces and unknowns. The scene's own text was checked when the
/// job was read; this finds what only its mesh can tell.
///
/// # Errors
/// Those of the stages `mesh` and `setup`, except for files.
pub fn run(job: &Job) -> Result<()> {
    let (mesh, warnings) = mesh_stage::make(&job.scene, &job.scene_file)?;
    warnings.iter().for_each(|w| log::warn!("{w}"));
    let (setup, _) = setup::make(&job.scene, &mesh)?;
    report::check_sweeps(job)?;
    if job.scene.statics.is_some() && setup.held.len() < FREE_BODY {
        let held = setup.held.len();
        log::warn!("[statics]: the pins hold {held} unknowns, but a free body moves in {FREE_BODY} ways; `run` will find a mechanism");
    }
    let mut lines = parts(&job.scene);
    lines.extend(job.scene.flatten.map(|table| ("flatten", flattened(table.onto, &mesh))));
    let extent: [f64; 3] = std::array::from_fn(|k| {
        let along = mesh.vertices.iter().map(|v| v[k]);
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    });
    let [x, y, z] = extent.map(|e| (1e6 * e).round() / 1e6);
    lines.push(("size", format!("{} vertices, {} faces, {x} x {y} x {z} m", mesh.vertices.len(), mesh.faces.len())));
    if !mesh.regions.is_empty() {
        let count = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let regions = mesh.regions.iter().map(|(name, r)| {
            let [vertices, edges] = [count(r.vertices.len(), "vertex", "vertices"), count(r.edges.len(), "edge", "edges")];
            format!("{name}: {vertices}, {edges}, {}", count(r.faces.len(), "face", "faces"))
        });
        lines.push(("regions", regions.collect::<Vec<_>>().join("\n          ")));
    }
    lines.push(("unknowns", format!("{} free, {} held", setup.free_unknowns, setup.held.len())));
    let lines: Vec<String> = lines.into_iter().map(|(name, what)| format!("{name:<9} {what}")).collect();
    print(&lines.join("\n"))
}

/// Name and description of every part that the scene has.
fn parts(scene: &Scene) -> Vec<(&'static str, String)> {
    let shell = &scene.shell;
    let what = match &scene.cosserat {
        Some(table) => (scene.model.name(), super::grid::describe(table)),
        None => ("shell", describe_shell(shell)),
    };
    let mut parts = vec![("mesh", mesh(&scene.mesh)), what];
    if let Some(refine) = &scene.refine {
        parts.insert(1, ("refine", format!("each face into {}", 1u64 << (2 * refine.times))));
    }
    if !scene.title.is_empty() {
        parts.insert(0, ("title", scene.title.clone()));
    }
    if let Some(direction) = &scene.machine_direction {
        parts.push(("fibres", machine_direction(direction)));
    }
    if let Some(rest) = &scene.rest {
        parts.push(("rest", rest_laws(rest)));
    }
    parts.extend(scene.diffusing().map(|(table, _, _, said)| (table, diffusion(said))));
    if let Some(gravity) = &scene.gravity {
        parts.push(("gravity", format!("{} m/s2", vector(&gravity.acceleration))));
    }
    let change = |value: Option<f64>, unit: &str| value.map_or(String::new(), |value| format!(", {value} {unit}"));
    parts.extend(shell.regions.iter().map(|r| {
        let other = r.material.is_some() || r.lame.is_some() || r.compression.is_some() || r.orthotropic.is_some() || r.bilayer.is_some();
        let material = if other {
            describe_material(&Composition::of(shell).within(r))
        } else {
            r.youngs_modulus.map_or(String::new(), |e| format!(", {e:e} Pa"))
        };
        ("region", format!("{}{}{material}{}", r.region, change(r.thickness, "m"), change(r.density, "kg/m3")))
    }));
    parts.extend(scene.forces.iter().map(|load| ("force", format!("{}: {:?} N on each vertex", load.region, load.force))));
    parts.extend(scene.edge_loads.iter().map(|load| ("edge-load", format!("{}: {:?} N/m", load.region, load.force))));
    parts.extend(scene.moments.iter().map(|load| ("moment", format!("{}: {:?} N", load.region, load.moment))));
    let all = || "all faces".to_owned();
    parts.extend(
        scene
            .pressures
            .iter()
            .map(|load| ("pressure", format!("{}: {} Pa", load.region.clone().unwrap_or_else(all), word(&load.pressure)))),
    );
    for (name, loads, unit) in [("surface-load", &scene.surface_loads, "N/m2"), ("body-force", &scene.body_forces, "N/m3")] {
        let where_and_what = |load: &SpreadForce| format!("{}: {} {unit}", load.region.clone().unwrap_or_else(all), vector(&load.force));
        parts.extend(loads.iter().map(|load| (name, where_and_what(load))));
    }
    parts.extend(scene.winds.iter().map(|w| ("wind", format!("{}: {} m/s", w.region.clone().unwrap_or_else(all), vector(&w.velocity)))));
    parts.extend(scene.pins.iter().map(|pin| {
        let axes: Vec<String> = pin.components.iter().map(|axis| format!("{axis:?}").to_lowercase()).collect();
        let director = match pin.director {
            None => "",
            Some(PinDirector::Clamped) => ", clamped",
            Some(PinDirector::Symmetry(_)) => ", plane of symmetry",
            Some(PinDirector::Rotation(_)) => ", turned",
        };
        let moved = if pin.motion.is_some() { ", moved" } else { "" };
        ("pin", format!("{}: {}{director}{moved}", pin.region, axes.join(" ")))
    }));
    if let Some(statics) = &scene.statics {
        let stable = if statics.stable { ", unstable states are left" } else { "" };
        let disturbed = statics.perturbation.as_ref().map_or(String::new(), |p| format!(", disturbed by {} m", p.amplitude));
        let relaxed = if statics.method == Method::DynamicRelaxation { ", dynamic relaxation" } else { "" };
        let steps =
            statics.end.map_or_else(|| format!("{} load steps", statics.steps), |end| format!("{} steps to {end} s", statics.steps));
        let chosen = match (&statics.adaptive, &statics.arc_length) {
            (Some(_), _) => ", adaptive",
            (None, Some(_)) => ", along the path by arc length",
            (None, None) => "",
        };
        parts.push(("statics", format!("{steps}{chosen}{stable}{disturbed}{relaxed}")));
    }
    if let Some(dynamics) = &scene.dynamics {
        let how = match dynamics.integrator {
            Integrator::ImplicitEuler => "",
            Integrator::Bdf2 => ", BDF2",
            Integrator::GeneralisedAlpha => ", generalised-alpha",
        };
        let by_error = if dynamics.adaptive.is_some() { " first, then by their error" } else { "" };
        parts.push(("dynamics", format!("to {} s in steps of {} s{by_error}{how}", dynamics.end, dynamics.dt)));
    }
    if let Some(modes) = &scene.modes {
        parts.push(("modes", format!("{} of {}", modes.count, if modes.kind == ModeKind::Vibration { "vibration" } else { "buckling" })));
    }
    if let Some(report) = &scene.report {
        parts.push((
            "report",
            format!(
                "{} expectations{}{}",
                report.expectations.len(),
                if report.ladder.is_some() { ", ladder" } else { "" },
                match report.sweeps.len() {
                    0 => String::new(),
                    1 => ", 1 sweep".to_owned(),
                    n => format!(", {n} sweeps"),
                }
            ),
        ));
    }
    parts
}

fn word(expr: &Expr) -> String {
    match expr {
        Expr::Number(value) => value.to_string(),
        Expr::Text(text) => text.clone(),
    }
}

fn vector(components: &[Expr; 3]) -> String {
    format!("({})", components.each_ref().map(word).join(", "))
}

fn diffusion(table: &Diffusion) -> String {
    let layers = table.layers();
    let sides: Vec<String> = table
        .boundaries
        .iter()
        .map(|b| {
            let kind = if b.value.is_some() {
                "given"
            } else if b.flux.is_some() {
                "flux"
            } else {
                "exchange"
            };
            let region = b.region.as_ref().map_or(String::new(), |name| format!(" of {name}"));
            format!(", {kind} at the {}{region}", format!("{:?}", b.side).to_lowercase())
        })
        .collect();
    let sides = if sides.is_empty() { ", sealed".to_owned() } else { sides.concat() };
    let effects =
        [("softens", table.stiffness.is_some()), ("adds mass", table.added_density.is_some()), ("has a source", table.source.is_some())];
    let effects: String = effects.iter().filter(|(_, there)| *there).map(|(name, _)| format!(", {name}")).collect();
    format!("{layers} layers{sides}{effects}")
}

/// What became of a mesh that was flattened.
fn flattened(onto: FlattenOnto, mesh: &Mesh) -> String {
    let shape = match onto {
        FlattenOnto::Disc => "disc",
        FlattenOnto::Natural => "natural boundary",
    };
    let [least, most] = mesh
        .fields
        .get(conformal::FACTOR)
        .map_or([0.0; 2], |factor| [f64::min, f64::max].map(|extreme| factor.data.iter().copied().reduce(extreme).unwrap_or_default()));
    format!("{shape}, lengths were {:.4} to {:.4} times as long", least.exp(), most.exp())
}

/// The laws in the order in which they follow one another.
fn rest_laws(rest: &Rest) -> String {
    let laws = [
        ("pullback", rest.pullback.is_some()),
        ("surface", rest.surface.is_some()),
        ("shape", rest.shape.is_some()),
        ("isotropic", rest.isotropic.is_some()),
        ("orthotropic", rest.orthotropic.is_some()),
        ("linear", rest.linear.is_some()),
        ("bilayer", rest.bilayer.is_some()),
        ("thermal", rest.thermal.is_some()),
        ("prestress", rest.prestress.is_some()),
    ];
    let names: Vec<&str> = laws.iter().filter(|(_, there)| *there).map(|(name, _)| *name).collect();
    if names.is_empty() { "initial shape".to_owned() } else { names.join(", then ") }
}

fn machine_direction(direction: &MachineDirection) -> String {
    match direction {
        MachineDirection::Vector([x, y, z]) => format!("along ({x}, {y}, {z})"),
        MachineDirection::Angle(_) => "at an angle in the xy plane".to_owned(),
        MachineDirection::Radial(_) => "radial".to_owned(),
        MachineDirection::Azimuthal(_) => "azimuthal".to_owned(),
        MachineDirection::Gradient(_) => "along a gradient".to_owned(),
        MachineDirection::Field(name) => format!("field {name}"),
        MachineDirection::Transport(_) => "transported".to_owned(),
    }
}

fn describe_shell(shell: &Shell) -> String {
    let (element, director) = (shell.element.name(), shell.director.name());
    let density = shell.density.map_or(String::new(), |rho| format!(", {rho} kg/m3"));
    format!("{element} {director}, {} m{}{density}", shell.thickness, describe_material(&Composition::of(shell)))
}

/// Law and moduli, each after a comma. The law is left out where it is the default.
fn describe_material(made: &Composition) -> String {
    if let Some(o) = &made.orthotropic {
        let ([e1, e2], nu, g) = (o.youngs_moduli, o.poissons_ratio, o.shear_modulus);
        return format!(", orthotropic, {e1:e} and {e2:e} Pa, nu {nu}, shear {g:e} Pa");
    }
    if let Some((bilayer, [top, bottom])) = made.bilayer.as_ref().and_then(|b| Some((b, made.layers(b)?))) {
        let thickness = bilayer.top_thickness;
        return format!(", bilayer, top {thickness} m, {:e} Pa, nu {}, bottom {:e} Pa, nu {}", top[0], top[1], bottom[0], bottom[1]);
    }
    let law = match (made.material, made.lame) {
        (Material::Stvk, Some(Lame::ThreeD)) => ", three-dimensional Lame parameters".to_owned(),
        (Material::Stvk, _) => String::new(),
        (law, _) => format!(", {}", law.name()),
    };
    let modulus = made.youngs_modulus.map_or(String::new(), |e| format!(", {e:e} Pa"));
    let ratio = made.poissons_ratio.map_or(String::new(), |nu| format!(", nu {nu}"));
    format!("{law}{modulus}{ratio}")
}

fn mesh(mesh: &MeshTable) -> String {
    match mesh {
        MeshTable::Rectangle(table) => format!("rectangle, {} x {} cells", table.cells[0], table.cells[1]),
        MeshTable::Disc(table) => format!("disc, {} rings", table.rings),
        MeshTable::Annulus(table) => format!("annulus, {} x {} cells", table.cells[0], table.cells[1]),
        MeshTable::Cylinder(table) => format!("cylinder, {} x {} cells", table.cells[0], table.cells[1]),
        MeshTable::SphereCap(table) => format!("sphere cap, {} rings", table.rings),
        MeshTable::Outline(table) => {
            let corners = match (&table.file, &table.points) {
                (Some(file), _) => file.display().to_string(),
                (None, points) => format!("{} corners", points.as_ref().map_or(0, Vec::len)),
            };
            format!("outline, {corners}, {} holes", table.holes.len())
        }
        MeshTable::Grid(table) => format!("grid, {} x {} nodes", table.nodes[0], table.nodes[1]),
        MeshTable::File(table) => format!("file {}", table.path.display()),
    }
}

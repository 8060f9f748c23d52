//! Ranges of the fields and rules between them, beyond what their types say. Stops at the first fault.
//!
//! What depends on the mesh (whether a region exists, whether it has faces) is not checked here.

mod cosserat;
mod diffusion;
mod load;
mod matrix;
mod modes;
mod report;
mod rest;
mod stepping;

use super::source::Fault;
use super::*;
use std::ops::RangeInclusive;

pub(super) type Check = Result<(), Fault>;

const CELLS: RangeInclusive<usize> = 1..=10_000;
/// As many as the names of checkpoints have digits for.
const MOST_STEPS: f64 = 1e8;
/// After that a single face has become nearly as many as a mesh may have.
const REFINEMENTS: RangeInclusive<usize> = 1..=12;
const RINGS: RangeInclusive<usize> = 1..=5_000;

fn fault(key: &str, message: impl Into<String>) -> Fault {
    Fault::new(key.split('.').filter(|part| !part.is_empty()).map(str::to_owned).collect(), message)
}

pub(super) fn require(key: &str, condition: bool, message: impl Into<String>) -> Check {
    if condition { Ok(()) } else { Err(fault(key, message)) }
}

pub(super) fn positive(key: &str, value: f64, unit: &str) -> Check {
    require(key, value > 0.0 && value.is_finite(), format!("must be > 0 [{unit}]"))
}

fn positive_or_absent(key: &str, value: Option<f64>, unit: &str) -> Check {
    value.map_or(Ok(()), |value| positive(key, value, unit))
}

pub(super) fn finite(key: &str, values: &[f64], unit: &str) -> Check {
    require(key, values.iter().all(|value| value.is_finite()), format!("must be finite [{unit}]"))
}

fn within<T: PartialOrd + std::fmt::Display>(key: &str, value: T, range: RangeInclusive<T>) -> Check {
    require(key, range.contains(&value), format!("must be {} to {}", range.start(), range.end()))
}

pub(super) fn non_zero(key: &str, vector: &[f64; 3]) -> Check {
    finite(key, vector, "1")?;
    require(key, vector.iter().any(|component| component.abs() > 1e-100), "must not be the zero vector")
}

pub(super) fn named(key: &str, name: &str) -> Check {
    require(key, !name.trim().is_empty(), "must not be empty")
}

/// The expression parses with these variables; a constant one must be finite.
pub(super) fn expression(key: &str, text: &Expr, variables: &[&str]) -> Check {
    let parsed = text.parse(variables).map_err(|message| fault(key, message))?;
    require(key, !parsed.is_constant() || parsed.eval(&[]).is_finite(), "must be finite")
}

pub(super) fn optional_expression(key: &str, text: &Option<Expr>, variables: &[&str]) -> Check {
    text.as_ref().map_or(Ok(()), |text| expression(key, text, variables))
}

pub(super) fn expressions<'a>(key: &str, texts: impl IntoIterator<Item = &'a Expr>, variables: &[&str]) -> Check {
    texts.into_iter().enumerate().try_for_each(|(i, text)| expression(&format!("{key}.{i}"), text, variables))
}

/// Every rule.
pub(super) fn scene(scene: &Scene) -> Check {
    mesh(&scene.mesh)?;
    scene.refine.map_or(Ok(()), |table| within("refine.times", table.times, REFINEMENTS))?;
    if let Some(flatten) = &scene.flatten {
        positive_or_absent("flatten.radius", flatten.radius, "m")?;
        let has_radius = flatten.radius.is_none() || flatten.onto == FlattenOnto::Disc;
        require("flatten.radius", has_radius, "needs `onto = \"disc\"`")?;
    }
    regions(&scene.regions)?;
    time(scene)?;
    cosserat::model(scene)?;
    if scene.cosserat.is_none() {
        shell(scene)?;
    }
    scene.machine_direction.as_ref().map_or(Ok(()), rest::machine_direction)?;
    scene.rest.as_ref().map_or(Ok(()), |table| rest::rest(table, scene))?;
    diffusion::diffusing(scene)?;
    if let Some(gravity) = &scene.gravity {
        expressions("gravity.acceleration", &gravity.acceleration, PLACE_AND_TIME)?;
        optional_expression("gravity.factor", &gravity.factor, TIME)?;
    }
    loads(scene)?;
    let angles = !scene.output.directors || scene.shell.director != Director::Average;
    require("output.directors", angles, "needs directors of the edges' own, which `average` has not")?;
    let modes = !scene.output.lowest_mode || scene.statics.as_ref().is_some_and(|s| s.stable);
    require("output.lowest_mode", modes, "needs `stable = true` in [statics]")?;
    let turned = |pin: &Pin| matches!(pin.director, Some(PinDirector::Rotation(_)));
    for (i, table) in scene.pins.iter().enumerate() {
        let angles = scene.shell.director != Director::Average || !turned(table);
        require(&format!("pin.{i}.director"), angles, "needs directors of the edges' own, which `average` has not")?;
        pin(&format!("pin.{i}"), table)?;
    }
    modes::modes(scene)?;
    count_of_steps(scene)?;
    within("solver.tolerance", scene.solver.tolerance, 1e-14..=1e-2)?;
    within("solver.max_iterations", scene.solver.max_iterations, 1..=1000)?;
    within("solver.max_halvings", scene.solver.max_halvings, 0..=40)?;
    scene.report.as_ref().map_or(Ok(()), |table| report::report(table, scene))
}

fn loads(scene: &Scene) -> Check {
    for (i, load) in scene.forces.iter().enumerate() {
        finite(&format!("force.{i}.force"), &load.force, "N")?;
        optional_expression(&format!("force.{i}.factor"), &load.factor, TIME)?;
    }
    for (i, load) in scene.edge_loads.iter().enumerate() {
        finite(&format!("edge-load.{i}.force"), &load.force, "N/m")?;
        optional_expression(&format!("edge-load.{i}.factor"), &load.factor, TIME)?;
    }
    for (i, load) in scene.moments.iter().enumerate() {
        finite(&format!("moment.{i}.moment"), &load.moment, "N")?;
        optional_expression(&format!("moment.{i}.factor"), &load.factor, TIME)?;
        let angles = scene.shell.director != Director::Average;
        require(&format!("moment.{i}"), angles, "needs directors of the edges' own, which `average` has not")?;
    }
    for (i, load) in scene.pressures.iter().enumerate() {
        expression(&format!("pressure.{i}.pressure"), &load.pressure, PLACE_AND_TIME)?;
        optional_expression(&format!("pressure.{i}.factor"), &load.factor, TIME)?;
    }
    load::distributed(scene)
}

fn cells(key: &str, cells: [usize; 2], least: [usize; 2]) -> Check {
    (0..2).try_for_each(|i| within(&format!("{key}.{i}"), cells[i], least[i]..=*CELLS.end()))
}

fn mesh(mesh: &MeshTable) -> Check {
    let structured = |key, pattern| require(key, pattern != Pattern::Delaunay, "`delaunay` exists for rectangles only");
    match mesh {
        MeshTable::Rectangle(table) => {
            positive("mesh.rectangle.size.0", table.size[0], "m")?;
            positive("mesh.rectangle.size.1", table.size[1], "m")?;
            cells("mesh.rectangle.cells", table.cells, [1, 1])?;
            jitter("mesh.rectangle.jitter", table.jitter, table.pattern)?;
            let Some(triangles) = &table.triangulation else { return Ok(()) };
            let key = "mesh.rectangle.triangulation";
            require(key, table.pattern == Pattern::Delaunay, "needs `pattern = \"delaunay\"`")?;
            triangulation(key, triangles)
        }
        MeshTable::Disc(table) => {
            positive("mesh.disc.radius", table.radius, "m")?;
            within("mesh.disc.rings", table.rings, RINGS)
        }
        MeshTable::Annulus(table) => {
            let [inner, outer] = table.radii;
            positive("mesh.annulus.radii.0", inner, "m")?;
            require("mesh.annulus.radii.1", outer > inner && outer.is_finite(), "must be larger than the inner radius [m]")?;
            cells("mesh.annulus.cells", table.cells, [1, 3])?;
            structured("mesh.annulus.pattern", table.pattern)
        }
        MeshTable::Cylinder(table) => {
            positive("mesh.cylinder.radius", table.radius, "m")?;
            positive("mesh.cylinder.length", table.length, "m")?;
            require("mesh.cylinder.angle", table.angle > 0.0 && table.angle <= 360.0, "must be > 0 and <= 360 [degrees]")?;
            cells("mesh.cylinder.cells", table.cells, [if table.angle == 360.0 { 3 } else { 1 }, 1])?;
            structured("mesh.cylinder.pattern", table.pattern)
        }
        MeshTable::SphereCap(table) => {
            positive("mesh.sphere-cap.radius", table.radius, "m")?;
            let angle = table.half_angle;
            require("mesh.sphere-cap.half_angle", angle > 0.0 && angle < 180.0, "must be > 0 and < 180 [degrees]")?;
            within("mesh.sphere-cap.rings", table.rings, RINGS)
        }
        MeshTable::Outline(table) => {
            let key = "mesh.outline";
            require(key, table.points.is_some() != table.file.is_some(), "exactly one of `points` and `file` must be given")?;
            let named = table.file.as_ref().is_none_or(|file| !file.as_os_str().is_empty());
            require("mesh.outline.file", named, "must not be empty")?;
            table.points.as_ref().map_or(Ok(()), |points| polygon("mesh.outline.points", points))?;
            for (i, hole) in table.holes.iter().enumerate() {
                polygon(&format!("mesh.outline.holes.{i}"), hole)?;
            }
            triangulation("mesh.outline.triangulation", &table.triangulation)
        }
        MeshTable::Grid(table) => cosserat::grid("mesh.grid", table),
        MeshTable::File(table) => mesh_file("mesh.file", table),
    }
}

pub(super) fn mesh_file(key: &str, table: &MeshFile) -> Check {
    require(&format!("{key}.path"), !table.path.as_os_str().is_empty(), "must not be empty")?;
    positive(&format!("{key}.scale"), table.scale, "m per unit of the file")
}

fn jitter(key: &str, jitter: f64, pattern: Pattern) -> Check {
    within(key, jitter, 0.0..=0.45)?;
    require(key, jitter == 0.0 || pattern != Pattern::Delaunay, "cannot be combined with the pattern `delaunay`")
}

fn triangulation(key: &str, table: &Triangulation) -> Check {
    positive(&format!("{key}.size"), table.size, "m")?;
    within(&format!("{key}.min_angle"), table.min_angle, 0.0..=30.0)
}

fn polygon(key: &str, points: &[[f64; 2]]) -> Check {
    require(key, points.len() >= 3, format!("has {} corners, must have at least 3", points.len()))?;
    for (i, point) in points.iter().enumerate() {
        let key = format!("{key}.{i}");
        finite(&key, point, "m")?;
        require(&key, points[(i + 1) % points.len()] != *point, "is the same as the next corner")?;
    }
    Ok(())
}

fn regions(regions: &[RegionTable]) -> Check {
    for (i, table) in regions.iter().enumerate() {
        let key = format!("region.{i}");
        named(&format!("{key}.name"), &table.name)?;
        let new = regions[..i].iter().all(|other| other.name != table.name);
        require(&format!("{key}.name"), new, "a region of this name comes before")?;
        require(&key, table.condition.is_some() != table.nearest.is_some(), "exactly one of `where` and `nearest` must be given")?;
        optional_expression(&format!("{key}.where"), &table.condition, PLACE)?;
        finite(&format!("{key}.nearest"), table.nearest.as_ref().map_or(&[], |point| point), "m")?;
    }
    Ok(())
}

fn shell(scene: &Scene) -> Check {
    let shell = &scene.shell;
    let whole = Composition::of(shell);
    positive("shell.thickness", shell.thickness, "m")?;
    positive_or_absent("shell.density", shell.density, "kg/m3")?;
    material("shell", &whole)?;
    composition("shell", &whole, "")?;
    positive_or_absent("shell.viscosity", shell.viscosity, "s")?;
    let both = shell.element == Element::Quadratic && shell.director == Director::Average;
    require("shell.director", !both, "`average` exists for the linear element only")?;
    let vibrates = scene.modes.as_ref().filter(|table| table.kind == ModeKind::Vibration).map(|_| "modes");
    let weight = scene.gravity.as_ref().map(|_| "gravity");
    let user = scene.dynamics.as_ref().map(|_| "dynamics").or(weight).or(vibrates);
    if let (Some(user), None) = (user, shell.density) {
        return Err(fault("shell.density", format!("this key is missing, and [{user}] needs it [kg/m3]")));
    }
    require("shell.viscosity", shell.viscosity.is_none() || scene.dynamics.is_some(), "has no meaning without [dynamics]")?;
    for (i, table) in shell.regions.iter().enumerate() {
        let key = format!("shell.region.{i}");
        named(&format!("{key}.region"), &table.region)?;
        positive_or_absent(&format!("{key}.thickness"), table.thickness, "m")?;
        positive_or_absent(&format!("{key}.density"), table.density, "kg/m3")?;
        let own = Composition { thickness: table.thickness.unwrap_or(shell.thickness), ..Composition::default() }.within(table);
        material(&key, &own)?;
        let there = whole.within(table);
        let idle = there.orthotropic.is_some() && (table.youngs_modulus.is_some() || table.poissons_ratio.is_some());
        require(&key, !idle, "`youngs_modulus` and `poissons_ratio` have no effect here, the material is `orthotropic`")?;
        composition(&key, &there, &table.region)?;
    }
    Ok(())
}

fn isotropic(key: &str, modulus: Option<f64>, ratio: Option<f64>) -> Check {
    positive_or_absent(&format!("{key}.youngs_modulus"), modulus, "Pa")?;
    let valid = ratio.is_none_or(|ratio| ratio > -1.0 && ratio < 0.5);
    require(&format!("{key}.poissons_ratio"), valid, "must be > -1 and < 0.5")
}

/// Ranges of the numbers that one table gives.
fn material(key: &str, own: &Composition) -> Check {
    isotropic(key, own.youngs_modulus, own.poissons_ratio)?;
    let share = own.compression.is_none_or(|share| share > 0.0 && share <= 1.0);
    require(&format!("{key}.compression"), share, "must be > 0 and <= 1")?;
    if let Some(table) = &own.orthotropic {
        let key = format!("{key}.orthotropic");
        (0..2).try_for_each(|i| positive(&format!("{key}.youngs_moduli.{i}"), table.youngs_moduli[i], "Pa"))?;
        finite(&format!("{key}.poissons_ratio"), &[table.poissons_ratio], "1")?;
        positive(&format!("{key}.shear_modulus"), table.shear_modulus, "Pa")?;
    }
    let Some(table) = &own.bilayer else { return Ok(()) };
    positive(&format!("{key}.bilayer.top_thickness"), table.top_thickness, "m")?;
    isotropic(&format!("{key}.bilayer.top"), table.top.youngs_modulus, table.top.poissons_ratio)?;
    isotropic(&format!("{key}.bilayer.bottom"), table.bottom.youngs_modulus, table.bottom.poissons_ratio)
}

/// What holds together, in a region or all over.
fn composition(key: &str, there: &Composition, region: &str) -> Check {
    let place = if region.is_empty() { String::new() } else { format!(" (region '{region}')") };
    there.check().map_err(|(name, message)| fault(&format!("{key}.{name}"), format!("{message}{place}")))
}

fn pin(key: &str, pin: &Pin) -> Check {
    named(&format!("{key}.region"), &pin.region)?;
    let held = format!("{key}.components");
    require(&held, !pin.components.is_empty() || pin.director.is_some(), "holds nothing; name a component or a director")?;
    for (i, axis) in pin.components.iter().enumerate() {
        require(&held, !pin.components[..i].contains(axis), "a component is repeated")?;
    }
    match &pin.director {
        Some(PinDirector::Symmetry(normal)) => non_zero(&format!("{key}.director.symmetry"), normal)?,
        Some(PinDirector::Rotation(rotation)) => {
            non_zero(&format!("{key}.director.rotation.axis"), &rotation.axis)?;
            expression(&format!("{key}.director.rotation.angle"), &rotation.angle, TIME)?;
        }
        Some(PinDirector::Clamped) | None => {}
    }
    let Some(motion) = &pin.motion else { return Ok(()) };
    let mut moves = false;
    for (name, axis, text) in [("x", Axis::X, &motion.x), ("y", Axis::Y, &motion.y), ("z", Axis::Z, &motion.z)] {
        let Some(text) = text else { continue };
        let key = format!("{key}.motion.{name}");
        require(&key, pin.components.contains(&axis), format!("`{name}` is not among the held `components`"))?;
        expression(&key, text, POSITION_AND_TIME)?;
        moves = true;
    }
    require(&format!("{key}.motion"), moves, "must give x, y or z")
}

fn time(scene: &Scene) -> Check {
    match (&scene.statics, &scene.dynamics) {
        (None, None) => Err(fault("", "exactly one of [statics] and [dynamics] must be given, found none")),
        (Some(_), Some(_)) => Err(fault("dynamics", "exactly one of [statics] and [dynamics] must be given, found both")),
        (Some(table), None) => statics(table, scene),
        (None, Some(dynamics)) => {
            positive("dynamics.dt", dynamics.dt, "s")?;
            positive("dynamics.end", dynamics.end, "s")?;
            expressions("dynamics.velocity", dynamics.velocity.iter().flatten(), PLACE)?;
            if let Some(table) = &dynamics.random_velocity {
                positive("dynamics.random_velocity.speed", table.speed, "m/s")?;
                // Recorded scenes are TOML, whose integers have a sign.
                require("dynamics.random_velocity.seed", table.seed <= i64::MAX as u64, "must be below 2^63")?;
            }
            if let Some(radius) = dynamics.spectral_radius {
                let damped = dynamics.integrator == Integrator::GeneralisedAlpha;
                require("dynamics.spectral_radius", damped, "needs `integrator = \"generalised-alpha\"`")?;
                within("dynamics.spectral_radius", radius, 0.0..=1.0)?;
            }
            let Some(adaptive) = &dynamics.adaptive else { return Ok(()) };
            within("dynamics.adaptive.tolerance", adaptive.tolerance, 1e-10..=0.1)?;
            positive_or_absent("dynamics.adaptive.largest_dt", adaptive.largest_dt, "s")
        }
    }
}

fn statics(statics: &Statics, scene: &Scene) -> Check {
    within("statics.steps", statics.steps, usize::from(scene.modes.is_none())..=100_000)?;
    positive_or_absent("statics.end", statics.end, "s")?;
    let energies = !statics.stable || scene.moments.is_empty();
    require("statics.stable", energies, "needs an energy to tell stable states by, which a [[moment]] has not")?;
    stepping::stepping(statics, scene)?;
    let relaxes = statics.method == Method::DynamicRelaxation;
    require("statics.method", !relaxes || !statics.stable, "`dynamic-relaxation` goes without `stable`, it ends in minima by itself")?;
    let alone = !relaxes || (statics.arc_length.is_none() && statics.adaptive.is_none());
    require(
        "statics.method",
        alone,
        "`dynamic-relaxation` goes without [statics.arc-length] and [statics.adaptive], which count Newton iterations",
    )?;
    if let Some(table) = &statics.relaxation {
        require("statics.relaxation", relaxes, "needs `method = \"dynamic-relaxation\"`")?;
        within("statics.relaxation.tolerance", table.tolerance, 1e-12..=1e-2)?;
        within("statics.relaxation.max_iterations", table.max_iterations, 1..=1_000_000_000)?;
    }
    let Some(perturbation) = &statics.perturbation else { return Ok(()) };
    positive("statics.perturbation.amplitude", perturbation.amplitude, "m")?;
    // Recorded scenes are TOML, whose integers have a sign.
    require("statics.perturbation.seed", perturbation.seed <= i64::MAX as u64, "must be below 2^63")
}

/// Steps and output times are so few that the time grows by each of them.
fn count_of_steps(scene: &Scene) -> Check {
    positive_or_absent("output.interval", scene.output.interval, "s")?;
    let end = scene.end();
    let diffusing =
        [("moisture.dt", &scene.moisture), ("heat.dt", &scene.heat)].map(|(key, table)| (key, table.as_ref().and_then(|t| t.dt)));
    let steps = [("dynamics.dt", scene.dynamics.as_ref().map(|table| table.dt)), ("output.interval", scene.output.interval)];
    for (key, length) in steps.into_iter().chain(diffusing) {
        let count = length.map_or(0.0, |length| end / length);
        require(key, count <= MOST_STEPS, format!("makes {count:e} steps to the end at {end:e} s, must be at most {MOST_STEPS:e}"))?;
    }
    Ok(())
}

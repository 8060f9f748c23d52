//! Rules of `model`, `[cosserat]` and `[mesh.grid]`.

use super::*;
use crate::scene::cosserat::{Constant, GridScheme, Model};

/// A grid of as many nodes has as many faces as a mesh may have.
const NODES: RangeInclusive<usize> = 3..=3_000;

pub(super) fn grid(key: &str, table: &Grid) -> Check {
    for i in 0..2 {
        within(&format!("{key}.nodes.{i}"), table.nodes[i], NODES)?;
        positive(&format!("{key}.size.{i}"), table.size[i], "m")?;
    }
    expressions(&format!("{key}.position"), table.position.iter().flatten(), PLANE)
}

/// Which tables go with which model, and `[cosserat]` itself.
pub(super) fn model(scene: &Scene) -> Check {
    let Some(table) = &scene.cosserat else {
        require(
            "cosserat",
            scene.model == Model::Koiter,
            format!("this table is missing, and `model = \"{}\"` needs it", scene.model.name()),
        )?;
        return require("shell", !scene.shell.is_absent(), "this key is missing");
    };
    let name = scene.model.name();
    require(
        "cosserat",
        scene.model != Model::Koiter,
        "belongs to `model = \"cosserat\"` and `model = \"terzopoulos\"`, which the scene has not",
    )?;
    require("mesh", scene.mesh.grid().is_some(), format!("`model = \"{name}\"` needs [mesh.grid]"))?;
    let pinned = scene.pins.iter().position(|pin| pin.director.is_some());
    let foreign = [
        ("shell".to_owned(), !scene.shell.is_absent()),
        ("refine".into(), scene.refine.is_some()),
        ("flatten".into(), scene.flatten.is_some()),
        ("machine-direction".into(), scene.machine_direction.is_some()),
        ("rest".into(), scene.rest.is_some()),
        ("moisture".into(), scene.moisture.is_some()),
        ("heat".into(), scene.heat.is_some()),
        ("moment".into(), !scene.moments.is_empty()),
        ("body-force".into(), !scene.body_forces.is_empty()),
        ("modes".into(), scene.modes.is_some()),
        ("statics.arc-length".into(), scene.statics.as_ref().is_some_and(|s| s.arc_length.is_some())),
        ("statics.method".into(), scene.statics.as_ref().is_some_and(|s| s.method != Method::default() || s.relaxation.is_some())),
        ("dynamics.integrator".into(), scene.dynamics.as_ref().is_some_and(|d| d.integrator != Integrator::default())),
        ("dynamics.adaptive".into(), scene.dynamics.as_ref().is_some_and(|d| d.adaptive.is_some())),
        ("output.reactions".into(), scene.output.reactions),
        (format!("pin.{}.director", pinned.unwrap_or_default()), pinned.is_some()),
        ("statics.stable".into(), scene.statics.as_ref().is_some_and(|s| s.stable)),
        ("statics.perturbation".into(), scene.statics.as_ref().is_some_and(|s| s.perturbation.is_some())),
        ("output.directors".into(), scene.output.directors),
        ("report.ladder".into(), scene.report.as_ref().is_some_and(|r| r.ladder.is_some())),
    ];
    for (key, there) in foreign {
        require(&key, !there, format!("belongs to the Koiter shell; `model = \"{name}\"` has no such part"))?;
    }
    constants(table, scene)?;
    positive_or_absent("cosserat.mass", table.mass, "kg")?;
    positive_or_absent("cosserat.damping", table.damping, "kg/s")?;
    let user = if scene.dynamics.is_some() { Some("dynamics") } else { scene.gravity.as_ref().map(|_| "gravity") };
    if let (Some(user), None) = (user, table.mass) {
        return Err(fault("cosserat.mass", format!("this key is missing, and [{user}] needs it [kg]")));
    }
    let strong = table.scheme == GridScheme::StrongForm;
    require("cosserat.border", strong || table.border == GridBorder::default(), "has no meaning without `scheme = \"strong-form\"`")?;
    require(
        "cosserat.divergence",
        strong || table.divergence == Divergence::default(),
        "has no meaning without `scheme = \"strong-form\"`",
    )?;
    let moving = [
        ("cosserat.scheme", strong),
        ("cosserat.damping", table.damping.is_some()),
        ("cosserat.stream", table.stream.is_some()),
        ("cosserat.table", table.table.is_some()),
        ("cosserat.normal-force.0", !table.normal_forces.is_empty()),
    ];
    for (key, there) in moving {
        require(key, !there || scene.dynamics.is_some(), "needs [dynamics]")?;
    }
    if let Some(stream) = &table.stream {
        finite("cosserat.stream.velocity", &stream.velocity, "m/s")?;
        positive("cosserat.stream.coefficient", stream.coefficient, "Pa s/m")?;
        optional_expression("cosserat.stream.factor", &stream.factor, TIME)?;
    }
    if let Some(disc) = &table.table {
        finite("cosserat.table.centre", &disc.centre, "m")?;
        positive("cosserat.table.radius", disc.radius, "m")?;
    }
    for (i, load) in table.normal_forces.iter().enumerate() {
        let key = format!("cosserat.normal-force.{i}");
        named(&format!("{key}.region"), &load.region)?;
        finite(&format!("{key}.force"), &[load.force], "N")?;
        optional_expression(&format!("{key}.factor"), &load.factor, TIME)?;
    }
    Ok(())
}

fn constants(table: &Cosserat, scene: &Scene) -> Check {
    let place = |name: &str, constant: Constant, c: usize| match constant {
        Constant::One(_) => format!("cosserat.{name}"),
        Constant::Three(_) => format!("cosserat.{name}.{c}"),
    };
    let [eta, xi, phi] = [table.eta, table.xi, table.phi].map(Constant::components);
    for c in 0..3 {
        positive(&place("eta", table.eta, c), eta[c], "N/m")?;
        positive(&place("xi", table.xi, c), xi[c], "N m")?;
        finite(&place("phi", table.phi, c), &[phi[c]], "N")?;
        let none = scene.model != Model::Terzopoulos || phi[c] == 0.0;
        require(&place("phi", table.phi, c), none, "`model = \"terzopoulos\"` has no such constant")?;
        let (square, bound) = (phi[c] * phi[c], 4.0 * eta[c] * xi[c]);
        let message = format!(
            "makes the energy indefinite: phi^2 = {square:e} must be below 4 eta xi = 4 x {} x {} = {bound:e} (component {})",
            eta[c],
            xi[c],
            ["11", "12", "22"][c]
        );
        require(&place("phi", table.phi, c), square < bound, message)?;
    }
    let mixed = !table.mixed_terms || scene.model == Model::Cosserat;
    require("cosserat.mixed_terms", mixed, "`model = \"terzopoulos\"` has no mixed terms")
}

//! Ranges and rules of the tables `[rest]` and `[machine-direction]`.

use super::{Check, expression, expressions, finite, mesh_file, named, non_zero, optional_expression, positive, require};
use crate::scene::{Expr, MachineDirection, PLACE, PLACE_AND_TIME, PLANE, PLANE_AND_TIME, Rest, Scalar, Scene, Shape, Surface, TIME};

/// Rules of `[rest]`.
pub(in crate::scene) fn rest(rest: &Rest, scene: &Scene) -> Check {
    let fibres = scene.machine_direction.is_some();
    optional_expression("rest.ramp", &rest.ramp, TIME)?;
    if let Some(Ok(ramp)) = rest.ramp.as_ref().map(|ramp| ramp.parse(TIME)) {
        require("rest.ramp", !ramp.is_constant() || (0.0..=1.0).contains(&ramp.eval(&[])), "must be 0 to 1")?;
    }
    at_most_one(&[("pullback", rest.pullback.is_some()), ("surface", rest.surface.is_some()), ("shape", rest.shape.is_some())])?;
    at_most_one(&[("linear", rest.linear.is_some()), ("bilayer", rest.bilayer.is_some())])?;
    if let Some(law) = &rest.pullback {
        expressions("rest.pullback.abar", law.abar.iter().flatten(), PLANE_AND_TIME)?;
        expressions("rest.pullback.bbar", law.bbar.iter().flatten(), PLANE_AND_TIME)?;
    }
    rest.surface.as_ref().map_or(Ok(()), surface)?;
    match &rest.shape {
        Some(Shape::File(table)) => mesh_file("rest.shape.file", table)?,
        Some(Shape::Field(name)) => named("rest.shape.field", name)?,
        None => {}
    }
    if let Some(law) = &rest.isotropic {
        scalar("rest.isotropic.s", &law.s, PLACE_AND_TIME)?;
    }
    if let Some(law) = &rest.orthotropic {
        for (i, factor) in law.factors.iter().enumerate() {
            scalar(&format!("rest.orthotropic.factors.{i}"), factor, PLACE_AND_TIME)?;
        }
        law.angle.as_ref().map_or(Ok(()), |angle| scalar("rest.orthotropic.angle", angle, PLACE_AND_TIME))?;
        require("rest.orthotropic", law.angle.is_some() || fibres, "needs `angle`, or [machine-direction] in the scene")?;
    }
    if let Some(law) = &rest.linear {
        moisture("rest.linear", [("m_plus", &law.m_plus), ("m_minus", &law.m_minus)], law.profile.is_some(), scene)?;
        coefficients("rest.linear", "mu", &[law.mu], law.mu_perp.as_slice(), fibres)?;
    }
    if let Some(law) = &rest.bilayer {
        moisture("rest.bilayer", [("m_plus", &law.m_plus), ("m_minus", &law.m_minus)], law.profile.is_some(), scene)?;
        coefficients("rest.bilayer", "mu", &law.mu, law.mu_perp.as_ref().map_or(&[], |mu| mu), fibres)?;
    }
    if let Some(law) = &rest.thermal {
        require("rest.thermal", scene.heat.is_some(), "needs the table [heat]")?;
        coefficients("rest.thermal", "expansion", &[law.expansion], law.expansion_perp.as_slice(), fibres)?;
        if let Some(bottom) = &law.bottom {
            coefficients("rest.thermal.bottom", "expansion", &[bottom.expansion], bottom.expansion_perp.as_slice(), fibres)?;
            let both = bottom.expansion_perp.is_none() || law.expansion_perp.is_some();
            require("rest.thermal.bottom.expansion_perp", both, "needs `expansion_perp` of the law")?;
        }
    }
    let Some(law) = &rest.prestress else { return Ok(()) };
    let some = law.times.is_some() || law.plus_a.is_some() || law.plus_b.is_some();
    require("rest.prestress", some, "must give `times`, `plus_a` or `plus_b`")?;
    law.times.as_ref().map_or(Ok(()), |times| scalar("rest.prestress.times", times, PLACE_AND_TIME))?;
    expressions("rest.prestress.plus_a", law.plus_a.iter().flatten(), PLANE_AND_TIME)?;
    expressions("rest.prestress.plus_b", law.plus_b.iter().flatten(), PLANE_AND_TIME)
}

fn at_most_one(laws: &[(&str, bool)]) -> Check {
    let found: Vec<String> = laws.iter().filter(|(_, there)| *there).map(|(name, _)| format!("`{name}`")).collect();
    require("rest", found.len() < 2, format!("at most one of these laws may be given: {}", found.join(", ")))
}

pub(super) fn scalar(key: &str, value: &Scalar, variables: &[&str]) -> Check {
    match value {
        Scalar::Expr(expr) => expression(key, expr, variables),
        Scalar::Field(field) => {
            named(&format!("{key}.field"), &field.field)?;
            optional_expression(&format!("{key}.times"), &field.times, variables)
        }
    }
}

fn surface(surface: &Surface) -> Check {
    match surface {
        Surface::Position(exprs) => expressions("rest.surface.position", exprs, PLANE),
        Surface::Sphere { radius } => positive("rest.surface.sphere.radius", *radius, "m"),
        Surface::Torus { radii: [a, b] } => {
            positive("rest.surface.torus.radii.1", *b, "m")?;
            require("rest.surface.torus.radii.0", a > b && a.is_finite(), "must be larger than the radius of the tube [m]")
        }
        Surface::Catenoid { waist, turn } => {
            positive("rest.surface.catenoid.waist", *waist, "m")?;
            finite("rest.surface.catenoid.turn", &[*turn], "degrees")
        }
        Surface::Helicoid { waist } => positive("rest.surface.helicoid.waist", *waist, "m"),
    }
}

/// Moisture is prescribed by the law or diffuses, not both.
fn moisture(key: &str, sides: [(&str, &Option<Expr>); 2], profile: bool, scene: &Scene) -> Check {
    let diffuses = scene.moisture.is_some();
    for (name, side) in sides {
        let key = format!("{key}.{name}");
        optional_expression(&key, side, PLACE_AND_TIME)?;
        require(&key, side.is_some() || diffuses, "this key is missing, and the scene has no [moisture]")?;
        require(&key, side.is_none() || !diffuses, "is what [moisture] tells; leave it out")?;
    }
    require(&format!("{key}.profile"), diffuses || !profile, "needs the table [moisture]")
}

fn coefficients(key: &str, name: &str, along: &[f64], across: &[f64], fibres: bool) -> Check {
    finite(&format!("{key}.{name}"), along, "relative change of length")?;
    finite(&format!("{key}.{name}_perp"), across, "relative change of length")?;
    require(&format!("{key}.{name}_perp"), across.is_empty() || fibres, "needs the table [machine-direction]")
}

/// Rules of `[machine-direction]`.
pub(in crate::scene) fn machine_direction(direction: &MachineDirection) -> Check {
    match direction {
        MachineDirection::Vector(vector) => non_zero("machine-direction.vector", vector),
        MachineDirection::Angle(angle) => scalar("machine-direction.angle", angle, PLACE),
        MachineDirection::Radial(axis) => finite("machine-direction.radial.center", &axis.center, "m"),
        MachineDirection::Azimuthal(axis) => finite("machine-direction.azimuthal.center", &axis.center, "m"),
        MachineDirection::Gradient(expr) => expression("machine-direction.gradient", expr, PLACE),
        MachineDirection::Field(name) => named("machine-direction.field", name),
        MachineDirection::Transport(transport) => {
            finite("machine-direction.transport.from", &transport.from, "m")?;
            non_zero("machine-direction.transport.vector", &transport.vector)
        }
    }
}

//! Turns what a scene says into objects: expressions into fields, tables into potentials, supports and rest drivers.
//!
//! An absent table becomes no object. What does not change during a run is made once by `setup` and kept in [`Setup`].

use super::setup::Setup;
use crate::error::{Error, Result};
use crate::load::DeadLoad;
use crate::math::Expression;
use crate::mesh::{Mesh, Topology};
use crate::model::{HeldUnknown, Load, Motion, Parts, Ramp, RestDriver, ShellModel};
use crate::scene::{self, Axis, Expr, Scene};
use crate::shell::rest::{Law, Linear, Pullback, Sampling, ScalarField};
use crate::shell::{Director, Inertia, Inertial, Koiter, LinearAverage, LinearFree, MassKind, Measure, Shell};
use nalgebra::Vector3;

/// Values of all the variables of an expression at a place and time, picked by its list of names.
pub fn place_values(names: &[&str], p: &Vector3<f64>, t: f64) -> Vec<f64> {
    let value = |name: &&str| match *name {
        "x" => p.x,
        "y" => p.y,
        "z" => p.z,
        "r" => p.x.hypot(p.y),
        "theta" => p.y.atan2(p.x),
        _ => t,
    };
    names.iter().map(value).collect()
}

/// An expression that the scene's check has parsed before. Errors: never after that check.
pub fn expression(key: &str, expr: &Expr, names: &[&str]) -> Result<Expression> {
    expr.parse(names).map_err(|e| Error::input(key, e))
}

/// A scalar of place and time.
fn field(key: &str, expr: &Expr, names: &'static [&'static str]) -> Result<ScalarField> {
    let parsed = expression(key, expr, names)?;
    if parsed.is_constant() {
        let value = parsed.eval(&[]);
        return Ok(Box::new(move |_, _| value));
    }
    Ok(Box::new(move |p, t| parsed.eval(&place_values(names, p, t))))
}

/// A number in time.
fn of_time(key: &str, expr: &Expr) -> Result<Box<dyn Fn(f64) -> f64>> {
    let parsed = expression(key, expr, scene::TIME)?;
    Ok(Box::new(move |t| parsed.eval(&[t])))
}

/// Number of the axis.
pub fn axis_index(axis: Axis) -> usize {
    match axis {
        Axis::X => 0,
        Axis::Y => 1,
        Axis::Z => 2,
    }
}

/// The shell's energy over the element that the scene names.
pub fn shell(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Box<dyn Shell> {
    let mut supports = vec![Director::Free; topology.edges.len()];
    for (edge, p) in &setup.held_directors {
        supports[*edge] = Director::Held(*p);
    }
    let (materials, viscosity) = (setup.materials.clone(), scene.shell.viscosity);
    let free = |measure| -> Box<dyn Shell> {
        Box::new(Koiter::new(LinearFree::new(mesh, topology, measure, &supports), materials.clone(), viscosity))
    };
    match scene.shell.director {
        scene::Director::Average => Box::new(Koiter::new(LinearAverage::new(mesh, topology, &supports), materials, viscosity)),
        scene::Director::FreeSin => free(Measure::Sin),
        scene::Director::FreeTan => free(Measure::Tan),
    }
}

/// The growth law, whether it changes in time, and none for the initial shape.
fn law(scene: &Scene, setup: &Setup) -> Result<Option<(Box<dyn Law>, bool)>> {
    let Some(rest) = &scene.rest else { return Ok(None) };
    let mut changes = false;
    let mut make = |key: &str, expr: &Expr, names: &'static [&'static str]| {
        changes |= expression(key, expr, names)?.uses("t");
        field(key, expr, names)
    };
    if let Some(table) = &rest.pullback {
        let mut form = |key: &str, exprs: &Option<[Expr; 3]>| -> Result<Option<[ScalarField; 3]>> {
            let Some([a, b, c]) = exprs else { return Ok(None) };
            Ok(Some([make(key, a, scene::PLANE_AND_TIME)?, make(key, b, scene::PLANE_AND_TIME)?, make(key, c, scene::PLANE_AND_TIME)?]))
        };
        let (abar, bbar) = (form("rest.pullback.abar", &table.abar)?, form("rest.pullback.bbar", &table.bbar)?);
        let polar = table.components == scene::Components::Polar;
        return Ok(Some((Box::new(Pullback { abar, bbar, polar }), changes)));
    }
    if let Some(table) = &rest.linear {
        let m_plus = make("rest.linear.m_plus", &table.m_plus, scene::PLACE_AND_TIME)?;
        let m_minus = make("rest.linear.m_minus", &table.m_minus, scene::PLACE_AND_TIME)?;
        let fibres = table.mu_perp.zip(setup.machine_direction.clone());
        return Ok(Some((Box::new(Linear { m_plus, m_minus, mu: table.mu, fibres }), changes)));
    }
    Ok(None)
}

/// What drives the rest forms, if anything does.
pub fn rest(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<Option<RestDriver>> {
    let Some((law, changes)) = law(scene, setup)? else { return Ok(None) };
    let table = scene.rest.clone().unwrap_or_default();
    let ramp: Option<Ramp> = match &table.ramp {
        Some(expr) => Some(of_time("rest.ramp", expr)?),
        None if scene.statics.is_some() => Some(Box::new(|t| t)),
        None => None,
    };
    let sampling = match table.sampling {
        scene::Sampling::Edges => Sampling::Edges,
        scene::Sampling::Centroid => Sampling::Centroid,
    };
    let thickness = setup.materials.iter().map(|m| m.thickness).collect();
    Ok(Some(RestDriver::new(mesh.clone(), topology.clone(), law, changes, sampling, ramp, thickness, setup.initial_forms.clone())))
}

/// Mass of each face [kg]: thickness, density and rest area at the start. Empty where the scene has no density.
fn face_masses(setup: &Setup) -> Vec<f64> {
    let area = |a: [f64; 3]| 0.5 * (a[0] * a[2] - a[1] * a[1]).sqrt();
    setup.densities.iter().zip(&setup.materials).zip(&setup.rest_forms).map(|((rho, m), f)| rho * m.thickness * area(f.a)).collect()
}

/// The whole model at its start.
pub fn model(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<ShellModel> {
    let masses = face_masses(setup);
    let kind = match scene.shell.mass {
        scene::Mass::Consistent => MassKind::Consistent,
        scene::Mass::Lumped => MassKind::Lumped,
    };
    let mut loads = Vec::new();
    if let Some(table) = &scene.gravity {
        let mut nodes = vec![0.0; mesh.vertices.len()];
        for (face, mass) in mesh.faces.iter().zip(&masses) {
            face.iter().for_each(|v| nodes[*v] += mass / 3.0);
        }
        let g = Vector3::from(table.acceleration);
        let potential = DeadLoad::new(nodes.iter().map(|mass| g * *mass).enumerate().collect());
        let factor = load_factor(scene, "gravity.factor", &table.factor)?;
        loads.push(Load { key: "gravity.factor", energy_name: "gravity_energy_J", potential, factor });
    }
    let held = setup
        .held
        .iter()
        .map(|h| {
            let start = if h.unknown < 3 * mesh.vertices.len() { mesh.vertices[h.unknown / 3][h.unknown % 3] } else { 0.0 };
            let motion: Option<Motion> = match h.pin.and_then(|pin| pin_motion(scene, pin, h.unknown % 3)) {
                None => None,
                Some(expr) => {
                    let parsed = expression("pin.motion", expr, scene::POSITION_AND_TIME)?;
                    let p = mesh.vertices[h.unknown / 3];
                    Some(Box::new(move |t| parsed.eval(&[p.x, p.y, p.z, t])))
                }
            };
            Ok(HeldUnknown { unknown: h.unknown, start, motion })
        })
        .collect::<Result<Vec<_>>>()?;
    let parts = Parts {
        shell: shell(scene, mesh, topology, setup),
        inertia: scene.dynamics.as_ref().map(|_| -> Box<dyn Inertial> {
            Box::new(Inertia::<3, 9>::new(mesh.faces.clone(), masses.iter().map(|mass| kind.linear(*mass)).collect()))
        }),
        loads,
        rest: rest(scene, mesh, topology, setup)?,
        initial_forms: setup.initial_forms.clone(),
        held,
        positions: mesh.vertices.clone(),
        velocities: velocities(scene, mesh)?,
    };
    ShellModel::new(parts, mesh.diameter(), scene.solver.tolerance, scene.solver.max_iterations)
}

/// A load's factor in time: as given, else the load factor in statics and none in dynamics.
fn load_factor(scene: &Scene, key: &str, factor: &Option<Expr>) -> Result<Option<Motion>> {
    match factor {
        Some(expr) => Ok(Some(of_time(key, expr)?)),
        None if scene.statics.is_some() => Ok(Some(Box::new(|t| t))),
        None => Ok(None),
    }
}

/// The prescribed displacement along an axis of a pin, if it has one.
pub fn pin_motion(scene: &Scene, pin: usize, axis: usize) -> Option<&Expr> {
    let motion = scene.pins.get(pin)?.motion.as_ref()?;
    [&motion.x, &motion.y, &motion.z][axis].as_ref()
}

/// Initial velocity of each vertex [m/s]; empty in statics.
fn velocities(scene: &Scene, mesh: &Mesh) -> Result<Vec<Vector3<f64>>> {
    let Some(dynamics) = &scene.dynamics else { return Ok(Vec::new()) };
    let Some(exprs) = &dynamics.velocity else { return Ok(vec![Vector3::zeros(); mesh.vertices.len()]) };
    let fields = exprs.iter().map(|e| field("dynamics.velocity", e, scene::PLACE)).collect::<Result<Vec<_>>>()?;
    let velocities: Vec<Vector3<f64>> =
        mesh.vertices.iter().map(|p| Vector3::new(fields[0](p, 0.0), fields[1](p, 0.0), fields[2](p, 0.0))).collect();
    match velocities.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        Some(v) => Err(Error::input("dynamics.velocity", format!("is not finite at vertex {v}"))),
        None => Ok(velocities),
    }
}

/// Moisture at the two sides of each vertex [%] at a time, where the scene has any: top, bottom.
pub fn moisture(scene: &Scene, mesh: &Mesh, time: f64) -> Result<Option<[Vec<f64>; 2]>> {
    let Some(linear) = scene.rest.as_ref().and_then(|r| r.linear.as_ref()) else { return Ok(None) };
    let side = |key: &str, expr: &Expr| -> Result<Vec<f64>> {
        let field = field(key, expr, scene::PLACE_AND_TIME)?;
        Ok(mesh.vertices.iter().map(|p| field(p, time)).collect())
    };
    Ok(Some([side("rest.linear.m_plus", &linear.m_plus)?, side("rest.linear.m_minus", &linear.m_minus)?]))
}

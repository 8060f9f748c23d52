//! Turns what a scene says into objects: expressions into fields, tables into potentials, supports and rest drivers.
//!
//! An absent table becomes no object. What does not change during a run is made once by `setup` and kept in [`Setup`].

use super::diffusion;
use super::loads;
use super::rest;
use super::setup::{Held, Setup};
use super::supports;
use super::velocity;
use crate::error::{Error, Result};
use crate::math::Expression;
use crate::mesh::{Mesh, Topology};
use crate::model::{FollowingMass, HeldUnknown, Integrator, Model, Motion, Parts, ShellModel};
use crate::scene::{self, Axis, Expr, Scene};
use crate::shell::{Director, Inertia, Inertial, LinearAverage, LinearFree, MassKind, Measure, QuadraticFree, Shell, koiter};
use crate::solve::Relaxation;
use nalgebra::Vector3;

/// Spectral radius of generalised-alpha where the scene has none.
const DEFAULT_RADIUS: f64 = 0.8;

/// A scalar of a place [m] and time [s].
pub type PlaceField = Box<dyn Fn(&Vector3<f64>, f64) -> f64>;

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

/// A scalar of place and time in the initial shape.
pub fn field(key: &str, expr: &Expr, names: &'static [&'static str]) -> Result<PlaceField> {
    let parsed = expression(key, expr, names)?;
    if parsed.is_constant() {
        let value = parsed.eval(&[]);
        return Ok(Box::new(move |_, _| value));
    }
    Ok(Box::new(move |p, t| parsed.eval(&place_values(names, p, t))))
}

/// A number in time.
pub fn of_time(key: &str, expr: &Expr) -> Result<Box<dyn Fn(f64) -> f64>> {
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
    setup.held_directors.iter().for_each(|(edge, support)| supports[*edge] = *support);
    let (materials, constitutions, viscosity) = (setup.materials.clone(), setup.constitutions.clone(), scene.shell.viscosity);
    let measure = match scene.shell.director {
        scene::Director::Average => {
            return koiter(LinearAverage::new(mesh, topology, &supports), materials, constitutions, viscosity);
        }
        scene::Director::FreeSin => Measure::Sin,
        scene::Director::FreeTan => Measure::Tan,
        scene::Director::FreeAngle => Measure::Angle,
    };
    match scene.shell.element {
        scene::Element::Linear => koiter(LinearFree::new(mesh, topology, measure, &supports), materials, constitutions, viscosity),
        scene::Element::Quadratic => {
            let element = QuadraticFree::new(mesh, topology, &mesh.midpoints, measure, &supports);
            koiter(element, materials, constitutions, viscosity)
        }
    }
}

/// Nodes and mass matrices of all faces, the mass that each node carries [kg], and the shares of each face in it.
struct Masses {
    inertia: Box<dyn Inertial>,
    nodes: Vec<f64>,
    shares: Vec<Vec<(usize, f64)>>,
}

/// Masses by thickness, density and rest area at the start; none where the scene has no density.
fn masses(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Option<Masses> {
    let kind = match scene.shell.mass {
        scene::Mass::Consistent => MassKind::Consistent,
        scene::Mass::Lumped => MassKind::Lumped,
    };
    let per_area: Vec<f64> = setup.densities.iter().zip(&setup.materials).map(|(rho, m)| rho * m.thickness).collect();
    (!per_area.is_empty()).then(|| masses_of(kind, &per_area, scene, mesh, topology, setup))
}

/// Inertia of the shell; none where the scene has no density.
pub fn inertia(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Option<Box<dyn Inertial>> {
    masses(scene, mesh, topology, setup).map(|masses| masses.inertia)
}

/// Masses of faces with these masses per rest area at the start [kg/m2].
fn masses_of(kind: MassKind, per_area: &[f64], scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Masses {
    let root = |a: [f64; 3]| (a[0] * a[2] - a[1] * a[1]).sqrt();
    let count = mesh.vertices.len() + mesh.midpoints.len();
    match scene.shell.element {
        scene::Element::Linear => {
            let matrices: Vec<_> = per_area.iter().zip(&setup.rest_forms).map(|(m, f)| kind.linear(0.5 * m * root(f.a))).collect();
            let shares = shares(&mesh.faces, &matrices);
            Masses { inertia: Box::new(Inertia::<3, 9>::new(mesh.faces.clone(), matrices)), nodes: carried(count, &shares), shares }
        }
        scene::Element::Quadratic => {
            let matrices: Vec<_> = per_area
                .iter()
                .zip(setup.rest_forms.chunks_exact(3))
                .map(|(m, f)| kind.quadratic(std::array::from_fn(|k| m * root(f[k].a))))
                .collect();
            let faces: Vec<[usize; 6]> = (0..mesh.faces.len()).map(|f| loads::six_nodes(mesh, topology, f)).collect();
            let shares = shares(&faces, &matrices);
            Masses { inertia: Box::new(Inertia::<6, 18>::new(faces, matrices)), nodes: carried(count, &shares), shares }
        }
    }
}

/// The mass of each face that its nodes carry by their shape functions: the row sums.
fn shares<const K: usize>(faces: &[[usize; K]], matrices: &[[[f64; K]; K]]) -> Vec<Vec<(usize, f64)>> {
    let of = |(face, matrix): (&[usize; K], &[[f64; K]; K])| face.iter().copied().zip(matrix.iter().map(|row| row.iter().sum())).collect();
    faces.iter().zip(matrices).map(of).collect()
}

/// Mass that each of `count` nodes carries [kg].
fn carried(count: usize, shares: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let mut nodes = vec![0.0; count];
    shares.iter().flatten().for_each(|(node, mass)| nodes[*node] += mass);
    nodes
}

/// The whole model at its start.
pub fn model(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<Box<dyn Model>> {
    if scene.cosserat.is_some() {
        return Ok(Box::new(super::grid::model(scene, mesh, topology, setup)?));
    }
    Ok(Box::new(shell_model(scene, mesh, topology, setup)?))
}

/// A Koiter shell at its start.
pub fn shell_model(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<ShellModel> {
    let profiles = diffusion::profiles(scene, mesh)?;
    let masses = masses(scene, mesh, topology, setup);
    let positions = mesh.nodes();
    let held = held_unknowns(scene, mesh, topology, setup)?;
    let loads = loads::build(scene, mesh, topology, &setup.materials, masses.as_ref().map_or(&[], |m| &m.nodes), &held)?;
    let follows = scene.moisture.as_ref().is_some_and(|table| table.added_density.is_some());
    let following_mass = masses.as_ref().filter(|_| follows).map(|masses| FollowingMass {
        densities: setup.densities.clone(),
        carried: masses.shares.clone(),
        nodes: masses.nodes.len(),
    });
    let parts = Parts {
        shell: shell(scene, mesh, topology, setup),
        transports: diffusion::transports(scene, mesh, topology, setup, &profiles)?,
        following_mass,
        inertia: if scene.dynamics.is_some() { masses.map(|m| m.inertia) } else { None },
        loads,
        rest: rest::driver(scene, mesh, topology, setup, &profiles)?,
        initial_forms: setup.initial_forms.clone(),
        velocities: velocity::initial(scene, &held, &positions)?,
        held,
        positions,
    };
    let mut model = ShellModel::new(parts, mesh.diameter(), scene.solver.tolerance, scene.solver.max_iterations)?;
    if scene.output.reactions {
        model.keep_reactions()?;
    }
    if let Some(statics) = scene.statics.as_ref().filter(|s| s.method == scene::Method::DynamicRelaxation) {
        let said = statics.relaxation.clone().unwrap_or_default();
        model.relax_by(Relaxation { tolerance: said.tolerance * mesh.diameter(), max_iterations: said.max_iterations });
    }
    if let Some(dynamics) = &scene.dynamics {
        let tolerance = dynamics.adaptive.as_ref().map(|table| table.tolerance * mesh.diameter());
        model.integrate_by(integrator(dynamics), tolerance);
    }
    if scene.statics.as_ref().is_some_and(|s| s.stable) {
        let areas = masses_of(MassKind::Lumped, &vec![1.0; mesh.faces.len()], scene, mesh, topology, setup).nodes;
        model.leave_unstable(&areas, scene.output.lowest_mode);
    }
    Ok(model)
}

/// The time integration that a scene names.
fn integrator(dynamics: &scene::Dynamics) -> Integrator {
    match dynamics.integrator {
        scene::Integrator::ImplicitEuler => Integrator::ImplicitEuler,
        scene::Integrator::Bdf2 => Integrator::Bdf2,
        scene::Integrator::GeneralisedAlpha => {
            Integrator::GeneralisedAlpha { spectral_radius: dynamics.spectral_radius.unwrap_or(DEFAULT_RADIUS) }
        }
    }
}

/// The supports, with their motions.
pub fn held_unknowns(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<Vec<HeldUnknown>> {
    let positions = mesh.nodes();
    let unknown = |h: &Held| {
        let start = positions.get(h.unknown / 3).map_or(0.0, |p| p[h.unknown % 3]);
        Ok(HeldUnknown { unknown: h.unknown, start, motion: motion(scene, mesh, topology, &positions, h)? })
    };
    setup.held.iter().map(unknown).collect()
}

/// What moves a held unknown, and its key: a pin's displacement [m], or its rotation [rad] about the edge's own direction.
fn motion(scene: &Scene, mesh: &Mesh, topology: &Topology, nodes: &[Vector3<f64>], held: &Held) -> Result<Option<(String, Motion)>> {
    let Some(pin) = held.pin else { return Ok(None) };
    let first_angle = supports::first_angle(mesh);
    if held.unknown < first_angle {
        let Some(expr) = pin_motion(scene, pin, held.unknown % 3) else { return Ok(None) };
        let key = format!("pin.{pin}.motion.{}", ["x", "y", "z"][held.unknown % 3]);
        let parsed = expression(&key, expr, scene::POSITION_AND_TIME)?;
        let p = nodes[held.unknown / 3];
        return Ok(Some((key, Box::new(move |t| parsed.eval(&[p.x, p.y, p.z, t])))));
    }
    let Some(scene::PinDirector::Rotation(rotation)) = scene.pins.get(pin).and_then(|p| p.director.as_ref()) else { return Ok(None) };
    let edge = topology.edges[(held.unknown - first_angle) / supports::angles_per_edge(scene)];
    let sense =
        supports::edge_sense(mesh, edge, &rotation.axis).map_err(|e| Error::input(format!("pin.{pin}.director.rotation.axis"), e))?;
    let key = format!("pin.{pin}.director.rotation.angle");
    let angle = of_time(&key, &rotation.angle)?;
    Ok(Some((key, Box::new(move |t| sense * angle(t).to_radians()))))
}

/// The prescribed displacement along an axis of a pin, if it has one.
pub fn pin_motion(scene: &Scene, pin: usize, axis: usize) -> Option<&Expr> {
    let motion = scene.pins.get(pin)?.motion.as_ref()?;
    [&motion.x, &motion.y, &motion.z][axis].as_ref()
}

//! The diffusion of a scene as objects: slab, boundary conditions, first values, and what rest laws read of it.

use super::build::{expression, place_values};
use super::rest::mesh_field;
use super::setup::{Setup, region};
use crate::error::{Error, Result};
use crate::mesh::{FieldSampler, Mesh, Topology};
use crate::model::{Profile, Transport};
use crate::moisture::{self, Condition, Diffusion, Law, Mass, Slab, Source, Where};
use crate::scene::{self, Expr, Scalar, Scene};
use crate::shell::rest::Forms;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// What diffuses, as rest laws read it: by the names of the quantities; empty where nothing does.
pub type Profiles = BTreeMap<&'static str, Profile>;

/// Moisture of what has given off all its water [%].
const BONE_DRY: f64 = -100.0;

/// The profiles of a scene at the start.
///
/// # Errors
/// A field that the mesh has not, first values that are not finite.
pub fn profiles(scene: &Scene, mesh: &Mesh) -> Result<Profiles> {
    let mut profiles = Profiles::new();
    for (table, name, _, diffusion) in scene.diffusing() {
        let levels = levels(diffusion);
        let values = initial(table, diffusion, mesh, &levels)?;
        profiles.insert(name, Profile::new(mesh.faces.clone(), levels, diffusion.seen == scene::Seen::Faces, values));
    }
    Ok(profiles)
}

/// Everything that diffuses, its values being those of the profiles.
///
/// # Errors
/// Regions that do not exist or have nothing to offer.
pub fn transports(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup, profiles: &Profiles) -> Result<Vec<Transport>> {
    let mut transports = Vec::new();
    for (table, name, unit, said) in scene.diffusing() {
        let Some(profile) = profiles.get(name) else { continue };
        let positions: Rc<[Vector3<f64>]> = mesh.vertices.clone().into();
        let slab = slab(table, said, mesh, setup, profile.levels())?;
        let conditions = said.boundaries.iter().enumerate();
        let conditions = conditions
            .map(|(i, boundary)| condition(&format!("{table}.boundary.{i}"), boundary, mesh, topology, &positions))
            .collect::<Result<Vec<_>>>()?;
        let source = said.source.as_ref().map(|expr| source(&format!("{table}.source"), expr, &positions)).transpose()?;
        let mass = match said.mass {
            scene::DiffusionMass::Lumped => Mass::Lumped,
            scene::DiffusionMass::Consistent => Mass::Consistent,
        };
        let scheme = match said.scheme {
            scene::Scheme::BackwardEuler => moisture::Scheme::BackwardEuler,
            scene::Scheme::Sdirk2 => moisture::Scheme::Sdirk2,
        };
        let mut diffusion = Diffusion::new(slab, conditions, source, mass, scheme, said.dt)?;
        diffusion.set(profile.values().to_vec());
        if table == "moisture" {
            diffusion.require_at_least(BONE_DRY);
        }
        let stiffness = said.stiffness.as_ref().map(|expr| -> Result<Box<dyn Fn(f64) -> f64>> {
            let parsed = expression(&format!("{table}.stiffness"), expr, scene::DIFFUSED)?;
            Ok(Box::new(move |u| parsed.eval(&[u])))
        });
        transports.push(Transport {
            table,
            name,
            unit,
            diffusion,
            profile: profile.clone(),
            reads_heights: said.boundaries.iter().any(|boundary| boundary.below.is_some()),
            stiffness: stiffness.transpose()?,
            added_density: said.added_density,
        });
    }
    Ok(transports)
}

/// Heights of the levels as fractions of the thickness.
fn levels(table: &scene::Diffusion) -> Vec<f64> {
    let layers = table.layers();
    match (&table.levels, table.spacing.unwrap_or_default()) {
        (Some(levels), _) => levels.clone(),
        (None, scene::Spacing::Cosine) => moisture::cosine_levels(layers),
        (None, scene::Spacing::Uniform) => (0..=layers).map(|i| i as f64 / layers as f64).collect(),
    }
}

/// First values, level by level over each vertex.
fn initial(table: &str, said: &scene::Diffusion, mesh: &Mesh, levels: &[f64]) -> Result<Vec<f64>> {
    let key = format!("{table}.initial");
    let text = |expr: &Expr| expression(&key, expr, scene::BODY);
    let mut factor = None;
    let (parsed, sampler) = match &said.initial {
        Scalar::Expr(expr) => (Some(text(expr)?), None),
        Scalar::Field(named) => {
            factor = named.times.as_ref().map(text).transpose()?;
            (None, Some(mesh_field(mesh, &format!("{key}.field"), &named.field, 1)?))
        }
    };
    let of_vertices = sampler.map(|sampler| at_vertices(mesh, &sampler));
    let mut values = Vec::with_capacity(mesh.vertices.len() * levels.len());
    for (v, p) in mesh.vertices.iter().enumerate() {
        for level in levels {
            let mut place = place_values(scene::PLACE, p, 0.0);
            place.push(2.0 * level - 1.0);
            let value = match (&parsed, &of_vertices) {
                (Some(parsed), _) => parsed.eval(&place),
                (None, Some(field)) => field[v] * factor.as_ref().map_or(1.0, |factor| factor.eval(&place)),
                (None, None) => 0.0,
            };
            let dry = table == "moisture" && value < BONE_DRY * (1.0 + 1e-9);
            if dry || !value.is_finite() {
                let why = if dry { format!(" %, but {BONE_DRY} % is bone dry already") } else { String::new() };
                return Err(Error::input(key, format!("is {value}{why} at vertex {v}, ({}, {}, {}) m", p.x, p.y, p.z)));
            }
            values.push(value);
        }
    }
    Ok(values)
}

/// A field at the vertices: of the faces, the mean of those around.
fn at_vertices(mesh: &Mesh, sampler: &FieldSampler) -> Vec<f64> {
    let (mut sums, mut counts) = (vec![0.0; mesh.vertices.len()], vec![0.0; mesh.vertices.len()]);
    for (f, face) in mesh.faces.iter().enumerate() {
        for (v, place) in face.iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            sums[*v] += sampler.at(f, place).map_or(f64::NAN, |value| value[0]);
            counts[*v] += 1.0;
        }
    }
    sums.iter().zip(counts).map(|(sum, count)| sum / count).collect()
}

/// Geometry and conductivity: the rest shape at the start, of which each face has one metric, as its mass has.
fn slab(table: &str, said: &scene::Diffusion, mesh: &Mesh, setup: &Setup, levels: &[f64]) -> Result<Slab> {
    let mut coefficients = vec![said.diffusivity; mesh.faces.len()];
    for (i, part) in said.regions.iter().enumerate() {
        let key = format!("{table}.region.{i}.region");
        let faces = &region(mesh, &key, &part.region)?.faces;
        nothing(faces.is_empty(), &key, &part.region, "faces")?;
        faces.iter().for_each(|f| coefficients[*f] = part.diffusivity);
    }
    let points = setup.rest_forms.len() / mesh.faces.len();
    let mean = |forms: &[Forms]| std::array::from_fn(|c| forms.iter().map(|form| form.a[c]).sum::<f64>() / points as f64);
    let metric: Vec<[f64; 3]> = setup.rest_forms.chunks_exact(points).map(mean).collect();
    let tensor = |f: usize, d: &scene::Diffusivity| {
        let direction = setup.machine_direction.as_ref().map_or([1.0, 0.0], |directions| directions[f]);
        moisture::in_plane_tensor(metric[f], direction, d.along, d.across.unwrap_or(d.along))
    };
    Ok(Slab {
        vertices: mesh.vertices.len(),
        faces: mesh.faces.clone(),
        thickness: setup.materials.iter().map(|m| m.thickness).collect(),
        in_plane: coefficients.iter().enumerate().map(|(f, d)| tensor(f, d)).collect(),
        through: coefficients.iter().map(|d| d.through).collect(),
        levels: levels.to_vec(),
        metric,
    })
}

fn condition(key: &str, said: &scene::Boundary, mesh: &Mesh, topology: &Topology, positions: &Rc<[Vector3<f64>]>) -> Result<Condition> {
    let named = said.region.as_ref().map(|name| region(mesh, &format!("{key}.region"), name)).transpose()?;
    let name = said.region.as_deref().unwrap_or_default();
    let place = match said.side {
        scene::Side::Rim => {
            let wanted: Option<BTreeSet<[usize; 2]>> = named.map(|region| region.edges.iter().copied().collect());
            let boundary = topology.edges.iter().zip(&topology.edge_faces).filter(|(_, sides)| sides.iter().flatten().count() == 1);
            let edges: Vec<(usize, usize)> = boundary
                .filter(|(edge, _)| wanted.as_ref().is_none_or(|wanted| wanted.contains(*edge)))
                .flat_map(|(_, sides)| sides.iter().flatten().map(|side| (side.face, side.local)))
                .collect();
            let what = if named.is_some() { "edges on the boundary" } else { "rim: the mesh is closed" };
            nothing(edges.is_empty(), &format!("{key}.{}", if named.is_some() { "region" } else { "side" }), name, what)?;
            Where::Rim { edges }
        }
        scene::Side::Top | scene::Side::Bottom => {
            let faces = named.map_or((0..mesh.faces.len()).collect(), |region| region.faces.clone());
            nothing(faces.is_empty(), &format!("{key}.region"), name, "faces")?;
            let side = if said.side == scene::Side::Top { moisture::Side::Top } else { moisture::Side::Bottom };
            Where::Side { side, faces }
        }
    };
    let data = |name: &str, expr: &Expr| -> Result<moisture::Data> {
        let parsed = expression(&format!("{key}.{name}"), expr, scene::PLACE_AND_TIME)?;
        if parsed.is_constant() {
            let value = parsed.eval(&[]);
            return Ok(Box::new(move |_, _| value));
        }
        let positions = Rc::clone(positions);
        Ok(Box::new(move |vertex, t| parsed.eval(&place_values(scene::PLACE_AND_TIME, &positions[vertex], t))))
    };
    let law = match (&said.value, &said.flux, &said.exchange) {
        (Some(value), ..) => Law::Value(data("value", value)?),
        (None, Some(flux), _) => Law::Flux(data("flux", flux)?),
        (None, None, Some(air)) => Law::Exchange { coefficient: air.coefficient, outside: data("exchange.outside", &air.outside)? },
        (None, None, None) => return Err(Error::input(key, "exactly one of `value`, `flux` and `exchange` must be given")),
    };
    let window = [said.from.unwrap_or(f64::NEG_INFINITY), said.until.unwrap_or(f64::INFINITY)];
    Ok(Condition { place, law, window, below: said.below })
}

fn source(key: &str, expr: &Expr, positions: &Rc<[Vector3<f64>]>) -> Result<Source> {
    let (parsed, positions) = (expression(key, expr, scene::BODY_AND_TIME)?, Rc::clone(positions));
    let rate = move |vertex: usize, height: f64, t: f64| {
        let mut values = place_values(scene::PLACE, &positions[vertex], 0.0);
        values.extend([2.0 * height - 1.0, t]);
        parsed.eval(&values)
    };
    Ok(Source { rate: Box::new(rate) })
}

fn nothing(empty: bool, key: &str, region: &str, what: &str) -> Result<()> {
    match (empty, region.is_empty()) {
        (false, _) => Ok(()),
        (true, true) => Err(Error::input(key, format!("there is no {what}"))),
        (true, false) => Err(Error::input(key, format!("region '{region}' has no {what} through which something could enter"))),
    }
}

//! The loads of a scene as nodal forces and pressures, consistent with the element's shape functions.

use super::build::{expression, field, of_time};
use super::setup::region;
use super::supports::{angles_per_edge, first_angle};
use crate::error::{Error, Result};
use crate::load::{DeadLoad, EdgeMoment, Load, Pressure, SpreadLoad, SurfacePiece, VectorField, Viewpoint, Wind};
use crate::math::SurfacePoint;
use crate::math::quadrature::{GAUSS, GAUSS_2, linear_radon, linear_triangle, quadratic_triangle};
use crate::mesh::{Mesh, Topology};
use crate::model::{AppliedLoad, HeldUnknown, Motion};
use crate::scene::{self, Expr, Scene, SpreadForce};
use crate::shell::Material;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Column of the history.
const PRESSURE_ENERGY: &str = "pressure_energy_J";

/// All loads of a scene; none of an absent table. `materials`: of each face. `carried`: mass that each node carries [kg], for weight. `held`: what
/// supports hold.
///
/// # Errors
/// Regions that do not exist or have nothing to load; a pressure without energy where stable states are asked for.
pub fn build(
    scene: &Scene,
    mesh: &Mesh,
    topology: &Topology,
    materials: &[Material],
    carried: &[f64],
    held: &[HeldUnknown],
) -> Result<Vec<AppliedLoad>> {
    let mut loads = Vec::new();
    let mut add = |key: String, energy_name: Option<&'static str>, potential: Box<dyn Load>, factor: &Option<Expr>| -> Result<()> {
        let factor = load_factor(scene, &key, factor)?;
        loads.push(AppliedLoad { key, energy_name, potential, factor });
        Ok(())
    };
    if let Some(table) = &scene.gravity {
        let (acceleration, changes) = vector_field("gravity.acceleration", &table.acceleration)?;
        let weight = DeadLoad::weight(carried, &mesh.nodes()[..carried.len()], acceleration, changes);
        let factor = own_factor(&table.factor, changes);
        add("gravity.factor".into(), Some("gravity_energy_J"), Box::new(weight), &factor)?;
    }
    for (i, table) in scene.forces.iter().enumerate() {
        let vertices = &region(mesh, &format!("force.{i}.region"), &table.region)?.vertices;
        nothing(vertices.is_empty(), &format!("force.{i}.region"), &table.region, "vertices")?;
        let forces = vertices.iter().map(|v| (*v, Vector3::from(table.force))).collect();
        add(format!("force.{i}.factor"), Some("force_energy_J"), Box::new(DeadLoad::new(forces)), &table.factor)?;
    }
    for (i, table) in scene.edge_loads.iter().enumerate() {
        let pairs: BTreeSet<[usize; 2]> = region(mesh, &format!("edge-load.{i}.region"), &table.region)?.edges.iter().copied().collect();
        nothing(pairs.is_empty(), &format!("edge-load.{i}.region"), &table.region, "edges")?;
        let mut lengths = BTreeMap::new();
        for e in (0..topology.edges.len()).filter(|e| pairs.contains(&topology.edges[*e])) {
            for (node, length) in edge_shares(mesh, topology, e) {
                *lengths.entry(node).or_insert(0.0) += length;
            }
        }
        let force = Vector3::from(table.force);
        let forces = lengths.into_iter().map(|(node, length)| (node, force * length)).collect();
        add(format!("edge-load.{i}.factor"), Some("edge_load_energy_J"), Box::new(DeadLoad::new(forces)), &table.factor)?;
    }
    for (i, table) in scene.moments.iter().enumerate() {
        let pairs: BTreeSet<[usize; 2]> = region(mesh, &format!("moment.{i}.region"), &table.region)?.edges.iter().copied().collect();
        nothing(pairs.is_empty(), &format!("moment.{i}.region"), &table.region, "edges")?;
        let (moment, count, first) = (Vector3::from(table.moment), angles_per_edge(scene), first_angle(mesh));
        let mut moments = Vec::new();
        for e in (0..topology.edges.len()).filter(|e| pairs.contains(&topology.edges[*e])) {
            for (g, tangent) in angle_tangents(mesh, topology, e).into_iter().enumerate() {
                // The tangent carries the length, so this is the integral of the moment's part along the edge.
                moments.push((first + count * e + g, moment.dot(&tangent) / count as f64));
            }
        }
        add(format!("moment.{i}.factor"), None, Box::new(EdgeMoment::new(moments)), &table.factor)?;
    }
    let mut has_energy = true;
    for (i, table) in scene.pressures.iter().enumerate() {
        let faces = faces(mesh, &format!("pressure.{i}.region"), table.region.as_deref())?;
        let key = format!("pressure.{i}.pressure");
        let parsed = expression(&key, &table.pressure, scene::PLACE_AND_TIME)?;
        let constant = parsed.is_constant().then(|| parsed.eval(&[]));
        let value = || field(&key, &table.pressure, scene::PLACE_AND_TIME);
        let view = viewpoint(&faces, mesh, topology, held);
        let (potential, energy): (Box<dyn Load>, bool) = if mesh.midpoints.is_empty() {
            let nodes = faces.iter().map(|f| mesh.faces[*f]).collect();
            let pressure = match constant {
                Some(p) => Pressure::<3, 9>::new(nodes, linear_triangle().to_vec(), p),
                None => Pressure::varying(nodes, linear_radon().to_vec(), value()?, &mesh.nodes(), mesh.diameter()),
            };
            with_energy(pressure, view)
        } else {
            let nodes = faces.iter().map(|f| six_nodes(mesh, topology, *f)).collect();
            let points = quadratic_triangle().to_vec();
            let pressure = match constant {
                Some(p) => Pressure::<6, 18>::new(nodes, points, p),
                None => Pressure::varying(nodes, points, value()?, &mesh.nodes(), mesh.diameter()),
            };
            with_energy(pressure, view)
        };
        if !energy && scene.statics.as_ref().is_some_and(|statics| statics.stable) {
            let why = if view.is_none() {
                "with edges that are neither held nor in planes of symmetry"
            } else {
                "that is not finite beneath the surface"
            };
            return Err(Error::input(
                "statics.stable",
                format!("needs an energy to tell stable states by, which pressure.{i}, one {why}, has not"),
            ));
        }
        has_energy &= energy;
        let factor = own_factor(&table.factor, parsed.uses("t"));
        add(format!("pressure.{i}.factor"), Some(PRESSURE_ENERGY), potential, &factor)?;
    }
    for (i, table) in scene.surface_loads.iter().enumerate() {
        let (load, changes) = spread(&format!("surface-load.{i}"), table, mesh, topology, |_| 1.0)?;
        add(format!("surface-load.{i}.factor"), Some("surface_load_energy_J"), Box::new(load), &own_factor(&table.factor, changes))?;
    }
    for (i, table) in scene.body_forces.iter().enumerate() {
        let (load, changes) = spread(&format!("body-force.{i}"), table, mesh, topology, |face| materials[face].thickness)?;
        add(format!("body-force.{i}.factor"), Some("body_force_energy_J"), Box::new(load), &own_factor(&table.factor, changes))?;
    }
    for (i, table) in scene.winds.iter().enumerate() {
        let faces = faces(mesh, &format!("wind.{i}.region"), table.region.as_deref())?;
        let (air, _) = vector_field(&format!("wind.{i}.velocity"), &table.velocity)?;
        let coefficients = [table.normal, table.tangential];
        let potential: Box<dyn Load> = if mesh.midpoints.is_empty() {
            let nodes = faces.iter().map(|f| mesh.faces[*f]).collect();
            Box::new(Wind::<3, 9>::new(nodes, linear_radon().to_vec(), &mesh.nodes(), air, table.density, coefficients))
        } else {
            let nodes = faces.iter().map(|f| six_nodes(mesh, topology, *f)).collect();
            Box::new(Wind::<6, 18>::new(nodes, quadratic_triangle().to_vec(), &mesh.nodes(), air, table.density, coefficients))
        };
        add(format!("wind.{i}.factor"), None, potential, &Some(Expr::Number(1.0)))?;
    }
    if !has_energy {
        // One column has the sum of all.
        loads.iter_mut().filter(|load| load.energy_name == Some(PRESSURE_ENERGY)).for_each(|load| load.energy_name = None);
    }
    Ok(loads)
}

/// A pressure with its energy seen from `view`, if it has one there, and whether it has.
fn with_energy<const K: usize, const N: usize>(pressure: Pressure<K, N>, view: Option<Viewpoint>) -> (Box<dyn Load>, bool)
where
    Pressure<K, N>: Load + 'static,
{
    let pressure = pressure.seen_from(view);
    let energy = view.is_some() && pressure.is_finite_beneath(0.0);
    (Box::new(if energy { pressure } else { pressure.seen_from(None) }), energy)
}

/// Where the volume under loaded faces is to be seen from for their pressure to have an energy; none where their rim moves otherwise than in
/// planes of symmetry across the axes.
fn viewpoint(faces: &[usize], mesh: &Mesh, topology: &Topology, held: &[HeldUnknown]) -> Option<Viewpoint> {
    let loaded: BTreeSet<usize> = faces.iter().copied().collect();
    let moves: BTreeMap<usize, bool> = held.iter().map(|h| (h.unknown, h.motion.is_some())).collect();
    let (positions, near) = (mesh.nodes(), 1e-9 * mesh.diameter());
    let mut planes: [Vec<f64>; 3] = Default::default();
    for (e, pair) in topology.edges.iter().enumerate() {
        if topology.edge_faces[e].iter().flatten().filter(|side| loaded.contains(&side.face)).count() != 1 {
            continue;
        }
        let middle = (!mesh.midpoints.is_empty()).then_some(mesh.vertices.len() + e);
        let nodes: Vec<usize> = pair.iter().copied().chain(middle).collect();
        if nodes.iter().all(|n| (0..3).all(|k| moves.contains_key(&(3 * n + k)))) {
            continue;
        }
        let at = |k: usize| positions[nodes[0]][k];
        let stays = |n: &usize, k: usize| moves.get(&(3 * n + k)) == Some(&false) && (positions[*n][k] - at(k)).abs() <= near;
        let k = (0..3).find(|k| nodes.iter().all(|n| stays(n, *k)))?;
        if planes[k].iter().all(|c| (c - at(k)).abs() > near) {
            planes[k].push(at(k));
        }
    }
    let axes = [0, 1, 2].map(|k| planes[k].len() < 2);
    let origin = Vector3::from_fn(|k, _| planes[k].first().copied().unwrap_or(0.0));
    axes.contains(&true).then_some(Viewpoint { origin, axes })
}

/// The faces of a region, of which there must be some, or all.
fn faces(mesh: &Mesh, key: &str, name: Option<&str>) -> Result<Vec<usize>> {
    let faces = match name {
        Some(name) => region(mesh, key, name)?.faces.clone(),
        None => (0..mesh.faces.len()).collect(),
    };
    nothing(faces.is_empty(), key, name.unwrap_or(""), "faces")?;
    Ok(faces)
}

/// A force that is spread over faces, each with a depth [m, or 1 for a force per area], and whether it depends on time.
fn spread(key: &str, table: &SpreadForce, mesh: &Mesh, topology: &Topology, depth: impl Fn(usize) -> f64) -> Result<(SpreadLoad, bool)> {
    let faces = faces(mesh, &format!("{key}.region"), table.region.as_deref())?;
    let (field, changes) = vector_field(&format!("{key}.force"), &table.force)?;
    let positions = mesh.nodes();
    let mut pieces = Vec::new();
    for face in faces {
        if mesh.midpoints.is_empty() {
            pieces.extend(linear_radon().iter().map(|point| piece(&mesh.faces[face], point, &positions, depth(face))));
        } else {
            let nodes = six_nodes(mesh, topology, face);
            pieces.extend(quadratic_triangle().iter().map(|point| piece(&nodes, point, &positions, depth(face))));
        }
    }
    Ok((SpreadLoad::new(pieces, field, changes), changes))
}

/// A quadrature point of a face in its initial shape.
fn piece<const K: usize>(nodes: &[usize; K], point: &SurfacePoint<K>, positions: &[Vector3<f64>], depth: f64) -> SurfacePiece {
    let sum = |weights: &[f64; K]| nodes.iter().zip(weights).map(|(n, w)| positions[*n] * *w).sum::<Vector3<f64>>();
    let size = sum(&point.slopes[0]).cross(&sum(&point.slopes[1])).norm() * point.weight * depth;
    SurfacePiece { place: sum(&point.shape), shares: nodes.iter().copied().zip(point.shape.map(|n| n * size)).collect() }
}

/// A vector of place and time, and whether it depends on time.
fn vector_field(key: &str, exprs: &[Expr; 3]) -> Result<(VectorField, bool)> {
    let mut changes = false;
    for expr in exprs {
        changes |= expression(key, expr, scene::PLACE_AND_TIME)?.uses("t");
    }
    let component = |k: usize| field(&format!("{key}.{k}"), &exprs[k], scene::PLACE_AND_TIME);
    let [x, y, z] = [component(0)?, component(1)?, component(2)?];
    Ok((Box::new(move |p, t| Vector3::new(x(p, t), y(p, t), z(p, t))), changes))
}

/// The factor of a load that may depend on time by itself, and then does not grow with the load factor.
fn own_factor(factor: &Option<Expr>, changes: bool) -> Option<Expr> {
    factor.clone().or(changes.then_some(Expr::Number(1.0)))
}

/// Nodes of a curved face: its vertices, then the middle of edge `i`, opposite vertex `i`.
pub fn six_nodes(mesh: &Mesh, topology: &Topology, face: usize) -> [usize; 6] {
    std::array::from_fn(|p| if p < 3 { mesh.faces[face][p] } else { mesh.vertices.len() + topology.face_edges[face][p - 3] })
}

/// Tangents of an edge [m] at its director angles, from the lower vertex to the higher.
pub fn angle_tangents(mesh: &Mesh, topology: &Topology, e: usize) -> Vec<Vector3<f64>> {
    let [p, q] = topology.edges[e].map(|v| mesh.vertices[v]);
    let Some(middle) = mesh.midpoints.get(e) else { return vec![q - p] };
    GAUSS_2.iter().map(|t| p * (4.0 * t - 3.0) + q * (4.0 * t - 1.0) + middle * (4.0 - 8.0 * t)).collect()
}

/// The length of an edge that each of its nodes carries [m]: the integrals of their shape functions.
fn edge_shares(mesh: &Mesh, topology: &Topology, e: usize) -> Vec<(usize, f64)> {
    let [a, b] = topology.edges[e];
    let (p, q) = (mesh.vertices[a], mesh.vertices[b]);
    let Some(middle) = mesh.midpoints.get(e) else {
        let half = 0.5 * (q - p).norm();
        return vec![(a, half), (b, half)];
    };
    let mut shares = [0.0; 3];
    for (t, weight) in GAUSS {
        let tangent = p * (4.0 * t - 3.0) + q * (4.0 * t - 1.0) + middle * (4.0 - 8.0 * t);
        let shape = [(1.0 - t) * (1.0 - 2.0 * t), t * (2.0 * t - 1.0), 4.0 * t * (1.0 - t)];
        shares.iter_mut().zip(shape).for_each(|(s, n)| *s += weight * n * tangent.norm());
    }
    [a, b, mesh.vertices.len() + e].into_iter().zip(shares).collect()
}

fn nothing(empty: bool, key: &str, region: &str, what: &str) -> Result<()> {
    if empty { Err(Error::input(key, format!("region '{region}' has no {what} that could be loaded"))) } else { Ok(()) }
}

/// A load's factor in time: as given, else the load factor; none where the run is in time.
pub fn load_factor(scene: &Scene, key: &str, factor: &Option<Expr>) -> Result<Option<Motion>> {
    match factor {
        Some(expr) => Ok(Some(of_time(key, expr)?)),
        None if !scene.runs_in_time() => Ok(Some(Box::new(|t| t))),
        None => Ok(None),
    }
}

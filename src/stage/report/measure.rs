//! What the measures of a scene mean: each as a number of a case that has run.

use super::super::build::{self, place_values};
use super::super::fields::State;
use super::super::grid_fields::Shown;
use super::super::{mesh as mesh_stage, modes, setup};
use super::case::{Case, When, time_within};
use super::reactions;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology, conformal};
use crate::report::shapes::{Shape, asymmetry};
use crate::report::{Surface, Waves, curvature, cylinder_distance, mean, median, nodes_distance, surface_distance, vertex_areas, waves};
use crate::scene::{self, CurvatureKind, Distance, EnergyPart, Expr, Measure, Scene, Statistic, Weighting};
use crate::snapshot::{Association, Field};
use nalgebra::Vector3;

impl Case<'_> {
    /// A measure in its unit; not finite where it has no value.
    ///
    /// # Errors
    /// Places, regions, fields and columns that are not there, which [`super::check_measures`] finds before a run.
    pub fn measure(&self, measure: &Measure, when: When) -> Result<f64> {
        let (scene, mesh) = (&self.job.scene, &self.mesh);
        match measure {
            Measure::Displacement { at, axis, region } => {
                let (vertex, axis) = (vertex_at(mesh, "report", at, region.as_deref())?, build::axis_index(*axis));
                Ok(self.positions(when)?[vertex][axis] - mesh.vertices[vertex][axis])
            }
            Measure::Reaction { region, axis } => {
                let forces = reactions::forces(mesh, &self.snapshot(when)?, "report", region)?;
                Ok(forces.iter().map(|(_, f)| f[build::axis_index(*axis)]).sum())
            }
            Measure::ReactionMoment { region, axis, about } => {
                let snapshot = self.snapshot(when)?;
                let moment = reactions::moment(mesh, &snapshot, &self.positions(when)?, region, &Vector3::from(*about))?;
                Ok(moment[build::axis_index(*axis)])
            }
            Measure::Frequency { mode } | Measure::BucklingFactor { mode } => {
                let found = modes::load(self.job)?;
                Ok(found.and_then(|found| found.values.get(mode - 1).copied()).unwrap_or(f64::NAN))
            }
            Measure::DistanceBetween { a, b } => {
                let (a, b) = (vertex_at(mesh, "report", a, None)?, vertex_at(mesh, "report", b, None)?);
                let positions = self.positions(when)?;
                Ok((positions[b] - positions[a]).norm())
            }
            Measure::CylinderDistance { radius } => Ok(cylinder_distance(&mesh.nodes(), &self.positions(when)?, *radius)),
            Measure::SurfaceDistance { position, kind, mirror, over } => {
                let exact = Image::new("report: surface-distance.position", position, mesh, *kind)?;
                Ok(exact.distance(mesh, &self.positions(when)?, *mirror) / over.unwrap_or(1.0))
            }
            Measure::OriginalDistance { kind, mirror, over } => {
                let original = Image::original("report: original-distance", mesh, *kind)?;
                Ok(original.distance(mesh, &self.positions(when)?, *mirror) / over.unwrap_or(1.0))
            }
            Measure::Asymmetry { axis, at, over } => {
                let shape = Shape { places: mesh.nodes(), positions: self.positions(when)? };
                Ok(asymmetry(&shape, build::axis_index(*axis), *at) / over.unwrap_or(1.0))
            }
            Measure::CurvatureSquare { of, weighting } => Ok(curvature_square(mesh, &self.positions(when)?, *of, *weighting)),
            Measure::Waves { region } => Ok(self.waves(region, when)?.map_or(f64::NAN, |w| w.number as f64)),
            Measure::WaveAmplitude { region } => Ok(self.waves(region, when)?.map_or(f64::NAN, |w| w.amplitude)),
            Measure::Energy { part, over } => {
                let snapshot = self.snapshot(when)?;
                let topology = Topology::new(&mesh.faces);
                let energies = Shown::new(scene, mesh, &topology, &self.setup)?.energies(&snapshot, &snapshot)?;
                Ok(take(energies, *part) / energy_scale("report: energy.over", over.as_ref(), scene)?)
            }
            Measure::EnergyRatio { part } => {
                let snapshot = self.snapshot(when)?;
                let topology = Topology::new(&mesh.faces);
                let mut fields = Shown::new(scene, mesh, &topology, &self.setup)?;
                let initial = fields.energies(&self.start, &snapshot)?;
                Ok(take(fields.energies(&snapshot, &snapshot)?, *part) / take(initial, *part))
            }
            Measure::Field { name, component, statistic, minus, region } => {
                self.statistic(name, *component, *statistic, minus.as_ref(), region.as_deref(), when)
            }
            Measure::LoadFactor | Measure::TimeReached => Ok(self.snapshot(when)?.time),
            Measure::TimeWithin { column, least, most } => Ok(time_within(self.history(), column, [*least, *most])),
            Measure::History { column } => self.told(column, when),
            Measure::NewtonIterations => Ok(self.told("newton_iterations", when)? + self.told("fallback_iterations", when)?),
            Measure::Factorizations => self.told("factorizations", when),
        }
    }

    fn waves(&self, region: &str, when: When) -> Result<Option<Waves>> {
        let rim = rim(&self.mesh, "report", region)?;
        let along = |nodes: &[Vector3<f64>]| -> Vec<Vector3<f64>> { rim.iter().map(|v| nodes[*v]).collect() };
        Ok(waves(&along(&self.mesh.nodes()), &along(&self.positions(when)?)))
    }

    fn statistic(
        &self,
        name: &str,
        component: usize,
        statistic: Statistic,
        minus: Option<&Expr>,
        region: Option<&str>,
        when: When,
    ) -> Result<f64> {
        let topology = Topology::new(&self.mesh.faces);
        let snapshot = self.snapshot(when)?;
        let state = Shown::new(&self.job.scene, &self.mesh, &topology, &self.setup)?.of(&snapshot)?;
        // Scenes name fields with hyphens, as all their keywords; files with underscores.
        let name = name.replace('-', "_");
        let found = state.cell_data.iter().chain(&state.point_data).find(|f| f.name == name);
        let Some(field) = found else {
            let known: Vec<&str> = state.cell_data.iter().chain(&state.point_data).map(|f| f.name.as_str()).collect();
            return Err(Error::input_with_help(
                "report",
                format!("there is no field '{name}'"),
                format!("there are: {}", known.join(", ")),
            ));
        };
        if component >= field.components {
            return Err(Error::input(
                "report",
                format!("field '{name}' has {} components, {component} is not among them (they count from 0)", field.components),
            ));
        }
        let mut values: Vec<f64> = field.data.iter().skip(component).step_by(field.components).copied().collect();
        if let Some(minus) = minus {
            let minus = build::field("report: field.minus", minus, scene::PLACE_AND_TIME)?;
            let mesh = &self.mesh;
            let places: Vec<Vector3<f64>> = match field.association {
                Association::Face => {
                    mesh.faces.iter().map(|face| face.iter().map(|v| mesh.vertices[*v]).sum::<Vector3<f64>>() / 3.0).collect()
                }
                _ => mesh.nodes(),
            };
            values.iter_mut().zip(&places).for_each(|(value, place)| *value -= minus(place, snapshot.time));
        }
        let mut weights = weights(&self.mesh, &state, field);
        if let Some(region) = region {
            let members = members(&self.mesh, "report", region, field.association)?;
            values = members.iter().map(|i| values[*i]).collect();
            weights = members.iter().filter_map(|i| weights.get(*i)).copied().collect();
        }
        Ok(match statistic {
            Statistic::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Statistic::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Statistic::Mean => mean(&values, &weights),
            Statistic::Median => median(&values, &weights),
            Statistic::Magnitude => values.iter().fold(0.0, |m, v| m.max(v.abs())),
            Statistic::Rms => mean(&values.iter().map(|v| v * v).collect::<Vec<_>>(), &weights).sqrt(),
        })
    }
}

/// Rest areas that belong to the faces, or to the vertices, which come before other nodes: these have none.
fn weights(mesh: &Mesh, state: &State, field: &Field) -> Vec<f64> {
    if field.association == Association::Face {
        return state.areas.clone();
    }
    let mut weights = vec![0.0; mesh.vertices.len()];
    for (face, area) in mesh.faces.iter().zip(&state.areas) {
        face.iter().for_each(|v| weights[*v] += area / 3.0);
    }
    weights
}

/// The faces or vertices of a region, of which there must be some.
pub fn members(mesh: &Mesh, key: &str, region: &str, association: Association) -> Result<Vec<usize>> {
    let found = setup::region(mesh, key, region)?;
    let (members, what) = if association == Association::Face { (&found.faces, "faces") } else { (&found.vertices, "vertices") };
    if members.is_empty() {
        return Err(Error::input(key, format!("region '{region}' has no {what}")));
    }
    Ok(members.clone())
}

/// The vertices of a closed rim in their order.
pub fn rim(mesh: &Mesh, key: &str, region: &str) -> Result<Vec<usize>> {
    let found = setup::region(mesh, key, region)?;
    crate::report::waves::closed_loop(found).map_err(|e| Error::input(key, format!("region '{region}' {e}")))
}

fn take([membrane, bending]: [f64; 2], part: EnergyPart) -> f64 {
    match part {
        EnergyPart::Membrane => membrane,
        EnergyPart::Bending => bending,
        EnergyPart::Total => membrane + bending,
    }
}

/// The energy [J] that energies are divided by.
///
/// # Errors
/// One that is not positive for this shell, or that asks for moduli which `[shell]` does not state.
pub fn energy_scale(key: &str, over: Option<&Expr>, scene: &Scene) -> Result<f64> {
    let Some(over) = over else { return Ok(1.0) };
    let (s, over) = (&scene.shell, build::expression(key, over, scene::SHELL)?);
    for (name, what, value) in [("E", "youngs_modulus", s.youngs_modulus), ("nu", "poissons_ratio", s.poissons_ratio)] {
        if value.is_none() && over.uses(name) {
            return Err(Error::input(key, format!("uses {name}, but [shell] has no `{what}`")));
        }
    }
    let scale = over.eval(&[s.thickness, s.youngs_modulus.unwrap_or(f64::NAN), s.poissons_ratio.unwrap_or(f64::NAN)]);
    if scale > 0.0 && scale.is_finite() { Ok(scale) } else { Err(Error::input(key, format!("is {scale} J for this shell, must be > 0"))) }
}

/// Square of a curvature that is fitted to all nodes.
fn curvature_square(mesh: &Mesh, positions: &[Vector3<f64>], of: CurvatureKind, weighting: Weighting) -> f64 {
    // Curved faces by the four flat ones on their nodes.
    let quarter = |[a, b, c, d, e, f]: [usize; 6]| [[a, d, f], [d, b, e], [f, e, c], [d, e, f]];
    let faces: Vec<[usize; 3]> =
        if mesh.midpoints.is_empty() { mesh.faces.clone() } else { mesh.six_node_faces().into_iter().flat_map(quarter).collect() };
    let fitted = curvature(positions, &faces).into_iter().map(|c| match of {
        CurvatureKind::Mean => c.mean * c.mean,
        CurvatureKind::Gauss => c.gauss * c.gauss,
    });
    let squares: Vec<f64> = fitted.collect();
    match weighting {
        Weighting::Area => mean(&squares, &vertex_areas(positions, &faces)),
        Weighting::Sum => squares.iter().sum(),
    }
}

/// The exact shape that a map makes of the initial mesh.
pub struct Image {
    nodes: Vec<Vector3<f64>>,
    /// The whole surface, where that is asked for.
    surface: Option<Surface>,
}

impl Image {
    /// Errors: an expression that is not finite at a node or, for the whole surface, somewhere between.
    pub fn new(key: &str, position: &[Expr; 3], mesh: &Mesh, kind: Distance) -> Result<Self> {
        let mut parsed = Vec::new();
        for (i, text) in position.iter().enumerate() {
            parsed.push(build::expression(&format!("{key}.{i}"), text, scene::PLACE)?);
        }
        let image = |p: Vector3<f64>| {
            let values = place_values(scene::PLACE, &p, 0.0);
            Vector3::from_iterator(parsed.iter().map(|e| e.eval(&values)))
        };
        let initial = mesh.nodes();
        let nodes: Vec<_> = initial.iter().map(|p| image(*p)).collect();
        for (p, q) in initial.iter().zip(&nodes) {
            if let Some(i) = (0..3).find(|i| !q[*i].is_finite()) {
                return Err(Error::input(format!("{key}.{i}"), format!("is {} at ({}, {}, {}) m", q[i], p.x, p.y, p.z)));
            }
        }
        let surface = (kind == Distance::Hausdorff).then(|| Surface::new(mesh, &initial, image));
        if surface.as_ref().is_some_and(|s| !s.is_finite()) {
            return Err(Error::input(key, "is not finite somewhere between the nodes of the mesh"));
        }
        Ok(Image { nodes, surface })
    }

    /// The shape that the mesh had before it was flattened. Errors: a mesh that does not say, or with coordinates that are not finite.
    pub fn original(key: &str, mesh: &Mesh, kind: Distance) -> Result<Self> {
        let nodes = super::super::rest::node_positions(mesh, key, conformal::POSITION)?;
        if let Some(i) = nodes.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(Error::input(key, format!("field '{}' is not finite at node {i}", conformal::POSITION)));
        }
        let surface = (kind == Distance::Hausdorff).then(|| Surface::new(mesh, &nodes, |p| p));
        Ok(Image { nodes, surface })
    }

    /// Distance [m] from the shape with its nodes at `positions` [m].
    fn distance(&self, mesh: &Mesh, positions: &[Vector3<f64>], mirror: bool) -> f64 {
        match &self.surface {
            None => nodes_distance(&self.nodes, positions, mirror),
            Some(exact) => {
                let now = Surface::new(mesh, positions, |p| p);
                surface_distance((&self.nodes, exact), (positions, &now), mirror)
            }
        }
    }
}

/// The vertex nearest to a place, of a region or of all.
pub fn vertex_at(mesh: &Mesh, key: &str, at: &[f64; 3], region: Option<&str>) -> Result<usize> {
    let at = Vector3::from(*at);
    let among = match region {
        Some(name) => setup::region(mesh, &format!("{key}.region"), name)?.vertices.clone(),
        None => (0..mesh.vertices.len()).collect(),
    };
    let distance = |v: &usize| (mesh.vertices[*v] - at).norm();
    let nearest = among.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let nearest = nearest.ok_or_else(|| Error::input(key, "the region has no vertex"))?;
    mesh_stage::near(mesh, nearest, &at).map_err(|e| Error::input(key, e))?;
    Ok(nearest)
}

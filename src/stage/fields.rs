//! The fields of a state that are exported and reported: computed from a snapshot, never stored in checkpoints.

use super::build;
use super::diffusion::{self, Profiles};
use super::rest;
use super::setup::Setup;
use crate::error::{Error, Result};
use crate::math::Expression;
use crate::math::quadrature::GAUSS_2;
use crate::mesh::{Mesh, Topology};
use crate::model::{RestDriver, place_of_law};
use crate::scene::{self, Scene};
use crate::shell::Shell;
use crate::shell::fields::at_point;
use crate::shell::rest::Forms;
use crate::snapshot::{Association, Field, Snapshot};
use nalgebra::{Matrix3, Vector3};

/// Computes fields of the snapshots of one case.
pub struct Fields<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    topology: &'a Topology,
    setup: &'a Setup,
    shell: Box<dyn Shell>,
    rest: Option<RestDriver>,
    profiles: Profiles,
    /// Factors on the stiffness by what diffuses, one a quantity that has any.
    stiffness: Vec<(&'static str, Expression)>,
}

/// Names and numbers of components of the fields that a scene has.
pub fn names(scene: &Scene) -> Vec<(&'static str, usize)> {
    if scene.cosserat.is_some() {
        return super::grid_fields::names(scene);
    }
    let swells = scene.rest.as_ref().is_some_and(|r| r.linear.is_some() || r.bilayer.is_some());
    let mut names = vec![("displacement", 3)];
    names.extend(scene.dynamics.as_ref().map(|_| ("velocity", 3)));
    names.extend(scene.output.lowest_mode.then_some(("lowest_mode", 3)));
    names.extend(scene.output.reactions.then_some(("reaction", 3)));
    let prescribed = swells && scene.moisture.is_none();
    names.extend([("moisture_top", 1), ("moisture_bottom", 1)].into_iter().filter(|_| prescribed));
    names.extend(scene.diffusing().flat_map(|(table, ..)| diffused(table).map(|name| (name, 1))));
    names.extend(NAMES.iter().map(|(name, n, _)| (*name, *n)));
    names.extend(scene.machine_direction.as_ref().map(|_| ("machine_direction", 3)));
    names
}

/// Names of the fields at the top, at the bottom and of the mean over the thickness of what the table lets diffuse.
pub fn diffused(table: &str) -> [&'static str; 3] {
    if table == "heat" {
        ["temperature_top", "temperature_bottom", "temperature_mean"]
    } else {
        ["moisture_top", "moisture_bottom", "moisture_mean"]
    }
}

/// Whether the field of that name belongs to the faces; nodes may have means of it besides.
pub fn of_faces(name: &str) -> bool {
    name == "machine_direction" || NAMES.iter().any(|(n, ..)| *n == name)
}

/// Points [m], wedges between them, and the values of a quantity at the points.
pub type Prisms = (Vec<Vector3<f64>>, Vec<[usize; 6]>, Vec<f64>);

/// A state in space: vertex positions and fields.
pub struct State {
    /// Vertex positions [m].
    pub points: Vec<Vector3<f64>>,
    /// One entry per vertex.
    pub point_data: Vec<Field>,
    /// One entry per face.
    pub cell_data: Vec<Field>,
    /// Rest area of each face [m2].
    pub areas: Vec<f64>,
}

fn field(name: &str, association: Association, components: usize, unit: &str, data: Vec<f64>) -> Field {
    Field { name: name.into(), association, components, unit: unit.into(), data }
}

/// Name, components and unit of each field of the faces.
const NAMES: &[(&str, usize, &str); 11] = &[
    ("principal_curvatures", 2, "1/m"),
    ("principal_direction_1", 3, "1"),
    ("principal_direction_2", 3, "1"),
    ("mean_curvature", 1, "1/m"),
    ("gauss_curvature", 1, "1/m2"),
    ("membrane_strain", 6, "1"),
    ("membrane_stress", 6, "Pa"),
    ("bending_moment", 6, "N"),
    ("membrane_energy_density", 1, "J/m2"),
    ("bending_energy_density", 1, "J/m2"),
    ("thickness", 1, "m"),
];

/// A symmetric tensor in VTK's order.
fn symmetric(m: &Matrix3<f64>) -> [f64; 6] {
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(0, 2)]]
}

impl<'a> Fields<'a> {
    /// Builds the shell and the rest driver that the fields are computed with.
    pub fn new(scene: &'a Scene, mesh: &'a Mesh, topology: &'a Topology, setup: &'a Setup) -> Result<Self> {
        let profiles = diffusion::profiles(scene, mesh)?;
        let softened = scene.diffusing().filter_map(|(table, name, _, said)| Some((table, name, said.stiffness.as_ref()?)));
        let stiffness = softened
            .map(|(table, name, expr)| Ok((name, build::expression(&format!("{table}.stiffness"), expr, scene::DIFFUSED)?)))
            .collect::<Result<_>>()?;
        Ok(Fields {
            stiffness,
            scene,
            mesh,
            topology,
            setup,
            shell: build::shell(scene, mesh, topology, setup),
            rest: rest::driver(scene, mesh, topology, setup, &profiles)?,
            profiles,
        })
    }

    /// Takes the directors of a shape; returns its unknowns, and the rest forms at the time of a state with what diffuses in it.
    fn put(&mut self, shape: &Snapshot, state: &Snapshot) -> Result<(Vec<f64>, Vec<Forms>)> {
        fn of<'a>(snapshot: &'a Snapshot, name: &str, length: usize) -> Result<&'a [f64]> {
            let data = snapshot.field(name).map(|f| f.data.as_slice()).filter(|d| d.len() == length);
            data.ok_or_else(|| Error::input("checkpoint", format!("field '{name}' is missing or not of this mesh")))
        }
        let mut unknowns = of(shape, "position", 3 * (self.mesh.vertices.len() + self.mesh.midpoints.len()))?.to_vec();
        unknowns.resize(self.shell.unknowns(), 0.0);
        let count = self.shell.directors().len();
        if count > 0 {
            let directors: Vec<Vector3<f64>> =
                of(shape, "director", 3 * count)?.chunks_exact(3).map(|d| Vector3::new(d[0], d[1], d[2])).collect();
            self.shell.set_directors(&directors);
        }
        for (name, profile) in &self.profiles {
            let length = profile.values().len();
            profile.set(of(state, name, length)?);
        }
        if !self.stiffness.is_empty() {
            self.shell.set_stiffness(self.stiffness());
        }
        let rest = match &mut self.rest {
            Some(driver) => driver.forms(state.time).map_err(|e| Error::input(place_of_law(e.law), e.reason))?,
            None => self.setup.initial_forms.clone(),
        };
        Ok((unknowns, rest))
    }

    /// Membrane and bending energy [J] of a snapshot's shape in the rest forms of another one, without damping. Errors: a snapshot of another
    /// case.
    pub fn energies(&mut self, shape: &Snapshot, state: &Snapshot) -> Result<[f64; 2]> {
        let (unknowns, rest) = self.put(shape, state)?;
        self.shell.set_rest(&rest);
        Ok(self.shell.energies(&unknowns))
    }

    /// All fields of a snapshot. Errors: a snapshot of another case.
    pub fn of(&mut self, snapshot: &Snapshot) -> Result<State> {
        let (all, rest) = self.put(snapshot, snapshot)?;
        let initial = self.mesh.nodes();
        let points: Vec<Vector3<f64>> = all[..3 * initial.len()].chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
        let point = |name: &str, n, unit: &str, data| field(name, Association::Node, n, unit, data);
        let displacement = points.iter().zip(&initial).flat_map(|(p, q)| (p - q).data.0[0]).collect();
        let mut point_data = vec![point("displacement", 3, "m", displacement)];
        if let Some(velocity) = snapshot.field("velocity") {
            point_data.push(point("velocity", 3, "m/s", velocity.data.clone()));
        }
        if let Some(mode) = snapshot.field("lowest_mode") {
            point_data.push(point("lowest_mode", 3, "1", mode.data.clone()));
        }
        if let Some(reaction) = snapshot.field("reaction") {
            point_data.push(point("reaction", 3, "N", reaction.data.clone()));
        }
        if let Some([top, bottom]) = rest::moisture(self.scene, self.mesh, snapshot.time)? {
            point_data.extend([point("moisture_top", 1, "%", top), point("moisture_bottom", 1, "%", bottom)]);
        }
        for (table, name, unit, _) in self.scene.diffusing() {
            let Some(profile) = self.profiles.get(name) else { continue };
            let (values, count) = (profile.values(), profile.levels().len());
            let level = |l: usize| values.chunks_exact(count).map(|u| u[l]).collect();
            for (name, data) in diffused(table).into_iter().zip([level(count - 1), level(0), profile.means()]) {
                point_data.push(point(name, 1, unit, self.at_nodes(data)));
            }
        }
        let (cell_data, areas) = self.cells(&all, &rest);
        if !self.mesh.midpoints.is_empty() {
            point_data.extend(self.averaged(&cell_data, &areas));
        }
        Ok(State { points, point_data, cell_data, areas })
    }

    /// Values at the vertices, and on curved faces at the middles of the edges, where they are means.
    fn at_nodes(&self, mut values: Vec<f64>) -> Vec<f64> {
        if !self.mesh.midpoints.is_empty() {
            values.extend(self.topology.edges.iter().map(|[a, b]| 0.5 * (values[*a] + values[*b])).collect::<Vec<_>>());
        }
        values
    }

    /// Factors on the stiffness of the faces by what diffuses; none at all where nothing has any.
    fn stiffness(&self) -> Vec<f64> {
        let mut factors = Vec::new();
        for (name, expression) in &self.stiffness {
            let means = self.profiles.get(name).map_or(Vec::new(), |profile| profile.face_means());
            factors.resize(means.len(), 1.0);
            factors.iter_mut().zip(means).for_each(|(factor, u)| *factor *= expression.eval(&[u]));
        }
        factors
    }

    /// The body of the shell in a state, as prisms: points, wedges, and the values of a quantity at the points; none if it does not diffuse. Points
    /// lie off the vertices along the mean normal of the faces around, by the mean of their thickness. After [`Fields::of`] of that state.
    pub fn prisms(&self, state: &State, quantity: &str) -> Option<Prisms> {
        let profile = self.profiles.get(quantity)?;
        let (levels, vertices) = (profile.levels(), self.mesh.vertices.len());
        let (mut normals, mut thickness, mut counts) = (vec![Vector3::zeros(); vertices], vec![0.0; vertices], vec![0.0; vertices]);
        for (face, material) in self.mesh.faces.iter().zip(&self.setup.materials) {
            let [a, b, c] = face.map(|v| state.points[v]);
            for &v in face {
                normals[v] += (b - a).cross(&(c - a));
                thickness[v] += material.thickness;
                counts[v] += 1.0;
            }
        }
        let offset = |v: usize, level: f64| normals[v].try_normalize(0.0).unwrap_or_default() * ((level - 0.5) * thickness[v] / counts[v]);
        let points =
            (0..vertices).flat_map(|v| levels.iter().map(move |level| (v, *level))).map(|(v, level)| state.points[v] + offset(v, level));
        let wedge = |face: &[usize; 3], level: usize| {
            let at = |v: usize, l: usize| v * levels.len() + l;
            let [a, b, c] = *face;
            [at(a, level), at(c, level), at(b, level), at(a, level + 1), at(c, level + 1), at(b, level + 1)]
        };
        let wedges = self.mesh.faces.iter().flat_map(|face| (1..levels.len()).map(move |level| wedge(face, level - 1)));
        Some((points.collect(), wedges.collect(), profile.values().to_vec()))
    }

    /// Places of the directors [m] in a state, and the directors.
    pub fn directors(&self, state: &State, snapshot: &Snapshot) -> (Vec<Vector3<f64>>, Field) {
        let data = snapshot.field("director").map_or(Vec::new(), |f| f.data.clone());
        let vertices = self.mesh.vertices.len();
        let places = self.topology.edges.iter().enumerate().flat_map(|(e, [a, b])| {
            let (p, q) = (state.points[*a], state.points[*b]);
            match state.points.get(vertices + e) {
                None => vec![(p + q) * 0.5],
                Some(middle) => {
                    let at = |t: f64| p * ((1.0 - t) * (1.0 - 2.0 * t)) + q * (t * (2.0 * t - 1.0)) + middle * (4.0 * t * (1.0 - t));
                    GAUSS_2.iter().map(|t| at(*t)).collect()
                }
            }
        });
        (places.collect(), field("director", Association::Node, 3, "1", data))
    }

    /// Fields of the faces (means over their integration points), and their rest areas.
    fn cells(&self, x: &[f64], rest: &[Forms]) -> (Vec<Field>, Vec<f64>) {
        let (forms, tangents) = (self.shell.forms(x), self.shell.tangents(x));
        let (per_face, stiffness) = (self.shell.points(), self.stiffness());
        let mut columns: [Vec<f64>; 11] = Default::default();
        let mut directions = Vec::new();
        let mut areas = Vec::with_capacity(self.mesh.faces.len());
        for f in 0..self.mesh.faces.len() {
            let material = &self.setup.materials[f];
            let mut sums: [[f64; 6]; 11] = Default::default();
            let mut area = 0.0;
            let mut direction = Vector3::zeros();
            for (k, weight) in (per_face * f..per_face * (f + 1)).zip(self.shell.weights()) {
                let e = forms[k];
                let now = Forms { a: [e[0], e[1], e[2]], b: [e[3], e[4], e[5]] };
                let mut p = at_point(&tangents[k], &now, &rest[k], material, &self.setup.constitution(f));
                if let Some(factor) = stiffness.get(f) {
                    p.soften(*factor);
                }
                area += weight * (rest[k].a[0] * rest[k].a[2] - rest[k].a[1] * rest[k].a[1]).sqrt();
                // Directions have no sign of their own: those of the first point lead.
                let lead = |sum: &[f64; 6], d: &Vector3<f64>| if sum[0] * d.x + sum[1] * d.y + sum[2] * d.z < 0.0 { -d } else { *d };
                let (d1, d2) = (lead(&sums[1], &p.principal_directions[0]), lead(&sums[2], &p.principal_directions[1]));
                let values: [&[f64]; 11] = [
                    &p.principal_curvatures,
                    d1.as_slice(),
                    d2.as_slice(),
                    &[p.mean_curvature],
                    &[p.gauss_curvature],
                    &symmetric(&p.membrane_strain),
                    &symmetric(&p.membrane_stress),
                    &symmetric(&p.bending_moment),
                    &[p.membrane_energy_density],
                    &[p.bending_energy_density],
                    &[material.thickness],
                ];
                for (sum, value) in sums.iter_mut().zip(values) {
                    sum.iter_mut().zip(value).for_each(|(s, v)| *s += v / per_face as f64);
                }
                if let Some(d) = &self.setup.machine_direction {
                    direction += tangents[k][0] * d[f][0] + tangents[k][1] * d[f][1];
                }
            }
            areas.push(area);
            for ((column, sum), (_, n, _)) in columns.iter_mut().zip(&mut sums).zip(NAMES) {
                if *n == 3 {
                    let norm = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
                    sum.iter_mut().for_each(|s| *s /= norm);
                }
                column.extend_from_slice(&sum[..*n]);
            }
            if self.setup.machine_direction.is_some() {
                directions.extend_from_slice(direction.normalize().as_slice());
            }
        }
        let mut cells: Vec<Field> =
            NAMES.iter().zip(columns).map(|((name, n, unit), data)| field(name, Association::Face, *n, unit, data)).collect();
        if !directions.is_empty() {
            cells.push(field("machine_direction", Association::Face, 3, "1", directions));
        }
        (cells, areas)
    }

    /// The fields of the faces at the nodes: means over the faces around, weighted by area. Directions, which have no mean, are left out.
    fn averaged(&self, cells: &[Field], areas: &[f64]) -> Vec<Field> {
        let faces = self.mesh.six_node_faces();
        let nodes = self.mesh.vertices.len() + self.mesh.midpoints.len();
        let mut weights = vec![0.0; nodes];
        faces.iter().zip(areas).for_each(|(face, area)| face.iter().for_each(|n| weights[*n] += area));
        let mean = |cell: &Field| {
            let n = cell.components;
            let mut data = vec![0.0; n * nodes];
            for ((face, area), value) in faces.iter().zip(areas).zip(cell.data.chunks_exact(n)) {
                for &node in face {
                    value.iter().enumerate().for_each(|(c, v)| data[n * node + c] += area / weights[node] * v);
                }
            }
            Field { association: Association::Node, data, ..cell.clone() }
        };
        cells.iter().filter(|c| c.components != 3).map(mean).collect()
    }
}

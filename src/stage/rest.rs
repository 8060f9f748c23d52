//! The growth laws of a scene as objects, what drives them in time, and the machine direction they refer to.

use super::build::{self, expression, field, of_time};
use super::diffusion::Profiles;
use super::setup::Setup;
use crate::error::{Error, Result};
use crate::math::Jet;
use crate::mesh::{FieldOn, FieldSampler, Mesh, Topology};
use crate::model::{Profile as Values, Ramp, RestDriver};
use crate::scene::{self, Expr, Scalar, Scene};
use crate::shell::rest::{
    Components, Expansion, Forms, Interpolation, Isotropic, Law, LinearInterpolation, MachineDirection, Orthotropic, OtherShape, Prestress,
    Product, Profile, Pullback, QuadraticInterpolation, Sampling, ScalarField, Site, Surface, Swelling, on_faces, transported,
};
use crate::shell::{Bilayer, Constitution};
use nalgebra::Vector3;

/// Turns what the tables say into fields, and notes whether any changes in time.
struct Reader<'a> {
    mesh: &'a Mesh,
    changes: bool,
}

impl Reader<'_> {
    fn expr(&mut self, key: &str, expr: &Expr, names: &'static [&'static str]) -> Result<ScalarField> {
        self.changes |= expression(key, expr, names)?.uses("t");
        let field = field(key, expr, names)?;
        Ok(Box::new(move |site, t| field(&site.position, t)))
    }

    fn scalar(&mut self, key: &str, scalar: &Scalar) -> Result<ScalarField> {
        match scalar {
            Scalar::Expr(expr) => self.expr(key, expr, scene::PLACE_AND_TIME),
            Scalar::Field(named) => {
                let sampler = mesh_field(self.mesh, &format!("{key}.field"), &named.field, 1)?;
                let value = move |site: &Site| sampler.at(site.face, site.place).map_or(f64::NAN, |v| v[0]);
                let Some(times) = &named.times else { return Ok(Box::new(move |site, _| value(site))) };
                let times = self.expr(&format!("{key}.times"), times, scene::PLACE_AND_TIME)?;
                Ok(Box::new(move |site, t| times(site, t) * value(site)))
            }
        }
    }

    fn tensor(&mut self, key: &str, exprs: &Option<[Expr; 3]>) -> Result<Option<[ScalarField; 3]>> {
        let Some([a, b, c]) = exprs else { return Ok(None) };
        let mut make = |expr| self.expr(key, expr, scene::PLANE_AND_TIME);
        Ok(Some([make(a)?, make(b)?, make(c)?]))
    }
}

/// The growth law, whether it changes in time; none for the initial shape.
fn law(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup, profiles: &Profiles) -> Result<Option<(Box<dyn Law>, bool)>> {
    let Some(rest) = &scene.rest else { return Ok(None) };
    let mut reader = Reader { mesh, changes: false };
    let mut laws: Vec<(&'static str, Box<dyn Law>)> = Vec::new();
    if let Some(table) = &rest.pullback {
        let (abar, bbar) = (reader.tensor("rest.pullback.abar", &table.abar)?, reader.tensor("rest.pullback.bbar", &table.bbar)?);
        laws.push(("pullback", Box::new(Pullback { abar, bbar, components: components(table.components) })));
    }
    if let Some(table) = &rest.surface {
        laws.push(("surface", Box::new(surface(table)?)));
    }
    if let Some(table) = &rest.shape {
        laws.push(("shape", Box::new(other_shape(scene, mesh, topology, setup, table)?)));
    }
    if let Some(table) = &rest.isotropic {
        laws.push(("isotropic", Box::new(Isotropic { s: reader.scalar("rest.isotropic.s", &table.s)? })));
    }
    if let Some(table) = &rest.orthotropic {
        let [along, across] = &table.factors;
        let factors = [reader.scalar("rest.orthotropic.factors.0", along)?, reader.scalar("rest.orthotropic.factors.1", across)?];
        let direction = match &table.angle {
            Some(angle) => at_angle(reader.scalar("rest.orthotropic.angle", angle)?),
            None => fibres(scene, mesh, setup)?,
        };
        laws.push(("orthotropic", Box::new(Orthotropic { factors, direction })));
    }
    if let Some(table) = swelling(rest) {
        let fibres = table.mu_perp.map(|mu| Ok::<_, Error>((mu, fibres(scene, mesh, setup)?))).transpose()?;
        let own = || setup.constitutions.iter().map(Constitution::layers).collect();
        let name = table.name;
        let moisture = match (table.prescribed, profiles.get("moisture")) {
            (Some([plus, minus]), _) => Some([
                reader.expr(&format!("rest.{name}.m_plus"), plus, scene::PLACE_AND_TIME)?,
                reader.expr(&format!("rest.{name}.m_minus"), minus, scene::PLACE_AND_TIME)?,
            ]),
            (None, Some(values)) if table.profile == scene::Profile::Sides => {
                Some([values.levels().len() - 1, 0].map(|level| -> ScalarField {
                    let values = values.clone();
                    Box::new(move |site, _| values.at(site, level))
                }))
            }
            (None, _) => None,
        };
        reader.changes |= table.prescribed.is_none();
        let prescribed = table.prescribed.is_some();
        let law: Box<dyn Law> = match (moisture, profiles.get("moisture")) {
            (Some(moisture), _) => {
                let profile = if table.layered { Profile::Bilayer(own()) } else { Profile::Linear };
                Box::new(Swelling { profile, moisture, mu: table.mu, fibres, prescribed })
            }
            (None, Some(values)) => Box::new(expansion(["moisture", "%"], values, table.mu, fibres, own())),
            (None, None) => {
                return Err(Error::input(format!("rest.{name}.m_plus"), "this key is missing, and the scene has no [moisture]"));
            }
        };
        laws.push((name, law));
    }
    if let (Some(table), Some(values)) = (&rest.thermal, profiles.get("temperature")) {
        reader.changes = true;
        let bottom = table.bottom.as_ref();
        let along = [table.expansion, bottom.map_or(table.expansion, |layer| layer.expansion)];
        let across = table.expansion_perp.map(|mu| [mu, bottom.and_then(|layer| layer.expansion_perp).unwrap_or(mu)]);
        let fibres = across.map(|mu| Ok::<_, Error>((mu, fibres(scene, mesh, setup)?))).transpose()?;
        let layers = setup.constitutions.iter().map(Constitution::layers).collect();
        laws.push(("thermal", Box::new(expansion(["temperature", "K"], values, along, fibres, layers))));
    }
    if let Some(table) = &rest.prestress {
        let law = Prestress {
            times: table.times.as_ref().map(|times| reader.scalar("rest.prestress.times", times)).transpose()?,
            plus_a: reader.tensor("rest.prestress.plus_a", &table.plus_a)?,
            plus_b: reader.tensor("rest.prestress.plus_b", &table.plus_b)?,
            components: components(table.components),
        };
        laws.push(("prestress", Box::new(law)));
    }
    Ok(if laws.is_empty() { None } else { Some((Box::new(Product(laws)), reader.changes)) })
}

/// What `linear` and `bilayer` have in common.
struct SwellingTable<'a> {
    name: &'static str,
    /// Whether the layers swell each as a whole.
    layered: bool,
    /// Moisture at the top and the bottom, where it does not diffuse.
    prescribed: Option<[&'a Expr; 2]>,
    profile: scene::Profile,
    mu: [f64; 2],
    mu_perp: Option<[f64; 2]>,
}

/// The swelling law of the scene, if it has one.
fn swelling(rest: &scene::Rest) -> Option<SwellingTable<'_>> {
    let linear = rest.linear.as_ref().map(|t| SwellingTable {
        name: "linear",
        layered: false,
        prescribed: t.m_plus.as_ref().zip(t.m_minus.as_ref()).map(|(plus, minus)| [plus, minus]),
        profile: t.profile.unwrap_or_default(),
        mu: [t.mu; 2],
        mu_perp: t.mu_perp.map(|mu| [mu; 2]),
    });
    let bilayer = rest.bilayer.as_ref().map(|t| SwellingTable {
        name: "bilayer",
        layered: true,
        prescribed: t.m_plus.as_ref().zip(t.m_minus.as_ref()).map(|(plus, minus)| [plus, minus]),
        profile: t.profile.unwrap_or_default(),
        mu: t.mu,
        mu_perp: t.mu_perp,
    });
    linear.or(bilayer)
}

/// The law by all of a profile.
fn expansion(
    quantity: [&'static str; 2],
    values: &Values,
    mu: [f64; 2],
    fibres: Option<([f64; 2], MachineDirection)>,
    layers: Vec<Option<Bilayer>>,
) -> Expansion {
    let (levels, values) = (values.levels().to_vec(), values.clone());
    Expansion { quantity, levels, value: Box::new(move |site, level| values.at(site, level)), mu, fibres, layers }
}

/// A field of the mesh with that many components. Errors: there is none.
pub fn mesh_field(mesh: &Mesh, key: &str, name: &str, components: usize) -> Result<FieldSampler> {
    let known = || mesh.fields.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    let Some(sampler) = mesh.field_sampler(name) else {
        let help = if mesh.fields.is_empty() { "the mesh has no fields".to_owned() } else { format!("the mesh has: {}", known()) };
        return Err(Error::input_with_help(key, format!("there is no field '{name}'"), help));
    };
    match mesh.fields.get(name).map(|f| f.components) {
        Some(n) if n != components => Err(Error::input(key, format!("field '{name}' has {n} components, {components} are needed"))),
        _ => Ok(sampler),
    }
}

/// Places of all nodes [m] from a field of the mesh. Errors: there is none, or it is not one of positions.
pub fn node_positions(mesh: &Mesh, key: &str, name: &str) -> Result<Vec<Vector3<f64>>> {
    mesh_field(mesh, key, name, 3)?;
    let field = &mesh.fields[name];
    if field.on != FieldOn::Nodes {
        return Err(Error::input(key, format!("field '{name}' belongs to the faces, positions of nodes are needed")));
    }
    Ok(field.data.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect())
}

/// Law `shape`: the forms of the same faces with their nodes elsewhere.
fn other_shape(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup, table: &scene::Shape) -> Result<OtherShape> {
    let (key, name) = match table {
        scene::Shape::File(_) => ("rest.shape.file", super::mesh::REST_SHAPE),
        scene::Shape::Field(name) => ("rest.shape.field", name.as_str()),
    };
    let nodes = node_positions(mesh, key, name)?;
    let (vertices, midpoints) = nodes.split_at(mesh.vertices.len());
    let other = Mesh { vertices: vertices.to_vec(), midpoints: midpoints.to_vec(), ..mesh.clone() };
    let shell = build::shell(scene, &other, topology, setup);
    let mut x: Vec<f64> = nodes.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(shell.unknowns(), 0.0);
    let initial_forms: Vec<Forms> = shell.forms(&x).iter().map(|e| Forms { a: [e[0], e[1], e[2]], b: [e[3], e[4], e[5]] }).collect();
    if let Some(k) = initial_forms.iter().position(|f| !f.is_admissible()) {
        return Err(Error::input(key, format!("face {} has no area in the other shape", k / shell.points())));
    }
    let setup = Setup { initial_forms, ..setup.clone() };
    Ok(OtherShape { shape: interpolation(scene, &other, topology, &setup) })
}

fn components(components: scene::Components) -> Components {
    match components {
        scene::Components::Cartesian => Components::Cartesian,
        scene::Components::Polar => Components::Polar,
    }
}

/// Variables x, y, z, r, theta at a place, with their derivatives in x, y, z.
fn place_jets(p: &Vector3<f64>) -> [Jet; 5] {
    let [x, y, z] = [0, 1, 2].map(|i| Jet::variable(p[i], i));
    let (r2, r) = (p.x * p.x + p.y * p.y, p.x.hypot(p.y));
    let (r3, r4) = (r2 * r, r2 * r2);
    let radius = x.binary(&y, r, [p.x / r, p.y / r], [p.y * p.y / r3, -p.x * p.y / r3, p.x * p.x / r3]);
    let (xy, square) = (p.x * p.y, p.y * p.y - p.x * p.x);
    let theta = x.binary(&y, p.y.atan2(p.x), [-p.y / r2, p.x / r2], [2.0 * xy / r4, square / r4, -2.0 * xy / r4]);
    [x, y, z, radius, theta]
}

/// Law `surface`.
fn surface(table: &scene::Surface) -> Result<Surface> {
    let exprs = table.position();
    let parsed = exprs.iter().map(|e| expression("rest.surface", e, scene::PLANE)).collect::<Result<Vec<_>>>()?;
    Ok(Surface {
        map: Box::new(move |p| {
            let [x, y, _, r, theta] = place_jets(p);
            let jets = [0, 1, 2].map(|i| parsed[i].jet(&[x, y, r, theta]));
            let of = |part: fn(&Jet) -> f64| Vector3::from(jets.each_ref().map(part));
            [
                of(|j| j.value),
                of(|j| j.gradient.x),
                of(|j| j.gradient.y),
                of(|j| j.hessian[(0, 0)]),
                of(|j| j.hessian[(0, 1)]),
                of(|j| j.hessian[(1, 1)]),
            ]
        }),
    })
}

/// A direction in the xy plane at an angle [degrees] from the x axis.
fn at_angle(angle: ScalarField) -> MachineDirection {
    MachineDirection::Vector(Box::new(move |site, t| {
        let (sin, cos) = angle(site, t).to_radians().sin_cos();
        Vector3::new(cos, sin, 0.0)
    }))
}

/// The machine direction as laws see it: at every place where it is known there, else that of the faces. Errors: never after the setup.
fn fibres(scene: &Scene, mesh: &Mesh, setup: &Setup) -> Result<MachineDirection> {
    let per_face = || MachineDirection::PerFace(setup.machine_direction.clone().unwrap_or_default());
    Ok(scene.machine_direction.as_ref().map(|table| pointwise(table, mesh)).transpose()?.flatten().unwrap_or_else(per_face))
}

/// The machine direction as a function of place; none where it is one of faces.
fn pointwise(table: &scene::MachineDirection, mesh: &Mesh) -> Result<Option<MachineDirection>> {
    let mut reader = Reader { mesh, changes: false };
    let from_axis = |center: [f64; 2], turn: fn(Vector3<f64>) -> Vector3<f64>| {
        MachineDirection::Vector(Box::new(move |site: &Site, _| turn(site.position - Vector3::new(center[0], center[1], site.position.z))))
    };
    Ok(Some(match table {
        scene::MachineDirection::Vector(v) => {
            let v = Vector3::from(*v);
            MachineDirection::Vector(Box::new(move |_, _| v))
        }
        scene::MachineDirection::Angle(angle) => at_angle(reader.scalar("machine-direction.angle", angle)?),
        scene::MachineDirection::Radial(axis) => from_axis(axis.center, |d| d),
        scene::MachineDirection::Azimuthal(axis) => from_axis(axis.center, |d| Vector3::new(-d.y, d.x, 0.0)),
        scene::MachineDirection::Gradient(expr) => {
            let parsed = expression("machine-direction.gradient", expr, scene::PLACE)?;
            MachineDirection::Vector(Box::new(move |site, _| parsed.jet(&place_jets(&site.position)).gradient))
        }
        scene::MachineDirection::Field(name) => {
            let sampler = mesh_field(mesh, "machine-direction.field", name, 3)?;
            MachineDirection::Vector(Box::new(move |site, _| {
                sampler.at(site.face, site.place).map_or(Vector3::zeros(), |v| Vector3::new(v[0], v[1], v[2]))
            }))
        }
        scene::MachineDirection::Transport(_) => return Ok(None),
    }))
}

/// The machine direction of each face by barycentric components, if the scene has one.
///
/// # Errors
/// A direction that vanishes or has no part in some face, a field that the mesh has not, faces that a transported direction does not reach.
pub fn machine_direction(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Result<Option<Vec<[f64; 2]>>> {
    let Some(table) = &scene.machine_direction else { return Ok(None) };
    let per_face = match (pointwise(table, mesh)?, table) {
        (Some(direction), _) => {
            let interpolation = interpolation(scene, mesh, topology, setup);
            on_faces(&direction, mesh.faces.len(), |face, place| interpolation.site(face, place))
        }
        (None, scene::MachineDirection::Transport(transport)) => {
            let (from, vector) = (Vector3::from(transport.from), Vector3::from(transport.vector));
            let distance = |f: &usize| (mesh.faces[*f].iter().map(|v| mesh.vertices[*v]).sum::<Vector3<f64>>() / 3.0 - from).norm();
            let nearest = (0..mesh.faces.len()).min_by(|f, g| distance(f).total_cmp(&distance(g)));
            super::mesh::near(mesh, nearest.map_or(0, |f| mesh.faces[f][0]), &from)
                .map_err(|e| Error::input("machine-direction.transport.from", e))?;
            transported(mesh, topology, nearest.unwrap_or(0), &vector)
        }
        (None, _) => return Ok(None),
    };
    per_face.map(Some).map_err(|e| Error::input("machine-direction", e))
}

/// How the scene's element makes rest forms of a law.
fn interpolation(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup) -> Box<dyn Interpolation> {
    let sampling = match scene.rest.as_ref().map(|rest| rest.sampling).unwrap_or_default() {
        scene::Sampling::Edges => Sampling::Edges,
        scene::Sampling::Centroid => Sampling::Centroid,
    };
    let (mesh, topology, initial) = (mesh.clone(), topology.clone(), setup.initial_forms.clone());
    let thickness = setup.materials.iter().map(|m| m.thickness).collect();
    match scene.shell.element {
        scene::Element::Linear => Box::new(LinearInterpolation { mesh, topology, sampling, initial, thickness }),
        scene::Element::Quadratic => Box::new(QuadraticInterpolation { mesh, topology, sampling, initial, thickness }),
    }
}

/// What drives the rest forms, if anything does.
pub fn driver(scene: &Scene, mesh: &Mesh, topology: &Topology, setup: &Setup, profiles: &Profiles) -> Result<Option<RestDriver>> {
    let (Some((law, changes)), Some(table)) = (law(scene, mesh, topology, setup, profiles)?, &scene.rest) else { return Ok(None) };
    let ramp: Option<Ramp> = match &table.ramp {
        Some(expr) => Some(of_time("rest.ramp", expr)?),
        None if !scene.runs_in_time() && !changes => Some(Box::new(|t| t)),
        None => None,
    };
    let interpolation = interpolation(scene, mesh, topology, setup);
    let mut driver = RestDriver::new(law, changes, interpolation, ramp, setup.initial_forms.clone());
    setup.limit().into_iter().for_each(|limit| driver.set_limit(limit));
    Ok(Some(driver))
}

/// Prescribed moisture at the two sides of each node [%] at a time, where the scene has any: top, bottom.
pub fn moisture(scene: &Scene, mesh: &Mesh, time: f64) -> Result<Option<[Vec<f64>; 2]>> {
    let Some([plus, minus]) = scene.rest.as_ref().and_then(swelling).and_then(|table| table.prescribed) else { return Ok(None) };
    let side = |expr: &Expr| -> Result<Vec<f64>> {
        let field = field("rest", expr, scene::PLACE_AND_TIME)?;
        Ok(mesh.nodes().iter().map(|p| field(p, time)).collect())
    };
    Ok(Some([side(plus)?, side(minus)?]))
}

//! `setup`: materials, machine direction, supports, rest forms and the first state (`setup.h5`).

use super::build;
use super::diffusion;
use super::materials::{self, Compositions};
use super::{Job, mesh as mesh_stage};
use super::{rest, supports};
use crate::case::{Archive, Array, Folder, Kind, hash, put_snapshot, snapshot_from_archive};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Region, Topology};
use crate::model::{Limit, Model, StepFailure, place_of_law};
use crate::scene::{self, Scene, Shape};
use crate::shell::rest::{Forms, Impossible};
use crate::shell::{Constitution, Director, Material};
use crate::snapshot::Snapshot;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// What `setup.h5` keeps: all that a run needs and that does not change during it.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Material of each face.
    pub materials: Vec<Material>,
    /// Law of each face; empty where all have the default, isotropic St. Venant-Kirchhoff in plane stress.
    pub constitutions: Vec<Constitution>,
    /// Density of each face [kg/m3]; empty where the scene has none.
    pub densities: Vec<f64>,
    /// Forms of the initial shape, per integration point.
    pub initial_forms: Vec<Forms>,
    /// Rest forms at the start, per integration point.
    pub rest_forms: Vec<Forms>,
    /// Machine direction of each face by barycentric components, if there is one.
    pub machine_direction: Option<Vec<[f64; 2]>>,
    /// Held unknowns, ascending.
    pub held: Vec<Held>,
    /// Edges whose directors are held, and how.
    pub held_directors: Vec<(usize, Director)>,
    /// Number of free unknowns.
    pub free_unknowns: usize,
}

/// One held unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    /// Its number: three coordinates a node (vertices, then midpoints), then the angles of the edges.
    pub unknown: usize,
    /// The pin that moves it; none if it stays.
    pub pin: Option<usize>,
}

/// The stage.
///
/// # Errors
/// Regions that do not exist, laws that are impossible somewhere, files that are stale or cannot be written.
pub fn run(job: &Job) -> Result<()> {
    let mesh = mesh_stage::load(job)?;
    let (setup, snapshot) = make(&job.scene, &mesh)?;
    let mut archive = setup.to_archive(&inputs(job)?);
    put_snapshot(&mut archive, &snapshot);
    let _lock = Folder::new(&job.case, "").lock()?;
    archive.write(&path(job))?;
    job.record()?;
    job.say(&format!("{}: {} free unknowns, {} held", path(job).display(), setup.free_unknowns, setup.held.len()));
    Ok(())
}

/// Path of the stage's file.
pub fn path(job: &Job) -> PathBuf {
    job.case.join("setup.h5")
}

/// Hash of what the stage's file is made from: the mesh and the tables it reads, but for what only exports.
pub fn inputs(job: &Job) -> Result<String> {
    let s = &job.scene;
    let loads = (&s.gravity, &s.forces, &s.edge_loads, &s.moments, &s.pressures, &s.surface_loads, &s.body_forces, &s.winds);
    let statics = s.statics.as_ref().map(|table| &table.perturbation);
    let start = (statics, s.dynamics.as_ref().map(|d| &d.velocity));
    let diffusing = [&s.moisture, &s.heat].map(|table| table.as_ref().map(|table| scene::Diffusion { prisms: false, ..table.clone() }));
    let mut rest = s.rest.clone();
    if let Some(Shape::File(table)) = rest.as_mut().and_then(|rest| rest.shape.as_mut()) {
        // What is in the file counts, with the mesh, and not where it is.
        table.path.clear();
    }
    let tables = serde_json::to_string(&(
        (&s.model, &s.shell, &s.cosserat),
        &s.machine_direction,
        &rest,
        diffusing,
        loads,
        &s.pins,
        start,
        s.output.reactions,
    ));
    let tables = tables.map_err(|e| Error::input("scene", e.to_string()))?;
    Ok(hash::of(&[mesh_stage::inputs(job)?.as_bytes(), tables.as_bytes()]))
}

/// Reads what the stage wrote. Errors: a file that is missing, damaged or stale.
pub fn load(job: &Job) -> Result<(Setup, Snapshot)> {
    let path = path(job);
    let archive = Archive::read_for(&path, Kind::Setup, &inputs(job)?)?;
    Ok((Setup::from_archive(&archive, &path)?, snapshot_from_archive(&archive, &path)?))
}

/// Makes everything in memory.
pub fn make(scene: &Scene, mesh: &Mesh) -> Result<(Setup, Snapshot)> {
    if scene.cosserat.is_some() {
        return super::grid::setup(scene, mesh);
    }
    let topology = Topology::new(&mesh.faces);
    let mut setup = Setup::default();
    (setup.held, setup.held_directors) = supports::find(scene, mesh, &topology)?;
    let compositions = Compositions::new(scene, mesh)?;
    setup.materials = compositions.materials();
    let shell = build::shell(scene, mesh, &topology, &setup);
    let mut x: Vec<f64> = mesh.nodes().iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(shell.unknowns(), 0.0);
    setup.initial_forms = shell.forms(&x).iter().map(|e| Forms { a: [e[0], e[1], e[2]], b: [e[3], e[4], e[5]] }).collect();
    if let Some(f) = setup.initial_forms.iter().position(|f| !f.is_admissible()) {
        return Err(Error::input("mesh", format!("face {} has no area that can be computed with", f / shell.points())));
    }
    setup.machine_direction = rest::machine_direction(scene, mesh, &topology, &setup)?;
    setup.constitutions = compositions.constitutions(setup.machine_direction.as_deref());
    setup.densities = compositions.densities;
    if let Some(limit) = setup.limit() {
        limit(&setup.initial_forms).map_err(|e| Error::input("mesh", e))?;
    }
    setup.rest_forms = match rest::driver(scene, mesh, &topology, &setup, &diffusion::profiles(scene, mesh)?)? {
        Some(mut driver) => {
            // As a load step the law has no share yet at t = 0; asking for the end finds places where it is impossible before the run does.
            let impossible = |e: Impossible| Error::input(place_of_law(e.law), e.reason);
            if !scene.runs_in_time() {
                driver.forms(1.0).map_err(impossible)?;
            }
            driver.forms(0.0).map_err(impossible)?
        }
        None => setup.initial_forms.clone(),
    };
    drop(shell);
    let mut model = build::shell_model(scene, mesh, &topology, &setup)?;
    check_prescribed(scene, &model)?;
    super::stepping::Stepping::new(scene, mesh)?;
    super::report::check_measures(scene, mesh, &super::run::columns(scene, &model))?;
    setup.free_unknowns = model.free_unknowns();
    if let Some(table) = scene.statics.as_ref().and_then(|s| s.perturbation.as_ref()) {
        super::perturbation::apply(table, scene, mesh, &topology, &setup, &mut model)?;
    }
    Ok((setup, model.snapshot()))
}

/// Makes sure that what is prescribed at the start and, for load steps, at the end is finite.
pub fn check_prescribed(scene: &Scene, model: &dyn Model) -> Result<()> {
    for time in if scene.runs_in_time() { &[0.0][..] } else { &[0.0, 1.0] } {
        model.check_prescribed(*time).map_err(|failure| match failure {
            StepFailure::Input { place, reason } => Error::input(place, reason),
            other => Error::input("setup", format!("{other:?}")),
        })?;
    }
    Ok(())
}

/// The region of that name, with its name in the error if there is none.
pub fn region<'a>(mesh: &'a Mesh, key: &str, name: &str) -> Result<&'a Region> {
    mesh.regions.get(name).ok_or_else(|| {
        let known: Vec<&str> = mesh.regions.keys().map(String::as_str).collect();
        Error::input_with_help(key, format!("there is no region '{name}'"), format!("the mesh has: {}", known.join(", ")))
    })
}

fn rows(forms: &[Forms]) -> Array {
    Array::rows(forms.iter().flat_map(|f| f.a.into_iter().chain(f.b)).collect(), 6)
        .with("unit", "m2 m2 m2 m m m")
        .with("components", "a11 a12 a22 b11 b12 b22")
}

impl Setup {
    /// What tells the first face whose material cannot have forms given for each integration point; none where every material can have any.
    pub fn limit(&self) -> Option<Limit> {
        if !self.constitutions.contains(&Constitution::NeoHookean) {
            return None;
        }
        let (materials, constitutions) = (self.materials.clone(), self.constitutions.clone());
        Some(Box::new(move |forms| {
            let points = forms.len() / materials.len();
            let refused = |k: &usize| !constitutions[k / points].admits(&materials[k / points], &forms[*k]);
            let Some(face) = (0..forms.len()).find(refused).map(|k| k / points) else { return Ok(()) };
            let thickness = materials[face].thickness;
            Err(format!("face {face} is bent more sharply than its thickness of {thickness} m allows for a neo-hookean shell"))
        }))
    }

    /// Law of a face.
    pub fn constitution(&self, face: usize) -> Constitution {
        self.constitutions.get(face).copied().unwrap_or_default()
    }

    fn to_archive(&self, inputs: &str) -> Archive {
        let mut archive = Archive::new(Kind::Setup, inputs);
        archive.numbers.insert("free_unknowns".into(), self.free_unknowns as f64);
        let mut put = |name: &str, array| archive.arrays.insert(name.into(), array);
        // A surface on a grid has constants instead.
        if !self.materials.is_empty() {
            let material = self.materials.iter().flat_map(|m| [m.thickness, m.youngs_modulus, m.poissons_ratio]).collect();
            put(
                "material",
                Array::rows(material, 3).with("unit", "m, Pa, 1").with("components", "thickness, Young's modulus, Poisson's ratio"),
            );
            put("initial_forms", rows(&self.initial_forms));
            put("rest_forms", rows(&self.rest_forms));
        }
        if !self.constitutions.is_empty() {
            put("constitution", materials::to_array(&self.constitutions));
        }
        if !self.densities.is_empty() {
            put("density", Array::rows(self.densities.clone(), 1).with("unit", "kg/m3"));
        }
        if let Some(d) = &self.machine_direction {
            put("machine_direction", Array::rows(d.iter().flatten().copied().collect(), 2).with("unit", "1").with("basis", "barycentric"));
        }
        if !self.held.is_empty() {
            put(
                "held_unknowns",
                Array::indices(self.held.iter().flat_map(|h| [h.unknown, h.pin.map_or(0, |p| p + 1)]), 2)
                    .with("components", "unknown, number of the pin that moves it or 0"),
            );
        }
        if !self.held_directors.is_empty() {
            let plane = |support: &Director| match support {
                Director::Symmetry(normal) => *normal,
                _ => Vector3::zeros(),
            };
            put("held_director_edges", Array::indices(self.held_directors.iter().map(|(e, _)| *e), 1));
            let planes = self.held_directors.iter().flat_map(|(_, support)| plane(support).data.0[0]).collect();
            put("held_director_planes", Array::rows(planes, 3).with("meaning", "normal of the plane of symmetry; 0 where clamped"));
        }
        archive
    }

    fn from_archive(archive: &Archive, path: &Path) -> Result<Self> {
        let missing = |name: &str| archive.kind.stale(path, format!("array '{name}' is missing or of another type"));
        let real = |name: &str| archive.arrays.get(name).and_then(Array::as_f64).ok_or_else(|| missing(name));
        let whole = |name: &str| -> Result<Vec<usize>> {
            let Some(array) = archive.arrays.get(name) else { return Ok(Vec::new()) };
            Ok(array.as_i64().ok_or_else(|| missing(name))?.iter().map(|i| *i as usize).collect())
        };
        let optional = |name: &str| if archive.arrays.contains_key(name) { real(name).map(Some) } else { Ok(None) };
        let is_shell = ["material", "initial_forms", "rest_forms"].iter().any(|name| archive.arrays.contains_key(*name));
        let of_shell = |name: &str| if is_shell { real(name) } else { Ok(&[][..]) };
        let forms = |name: &str| -> Result<Vec<Forms>> {
            Ok(of_shell(name)?.chunks_exact(6).map(|r| Forms { a: [r[0], r[1], r[2]], b: [r[3], r[4], r[5]] }).collect())
        };
        let planes = optional("held_director_planes")?.unwrap_or(&[]).chunks_exact(3).map(|d| Vector3::new(d[0], d[1], d[2]));
        let supports = planes.map(|normal| if normal == Vector3::zeros() { Director::Clamped } else { Director::Symmetry(normal) });
        let machine_direction: Option<Vec<[f64; 2]>> =
            optional("machine_direction")?.map(|d| d.chunks_exact(2).map(|d| [d[0], d[1]]).collect());
        let constitutions = optional("constitution")?.map_or(Some(Vec::new()), |rows| materials::from_rows(rows, &machine_direction));
        Ok(Setup {
            constitutions: constitutions.ok_or_else(|| missing("constitution"))?,
            materials: of_shell("material")?
                .chunks_exact(3)
                .map(|m| Material { thickness: m[0], youngs_modulus: m[1], poissons_ratio: m[2] })
                .collect(),
            densities: optional("density")?.unwrap_or(&[]).to_vec(),
            initial_forms: forms("initial_forms")?,
            rest_forms: forms("rest_forms")?,
            machine_direction,
            held: whole("held_unknowns")?.chunks_exact(2).map(|h| Held { unknown: h[0], pin: h[1].checked_sub(1) }).collect(),
            held_directors: whole("held_director_edges")?.into_iter().zip(supports).collect(),
            free_unknowns: archive.numbers.get("free_unknowns").map_or(0, |n| *n as usize),
        })
    }
}

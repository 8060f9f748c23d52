//! What the physics tests share: scenes run through all stages in a folder of their own, and states of a shell made by hand.

use nalgebra::{Matrix2, Vector3};
use thinshell::case::{Folder, History};
use thinshell::mesh::{Mesh, Topology};
use thinshell::model::{HeldUnknown, Parts, RestDriver, ShellModel};
use thinshell::scene;
use thinshell::shell::rest::Forms;
use thinshell::shell::{Director, Koiter, LinearAverage, LinearFree, Material, Measure, Shell};
use thinshell::snapshot::Snapshot;
use thinshell::stage::{self, Job};

/// A scene that was run to its end.
pub struct Case {
    pub mesh: Mesh,
    /// Positions at the end [m].
    pub end: Vec<Vector3<f64>>,
    pub job: Job,
    history: thinshell::case::history::Table,
    _folder: tempfile::TempDir,
}

fn job(text: &str) -> (Job, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let (scene, source) = scene::parse("scene.toml", text, &[]).unwrap_or_else(|e| panic!("{e:?}"));
    let case = folder.path().join("case");
    (Job { scene, scene_file: folder.path().join("scene.toml"), source, case, quiet: true }, folder)
}

pub fn points(snapshot: &Snapshot, field: &str) -> Vec<Vector3<f64>> {
    snapshot.field(field).unwrap().data.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect()
}

/// Runs a scene through mesh, setup and run.
pub fn try_run(text: &str) -> thinshell::Result<Case> {
    let (job, folder) = job(text);
    stage::mesh::run(&job)?;
    stage::setup::run(&job)?;
    stage::run::run(&job, &stage::run::Options::default())?;
    let mesh = stage::mesh::load(&job)?;
    let history = History::read(&stage::run::history_path(&job))?;
    let mut case = Case { mesh, end: Vec::new(), history, job, _folder: folder };
    case.end = points(case.states().last().unwrap(), "position");
    Ok(case)
}

pub fn run(text: &str) -> Case {
    try_run(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

impl Case {
    /// The checkpoints that were kept, the start first.
    pub fn states(&self) -> Vec<Snapshot> {
        let folder = Folder::new(&self.job.case, stage::run::inputs(&self.job).unwrap());
        folder.list().unwrap().into_iter().map(|step| folder.read(step).unwrap()).collect()
    }

    /// A column of the history.
    pub fn column(&self, name: &str) -> Vec<f64> {
        self.history.column(name).unwrap_or_else(|| panic!("no column {name}"))
    }

    pub fn last(&self, name: &str) -> f64 {
        *self.column(name).last().unwrap()
    }

    /// Initial and final place of the vertex nearest to a point.
    pub fn vertex(&self, x: f64, y: f64, z: f64) -> (Vector3<f64>, Vector3<f64>) {
        let v = self.mesh.region_nearest(Vector3::new(x, y, z)).vertices[0];
        (self.mesh.vertices[v], self.end[v])
    }

    pub fn displacement(&self, x: f64, y: f64, z: f64) -> Vector3<f64> {
        let (from, to) = self.vertex(x, y, z);
        to - from
    }
}

/// The forms and the first state that the setup makes of a scene.
pub fn set_up(text: &str) -> thinshell::Result<(Mesh, stage::setup::Setup, Snapshot)> {
    let (job, _folder) = job(text);
    stage::mesh::run(&job)?;
    let mesh = stage::mesh::load(&job)?;
    let (setup, snapshot) = stage::setup::make(&job.scene, &mesh)?;
    Ok((mesh, setup, snapshot))
}

pub fn matrix(form: [f64; 3]) -> Matrix2<f64> {
    Matrix2::new(form[0], form[1], form[1], form[2])
}

/// Principal curvatures of a face, the more negative first: eigenvalues of `a^-1 b`.
pub fn principal(e: &[f64; 6]) -> [f64; 2] {
    let shape = matrix([e[0], e[1], e[2]]).try_inverse().unwrap() * matrix([e[3], e[4], e[5]]);
    let (mean, det) = (0.5 * shape.trace(), shape.determinant());
    let root = (mean * mean - det).max(0.0).sqrt();
    [mean - root, mean + root]
}

/// Slope of `log(error)` over `log(size)` between neighbours, sizes halving.
pub fn rates(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// Mean of the rates.
pub fn rate(errors: &[f64]) -> f64 {
    (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Average,
    Sin,
    Tan,
}

/// A shell of one kind over a mesh, with rest forms of zero.
pub fn shell(kind: Kind, mesh: &Mesh, supports: &[Director], material: Material) -> Box<dyn Shell> {
    let topology = Topology::new(&mesh.faces);
    let materials = vec![material; mesh.faces.len()];
    let free = |measure| LinearFree::new(mesh, &topology, measure, supports);
    match kind {
        Kind::Average => Box::new(Koiter::new(LinearAverage::new(mesh, &topology, supports), materials, None)),
        Kind::Sin => Box::new(Koiter::new(free(Measure::Sin), materials, None)),
        Kind::Tan => Box::new(Koiter::new(free(Measure::Tan), materials, None)),
    }
}

pub fn free(mesh: &Mesh) -> Vec<Director> {
    vec![Director::Free; Topology::new(&mesh.faces).edges.len()]
}

/// All unknowns of a shell at the vertices of a mesh, angles zero.
pub fn unknowns(shell: &dyn Shell, mesh: &Mesh) -> Vec<f64> {
    let mut x: Vec<f64> = mesh.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    x.resize(shell.unknowns(), 0.0);
    x
}

pub fn forms(strains: &[[f64; 6]]) -> Vec<Forms> {
    strains.iter().map(|e| Forms { a: [e[0], e[1], e[2]], b: [e[3], e[4], e[5]] }).collect()
}

/// A static model that starts at the vertices of `mesh`. `rest`: rest forms where no driver says otherwise.
pub fn model(
    shell: Box<dyn Shell>,
    mesh: &Mesh,
    rest: Vec<Forms>,
    driver: Option<RestDriver>,
    held: impl IntoIterator<Item = usize>,
) -> ShellModel {
    let x = unknowns(&*shell, mesh);
    let held = held.into_iter().map(|unknown| HeldUnknown { unknown, start: x[unknown], motion: None }).collect();
    let parts = Parts {
        shell,
        inertia: None,
        transports: Vec::new(),
        following_mass: None,
        loads: vec![],
        rest: driver,
        initial_forms: rest,
        held,
        positions: mesh.vertices.clone(),
        velocities: vec![],
    };
    ShellModel::new(parts, mesh.diameter(), 1e-10, 50).unwrap()
}

/// Lays a flat mesh onto a cylinder about the y axis (x runs around, y along), normals outward.
pub fn rolled(flat: &Mesh, radius: f64) -> Mesh {
    placed(flat, |p| Vector3::new(radius * (p.x / radius).sin(), p.y, radius * (p.x / radius).cos()))
}

/// Lays a flat mesh onto a sphere by arc length from the origin, normals outward.
pub fn capped(flat: &Mesh, radius: f64) -> Mesh {
    placed(flat, |p| {
        let r = p.x.hypot(p.y);
        let across = if r > 0.0 { radius * (r / radius).sin() / r } else { 1.0 };
        Vector3::new(p.x * across, p.y * across, radius * (r / radius).cos())
    })
}

pub fn placed(flat: &Mesh, place: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Mesh {
    Mesh { vertices: flat.vertices.iter().map(place).collect(), ..flat.clone() }
}

/// Supports of a free body: six components at three vertices around (x, y), `dx` and `dy` apart.
pub fn six_pins(x: f64, y: f64, dx: f64, dy: f64) -> String {
    format!(
        "[[region]]\nname = \"c\"\nnearest = [{x}, {y}, 0.0]\n[[region]]\nname = \"a\"\nnearest = [{x}, {}, 0.0]\n[[region]]\nname = \"d\"\nnearest = [{}, {y}, 0.0]\n\
         [[pin]]\nregion = \"c\"\n[[pin]]\nregion = \"a\"\ncomponents = [\"x\", \"z\"]\n[[pin]]\nregion = \"d\"\ncomponents = [\"z\"]\n",
        y + dy,
        x + dx
    )
}

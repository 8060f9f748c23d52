//! `modes`: the lowest modes of vibration or buckling about the last equilibrium (`modes.h5`, `modes.json`, `vtk/modes.pvd`).

use super::{Job, build, mesh as mesh_stage, run as run_stage, setup};
use crate::case::{Archive, Array, Folder, Kind, atomic, hash, vtk};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::model::ShellModel;
use crate::scene::{ModeKind, Modes};
use crate::snapshot::{Association, Field, Snapshot};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::path::PathBuf;

/// What the stage found.
pub struct Found {
    /// Which modes.
    pub kind: ModeKind,
    /// Frequencies [Hz], negative where the equilibrium is unstable and the mode grows at that rate over 2 pi; or factors on the load [1]. Ascending.
    pub values: Vec<f64>,
    /// Frequencies [Hz] up to which each could be round-off, in which case it is 0; empty for factors.
    pub round_off: Vec<f64>,
    /// Displacement of each node in each mode, its largest coordinate 1.
    pub shapes: Vec<Vec<f64>>,
}

/// The stage; says that there is nothing to do where the scene has no such table.
///
/// # Errors
/// Stale inputs, a run that is not at its end, modes that cannot be found ([`Error::Numerical`]).
pub fn run(job: &Job) -> Result<()> {
    let Some(table) = &job.scene.modes else {
        return Err(Error::input("modes", format!("{} has no such table", job.scene_file.display())));
    };
    let mesh = mesh_stage::load(job)?;
    let (setup, first) = setup::load(job)?;
    let folder = Folder::new(&job.case, run_stage::inputs(job)?);
    let last = run_stage::progress(job)?.snapshot.filter(|_| run_stage::is_done(job).unwrap_or(false)).ok_or_else(|| Error::Stale {
        path: job.case.join("run"),
        message: "the run is not at its end".into(),
        help: "finish it: thinshell run SCENE".into(),
    })?;
    let _lock = folder.lock()?;
    let topology = Topology::new(&mesh.faces);
    let mut model = build::shell_model(&job.scene, &mesh, &topology, &setup)?;
    let found = match table.kind {
        ModeKind::Vibration => {
            let inertia = build::inertia(&job.scene, &mesh, &topology, &setup)
                .ok_or_else(|| Error::input("shell.density", "this key is missing, and [modes] needs it [kg/m3]"))?;
            restore(&mut model, &last)?;
            model.vibration_modes(inertia, table.count, table.shift)
        }
        ModeKind::Buckling => model.buckling_modes([&first, &last], table.count, table.shift.unwrap_or(0.0)),
    };
    let modes = found.map_err(|reason| Error::Numerical {
        message: format!("no modes of {}: {reason}", name(table.kind)),
        help: Some("the run and its checkpoints are kept".into()),
    })?;
    if modes.len() < table.count {
        log::warn!("{} modes were found, as there are no more", modes.len());
    }
    let coordinates = 3 * mesh.nodes().len();
    let found = Found {
        kind: table.kind,
        values: modes.iter().map(|mode| number(table.kind, mode.value)).collect(),
        round_off: match table.kind {
            ModeKind::Vibration => modes.iter().map(|mode| number(table.kind, mode.noise)).collect(),
            ModeKind::Buckling => Vec::new(),
        },
        shapes: modes.into_iter().map(|mode| mode.vector[..coordinates].to_vec()).collect(),
    };
    archive(&found, &inputs(job)?).write(&path(job))?;
    atomic::write(&job.case.join("modes.json"), json(&found).as_bytes())?;
    job.record()?;
    job.say(&format!("{}: {}", path(job).display(), found.list()));
    Ok(())
}

fn restore(model: &mut ShellModel, state: &Snapshot) -> Result<()> {
    model.restore(state).map_err(|e| Error::input("checkpoint", e))
}

/// A frequency by its square in radians, or a factor as it is.
fn number(kind: ModeKind, value: f64) -> f64 {
    match kind {
        ModeKind::Vibration => value.signum() * value.abs().sqrt() / TAU,
        ModeKind::Buckling => value,
    }
}

fn name(kind: ModeKind) -> &'static str {
    match kind {
        ModeKind::Vibration => "vibration",
        ModeKind::Buckling => "buckling",
    }
}

/// Name of the values, with their unit.
fn quantity(kind: ModeKind) -> &'static str {
    match kind {
        ModeKind::Vibration => "frequency_Hz",
        ModeKind::Buckling => "buckling_factor",
    }
}

fn unit(kind: ModeKind) -> &'static str {
    match kind {
        ModeKind::Vibration => "Hz",
        ModeKind::Buckling => "times the load",
    }
}

/// Path of the stage's file.
pub fn path(job: &Job) -> PathBuf {
    job.case.join("modes.h5")
}

/// Hash of what the stage's file is made from.
pub fn inputs(job: &Job) -> Result<String> {
    let run = run_stage::inputs(job)?;
    let table = serde_json::to_string(&job.scene.modes).map_err(|e| Error::input("modes", e.to_string()))?;
    let states = Folder::new(&job.case, &run).fingerprint()?;
    Ok(hash::of(&[run.as_bytes(), table.as_bytes(), states.as_bytes()]))
}

/// Whether there is nothing to do: the file is that of the present run, or the scene has no such table.
///
/// # Errors
/// Those of the run.
pub fn is_current(job: &Job) -> Result<bool> {
    Ok(job.scene.modes.is_none() || Archive::read_for(&path(job), Kind::Modes, &inputs(job)?).is_ok())
}

fn archive(found: &Found, inputs: &str) -> Archive {
    let mut archive = Archive::new(Kind::Modes, inputs);
    let unit = if found.kind == ModeKind::Vibration { "Hz" } else { "1" };
    archive.arrays.insert(quantity(found.kind).into(), Array::rows(found.values.clone(), 1).with("unit", unit));
    if !found.round_off.is_empty() {
        archive.arrays.insert("round_off_Hz".into(), Array::rows(found.round_off.clone(), 1).with("unit", unit));
    }
    let shapes: Vec<f64> = found.shapes.concat();
    let shape = vec![found.shapes.len(), shapes.len() / (3 * found.shapes.len()).max(1), 3];
    let array = Array { shape, ..Array::rows(shapes, 3) };
    archive.arrays.insert("mode".into(), array.with("unit", "1").with("meaning", "displacement of each node, its largest coordinate 1"));
    archive
}

fn json(found: &Found) -> String {
    let rows: Vec<_> =
        found.values.iter().enumerate().map(|(i, value)| serde_json::json!({ "mode": i + 1, quantity(found.kind): value })).collect();
    serde_json::to_string_pretty(&rows).unwrap_or_default() + "\n"
}

/// Reads what the stage wrote; none where the scene has no such table.
///
/// # Errors
/// A file that is missing, damaged or stale.
pub fn load(job: &Job) -> Result<Option<Found>> {
    let Some(Modes { kind, .. }) = job.scene.modes else { return Ok(None) };
    let path = path(job);
    let archive = Archive::read_for(&path, Kind::Modes, &inputs(job)?)?;
    let array = |name: &str| {
        let found = archive.arrays.get(name).and_then(Array::as_f64);
        found.ok_or_else(|| Kind::Modes.stale(&path, format!("array '{name}' is missing or of another type")))
    };
    let values = array(quantity(kind))?.to_vec();
    let round_off = if kind == ModeKind::Vibration { array("round_off_Hz")?.to_vec() } else { Vec::new() };
    let shapes = array("mode")?;
    let length = (shapes.len() / values.len().max(1)).max(1);
    Ok(Some(Found { kind, shapes: shapes.chunks_exact(length).map(<[f64]>::to_vec).collect(), round_off, values }))
}

/// Writes each mode as a file with the last equilibrium as its shape: field `mode` and, in `modes.json`, its value. The names of the files.
pub fn export(found: &Found, mesh: &Mesh, state: &Snapshot, folder: &std::path::Path) -> Result<Vec<(f64, String)>> {
    let positions = state.field("position").map_or(&[][..], |f| &f.data);
    let points: Vec<Vector3<f64>> = positions.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
    let curved = if mesh.midpoints.is_empty() { Vec::new() } else { mesh.six_node_faces() };
    let faces = if curved.is_empty() { vtk::Faces::Linear(&mesh.faces) } else { vtk::Faces::Quadratic(&curved) };
    let mut files = Vec::new();
    for (i, shape) in found.shapes.iter().enumerate() {
        let field = Field { name: "mode".into(), association: Association::Node, components: 3, unit: "1".into(), data: shape.clone() };
        let name = format!("mode_{:04}.{}", i + 1, faces.extension());
        vtk::Surface { points: &points, faces, point_data: vec![field], cell_data: Vec::new() }.write(&folder.join(&name))?;
        files.push(((i + 1) as f64, name));
    }
    atomic::write(&folder.join("modes.json"), json(found).as_bytes())?;
    vtk::write_series(&folder.join("modes.pvd"), &files, None)?;
    Ok(files)
}

impl Found {
    /// Lines for a report.
    pub fn lines(&self) -> Vec<String> {
        vec![format!("Lowest modes of {}: {}", name(self.kind), self.list())]
    }

    /// The values with their unit, and what a 0 stands for.
    fn list(&self) -> String {
        let list: Vec<String> = self.values.iter().map(|value| crate::report::number(*value)).collect();
        let zeros = self.values.iter().zip(&self.round_off).filter(|(value, _)| **value == 0.0).map(|(_, noise)| *noise);
        let noise = zeros.fold(0.0, f64::max);
        let zero = if noise > 0.0 { format!(" (0: up to {noise:.1e} {}, which is round-off)", unit(self.kind)) } else { String::new() };
        format!("{} {}{zero}", list.join(", "), unit(self.kind))
    }
}

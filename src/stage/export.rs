//! `export`: writes checkpoints as VTK files (`vtk/*.vtp`, curved faces `*.vtu`, with a `.pvd`) for ParaView and pyvista.

use super::fields::State;
use super::grid_fields::Shown;
use super::{Job, mesh as mesh_stage, modes, run as run_stage, setup};
use crate::case::{Folder, hash, vtk};
use crate::error::{Error, Result};
use crate::mesh::{FieldOn, Mesh, Topology, conformal};
use crate::snapshot::{Association, Field};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Whether the files that are there are those of the present checkpoints.
///
/// # Errors
/// Those of the run.
pub fn is_current(job: &Job) -> Result<bool> {
    Ok(vtk::made_from(&path(job)).is_some_and(|hash| inputs(job).is_ok_and(|now| now == hash)))
}

/// Hash of what the files are made from: the checkpoints, and what is written of them.
fn inputs(job: &Job) -> Result<String> {
    let run = run_stage::inputs(job)?;
    let output = serde_json::to_string(&job.scene.output).map_err(|e| Error::input("output", e.to_string()))?;
    let checkpoints = Folder::new(&job.case, &run).fingerprint()?;
    let modes = if job.scene.modes.is_some() { modes::inputs(job)? } else { String::new() };
    Ok(hash::of(&[env!("CARGO_PKG_VERSION"), &run, &output, &checkpoints, &modes].map(str::as_bytes)))
}

/// The stage.
///
/// # Errors
/// Files that are missing, damaged or stale, or cannot be written.
pub fn run(job: &Job) -> Result<()> {
    let mesh = mesh_stage::load(job)?;
    let (setup, _) = setup::load(job)?;
    let mut folder = Folder::new(&job.case, run_stage::inputs(job)?);
    let steps = folder.kept()?;
    if steps.is_empty() {
        return Err(Error::Stale {
            path: job.case.join("run"),
            message: "has no checkpoint".into(),
            help: "make some: thinshell run SCENE".into(),
        });
    }
    let topology = Topology::new(&mesh.faces);
    let mut fields = Shown::new(&job.scene, &mesh, &topology, &setup)?;
    let series = path(job);
    let vtk_folder = series.parent().map(PathBuf::from).unwrap_or_default();
    std::fs::create_dir_all(&vtk_folder).map_err(|e| Error::io("create", &vtk_folder, e))?;
    let curved = if mesh.midpoints.is_empty() { Vec::new() } else { mesh.six_node_faces() };
    let cells = if let Shown::Grid(grid) = &fields { grid.quadrangles() } else { Vec::new() };
    let faces = match (curved.is_empty(), cells.is_empty()) {
        (false, _) => vtk::Faces::Quadratic(&curved),
        (true, true) => vtk::Faces::Linear(&mesh.faces),
        (true, false) => vtk::Faces::Quadrangles(&cells),
    };
    let (mut files, mut director_files, mut units) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut prism_files: BTreeMap<&str, Vec<(f64, String)>> = BTreeMap::new();
    let mut whole = true;
    let by_step = job.scene.statics.as_ref().is_some_and(|s| s.arc_length.is_some());
    for step in steps {
        let snapshot = match folder.read(step) {
            Ok(snapshot) => snapshot,
            Err(Error::Stale { path, message, .. }) if path == folder.path(step) && !message.contains("other inputs") => {
                log::warn!("{}: {message}; left out", path.display());
                whole = false;
                continue;
            }
            Err(e) => return Err(e),
        };
        // A load factor that goes back and forth would not keep the states in their order.
        let time = if by_step { step as f64 } else { snapshot.time };
        let mut state = fields.of(&snapshot)?;
        for field in state.point_data.iter().chain(&state.cell_data) {
            units.insert(field.name.clone(), field.unit.clone());
        }
        add_mesh_fields(&mesh, &mut state);
        if let (true, Shown::Shell(fields)) = (job.scene.output.directors, &fields) {
            let (points, directors) = fields.directors(&state, &snapshot);
            let name = format!("directors_{step:08}.vtp");
            let surface =
                vtk::Surface { points: &points, faces: vtk::Faces::Linear(&[]), point_data: vec![directors], cell_data: Vec::new() };
            surface.write(&vtk_folder.join(&name))?;
            director_files.push((time, name));
        }
        for (_, quantity, unit, _) in job.scene.diffusing().filter(|(.., said)| said.prisms) {
            let Shown::Shell(fields) = &fields else { continue };
            let Some((points, wedges, values)) = fields.prisms(&state, quantity) else { continue };
            let name = format!("{quantity}_prisms_{step:08}.vtu");
            let field = Field { name: quantity.into(), association: Association::Node, components: 1, unit: unit.into(), data: values };
            let body = vtk::Surface { points: &points, faces: vtk::Faces::Wedges(&wedges), point_data: vec![field], cell_data: Vec::new() };
            body.write(&vtk_folder.join(&name))?;
            units.insert(quantity.to_owned(), unit.to_owned());
            prism_files.entry(quantity).or_default().push((time, name));
        }
        let name = format!("step_{step:08}.{}", faces.extension());
        vtk::Surface { points: &state.points, faces, point_data: state.point_data, cell_data: state.cell_data }
            .write(&vtk_folder.join(&name))?;
        files.push((time, name));
    }
    // A case may be looked at before its modes have been found.
    let mut mode_files = Vec::new();
    if modes::is_current(job)?
        && let Some(found) = modes::load(job)?
        && let Some(last) = folder.newest_valid()?.snapshot
    {
        mode_files = modes::export(&found, &mesh, &last, &vtk_folder)?;
        units.insert("mode".into(), "1".into());
    }
    whole &= job.scene.modes.is_none() || !mode_files.is_empty();
    // In statics time is the load factor, along a path the number of the step.
    if job.scene.flatten.is_some() {
        units.extend([(conformal::FACTOR.to_owned(), "1".to_owned()), (conformal::POSITION.to_owned(), "m".to_owned())]);
    }
    units.insert("time".into(), if job.scene.runs_in_time() { "s" } else { "1" }.into());
    vtk::write_units(&vtk_folder.join("units.json"), &units)?;
    let kept: Vec<&str> = files
        .iter()
        .chain(&director_files)
        .chain(&mode_files)
        .chain(prism_files.values().flatten())
        .map(|(_, name)| name.as_str())
        .collect();
    remove_leftovers(&vtk_folder, &kept)?;
    if !director_files.is_empty() {
        vtk::write_series(&vtk_folder.join("directors.pvd"), &director_files, None)?;
    }
    for (quantity, files) in &prism_files {
        vtk::write_series(&vtk_folder.join(format!("{quantity}_prisms.pvd")), files, None)?;
    }
    // Not of what lacks a state: that is to be tried again.
    let inputs = if whole { Some(inputs(job)?) } else { None };
    vtk::write_series(&series, &files, inputs.as_deref())?;
    job.say(&format!("{}: {} states", series.display(), files.len()));
    Ok(())
}

/// Adds the fields of the mesh as they are, which have no unit that is known; the name of a computed field is taken, so `_initial` follows.
fn add_mesh_fields(mesh: &Mesh, state: &mut State) {
    let mut taken: BTreeSet<String> = state.point_data.iter().chain(&state.cell_data).map(|f| f.name.clone()).collect();
    for (name, field) in &mesh.fields {
        let mut name = name.clone();
        while !taken.insert(name.clone()) {
            name.push_str("_initial");
        }
        let (list, association) = match field.on {
            FieldOn::Nodes => (&mut state.point_data, Association::Node),
            FieldOn::Faces => (&mut state.cell_data, Association::Face),
        };
        list.push(Field { name, association, components: field.components, unit: String::new(), data: field.data.clone() });
    }
}

/// Path of the series.
pub fn path(job: &Job) -> PathBuf {
    job.case.join("vtk").join("case.pvd")
}

/// Removes states of an earlier export that this one does not have.
fn remove_leftovers(folder: &std::path::Path, kept: &[&str]) -> Result<()> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))?;
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let ours = ["step_", "directors", "mode_", "moisture_prisms", "temperature_prisms"].iter().any(|start| name.starts_with(start));
        let written = [".vtp", ".vtu", ".pvd"].iter().any(|ending| name.ends_with(ending));
        if ours && written && !kept.contains(&name.as_str()) {
            std::fs::remove_file(entry.path()).map_err(|e| Error::io("remove", &entry.path(), e))?;
        }
    }
    Ok(())
}

//! `report`: compares results with what their scenes expect (`report.json`, `report.md`), and tabulates error against run time.

use super::fields::{self, Fields};
use super::{Job, all, mesh as mesh_stage, print, run as run_stage, setup};
use crate::case::{Folder, History, atomic};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Topology};
use crate::report::{Cost, ExpectationResult, LadderRow, Outcome, cylinder_distance, ladder as ladder_table, mean};
use crate::scene::{Director, Element, Ladder, LadderMesh, Measure, MeshTable, Scene, Statistic};
use crate::snapshot::Snapshot;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// Reports on each of `targets`, a case's folder or a scene file (with `overrides`); `json` is written too, if given.
///
/// # Errors
/// Cases that are not there or not run, and [`Error::Missed`] when an expectation is.
pub fn run(targets: &[PathBuf], overrides: &[String], json: Option<&Path>, quiet: bool) -> Result<()> {
    let mut outcomes = Vec::new();
    for target in targets {
        outcomes.push(of_job(&Job::read(target, None, overrides, quiet)?)?);
    }
    if let Some(path) = json {
        let list: Vec<String> = outcomes.iter().map(Outcome::to_json).collect();
        let text = if let [one] = list.as_slice() { one.clone() } else { format!("[{}]", list.join(",")) };
        atomic::write(path, text.as_bytes())?;
    }
    verdict(&outcomes)
}

/// Writes `report.json` and `report.md` of one case and prints the latter.
pub fn of_job(job: &Job) -> Result<Outcome> {
    let case = Case::load(job)?;
    let mut results = Vec::new();
    for e in job.scene.report.iter().flat_map(|r| &r.expectations) {
        let value = case.measure(&e.measure, e.time)?;
        results.push(ExpectationResult::new(&e.name, value, e.reference, e.tolerance, &e.source));
    }
    let outcome = Outcome::new(job.name(), results, case.cost()?);
    atomic::write(&job.case.join("report.json"), outcome.to_json().as_bytes())?;
    let mut text = outcome.to_markdown();
    for line in case.switches() {
        text.push_str(&format!("\n{line}.\n"));
    }
    if let Some(unstable) = case.unstable() {
        text.push_str(&format!(
            "\nWarning: the last equilibrium is unstable in {unstable} directions; a small disturbance would make the shell leave it.\n"
        ));
    }
    atomic::write(&job.case.join("report.md"), text.as_bytes())?;
    job.record()?;
    if !job.quiet {
        print(text.trim_end())?;
    }
    Ok(outcome)
}

/// [`Error::Missed`] if some expectation is.
pub fn verdict(outcomes: &[Outcome]) -> Result<()> {
    let missed: Vec<&str> = outcomes.iter().filter(|o| !o.passed).map(|o| o.scene.as_str()).collect();
    if missed.is_empty() { Ok(()) } else { Err(Error::Missed(format!("expectations missed: {}", missed.join(", ")))) }
}

/// A case that has run.
struct Case<'a> {
    job: &'a Job,
    mesh: Mesh,
    setup: setup::Setup,
    folder: Folder,
    history: crate::case::history::Table,
}

impl<'a> Case<'a> {
    fn load(job: &'a Job) -> Result<Self> {
        let mesh = mesh_stage::load(job)?;
        let (setup, _) = setup::load(job)?;
        let folder = Folder::new(&job.case, run_stage::inputs(job)?);
        if !run_stage::is_done(job)? {
            return Err(Error::Stale {
                path: job.case.join("run"),
                message: "the run is not at its end".into(),
                help: "finish it: thinshell run SCENE".into(),
            });
        }
        let history = History::read(&run_stage::history_path(job))?;
        Ok(Case { job, mesh, setup, folder, history })
    }

    /// Unstable directions of the last equilibrium, if it has any.
    fn unstable(&self) -> Option<f64> {
        self.job.scene.statics.as_ref()?;
        self.history.last("negative_pivots").filter(|n| *n > 0.0)
    }

    /// Steps that left an unstable equilibrium, in words.
    fn switches(&self) -> Vec<String> {
        let column = |name| self.history.column(name).unwrap_or_default();
        let [times, totals, after, before] = ["time_s", "branch_switches", "lowest_eigenvalue", "lowest_eigenvalue_before"].map(column);
        let earlier = [0.0].into_iter().chain(totals.iter().copied());
        let steps = totals.iter().zip(earlier).enumerate().filter(|(_, (now, earlier))| *now > earlier);
        steps.map(|(i, _)| run_stage::switched(&self.job.moment(times[i]), before[i], after[i])).collect()
    }

    fn cost(&self) -> Result<Cost> {
        Ok(Cost {
            dofs: self.setup.free_unknowns,
            faces: self.mesh.faces.len(),
            wall_s: self.last("wall_s")?,
            newton_iterations: (self.last("newton_iterations")? + self.last("fallback_iterations")?) as u64,
            factorizations: self.last("factorizations")? as u64,
        })
    }

    /// Last value of a column of the history.
    fn last(&self, column: &str) -> Result<f64> {
        if self.history.rows.is_empty() {
            return Ok(0.0);
        }
        self.history.last(column).ok_or_else(|| {
            Error::input_with_help(
                "report",
                format!("the history has no column '{column}'"),
                format!("it has: {}", self.history.columns.join(", ")),
            )
        })
    }

    /// The snapshot nearest to a time, or the last.
    fn snapshot(&self, time: Option<f64>) -> Result<Snapshot> {
        let Some(time) = time else {
            let newest = self.folder.newest_valid()?.snapshot;
            return newest.ok_or_else(|| Error::Stale {
                path: self.job.case.join("run"),
                message: "has no checkpoint".into(),
                help: "make some: thinshell run SCENE".into(),
            });
        };
        let mut nearest: Option<Snapshot> = None;
        for step in self.folder.list()? {
            let snapshot = self.folder.read(step)?;
            if nearest.as_ref().is_none_or(|n| (snapshot.time - time).abs() < (n.time - time).abs()) {
                nearest = Some(snapshot);
            }
        }
        nearest.ok_or_else(|| Error::input("report", "there is no checkpoint"))
    }

    fn measure(&self, measure: &Measure, time: Option<f64>) -> Result<f64> {
        let positions = || -> Result<Vec<Vector3<f64>>> {
            let snapshot = self.snapshot(time)?;
            let field = snapshot.field("position").ok_or_else(|| Error::input("checkpoint", "it has no positions"))?;
            Ok(field.data.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect())
        };
        match measure {
            Measure::Displacement { at, axis, region } => {
                let (vertex, axis) = (vertex_at(&self.mesh, at, region.as_deref())?, super::build::axis_index(*axis));
                Ok(positions()?[vertex][axis] - self.mesh.vertices[vertex][axis])
            }
            Measure::CylinderDistance { radius } => Ok(cylinder_distance(&self.mesh.nodes(), &positions()?, *radius)),
            Measure::Field { name, component, statistic } => self.statistic(name, *component, *statistic, time),
            Measure::History { column } => self.last(column),
            Measure::NewtonIterations => Ok(self.last("newton_iterations")? + self.last("fallback_iterations")?),
            Measure::Factorizations => self.last("factorizations"),
        }
    }

    fn statistic(&self, name: &str, component: usize, statistic: Statistic, time: Option<f64>) -> Result<f64> {
        let topology = Topology::new(&self.mesh.faces);
        let state = Fields::new(&self.job.scene, &self.mesh, &topology, &self.setup)?.of(&self.snapshot(time)?)?;
        // Scenes name fields with hyphens, as all their keywords; files with underscores.
        let name = name.replace('-', "_");
        let (mut found, mut weights) = (state.cell_data.iter().find(|f| f.name == name), state.areas.clone());
        if found.is_none() {
            found = state.point_data.iter().find(|f| f.name == name);
            weights = vec![0.0; self.mesh.vertices.len()];
            for (face, area) in self.mesh.faces.iter().zip(&state.areas) {
                face.iter().for_each(|v| weights[*v] += area / 3.0);
            }
        }
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
        let values: Vec<f64> = field.data.iter().skip(component).step_by(field.components).copied().collect();
        Ok(match statistic {
            Statistic::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
            Statistic::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Statistic::Mean => mean(&values, &weights),
        })
    }
}

/// The vertex nearest to a place, of a region or of all.
fn vertex_at(mesh: &Mesh, at: &[f64; 3], region: Option<&str>) -> Result<usize> {
    let at = Vector3::from(*at);
    let among = match region {
        Some(name) => setup::region(mesh, "report", name)?.vertices.clone(),
        None => (0..mesh.vertices.len()).collect(),
    };
    let distance = |v: &usize| (mesh.vertices[*v] - at).norm();
    let nearest = among.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let nearest = nearest.ok_or_else(|| Error::input("report", "the region has no vertex"))?;
    mesh_stage::near(mesh, nearest, &at).map_err(|e| Error::input("report: displacement.at", e))?;
    Ok(nearest)
}

/// Refuses measures that this scene cannot have, before it is run: places far outside, regions, fields and columns that do not exist.
/// `columns`: of the history.
///
/// # Errors
/// The expectation's key and what there is instead.
pub fn check_measures(scene: &Scene, mesh: &Mesh, columns: &[&str]) -> Result<()> {
    let Some(report) = &scene.report else { return Ok(()) };
    let expected = report.expectations.iter().enumerate().map(|(i, e)| (format!("report.expect.{i}.measure"), &e.measure));
    let ladder = report.ladder.iter().map(|l| ("report.ladder.measure".to_owned(), &l.measure));
    for (key, measure) in expected.chain(ladder) {
        match measure {
            Measure::Displacement { at, region, .. } => {
                vertex_at(mesh, at, region.as_deref()).map_err(|e| Error::input(key, e.to_string()))?;
            }
            Measure::Field { name, component, .. } => {
                let (known, name) = (fields::names(scene), name.replace('-', "_"));
                let Some((_, components)) = known.iter().find(|(n, _)| *n == name) else {
                    let known: Vec<&str> = known.iter().map(|(n, _)| *n).collect();
                    return Err(Error::input_with_help(
                        key,
                        format!("there is no field '{name}'"),
                        format!("there are: {}", known.join(", ")),
                    ));
                };
                if component >= components {
                    return Err(Error::input(
                        key,
                        format!("field '{name}' has {components} components; {component} is not among them (they count from 0)"),
                    ));
                }
            }
            Measure::History { column } if column != "step" && !columns.contains(&column.as_str()) => {
                return Err(Error::input_with_help(
                    key,
                    format!("the history has no column '{column}'"),
                    format!("it has: {}", columns.join(", ")),
                ));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Runs the scene at every combination that its `[report.ladder]` lists, in folders of their own that do not stay, and tabulates error
/// against run time (`ladder.json`, `ladder.md` in the case, and `json`).
///
/// # Errors
/// A scene without a ladder, input errors of any combination. Numerical failures become rows that say so.
pub fn ladder(job: &Job, json: Option<&Path>) -> Result<()> {
    let Some(ladder) = job.scene.report.as_ref().and_then(|r| r.ladder.clone()) else {
        return Err(Error::input(job.scene_file.display().to_string(), "the scene has no [report.ladder]"));
    };
    let directors = if ladder.directors.is_empty() { vec![job.scene.shell.director] } else { ladder.directors.clone() };
    let thicknesses = if ladder.thicknesses.is_empty() { vec![job.scene.shell.thickness] } else { ladder.thicknesses.clone() };
    let meshes: Vec<Option<&LadderMesh>> = if ladder.meshes.is_empty() { vec![None] } else { ladder.meshes.iter().map(Some).collect() };
    let mut rows = Vec::new();
    let elements = if ladder.elements.is_empty() { vec![job.scene.shell.element] } else { ladder.elements.clone() };
    let pairs = elements.iter().flat_map(|e| directors.iter().map(move |d| (*e, *d)));
    for (element, director) in pairs.filter(|(e, d)| (*e, *d) != (Element::Quadratic, Director::Average)) {
        for mesh in &meshes {
            for thickness in &thicknesses {
                for resolution in &ladder.resolutions {
                    let mut scene = job.scene.clone();
                    (scene.shell.element, scene.shell.director) = (element, director);
                    scene.shell.thickness = *thickness;
                    vary_mesh(&mut scene.mesh, *mesh, *resolution);
                    let folder = tempfile::tempdir().map_err(|e| Error::io("create a folder in", &std::env::temp_dir(), e))?;
                    let step = Job { scene, case: folder.path().to_path_buf(), quiet: true, ..job.clone() };
                    let mut row = ladder_row(&step, &ladder)?;
                    row.director = match element {
                        Element::Linear => director.name().to_owned(),
                        Element::Quadratic => format!("quadratic {}", director.name()),
                    };
                    row.mesh = mesh.map_or_else(|| "own".to_owned(), |m| m.name.clone());
                    row.thickness = *thickness;
                    log::info!(
                        "{} {} h {:e} m, {} faces: error {}",
                        row.director,
                        row.mesh,
                        row.thickness,
                        row.faces,
                        row.error.map_or("none".to_owned(), |e| format!("{e:.3e}"))
                    );
                    rows.push(row);
                }
            }
        }
    }
    ladder_table::orders(&mut rows);
    let (text, table) = (ladder_table::to_json(&rows), ladder_table::to_markdown(&rows));
    std::fs::create_dir_all(&job.case).map_err(|e| Error::io("create", &job.case, e))?;
    atomic::write(&job.case.join("ladder.json"), text.as_bytes())?;
    atomic::write(&job.case.join("ladder.md"), table.as_bytes())?;
    if let Some(path) = json {
        atomic::write(path, text.as_bytes())?;
    }
    print(table.trim_end())
}

/// The scene's mesh in another variant, and finer by a factor.
fn vary_mesh(mesh: &mut MeshTable, variant: Option<&LadderMesh>, resolution: f64) {
    let finer = |n: &mut usize| *n = (*n as f64 * resolution).round().max(1.0) as usize;
    match mesh {
        MeshTable::Rectangle(t) => {
            t.cells.iter_mut().for_each(finer);
            t.triangulation.iter_mut().for_each(|t| t.size /= resolution);
            if let Some(variant) = variant {
                (t.pattern, t.jitter) = (variant.pattern, variant.jitter);
            }
        }
        MeshTable::Disc(t) => finer(&mut t.rings),
        MeshTable::SphereCap(t) => finer(&mut t.rings),
        MeshTable::Annulus(t) => t.cells.iter_mut().for_each(finer),
        MeshTable::Cylinder(t) => t.cells.iter_mut().for_each(finer),
        MeshTable::Outline(t) => t.triangulation.size /= resolution,
        MeshTable::File(_) => {}
    }
}

fn ladder_row(job: &Job, ladder: &Ladder) -> Result<LadderRow> {
    let (mesh, _) = mesh_stage::make(&job.scene, &job.scene_file)?;
    let mut row = LadderRow { faces: mesh.faces.len(), ..LadderRow::default() };
    match all::until_run(job) {
        Ok(()) => {
            let case = Case::load(job)?;
            let (value, cost) = (case.measure(&ladder.measure, None)?, case.cost()?);
            row.error = Some((value - ladder.reference).abs()).filter(|e| e.is_finite());
            row.failure = if row.error.is_none() { Some("the measure is not finite".into()) } else { None };
            (row.dofs, row.wall_s, row.factorizations) = (cost.dofs, cost.wall_s, cost.factorizations);
            Ok(row)
        }
        Err(Error::Numerical { message, .. }) => {
            row.dofs = setup::load(job)?.0.free_unknowns;
            row.failure = Some(message);
            Ok(row)
        }
        Err(e) => Err(e),
    }
}

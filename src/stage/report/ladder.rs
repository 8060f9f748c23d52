//! `report --ladder`: error against run time over resolutions, meshes, elements, directors, thicknesses, samplings and integrators, or over steps.

use super::super::Job;
use super::case::attempt;
use super::path::Spot;
use crate::case::atomic;
use crate::error::{Error, Result};
use crate::report::{DenseProduct, LadderRow, ladder as table};
use crate::scene::{
    Director, Element, Expectation, Integrator, Ladder, LadderExpectation, LadderMesh, MeshTable, Method, Refine, Refinement, Rest,
    Sampling, Scene,
};
use std::path::Path;

/// What of the scene a ladder varies besides the resolution.
#[derive(Clone, Copy)]
struct Variant<'a> {
    element: Element,
    director: Director,
    mesh: Option<&'a LadderMesh>,
    sampling: Option<Sampling>,
    thickness: f64,
    integrator: Option<Integrator>,
    method: Option<Method>,
}

/// Runs the scene at every combination that its `[report.ladder]` lists, in folders of their own that do not stay, and tabulates error
/// against run time (`ladder.json`, `ladder.csv` and `ladder.md` in the case, and `json`).
///
/// # Errors
/// A scene without a ladder, input errors of any combination, [`Error::Missed`] when an expectation of the ladder is. Numerical failures
/// become rows that say so; where all are, an error.
pub fn ladder(job: &Job, json: Option<&Path>) -> Result<()> {
    let Some((report, ladder)) = job.scene.report.as_ref().and_then(|r| Some((r, r.ladder.as_ref()?))) else {
        return Err(Error::input("report.ladder", format!("{} has no such table", job.scene_file.display())));
    };
    let mut rows = Vec::new();
    // Variants with the places of their finest runs.
    let mut finest = Vec::new();
    let mut machine = DenseProduct::default();
    for variant in variants(job, ladder) {
        let meets: Vec<&String> = variant.expectations(ladder).flat_map(|e| &e.meets).collect();
        let met: Vec<&Expectation> = report.expectations.iter().filter(|e| meets.contains(&&e.name)).collect();
        let resolutions = variant.resolutions(ladder);
        for resolution in &resolutions {
            machine.round();
            let is_finest = resolutions.last() == Some(resolution);
            let row = run(job, ladder, &variant, *resolution, if is_finest { &met } else { &[] })?;
            let error = row.error.map_or("none".to_owned(), |e| format!("{e:.3e}"));
            log::info!("{}, {} faces: error {error}", row.kind(), row.faces);
            rows.push(row);
        }
        finest.push((variant, rows.len() - 1));
    }
    rows.iter_mut().for_each(|row| row.gflop = 1e-9 * machine.rate() * row.wall_s);
    table::orders(&mut rows);
    for (variant, place) in finest {
        let row = &mut rows[place];
        let order = match ladder.refinement {
            Refinement::Anew => row.fitted_order,
            Refinement::Split | Refinement::Steps => row.order,
        };
        for expected in variant.expectations(ladder) {
            row.expect(order, expected.least_order, expected.largest_error, &expected.source);
        }
    }
    std::fs::create_dir_all(&job.case).map_err(|e| Error::io("create", &job.case, e))?;
    atomic::write(&job.case.join("ladder.csv"), table::to_csv(&rows).as_bytes())?;
    super::publish(job, "ladder", &table::to_json(&rows), &table::to_markdown(&rows), json)?;
    super::fail_if_all(rows.iter().map(|row| row.failure.is_some()), "ladder")?;
    let missed = rows.iter().map(|row| row.missed.len()).sum::<usize>();
    if missed == 0 { Ok(()) } else { Err(Error::Missed(format!("expectations of the ladder missed: {missed}"))) }
}

/// All combinations; the rows of the table in their order are these at one resolution after the other.
fn variants<'a>(job: &Job, ladder: &'a Ladder) -> Vec<Variant<'a>> {
    fn or<T: Clone>(list: &[T], own: T) -> Vec<T> {
        if list.is_empty() { vec![own] } else { list.to_vec() }
    }
    let shell = &job.scene.shell;
    let mut variants = Vec::new();
    let integrators = ladder.integrators.iter().map(|integrator| (Some(*integrator), None));
    let ways: Vec<_> = or(&integrators.chain(ladder.methods.iter().map(|method| (None, Some(*method)))).collect::<Vec<_>>(), (None, None));
    let elements = or(&ladder.elements, shell.element);
    let directors = or(&ladder.directors, shell.director);
    let pairs = elements.iter().flat_map(|e| directors.iter().map(move |d| (*e, *d)));
    for (element, director) in pairs.filter(|(e, d)| (*e, *d) != (Element::Quadratic, Director::Average)) {
        for mesh in or(&ladder.meshes.iter().map(Some).collect::<Vec<_>>(), None) {
            for sampling in or(&ladder.samplings.iter().copied().map(Some).collect::<Vec<_>>(), None) {
                for thickness in or(&ladder.thicknesses, shell.thickness) {
                    for (integrator, method) in &ways {
                        variants.push(Variant { element, director, mesh, sampling, thickness, integrator: *integrator, method: *method });
                    }
                }
            }
        }
    }
    variants
}

impl Variant<'_> {
    fn expectations<'a>(&'a self, ladder: &'a Ladder) -> impl Iterator<Item = &'a LadderExpectation> {
        ladder.expectations.iter().filter(|e| self.is_meant_by(e))
    }

    /// Those of the ladder and what its expectations add to them, ascending.
    fn resolutions(&self, ladder: &Ladder) -> Vec<f64> {
        let further = self.expectations(ladder).flat_map(|e| &e.further);
        let mut all: Vec<f64> = ladder.resolutions.iter().chain(further).copied().collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    fn is_meant_by(&self, expected: &LadderExpectation) -> bool {
        expected.element.is_none_or(|element| element == self.element)
            && expected.director.is_none_or(|director| director == self.director)
            && expected.mesh.as_ref().is_none_or(|name| self.mesh.is_some_and(|mesh| mesh.name == *name))
            && expected.sampling.is_none_or(|sampling| Some(sampling) == self.sampling)
            && expected.thickness.is_none_or(|thickness| thickness == self.thickness)
            && expected.integrator.is_none_or(|integrator| Some(integrator) == self.integrator)
            && expected.method.is_none_or(|method| Some(method) == self.method)
    }
}

/// One run. `met`: what of the scene's own expectations it must meet.
fn run(job: &Job, ladder: &Ladder, variant: &Variant, resolution: f64, met: &[&Expectation]) -> Result<LadderRow> {
    let mut scene = job.scene.clone();
    (scene.shell.element, scene.shell.director, scene.shell.thickness) = (variant.element, variant.director, variant.thickness);
    if let Some(sampling) = variant.sampling {
        scene.rest.get_or_insert_with(Rest::default).sampling = sampling;
    }
    if let (Some(dynamics), Some(integrator)) = (&mut scene.dynamics, variant.integrator) {
        dynamics.integrator = integrator;
    }
    if let (Some(statics), Some(method)) = (&mut scene.statics, variant.method) {
        statics.method = method;
    }
    refine(&mut scene, ladder, variant.mesh, resolution);
    let step = scene.dynamics.as_ref().filter(|_| ladder.refinement == Refinement::Steps).map(|dynamics| dynamics.dt);
    let folder = tempfile::tempdir().map_err(|e| Error::io("create a folder in", &std::env::temp_dir(), e))?;
    let measures: Vec<_> = {
        let own = (&ladder.measure, Spot::new(None, ladder.limit_point, None));
        std::iter::once(own).chain(met.iter().map(|e| (&e.measure, Spot::from(*e)))).collect()
    };
    let trial = attempt(&Job { scene, case: folder.path().to_path_buf(), quiet: true, ..job.clone() }, &measures)?;
    let values = trial.values.as_ref().map_or(&[][..], |values| &values[1..]);
    let missed = met.iter().enumerate().filter_map(|(i, e)| {
        let value = values.get(i).copied().flatten();
        let text = value.map_or("unknown".to_owned(), |value| value.to_string());
        let passes = value.is_some_and(|value| (value - e.reference).abs() <= e.tolerance);
        (!passes).then(|| format!("{} {text}, expected {} +- {} ({})", e.name, e.reference, e.tolerance, e.source))
    });
    let missed = missed.collect();
    let (error, failure) = match trial.values {
        Ok(values) => match values.first().copied().flatten() {
            Some(value) => (Some((value - ladder.reference).abs()), None),
            None => (None, Some("the measure is not finite".to_owned())),
        },
        Err(stopped) => (None, Some(stopped.reason)),
    };
    Ok(LadderRow {
        director: match variant.element {
            Element::Linear => variant.director.name().to_owned(),
            Element::Quadratic => format!("quadratic {}", variant.director.name()),
        },
        mesh: variant.mesh.map_or_else(|| "own".to_owned(), |m| m.name.clone()),
        thickness: variant.thickness,
        sampling: variant.sampling.map(Sampling::name),
        method: variant.integrator.map(Integrator::name).or(variant.method.map(Method::name)),
        step,
        faces: trial.cost.faces,
        longest_edge: trial.longest_edge,
        dofs: trial.cost.dofs,
        error: error.filter(|e| e.is_finite()),
        wall_s: trial.cost.wall_s,
        factorizations: trial.cost.factorizations,
        failure,
        missed,
        ..LadderRow::default()
    })
}

/// Gives the scene its mesh in another variant, and the mesh or the steps a resolution.
fn refine(scene: &mut Scene, ladder: &Ladder, variant: Option<&LadderMesh>, resolution: f64) {
    let first = ladder.resolutions[0];
    match ladder.refinement {
        Refinement::Anew => vary_mesh(&mut scene.mesh, variant, resolution),
        Refinement::Split => {
            vary_mesh(&mut scene.mesh, variant, first);
            let times = (resolution / first).log2().round() as usize;
            if times > 0 {
                scene.refine.get_or_insert(Refine { times: 0 }).times += times;
            }
        }
        Refinement::Steps => {
            vary_mesh(&mut scene.mesh, variant, 1.0);
            scene.dynamics.iter_mut().for_each(|dynamics| dynamics.dt /= resolution);
        }
    }
}

/// The mesh in another variant, and finer by a factor; that of a file is what it is.
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
        // No shell has a grid.
        MeshTable::File(_) | MeshTable::Grid(_) => {}
    }
}

//! `report --ladder`: error against run time over resolutions, meshes, elements, directors, thicknesses and samplings.

use super::super::Job;
use super::case::attempt;
use crate::error::{Error, Result};
use crate::report::{LadderRow, ladder as table};
use crate::scene::{Director, Element, Ladder, LadderExpectation, LadderMesh, MeshTable, Rest, Sampling};
use std::path::Path;

/// What of the scene a ladder varies besides the resolution.
#[derive(Clone, Copy)]
struct Variant<'a> {
    element: Element,
    director: Director,
    mesh: Option<&'a LadderMesh>,
    sampling: Option<Sampling>,
    thickness: f64,
}

/// Runs the scene at every combination that its `[report.ladder]` lists, in folders of their own that do not stay, and tabulates error
/// against run time (`ladder.json`, `ladder.md` in the case, and `json`).
///
/// # Errors
/// A scene without a ladder, input errors of any combination, [`Error::Missed`] when an expectation of the ladder is. Numerical failures
/// become rows that say so.
pub fn ladder(job: &Job, json: Option<&Path>) -> Result<()> {
    let Some(ladder) = job.scene.report.as_ref().and_then(|r| r.ladder.clone()) else {
        return Err(Error::input("report.ladder", format!("{} has no such table", job.scene_file.display())));
    };
    let mut rows = Vec::new();
    for variant in variants(job, &ladder) {
        for resolution in &ladder.resolutions {
            let row = run(job, &ladder, &variant, *resolution)?;
            let error = row.error.map_or("none".to_owned(), |e| format!("{e:.3e}"));
            log::info!("{}, {} faces: error {error}", row.kind(), row.faces);
            rows.push(row);
        }
    }
    table::orders(&mut rows);
    // The finest run of a variant is its last.
    let finest = rows.chunks_exact_mut(ladder.resolutions.len().max(1)).filter_map(|rows| rows.last_mut());
    for (row, variant) in finest.zip(variants(job, &ladder)) {
        for expected in ladder.expectations.iter().filter(|e| variant.is_meant_by(e)) {
            row.expect(expected.least_order, expected.largest_error, &expected.source);
        }
    }
    super::publish(job, "ladder", &table::to_json(&rows), &table::to_markdown(&rows), json)?;
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
    let elements = or(&ladder.elements, shell.element);
    let directors = or(&ladder.directors, shell.director);
    let pairs = elements.iter().flat_map(|e| directors.iter().map(move |d| (*e, *d)));
    for (element, director) in pairs.filter(|(e, d)| (*e, *d) != (Element::Quadratic, Director::Average)) {
        for mesh in or(&ladder.meshes.iter().map(Some).collect::<Vec<_>>(), None) {
            for sampling in or(&ladder.samplings.iter().copied().map(Some).collect::<Vec<_>>(), None) {
                for thickness in or(&ladder.thicknesses, shell.thickness) {
                    variants.push(Variant { element, director, mesh, sampling, thickness });
                }
            }
        }
    }
    variants
}

impl Variant<'_> {
    fn is_meant_by(&self, expected: &LadderExpectation) -> bool {
        expected.element.is_none_or(|element| element == self.element)
            && expected.director.is_none_or(|director| director == self.director)
            && expected.mesh.as_ref().is_none_or(|name| self.mesh.is_some_and(|mesh| mesh.name == *name))
            && expected.sampling.is_none_or(|sampling| Some(sampling) == self.sampling)
            && expected.thickness.is_none_or(|thickness| thickness == self.thickness)
    }
}

fn run(job: &Job, ladder: &Ladder, variant: &Variant, resolution: f64) -> Result<LadderRow> {
    let mut scene = job.scene.clone();
    (scene.shell.element, scene.shell.director, scene.shell.thickness) = (variant.element, variant.director, variant.thickness);
    if let Some(sampling) = variant.sampling {
        scene.rest.get_or_insert_with(Rest::default).sampling = sampling;
    }
    vary_mesh(&mut scene.mesh, variant.mesh, resolution);
    let folder = tempfile::tempdir().map_err(|e| Error::io("create a folder in", &std::env::temp_dir(), e))?;
    let trial = attempt(&Job { scene, case: folder.path().to_path_buf(), quiet: true, ..job.clone() }, &[&ladder.measure])?;
    let (error, failure) = match trial.values {
        Ok(values) => match values.first().copied().flatten() {
            Some(value) => (Some((value - ladder.reference).abs()), None),
            None => (None, Some("the measure is not finite".to_owned())),
        },
        Err(reason) => (None, Some(reason)),
    };
    Ok(LadderRow {
        director: match variant.element {
            Element::Linear => variant.director.name().to_owned(),
            Element::Quadratic => format!("quadratic {}", variant.director.name()),
        },
        mesh: variant.mesh.map_or_else(|| "own".to_owned(), |m| m.name.clone()),
        thickness: variant.thickness,
        sampling: variant.sampling.map(Sampling::name),
        faces: trial.cost.faces,
        longest_edge: trial.longest_edge,
        dofs: trial.cost.dofs,
        error: error.filter(|e| e.is_finite()),
        wall_s: trial.cost.wall_s,
        factorizations: trial.cost.factorizations,
        failure,
        ..LadderRow::default()
    })
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

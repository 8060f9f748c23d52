//! Refuses measures that a scene cannot have, before it is run.

use super::super::fields;
use super::measure::{Image, energy_scale, members, rim, vertex_at};
use super::reactions;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::scene::{Measure, Scene};
use crate::snapshot::Association;

/// Finds places far outside, regions, fields and columns that do not exist, maps and scales without a value. `columns`: of the history.
///
/// # Errors
/// The measure's key and what there is instead.
pub fn check_measures(scene: &Scene, mesh: &Mesh, columns: &[&str]) -> Result<()> {
    let Some(report) = &scene.report else { return Ok(()) };
    for (i, expectation) in report.expectations.iter().enumerate() {
        check(&format!("report.expect.{i}.measure"), &expectation.measure, scene, mesh, columns)?;
        if let Some(passage) = &expectation.passage {
            check(&format!("report.expect.{i}.passage.measure"), &passage.measure, scene, mesh, columns)?;
        }
    }
    for (i, entry) in report.path.iter().flat_map(|path| &path.measures).enumerate() {
        check(&format!("report.path.measures.{i}.measure"), &entry.measure, scene, mesh, columns)?;
    }
    if let Some(ladder) = &report.ladder {
        check("report.ladder.measure", &ladder.measure, scene, mesh, columns)?;
    }
    for (i, sweep) in report.sweeps.iter().enumerate() {
        for (k, entry) in sweep.measures.iter().enumerate() {
            check(&format!("report.sweep.{i}.measures.{k}.measure"), &entry.measure, scene, mesh, columns)?;
            if let Some(passage) = &entry.passage {
                check(&format!("report.sweep.{i}.measures.{k}.passage.measure"), &passage.measure, scene, mesh, columns)?;
            }
        }
    }
    Ok(())
}

fn check(key: &str, measure: &Measure, scene: &Scene, mesh: &Mesh, columns: &[&str]) -> Result<()> {
    let vertex = |name: &str, at: &[f64; 3], region: Option<&str>| vertex_at(mesh, &format!("{key}{name}"), at, region).map(drop);
    match measure {
        Measure::Displacement { at, region, .. } => vertex(".displacement", at, region.as_deref()),
        Measure::DistanceBetween { a, b } => {
            vertex(".distance-between.a", a, None)?;
            vertex(".distance-between.b", b, None)
        }
        Measure::Reaction { region, .. } => reactions::nodes(mesh, &format!("{key}.reaction.region"), region).map(drop),
        Measure::ReactionMoment { region, .. } => reactions::nodes(mesh, &format!("{key}.reaction-moment.region"), region).map(drop),
        Measure::SurfaceDistance { position, kind, .. } => {
            Image::new(&format!("{key}.surface-distance.position"), position, mesh, *kind).map(drop)
        }
        Measure::OriginalDistance { kind, .. } => Image::original(&format!("{key}.original-distance"), mesh, *kind).map(drop),
        Measure::Waves { region } => rim(mesh, &format!("{key}.waves.region"), region).map(drop),
        Measure::WaveAmplitude { region } => rim(mesh, &format!("{key}.wave-amplitude.region"), region).map(drop),
        Measure::Energy { over, .. } => energy_scale(&format!("{key}.energy.over"), over.as_ref(), scene).map(drop),
        Measure::Field { name, component, region, .. } => {
            let (known, name) = (fields::names(scene), name.replace('-', "_"));
            let Some((_, components)) = known.iter().find(|(n, _)| *n == name) else {
                let known: Vec<&str> = known.iter().map(|(n, _)| *n).collect();
                return Err(Error::input_with_help(key, format!("there is no field '{name}'"), format!("there are: {}", known.join(", "))));
            };
            if component >= components {
                return Err(Error::input(
                    key,
                    format!("field '{name}' has {components} components; {component} is not among them (they count from 0)"),
                ));
            }
            let Some(region) = region else { return Ok(()) };
            let of_faces = scene.cosserat.is_none() && fields::of_faces(&name);
            let association = if of_faces { Association::Face } else { Association::Node };
            members(mesh, &format!("{key}.field.region"), region, association).map(drop)
        }
        Measure::History { column } | Measure::TimeWithin { column, .. } if column != "step" && !columns.contains(&column.as_str()) => {
            Err(Error::input_with_help(key, format!("the history has no column '{column}'"), format!("it has: {}", columns.join(", "))))
        }
        _ => Ok(()),
    }
}

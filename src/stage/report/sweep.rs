//! `report --sweep`: runs a scene over values of its keys, tabulates measures, fits laws.

use super::super::{Job, mesh as mesh_stage, setup};
use super::case::{Case, attempt};
use super::path::Spot;
use crate::error::{Error, Result};
use crate::report::shapes::{SHAPE_DISTANCES, Shape, shape_distances};
use crate::report::{Sweep, SweepFit, SweepLargest, SweepRow, number, sweep as table};
use crate::scene::{self, SweepMeasure, SweepValue};
use serde_json::Value;
use std::path::Path;

/// Runs the scene at every value, or pair of values, that its `[[report.sweep]]` list, in folders of their own that do not stay, and
/// tabulates what was measured (`sweep.json`, `sweep.md` in the case, and `json`).
///
/// # Errors
/// A scene without a sweep, a value with which the scene is none, before anything runs; [`Error::Missed`] when a limit or an exponent is.
/// Numerical failures become rows that say so; where all are, an error.
pub fn sweep(job: &Job, json: Option<&Path>) -> Result<()> {
    let sweeps = job.scene.report.as_ref().map_or(&[][..], |r| &r.sweeps);
    if sweeps.is_empty() {
        return Err(Error::input("report.sweep", format!("{} has no such table", job.scene_file.display())));
    }
    let planned = sweeps.iter().enumerate().map(|(i, sweep)| plan(job, i, sweep)).collect::<Result<Vec<_>>>()?;
    let mut results = Vec::new();
    for (sweep, runs) in sweeps.iter().zip(planned) {
        let mut rows = Vec::new();
        let mut shapes = Vec::new();
        for run in runs {
            let (row, shape) = row(job, sweep, run)?;
            rows.push(row);
            shapes.push(shape);
        }
        let mut measures: Vec<String> = sweep.measures.iter().map(|m| m.name.clone()).collect();
        let mut limits: Vec<[Option<f64>; 2]> = sweep.measures.iter().map(|m| [m.least, m.most]).collect();
        if sweep.shapes.is_some() {
            let second = sweep.second.as_ref().map_or(1, |second| second.list().len());
            for (row, distances) in rows.iter_mut().zip(shape_distances(&shapes, second)) {
                row.measures.extend(distances);
            }
            measures.extend(SHAPE_DISTANCES.map(String::from));
            limits.extend([[None; 2]; 2]);
        }
        if limits.as_flattened().iter().all(Option::is_none) {
            limits.clear();
        }
        let fits = fits(sweep, &rows);
        let largest = sweep.largest.as_ref().map(|entry| {
            let place = sweep.measures.iter().position(|m| m.name == entry.measure).unwrap_or(0);
            SweepLargest::new(&entry.measure, place, entry.least, &rows)
        });
        let keys = [Some(&sweep.key), sweep.second.as_ref().map(|s| &s.key)].into_iter().flatten().cloned().collect();
        results.push(Sweep { name: sweep.name.clone(), keys, measures, limits, rows, fits, largest });
    }
    let tables: Vec<String> = results.iter().map(Sweep::to_markdown).collect();
    super::publish(job, "sweep", &table::to_json(&job.name(), &results), &tables.join("\n"), json)?;
    super::fail_if_all(results.iter().flat_map(|s| &s.rows).map(SweepRow::has_failed), "sweep")?;
    let missed: Vec<&str> = results.iter().filter(|s| !s.passed()).map(|s| s.name.as_str()).collect();
    if missed.is_empty() { Ok(()) } else { Err(Error::Missed(format!("expectations of sweeps missed: {}", missed.join(", ")))) }
}

/// One run of a sweep: its values and the scene with them.
struct Run {
    values: Vec<SweepValue>,
    /// Key of its value in the scene, for errors.
    place: String,
    scene: scene::Scene,
    source: scene::Source,
}

/// Makes sure that the scene is one with every value of its sweeps. Makes no mesh.
///
/// # Errors
/// The sweep's key where the scene cannot have that, else the value with which the scene is none.
pub fn check_sweeps(job: &Job) -> Result<()> {
    let sweeps = job.scene.report.as_ref().map_or(&[][..], |r| &r.sweeps);
    sweeps.iter().enumerate().try_for_each(|(i, sweep)| runs(job, i, sweep).map(drop))
}

/// All runs of a sweep, each a scene.
fn runs(job: &Job, number: usize, sweep: &scene::Sweep) -> Result<Vec<Run>> {
    let second = sweep.second.as_ref().map(|s| (s.key.as_str(), s.list()));
    let key = format!("report.sweep.{number}");
    let of_value = |i: usize| if sweep.logarithmic.is_some() { format!("{key}.logarithmic") } else { format!("{key}.values.{i}") };
    // Times at which the scene expects something need not be there in a run, which is not asked for it.
    let expectations = job.scene.report.iter().flat_map(|report| &report.expectations).enumerate();
    let timed = expectations.filter(|(_, e)| e.time.is_some()).map(|(i, _)| format!("report.expect.{i}.time=0"));
    let silent: Vec<String> = timed.chain(["report.sweep=[]".to_owned()]).collect();
    let mut runs = Vec::new();
    for (i, value) in sweep.list().iter().enumerate() {
        let others: Vec<Option<&SweepValue>> = second.as_ref().map_or(vec![None], |(_, list)| list.iter().map(Some).collect());
        for other in others {
            // What is changed, with the keys of name and value in this scene.
            let mut changes: Vec<(String, [String; 2])> = Vec::new();
            for (k, change) in sweep.set.iter().enumerate() {
                changes.push((change.clone(), [(); 2].map(|()| format!("{key}.set.{k}"))));
            }
            changes.push((format!("{}={}", sweep.key, value.text()), [format!("{key}.key"), of_value(i)]));
            for (k, tied) in sweep.with.iter().enumerate() {
                let at = format!("{key}.with.{k}");
                changes.push((format!("{}={}", tied.key, tied.values[i].text()), [format!("{at}.key"), format!("{at}.values.{i}")]));
            }
            if let Some((second, value)) = second.as_ref().map(|(key, _)| key).zip(other) {
                changes.push((format!("{second}={}", value.text()), [format!("{key}.second.key"), format!("{key}.second")]));
            }
            let overrides: Vec<String> = changes.iter().map(|(change, _)| change).chain(&silent).cloned().collect();
            let made = scene::parse(&job.scene_file.display().to_string(), job.source.text(), &overrides);
            let (scene, source) = made.map_err(|e| match e {
                Error::Scene(fault) => {
                    // A fault at the start of an override is one of its key.
                    let at_key = fault.text.name() == "--set" && fault.span.is_some_and(|span| span.offset() == 0);
                    let change = changes.iter().find(|(change, _)| fault.text.name() == "--set" && change == fault.text.inner());
                    let place = change.map_or(of_value(i), |(_, [name, value])| if at_key { name.clone() } else { value.clone() });
                    Error::Input { place, message: fault.message.replace(" (from --set)", ""), help: fault.help }
                }
                other => other,
            })?;
            let end = scene.end() * (1.0 + 1e-9);
            let times = sweep.measures.iter().enumerate().map(|(m, entry)| (format!("measures.{m}"), entry.time));
            let times = times.chain(sweep.shapes.map(|shapes| ("shapes".to_owned(), shapes.time)));
            if let Some((at, time)) = times.into_iter().find_map(|(at, time)| Some((at, time.filter(|t| *t > end)?))) {
                let message = format!("is after the end of the run at {} (seconds, in statics the load factor)", scene.end());
                let change = format!("{}={}", sweep.key, value.text());
                return Err(Error::input(format!("{key}.{at}.time"), format!("{time} with {change}: {message}")));
            }
            let values = [Some(value), other].into_iter().flatten().cloned().collect();
            runs.push(Run { values, place: of_value(i), scene, source });
        }
    }
    Ok(runs)
}

/// All runs of a sweep, each checked as `check` does.
fn plan(job: &Job, number: usize, sweep: &scene::Sweep) -> Result<Vec<Run>> {
    let runs = runs(job, number, sweep)?;
    for run in &runs {
        let made = mesh_stage::make(&run.scene, &job.scene_file).and_then(|(mesh, _)| setup::make(&run.scene, &mesh));
        made.map_err(|e| match e {
            Error::Input { place, message, help } => {
                let values: Vec<String> = run.values.iter().map(SweepValue::text).collect();
                Error::Input { place: run.place.clone(), message: format!("with {}, {place}: {message}", values.join(", ")), help }
            }
            other => other,
        })?;
    }
    Ok(runs)
}

/// One run as a row, and its shape where that is asked for and there is one.
fn row(job: &Job, sweep: &scene::Sweep, run: Run) -> Result<(SweepRow, Option<Shape>)> {
    let folder = tempfile::tempdir().map_err(|e| Error::io("create a folder in", &std::env::temp_dir(), e))?;
    let step = Job { scene: run.scene, source: run.source, case: folder.path().to_path_buf(), quiet: true, ..job.clone() };
    let measures: Vec<_> = sweep.measures.iter().map(|m| (&m.measure, Spot::new(m.time, m.limit_point, m.passage.as_ref()))).collect();
    let trial = attempt(&step, &measures)?;
    let cost = trial.cost;
    let (measured, failure) = match trial.values {
        Ok(values) => (values, None),
        Err(stopped) => {
            let at_end = |m: &&SweepMeasure| m.time.is_none() && m.limit_point.is_none() && m.passage.is_none();
            let measured = |m: &SweepMeasure| Some(m).filter(at_end).and_then(|m| stopped.measure(&m.measure));
            (sweep.measures.iter().map(measured).collect(), Some(stopped.reason))
        }
    };
    let shape = match &sweep.shapes {
        Some(shapes) if failure.is_none() => {
            let case = Case::load(&step)?;
            Some(Shape { places: case.mesh.nodes(), positions: case.positions(shapes.time.into())? })
        }
        _ => None,
    };
    let values: Vec<Value> = run.values.iter().map(json).collect();
    let place: Vec<String> = values.iter().map(table::word).collect();
    let limited = sweep.measures.iter().zip(&measured);
    let missed = limited.filter_map(|(m, value)| limit(m, *value)).map(|m| format!("{}: {m}", place.join(", "))).collect();
    let shown: Vec<String> = sweep
        .measures
        .iter()
        .zip(&measured)
        .map(|(m, v)| format!("{} {}", m.name, v.map_or("none".into(), |v| format!("{v:.6e}"))))
        .collect();
    log::info!("{} at {}: {}", sweep.name, place.join(", "), failure.clone().unwrap_or_else(|| shown.join(", ")));
    let row = SweepRow {
        values,
        measures: measured,
        faces: cost.faces,
        dofs: cost.dofs,
        wall_s: cost.wall_s,
        newton_iterations: cost.newton_iterations,
        factorizations: cost.factorizations,
        failure,
        missed,
    };
    Ok((row, shape))
}

/// What a value misses, in words. Where there is no value, every limit is missed.
pub(super) fn limit(measure: &SweepMeasure, value: Option<f64>) -> Option<String> {
    let (name, source) = (&measure.name, measure.source.as_deref()?);
    let Some(value) = value else { return Some(format!("{name} has no value ({source})")) };
    match (measure.least, measure.most) {
        (Some(least), _) if value < least => Some(format!("{name} {} is less than {} ({source})", number(value), number(least))),
        (_, Some(most)) if value > most => Some(format!("{name} {} is more than {} ({source})", number(value), number(most))),
        _ => None,
    }
}

/// A value of a key as JSON.
pub(super) fn json(value: &SweepValue) -> Value {
    match value {
        SweepValue::Whole(value) => Value::from(*value),
        SweepValue::Number(value) => Value::from(*value),
        SweepValue::Truth(value) => Value::from(*value),
        SweepValue::Text(text) => Value::from(text.as_str()),
    }
}

/// The fitted law, for each value of the second key or through the runs that are chosen among them.
fn fits(sweep: &scene::Sweep, rows: &[SweepRow]) -> Vec<SweepFit> {
    let Some(fit) = &sweep.fit else { return Vec::new() };
    let scene::FitKind::Power = fit.kind;
    let place_of = |name: &str| sweep.measures.iter().position(|m| m.name == name).unwrap_or(0);
    let place = place_of(&fit.measure);
    let expected = fit.expect.as_ref().map(|e| (e.exponent, e.tolerance, e.source.as_str()));
    let law = |rows: &[&SweepRow], at| SweepFit::new(&fit.measure, place, rows, at, expected);
    if let Some(name) = &fit.lowest {
        let chosen = table::lowest(rows, place_of(name));
        return vec![law(&chosen, Some(Value::from(format!("lowest {name}"))))];
    }
    let mut seconds: Vec<Option<&Value>> = Vec::new();
    for row in rows {
        if !seconds.contains(&row.values.get(1)) {
            seconds.push(row.values.get(1));
        }
    }
    let of = |second: &Option<&Value>| {
        let rows: Vec<&SweepRow> = rows.iter().filter(|row| row.values.get(1) == *second).collect();
        law(&rows, second.cloned())
    };
    seconds.iter().map(of).collect()
}

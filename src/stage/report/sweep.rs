//! `report --sweep`: runs a scene over values of its keys, tabulates measures, fits laws.

use super::super::{Job, mesh as mesh_stage, setup};
use super::case::attempt;
use super::path::Spot;
use crate::error::{Error, Result};
use crate::report::{Sweep, SweepFit, SweepRow, number, sweep as table};
use crate::scene::{self, Logarithmic, SweepMeasure, SweepValue};
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
        for run in runs {
            rows.push(row(job, sweep, run)?);
        }
        let fits = fits(sweep, &rows);
        let keys = [Some(&sweep.key), sweep.second.as_ref().map(|s| &s.key)].into_iter().flatten().cloned().collect();
        let measures = sweep.measures.iter().map(|m| m.name.clone()).collect();
        let mut limits: Vec<[Option<f64>; 2]> = sweep.measures.iter().map(|m| [m.least, m.most]).collect();
        if limits.as_flattened().iter().all(Option::is_none) {
            limits.clear();
        }
        results.push(Sweep { name: sweep.name.clone(), keys, measures, limits, rows, fits });
    }
    let tables: Vec<String> = results.iter().map(Sweep::to_markdown).collect();
    super::publish(job, "sweep", &table::to_json(&job.name(), &results), &tables.join("\n"), json)?;
    super::fail_if_all(results.iter().flat_map(|s| &s.rows).map(|row| row.failure.is_some()), "sweep")?;
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
    let list = |values: &[SweepValue], logarithmic: &Option<Logarithmic>| logarithmic.map_or(values.to_vec(), |table| table.values());
    let first = list(&sweep.values, &sweep.logarithmic);
    let second = sweep.second.as_ref().map(|s| (s.key.as_str(), list(&s.values, &s.logarithmic)));
    let key = format!("report.sweep.{number}");
    let of_value = |i: usize| if sweep.logarithmic.is_some() { format!("{key}.logarithmic") } else { format!("{key}.values.{i}") };
    let mut runs = Vec::new();
    for (i, value) in first.iter().enumerate() {
        let pairs: Vec<Vec<(&str, &SweepValue)>> = match &second {
            Some((key, others)) => others.iter().map(|other| vec![(sweep.key.as_str(), value), (*key, other)]).collect(),
            None => vec![vec![(sweep.key.as_str(), value)]],
        };
        for pair in pairs {
            // Times at which the scene expects something need not be there in a run, which is not asked for it.
            let expectations = job.scene.report.iter().flat_map(|report| &report.expectations).enumerate();
            let timed = expectations.filter(|(_, e)| e.time.is_some()).map(|(i, _)| format!("report.expect.{i}.time=0"));
            let silent = timed.chain(["report.sweep=[]".to_owned()]);
            let overrides: Vec<String> = pair.iter().map(|(key, value)| format!("{key}={}", value.text())).chain(silent).collect();
            let made = scene::parse(&job.scene_file.display().to_string(), job.source.text(), &overrides);
            let (scene, source) = made.map_err(|e| match e {
                Error::Scene(fault) => {
                    // A fault at the start of an override is one of its key.
                    let at_key = fault.text.name() == "--set" && fault.span.is_some_and(|span| span.offset() == 0);
                    let of_second = overrides.get(1) == Some(fault.text.inner());
                    let place = match (at_key, of_second) {
                        (true, true) => format!("{key}.second.key"),
                        (true, false) => format!("{key}.key"),
                        (false, true) => format!("{key}.second"),
                        (false, false) => of_value(i),
                    };
                    Error::Input { place, message: fault.message.replace(" (from --set)", ""), help: fault.help }
                }
                other => other,
            })?;
            let end = scene.end() * (1.0 + 1e-9);
            if let Some((m, time)) = sweep.measures.iter().enumerate().find_map(|(m, entry)| Some((m, entry.time.filter(|t| *t > end)?))) {
                let message = format!("is after the end of the run at {} (seconds, in statics the load factor)", scene.end());
                return Err(Error::input(format!("{key}.measures.{m}.time"), format!("{time} with {}: {message}", overrides[0])));
            }
            let values = pair.into_iter().map(|(_, value)| value.clone()).collect();
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

fn row(job: &Job, sweep: &scene::Sweep, run: Run) -> Result<SweepRow> {
    let folder = tempfile::tempdir().map_err(|e| Error::io("create a folder in", &std::env::temp_dir(), e))?;
    let step = Job { scene: run.scene, source: run.source, case: folder.path().to_path_buf(), quiet: true, ..job.clone() };
    let measures: Vec<_> = sweep.measures.iter().map(|m| (&m.measure, Spot::new(m.time, m.limit_point, m.passage.as_ref()))).collect();
    let trial = attempt(&step, &measures)?;
    let cost = trial.cost;
    let (measured, failure) = match trial.values {
        Ok(values) => (values, None),
        Err(reason) => (vec![None; measures.len()], Some(reason)),
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
    Ok(SweepRow {
        values,
        measures: measured,
        faces: cost.faces,
        dofs: cost.dofs,
        wall_s: cost.wall_s,
        newton_iterations: cost.newton_iterations,
        factorizations: cost.factorizations,
        failure,
        missed,
    })
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

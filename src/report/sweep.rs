//! What a scene's result does when one or two of its keys are varied: `sweep.json` and its tables.

use super::{cell, norm, number, table};
use serde::Serialize;
use serde_json::Value;

/// One run of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SweepRow {
    /// Values of the keys.
    pub values: Vec<Value>,
    /// What was measured, in the measures' units; none where the run stopped before or the measure is not finite.
    pub measures: Vec<Option<f64>>,
    /// Number of faces.
    pub faces: usize,
    /// Number of unknowns.
    pub dofs: usize,
    /// Run time [s].
    pub wall_s: f64,
    /// Newton iterations.
    pub newton_iterations: u64,
    /// Numeric factorisations.
    pub factorizations: u64,
    /// Why the run stopped before its end; it has failed where there is no measure up to there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Limits that were missed, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missed: Vec<String>,
}

/// A power law of a measure in the first key, for one value of the second key if there is one.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SweepFit {
    /// Name of the measure.
    pub measure: String,
    /// Value of the second key, or how its rows were chosen among those.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<Value>,
    /// Exponent; none where there is no law, because too few rows have a value or one is not positive.
    pub exponent: Option<f64>,
    /// Value of the measure at 1.
    pub prefactor: Option<f64>,
    /// See [`norm::PowerLaw::misfit`].
    pub misfit: Option<f64>,
    /// Rows that have a value, and all rows.
    pub points: [usize; 2],
    /// What the exponent should be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<SweepExpectation>,
}

/// What was expected of an exponent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepExpectation {
    /// Exponent.
    pub exponent: f64,
    /// Largest distance from it that passes.
    pub tolerance: f64,
    /// Where it comes from.
    pub source: String,
    /// Whether it is met by a law through all rows.
    pub passed: bool,
}

/// For each value of the first key the largest value of the second with which, and with all smaller ones, a measure is large enough.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SweepLargest {
    /// Name of the measure.
    pub measure: String,
    /// Its smallest value that suffices.
    pub least: f64,
    /// Value of the first key; the value of the second, none where the smallest does not suffice; and the next larger one, none where all suffice.
    pub rows: Vec<(Value, Option<f64>, Option<f64>)>,
}

/// One sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sweep {
    /// Name.
    pub name: String,
    /// The one or two keys.
    pub keys: Vec<String>,
    /// Names of the measures.
    pub measures: Vec<String>,
    /// Smallest and largest value of each measure that passes; empty where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<[Option<f64>; 2]>,
    /// One row a run; the second key changes fastest.
    pub rows: Vec<SweepRow>,
    /// Fitted laws.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fits: Vec<SweepFit>,
    /// Up to where a measure suffices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<SweepLargest>,
}

impl SweepRow {
    /// Whether the run failed and has nothing to tell.
    pub fn has_failed(&self) -> bool {
        self.failure.is_some() && self.measures.iter().all(Option::is_none)
    }
}

impl SweepLargest {
    /// That of a measure, by its place among the measures, over all rows of a sweep of two keys, the second of numbers.
    pub fn new(measure: &str, place: usize, least: f64, rows: &[SweepRow]) -> Self {
        let mut firsts: Vec<&Value> = Vec::new();
        for first in rows.iter().filter_map(|row| row.values.first()) {
            if !firsts.contains(&first) {
                firsts.push(first);
            }
        }
        let of = |first: &Value| {
            let of_first = rows.iter().filter(|row| row.values.first() == Some(first));
            let passes = |row: &SweepRow| row.measures.get(place).copied().flatten().is_some_and(|value| value >= least);
            let mut tried: Vec<(f64, bool)> = of_first.filter_map(|row| Some((row.values.get(1)?.as_f64()?, passes(row)))).collect();
            tried.sort_by(|a, b| a.0.total_cmp(&b.0));
            let count = tried.iter().take_while(|(_, passes)| *passes).count();
            (first.clone(), count.checked_sub(1).map(|i| tried[i].0), tried.get(count).map(|(value, _)| *value))
        };
        SweepLargest { measure: measure.to_owned(), least, rows: firsts.into_iter().map(of).collect() }
    }
}

impl SweepFit {
    /// The law of a measure, by its place among the measures, in the first key over `rows`, whose first values must be numbers.
    /// `at`: what the rows have in common. `expected`: exponent, tolerance, source.
    pub fn new(measure: &str, place: usize, rows: &[&SweepRow], at: Option<Value>, expected: Option<(f64, f64, &str)>) -> Self {
        let point = |row: &&SweepRow| Some((row.values.first()?.as_f64()?, (*row.measures.get(place)?)?));
        let pairs: Vec<(f64, f64)> = rows.iter().filter_map(point).collect();
        let law = norm::power_law(&pairs);
        let whole = pairs.len() == rows.len();
        let expected = expected.map(|(exponent, tolerance, source)| {
            let passed = whole && law.is_some_and(|law| (law.exponent - exponent).abs() <= tolerance);
            SweepExpectation { exponent, tolerance, source: source.to_owned(), passed }
        });
        SweepFit {
            measure: measure.to_owned(),
            at,
            exponent: law.map(|l| l.exponent),
            prefactor: law.map(|l| l.prefactor),
            misfit: law.map(|l| l.misfit),
            points: [pairs.len(), rows.len()],
            expected,
        }
    }
}

/// For each value of the first key the row with the lowest value of a measure, by its place among the measures; where none of the rows has a
/// value, the first of them.
pub fn lowest(rows: &[SweepRow], place: usize) -> Vec<&SweepRow> {
    let value = |row: &SweepRow| row.measures.get(place).copied().flatten().unwrap_or(f64::INFINITY);
    let mut chosen: Vec<&SweepRow> = Vec::new();
    for row in rows {
        match chosen.iter_mut().find(|other| other.values.first() == row.values.first()) {
            Some(other) if value(row) < value(other) => *other = row,
            Some(_) => {}
            None => chosen.push(row),
        }
    }
    chosen
}

impl Sweep {
    /// Whether all limits and all expected exponents are met.
    pub fn passed(&self) -> bool {
        let law = |fit: &SweepFit| fit.expected.as_ref().is_none_or(|e| e.passed);
        self.rows.iter().all(|row| row.missed.is_empty()) && self.fits.iter().all(law)
    }

    /// The tables as Markdown: rows, then laws, then up to where a measure suffices, then why runs stopped, then limits that were missed.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("# {}\n\n", cell(&self.name));
        let names = self.keys.iter().chain(&self.measures).map(String::as_str);
        let header: Vec<&str> = names.chain(["faces", "unknowns", "run time [s]", "Newton iterations", "factorisations"]).collect();
        let row = |r: &SweepRow| -> Vec<String> {
            let values = r.values.iter().map(word);
            let measures = r.measures.iter().enumerate().map(|(i, m)| match (&r.failure, i) {
                (Some(failure), 0) if r.has_failed() => format!("failed: {}", cell(failure)),
                _ => optional(*m),
            });
            let counts = [r.faces.to_string(), r.dofs.to_string(), format!("{:.2}", r.wall_s)];
            let counts = counts.into_iter().chain([r.newton_iterations.to_string(), r.factorizations.to_string()]);
            values.chain(measures).chain(counts).collect()
        };
        text += &table(&header, 0, &self.rows.iter().map(row).collect::<Vec<_>>());
        if !self.fits.is_empty() {
            text += &format!("\nPower laws in {}:\n\n", cell(&self.keys[0]));
            let law = |f: &SweepFit| -> Vec<String> {
                let at = f.at.as_ref().map(word);
                let (expected, passed, source) = match &f.expected {
                    Some(e) => (format!("{} +- {}", number(e.exponent), number(e.tolerance)), verdict(e.passed), cell(&e.source)),
                    None => Default::default(),
                };
                let points = format!("{} of {}", f.points[0], f.points[1]);
                let numbers = [f.exponent, f.prefactor, f.misfit].map(optional);
                [cell(&f.measure)].into_iter().chain(at).chain([source, passed, expected]).chain(numbers).chain([points]).collect()
            };
            let second = self.keys.get(1).map(String::as_str);
            let header = ["measure"].into_iter().chain(second);
            let header: Vec<&str> =
                header.chain(["source", "passed", "expected", "exponent", "prefactor", "largest misfit", "rows"]).collect();
            text += &table(&header, header.len() - 5, &self.fits.iter().map(law).collect::<Vec<_>>());
        }
        if let Some(largest) = &self.largest {
            let second = self.keys.get(1).map_or("", String::as_str);
            text += &format!("\nLargest {second} up to which {} is at least {}:\n\n", cell(&largest.measure), number(largest.least));
            let line = |(first, value, next): &(Value, Option<f64>, Option<f64>)| vec![word(first), optional(*value), optional(*next)];
            let rows: Vec<Vec<String>> = largest.rows.iter().map(line).collect();
            text += &table(&[&self.keys[0], &format!("largest {second}"), "next larger tried"], 0, &rows);
        }
        let stopped: Vec<&SweepRow> = self.rows.iter().filter(|row| row.failure.is_some() && !row.has_failed()).collect();
        if !stopped.is_empty() {
            text += "\nRuns that stopped before their end:\n\n";
        }
        for row in stopped {
            let place: Vec<String> = row.values.iter().map(word).collect();
            text += &format!("- {}: {}\n", place.join(", "), row.failure.as_deref().unwrap_or_default());
        }
        let missed: Vec<&String> = self.rows.iter().flat_map(|row| &row.missed).collect();
        if !missed.is_empty() {
            text += "\nMissed limits:\n\n";
            missed.iter().for_each(|limit| text += &format!("- {limit}\n"));
        }
        text
    }
}

/// Contents of `sweep.json`.
pub fn to_json(scene: &str, sweeps: &[Sweep]) -> String {
    let passed = sweeps.iter().all(Sweep::passed);
    super::outcome::json(&serde_json::json!({ "scene": scene, "passed": passed, "sweeps": sweeps }))
}

/// The value of a key in words.
pub fn word(value: &Value) -> String {
    match (value, value.as_f64()) {
        (Value::String(text), _) => cell(text),
        (Value::Number(n), Some(x)) if n.is_f64() => number(x),
        (other, _) => other.to_string(),
    }
}

fn optional(value: Option<f64>) -> String {
    value.map_or("-".into(), number)
}

fn verdict(passed: bool) -> String {
    if passed { "yes" } else { "**no**" }.into()
}

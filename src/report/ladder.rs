//! Error against run time over several resolutions: `ladder.json` and its table.

use super::{cell, norm, number, table};
use serde::Serialize;

/// One run of a ladder.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LadderRow {
    /// Director of the element.
    pub director: String,
    /// Name of the mesh variant.
    pub mesh: String,
    /// Thickness [m].
    pub thickness: f64,
    /// How the rest metric was sampled, where the ladder varies that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<&'static str>,
    /// Integrator, or way to the equilibrium, where the ladder varies that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<&'static str>,
    /// Step of time [s], by which orders are measured where the ladder varies that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Number of faces.
    pub faces: usize,
    /// Longest edge of the mesh [m], by which orders are measured otherwise.
    pub longest_edge: f64,
    /// Number of unknowns.
    pub dofs: usize,
    /// Distance of what was measured from its exact value; none for a run that failed.
    pub error: Option<f64>,
    /// Observed order against the next coarser run of the same kind; see [`orders`].
    pub order: Option<f64>,
    /// Order fitted to this run and all coarser ones of the same kind; see [`orders`].
    pub fitted_order: Option<f64>,
    /// Run time [s].
    pub wall_s: f64,
    /// The same in operations [1e9] that the machine would have done meanwhile in products of dense matrices; see [`super::DenseProduct`].
    pub gflop: f64,
    /// Numeric factorisations.
    pub factorizations: u64,
    /// Why the run failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Expectations of its kind that were missed, in words; at the finest run of the kind only.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missed: Vec<String>,
}

impl LadderRow {
    fn is_of_the_kind_of(&self, other: &LadderRow) -> bool {
        let thickness = self.thickness.to_bits() == other.thickness.to_bits();
        self.director == other.director
            && self.mesh == other.mesh
            && thickness
            && (self.sampling, self.method) == (other.sampling, other.method)
    }

    /// The kind in words.
    pub fn kind(&self) -> String {
        let sampling = self.sampling.map_or(String::new(), |sampling| format!(", rest metric by {sampling}"));
        let method = self.method.map_or(String::new(), |method| format!(", {method}"));
        let step = self.step.map_or(String::new(), |step| format!(", steps of {} s", number(step)));
        format!("{}, {}, {} m{sampling}{method}{step}", self.director, self.mesh, number(self.thickness))
    }

    /// Notes what the row misses of a least order and a largest error. What is not known is missed. `order`: which of its orders counts.
    pub fn expect(&mut self, order: Option<f64>, least_order: Option<f64>, largest_error: Option<f64>, source: &str) {
        let mut check = |what: &str, value: Option<f64>, bound: Option<f64>, meets: fn(f64, f64) -> bool| {
            let Some(bound) = bound else { return };
            if !value.is_some_and(|value| meets(value, bound)) {
                let value = value.map_or("unknown".to_owned(), number);
                self.missed.push(format!("{what} {value}, expected {} ({source})", number(bound)));
            }
        };
        check("order", order, least_order, |value, bound| value >= bound);
        check("error", self.error, largest_error, |value, bound| value <= bound);
    }
}

/// Sets the order of each row from the row before it of the same director, mesh, thickness, sampling and method, by the step or the longest edge.
///
/// A first row has none, nor has one after a run that failed. The fitted order is the slope of the best line through the logarithms of all of
/// them so far: a largest error over unstructured meshes, which are not similar to each other, goes down by uneven steps.
pub fn orders(rows: &mut [LadderRow]) {
    let point = |row: &LadderRow| Some((row.step.unwrap_or(row.longest_edge), row.error?));
    for i in 0..rows.len() {
        let (before, rest) = rows.split_at_mut(i);
        let row = &mut rest[0];
        let coarser = before.iter().rev().find(|b| b.is_of_the_kind_of(row));
        row.order = coarser.and_then(point).zip(point(row)).and_then(|(coarse, fine)| norm::observed_order(coarse, fine));
        let kind = before.iter().filter(|b| b.is_of_the_kind_of(row)).filter_map(point);
        row.fitted_order = norm::power_law(&kind.chain(point(row)).collect::<Vec<_>>()).map(|law| law.exponent);
    }
}

/// Contents of `ladder.json`: one object per row. A row that failed has `error` null and a key `failure`.
pub fn to_json(rows: &[LadderRow]) -> String {
    super::outcome::json(&rows)
}

/// The table for programs that read no JSON: one line per run, empty where there is no number. Names are those of the JSON.
pub fn to_csv(rows: &[LadderRow]) -> String {
    let header = [
        "director",
        "mesh",
        "thickness",
        "sampling",
        "method",
        "step",
        "faces",
        "longest_edge",
        "dofs",
        "error",
        "order",
        "fitted_order",
        "wall_s",
        "gflop",
        "factorizations",
        "failure",
    ];
    let optional = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    let mut text = csv::Writer::from_writer(Vec::new());
    let lines = rows.iter().map(|r| {
        [
            r.director.clone(),
            r.mesh.clone(),
            r.thickness.to_string(),
            r.sampling.unwrap_or_default().to_owned(),
            r.method.unwrap_or_default().to_owned(),
            optional(r.step),
            r.faces.to_string(),
            r.longest_edge.to_string(),
            r.dofs.to_string(),
            optional(r.error),
            optional(r.order),
            optional(r.fitted_order),
            r.wall_s.to_string(),
            r.gflop.to_string(),
            r.factorizations.to_string(),
            r.failure.clone().unwrap_or_default(),
        ]
    });
    for line in std::iter::once(header.map(str::to_owned)).chain(lines) {
        // Memory takes all, and lines have the same number of cells.
        let _ = text.write_record(line);
    }
    String::from_utf8(text.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// The table as Markdown, and the expectations that were missed. Columns of samplings, methods and steps only where rows have them.
pub fn to_markdown(rows: &[LadderRow]) -> String {
    let optional = |value: Option<f64>| value.map_or("-".into(), number);
    // Two digits at least.
    let time = |t: f64| if t < 0.1 { format!("{t:.4}") } else { format!("{t:.2}") };
    let sampled = rows.iter().any(|r| r.sampling.is_some());
    let by_method = rows.iter().any(|r| r.method.is_some());
    let by_step = rows.iter().any(|r| r.step.is_some());
    let row = |r: &LadderRow| {
        let [order, fitted] = [r.order, r.fitted_order].map(|order| order.map_or("-".into(), |o| format!("{o:.2}")));
        let error = r.failure.as_ref().map_or_else(|| optional(r.error), |f| format!("failed: {}", cell(f)));
        let counts =
            [r.faces.to_string(), r.dofs.to_string(), error, order, fitted, time(r.wall_s), time(r.gflop), r.factorizations.to_string()];
        let sampling = sampled.then(|| r.sampling.unwrap_or("-").to_owned());
        let method = by_method.then(|| r.method.unwrap_or("-").to_owned());
        let step = by_step.then(|| optional(r.step));
        let kind = [cell(&r.director), cell(&r.mesh)].into_iter().chain(sampling).chain(method).chain([number(r.thickness)]);
        kind.chain(step).chain(counts).collect()
    };
    let (sampling, method) = (sampled.then_some("sampling"), by_method.then_some("method"));
    let step = by_step.then_some("step [s]");
    let counts = ["faces", "unknowns", "error", "order", "fitted order", "run time [s]", "run time [Gflop]", "factorisations"];
    let header: Vec<&str> =
        ["director", "mesh"].into_iter().chain(sampling).chain(method).chain(["thickness [m]"]).chain(step).chain(counts).collect();
    let mut text = table(&header, header.len() - counts.len() - 1 - usize::from(by_step), &rows.iter().map(row).collect::<Vec<_>>());
    let missed: Vec<String> = rows.iter().flat_map(|r| r.missed.iter().map(|m| format!("- {}: {m}\n", r.kind()))).collect();
    if !missed.is_empty() {
        text += &format!("\nMissed:\n\n{}", missed.concat());
    }
    text
}

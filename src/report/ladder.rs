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
    /// Number of faces.
    pub faces: usize,
    /// Number of unknowns.
    pub dofs: usize,
    /// Distance of what was measured from its exact value; none for a run that failed.
    pub error: Option<f64>,
    /// Observed order against the next coarser run of the same kind; see [`orders`].
    pub order: Option<f64>,
    /// Run time [s].
    pub wall_s: f64,
    /// Numeric factorisations.
    pub factorizations: u64,
    /// Why the run failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

impl LadderRow {
    fn is_of_the_kind_of(&self, other: &LadderRow) -> bool {
        self.director == other.director && self.mesh == other.mesh && self.thickness.to_bits() == other.thickness.to_bits()
    }
}

/// Sets the order of each row from the row before it of the same director, mesh and thickness, with `h = faces^(-1/2)`.
///
/// A first row has none, nor has one after a run that failed.
pub fn orders(rows: &mut [LadderRow]) {
    let point = |row: &LadderRow| Some(((row.faces as f64).powf(-0.5), row.error?));
    for i in 0..rows.len() {
        let (before, rest) = rows.split_at_mut(i);
        let row = &mut rest[0];
        let coarser = before.iter().rev().find(|b| b.is_of_the_kind_of(row));
        row.order = coarser.and_then(point).zip(point(row)).and_then(|(coarse, fine)| norm::observed_order(coarse, fine));
    }
}

/// Contents of `ladder.json`: one object per row. A row that failed has `error` null and a key `failure`.
pub fn to_json(rows: &[LadderRow]) -> String {
    super::outcome::json(&rows)
}

/// The table as Markdown.
pub fn to_markdown(rows: &[LadderRow]) -> String {
    let optional = |value: Option<f64>| value.map_or("-".into(), number);
    let row = |r: &LadderRow| {
        let order = r.order.map_or("-".into(), |o| format!("{o:.2}"));
        let error = r.failure.as_ref().map_or_else(|| optional(r.error), |f| format!("failed: {}", cell(f)));
        let counts = [r.faces.to_string(), r.dofs.to_string(), error, order, format!("{:.2}", r.wall_s), r.factorizations.to_string()];
        [cell(&r.director), cell(&r.mesh), number(r.thickness)].into_iter().chain(counts).collect()
    };
    let header = ["director", "mesh", "thickness [m]", "faces", "unknowns", "error", "order", "run time [s]", "factorisations"];
    table(&header, 2, &rows.iter().map(row).collect::<Vec<_>>())
}

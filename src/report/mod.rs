//! Numbers that say how good a result is, and the tables that show them.
//!
//! Pure functions of points, faces and numbers; no file is read or written here, and no model is known.

pub mod curvature;
pub mod distance;
pub mod fit;
pub mod ladder;
pub mod machine;
pub mod matrix;
pub mod norm;
pub mod outcome;
pub mod path;
pub mod shapes;
pub mod surface;
pub mod sweep;
pub mod waves;

pub use crate::math::rigid_fit;
pub use curvature::{Curvature, curvature};
pub use distance::{farthest, hausdorff};
pub use fit::cylinder_distance;
pub use ladder::LadderRow;
pub use machine::DenseProduct;
pub use matrix::{MatrixCell, MatrixSolution};
pub use norm::{PowerLaw, l2_norm, mean, median, observed_order, power_law, rate, vertex_areas};
pub use outcome::{Cost, ExpectationResult, Outcome};
pub use path::{PathTable, Place};
pub use surface::{Surface, nodes_distance, surface_distance};
pub use sweep::{Sweep, SweepFit, SweepLargest, SweepRow};
pub use waves::{Waves, waves};

/// A text as one cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}

/// A Markdown table, padded so that it reads well in a terminal. The first `texts` columns are set left, numbers right.
fn table(header: &[&str], texts: usize, rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([header[column].chars().count(), 3]).max().unwrap_or(3)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let padded = cells.enumerate().map(|(i, c)| if i < texts { format!("{c:<0$}", widths[i]) } else { format!("{c:>0$}", widths[i]) });
        format!("| {} |\n", padded.collect::<Vec<_>>().join(" | "))
    };
    let rule = |i: usize| if i < texts { format!(":{}", "-".repeat(widths[i] - 1)) } else { format!("{}:", "-".repeat(widths[i] - 1)) };
    let rules: Vec<String> = (0..header.len()).map(rule).collect();
    let mut text = line(&mut header.iter().copied());
    text += &line(&mut rules.iter().map(String::as_str));
    for row in rows {
        text += &line(&mut row.iter().map(String::as_str));
    }
    text
}

/// A number for people: six digits, exponents where they are shorter, a dash where there is none.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "-".into();
    }
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = if value == 0.0 { 0 } else { (5 - value.abs().log10().floor() as i32).clamp(0, 8) as usize };
        let text = format!("{value:.digits$}");
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text };
    }
    format!("{value:.3e}")
}

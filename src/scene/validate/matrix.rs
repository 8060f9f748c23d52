//! Rules of `[report.matrix]`.

use super::report::sweep_measures;
use super::*;

/// Cells that a matrix may have.
const MOST_CELLS: usize = 10_000;

pub(super) fn matrix(table: &Matrix, scene: &Scene) -> Check {
    let key = |name: &str| format!("report.matrix.{name}");
    sweep_measures("report.matrix.measures", &table.measures, scene)?;
    require(&key("most_factorizations"), table.most_factorizations != Some(0), "must be >= 1")?;
    // Recorded scenes are TOML, whose integers have a sign.
    require(&key("most_factorizations"), table.most_factorizations.is_none_or(|n| n <= i64::MAX as u64), "must be below 2^63")?;
    positive_or_absent(&key("most_iterations"), table.most_iterations, "1")?;
    positive(&key("largest_energy"), table.largest_energy, "1")?;
    require(&key("largest_gain"), table.largest_gain >= 0.0 && table.largest_gain.is_finite(), "must be >= 0 [1]")?;
    positive(&key("most_seconds"), table.most_seconds, "s")?;
    within(&key("most_seconds"), table.most_seconds, 0.0..=1e6)?;
    require(&key("part"), !table.parts.is_empty(), "must not be empty")?;
    let mut cells = 0usize;
    for (i, entry) in table.parts.iter().enumerate() {
        let key = format!("report.matrix.part.{i}");
        named(&format!("{key}.name"), &entry.name)?;
        let new = table.parts[..i].iter().all(|other| other.name != entry.name);
        require(&format!("{key}.name"), new, "a part of this name comes before")?;
        changes(&format!("{key}.set"), &entry.set)?;
        let mut product = 1usize;
        for (k, axis) in entry.axes.iter().enumerate() {
            let key = format!("{key}.axes.{k}");
            values(&key, &axis.key, &axis.values, axis.values.len())?;
            for (j, tied) in axis.with.iter().enumerate() {
                values(&format!("{key}.with.{j}"), &tied.key, &tied.values, axis.values.len())?;
            }
            product = product.saturating_mul(axis.values.len());
        }
        cells = cells.saturating_add(product);
    }
    require(&key("part"), cells <= MOST_CELLS, format!("makes {cells} cells, must be at most {MOST_CELLS}"))
}

/// Changes of a scene; `at` is the key of their list.
pub(super) fn changes(at: &str, changes: &[String]) -> Check {
    let wrong = changes.iter().position(|text| !text.contains('='));
    wrong.map_or(Ok(()), |k| require(&format!("{at}.{k}"), false, "`key=value` expected"))
}

/// A key and as many values of it.
pub(super) fn values(at: &str, key: &str, values: &[SweepValue], count: usize) -> Check {
    let parts = key.split('.').all(|part| !part.trim().is_empty()) && !key.contains('=');
    require(&format!("{at}.key"), parts, "must be names joined by dots")?;
    require(&format!("{at}.values"), !values.is_empty(), "must not be empty")?;
    require(
        &format!("{at}.values"),
        values.len() == count,
        format!("has {} values, must have {count} as the key that it goes with", values.len()),
    )
}

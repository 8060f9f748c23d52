//! Where on a path something happens, between its steps: by polynomials through up to five of them over the way along the path.
//!
//! The path itself is smooth there; its load factor at a limit point, or a displacement at a given load factor, are then known far better than by
//! the nearest step.

use serde::Serialize;

/// A place on a path: steps (their indices) and their weights, which add up to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Indices of steps that follow each other, and the weight of each.
    pub weights: Vec<(usize, f64)>,
}

impl Place {
    /// The step of that index itself.
    pub fn step(index: usize) -> Self {
        Place { weights: vec![(index, 1.0)] }
    }

    /// Lagrange's polynomial through the steps `from..=to` at `way`.
    fn between(ways: &[f64], from: usize, to: usize, way: f64) -> Self {
        let weight = |i: usize| (from..=to).filter(|j| *j != i).map(|j| (way - ways[j]) / (ways[i] - ways[j])).product();
        Place { weights: (from..=to).map(|i| (i, weight(i))).collect() }
    }

    /// The value there of what has these values at the steps.
    pub fn of(&self, values: &[f64]) -> f64 {
        self.weights.iter().map(|(i, weight)| weight * values[*i]).sum()
    }
}

/// The `number`-th place, counted from 1, where `t` turns back. `ways`: strictly growing way along the path at each step.
pub fn limit_point(ways: &[f64], t: &[f64], number: usize) -> Option<Place> {
    let turns = |i: &usize| (t[*i] - t[i - 1]) * (t[i + 1] - t[*i]) < 0.0 || (t[*i] != t[i - 1] && t[i + 1] == t[*i]);
    let at = (1..t.len().saturating_sub(1)).filter(turns).nth(number.checked_sub(1)?)?;
    let (from, to) = (at.saturating_sub(2), (at + 2).min(t.len() - 1));
    let sign = if t[at] > t[at - 1] { 1.0 } else { -1.0 };
    let height = |way: f64| sign * Place::between(ways, from, to, way).of(t);
    // One maximum between the neighbours.
    let (mut low, mut high) = (ways[at - 1], ways[at + 1]);
    for _ in 0..200 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if height(a) < height(b) { low = a } else { high = b }
    }
    Some(Place::between(ways, from, to, 0.5 * (low + high)))
}

/// The `number`-th place, counted from 1, where what has these `values` at the steps comes to or goes through `value`. `ways`: strictly growing.
pub fn passage(ways: &[f64], values: &[f64], value: f64, number: usize) -> Option<Place> {
    let number = number.checked_sub(1)?;
    let passes = |i: &usize| values[*i] != value && (values[*i] - value) * (values[i + 1] - value) <= 0.0;
    let at = (0..values.len().saturating_sub(1)).filter(passes).nth(number)?;
    // Four states, fewer only where there are no more.
    let last = values.len() - 1;
    let from = at.saturating_sub(1).min(last.saturating_sub(3));
    let to = (from + 3).min(last);
    let above = |way: f64| Place::between(ways, from, to, way).of(values) > value;
    let (mut low, mut high) = (ways[at], ways[at + 1]);
    let start = values[at] > value;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if above(middle) == start { low = middle } else { high = middle }
    }
    Some(Place::between(ways, from, to, 0.5 * (low + high)))
}

/// Measures at each step of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PathTable {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// One row per kept state; null where a measure has no value.
    pub rows: Vec<Vec<Option<f64>>>,
}

impl PathTable {
    /// The table as comma-separated values; nothing where a measure has no value.
    ///
    /// # Errors
    /// None that a table in memory has.
    pub fn to_csv(&self) -> std::io::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(|value| value.map_or(String::new(), |v| format!("{v:?}"))))?;
        }
        writer.into_inner().map_err(|e| e.into_error())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path with uneven steps, `t = s^3 - 3 s^2 + 2 s`, which turns at `1 -+ 1/sqrt 3`.
    fn path() -> (Vec<f64>, Vec<f64>) {
        let ways: Vec<f64> = [0.0, 0.1, 0.25, 0.5, 0.7, 1.0, 1.2, 1.45, 1.8, 2.1].to_vec();
        let t = ways.iter().map(|s| s * (s - 1.0) * (s - 2.0)).collect();
        (ways, t)
    }

    #[test]
    fn finds_limit_points_between_steps() {
        let (ways, t) = path();
        for (number, s) in [(1, 1.0 - 3f64.sqrt().recip()), (2, 1.0 + 3f64.sqrt().recip())] {
            let place = limit_point(&ways, &t, number).unwrap();
            assert!((place.of(&ways) - s).abs() < 1e-6 && (place.of(&t) - s * (s - 1.0) * (s - 2.0)).abs() < 1e-12, "{place:?}");
        }
        assert!(limit_point(&ways, &t, 3).is_none() && limit_point(&ways, &t, 0).is_none() && limit_point(&[0.0], &[0.0], 1).is_none());
    }

    #[test]
    fn finds_passages_between_steps() {
        let (ways, t) = path();
        // The first state is at 0 and does not come to it.
        for (value, number, s) in [(0.0, 1, 1.0), (0.0, 2, 2.0), (0.375, 1, 1.25 - 0.5 * 3.25f64.sqrt())] {
            let place = passage(&ways, &t, value, number).unwrap();
            assert!((place.of(&ways) - s).abs() < 1e-12, "{value} {number}: {}", place.of(&ways));
        }
        let place = passage(&ways, &t, 0.3, 1).unwrap();
        assert!((place.of(&t) - 0.3).abs() < 1e-12);
        assert!(passage(&ways, &t, 5.0, 1).is_none() && passage(&ways, &t, 0.0, 3).is_none());
    }
}

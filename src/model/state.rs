//! Fields and counts of snapshots, whatever the model.

use crate::snapshot::{Association, Field, Snapshot};
use crate::solve::Counters;

/// A field of a snapshot.
pub(super) fn field(name: &str, association: Association, components: usize, unit: &str, data: Vec<f64>) -> Field {
    Field { name: name.into(), association, components, unit: unit.into(), data }
}

/// Numbers of a field of a snapshot. Errors: one that is missing or of another length.
pub(super) fn take_field(snapshot: &Snapshot, name: &str, length: usize) -> Result<Vec<f64>, String> {
    let field = snapshot.field(name).ok_or(format!("it has no field '{name}'"))?;
    if field.data.len() == length {
        Ok(field.data.clone())
    } else {
        Err(format!("field '{name}' has {} numbers instead of {length}", field.data.len()))
    }
}

/// The counts that every model keeps, as numbers of a snapshot.
pub(super) fn numbers(counters: &Counters) -> Vec<(String, f64)> {
    let numbers = [
        ("newton_iterations", counters.newton_iterations),
        ("fallback_iterations", counters.fallback_iterations),
        ("factorizations", counters.factorizations),
    ];
    numbers.map(|(name, value)| (name.to_owned(), value as f64)).into()
}

/// All counts that a snapshot has; those that it does not name are 0.
pub(super) fn counters(snapshot: &Snapshot) -> Counters {
    let count = |name: &str| snapshot.number(name).unwrap_or(0.0) as u64;
    Counters {
        newton_iterations: count("newton_iterations"),
        fallback_iterations: count("fallback_iterations"),
        factorizations: count("factorizations"),
        branch_switches: count("branch_switches"),
        relaxation_iterations: count("relaxation_iterations"),
    }
}

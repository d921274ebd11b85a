//! Compares the facts of freshly computed records with those of committed ones.

use crate::{HarnessError, studies};
use drape_report::Record;
use drape_report::file::read_json;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;

/// Relative tolerance for numbers that passed through a library's factorisation.
const LIBRARY_TOLERANCE: f64 = 1e-9;
/// Keys whose values magnify differences: slopes between logarithms of small errors, and errors
/// over a power of the step.
const MAGNIFIED: [&str; 2] = ["order", "error_constant"];
const MAGNIFIED_TOLERANCE: f64 = 1e-6;
/// Integers of such cells may differ with the machine; they are recorded, not compared.
const MACHINE_COUNTS: [&str; 13] = [
    "cg_iterations",
    "outer_passes",
    "newton_iterations",
    "matvecs",
    "force_evaluations",
    "factorisations",
    "setups",
    "substeps",
    "rejected",
    "cg_per_step",
    "idle_steps",
    "unconverged_steps",
    "work_sweeps",
];

/// The two verdicts on a run that blows up. The last bit decides which of them it gets.
const BLOWN_UP: [&str; 2] = ["unstable", "diverged"];

/// A fact that no longer holds.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{record}: {cell}: `{key}` is {fresh}, committed is {committed}")]
pub struct Difference {
    /// Name of the record's file.
    pub record: String,
    /// Which cell.
    pub cell: String,
    /// Which value.
    pub key: String,
    /// The value that was computed now.
    pub fresh: String,
    /// The value that is committed.
    pub committed: String,
}

/// One comparable cell.
pub(crate) struct Fact {
    /// Names it within its record.
    pub(crate) key: String,
    /// Whether it has the same bits on every machine.
    pub(crate) portable: bool,
    pub(crate) values: Value,
}

/// A cell with all its values.
pub(crate) fn fact(key: String, portable: bool, values: &impl Serialize) -> Fact {
    Fact { key, portable, values: serde_json::to_value(values).unwrap_or(Value::Null) }
}

fn agree(key: &str, portable: bool, fresh: &Value, committed: &Value) -> bool {
    if portable || fresh == committed {
        return fresh == committed;
    }
    if MACHINE_COUNTS.contains(&key) {
        return true;
    }
    let blows_up = |value: &Value| value.as_str().is_some_and(|text| BLOWN_UP.contains(&text));
    if key == "verdict" && blows_up(fresh) && blows_up(committed) {
        return true;
    }
    if let (Some(fresh), Some(committed)) = (fresh.as_array(), committed.as_array()) {
        let mut pairs = fresh.iter().zip(committed);
        return fresh.len() == committed.len() && pairs.all(|(a, b)| agree(key, portable, a, b));
    }
    let is_magnified = MAGNIFIED.contains(&key);
    let tolerance = if is_magnified { MAGNIFIED_TOLERANCE } else { LIBRARY_TOLERANCE };
    match (fresh.as_f64(), committed.as_f64()) {
        (Some(a), Some(b)) => (a - b).abs() <= tolerance * a.abs().max(b.abs()).max(1.0),
        _ => false,
    }
}

/// Compares the facts of the record `name` below two folders.
pub(crate) fn compare<F: DeserializeOwned>(
    name: &str,
    fresh: &Path,
    committed: &Path,
    facts: fn(&F) -> Vec<Fact>,
) -> Result<(usize, Vec<Difference>), HarnessError> {
    let fresh = facts(&read_json::<Record<F>>(&fresh.join(name))?.facts);
    let committed = facts(&read_json::<Record<F>>(&committed.join(name))?.facts);
    let mut differences = Vec::new();
    for fact in &fresh {
        let difference = |key: &str, fresh: &Value, committed: &Value| Difference {
            record: name.to_owned(),
            cell: fact.key.clone(),
            key: key.to_owned(),
            fresh: fresh.to_string(),
            committed: committed.to_string(),
        };
        let Some(other) = committed.iter().find(|other| other.key == fact.key) else {
            differences.push(difference("cell", &Value::Bool(true), &Value::Null));
            continue;
        };
        let values = fact.values.as_object().into_iter().flatten();
        for (key, value) in values {
            let before = &other.values[key];
            if !agree(key, fact.portable, value, before) {
                differences.push(difference(key, value, before));
            }
        }
    }
    Ok((fresh.len(), differences))
}

/// Compares every fact of the records below `fresh` with the same fact below `committed`; `fresh`
/// may hold the quick subset. A portable fact must be equal. A fact in which a library's
/// factorisation took part must agree within 1e-9. Returns the number of facts compared and those
/// that differ.
///
/// # Errors
/// [`HarnessError::Record`] when a record is missing or unreadable.
pub fn compare_folders(
    fresh: &Path,
    committed: &Path,
) -> Result<(usize, Vec<Difference>), HarnessError> {
    let compared = studies::all()
        .iter()
        .map(|experiment| experiment.compare(fresh, committed))
        .collect::<Result<Vec<_>, _>>()?;
    let facts = compared.iter().map(|(facts, _)| facts).sum();
    Ok((facts, compared.into_iter().flat_map(|(_, differences)| differences).collect()))
}

#[cfg(test)]
#[path = "facts_tests.rs"]
mod tests;

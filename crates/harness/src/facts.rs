//! Do facts still hold? Compares freshly computed records with committed ones.

use crate::HarnessError;
use drape_records::file::read_json;
use drape_records::{Record, cg, hard_cases, momentum, order, tables};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;

/// Relative tolerance for numbers that passed through a library's factorisation.
const LIBRARY_TOLERANCE: f64 = 1e-9;
/// Slopes between logarithms of small errors, and errors over a power of the step, magnify such differences.
const MAGNIFIED: [&str; 2] = ["order", "error_constant"];
const MAGNIFIED_TOLERANCE: f64 = 1e-6;
/// Integers of such cells may differ with the machine; they are recorded, not compared.
const MACHINE_COUNTS: [&str; 7] = [
    "cg_iterations",
    "outer_passes",
    "newton_iterations",
    "matvecs",
    "cg_per_step",
    "idle_steps",
    "unconverged_steps",
];

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
    /// What was computed now.
    pub fresh: String,
    /// What is committed.
    pub committed: String,
}

/// One comparable cell: a key that names it, whether it is portable, and its values.
struct Fact {
    key: String,
    portable: bool,
    values: Value,
}

fn fact(key: String, portable: bool, values: &impl Serialize) -> Fact {
    Fact { key, portable, values: serde_json::to_value(values).unwrap_or(Value::Null) }
}

fn table_facts(record: &Record<tables::Facts>) -> Vec<Fact> {
    let cells = record.facts.rows.iter().flat_map(|row| {
        row.cells.iter().map(move |cell| {
            let key = format!("{} {} ε={}", row.id, cell.variant, cell.forcing_term);
            fact(key, cell.portable, cell)
        })
    });
    let rows = record.facts.rows.iter().map(|row| {
        let bare = tables::Row { cells: Vec::new(), best_fit: Vec::new(), ..row.clone() };
        fact(row.id.clone(), true, &bare)
    });
    rows.chain(cells).collect()
}

fn cg_facts(record: &Record<cg::Facts>) -> Vec<Fact> {
    let cells = record.facts.cells.iter().map(|c| {
        let key = format!(
            "{} {} n={} k/m={:e} h={} {} {} {} ε={}",
            c.series,
            c.material,
            c.particles,
            c.stiffness_over_mass_per_s2,
            c.step_s,
            c.variant,
            c.preconditioner,
            c.start,
            c.forcing_term
        );
        fact(key, c.portable, c)
    });
    let motion = record.facts.motion.iter().map(|m| {
        let key = format!("motion k/m={:e} {}", m.stiffness_over_mass_per_s2, m.label);
        fact(key, m.portable, m)
    });
    cells.chain(motion).collect()
}

fn hard_case_facts(record: &Record<hard_cases::Facts>) -> Vec<Fact> {
    let cases = record.facts.cases.iter().map(|case| fact(case.name.clone(), true, case));
    let cells = record.facts.cells.iter().map(|c| {
        let damping = if c.is_damped { "damped" } else { "undamped" };
        let mut fact = fact(format!("{}, {damping}: {}", c.case, c.method), c.portable, c);
        if let Value::Object(values) = &mut fact.values
            && !c.portable
        {
            // Long runs on hard scenes are chaotic: of what passed through a library only the verdict is repeatable.
            values.retain(|_, value| !value.is_number());
        }
        fact
    });
    cases.chain(cells).collect()
}

fn order_facts(record: &Record<order::Facts>) -> Vec<Fact> {
    let scenes = record.facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let rows = record.facts.rows.iter().flat_map(|row| {
        let key = format!("{} {}", row.scene, row.label);
        let bare = order::Row { runs: Vec::new(), ..row.clone() };
        let bare = fact(key.clone(), row.portable, &bare);
        let runs = row.runs.iter();
        let runs = runs.map(move |run| fact(format!("{key} h={}", run.step_s), row.portable, run));
        std::iter::once(bare).chain(runs)
    });
    scenes.chain(rows).collect()
}

fn momentum_facts(record: &Record<momentum::Facts>) -> Vec<Fact> {
    let scenes = record.facts.scenes.iter();
    let scenes = scenes.map(|scene| fact(format!("scene {}", scene.id), scene.portable, scene));
    let rows = record.facts.rows.iter().map(|row| {
        // An unstable run magnifies round-off: its way is the same everywhere only where the round-off is.
        let is_comparable = row.portable || row.verdict != momentum::UNSTABLE;
        let spin = if is_comparable { row.spin.clone() } else { Vec::new() };
        let row = momentum::Row { spin, ..row.clone() };
        fact(format!("{} {}", row.scene, row.label), row.portable, &row)
    });
    scenes.chain(rows).collect()
}

fn agree(key: &str, portable: bool, fresh: &Value, committed: &Value) -> bool {
    if portable || fresh == committed {
        return fresh == committed;
    }
    if MACHINE_COUNTS.contains(&key) {
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

fn compare<F: DeserializeOwned>(
    name: &str,
    fresh: &Path,
    committed: &Path,
    facts: fn(&Record<F>) -> Vec<Fact>,
) -> Result<(usize, Vec<Difference>), HarnessError> {
    let fresh = facts(&read_json::<Record<F>>(&fresh.join(name))?);
    let committed = facts(&read_json::<Record<F>>(&committed.join(name))?);
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

/// Compares every fact of the records below `fresh` (which may be the quick subset) with the same
/// fact below `committed`: exactly where the fact is portable, within 1e-9 where a library's
/// factorisation took part. Returns the number of facts compared and those that differ.
///
/// # Errors
/// [`HarnessError::Record`] when a record is missing or unreadable.
pub fn compare_folders(
    fresh: &Path,
    committed: &Path,
) -> Result<(usize, Vec<Difference>), HarnessError> {
    let compared = [
        compare("tables.json", fresh, committed, table_facts)?,
        compare("cg-vs-stiffness.json", fresh, committed, cg_facts)?,
        compare("order.json", fresh, committed, order_facts)?,
        compare("momentum.json", fresh, committed, momentum_facts)?,
        compare("hard-cases.json", fresh, committed, hard_case_facts)?,
    ];
    let facts = compared.iter().map(|(facts, _)| facts).sum();
    Ok((facts, compared.into_iter().flat_map(|(_, differences)| differences).collect()))
}

#[cfg(test)]
#[path = "facts_tests.rs"]
mod tests;

//! The maps agree with theory where it is certain.
#![allow(clippy::unwrap_used, reason = "tests")]

use super::atlas::{column, ends_column};
use super::sheet::{SEEDS, Setting};
use super::*;
use crate::methods::runs::Variant;
use crate::studies::stability::facts::EXACT;
use drape_report::file::read_json;
use drape_report::{Record, Verdict};
use std::path::Path;

/// Runs that end their column just so: method, k/m (1/s²), d/m (1/s) and step (s).
const EDGES: [(&str, f64, f64, f64); 3] = [
    ("dirk, esdirk3", 1e5, 0.0, 0.0316),
    ("baraff-witkin", 1e7, 0.0, 0.001),
    ("imex-updated", 1e6, 1.0, 0.000_316),
];

fn verdicts(label: &str, method: &'static str, setting: &Setting, steps: &[f64]) -> Vec<Verdict> {
    let variants = of_registry(|runs| runs.stability);
    let variant = variants.into_iter().find(|variant| variant.label == label);
    let variant = variant.unwrap_or(Variant::new("by its id", method));
    let cells = column(&variant, setting, steps).unwrap();
    cells.into_iter().map(|cell| cell.verdict).collect()
}

/// The largest eigenvalue is below 8 (k + k_s)/m. At k/m = 1e4 leapfrog is stable at 0.0067 s, and
/// not at 0.02 s.
#[test]
fn a_column_shows_the_limit_of_leapfrog_and_the_standstill_of_imex_euler() {
    let setting = Setting::new(1e4, 0.0).unwrap();
    let steps = [0.1, 0.02, 0.005];
    assert_eq!(
        verdicts("", "leapfrog", &setting, &steps),
        [Verdict::Diverged, Verdict::Diverged, Verdict::Stable]
    );
    let stiff = Setting::new(1e6, 0.0).unwrap();
    assert_eq!(verdicts(EXACT, "", &stiff, &[0.1]), [Verdict::Locked]);
    assert_eq!(verdicts(EXACT, "", &setting, &[0.005]), [Verdict::Stable]);
    assert_eq!(verdicts("", "backward-euler", &stiff, &[0.01]), [Verdict::Stable]);
}

#[test]
fn a_cell_beside_another_verdict_has_three_starts() {
    let setting = Setting::new(1e4, 0.0).unwrap();
    let variant = Variant::new("leapfrog", "leapfrog");
    let cells = column(&variant, &setting, &[0.02, 0.005, 0.004]).unwrap();
    let starts: Vec<_> = cells.iter().map(|cell| cell.starts).collect();
    assert_eq!(starts, [1, SEEDS.len() as u32, 1]);
}

#[test]
fn steps_shorter_than_those_over_budget_do_not_run() {
    let setting = Setting::new(1e6, 0.0).unwrap();
    let variant = Variant::new("by its id", "energy-momentum");
    let cells = column(&variant, &setting, &[0.001, 0.000_316, 0.000_1]).unwrap();
    assert!(cells.iter().all(|cell| cell.verdict == Verdict::OverBudget));
    assert!(cells[0].reached_s > 0.0 && cells[1].reached_s == 0.0);
    assert_eq!(cells.iter().map(|cell| cell.starts).collect::<Vec<_>>(), [1, 0, 0]);
    // A long step that is over budget says nothing of shorter ones, nor does a late end.
    let at = |step_s, share: f64, verdict| {
        let reached_s = share * super::sheet::schedule(step_s).time.duration_s;
        ends_column(&Cell { step_s, reached_s, verdict, ..cells[0].clone() })
    };
    assert!(at(0.01, 0.2, Verdict::OverBudget) && at(0.001, 0.9, Verdict::OverBudget));
    assert!(!at(0.1, 0.2, Verdict::OverBudget) && !at(0.01, 0.4, Verdict::OverBudget));
    assert!(!at(0.001, 0.2, Verdict::Stable));
}

/// The rule at its edge, against runs.
#[test]
fn a_step_that_is_left_out_is_over_budget() {
    let variants = of_registry(|runs| runs.stability);
    for (label, stiffness, damping, step) in EDGES {
        let setting = Setting::new(stiffness, damping).unwrap();
        let variant = variants.iter().find(|variant| variant.label == label).unwrap();
        let [longer, shorter] = [0, 1].map(|k| {
            let step = STEPS[STEPS.iter().position(|s| *s == step).unwrap() + k];
            column(variant, &setting, &[step]).unwrap().remove(0)
        });
        assert!(ends_column(&longer) && longer.starts == 1, "{label} at {step} s");
        assert_eq!((shorter.verdict, shorter.starts), (Verdict::OverBudget, 1), "{label}");
    }
}

#[test]
fn the_committed_map_leaves_out_what_the_rule_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results/stability.json");
    let record: Record<Facts> = read_json(&path).unwrap();
    let mut left_out = 0;
    for column in record.facts.cells.chunk_by(|a, b| a.step_s > b.step_s) {
        assert_eq!(column.len(), STEPS.len());
        for pair in column.windows(2) {
            let is_meant = pair[0].starts == 0 || ends_column(&pair[0]);
            assert_eq!(pair[1].starts == 0, is_meant, "{}, {} s", pair[1].label, pair[1].step_s);
            left_out += usize::from(is_meant);
        }
    }
    assert_eq!(left_out, 766);
}

#[test]
fn every_variant_has_a_theory_and_the_quick_columns_are_among_the_others() {
    for variant in of_registry(|runs| runs.stability) {
        assert!(
            crate::theory::form_of(variant.label).is_some_and(|form| form.limit.is_some()),
            "{}",
            variant.label
        );
    }
    let all = columns(false);
    for (k, d, steps) in columns(true) {
        let full = all.iter().find(|column| (column.0, column.1) == (k, d)).unwrap();
        assert!(full.2.starts_with(steps));
    }
}

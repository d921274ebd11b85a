//! Tests which differences between records count.

use super::*;
use crate::studies::momentum::facts as momentum;
use crate::studies::order::facts::{self as order, Run};
use crate::{Source, provenance};
use drape_report::RECORD_FORMAT;
use drape_report::Verdict;
use drape_report::file::write_json;
use std::collections::BTreeMap;

fn record<F>(facts: F) -> Record<F> {
    let text = || "text".to_owned();
    Record {
        format: RECORD_FORMAT.to_owned(),
        experiment: text(),
        question: text(),
        method: text(),
        command: text(),
        quick: false,
        words: drape_report::Words::default(),
        figures: Vec::new(),
        facts,
        provenance: provenance(&Source::default(), BTreeMap::new()),
    }
}

/// The keys that differ between two sets of facts.
fn different<F: Serialize + DeserializeOwned>(
    fresh: F,
    committed: F,
    facts: fn(&F) -> Vec<Fact>,
) -> Result<Vec<String>, Box<dyn std::error::Error>> {
    let folders = [tempfile::tempdir()?, tempfile::tempdir()?];
    for (folder, facts) in folders.iter().zip([fresh, committed]) {
        write_json(&folder.path().join("record.json"), &record(facts))?;
    }
    let (_, differences) = compare("record.json", folders[0].path(), folders[1].path(), facts)?;
    Ok(differences.into_iter().map(|d| format!("{}: {}", d.cell, d.key)).collect())
}

fn momentum(portable: bool, verdict: Verdict, spin: f64) -> momentum::Facts {
    let row = momentum::Row {
        scene: "spin".to_owned(),
        label: "method".to_owned(),
        method: "method".to_owned(),
        step_s: 0.01,
        spin: vec![1.0, spin],
        momentum_drift: None,
        angular_momentum_drift: None,
        final_spin: None,
        law: None,
        energy_gain: None,
        states_momentum: true,
        states_angular_momentum: true,
        verdict,
        unconverged_steps: 0,
        portable,
    };
    momentum::Facts { scenes: Vec::new(), rows: vec![row] }
}

#[test]
fn a_series_is_compared_within_the_tolerance_of_its_row() -> Result<(), Box<dyn std::error::Error>>
{
    let differs = |portable, verdict, change| {
        let (a, b) = (momentum(portable, verdict, 0.5), momentum(portable, verdict, 0.5 + change));
        different(a, b, studies::momentum::run::comparable)
    };
    let (completed, unstable) = (Verdict::Completed, Verdict::Unstable);
    assert_eq!(differs(true, completed, 1e-15)?, ["spin method: spin"]);
    assert!(differs(false, completed, 1e-10)?.is_empty());
    assert_eq!(differs(false, completed, 1e-8)?, ["spin method: spin"]);
    // An unstable run magnifies round-off, which is the same only where the run is portable.
    assert!(differs(false, unstable, 0.1)?.is_empty());
    assert_eq!(differs(true, unstable, 0.1)?, ["spin method: spin"]);
    Ok(())
}

#[test]
fn lists_of_different_length_differ() {
    let [short, long] = [1, 2].map(|length| Value::from(vec![0.5; length]));
    for portable in [true, false] {
        assert!(agree("spin", portable, &long, &long));
        assert!(!agree("spin", portable, &short, &long) && !agree("spin", portable, &long, &short));
    }
}

fn order(order: f64, error: f64) -> order::Facts {
    let verdict = Verdict::Completed;
    let row = order::Row {
        scene: "smooth".to_owned(),
        label: "method".to_owned(),
        method: "method".to_owned(),
        theory: Some(1),
        order: Some(order),
        fitted: 4,
        accepted: Some(true),
        error_constant: Some(4.0),
        runs: vec![Run { step_s: 0.01, error: Some(error), verdict, unconverged_steps: 0 }],
        portable: false,
    };
    order::Facts { scenes: Vec::new(), rows: vec![row] }
}

#[test]
fn slopes_may_differ_by_more_than_the_errors_behind_them() -> Result<(), Box<dyn std::error::Error>>
{
    let differs =
        |a, b| different(order(1.0, 0.5), order(1.0 + a, 0.5 + b), studies::order::run::comparable);
    assert!(differs(1e-7, 1e-10)?.is_empty());
    assert_eq!(differs(1e-5, 0.0)?, ["smooth method: order"]);
    assert_eq!(differs(0.0, 1e-8)?, ["smooth method h=0.01: error"]);
    Ok(())
}

/// Round-off may decide how a run blows up, but not whether.
#[test]
fn a_verdict_may_change_only_between_two_ways_to_blow_up() {
    let agrees = |a: &str, b: &str| agree("verdict", false, &Value::from(a), &Value::from(b));
    assert!(agrees("unstable", "diverged") && agrees("stable", "stable"));
    assert!(!agrees("stable", "unstable") && !agrees("diverged", "marginal"));
}

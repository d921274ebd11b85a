//! Tests of each branch of the words, with small facts.

use super::*;
use drape_report::Verdict;

fn runs(errors: &[Option<f64>]) -> Vec<Run> {
    let run = |(n, error): (usize, &Option<f64>)| Run {
        step_s: 0.01 / f64::from(1 << n),
        error: *error,
        verdict: if error.is_some() { Verdict::Completed } else { Verdict::Diverged },
        unconverged_steps: 0,
    };
    errors.iter().enumerate().map(run).collect()
}

/// A row with this observed order and this error at the finest step.
fn row(scene: &str, label: &str, theory: Option<u32>, order: Option<f64>, error: f64) -> Row {
    let agrees = |p: f64| theory.is_some_and(|theory| (p - f64::from(theory)).abs() < ACCEPTED);
    Row {
        scene: scene.to_owned(),
        label: label.to_owned(),
        method: label.to_owned(),
        theory,
        order,
        fitted: if order.is_some() { 4 } else { 2 },
        accepted: None,
        error_constant: order.filter(|p| agrees(*p)).map(|_| error),
        runs: runs(&[Some(error); 4]),
        portable: false,
    }
}

fn accepted(is_accepted: bool, row: Row) -> Row {
    Row { accepted: Some(is_accepted), ..row }
}

fn scene(id: &str, resolved: bool) -> Scene {
    Scene {
        id: id.to_owned(),
        resolved,
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 2.0,
        damping: "full".to_owned(),
        greatest_frequency_per_s: 300.0,
        span_s: 0.25,
        reference_error_m: 3e-12,
        portable: false,
    }
}

#[test]
fn no_facts_still_conclude_something() {
    let words = words(&Facts { scenes: Vec::new(), rows: Vec::new() });
    assert!(words.conclusion.contains("no row") && words.observations.is_empty());
}

#[test]
fn words_name_who_fails_who_claims_nothing_and_what_stiffness_does() {
    let gone = Row { runs: runs(&[None; 4]), ..row("stiff", "gone", Some(1), None, 0.1) };
    let mut facts = Facts {
        scenes: vec![scene("smooth", true), scene("stiff", false)],
        rows: vec![
            accepted(true, row("smooth", "good", Some(1), Some(1.0), 4.0)),
            accepted(true, row("smooth", "better", Some(1), Some(1.0), 2.0)),
            accepted(false, row("smooth", "wrong", Some(2), Some(1.0), 4.0)),
            row("smooth", "modest", None, Some(0.1), 0.02),
            row("stiff", "good", Some(1), Some(1.0), 0.1),
            row("stiff", "reduced", Some(2), Some(1.0), 0.1),
            row("stiff", "locked", Some(1), Some(0.1), 0.7),
            row("stiff", "sparse", Some(1), None, 0.1),
            row("stiff", "modest", None, Some(1.0), 0.1),
            gone,
        ],
    };
    let words = super::words(&facts);
    let said = words.conclusion;
    assert!(said.contains("within 0.15 in 2 of 3 cases. The exception is `wrong`."), "{said}");
    assert!(said.contains("order remains with 1 of 5 at k/m = 10⁴ s⁻²."), "{said}");
    let said = words.observations.join("\n");
    for part in [
        "(h ω_max down to 0.38): 1 with the order of theory, 1 with another order, 1 without a \
         claim, 1 off by half the motion, 1 with too few runs, 1 diverged.",
        "1 variant that claims no order solves another equation; its error at the finest \
         step reaches 2.0 %",
        "a factor of up to 2.0 (order 1)",
    ] {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    assert!(words.caveats.join(" ").contains("at most 3.0·10⁻¹² m"));
    let input = super::super::plates::Input { facts: facts.clone(), timings: None };
    let tables = super::super::plates::tables(&input);
    let cells = |n: usize, line: usize| tables[n].rows[line].join("; ");
    assert_eq!(cells(1, 0), "10⁴; good; with the order of theory; 1; 1.00; 0.100; 4");
    assert_eq!(cells(1, 3), "10⁴; locked; off by half the motion; 1; 0.10; 0.700; 4");
    assert_eq!(cells(1, 4), "10⁴; sparse; with too few runs; 1; –; 0.100; 2");
    assert!(cells(1, 5).starts_with("10⁴; gone; diverged"));
    assert_eq!((cells(2, 0), cells(2, 1)), ("1; better; 2.00".into(), "1; good; 4.00".into()));
    facts.rows.retain(|row| row.label != "wrong");
    let said = super::words(&facts).conclusion;
    assert!(said.contains("in 2 of 2 cases.") && !said.contains("exception"), "{said}");
}

//! What is concluded from drifts, and runs of a few methods.

use super::super::words::*;
use super::*;

fn row(scene: &str, label: &str) -> Row {
    Row {
        scene: scene.to_owned(),
        label: label.to_owned(),
        method: label.to_owned(),
        step_s: 0.01,
        spin: vec![1.0, 1.0],
        momentum_drift: Some(1e-15),
        angular_momentum_drift: Some(1e-15),
        final_spin: Some(1.0),
        law: None,
        energy_gain: Some(0.0),
        states_momentum: true,
        states_angular_momentum: false,
        verdict: Verdict::Completed,
        unconverged_steps: 0,
        portable: true,
    }
}

fn unstable_row(scene: &str, label: &str) -> Row {
    Row {
        momentum_drift: None,
        angular_momentum_drift: None,
        final_spin: None,
        energy_gain: None,
        verdict: Verdict::Unstable,
        ..row(scene, label)
    }
}

#[test]
fn the_greatest_drift_of_each_label_counts() {
    let drifting = |scene: &str, drift| Row { momentum_drift: Some(drift), ..row(scene, "leaky") };
    let facts = Facts {
        scenes: Vec::new(),
        rows: vec![
            drifting("fall-1e4", 0.25),
            row("fall-1e4", "tight"),
            drifting("fall-1e6", 0.5),
            drifting("spin-1e4", 0.125),
            unstable_row("spin-1e4", "tight"),
            Row { states_momentum: false, ..drifting("spin-1e4", 2.0) },
        ],
    };
    let pick: Pick = |row| (row.states_momentum, row.momentum_drift);
    let found = drifts(&facts, pick, true);
    assert_eq!(found, [("leaky", 0.5, "fall-1e6"), ("tight", 1e-15, "fall-1e4")]);
    assert_eq!(drifts(&facts, pick, false), [("leaky", 2.0, "spin-1e4")]);
    let text = stated(&facts, "linear", pick).unwrap_or_default();
    assert!(
        text.starts_with("1 of 2 variants") && text.contains("leaky 0.500 (fall-1e6)"),
        "{text}"
    );
}

#[test]
fn findings_name_what_is_lost_what_holds_and_what_fails() {
    let left = |scene, label, spin| Row { final_spin: Some(spin), ..row(scene, label) };
    let facts = Facts {
        scenes: Vec::new(),
        rows: vec![
            left("spin-1e4", "keeper", 1.004),
            left("spin-1e4", "desbrun, literal", 0.152),
            left("spin-1e4", "desbrun, consistent", 1.0),
            Row { energy_gain: Some(0.25), ..row("spin-1e6", "pump") },
            Row { law: Some(0.75), ..left("pair-1e4", "lawful", 0.5) },
            unstable_row("fall-1e4", "wild"),
            unstable_row("fall-1e6", "wild"),
        ],
    };
    let text = findings(&facts).join("\n");
    for part in [
        "kept within 1 % by keeper, desbrun, consistent; else |L|/|L₀| is desbrun, literal 0.152",
        "desbrun, literal, spin-1e4: 0.152 (prototype 0.15, confirmed)",
        "desbrun, consistent, spin-1e4: 1.000 (prototype 0.96, not confirmed)",
        "pump 25.0 % (spin-1e6)",
        "in all 1 runs",
        "met within 0.250",
        "wild (fall-1e4, fall-1e6)",
        "should keep linear momentum by the statement of their method do",
    ] {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
}

#[test]
fn every_label_that_the_tables_name_is_run() {
    let variants = of_registry(&VARIANTS);
    let named = UNSTATED.into_iter().chain(PROTOTYPE.iter().map(|(_, label, _)| *label));
    for label in named {
        assert!(variants.iter().any(|variant| variant.label == label), "{label}");
    }
}

fn setting(id: &str) -> Result<Setting, HarnessError> {
    let case = CASES.iter().find(|case| case.id == id);
    Setting::new(case.unwrap_or(&CASES[0]))
}

fn variant(label: &str) -> Variant {
    let variants = of_registry(&VARIANTS);
    let found = variants.into_iter().find(|variant| variant.label == label);
    found.unwrap_or_else(|| panic!("no variant {label}"))
}

#[test]
fn two_particles_follow_the_law_of_each_method() -> Result<(), HarnessError> {
    let pair = setting("pair-1e4")?;
    let mut lawful = 0;
    let variants = of_registry(&VARIANTS);
    let has_law = |v: &&Variant| theory::form(v.label).is_some_and(|form| form.spin.is_some());
    for variant in variants.iter().filter(has_law) {
        let (row, label) = (pair.row(variant)?, variant.label);
        if row.verdict == Verdict::Unstable {
            continue;
        }
        let (spin, law) = (row.final_spin.unwrap_or(f64::NAN), row.law.unwrap_or(f64::NAN));
        assert!((spin - law).abs() < 1e-8, "{label}: {spin} against {law}");
        lawful += 1;
    }
    assert!(lawful >= 10, "{lawful}");
    Ok(())
}

#[test]
fn explicit_steps_are_divided_and_keep_their_momenta() -> Result<(), HarnessError> {
    let sheet = setting("spin-1e4")?;
    let row = sheet.row(&variant("symplectic-euler"))?;
    assert!(row.step_s * sheet.scene.greatest_frequency_per_s <= EXPLICIT, "{}", row.step_s);
    assert_eq!(row.spin.len(), sheet.scene.time_s.len());
    assert!(row.states_momentum && row.momentum_drift.is_some_and(|drift| drift < 1e-13));
    assert!(row.states_angular_momentum);
    assert!(row.angular_momentum_drift.is_some_and(|drift| drift < 1e-13), "{row:?}");
    Ok(())
}

/// On the uneven sheet nothing cancels by symmetry: a method that does not pull in pairs drifts.
#[test]
fn the_falling_sheet_tells_who_keeps_linear_momentum() -> Result<(), HarnessError> {
    let sheet = setting("fall-1e4")?;
    let drift = |label| -> Result<f64, HarnessError> {
        Ok(sheet.row(&variant(label))?.momentum_drift.unwrap_or(f64::NAN))
    };
    assert!(drift("imex-euler")? < 1e-10);
    assert!(drift("kang")? > 1e-3);
    Ok(())
}

#[test]
fn a_run_that_gains_more_than_the_spin_is_unstable_and_has_no_numbers() -> Result<(), HarnessError>
{
    let pair = setting("pair-1e6")?;
    let row = pair.row(&variant("explicit-euler"))?;
    assert_eq!(row.verdict, Verdict::Unstable);
    let numbers =
        [row.momentum_drift, row.angular_momentum_drift, row.final_spin, row.law, row.energy_gain];
    assert_eq!(numbers, [None; 5]);
    assert!(row.spin.len() < pair.scene.time_s.len());
    assert!(row.spin.iter().all(|spin| spin.is_finite()));
    Ok(())
}

//! Tests with runs of a few methods.

use super::super::facts::PROTOTYPE;
use super::*;

#[test]
fn every_label_that_the_tables_name_is_run() {
    let forms = forms();
    for (_, label, _) in PROTOTYPE {
        assert!(forms.iter().any(|(form, _)| form.label == label), "{label}");
    }
}

fn setting(id: &str) -> Result<Setting, HarnessError> {
    let case = CASES.iter().find(|case| case.id == id);
    Setting::new(case.unwrap_or(&CASES[0]))
}

fn form(label: &str) -> (Variant, Keeps) {
    let found = forms().into_iter().find(|(form, _)| form.label == label);
    found.unwrap_or_else(|| panic!("no form {label}"))
}

#[test]
fn two_particles_follow_the_law_of_each_method() -> Result<(), HarnessError> {
    let pair = setting("pair-1e4")?;
    let mut lawful = 0;
    let has_law = |(form, _): &&(Variant, Keeps)| {
        theory::form_of(form.label).is_some_and(|form| form.spin.is_some())
    };
    for form in forms().iter().filter(has_law) {
        let (row, label) = (pair.row(form)?, form.0.label);
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
    let row = sheet.row(&form("symplectic-euler"))?;
    assert!(row.step_s * sheet.scene.greatest_frequency_per_s <= EXPLICIT, "{}", row.step_s);
    assert_eq!(row.spin.len(), sheet.scene.time_s.len());
    assert!(row.states_momentum && row.momentum_drift.is_some_and(|drift| drift < 1e-13));
    assert!(row.states_angular_momentum);
    assert!(row.angular_momentum_drift.is_some_and(|drift| drift < 1e-13), "{row:?}");
    Ok(())
}

/// On the uneven sheet no errors cancel by symmetry. A method whose forces are not pairs drifts.
#[test]
fn the_falling_sheet_tells_who_keeps_linear_momentum() -> Result<(), HarnessError> {
    let sheet = setting("fall-1e4")?;
    let drift = |label| -> Result<f64, HarnessError> {
        Ok(sheet.row(&form(label))?.momentum_drift.unwrap_or(f64::NAN))
    };
    assert!(drift("imex-euler")? < 1e-10);
    // Sweeps over single particles lose less, and these methods do not claim to keep momentum
    // either.
    let loses = methods::all().filter(|method| !method.conserves.contains(&Quantity::Momentum));
    let drifts: Result<Vec<_>, _> = loses.map(|method| drift(method.id)).collect();
    assert!(drifts?.iter().any(|drift| *drift > 1e-3));
    Ok(())
}

#[test]
fn a_run_that_gains_more_than_the_spin_is_unstable_and_has_no_numbers() -> Result<(), HarnessError>
{
    let pair = setting("pair-1e6")?;
    let row = pair.row(&form("explicit-euler"))?;
    assert_eq!(row.verdict, Verdict::Unstable);
    let numbers =
        [row.momentum_drift, row.angular_momentum_drift, row.final_spin, row.law, row.energy_gain];
    assert_eq!(numbers, [None; 5]);
    assert!(row.spin.len() < pair.scene.time_s.len());
    assert!(row.spin.iter().all(|spin| spin.is_finite()));
    Ok(())
}

//! Tests of conclusions from errors, and runs of a few methods.

use super::*;

fn runs(errors: &[Option<f64>]) -> Vec<Run> {
    let run = |(n, error): (usize, &Option<f64>)| Run {
        step_s: 0.01 / f64::from(1 << n),
        error: *error,
        verdict: if error.is_some() { Verdict::Completed } else { Verdict::Diverged },
        unconverged_steps: 0,
    };
    errors.iter().enumerate().map(run).collect()
}

/// Runs with errors `c hᵖ` at four step sizes.
fn power_law(c: f64, p: i32) -> Vec<Run> {
    let errors: Vec<_> = runs(&[None; 4]).iter().map(|run| Some(c * run.step_s.powi(p))).collect();
    runs(&errors)
}

#[test]
fn the_order_of_theory_comes_with_its_constant_and_another_without() {
    let second = power_law(30.0, 2);
    let observed = Observed::of(&second, Some(2));
    assert!((observed.order.unwrap_or_default() - 2.0).abs() < 1e-12, "{observed:?}");
    assert!((observed.error_constant.unwrap_or_default() - 30.0).abs() < 1e-9, "{observed:?}");
    assert!(observed.agrees && observed.fitted == 4);
    for theory in [Some(1), None] {
        let observed = Observed::of(&second, theory);
        assert!(!observed.agrees && observed.error_constant.is_none(), "{observed:?}");
        assert!(observed.order.is_some());
    }
}

#[test]
fn runs_behind_one_that_diverged_do_not_count() {
    let mut mixed = power_law(1.0, 1);
    mixed[0].error = None;
    let observed = Observed::of(&mixed, Some(1));
    assert_eq!((observed.fitted, observed.agrees), (3, true));
    // A run that is coarser than a diverged one may have a small error by chance.
    mixed[0].error = Some(1e-9);
    mixed[1].error = None;
    let observed = Observed::of(&mixed, Some(1));
    assert_eq!((observed.fitted, observed.order, observed.agrees), (2, None, false));
    let all = Observed::of(&runs(&[None; 4]), Some(1));
    assert_eq!((all.fitted, all.order), (0, None));
}

#[test]
fn exceptions_of_theory_are_those_of_known_variants() {
    assert_eq!(theory("terzopoulos-fleischer, clamped", Order::One), None);
    assert_eq!(theory("bdf, 3 steps", Order::Two), Some(3));
    assert_eq!(theory("bdf2", Order::Two), Some(2));
}

#[test]
fn a_few_methods_on_the_smooth_and_on_a_stiff_scene() -> Result<(), HarnessError> {
    let smooth = Setting::new(&CASES[0])?;
    assert!(smooth.scene.resolved && smooth.scene.reference_error_m < 1e-9);
    for method in ["symplectic-euler", "imex-euler:forcing_term=1e-10"] {
        let row = smooth.row(&Variant::new("first order", method))?;
        assert_eq!(row.accepted, Some(true), "{row:?}");
        let constant = row.error_constant.unwrap_or_default();
        assert!((3.0..5.0).contains(&constant), "{row:?}");
    }
    // A method that shortens springs solves another equation. The test claims an order for it, and
    // the claim fails.
    let shortened = smooth.row(&Variant::new("claims an order", "provot"))?;
    assert_eq!((shortened.accepted, shortened.error_constant), (Some(false), None));
    assert_eq!(smooth.row(&Variant::new("provot", "provot"))?.accepted, None);
    let stiff = Setting::new(&CASES[3])?;
    assert!(!stiff.scene.resolved);
    let row = stiff.row(&Variant::new("symplectic-euler", "symplectic-euler"))?;
    assert!(row.runs.iter().all(|run| run.verdict == Verdict::Diverged && run.error.is_none()));
    assert_eq!((row.order, row.accepted, row.error_constant), (None, None, None));
    Ok(())
}

#[test]
fn every_scene_has_its_own_name_and_some_are_quick() {
    assert!(CASES.iter().any(|case| case.is_quick) && !CASES.iter().all(|case| case.is_quick));
    for (n, case) in CASES.iter().enumerate() {
        assert!(CASES[..n].iter().all(|other| other.id != case.id), "{}", case.id);
    }
}

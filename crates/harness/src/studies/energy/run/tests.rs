//! Tests of scenes, energy flows and the findings from them.

use super::super::words::words;
use super::*;
use crate::studies::energy::facts::ALL_IMPLICIT;
use crate::studies::energy::facts::Ledger;
use drape_report::Verdict;
use std::collections::BTreeMap;

fn setting(name: &str, is_damped: bool) -> Setting {
    let case = CASES.into_iter().find(|case| case.name == name).expect("a case");
    Setting::new(&(Case { side: 6, duration: 0.3, ..case }, is_damped)).expect("a scene")
}

#[test]
fn causes_and_excess_add_up_to_the_drift() {
    for (scene, is_damped) in [("hanging-1e4", true), ("sphere-1e4", false)] {
        let setting = setting(scene, is_damped);
        for id in ["imex-euler", "symplectic-euler", "desbrun", "baraff-witkin"] {
            let row = setting.row(&Variant::new(id, id)).expect("a run");
            let (Some(ledger), Some(drift)) = (&row.ledger, row.drift) else {
                panic!("{id} on {scene} is {}", row.verdict)
            };
            assert!((ledger.sum() - drift).abs() < 1e-10, "{id}: {ledger:?}, {drift}");
            assert!(row.closure_defect.is_some_and(|defect| defect < 1e-8), "{id}");
            assert_eq!(ledger.damping < 0.0, is_damped, "{id}: {ledger:?}");
            if !is_damped {
                let excess = row.excess_dissipation.expect("it lasted");
                assert!((excess + drift).abs() < 1e-12, "{id}: nothing is damped");
            }
        }
    }
}

#[test]
fn the_integral_of_the_damping_is_that_of_the_ledger_where_steps_are_short() {
    let row = setting("hanging-1e4", true)
        .row(&Variant::new("leapfrog", "leapfrog:solver=cg"))
        .expect("a run");
    let (ledger, drift) = (row.ledger.expect("a ledger"), row.drift.expect("it lasted"));
    let excess = row.excess_dissipation.expect("it lasted");
    assert!((excess + drift - ledger.damping).abs() < 1e-3 * ledger.damping.abs());
    assert!(ledger.damping < -0.001, "{ledger:?}");
}

#[test]
fn samples_end_where_a_run_leaves_all_bounds_and_it_has_no_ledger() {
    let setting = setting("hanging-1e6", false);
    let row = setting.row(&Variant::new("wild", "explicit-euler")).expect("a run");
    assert!(
        row.verdict == Verdict::Unstable || row.verdict == Verdict::Diverged,
        "{}",
        row.verdict
    );
    assert!(row.energy.len() < setting.scene.time_s.len(), "{}", row.energy.len());
    assert!(row.energy.iter().all(|energy| energy.abs() <= 10.0));
    assert_eq!((row.ledger, row.drift, row.excess_dissipation), (None, None, None));
    let row = setting.row(&Variant::new("calm", "imex-euler")).expect("a run");
    assert_eq!(row.energy.len(), 31, "a sample a step where there are fewer than a hundred");
}

#[test]
fn explicit_methods_divide_the_step_and_damped_explicit_euler_more_than_others() {
    let division = |scene, is_damped, id: &str| {
        let choice = Choice::parse(id, &[]).expect("a method");
        setting(scene, is_damped).division(choice.method())
    };
    assert_eq!(division("hanging-1e4", true, "imex-euler"), 1);
    assert_eq!(division("hanging-1e4", true, "leapfrog"), 8);
    assert_eq!(division("hanging-1e6", true, "leapfrog"), 64);
    assert_eq!(division("hanging-1e6", false, "explicit-euler"), 64);
    assert_eq!(division("hanging-1e6", true, "explicit-euler"), 256);
}

fn ledger(inertia: f64, gap: f64) -> Ledger {
    Ledger {
        damping: -0.25,
        inertia,
        gaps: BTreeMap::from([("tension".to_owned(), gap)]),
        residual: 0.0,
        constraint: 0.0,
        correction: 0.0,
    }
}

fn row(label: &str, ledger: Option<Ledger>) -> Row {
    Row {
        scene: "a damped".to_owned(),
        label: label.to_owned(),
        method: label.to_owned(),
        step_s: 0.01,
        steps: 10,
        verdict: Verdict::Stable,
        energy: vec![0.0],
        drift: Some(-0.5),
        gain: Some(0.0),
        excess_dissipation: Some(0.25),
        closure_defect: ledger.as_ref().map(|_| 1e-12),
        ledger,
        unconverged_steps: 0,
        portable: true,
    }
}

fn facts(rows: Vec<Row>) -> Facts {
    let scene = Scene {
        id: "a damped".to_owned(),
        scene: "a".to_owned(),
        is_damped: true,
        particles: 4,
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 40.0,
        duration_s: 1.0,
        step_s: 0.01,
        reference_energy_j: 1.0,
        start_energy_j: 0.0,
        time_s: vec![0.0],
        portable: true,
    };
    let unattributed = unattributed(&rows);
    Facts { scenes: vec![scene], rows, unattributed }
}

/// The same scene without damping.
fn with_undamped(facts: Facts) -> Facts {
    let undamped =
        Scene { id: "a undamped".to_owned(), is_damped: false, ..facts.scenes[0].clone() };
    let rows = facts.rows.iter().map(|row| Row { scene: undamped.id.clone(), ..row.clone() });
    let rows = rows.collect::<Vec<_>>();
    Facts {
        scenes: vec![undamped, facts.scenes[0].clone()],
        rows: rows.into_iter().chain(facts.rows).collect(),
        unattributed: facts.unattributed,
    }
}

#[test]
fn words_follow_from_the_ledgers() {
    let wild = Row { verdict: Verdict::Unstable, drift: None, ..row("wild", None) };
    let loose = Row {
        ledger: Some(Ledger { residual: 0.125, ..ledger(0.0, 0.001) }),
        ..row("loose", None)
    };
    let eater = Ledger { damping: -0.125, ..ledger(-0.5, -0.125) };
    let rows = vec![
        row("eater", Some(eater)),
        row("giver", Some(ledger(0.5, 0.0))),
        row(ALL_IMPLICIT, Some(ledger(0.0, -0.002))),
        loose,
        row("two-step", None),
        wild,
    ];
    let facts = facts(rows);
    assert_eq!(facts.unattributed, ["two-step"]);
    // The damped scene alone, which a subset may have, supports fewer findings.
    let damped = words(&facts).conclusion;
    assert!(
        damped.starts_with("With damping, the numerical loss replaces physical damping"),
        "{damped}"
    );
    let mut facts = with_undamped(facts);
    let said = words(&facts);
    for part in [
        "the time step of some variants takes at least a tenth",
        "2 variants lose less than 1 % in every scene.",
        "take 12 % with the most dissipative method and 25 % with the least",
    ] {
        assert!(said.conclusion.contains(part), "{part}\n{said:?}");
    }
    let text = said.observations.join("\n") + &said.caveats.join("\n");
    for part in [
        "Every ledger closes: in 6 runs",
        "satisfies its energy theorem",
        "In 2 runs, at least 10 % of E_ref passes through the residual of the solve; \
         the most is 12 % (loose, a damped)",
        "2 of 12 runs gained too much energy",
        "1 variant has no ledger",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    for row in facts.rows.iter_mut().filter(|row| row.label == "loose") {
        row.ledger = Some(ledger(-0.2, 0.0));
    }
    let said = words(&facts).conclusion;
    assert!(said.contains("Only `imex-euler, all springs` loses less"), "{said}");
    let mut broken = facts;
    for row in &mut broken.rows {
        match row.label.as_str() {
            "eater" => row.closure_defect = Some(1e-3),
            ALL_IMPLICIT => row.ledger = Some(ledger(-0.6, 0.5)),
            "giver" => row.ledger = Some(Ledger { damping: 0.0, ..ledger(-0.2, 0.0) }),
            _ => {}
        }
    }
    let said = words(&broken);
    let text = said.observations.join("\n");
    assert!(text.contains("In 2 of 6 runs the ledger does not close"), "{text}");
    assert!(text.contains("violates its energy theorem"), "{text}");
    assert!(said.conclusion.contains("No variant stays within"), "{said:?}");
}

#[test]
fn only_the_verdict_of_what_is_not_portable_is_compared() {
    let elsewhere = Row { portable: false, ..row("elsewhere", Some(ledger(0.0, 0.0))) };
    let facts = comparable(&facts(vec![row("here", Some(ledger(0.0, 0.0))), elsewhere]));
    assert_eq!(facts.len(), 3);
    assert!(facts[1].values.get("ledger").is_some());
    let keys: Vec<_> = facts[2].values.as_object().expect("an object").keys().collect();
    assert_eq!(keys, ["method", "verdict"]);
}

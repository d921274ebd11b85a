//! Tests of each branch of the words, with small facts.

use super::*;

fn spring(direction: &str, speed: f64) -> Spring {
    Spring {
        label: IMEX_EULER.to_owned(),
        method: IMEX_EULER.to_owned(),
        direction: direction.to_owned(),
        theta: 10.0,
        step_s: 0.01,
        steps: 100,
        load_m_s2: 1e-3,
        speed_m_s: speed,
        law_m_s: 1e-6,
        recurrence_error: Some(1e-14),
        free_m_s: 1e-3,
        portable: true,
    }
}

fn run(label: &str, stiffness: f64, retained: f64) -> Run {
    Run {
        label: label.to_owned(),
        method: label.to_owned(),
        stiffness_over_mass_per_s2: stiffness,
        step_s: BASE_STEP,
        path_m: Some(retained),
        retained: Some(retained),
        retained_beside_backward_euler: None,
        retained_fall: None,
        height_m: None,
        prototype_path_m: None,
        late_speed_m_s: Some(1.0),
        law_m_s: 1.0,
        verdict: if retained < 0.5 { Verdict::Locked } else { Verdict::Stable },
        gain: 0.0,
        unconverged_steps: 0,
        portable: true,
    }
}

fn facts(runs: Vec<Run>, springs: Vec<Spring>) -> Facts {
    Facts { sheets: Vec::new(), runs, springs }
}

fn observed(facts: &Facts) -> String {
    words(facts).observations.join("\n")
}

#[test]
fn no_facts_still_conclude_something() {
    let words = words(&facts(Vec::new(), Vec::new()));
    assert!(words.conclusion.contains("no run") && words.observations.is_empty());
    assert!(words.caveats.is_empty());
}

#[test]
fn the_conclusion_says_who_stands_still_who_moves_and_whether_the_law_holds() {
    let runs = |implicit, law_m_s| {
        let plain = Run { law_m_s, ..run(IMEX_EULER, BASE_STIFFNESS, 0.08) };
        vec![plain, run(UPDATED, 1e6, 0.95), run(BACKWARD_EULER, 1e6, implicit)]
    };
    let said = words(&facts(runs(0.951, 1.001), Vec::new())).conclusion;
    for part in [
        "At k/m = 10⁶ s⁻² and h = 0.01 s, IMEX Euler is stable but keeps only 8.0 % of the motion",
        "it keeps 95 %, as much as backward Euler.",
        "falls at the speed of the law of locking, within 0.10 %",
    ] {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    let said = words(&facts(runs(0.7, 2.0), Vec::new())).conclusion;
    assert!(said.contains("keeps 95 %; backward Euler keeps 70 %"), "{said}");
    assert!(said.contains("at 0.500 times the speed of"), "{said}");
    let moving = words(&facts(vec![run(IMEX_EULER, BASE_STIFFNESS, 0.9)], Vec::new()));
    assert!(moving.conclusion.ends_with("IMEX Euler keeps 90 % of the motion of the cloth."));
    assert!(!moving.caveats.join(" ").contains("flat sheet"));
}

#[test]
fn observations_count_who_locks_and_ask_whether_damping_explains_it() {
    let locked = || run(IMEX_EULER, BASE_STIFFNESS, 0.08);
    let shorter = Run { step_s: 0.001, ..run(IMEX_EULER, BASE_STIFFNESS, 0.7) };
    let with = |implicit, shorter: Run| {
        let soft = run("other", 1e5, 0.4);
        facts(vec![locked(), shorter, soft, run(BACKWARD_EULER, 1e6, implicit)], Vec::new())
    };
    let said = observed(&with(0.95, shorter.clone()));
    assert!(said.contains("2 of 3 variants") && said.contains("first at k/m = 10⁵ s⁻²"), "{said}");
    assert!(said.contains("does not explain the loss: backward Euler keeps at least 95 %"));
    assert!(said.contains("keeps half of the motion up to h = 0.001 s"), "{said}");
    let still = Run { verdict: Verdict::Locked, ..shorter };
    let said = observed(&with(0.4, still));
    assert!(said.contains("may explain the loss"), "{said}");
    assert!(said.contains("keeps half of the motion at no step"), "{said}");
}

#[test]
fn the_observation_on_directions_follows_the_difference() {
    let springs =
        |speed| facts(Vec::new(), vec![spring("along x", 1e-6), spring("oblique", speed)]);
    assert!(observed(&springs(1e-6)).contains("locks like an oblique one, within 0:"));
    assert!(observed(&springs(2e-6)).contains("lock differently, by up to 1.0."));
    assert!(!observed(&facts(Vec::new(), vec![spring("along x", 1e-6)])).contains("oblique"));
}

#[test]
fn a_missed_recurrence_is_told() {
    assert!(observed(&facts(Vec::new(), vec![spring("along x", 1e-6)])).contains("spring meets"));
    let off = Spring { recurrence_error: Some(1e-3), ..spring("along x", 1e-6) };
    assert!(observed(&facts(Vec::new(), vec![off])).contains("misses its exact recurrence"));
}

#[test]
fn caveats_name_the_prototype_the_unstable_runs_and_the_reference() {
    let beside = |path| Run { prototype_path_m: Some(path), ..run("a", 1e4, 1.0) };
    let unstable = Run { verdict: Verdict::Unstable, ..run("b", 1e4, 9.0) };
    let sheet = Sheet {
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 40.0,
        side: 20,
        path_m: 2.0,
        path_error_m: 0.02,
        half_fall_s: 0.5,
        reference_step_s: 1e-4,
        lever: 341.0,
        swing_lever: 162.0,
        portable: true,
    };
    let runs = vec![beside(1.001), beside(2.0), unstable];
    let facts = Facts { sheets: vec![sheet], ..facts(runs, Vec::new()) };
    let said = words(&facts).caveats.join("\n");
    assert!(said.contains("agrees in 1 of 2 paths"), "{said}");
    assert!(
        said.contains("1 of 3 runs was not stable") && said.contains("at most 1.0 %"),
        "{said}"
    );
}

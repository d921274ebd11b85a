//! Tests of each branch of the words, with small facts.
#![allow(clippy::unwrap_used, reason = "tests")]

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

fn scene(id: &str, stiffness_over_mass_per_s2: f64) -> Scene {
    Scene {
        id: id.to_owned(),
        particles: 400,
        stiffness_over_mass_per_s2,
        spin_per_s: [2.0, 0.0, 0.0],
        gravity_m_s2: [0.0; 3],
        duration_s: 1.0,
        step_s: 0.01,
        greatest_frequency_per_s: 300.0,
        mass_kg: 0.4,
        size_m: 1.4,
        speed_m_s: 1.0,
        time_s: vec![0.0, 1.0],
        portable: true,
    }
}

fn sheets() -> Vec<Scene> {
    vec![scene("spin-1e4", 1e4), scene("spin-1e6", 1e6)]
}

#[test]
fn no_facts_still_conclude_something() {
    let words = words(&Facts { scenes: Vec::new(), rows: Vec::new() });
    assert!(words.conclusion.contains("no method") && words.observations.is_empty());
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
    let found = drifts(&facts, LINEAR, true);
    assert_eq!(found, [("leaky", 0.5, "fall-1e6"), ("tight", 1e-15, "fall-1e4")]);
    assert_eq!(drifts(&facts, LINEAR, false), [("leaky", 2.0, "spin-1e4")]);
    let words = words(&facts);
    assert!(words.conclusion.starts_with("1 of 2 claims"), "{}", words.conclusion);
    assert!(words.conclusion.contains("leaky drifts by 0.500 (fall-1e6)"));
    let said = words.observations.join("\n");
    assert!(
        said.contains("Of 1 variant that does not claim")
            && said.contains("leaky by 2.00 (spin-1e4)"),
        "{said}"
    );
}

#[test]
fn a_broken_statement_on_angular_momentum_is_told() {
    let stating = |drift| Row {
        states_angular_momentum: true,
        angular_momentum_drift: Some(drift),
        ..row("spin-1e4", "turning")
    };
    let said = |drift| words(&Facts { scenes: Vec::new(), rows: vec![stating(drift)] }).conclusion;
    assert!(said(1e-12).starts_with("All 2 claims") && said(1e-12).contains("within 10⁻⁹"));
    assert!(said(0.5).starts_with("1 of 2 claims") && said(0.5).contains("turning drifts by"));
}

#[test]
fn words_and_tables_tell_what_is_lost_what_holds_and_what_fails() {
    let left = |scene, label, spin| Row { final_spin: Some(spin), ..row(scene, label) };
    let [none, literal, consistent] = CORRECTIONS;
    let facts = Facts {
        scenes: sheets(),
        rows: vec![
            left("spin-1e4", "keeper", 1.004),
            left("spin-1e4", none, 0.053),
            left("spin-1e4", literal, 0.152),
            left("spin-1e4", consistent, 1.0),
            left("spin-1e6", "keeper", 1.004),
            left("spin-1e6", "loser", 0.001),
            Row { energy_gain: Some(0.25), step_s: 0.001, ..row("spin-1e6", "pump") },
            Row { law: Some(0.75), ..left("pair-1e4", "lawful", 0.5) },
            Row { law: Some(0.5), ..left("pair-1e4", "better", 0.5) },
            unstable_row("spin-1e6", "wild"),
            unstable_row("spin-1e4", "wild"),
        ],
    };
    let words = words(&facts);
    let said = words.conclusion;
    assert!(said.contains("hold within 10⁻⁹"), "{said}");
    assert!(said.contains("At k/m = 10⁶ s⁻², 2 of 3 stable variants keep"), "{said}");
    assert!(said.contains("and 1 keeps less than 1 % of it"), "{said}");
    let said = words.observations.join("\n");
    for part in [
        "5.3 % of the spin without correction, 15 % with the printed one and 100 % with a \
         consistent",
        "1 of 9 stable runs gains more than 1 % of the energy of the spin, at most 25 %",
        "in 1 of 2 runs; the greatest difference is 0.25.",
        "2 of 11 runs diverged",
    ] {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    let said = words.caveats.join("\n");
    assert!(said.contains("confirms 2 of 3 values of Desbrun's method"), "{said}");
    assert!(said.contains("1 explicit variant takes shorter steps"), "{said}");

    let input = super::super::plates::Input { facts, timings: None };
    let tables = super::super::plates::tables(&input);
    let find = |title: &str| tables.iter().find(|table| table.title.contains(title)).unwrap();
    let line = |title: &str, n: usize| find(title).rows[n].join("; ");
    assert!(line("prototype", 1).ends_with("0.152; 0.15; yes"), "{}", line("prototype", 1));
    assert!(line("prototype", 2).ends_with("1.00; 0.96; no"), "{}", line("prototype", 2));
    assert_eq!(line("gain more than", 0), "pump; spinning sheet, k/m = 10⁶ s⁻²; 25.0; 1.00");
    let spins: Vec<_> = find("Spin that is left").rows.iter().map(|row| row[0].as_str()).collect();
    let place = |label| spins.iter().position(|spin| *spin == label).unwrap();
    assert!(place("keeper") < place("loser") && place("loser") < place("wild"), "{spins:?}");
}

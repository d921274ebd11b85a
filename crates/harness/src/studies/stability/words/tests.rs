//! Tests of each branch of the words, with small facts.

use super::super::facts::Shear;
use super::*;

fn cell(label: &str, verdict: Verdict) -> Cell {
    Cell {
        label: label.to_owned(),
        method: label.to_owned(),
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 0.0,
        step_s: 0.01,
        verdict,
        starts: 1,
        gain: 0.0,
        drift: 0.0,
        reach: None,
        reached_s: 2.0,
        portable: true,
    }
}

fn limit(scene: &str, theory_s: Option<f64>, measured_s: Option<f64>) -> Limit {
    Limit {
        scene: scene.to_owned(),
        label: "a".to_owned(),
        method: "a".to_owned(),
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 0.0,
        largest_eigenvalue_per_s2: 8e4,
        rule: String::new(),
        theory_s,
        visible_s: None,
        measured_s,
        is_unlimited: false,
        range_s: [1e-4, 8.0],
        runs: 1,
        portable: true,
    }
}

fn facts(cells: Vec<Cell>, limits: Vec<Limit>) -> Facts {
    Facts { cells, limits, shear: Vec::new() }
}

#[test]
fn no_facts_still_conclude_something() {
    let words = words(&facts(Vec::new(), Vec::new()));
    assert!(words.conclusion.contains("no cell") && words.observations.is_empty());
}

#[test]
fn a_locked_cell_is_neither_a_gain_nor_a_success() {
    let cells = vec![
        cell("a", Verdict::Locked),
        cell("a", Verdict::Locked),
        cell("a", Verdict::Stable),
        cell("b", Verdict::Marginal),
        cell("c", Verdict::OverBudget),
        Cell { starts: 0, ..cell("d", Verdict::OverBudget) },
        cell("d", Verdict::Stable),
    ];
    let words = words(&facts(cells, Vec::new()));
    let said = words.conclusion;
    assert!(said.contains("2 of 3 variants never gained energy: `a` and `d`."), "{said}");
    assert!(said.contains("with `a`, more than half of the cells"), "{said}");
    let observed = &words.observations[0];
    assert!(observed.contains("2 of 7 cells are over budget"), "{observed}");
    assert!(
        observed.ends_with("1 of them did not run, since a longer step was over budget already.")
    );
    let failing = facts(vec![cell("b", Verdict::Diverged)], Vec::new());
    let said = super::words(&failing).conclusion;
    assert!(
        said.contains("None of 1 variant stays free of energy gain") && !said.contains("locked"),
        "{said}"
    );
    let many = ["a", "b", "c", "d", "e", "f"].map(|label| cell(label, Verdict::Stable));
    let said = super::words(&facts(many.into(), Vec::new())).conclusion;
    assert!(said.contains("6 of 6 variants never gained energy."), "{said}");
}

#[test]
fn two_particles_agree_with_theory_are_loose_or_contradict_it() {
    let unlimited = Limit { is_unlimited: true, ..limit("pair", None, Some(8.0)) };
    let slow = Limit { visible_s: Some(4e-4), ..limit("pair", Some(0.0), Some(3.9e-4)) };
    let never = limit("pair", Some(0.0), None);
    let mut limits = vec![unlimited, slow.clone(), never, limit("pair", Some(0.01), Some(0.0097))];
    let said = words(&facts(Vec::new(), limits.clone())).conclusion;
    assert!(said.contains("agrees with theory in 4 of 4 cases."), "{said}");
    let loose = "imex-euler:forcing_term=0.05".to_owned();
    limits.push(Limit { method: loose.clone(), ..limit("pair", None, None) });
    let said = words(&facts(Vec::new(), limits.clone())).conclusion;
    assert!(said.contains("in 4 of 5 cases; in 1 the solver tolerance is too large"), "{said}");
    limits.push(limit("pair", Some(0.01), Some(0.02)));
    limits.push(limit("pair", Some(0.01), None));
    limits.push(limit("pair", None, None));
    limits.push(Limit { measured_s: Some(1.0), ..slow });
    limits.push(Limit { method: loose, ..limit("pair", Some(0.01), None) });
    let said = words(&facts(Vec::new(), limits)).conclusion;
    assert!(
        said.contains("in 4 of 10 cases; in 1 the solver tolerance")
            && said.contains("; in 5 it contradicts theory.")
    );
}

#[test]
fn a_broken_theorem_is_told() {
    let with = |gain| facts(vec![Cell { gain, ..cell(EXACT, Verdict::Stable) }], Vec::new());
    let holds = words(&with(0.0)).observations.join("\n");
    assert!(holds.contains("solved tightly, holds"), "{holds}");
    let broken = words(&with(0.01)).observations.join("\n");
    assert!(broken.contains("is broken: the energy rises by at most 0.0100 of E_ref"), "{broken}");
}

#[test]
fn the_sheet_and_explicit_shear_stand_beside_their_bounds() {
    let scan = |step_s, bound, first_failure| Shear {
        label: "mixed".to_owned(),
        method: String::new(),
        stiffness_over_mass_per_s2: 1e6,
        step_s,
        bound,
        start_bound: None,
        first_failure,
        ratios: Vec::new(),
        portable: true,
    };
    let limits = vec![limit("sheet", Some(0.01), Some(0.012)), limit("sheet", Some(0.01), None)];
    let shear = vec![scan(0.001, 1.0, Some(4.0)), scan(0.1, 0.6, Some(0.5)), scan(1.0, 0.5, None)];
    let said = words(&Facts { shear, ..facts(Vec::new(), limits) }).observations.join("\n");
    assert!(
        said.contains("1 of 2 longest stable steps reach")
            && said.contains("shortest is 0 times as long")
    );
    assert!(said.contains("in 2 of 3 scans"), "{said}");
    let steps = "k_s/k on: mixed, 4 at h = 0.001 s and 0.5 at h = 0.1 s.";
    assert!(said.contains(steps), "{said}");
}

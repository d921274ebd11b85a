//! Tests of each branch of the words, with small facts.

use super::*;

fn cell(variant: &str, k: f64, cg_per_step: f64) -> Cell {
    Cell {
        series: STIFFNESS.to_owned(),
        material: "fixed-k-over-m".to_owned(),
        particles: 400,
        stiffness_over_mass_per_s2: k,
        step_s: BASE_STEP_S,
        theta: 1.0,
        variant: variant.to_owned(),
        preconditioner: BASE_PRECONDITIONER.to_owned(),
        start: if variant == UPDATED_ROBUST { "best" } else { BASE_START }.to_owned(),
        forcing_term: FORCING_TERM,
        method: String::new(),
        steps: 100,
        cg_iterations: (100.0 * cg_per_step) as u64,
        cg_per_step,
        outer_passes: 0,
        newton_iterations: 0,
        idle_steps: 92,
        unconverged_steps: 0,
        energy_gain_j: 0.0,
        energy_climb: 0.0,
        verdict: Verdict::Stable,
        portable: true,
    }
}

fn fall(label: &str, k: f64, fall_m: f64, verdict: Verdict) -> Motion {
    Motion {
        stiffness_over_mass_per_s2: k,
        step_s: BASE_STEP_S,
        label: label.to_owned(),
        method: String::new(),
        fall_m,
        unconverged_steps: 0,
        energy_gain_j: 58.0,
        verdict,
        portable: true,
    }
}

#[test]
fn no_facts_still_conclude_something() {
    let words = words(&Facts { cells: Vec::new(), motion: Vec::new() });
    assert!(words.conclusion.contains("no count"), "{}", words.conclusion);
    assert!(words.observations.is_empty());
}

#[test]
fn the_conclusion_says_whether_the_sheet_that_needs_few_iterations_moves() {
    let facts = |plain, updated| Facts {
        cells: vec![cell(PLAIN, 1e4, 0.5), cell(PLAIN, 1e6, 4.55)],
        motion: vec![
            fall(PLAIN_MOTION, 1e6, plain, Verdict::Stable),
            fall(UPDATED_MOTION, 1e6, updated, Verdict::Stable),
            fall(IMPLICIT, 1e6, -0.4, Verdict::Stable),
        ],
    };
    let still = words(&facts(-0.08, -0.4)).conclusion;
    for part in [
        "From k/m = 10⁴ to 10⁶ s⁻²",
        "at most 4.55 CG iterations",
        "mean success: at k/m = 10⁶ s⁻² its sheet falls only 20 % as far",
        "it falls as far as with backward Euler, within 0 %",
    ] {
        assert!(still.contains(part), "`{part}` is not in\n{still}");
    }
    let moving = words(&facts(-0.36, -0.3)).conclusion;
    assert!(moving.contains("falls at least 90 % as far"), "{moving}");
    assert!(
        moving.contains("it falls differently, by up to") && moving.contains("25 %"),
        "{moving}"
    );
}

#[test]
fn observations_count_the_runs_that_gain_energy() {
    let gaining = |cell: Cell| Cell { verdict: Verdict::Unstable, energy_gain_j: 2.0, ..cell };
    let other = |preconditioner: &str, start: &str, count| Cell {
        preconditioner: preconditioner.to_owned(),
        start: start.to_owned(),
        ..cell(PLAIN, 1e4, count)
    };
    let newton = Cell { newton_iterations: 7, ..cell(UPDATED_ROBUST, 1e4, 0.0) };
    let step = |h, cg_iterations| Cell {
        series: STEP.to_owned(),
        step_s: h,
        cg_iterations,
        ..cell(PLAIN, 1e6, 1.0)
    };
    let facts = Facts {
        cells: vec![
            gaining(cell(PLAIN, 1e4, 0.5)),
            cell(PLAIN, 1e6, 1.0),
            other("none", BASE_START, 3.0),
            other(BASE_PRECONDITIONER, "last", 2.0),
            cell(UPDATED_PAPER, 1e4, 1.0),
            gaining(cell(UPDATED_PAPER, 1e6, 1.0)),
            newton,
            step(0.001, 593),
            step(0.05, 102),
        ],
        motion: vec![
            fall(TENSION_ONLY, 1e4, -0.4, Verdict::Stable),
            fall(TENSION_ONLY, 1e6, -0.1, Verdict::Unstable),
        ],
    };
    let words = words(&facts);
    let said = words.observations.join("\n");
    for part in [
        "up to 6.0 times as many iterations",
        "saves iterations in 1 of 1 cases",
        "1 of 4 runs of plain CG gains energy, all of them with the extrapolated start",
        "92 of 100 steps take no iteration",
        "as printed gains energy in 1 of 2 runs; safeguarded, in 0 of 1, with 7 Newton iterations",
        "gains energy at 1 of 2 stiffnesses, the softest at k/m = 10⁶ s⁻²",
        "the fewest iterations with h = 0.05 s (102) and the most with h = 0.001 s (593)",
    ] {
        assert!(said.contains(part), "`{part}` is not in\n{said}");
    }
    assert_eq!(words.observations.len(), 5);
    let caveats = words.caveats.join("\n");
    assert!(caveats.contains("ran up to k/m = 10⁴ s⁻² only"), "{caveats}");
}

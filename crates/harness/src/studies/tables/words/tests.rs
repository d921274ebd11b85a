//! Tests of each branch of the words, with small facts.
#![allow(clippy::unwrap_used, reason = "tests")]

use super::*;

fn cell(variant: &str, forcing_term: f64, cg_iterations: u64) -> Cell {
    Cell {
        variant: variant.to_owned(),
        method: String::new(),
        forcing_term,
        cg_iterations,
        outer_passes: 0,
        newton_iterations: 0,
        matvecs: 0,
        unconverged_steps: 0,
        energy_gain_j: 0.0,
        energy_climb: 0.0,
        verdict: Verdict::Stable,
        portable: true,
    }
}

/// A row whose paper count is 100 iterations, with runs of each variant at two values of ε.
fn row(row: u32, assumed_reading: bool, k: f64, counts: [[u64; 2]; 2]) -> Row {
    let cells: Vec<_> = [PLAIN, UPDATED_PAPER]
        .into_iter()
        .zip(counts)
        .flat_map(|(variant, [loose, tight])| {
            [cell(variant, 0.1, loose), cell(variant, 0.01, tight)]
        })
        .collect();
    let fit = |variant: &str| {
        let off = |cell: &&Cell| cell.cg_iterations.abs_diff(100);
        let cell = cells.iter().filter(|cell| cell.variant == variant).min_by_key(off).unwrap();
        BestFit {
            variant: variant.to_owned(),
            forcing_term: cell.forcing_term,
            cg_iterations: cell.cg_iterations,
            ratio: cell.cg_iterations as f64 / 100.0,
        }
    };
    Row {
        id: String::new(),
        table: 2,
        row,
        scene: String::new(),
        particles: 400,
        stiffness_over_mass_per_s2: k,
        assumed_reading,
        damping_over_mass_per_s: 40.0,
        step_s: 0.01,
        paper: PaperRow { cg_iterations: 100, cg_s: 1.0, matrix_setup_s: 1.0, solver_s: 3.0 },
        best_fit: vec![fit(PLAIN), fit(UPDATED_PAPER)],
        cells,
    }
}

fn said(rows: Vec<Row>) -> (String, String) {
    let words = words(&Facts { rows });
    (words.conclusion, words.observations.join("\n"))
}

#[test]
fn no_rows_still_conclude_something() {
    let (conclusion, observations) = said(Vec::new());
    assert!(conclusion.contains("no row") && observations.is_empty(), "{conclusion}");
}

#[test]
fn one_tolerance_fits_all_rows_or_none_does() {
    let (fits, observed) = said(vec![row(1, true, 1e4, [[110, 300], [50, 40]])]);
    assert!(fits.contains("A single ε, 0.1, repeats all") && fits.contains("1.10"), "{fits}");
    assert!(fits.contains("within 25 % in 1 of 1 rows"), "{fits}");
    assert!(!fits.contains("exponents"), "one reading was run: {fits}");
    assert!(
        observed
            .contains("within 25 % of the paper's count in 1 row, and updated CG as printed in 0")
    );
    assert!(observed.contains("No run of these rows gains energy"), "{observed}");
    let second = row(2, true, 1e6, [[300, 100], [50, 40]]);
    let (none, _) = said(vec![row(1, true, 1e4, [[110, 300], [50, 40]]), second]);
    assert!(none.contains("No single ε repeats all") && none.contains("up to 2.00"), "{none}");
    assert!(none.contains("in 2 of 2 rows"), "{none}");
}

#[test]
fn a_fit_by_an_unstable_run_does_not_count() {
    let mut unstable = row(1, true, 1e4, [[110, 300], [50, 40]]);
    unstable.cells[0].verdict = Verdict::Unstable;
    let (conclusion, observed) = said(vec![unstable]);
    assert!(conclusion.contains("in 0 of 1 rows"), "{conclusion}");
    assert!(observed.contains("1 of 4 runs gains energy, 0 of them with updated CG as printed"));
}

#[test]
fn the_nearest_reading_decides_only_if_it_is_the_one_that_is_taken() {
    let taken = row(1, true, 1e4, [[110, 300], [90, 40]]);
    let far = row(1, false, 1e5, [[400, 300], [400, 300]]);
    let (favoured, observed) = said(vec![taken.clone(), far]);
    assert!(favoured.contains("suggest that the illegible exponents are 4 and 6"), "{favoured}");
    assert!(observed.contains("in 2 of 2 cases"), "{observed}");
    let near = row(1, false, 1e5, [[100, 300], [400, 300]]);
    let (open, observed) = said(vec![taken, near]);
    assert!(open.contains("do not decide whether the illegible exponents are 4 and 6"), "{open}");
    assert!(observed.contains("in 1 of 2 cases"), "{observed}");
}

#[test]
fn what_a_verdict_or_a_cap_hides_is_told() {
    let mut troubled = row(1, true, 1e4, [[110, 300], [50, 40]]);
    troubled.cells[0].energy_climb = 0.28;
    troubled.cells[1].unconverged_steps = 39;
    let (_, observed) = said(vec![troubled]);
    assert!(
        observed.contains(
            "1 run called stable loses energy and gains it again, by up to 28 % of the released"
        ),
        "{observed}"
    );
    assert!(
        observed.contains("1 run has solves that stop before their tolerance, in up to 39 steps"),
        "{observed}"
    );
}

use super::super::words::words;
use super::*;
use crate::studies::solver_control::facts::PLAIN;
use drape_report::Verdict;

#[test]
fn every_cell_is_a_method_with_settings_it_takes_and_has_a_key_of_its_own() {
    for case in CASES {
        let cells = all(&case);
        for (n, cell) in cells.iter().enumerate() {
            let choice = Choice::parse(&cell.method, &[]).unwrap_or_else(|error| panic!("{error}"));
            assert!(choice.build().is_ok(), "{}", cell.method);
            let key = |c: &Cell| (c.series, c.label, c.is_adaptive, c.value.map(f64::to_bits));
            assert!(cells[..n].iter().all(|other| key(other) != key(cell)), "{cell:?}");
        }
        assert_eq!(cells.iter().any(|cell| cell.is_quick), case.id == runs::QUICK_SCENE);
    }
}

fn measured(label: &str, is_adaptive: bool, value: f64, error: f64, substeps: u64) -> Run {
    Run {
        series: "steps".to_owned(),
        scene: "hanging-1e4".to_owned(),
        label: label.to_owned(),
        is_adaptive,
        value: Some(value),
        method: label.to_owned(),
        step_s: 0.01,
        error: Some(error),
        energy_gain_j: 0.0,
        substeps,
        rejected: 0,
        setups: 1,
        factorisations: 0,
        newton_iterations: 0,
        outer_passes: 0,
        cg_iterations: 0,
        matvecs: 0,
        force_evaluations: 2 * substeps,
        work_sweeps: 30 + 2 * substeps,
        unconverged_steps: 0,
        verdict: Verdict::Completed,
        portable: false,
    }
}

#[test]
fn words_follow_from_the_facts() {
    let scene = Scene {
        id: "hanging-1e4".to_owned(),
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 40.0,
        span_s: SPAN,
        reference_error_m: 1e-9,
        portable: false,
    };
    let runs = vec![
        measured("imex-euler", false, 0.01, 0.2, 25),
        measured("imex-euler", false, 0.005, 0.1, 50),
        measured("imex-euler", true, 1e-2, 0.15, 40),
        measured(PLAIN, true, 1e-2, 0.5, 25),
    ];
    let facts = Facts { scenes: vec![scene], runs, histories: Vec::new() };
    let said = words(&facts);
    // The adaptive run takes 30 + 80 sweeps, the constant step that is at least as accurate 30 +
    // 100.
    let saves = "mostly save work: 1 of 1 adaptive runs do less work than a constant step with at \
                 most their error; the best saves 15 %";
    assert!(said.conclusion.contains(saves), "{said:?}");
    let text = said.observations.join("\n");
    let reduces =
        "reduces the error of IMEX Euler: it changes from 0.500 to 0.150, with 40 instead of 25";
    assert!(text.contains(reduces), "{text}");
    let mut dear = facts.clone();
    dear.runs[2].work_sweeps = 1000;
    dear.runs[2].error = Some(0.6);
    let said = words(&dear);
    assert!(said.conclusion.starts_with("Adaptive steps never save work: 0 of 1"), "{said:?}");
    assert!(said.observations.join(" ").contains("does not reduce the error"), "{said:?}");
    dear.runs.truncate(1);
    assert_eq!(words(&dear).conclusion, "No two runs can be compared.");
}

#[test]
fn words_compare_forcing_terms_factors_and_preconditioners() {
    let scene = Scene {
        id: "hanging-1e4".to_owned(),
        stiffness_over_mass_per_s2: 1e4,
        damping_over_mass_per_s: 40.0,
        span_s: SPAN,
        reference_error_m: 1e-9,
        portable: false,
    };
    let run =
        |series: &str, label: &str, value: Option<f64>, cg_iterations: u64, work_sweeps: u64| Run {
            series: series.to_owned(),
            value,
            cg_iterations,
            work_sweeps,
            ..measured(label, false, 0.0, 0.1, 25)
        };
    let mut facts = Facts {
        scenes: vec![scene],
        runs: vec![
            run("forcing", "newton", Some(0.5), 40, 0),
            run("forcing", "newton", Some(0.1), 20, 0),
            run("forcing", "newton", None, 15, 0),
            run("forcing", "linear", Some(0.5), 5, 0),
            run("forcing", "linear", Some(1e-6), 50, 0),
            run("forcing", "updated, to the end", None, 10, 0),
            run("forcing", "updated, Eisenstat-Walker", None, 8, 0),
            run("jacobian", "newton: fresh, Cholesky", None, 0, 100),
            run("jacobian", "newton: saved, Cholesky", None, 0, 25),
            run("preconditioner", "none", None, 100, 0),
            run("preconditioner", "jacobi", None, 90, 0),
            run("preconditioner", "ic0", None, 30, 0),
        ],
        histories: Vec::new(),
    };
    facts.runs[3].energy_gain_j = 1.0;
    let said = words(&facts);
    let walker = "forcing terms take 0.75 times the CG iterations of the best constant one";
    assert!(said.conclusion.contains(walker), "{said:?}");
    let text = said.observations.join("\n");
    for part in [
        "Runs with saved factors do 0.25 times the work",
        "IC(0) takes 0.30 times the CG iterations of a run without a preconditioner, and Jacobi takes \
         0.90 times.",
        "terms take 0.80 times the CG iterations of full solves",
        "linear at ε = 0.5 gains energy in 1 of 1 scenes; ε = 10⁻⁶ takes up to 10 times",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(said.caveats[0].starts_with("Every Newton run reaches the same residual"), "{said:?}");
    facts.runs[1].unconverged_steps = 1;
    assert!(words(&facts).caveats[0].starts_with("Not every Newton run"), "{said:?}");
}

/// On a stiff sheet, the estimator that measures the splitting takes smaller steps and has a
/// smaller error.
#[test]
fn the_splitting_estimate_sees_the_locking_that_positions_do_not_show() {
    let sheet = Sheet {
        side: 8,
        tension: 1e6,
        shear: 1e5,
        damping: 40.0,
        law: DampingLaw::Full,
        gravity: GRAVITY,
        is_pinned: true,
    };
    let (system, state) = sheet.spec().and_then(|spec| Ok(spec.build()?)).expect("valid");
    let settings = AdaptiveSettings { tolerance: 1e-9, ..AdaptiveSettings::default() };
    let exact = reference(&system, &state, &[0.1], settings).expect("no contact");
    let run = |estimator: &str| {
        let method = format!("imex-euler:implicit=springs,tolerance=1e-3,estimator={estimator}");
        let choice = Choice::parse(&method, &[]).expect("known");
        let mut simulation = Simulation { system: system.clone(), state: state.clone() };
        let time = TimeSpan { step_s: 0.01, duration_s: 0.1 };
        let outcome = Runner::new(&choice, time).go(&mut simulation).expect("runs");
        let error = position_error(&system, &state.x, &exact.states[0].x, &simulation.state.x);
        (outcome.substeps, error)
    };
    let ((few, blind), (many, seen)) = (run("plain"), run("splitting"));
    assert!(many > few + few / 5 && seen < 0.95 * blind, "{few}, {blind}; {many}, {seen}");
}

#[test]
fn work_is_that_of_the_solver() {
    let totals = Totals {
        force_evaluations: 25,
        matvecs: 28,
        cg_iterations: 7,
        newton_iterations: 3,
        setups: 1,
        ..Totals::default()
    };
    let of = |id: &str| work(&Choice::parse(id, &[]).expect("known"), &totals);
    // The work of CG on the scalar matrix consists of its products.
    assert_eq!(of("imex-euler"), 25 + 2 * 28 + 30);
    let newton = 25 + 6 * 28 + 30;
    assert_eq!(of("backward-euler:solver=cholesky"), newton + 3 * 18);
    assert_eq!(of("backward-euler:jacobian=saved"), newton + 3 * 18);
    for by_products in ["backward-euler", "bdf2:solver=cg", "dirk:solver=multigrid"] {
        assert_eq!(of(by_products), newton, "{by_products}");
    }
    assert_eq!(of("backward-euler:solver=cg,jacobian=saved"), newton + 7 * 18);
}

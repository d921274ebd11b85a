//! Tests of counts on a small system, of rebuilds by cause, and of the findings.

use super::super::facts::crossover;
use super::super::words::words;
use super::system::solver;
use super::*;
use crate::studies::precomputed_inverse::facts::{CG, CHOLESKY, Change, DENSE, Solver};

fn case(solver: &'static str) -> Case {
    Case { side: 5, solver, series: "any", stiffness: 1e4 }
}

#[test]
fn the_solvers_agree_and_keep_what_they_say() {
    let rows = [DENSE, CHOLESKY, CG].map(|name| solver(&case(name)).expect("runs"));
    // The sheet has 25 particles, 40 structural and 32 diagonal springs.
    for row in &rows {
        assert_eq!((row.particles, row.matrix_nonzeros), (25, 25 + 2 * 72));
        assert!(row.disagreement < 1e-11, "{row:?}");
    }
    let [dense, sparse, cg] = rows;
    assert_eq!(dense.kept_nonzeros, 625);
    assert!(dense.kept_bytes >= 2 * 8 * 625);
    assert_eq!(cg.kept_nonzeros, 25 + 72, "no fill");
    assert!(sparse.kept_nonzeros > cg.kept_nonzeros && sparse.kept_nonzeros < 325);
    assert!(cg.cg_per_step > 0.0 && dense.cg_per_step == 0.0);
}

#[test]
fn changes_cause_one_rebuild_each_and_answers_are_those_of_a_fresh_start() {
    for (name, method) in changes::METHODS {
        let run = changes::change(name, method).expect("runs");
        // There are two lasting changes of the step and ten alternating ones, of which the first is
        // a change too.
        assert_eq!((run.first, run.stiffness, run.constraints), (1, 3, 2), "{run:?}");
        assert_eq!(run.step_size, 2 + 10, "{run:?}");
        assert!(run.distance_to_fresh_m.iter().all(|d| *d < 1e-9), "{run:?}");
        assert_eq!(run.distance_to_fresh_m.len(), run.changed.len());
    }
}

fn row(particles: usize, solver: &str, solve_operations: f64) -> Solver {
    Solver {
        particles,
        solver: solver.to_owned(),
        series: "any".to_owned(),
        stiffness_over_mass_per_s2: 1e4,
        matrix_nonzeros: 5,
        kept_nonzeros: 5,
        kept_bytes: 60,
        setup_operations: 100.0 * solve_operations,
        solve_operations,
        cg_per_step: 2.0,
        disagreement: 1e-12,
        portable: false,
    }
}

#[test]
fn the_crossover_is_where_the_advantage_begins_to_last() {
    let dense = [(100, 10.0), (400, 50.0), (900, 200.0)].map(|(n, ops)| row(n, DENSE, ops));
    let others: Vec<_> = dense.iter().collect();
    let at = |operations: [f64; 3]| {
        let cg: Vec<_> = [100, 400, 900]
            .into_iter()
            .zip(operations)
            .map(|(n, operations)| row(n, CG, operations))
            .collect();
        crossover(cg.iter(), &others)
    };
    assert_eq!(at([20.0, 40.0, 60.0]), Some(400));
    assert_eq!(at([5.0, 60.0, 60.0]), Some(900));
    assert_eq!(at([5.0, 40.0, 60.0]), Some(100));
    assert_eq!(at([5.0, 40.0, 300.0]), None);
}

#[test]
fn a_rebuild_is_told_by_its_worth_in_solves() {
    let facts = |worth: f64| Facts {
        solvers: vec![
            Solver { setup_operations: worth * 10.0, ..row(100, DENSE, 10.0) },
            row(100, CG, 5.0),
        ],
        changes: Vec::new(),
    };
    let said = words(&facts(60.0));
    assert!(
        said.conclusion
            .ends_with("h or k costs as much as up to 60 solves with the dense inverse."),
        "{said:?}"
    );
    assert!(said.observations[0].starts_with("The three solvers agree"), "{said:?}");
}

#[test]
fn words_tell_who_is_dearest_who_overtakes_and_what_disagrees() {
    let sparse = [(100, 1.0), (400, 20.0)].map(|(n, ops)| row(n, CHOLESKY, ops));
    let cg = [(100, 2.0), (400, 10.0)].map(|(n, ops)| row(n, CG, ops));
    let dense = [(100, 5.0), (400, 50.0)].map(|(n, ops)| row(n, DENSE, ops));
    let solvers = dense.iter().chain(&sparse).chain(&cg).cloned().collect();
    let mut facts = Facts { solvers, changes: Vec::new() };
    let said = words(&facts).conclusion;
    assert!(said.starts_with("At every size the dense inverse costs most"), "{said}");
    assert!(said.contains("but from 400 particles on CG takes fewer (any)"), "{said}");
    facts.solvers[0].setup_operations = 1.0;
    facts.solvers[5].solve_operations = 30.0;
    facts.solvers[4].disagreement = 1e-3;
    let said = words(&facts);
    assert!(
        said.conclusion.starts_with("The dense inverse does not cost most at every size."),
        "{said:?}"
    );
    assert!(said.conclusion.contains("sparse factor than with CG at every size"), "{said:?}");
    assert!(said.observations[0].contains("do not agree"), "{said:?}");
    let change = |distance: f64| Change {
        solver: CG.to_owned(),
        method: "some".to_owned(),
        steps: 10,
        first: 1,
        step_size: 2,
        stiffness: 3,
        constraints: 4,
        changed: vec!["nothing".to_owned()],
        distance_to_fresh_m: vec![distance],
        portable: true,
    };
    facts.changes = vec![change(0.0)];
    let text = words(&facts).observations.join(" ");
    assert!(text.contains("In 10 steps") && text.contains("its operator 10 times"), "{text}");
    assert!(text.contains("agrees with a fresh start"), "{text}");
    facts.changes.push(change(0.5));
    let text = words(&facts).observations.join(" ");
    assert!(text.contains("differs from a fresh start by up to 0.50 m"), "{text}");
}

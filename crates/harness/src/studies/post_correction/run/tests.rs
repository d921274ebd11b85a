//! Twin steps isolate the correction; and tests of the findings.

use super::super::facts::{groups, spread};
use super::super::words::words;
use super::corrected::{rows, spin};
use super::sheets::{elongation, permuted};
use super::*;
use crate::methods::Choice;
use crate::run::{Runner, Simulation};
use crate::studies::post_correction::facts::{FORWARD, Mesh, PERTURBED, Row, Spin, Sweeps};
use drape_model::TimeSpan;
use drape_report::Verdict;

/// If the two steps of a pair were not the same method, their difference would not be the
/// correction.
#[test]
fn without_a_reachable_limit_both_methods_are_their_uncorrected_twins_bit_for_bit() {
    for (with, without) in [
        ("provot:limit=10", "symplectic-euler"),
        ("desbrun:inverse_dynamics=true,limit=10", "desbrun"),
    ] {
        let spec = Kind::Triangles.spec(1e6, true).expect("valid");
        let run = |method: &str| {
            let (system, state) = spec.build().expect("valid");
            let mut simulation = Simulation { system, state };
            let choice = Choice::parse(method, &[]).expect("known");
            let time = TimeSpan { step_s: 2e-4, duration_s: 0.02 };
            Runner::new(&choice, time).go(&mut simulation).expect("runs");
            simulation.state
        };
        assert_eq!(run(with), run(without), "{with}");
    }
}

#[test]
fn permuted_springs_are_the_same_springs_in_another_order() {
    let spec = Kind::Grid.spec(1e4, true).expect("valid");
    let mixed = permuted(spec.clone(), 1);
    assert_eq!(mixed, permuted(spec.clone(), 1));
    assert_ne!(mixed.springs, permuted(spec.clone(), 2).springs);
    let sorted = |spec: &drape_model::SystemSpec| {
        let mut ends: Vec<_> = spec.springs.iter().map(|spring| (spring.i, spring.j)).collect();
        ends.sort_unstable();
        ends
    };
    assert_ne!(mixed.springs, spec.springs);
    assert_eq!(sorted(&mixed), sorted(&spec));
}

#[test]
fn elongation_is_that_of_the_longest_spring() {
    let (system, mut state) = Kind::Grid.spec(1e4, true).expect("valid").build().expect("valid");
    assert!(elongation(&system, &state.x).abs() < 1e-12);
    for x in &mut state.x {
        x.x *= 1.3;
    }
    assert!((elongation(&system, &state.x) - 0.3).abs() < 1e-12);
}

/// Shortening moves both ends along the spring, so it keeps linear momentum. Angular momentum does
/// not stay the same.
#[test]
fn corrections_keep_momentum_and_take_angular_momentum() {
    let corrected = spin(Kind::Triangles, PROVOT, Some(0.05), STEP).expect("runs");
    assert!(corrected.momentum_change < 1e-14, "{corrected:?}");
    assert!(corrected.angular_momentum_left < 0.99, "{corrected:?}");
    let sum = corrected.angular_momentum_left + corrected.angular_momentum_taken;
    assert!((sum - 1.0).abs() < 1e-10, "symplectic Euler itself takes none: {corrected:?}");
    let free = spin(Kind::Triangles, PROVOT, None, STEP).expect("runs");
    assert!((free.angular_momentum_left - 1.0).abs() < 1e-10, "{free:?}");
    assert_eq!(free.angular_momentum_taken, 0.0);
}

#[test]
fn a_corrected_sheet_leaves_the_equation_that_the_uncorrected_step_meets() {
    let setting = Setting::new(Kind::Grid, STEP).expect("runs");
    let mesh = &setting.mesh;
    assert!(mesh.reference_elongation < 0.05 && mesh.uncorrected_elongation > 0.5, "{mesh:?}");
    let rows = rows(&setting, &groups_for_tests()).expect("runs");
    let row = &rows[0];
    assert_eq!((rows.len(), row.order.as_str(), row.verdict), (1, FORWARD, Verdict::Completed));
    assert!(row.uncorrected_residual < 1e-10 && row.residual > 0.1, "{row:?}");
    assert!(row.elongation < 0.5 * mesh.uncorrected_elongation, "{row:?}");
    assert!(row.weight_held > 0.0, "{row:?}");
}

fn groups_for_tests() -> Group {
    Group { method: PROVOT, limit: 0.1, sweeps: 1, step_s: STEP, all_orders: false }
}

fn row(limit: f64, order: &str, distance: f64, order_distance: &[f64]) -> Row {
    Row {
        mesh: "grid".to_owned(),
        label: "provot".to_owned(),
        method: "provot".to_owned(),
        limit,
        sweeps: 1,
        order: order.to_owned(),
        step_s: STEP,
        distance: vec![distance; 2],
        order_distance: order_distance.to_vec(),
        energy_taken: 0.1,
        energy_given: 0.0,
        weight_held: 0.5,
        residual: 0.5,
        uncorrected_residual: 0.0,
        elongation: 0.2,
        verdict: Verdict::Completed,
        portable: true,
    }
}

#[test]
fn dependence_and_approach_are_concluded_from_the_distances() {
    let facts = |narrow: f64, apart: f64| Facts {
        meshes: vec![Mesh {
            id: "grid".to_owned(),
            particles: 4,
            springs: 4,
            stiffness_over_mass_per_s2: 1e4,
            reference_stiffness_over_mass_per_s2: 1e7,
            damping_over_mass_per_s: 10.0,
            time_s: vec![0.5, 1.0],
            motion_m: vec![0.5, 1.0],
            reference_error: vec![1e-4; 2],
            uncorrected_distance: vec![1.0; 2],
            uncorrected_elongation: 3.0,
            reference_elongation: 0.01,
            released_j: 2.0,
            portable: true,
        }],
        rows: vec![
            row(0.1, FORWARD, 0.5, &[]),
            row(0.1, "backward", 0.5, &[0.002, apart]),
            row(0.1, "shuffled", 0.5, &[0.004, 0.5 * apart]),
            row(0.1, PERTURBED, 0.5, &[0.1, 0.2]),
            row(0.01, FORWARD, narrow, &[]),
        ],
        spins: Vec::new(),
        sweeps: Vec::new(),
    };
    let near = facts(0.1, 0.03);
    assert_eq!(spread(&groups(&near)[0].1), [0.004, 0.03]);
    let said = words(&near);
    let ends = "ends in 1 of 1 groups, by up to 3.0 % of the motion; a disturbed start changes it \
                by at most 20 %";
    assert!(said.observations[0].contains(ends), "{said:?}");
    let nearer = "nearer to the stiff one, but it stays at least 10 % of the motion away";
    assert!(said.conclusion.contains(nearer), "{said:?}");
    assert!(said.conclusion.ends_with("at least 0.50 of the forces."), "{said:?}");
    let said = words(&facts(0.6, 0.006));
    assert!(said.observations[0].contains("ends in 0 of 1 groups"), "{said:?}");
    assert!(
        said.conclusion.contains("narrower limits do not bring the corrected sheet"),
        "{said:?}"
    );
    assert!(said.observations[1].contains("2.0 to 20 times as elongated"), "{said:?}");
}

#[test]
fn words_tell_whether_the_residual_falls_and_what_a_subset_lacks() {
    let mut facts = Facts {
        meshes: Vec::new(),
        rows: vec![
            Row { residual: 1.5, ..row(0.1, FORWARD, 0.5, &[]) },
            Row { residual: 1.4, step_s: 0.5 * STEP, ..row(0.1, FORWARD, 0.5, &[]) },
        ],
        spins: Vec::new(),
        sweeps: Vec::new(),
    };
    let said = words(&facts).conclusion;
    assert!(
        said.starts_with("The corrected sheet ends at least 50 % of the motion away"),
        "{said}"
    );
    assert!(
        said.ends_with("as large as all forces, and it does not vanish with the step."),
        "{said}"
    );
    facts.rows[1].residual = 0.1;
    let said = words(&facts).conclusion;
    assert!(said.ends_with("though it falls with the step."), "{said}");
    facts.rows.clear();
    assert_eq!(words(&facts).conclusion, "No corrected sheet was run.");
}

#[test]
fn words_count_sweeps_and_what_spinning_sheets_lose() {
    let sweeps = |elongation: [f64; 2]| Sweeps {
        mesh: "grid".to_owned(),
        limit: 0.1,
        order: FORWARD.to_owned(),
        before: 0.8,
        sweeps: vec![1, 2],
        elongation: elongation.to_vec(),
        portable: true,
    };
    let spin = Spin {
        mesh: "grid".to_owned(),
        label: "provot".to_owned(),
        method: "provot".to_owned(),
        limit: Some(0.1),
        momentum_change: 1e-16,
        angular_momentum_left: 0.75,
        angular_momentum_taken: 0.25,
        energy_left: 0.5,
        portable: true,
    };
    let mut facts = Facts {
        meshes: Vec::new(),
        rows: Vec::new(),
        spins: vec![spin],
        sweeps: vec![sweeps([0.9, 0.5]), sweeps([0.7, 0.1])],
    };
    let text = words(&facts).observations.join(" ");
    assert!(text.contains("Corrections keep the momentum of a free sheet"), "{text}");
    assert!(text.contains("as little as 75 % of its angular momentum"), "{text}");
    assert!(text.contains("1 of 2 stretched sheets meet the limit within 2 sweeps"), "{text}");
    assert!(text.contains("lengthens the longest spring in 1."), "{text}");
    facts.spins[0].momentum_change = 1e-3;
    let text = words(&facts).observations.join(" ");
    assert!(text.contains("Corrections do not keep the momentum"), "{text}");
}

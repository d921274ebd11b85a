//! Beside the public solver of Newton 1.8.0, on one frozen sheet.

use super::support::prepared;
use drape_model::Vec3;
use drape_oracle::apart;
use drape_oracle::published::{Case, Descent, Published, newton, vectors};

/// Formulas of `SolverVBD`.
const THEIRS: Descent = Descent { is_clamped: false, is_damping_lagged: false };
/// Formulas of this crate.
const OURS: Descent = Descent { is_clamped: true, is_damping_lagged: true };

/// What single precision leaves of positions of 1 m after four steps, m.
const SINGLE: f64 = 5e-7;

/// The positions of this crate after so many steps.
fn ours(published: &Published, case: &Case, steps: usize) -> Vec<Vec3> {
    let settings = format!("start=inertial,sweeps={}", case.iterations);
    let mut run = prepared(&settings, published.build(case), published.step_s);
    run.steps(steps);
    run.state.x
}

fn cases(published: &Published) -> impl Iterator<Item = &Case> {
    published.cases.iter().filter(|case| case.solver == "vbd")
}

#[test]
fn the_public_solver_moves_a_sheet_by_its_formulas() {
    let published = newton();
    assert_eq!(cases(&published).count(), 4);
    for case in cases(&published) {
        for (&steps, theirs) in &case.position_after_m {
            let off = apart(&published.descend(case, THEIRS, steps), &vectors(theirs));
            assert!(off < SINGLE, "{}, {steps} steps: {off:e} m", case.name);
        }
    }
}

/// The same loop with the formulas of this crate gives the positions of this crate: nothing else
/// differs.
#[test]
fn this_method_moves_the_sheet_by_its_own_formulas() {
    let published = newton();
    let colours = &published.case("stretched").colours;
    for case in cases(&published) {
        let case = Case { colours: colours.clone(), ..case.clone() };
        for &steps in case.position_after_m.keys() {
            let written = published.descend(&case, OURS, steps);
            let off = apart(&ours(&published, &case, steps), &written);
            assert!(off < 1e-12, "{}, {steps} steps: {off:e} m", case.name);
        }
    }
}

/// Without damping, on stretched springs and with the same colours, the two are one method.
/// Colours, the clamp and the damping each make a difference that single precision does not hide.
#[test]
fn the_two_differ_by_colours_clamp_and_damping_alone() {
    let published = newton();
    for (name, least, most) in [
        ("stretched", 0.0, SINGLE),
        ("other colours", 1e-4, 2e-4),
        ("compressed", 2e-4, 4e-4),
        ("damped", 2e-3, 4e-3),
    ] {
        let case = published.case(name);
        let off = apart(&ours(&published, case, 4), &vectors(&case.position_after_m[&4]));
        assert!((least..most).contains(&off), "{name}: {off:e} m");
    }
}

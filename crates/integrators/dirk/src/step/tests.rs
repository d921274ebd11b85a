//! The step against its recurrences and laws, alone and in contact.

use super::Workspace;
use crate::{Dirk, DirkSettings, Tableau};
use drape_integrator::{Integrator, Rewind, SolveStatus};
use drape_model::DampingLaw;
use drape_oracle::checks::{self, Known, contact};
use drape_oracle::laws::Drift;
use drape_oracle::recurrence::RungeKutta;
use drape_oracle::scenes::{Sheet, stir};
use drape_oracle::{Run, apart};

const ALL: [&str; 5] = ["tr-bdf2", "sdirk2", "sdirk3", "esdirk3", "sdirk4"];

fn exact_of(tableau: &str) -> (RungeKutta, f64) {
    match tableau {
        "tr-bdf2" => (RungeKutta::tr_bdf2(), 2.0),
        "sdirk2" => (RungeKutta::sdirk2(), 2.0),
        "sdirk3" => (RungeKutta::sdirk3(), 3.0),
        "esdirk3" => (RungeKutta::esdirk3(), 3.0),
        _ => (RungeKutta::sdirk4(), 4.0),
    }
}

fn with(tableau: &str, more: &[(&str, &str)]) -> Box<dyn Integrator> {
    let pairs = more.iter().copied().chain([("tableau", tableau)]);
    Dirk::controlled(DirkSettings::from_pairs(pairs).expect("in range"))
}

fn tight(tableau: &str) -> Box<dyn Integrator> {
    with(tableau, &[("residual", "1e-16"), ("solver", "cholesky")])
}

#[test]
fn a_spring_without_length_moves_by_the_recurrence_at_any_step_sizes() {
    for (tableau, (theta, eta)) in ALL.into_iter().flat_map(|t| checks::PARAMETERS.map(|p| (t, p)))
    {
        let case = (tableau, theta, eta);
        let start = checks::oscillator(theta, eta);
        checks::follows(case, tight(tableau), start, &checks::SIZES, 1e-9, |size| {
            exact_of(tableau).0.amplification(theta * size * size, eta * size)
        });
    }
}

/// Numbers computed elsewhere with 30 digits: spin and angle after 1 s at h = 0.01 for θ = 1 and
/// θ = 100, and energy for θ = 100. The stage order decides: sdirk2 to sdirk4 lose or gain.
#[test]
fn a_stiff_pair_turns_as_a_computation_with_thirty_digits_says() {
    #[rustfmt::skip]
    let table = [
        ("tr-bdf2", [0.999_999_880_267, 1.999_967_529_899], [0.999_999_763_394, 1.999_967_413_557], 0.999_999_526_790),
        ("sdirk2", [0.999_852_838_712, 1.999_773_137_929], [0.991_621_411_805, 1.991_555_062_250], 0.983_333_592_760),
        ("sdirk3", [0.998_604_366_256, 1.998_585_049_175], [0.989_778_179_726, 1.989_692_266_827], 0.979_670_609_662),
        ("esdirk3", [0.999_999_204_643, 1.999_999_204_305], [0.999_998_966_983, 1.999_998_971_899], 0.999_997_933_976),
        ("sdirk4", [1.000_027_323_592, 2.000_024_393_999], [1.021_000_553_539, 2.020_632_884_186], 1.042_621_117_692),
    ];
    for (tableau, soft, stiff, energy) in table {
        for (theta, [spin, angle]) in [(1.0, soft), (100.0, stiff)] {
            let found = checks::turn(tight(tableau), theta);
            assert!((found.spin - spin).abs() < 1e-10, "{tableau}, θ={theta}: {found:?}");
            assert!((found.angle - angle).abs() < 1e-10, "{tableau}, θ={theta}: {found:?}");
            assert!(theta < 2.0 || (found.energy - energy).abs() < 1e-9, "{tableau}: {found:?}");
        }
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola() {
    for tableau in ALL {
        checks::falls_freely(tableau, with(tableau, &[]), Drift::MeanVelocity, 1e-11);
    }
}

/// At default settings: the residual falls with the order.
#[test]
fn every_tableau_has_its_order_with_both_laws_of_damping_at_default_settings() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let known = Known::new(stir(Sheet::smooth(law).build(), 0.02, 0.3), 0.25);
        for tableau in ALL {
            let steps: &[u32] = if tableau == "sdirk4" { &[10, 20, 40] } else { &[20, 40, 80] };
            let found = known.order(|| with(tableau, &[]), steps);
            let order = exact_of(tableau).1;
            assert!((found.order - order).abs() < 0.15, "{tableau}, {law:?}: {found:?}");
        }
    }
}

/// One linear solve a stage keeps order 2: Newton starts within `O(h²)` and squares that.
#[test]
fn one_newton_iteration_a_stage_keeps_order_two() {
    let known = Known::new(stir(Sheet::smooth(DampingLaw::Full).build(), 0.02, 0.3), 0.25);
    let one = [("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")];
    for (tableau, cheap) in [("tr-bdf2", &one[..1]), ("tr-bdf2", &one), ("sdirk2", &one)] {
        let found = known.order(|| with(tableau, cheap), &[20, 40, 80, 160]);
        assert!((found.order - 2.0).abs() < 0.2, "{tableau}, {cheap:?}: {found:?}");
    }
}

/// A factor keeps it to round-off. Conjugate gradients, the default, leave a residual, whose sum is
/// momentum: they keep it to their tolerance.
#[test]
fn momentum_of_a_free_sheet_is_kept() {
    for tableau in ALL {
        let free = Sheet { tension: 1e6, shear: 1e5, ..Sheet::free() };
        let start = stir(free.build(), 0.0, 0.3);
        for (settings, most) in [(&[("solver", "cholesky")][..], 1e-13), (&[], 1e-9)] {
            let drift = checks::momentum_drift(with(tableau, settings), start.clone(), 1e-3);
            assert!(drift < most, "{tableau}, {settings:?}: {drift:e}");
        }
    }
}

#[test]
fn a_dropped_particle_comes_to_rest_and_an_elastic_one_returns_to_its_height() {
    for tableau in ALL {
        contact::bounces_or_rests(tableau, || with(tableau, &[]), &[0.0, 0.5, 1.0]);
    }
}

#[test]
fn friction_is_coulombs() {
    for tableau in ALL {
        contact::friction_is_coulombs(tableau, || with(tableau, &[]), 0.0, 1e-3);
    }
}

#[test]
fn an_impact_with_friction_takes_its_share_once() {
    for tableau in ALL {
        contact::impact_takes_its_share_once(tableau, with(tableau, &[]));
    }
}

#[test]
fn led_pins_are_on_their_paths_and_a_rising_floor_lifts() {
    for tableau in ALL {
        contact::paths_lead(tableau, || with(tableau, &[]));
    }
}

/// What the last step knows of its forces does not outlive a change of the system.
#[test]
fn a_change_of_the_system_is_seen_at_once() {
    for tableau in ALL {
        let [kept, fresh] = checks::after_a_change(|| tight(tableau), 0.004);
        let off = apart(&kept.state.x, &fresh.state.x);
        assert!(off < 1e-12, "{tableau}: {off:e}");
    }
}

#[test]
fn settings_that_exclude_each_other_are_refused_and_unfinished_solves_reported() {
    for (tableau, fits) in ALL.into_iter().zip([true, true, false, false, false]) {
        let pairs = [("tableau", tableau), ("tolerance", "0.01")];
        assert_eq!(DirkSettings::from_pairs(pairs).is_ok(), fits, "{tableau}");
    }
    assert_eq!(DirkSettings::default().tableau, Tableau::TrBdf2);
    for tableau in ALL {
        let start = stir(Sheet { tension: 1e6, ..Sheet::default() }.build(), 0.1, 3.0);
        let mut run = Run::new(with(tableau, &[("max_iterations", "1")]), start, 0.05);
        assert_eq!(run.step().solve, SolveStatus::IterationLimit, "{tableau}");
    }
}

/// Under control of the step size a smooth fall keeps to the tolerance with few rejections.
#[test]
fn step_size_control_divides_steps() {
    let start = stir(Sheet { tension: 1e4, ..Sheet::default() }.build(), 0.02, 0.3);
    let mut run = Run::new(with("tr-bdf2", &[("tolerance", "1e-4")]), start, 0.1);
    let reports = run.steps(3);
    assert!(reports.iter().all(|r| r.substeps > 2 && r.error_estimate <= 1.0), "{reports:?}");
}

/// `(3γ² − 4γ + 2)/(12 (2 − γ))` with `γ = 2 − √2`, as in Bank et al. 1985.
#[test]
fn the_error_constant_of_tr_bdf2_is_the_published_one() {
    let gamma = 2.0 - std::f64::consts::SQRT_2;
    let published = (3.0 * gamma * gamma - 4.0 * gamma + 2.0) / (12.0 * (2.0 - gamma));
    let found = Workspace::error_constant(&DirkSettings::default(), 1.0);
    assert!((found - published).abs() < 1e-15, "{found}");
}

//! The step against its recurrence and its laws, alone and in contact.

use crate::{Midpoint, MidpointSettings};
use drape_integrator::{Integrator, SolveStatus, TimeStep};
use drape_model::{DampingLaw, Vec3};
use drape_oracle::checks::{self, Known, contact};
use drape_oracle::laws::{Drift, spin};
use drape_oracle::recurrence::implicit_midpoint;
use drape_oracle::scenes::{Sheet, build, floor, particles, stir, tension};
use drape_oracle::{Run, seconds};

const TIGHT: &[(&str, &str)] = &[("residual", "1e-16"), ("solver", "cholesky")];

fn midpoint(pairs: &[(&str, &str)]) -> Box<dyn Integrator> {
    let settings = MidpointSettings::from_pairs(pairs.iter().copied()).expect("in range");
    Midpoint::controlled(settings)
}

#[test]
fn a_spring_without_length_moves_by_the_recurrence_at_any_step_sizes() {
    for (theta, eta) in checks::PARAMETERS {
        let start = checks::oscillator(theta, eta);
        let sizes = &checks::SIZES;
        checks::follows((theta, eta), midpoint(TIGHT), start, sizes, 1e-9, |size| {
            implicit_midpoint(theta * size * size, eta * size)
        });
    }
}

/// Numbers of an independent implementation: spin, angle and energy after 1 s at h = 0.01.
#[test]
fn a_stiff_pair_turns_as_an_independent_implementation_says() {
    for (theta, angle, energy) in
        [(1.0, 1.999_731_52, None), (100.0, 1.999_730_83, Some(1.001_441_72))]
    {
        let found = checks::turn(midpoint(TIGHT), theta);
        assert!((found.spin - 1.0).abs() < 1e-8, "θ={theta}: {found:?}");
        assert!((found.angle - angle).abs() < 1e-6, "θ={theta}: {found:?}");
        let is_off = |energy: f64| (found.energy - energy).abs() >= 1e-6;
        assert!(!energy.is_some_and(is_off), "θ={theta}: {found:?}");
    }
}

/// Damping that is linear in the velocity takes spin by the law of the step.
#[test]
fn full_damping_takes_spin_by_the_law() {
    let (h, theta, eta) = (checks::H, 10.0, 0.125);
    let (k, c) = checks::coefficients(0.5 * theta, 0.5 * eta, h);
    let (x, v) = ([Vec3::zeros(), Vec3::new(0.6, 0.0, 0.0)], [Vec3::y(), -Vec3::y()]);
    let mut spec = particles(&[0.25; 2], &x, &v);
    spec.springs = vec![tension((0, 1), 0.5, k, c)];
    let mut run = Run::new(midpoint(TIGHT), build(&spec), h);
    let turn = |run: &Run| {
        let (d, v) = checks::pair(&run.state);
        d.cross(&v).z
    };
    for step in 0..50 {
        let (before, x) = (turn(&run), run.state.x.clone());
        run.step();
        let middle = (run.state.x[1] - run.state.x[0] + x[1] - x[0]) * 0.5;
        let factor = spin::implicit_midpoint(theta, eta, 0.5 / middle.norm());
        let after = turn(&run);
        assert!((after - factor * before).abs() < 1e-8 * before.abs(), "step {step}");
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola() {
    checks::falls_freely("midpoint", midpoint(&[]), Drift::MeanVelocity, 1e-11);
}

#[test]
fn the_order_is_two_with_both_laws_of_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let known = Known::new(stir(Sheet::smooth(law).build(), 0.02, 0.3), 0.25);
        let new = || midpoint(&[("residual", "1e-13")]);
        let found = known.order(new, &[20, 40, 80]);
        assert!((found.order - 2.0).abs() < 0.15, "{law:?}: {found:?}");
        let found = known.order_by(new, &[1.0, 2.0], &[20, 40, 80]);
        assert!((found.order - 2.0).abs() < 0.15, "{law:?}, uneven: {found:?}");
    }
}

/// One linear solve a step, by CG or directly: order 2 is kept, because Newton starts within
/// `O(h²)` and squares that.
#[test]
fn one_newton_iteration_by_conjugate_gradients_keeps_order_two() {
    let known = Known::new(stir(Sheet::smooth(DampingLaw::Full).build(), 0.02, 0.3), 0.25);
    let one = [("max_iterations", "1"), ("solver", "cg"), ("cg_tolerance", "0.01")];
    for cheap in [&one[..1], &one] {
        let found = known.order(|| midpoint(cheap), &[20, 40, 80, 160]);
        assert!((found.order - 2.0).abs() < 0.2, "{cheap:?}: {found:?}");
    }
}

#[test]
fn momentum_and_spin_of_a_free_sheet_are_kept() {
    let free = Sheet { damping: 0.0, tension: 1e6, shear: 1e5, ..Sheet::free() };
    let mut run = Run::new(midpoint(TIGHT), stir(free.build(), 0.0, 0.3), 1e-3);
    let of = |run: &Run| (run.system.momentum(&run.state), run.system.angular_momentum(&run.state));
    let (p, l) = of(&run);
    run.steps(50);
    let (p_end, l_end) = of(&run);
    let off = [(p_end - p).norm(), (l_end - l).norm()];
    assert!(off[0] < 1e-13 && off[1] < 1e-11, "{off:?}");
}

#[test]
fn a_dropped_particle_comes_to_rest_and_an_elastic_one_returns_to_its_height() {
    contact::bounces_or_rests("midpoint", || midpoint(&[]), &[0.0, 0.5, 1.0]);
}

#[test]
fn friction_on_a_slope_is_coulombs() {
    contact::friction_is_coulombs("midpoint", || midpoint(&[]), 0.0, 5e-3);
}

/// The ledger accounts for the whole change of energy, also in contact, and inertia is 0.
#[test]
fn the_ledger_accounts_for_the_change_of_energy() {
    let mut spec = Sheet { law: DampingLaw::Projected, pinned: false, ..Sheet::default() }.spec();
    spec.obstacles = vec![floor(0.0)];
    let (system, mut state) = build(&spec);
    for (i, x) in state.x.iter_mut().enumerate() {
        x.z += 0.02 + 0.001 * i as f64;
    }
    let mut run = Run::new(midpoint(&[]), (system, state), 0.01);
    let mut touched = false;
    for step in 0..40 {
        let before = run.state.clone();
        run.step();
        let Run { integrator, system, state, h } = &mut run;
        let ledger = integrator.ledger(system, &before, state, seconds(*h)).expect("a ledger");
        let change = system.total_energy(state) - system.total_energy(&before);
        let wrong = (ledger.sum() - change).abs() / ledger.magnitude().max(1e-6);
        assert!(wrong < 1e-8, "step {step}: {wrong:e}, {ledger:?}");
        touched |= ledger.impact < -1e-6;
        assert!(ledger.inertia.abs() < 1e-12, "{ledger:?}");
    }
    assert!(touched);
}

#[test]
fn an_unfinished_solve_is_reported_and_a_blow_up_is_no_panic() {
    let start = stir(Sheet { tension: 1e6, ..Sheet::default() }.build(), 0.1, 3.0);
    let mut run = Run::new(midpoint(&[("max_iterations", "1")]), start, 0.05);
    assert_eq!(run.step().solve, SolveStatus::IterationLimit);
    run.state.v[7].x = f64::NAN;
    let h = TimeStep::new(0.01).expect("positive");
    let mut clock = drape_integrator::PhaseClock::off();
    let _any = run.integrator.step(&run.system, &mut run.state, h, &mut clock);
}

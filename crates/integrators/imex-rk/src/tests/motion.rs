//! Steps against recurrences, laws and the exact motion.

use super::tableaux::additive;
use super::{NAMES, boxed, method, run};
use drape_integrator::{Integrator, PrepareError, SolveStatus};
use drape_model::{DampingLaw, KeyframeSpec, SpringEffect, System, Vec3};
use drape_oracle::checks::{self, H, Known, MASS};
use drape_oracle::laws::Drift;
use drape_oracle::recurrence::additive_runge_kutta;
use drape_oracle::scenes::{
    Sheet, across, anchored, build, floor, in_the_wind, resting_chain, stir, uneven,
};
use drape_oracle::{apart, bits, seconds};

/// A particle on an implicit and an explicit spring of rest length 0 to a pin: each coordinate is
/// the oscillator.
#[test]
fn a_step_is_its_recurrence_with_implicit_and_explicit_springs_at_any_step_sizes() {
    let (x, v) = (Vec3::new(1.0, -0.5, 2.0), Vec3::new(0.0, 40.0, 7.0));
    let parameters = [
        (0.36, 0.0, 0.06),
        (1.0, 0.1, 0.0),
        (100.0, 4.0, 0.4),
        (100.0, 0.0, 0.0),
        (2.0, 0.0, 30.0),
    ];
    let solvers = [("cholesky", 1e-12), ("cg,forcing_term=1e-15", 1e-9)];
    for ((name, pair), (theta, shear, eta)) in
        NAMES.into_iter().flat_map(|t| parameters.map(|p| (t, p)))
    {
        for ((solver, tolerance), sizes) in
            solvers.into_iter().flat_map(|s| [[1.0; 3], [1.0, 2.0, 0.75]].map(|sizes| (s, sizes)))
        {
            let (k, c) = checks::coefficients(theta, eta, H);
            let (k_shear, _) = checks::coefficients(shear, 0.0, H);
            let springs =
                [(SpringEffect::Tension, 0.0, k, c), (SpringEffect::Shear, 0.0, k_shear, 0.0)];
            let start = build(&anchored(MASS, &springs, x, v));
            let text = format!("tableau={name},solver={solver},implicit=tension");
            let case = (&text, theta, shear, eta);
            let tableau = additive(pair);
            let reports = checks::follows(case, boxed(&text), start, &sizes, tolerance, |size| {
                let square = size * size;
                additive_runge_kutta(&tableau, theta * square, shear * square, eta * size)
            });
            assert!(reports.iter().all(|r| r.solve == SolveStatus::Converged), "{case:?}");
        }
    }
}

/// A particle between two pinned ones: across the springs `θ` is implicit and `−σθ` explicit.
#[test]
fn motion_across_a_spring_sees_its_stiffness_split() {
    for ((name, pair), (theta, ratio)) in NAMES
        .into_iter()
        .flat_map(|t| [(100.0, 0.5), (100.0, 0.99), (100.0, 1.0), (0.36, 0.3)].map(|p| (t, p)))
    {
        let r = additive_runge_kutta(&additive(pair), theta, -ratio * theta, 0.0);
        let start = across(theta, ratio, MASS, H);
        let case = (name, theta, ratio);
        checks::moves_across(case, boxed(&format!("tableau={name}")), start, r, 50);
    }
}

/// `L/L₀` and angle at `θ = 1` and 100; exactly 1 and 2. At 100 nothing turns, and with `ark3` and
/// `ark4` the angular momentum does not tell.
#[test]
fn two_particles_turn_as_the_independent_computation_says() {
    let golden = [
        ("ars222", [(0.5343155466, 1.40496650), (0.0, 0.00328598)]),
        ("ars443", [(1.5541797764, 2.48478700), (0.0, 0.00143319)]),
        ("ark3", [(0.9971787873, 1.90031534), (0.9998003378, 0.09775669)]),
        ("ark4", [(1.0001203948, 2.01248749), (1.0008874219, 0.55157617)]),
    ];
    for (name, rows) in golden {
        for (theta, (momentum, angle)) in [1.0, 100.0].into_iter().zip(rows) {
            let found = checks::turn(boxed(&format!("tableau={name}")), theta);
            assert!((found.spin - momentum).abs() < 1e-8, "{name}, θ={theta}: {found:?}");
            assert!((found.angle - angle).abs() < 1e-7, "{name}, θ={theta}: {found:?}");
            assert!(found.momentum < 1e-12, "{name}, θ={theta}: {found:?}");
        }
    }
}

#[test]
fn a_free_sheet_falls_on_the_exact_parabola_and_feels_no_spring() {
    for (name, _) in NAMES {
        // What `ark3` and `ark4` add to the last stage carries the round-off of the explicit force.
        let bound = if name.starts_with("ars") { 1e-11 } else { 1e-9 };
        let integrator = boxed(&format!("tableau={name}"));
        checks::falls_freely(name, integrator, Drift::MeanVelocity, bound);
    }
}

#[test]
fn momentum_is_kept_with_unequal_masses_and_both_laws_of_damping() {
    for ((name, _), law) in
        NAMES.into_iter().flat_map(|t| [DampingLaw::Full, DampingLaw::Projected].map(|l| (t, l)))
    {
        let start = uneven(stir(Sheet { law, ..Sheet::free() }.build(), 0.02, 1.0));
        let drift = checks::momentum_drift(boxed(&format!("tableau={name}")), start, 0.004);
        assert!(drift < 1e-14, "{name}, {law:?}: {drift:e}");
    }
}

/// Observed order on a smooth scene, with all springs in the matrix and with shear springs
/// explicit, with both laws of damping.
#[test]
fn every_tableau_has_its_order() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let sheet = Sheet { side: 4, ..Sheet::smooth(law) };
        let known = Known::new(stir(sheet.build(), 0.02, 0.5), 0.125);
        for ((name, pair), implicit) in
            NAMES.into_iter().flat_map(|t| ["springs", "tension"].map(|implicit| (t, implicit)))
        {
            let text = format!("tableau={name},implicit={implicit}");
            let found = known.order(|| boxed(&text), &[40, 80, 160]);
            let order = f64::from(pair.tableau().order.number());
            let last = found.pairwise[found.pairwise.len() - 1];
            assert!((last - order).abs() < 0.15, "{text}, {law:?}: {found:?}");
        }
    }
}

/// A chain at rest is a fixed point, though its two parts of the force are large.
#[test]
fn an_equilibrium_is_a_fixed_point() {
    for (name, _) in NAMES {
        let start = resting_chain();
        let x = start.1.x.clone();
        let mut run = run(&format!("tableau={name}"), start, 0.05);
        run.steps(100);
        assert!(apart(&run.state.x, &x) < 1e-12, "{name}: {:e}", apart(&run.state.x, &x));
    }
}

#[test]
fn conjugate_gradients_come_as_close_as_their_tolerance() {
    for (name, _) in NAMES {
        let start = || {
            uneven(stir(
                Sheet { side: 8, tension: 1e4, shear: 1e3, ..Sheet::default() }.build(),
                0.02,
                0.5,
            ))
        };
        let end = |solver: &str| {
            let mut run = run(&format!("tableau={name},solver={solver}"), start(), 0.01);
            let reports = run.steps(20);
            assert!(reports.iter().all(|r| r.solve == SolveStatus::Converged), "{name}, {solver}");
            (run.state, reports.iter().map(|r| r.cg_iterations).sum::<u32>())
        };
        let ((exact, none), (found, iterations)) = (end("cholesky"), end("cg"));
        let off = apart(&exact.x, &found.x);
        assert!(none == 0 && iterations > 20 && off < 1e-6, "{name}: {off:e}, {iterations}");
    }
}

/// What changes between steps is followed: the next step is that of a fresh integrator.
#[test]
fn changes_of_the_system_and_the_step_size_are_followed() {
    for (name, _) in NAMES {
        let mut run =
            run(&format!("tableau={name}"), stir(Sheet::default().build(), 0.01, 0.5), 0.004);
        run.steps(2);
        let changes: [fn(&mut System) -> bool; 4] = [
            |s| s.scale_stiffness(drape_model::EffectKind::Tension, 4.0),
            |s| s.scale_damping(drape_model::EffectKind::Tension, 0.5),
            |s| s.set_pinned(7, true),
            |s| s.set_mass(&[2e-3; 25]),
        ];
        for (k, change) in changes.into_iter().enumerate() {
            assert!(change(&mut run.system), "change {k}");
            let mut fresh = run.fresh(boxed(&format!("tableau={name}")));
            run.h = [0.004, 0.003][k % 2];
            fresh.h = run.h;
            let (report, _) = (run.step(), fresh.step());
            assert_eq!(report.setups.total(), 1, "{name}, change {k}: {report:?}");
            assert_eq!(bits(&run.state), bits(&fresh.state), "{name}, change {k}");
            assert_eq!(run.step().setups.total(), 0, "{name}, change {k}");
        }
    }
}

/// Sweeps over the springs: the explicit forces of a stage, `−L_k X*` before a solve, and for
/// `ark3` and `ark4` the implicit force at the start.
#[test]
fn costs_are_counted() {
    for (name, sweeps) in [("ars222", 4), ("ars443", 8), ("ark3", 8), ("ark4", 12)] {
        let mut run = run(&format!("tableau={name}"), Sheet::default().build(), 0.004);
        let found: Vec<_> =
            run.steps(3).iter().map(|r| (r.force_evaluations, r.factorisations)).collect();
        assert_eq!(found, [(sweeps, 0); 3], "{name}");
    }
}

#[test]
fn obstacles_and_moving_pins_are_refused_by_name() {
    let mut contact = Sheet::default().spec();
    contact.obstacles = vec![floor(0.0)];
    let mut led = Sheet::default().spec();
    led.pins[0].path = vec![KeyframeSpec { time_s: 1.0, offset_m: [0.1, 0.0, 0.0] }];
    for (spec, expected) in [(contact, "contact"), (led, "moving pins")] {
        let (system, _) = build(&spec);
        let error = method("").prepare(&system, seconds(0.01)).expect_err("refused");
        assert!(
            matches!(&error, PrepareError::Unsupported { what, .. } if what == expected),
            "{error}"
        );
    }
}

/// A sheet that resists shear and bending by angles, in a steady wind with quadratic drag: all
/// forces take part with the full order.
#[test]
fn angles_and_wind_keep_the_order() {
    let known = Known::new(in_the_wind(), 0.125);
    for (name, order) in NAMES.map(|(name, pair)| (name, pair.tableau().order.number())) {
        let text = format!("tableau={name}");
        let found = known.order(|| boxed(&text), &[80, 160]);
        assert!((found.order - f64::from(order)).abs() < 0.2, "{text}: {found:?}");
    }
}

/// Each stage takes the wind of its own time.
#[test]
fn a_gust_keeps_the_order() {
    for (name, order) in NAMES.map(|(name, pair)| (name, pair.tableau().order.number())) {
        let text = format!("tableau={name}");
        let found = checks::order_in_a_gust(|| boxed(&text), &[40, 80, 160]);
        assert!((found.order - f64::from(order)).abs() < 0.2, "{text}: {found:?}");
    }
}

/// Steps of varying size keep the order: nothing of a step goes on in the next one.
#[test]
fn the_order_survives_changes_of_the_step_size() {
    let sheet = Sheet { side: 3, tension: 100.0, shear: 25.0, damping: 2.0, ..Sheet::default() };
    let known = Known::new(stir(sheet.build(), 0.02, 1.0), 0.25);
    for ((name, order), pattern) in
        NAMES.map(|(name, pair)| (name, pair.tableau().order.number())).into_iter().flat_map(|t| {
            [&[1.0, 1.17, 1.34][..], &[1.0, 2.0], &[1.0, 1.5, 0.75, 1.25]].map(|p| (t, p))
        })
    {
        let new = || boxed(&format!("tableau={name}"));
        let found = known.order_by(new, pattern, &[20, 40, 80, 160]);
        assert!((found.order - f64::from(order)).abs() < 0.15, "{name}, {pattern:?}: {found:?}");
    }
}

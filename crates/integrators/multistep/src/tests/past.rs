//! Step sizes, changes of the system, restarts, refusals, reports.

use super::{
    Family, Run, STEPS, adams, all, bdf, bits, build, particles, pin, spring, tetrahedron,
};
use crate::{AdamsBashforthSettings, BdfSettings, Steps};
use drape_integrator::{PhaseClock, Setups, SolveStatus, StepError};
use drape_model::{DampingLaw, System, Vec3};

const H: f64 = 0.01;

fn net() -> Run {
    Run::new(adams(Steps::One), build(&tetrahedron(DampingLaw::Projected)), H)
}

fn moving(family: Family, steps: Steps) -> Run {
    let mut run = Run::new(family(steps), build(&tetrahedron(DampingLaw::Projected)), H);
    (0..4).for_each(|_| {
        run.step();
    });
    run
}

/// The same state with an integrator that knows no past.
fn fresh(family: Family, steps: Steps, run: &Run) -> Run {
    Run::new(family(steps), (run.system.clone(), run.state.clone()), run.h.seconds())
}

#[test]
fn the_order_survives_changes_of_the_step_size() {
    // x = cos t, y = sin t.
    let spec = {
        let velocities = [Vec3::zeros(), Vec3::y()];
        let mut spec = particles(&[1.0; 2], &[Vec3::zeros(), Vec3::x()], &velocities);
        spec.pins = vec![pin(0)];
        spec.springs = vec![spring((0, 1), 0.0, 1.0, 0.0)];
        spec
    };
    for (family, steps) in all() {
        let error = |count: u32| {
            // Ratios from 0.7 to 1.4.
            let length = |n: u32| 1.0 + 0.17 * f64::from(n % 3);
            let total: f64 = (0..count).map(length).sum();
            let mut run = Run::new(family(steps), build(&spec), H);
            for n in 0..count {
                run.step_by(2.0 * length(n) / total);
            }
            let (sine, cosine) = run.state.t.sin_cos();
            (run.state.x[1] - Vec3::new(cosine, sine, 0.0)).norm()
        };
        let order = (error(150) / error(300)).log2();
        let k = steps.count() as f64;
        assert!((order - k).abs() < 0.15, "{family:?}, {steps:?}: {order}");
    }
}

#[test]
fn a_moderate_change_of_the_step_size_keeps_the_past_and_a_great_one_drops_it() {
    for (family, steps) in all().filter(|(_, steps)| *steps != Steps::One) {
        for (ratio, kept) in [(0.6, true), (1.45, true), (0.45, false), (2.1, false)] {
            let mut run = moving(family, steps);
            let mut fresh = fresh(family, steps, &run);
            run.step_by(ratio * H);
            fresh.step_by(ratio * H);
            let case = format!("{}, {steps:?}, ratio {ratio}", run.integrator.method().id);
            assert_eq!(bits(&run.state) != bits(&fresh.state), kept, "{case}");
        }
    }
    // Three steps of BDF forget their errors below a ratio of 1.6 only.
    let mut run = moving(bdf, Steps::Three);
    let mut fresh = fresh(bdf, Steps::Three, &run);
    run.step_by(1.6 * H);
    fresh.step_by(1.6 * H);
    assert_eq!(bits(&run.state), bits(&fresh.state));
}

type Change = fn(&mut System) -> bool;

const CHANGES: [Change; 5] = [
    |system| system.scale_stiffness("tension", 3.0),
    |system| system.scale_damping("tension", 0.5),
    |system| system.set_mass(&[1.0, 2.0, 3.0, 4.0]),
    |system| system.set_pinned(2, true),
    |system| system.set_pinned(0, false),
];

#[test]
fn after_any_change_of_the_system_a_step_is_that_of_a_fresh_integrator() {
    for (family, steps) in all() {
        for (number, change) in CHANGES.iter().enumerate() {
            let mut run = moving(family, steps);
            assert!(change(&mut run.system));
            let mut fresh = fresh(family, steps, &run);
            for step in 0..4 {
                assert_eq!(run.step(), fresh.step());
                let case = format!("{}, {steps:?}", run.integrator.method().id);
                assert_eq!(bits(&run.state), bits(&fresh.state), "{case}, {number}, step {step}");
            }
        }
    }
}

#[test]
fn after_a_restart_a_step_is_that_of_a_fresh_integrator() {
    for (family, steps) in all() {
        let mut run = moving(family, steps);
        run.integrator.restart(&run.state);
        let mut fresh = fresh(family, steps, &run);
        for _ in 0..4 {
            assert_eq!(run.step(), fresh.step());
            assert_eq!(bits(&run.state), bits(&fresh.state), "{family:?}, {steps:?}");
        }
    }
}

#[test]
fn pins_hold_to_the_last_bit_also_new_ones_and_let_go() {
    for (family, steps) in all() {
        let (system, mut state) = build(&tetrahedron(DampingLaw::Full));
        state.v[0] = Vec3::new(1.0, 2.0, 3.0);
        let mut run = Run::new(family(steps), (system, state), H);
        let case = format!("{}, {steps:?}", run.integrator.method().id);
        let hold = |run: &mut Run, pinned: usize| {
            let at = run.state.x[pinned];
            for _ in 0..6 {
                run.step();
                assert_eq!(
                    (run.state.x[pinned], run.state.v[pinned]),
                    (at, Vec3::zeros()),
                    "{case}"
                );
            }
        };
        hold(&mut run, 0);
        assert!(run.system.set_pinned(2, true));
        hold(&mut run, 2);
        assert!(run.system.set_pinned(0, false));
        hold(&mut run, 2);
        assert!(run.state.v[0].norm() > 0.1, "{case}: {:?}", run.state.v[0]);
    }
}

/// What the state says about the velocity of a pin before the first step is not what its springs feel.
#[test]
fn the_velocity_that_a_pin_had_does_not_matter() {
    for (family, steps) in all() {
        let [first, second] = [Vec3::zeros(), Vec3::new(30.0, -20.0, 10.0)].map(|velocity| {
            let (system, mut state) = build(&tetrahedron(DampingLaw::Projected));
            state.v[0] = velocity;
            let mut run = Run::new(family(steps), (system, state), H);
            (0..3).for_each(|_| {
                run.step();
            });
            run.state
        });
        for i in 0..4 {
            let apart = (first.x[i] - second.x[i]).norm() + (first.v[i] - second.v[i]).norm();
            assert!(apart < 1e-12, "{family:?}, {steps:?}, particle {i}: {apart:e}");
        }
    }
}

#[test]
fn a_net_at_rest_stays_there_to_the_last_bit() {
    let mut spec =
        particles(&[1.0, 2.0], &[Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.1, 0.2, 1.3)], &[]);
    spec.springs = vec![spring((0, 1), 1.0, 1e4, 1.0)];
    let rest = 1.3 - 0.3;
    spec.springs[0].rest_length_m = rest;
    for (family, steps) in all() {
        let mut run = Run::new(family(steps), build(&spec), H);
        let start = bits(&run.state);
        for _ in 0..50 {
            run.step();
        }
        run.state.t = 0.0;
        assert_eq!(bits(&run.state), start, "{family:?}, {steps:?}");
    }
}

#[test]
fn reports_say_what_a_step_cost() {
    for steps in STEPS {
        let mut run = Run::new(adams(steps), build(&tetrahedron(DampingLaw::Full)), H);
        let start = if steps == Steps::One { 1 } else { 2 };
        for expected in [start, 1, 1] {
            let report = run.step();
            assert_eq!(report.force_evaluations, expected, "{steps:?}");
            assert_eq!((report.newton_iterations, report.setups.total()), (0, 0));
        }
        let mut run = Run::new(bdf(steps), build(&tetrahedron(DampingLaw::Full)), H);
        let [first, second] = [run.step(), run.step()];
        for report in [first, second] {
            assert!(
                report.newton_iterations > 0 && report.factorisations >= report.newton_iterations
            );
            assert!(report.force_evaluations > report.newton_iterations);
            assert!(report.relative_residual > 0.0 && report.relative_residual < 1e-9);
            assert_eq!((report.setups, report.substeps), (Setups::default(), 1));
        }
        if steps == Steps::Three {
            assert!(first.factorisations > second.factorisations, "two stages: {first:?}");
        }
    }
}

#[test]
fn an_iteration_limit_is_reported_also_where_only_the_first_stage_met_it() {
    let status = |steps, residual: &str, h| {
        let pairs = [("max_iterations", "1"), ("residual", residual)];
        let mut settings = BdfSettings::from_pairs(pairs).expect("in range");
        settings.steps = steps;
        let integrator = Box::new(crate::Bdf::new(settings));
        Run::new(integrator, build(&tetrahedron(DampingLaw::Full)), h).step().solve
    };
    for steps in STEPS {
        assert_eq!(status(steps, "1e-14", 0.1), SolveStatus::IterationLimit, "{steps:?}");
    }
    assert_eq!(status(Steps::Three, "1e-4", 0.05), SolveStatus::IterationLimit);
    assert_eq!(status(Steps::Three, "1e-3", 0.05), SolveStatus::Converged);
}

#[test]
fn settings_are_read_and_refused_by_name() {
    for (text, steps) in [("1", Steps::One), ("2", Steps::Two), ("3", Steps::Three)] {
        let found = AdamsBashforthSettings::from_pairs([("steps", text)]).expect("in range");
        assert_eq!((found.steps, found.steps.count().to_string().as_str()), (steps, text));
        assert_eq!(BdfSettings::from_pairs([("steps", text)]).expect("in range").steps, steps);
    }
    assert_eq!(AdamsBashforthSettings::from_pairs([]), Ok(AdamsBashforthSettings::default()));
    assert_eq!(BdfSettings::from_pairs([]), Ok(BdfSettings::default()));
    let stage = BdfSettings::from_pairs([("residual", "1e-6"), ("max_iterations", "7")]);
    let stage = stage.expect("in range").stage;
    assert_eq!((stage.residual, stage.max_iterations), (1e-6, 7));
    for wrong in ["0", "4", "two"] {
        let refused = BdfSettings::from_pairs([("steps", wrong)]).expect_err("out of range");
        assert!(refused.to_string().contains("a whole number from 1 to 3"), "{refused}");
        assert!(AdamsBashforthSettings::from_pairs([("steps", wrong)]).is_err());
    }
    let refused = AdamsBashforthSettings::from_pairs([("residual", "1")]).expect_err("unknown");
    assert!(refused.to_string().contains("adams-bashforth2 has no setting `residual`"));
}

#[test]
fn what_was_not_prepared_is_refused_and_the_state_kept() {
    for (family, steps) in all() {
        let mut run = net();
        run.integrator = family(steps);
        let before = bits(&run.state);
        let Run { integrator, system, state, h } = &mut run;
        let error = integrator.step(system, state, *h, &mut PhaseClock::off());
        assert!(matches!(error, Err(StepError::NeedsPrepare)), "{error:?}");
        integrator.prepare(system, *h).expect("supported");
        state.x.pop();
        let error = integrator.step(system, state, *h, &mut PhaseClock::off());
        assert!(matches!(error, Err(StepError::SizeMismatch { .. })), "{error:?}");
        state.x.push(Vec3::new(0.3, 0.2, -0.6));
        assert_eq!(bits(state), before);
    }
}

#[test]
fn overflow_is_an_error_that_leaves_the_state_alone_or_a_result() {
    for (family, steps) in all() {
        let mut run = moving(family, steps);
        let before = bits(&run.state);
        run.h = super::seconds(1e200);
        let Run { integrator, system, state, h } = &mut run;
        match integrator.step(system, state, *h, &mut PhaseClock::off()) {
            Ok(_) => (0..3).for_each(|_| {
                let _ = integrator.step(system, state, *h, &mut PhaseClock::off());
            }),
            Err(error) => {
                assert!(matches!(error, StepError::Solver(_)), "{error}");
                assert_eq!(bits(state), before, "{family:?}, {steps:?}");
            }
        }
        // Far beyond its limit an explicit method blows up without a panic.
        assert!(run.system.scale_stiffness("tension", 1e12));
        run.state = build(&tetrahedron(DampingLaw::Full)).1;
        run.h = super::seconds(H);
        for _ in 0..200 {
            let Run { integrator, system, state, h } = &mut run;
            if integrator.step(system, state, *h, &mut PhaseClock::off()).is_err() {
                break;
            }
        }
    }
}

//! A step allocates nothing: not the first, not after a change of step size, stiffness, damping,
//! masses or pins, not in contact, with neither law of damping.

use drape_integrator::PhaseClock;
use drape_model::{DampingLaw, EffectKind, KeyframeSpec, ObstacleSpec, State, System};
use drape_oracle::scenes;
use drape_tests::{
    METHODS, Run, Sheet, assert_covers, build, bundled, prepared, seconds, stiffening, takes,
};

/// Beside those that every test goes through.
const MORE: [&str; 12] = [
    "leapfrog:step=bound",
    "imex-euler:implicit=springs,matrix=rebuilt",
    "imex-euler:preconditioner=none,start=last",
    "imex-updated:forcing_term=1e-9,newton_above=1e300",
    "imex-updated:max_outer=1",
    "imex-updated:safeguard=paper,forcing=eisenstat-walker",
    "imex-euler:tolerance=0.1,implicit=springs,estimator=splitting,solver=cholesky",
    "imex-updated:safeguard=paper,solver=cholesky",
    "imex-updated:start=last,implicit=tension,preconditioner=jacobi",
    "baraff-witkin:contact=position,hessian=raw,solver=cholesky",
    "projective:solver=cg,acceleration=anderson,memory=1",
    "projective:acceleration=lbfgs,iterations=100,residual=1e-9",
];

const SHEET: Sheet = Sheet {
    side: 15,
    tension: 1e4,
    shear: 1e3,
    damping: 10.0,
    law: DampingLaw::Full,
    gravity: scenes::GRAVITY,
    pinned: true,
};

fn allocations(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![0; 10]))), 1);
    // Preparing does allocate.
    let count = allocations(|| drop(prepared("imex-euler", bundled("hanging-textile-1e4"), 0.01)));
    assert!(count > 10, "{count}");
}

#[test]
fn steps_allocate_nothing_with_any_method_on_any_kind_of_scene() {
    assert_covers("allocations", METHODS, &[]);
    for scene in ["hanging-textile-1e4", "hanging-textile-sheared-1e6", "square-table-1e4"] {
        let (system, mut state) = bundled(scene);
        // Start in contact where there is a table.
        state.x.iter_mut().for_each(|x| x.z -= 0.01);
        for id in METHODS.into_iter().chain(MORE) {
            check(id, scene, (system.clone(), state.clone()));
        }
    }
}

/// Hinges couple four particles, each pair of them more than once.
#[test]
fn steps_with_hinges_allocate_nothing() {
    for id in [
        "symplectic-euler",
        "backward-euler",
        "backward-euler:solver=multigrid",
        "backward-euler:jacobian=saved,solver=cg",
        "baraff-witkin",
        "imex-euler",
    ] {
        check(id, "drape-test", bundled("drape-test"));
    }
}

/// From 1000 particles on, Newton's default solver takes single precision, or keeps the coarse
/// matrices of multigrid.
#[test]
fn steps_of_large_sheets_allocate_nothing_with_newtons_default_solver() {
    for tension in [1e4, 1e7] {
        for id in ["backward-euler", "bdf2", "dirk", "midpoint", "generalized-alpha"] {
            let sheet = Sheet { side: 34, tension, shear: 0.1 * tension, ..SHEET };
            check(id, &format!("a large sheet, {tension:e}"), sheet.build());
        }
    }
}

/// Its remainder beside the linear part, and its directions, need memory of their own.
#[test]
fn steps_with_projected_damping_allocate_nothing() {
    let law = DampingLaw::Projected;
    for id in METHODS.into_iter().chain(MORE) {
        check(id, "a sheet with projected damping", Sheet { law, ..SHEET }.build());
    }
}

/// With a matrix that changes whenever a spring changes piece, too.
#[test]
fn steps_with_springs_of_two_slopes_allocate_nothing() {
    let start = build(&stiffening(scenes::bundled("hanging-textile-1e4"), 100.0));
    let paper = [
        "imex-euler:split=paper",
        "imex-euler:split=paper,tolerance=0.1",
        "imex-updated:split=paper",
    ];
    for id in METHODS.into_iter().chain(paper) {
        check(id, "a sheet of two slopes", start.clone());
    }
}

/// Pins and a rough obstacle on paths.
#[test]
fn steps_under_led_pins_and_friction_allocate_nothing() {
    let mut spec = SHEET.spec();
    let path = || vec![KeyframeSpec { time_s: 1.0, offset_m: [0.5, 0.1, 0.2] }];
    spec.pins.iter_mut().for_each(|pin| pin.path = path());
    for obstacles in [false, true] {
        if obstacles {
            spec.obstacles.push(ObstacleSpec::Plane {
                point_m: [0.0, 0.0, 0.001],
                normal: [0.0, 0.0, 1.0],
                restitution: 0.2,
                friction: 0.3,
                path: path(),
            });
        }
        for id in METHODS.into_iter().chain(MORE) {
            check(id, "a sheet on led pins", build(&spec));
        }
    }
}

/// A scene that the method refuses is left out: the tests of refusals name them.
fn check(id: &str, scene: &str, system: (System, State)) {
    if !takes(id, &system.0) {
        return;
    }
    let mut run = prepared(id, system, 0.01);
    let heavier: Vec<f64> = run.system.mass().iter().map(|m| 1.25 * m).collect();
    let mut clock = PhaseClock::on();
    // The first change of a curve that several springs share copies it; no step does.
    assert!(run.system.scale_stiffness(EffectKind::Tension, 1.0));
    let count = allocations(|| {
        let mut step = |run: &mut Run, h: f64| {
            let Run { integrator, system, state, .. } = run;
            let outcome = integrator.step(system, state, seconds(h), &mut clock);
            assert!(outcome.is_ok(), "{id} on {scene}");
        };
        let h = run.h;
        (0..4).for_each(|_| step(&mut run, h));
        step(&mut run, 0.005);
        assert!(run.system.scale_stiffness(EffectKind::Tension, 0.5));
        step(&mut run, 0.005);
        assert!(run.system.scale_damping(EffectKind::Tension, 2.0));
        step(&mut run, 0.005);
        assert!(run.system.set_mass(&heavier));
        step(&mut run, 0.005);
        assert!(run.system.set_pinned(210, true) && run.system.set_pinned(0, false));
        step(&mut run, 0.005);
        run.integrator.restart(&run.state);
        (0..4).for_each(|_| step(&mut run, h));
    });
    assert_eq!(count, 0, "{id} on {scene}");
}

//! Pins on paths, contacts, friction, air, other frames; and the energy ledger in all of them.

use super::{ALL, run};
use drape_integrator::SolveStatus;
use drape_model::{
    AirSpec, AngularLaw, DampingLaw, DragSpec, KeyframeSpec, ObstacleSpec, State, System, Vec3,
    WindSpec,
};
use drape_oracle::scenes::{
    Sheet, build, floor, gravity, particles, stiffening, stir, tension, uneven,
};
use drape_oracle::{apart, largest, seconds};

fn frame(time_s: f64, offset_m: [f64; 3]) -> KeyframeSpec {
    KeyframeSpec { time_s, offset_m }
}

/// A sheet with a pin on a path, over a rough sphere on another.
fn led(law: DampingLaw) -> (System, State) {
    let mut spec = Sheet { law, ..Sheet::default() }.spec();
    spec.pins[0].path = vec![frame(0.06, [0.1, -0.1, 0.05]), frame(0.1, [0.1, -0.1, 0.0])];
    spec.obstacles.push(ObstacleSpec::Sphere {
        center_m: [0.05, 0.02, -0.41],
        radius_m: 0.4,
        restitution: 0.3,
        friction: 0.4,
        path: vec![frame(1.0, [0.3, 0.0, 0.8])],
    });
    stir(build(&spec), 0.0, 0.5)
}

/// A sheet that resists by its angles too, in a wind.
fn in_a_wind() -> (System, State) {
    let mut scene = Sheet { shear: 0.0, ..Sheet::default() }.scene();
    let law = |stiffness_n_m| Some(AngularLaw { stiffness_n_m });
    scene.effects.shear_angle = law(2e-3);
    scene.effects.bending_angle = law(2e-4);
    scene.effects.bending_hinge = law(2e-4);
    scene.effects.air = Some(AirSpec {
        drag: DragSpec::Quadratic { coefficient: 1.0, density_kg_m3: 1.2 },
        wind: Some(WindSpec { velocity_m_s: [1.0, 0.0, 3.0], gust: None }),
    });
    let (system, state) =
        build(&scene.discretise().unwrap_or_else(|violation| panic!("{violation}")));
    stir(uneven((system, state)), 0.0, 0.5)
}

/// The terms of the ledger add up to the change of energy, however many iterations were taken.
#[test]
fn the_ledger_explains_every_step() {
    let two_slopes = || stir(build(&stiffening(Sheet::default().spec(), 10.0)), 0.01, 0.5);
    let projected = Sheet { law: DampingLaw::Projected, pinned: false, ..Sheet::default() };
    for acceleration in ALL {
        for iterations in [1, 12] {
            let text = format!("acceleration={acceleration},iterations={iterations}");
            for (scene, start) in [
                ("led", led(DampingLaw::Full)),
                ("led, projected", led(DampingLaw::Projected)),
                ("wind", in_a_wind()),
                ("two slopes", two_slopes()),
                ("projected", stir(uneven(projected.build()), 0.01, 0.5)),
            ] {
                let mut run = run(&text, start, 0.004);
                for n in 0..40 {
                    let (before, energy) = (run.state.clone(), run.energy());
                    run.step();
                    let ledger =
                        run.integrator.ledger(&run.system, &before, &run.state, seconds(run.h));
                    let Some(ledger) = ledger else { panic!("{text}: no ledger") };
                    let off = (ledger.sum() - (run.energy() - energy)).abs() / ledger.magnitude();
                    assert!(off < 1e-8, "{text}, {scene}, step {n}: {off:e}");
                    if let Some(pin) = run.system.moving_pins().first() {
                        let off = (run.state.x[pin.particle] - pin.position(run.state.t)).norm();
                        assert!(off < 1e-14, "{text}, {scene}, step {n}: pin off by {off:e}");
                    }
                }
            }
        }
    }
}

/// A stiff pair falls on the floor, stays on it and stands still.
#[test]
fn what_falls_comes_to_rest_on_the_floor() {
    for acceleration in ALL {
        let x = [Vec3::new(0.0, 0.0, 0.3), Vec3::new(0.5, 0.0, 0.3)];
        let mut spec = particles(&[0.1; 2], &x, &[Vec3::zeros(); 2]);
        spec.springs = vec![tension((0, 1), 0.5, 1e3, 0.1)];
        spec.effects.gravity = gravity();
        spec.obstacles = vec![floor(0.0)];
        let mut run = run(&format!("acceleration={acceleration}"), build(&spec), 0.01);
        let start = run.energy();
        for n in 0..300 {
            let report = run.step();
            assert_eq!(report.solve, SolveStatus::Converged, "{acceleration}: {report:?}");
            assert!(run.energy() <= start, "{acceleration}, step {n}: {} J", run.energy());
        }
        assert!(largest(&run.state.v) < 1e-12, "{acceleration}: {:?}", run.state.v);
        assert!(run.state.x.iter().all(|x| x.z.abs() < 1e-9), "{acceleration}: {:?}", run.state.x);
    }
}

/// A sheet slides down a rough ball; with contacts conjugate gradients solve the global step.
#[test]
fn a_sheet_on_a_rough_ball_is_held_outside_and_gains_no_energy() {
    for acceleration in ALL {
        let sheet = Sheet { side: 8, tension: 1e5, shear: 1e4, pinned: false, ..Sheet::default() };
        let mut spec = sheet.spec();
        spec.obstacles.push(ObstacleSpec::Sphere {
            center_m: [0.07, 0.03, -0.31],
            radius_m: 0.3,
            restitution: 0.0,
            friction: 0.3,
            path: Vec::new(),
        });
        let text = format!("acceleration={acceleration},iterations=20");
        let mut run = run(&text, build(&spec), 0.005);
        let start = run.energy();
        let mut iterations = 0;
        for n in 0..80 {
            let report = run.step();
            iterations += report.cg_iterations;
            let ball = &run.system.obstacles()[0];
            let deepest =
                run.state.x.iter().map(|x| ball.distance(x).0).fold(f64::INFINITY, f64::min);
            assert!(deepest > -0.01, "{acceleration}, step {n}: {deepest} m");
            assert!(run.energy() <= start + 1e-6, "{acceleration}, step {n}: energy");
        }
        assert!(iterations > 100, "{acceleration}: {iterations}");
    }
}

/// In a frame that moves at 100 m/s the same steps are taken.
#[test]
fn the_shape_does_not_depend_on_the_frame() {
    let velocity = Vec3::new(30.0, -60.0, 70.0);
    let scene = |boost: Vec3| {
        let mut spec = Sheet { side: 6, ..Sheet::default() }.spec();
        for pin in &mut spec.pins {
            pin.path = vec![frame(1.0, boost.into())];
        }
        let (system, mut state) = stir(build(&spec), 0.02, 0.5);
        state.v.iter_mut().for_each(|v| *v += boost);
        (system, state)
    };
    for acceleration in ALL {
        let text = format!("acceleration={acceleration}");
        let end = |boost| {
            let mut run = run(&text, scene(boost), 0.004);
            run.steps(50);
            let t = run.state.t;
            run.state.x.iter().map(|x| x - boost * t).collect::<Vec<_>>()
        };
        let off = apart(&end(Vec3::zeros()), &end(velocity));
        assert!(off < 1e-10, "{acceleration}: {off:e} m");
    }
}

/// Overflow is a result, and nothing of it stays.
#[test]
fn after_an_overflow_the_next_step_is_that_of_a_new_integrator() {
    for acceleration in ALL {
        let text = format!("acceleration={acceleration},iterations=15");
        let mut spoilt = run(&text, stir(Sheet::default().build(), 0.0, 1.0), 0.01);
        let good = spoilt.state.clone();
        spoilt.state.v[7].x = 1e300;
        spoilt.step();
        spoilt.state.v[7].x = f64::NAN;
        spoilt.step();
        spoilt.state = good;
        spoilt.restart();
        let mut new = run(&text, (spoilt.system.clone(), spoilt.state.clone()), 0.01);
        spoilt.step();
        new.step();
        assert_eq!(spoilt.state, new.state, "{acceleration}");
    }
}

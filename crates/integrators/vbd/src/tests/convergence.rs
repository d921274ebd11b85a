//! The sweeps converge to the minimiser of backward Euler, at the known rate.

use super::support::{backward_euler, distance, leapfrog, prepared, settings, sheet};
use crate::Vbd;
use drape_model::{
    AirSpec, AngularLaw, DampingLaw, DragSpec, GravitySpec, KeyframeSpec, ObstacleSpec,
    SpringEffect, State, System, SystemSpec, Vec3, WindSpec,
};
use drape_oracle::scenes::{Sheet, anchored, build, stiffening, stir, uneven};
use drape_oracle::{Run, apart, bits};
use std::num::NonZero;

const H: f64 = 0.01;

/// A step of [`H`] from the sheet at 0.2 s: the state before, and the end of backward Euler's step.
fn problem(theta: f64) -> (System, State, State) {
    let stiffness = theta / (H * H);
    let (system, mut state) = sheet(stiffness, 0.0);
    leapfrog(&system, &mut state, 0.2, 0.7 * 2.0 / (4.35 * stiffness).sqrt());
    let mut exact = state.clone();
    backward_euler(&system, &mut exact, H);
    (system, state, exact)
}

/// The error that sweeps from the inertial target leave, over that of the target.
fn left((system, state, exact): &(System, State, State), text: &str) -> f64 {
    let mut target = state.x.clone();
    for i in (0..target.len()).filter(|&i| !system.pinned()[i]) {
        target[i] += state.v[i] * H + Vec3::z() * (-9.81 * H * H);
    }
    let mut run = prepared(&format!("start=inertial,{text}"), (system.clone(), state.clone()), H);
    run.step();
    distance(&run.state.x, &exact.x) / distance(&target, &exact.x)
}

#[test]
fn the_error_after_some_sweeps_is_known() {
    let soft = problem(1.0);
    let stiff = problem(100.0);
    for (problem, text, expected) in [
        (&soft, "sweeps=10", 3.658e-4),
        (&soft, "sweeps=12", 8.974e-5),
        (&soft, "sweeps=30", 2.986e-10),
        (&soft, "sweeps=30,chebyshev=0.95", 2.378e-4),
        (&soft, "sweeps=30,chebyshev=0.99", 5.300e-2),
        (&stiff, "sweeps=10", 5.490e-1),
        (&stiff, "sweeps=100", 2.030e-1),
        (&stiff, "sweeps=30,chebyshev=0.95", 1.981e-1),
        (&stiff, "sweeps=30,chebyshev=0.99", 4.912e-2),
        (&stiff, "sweeps=44,chebyshev=0.99", 9.298e-3),
    ] {
        let found = left(problem, text);
        assert!((found / expected - 1.0).abs() < 2e-3, "{text}: {found:e}, not {expected:e}");
    }
}

/// A sheet with every implicit effect at once: springs of two slopes, angles, hinges, wind.
fn everything(law: DampingLaw) -> SystemSpec {
    let mut scene = Sheet { law, ..Sheet::default() }.scene();
    let angular = |stiffness_n_m| Some(AngularLaw { stiffness_n_m });
    scene.effects.shear_angle = angular(2e-3);
    scene.effects.bending_angle = angular(2e-4);
    scene.effects.bending_hinge = angular(2e-4);
    scene.effects.air = Some(AirSpec {
        drag: DragSpec::Quadratic { coefficient: 1.0, density_kg_m3: 1.2 },
        wind: Some(WindSpec { velocity_m_s: [1.0, 0.0, 3.0], gust: None }),
    });
    stiffening(scene.discretise().unwrap_or_else(|violation| panic!("{violation}")), 10.0)
}

fn frame(time_s: f64, offset_m: [f64; 3]) -> KeyframeSpec {
    KeyframeSpec { time_s, offset_m }
}

/// The greatest distance of five steps from those of backward Euler, m, and the way, m.
fn from_newton(text: &str, spec: &SystemSpec) -> (f64, f64) {
    let (system, state) = uneven(stir(build(spec), 1e-2, 0.5));
    let start = state.x.clone();
    let mut run = prepared(text, (system, state), 0.004);
    let mut worst: f64 = 0.0;
    for _ in 0..5 {
        let mut exact = run.state.clone();
        // A pin moves as its path says.
        run.system.clear_pinned(&mut exact.v);
        let end = exact.t + run.h;
        let led: Vec<_> =
            run.system.moving_pins().iter().map(|p| (p.particle, p.position(end))).collect();
        for &(i, x) in &led {
            exact.v[i] = (x - exact.x[i]) / run.h;
        }
        backward_euler(&run.system, &mut exact, run.h);
        run.step();
        worst = worst.max(apart(&run.state.x, &exact.x));
    }
    (worst, apart(&run.state.x, &start))
}

#[test]
fn every_effect_and_both_laws_of_damping_are_those_of_backward_euler() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for text in ["sweeps=40", "sweeps=60,start=previous,chebyshev=0.3"] {
            let mut spec = everything(law);
            let (still, way) = from_newton(text, &spec);
            assert!(still < 1e-11 && way > 0.01, "{law:?}, {text}: {still:e} of {way}");
            spec.pins[0].path = vec![frame(0.1, [0.05, -0.1, 0.02])];
            let (led, way) = from_newton(text, &spec);
            assert!(led < 1e-11 && way > 0.01, "{law:?}, {text}, led: {led:e} of {way}");
        }
    }
}

/// A smooth sphere below the sheet: blocks of particles in contact are filtered.
#[test]
fn contacts_lead_the_blocks_as_they_lead_newtons_method() {
    let mut spec = Sheet { pinned: false, ..Sheet::default() }.spec();
    spec.obstacles.push(ObstacleSpec::sphere([0.05, 0.02, -0.42], 0.4, 0.0));
    let (off, way) = from_newton("sweeps=100", &spec);
    assert!(off < 1e-10 && way > 0.01, "{off:e} of {way}");
    let (system, mut state) = build(&spec);
    state.v.fill(Vec3::new(0.0, 0.0, -1.0));
    let mut run = prepared("", (system, state), 0.004);
    run.steps(50);
    let obstacle = &run.system.obstacles()[0];
    let deepest = run.state.x.iter().map(|x| obstacle.distance(x).0).fold(0.0, f64::min);
    assert!(deepest > -1e-2 && run.state.is_finite(), "{deepest}");
}

/// A single block under a contact is Newton's method in the plane: a few sweeps end at round-off.
/// The block of the free particle would take a share of each change away, and converge slowly.
#[test]
fn a_block_in_contact_is_newtons_method_along_the_surface() {
    let springs = [(SpringEffect::Tension, 1.3, 1e5, 0.0)];
    let mut spec = anchored(1.0, &springs, Vec3::new(1.0, 0.0, -1.0), Vec3::new(1.0, 0.3, 0.0));
    spec.effects.gravity = Some(GravitySpec { m_s2: [0.0, 0.0, -2e3] });
    spec.obstacles.push(ObstacleSpec::plane([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], 0.0));
    let end = |text: &str| {
        let mut run = prepared(text, build(&spec), H);
        run.step();
        run.state.x[1]
    };
    let [few, many] = ["sweeps=7", "sweeps=1000"].map(end);
    assert!(many.z == -1.0 && (many.x - 1.0).abs() > 1e-3, "{many:?}");
    assert!((few - many).norm() < 1e-12, "{few:?}, not {many:?}");
}

#[test]
fn a_change_of_stiffness_damping_mass_or_pins_is_followed() {
    let (system, state) = stir(Sheet::default().build(), 1e-2, 0.5);
    let mut run = prepared("", (system, state), 0.004);
    run.steps(3);
    for change in 0..4 {
        let is_changed = match change {
            0 => run.system.scale_stiffness(drape_model::EffectKind::Tension, 3.0),
            1 => run.system.scale_damping(drape_model::EffectKind::Shear, 0.5),
            2 => run.system.set_pinned(17, true),
            _ => {
                let heavier: Vec<_> = run.system.mass().iter().map(|m| 2.0 * m).collect();
                run.system.set_mass(&heavier)
            }
        };
        assert!(is_changed);
        let fresh = Box::new(Vbd::new(settings("")));
        let mut fresh = Run::new(fresh, (run.system.clone(), run.state.clone()), run.h);
        for _ in 0..3 {
            run.step();
            fresh.step();
            assert_eq!(bits(&run.state), bits(&fresh.state), "change {change}");
        }
    }
}

#[test]
fn three_threads_give_the_bits_of_one() {
    let sheet = Sheet { side: 130, tension: 1e5, shear: 1e4, ..Sheet::default() };
    let [one, three] = [1, 3].map(|threads| {
        let (mut system, state) = stir(sheet.build(), 1e-3, 0.1);
        system.set_threads(NonZero::new(threads).unwrap_or(NonZero::<usize>::MIN));
        let mut run = prepared("sweeps=3", (system, state), 1e-3);
        run.steps(2);
        bits(&run.state)
    });
    assert!(one == three);
}

/// Stiffnesses that rise from what inertia resolves carry long waves first.
#[test]
fn augmented_sweeps_come_closer_where_plain_ones_do_not_converge() {
    let (system, start) = sheet(1e6, 40.0);
    let mut exact = start.clone();
    for _ in 0..30 {
        backward_euler(&system, &mut exact, H);
    }
    let off = |text: &str| {
        let mut run = prepared(text, (system.clone(), start.clone()), H);
        run.steps(30);
        distance(&run.state.x, &exact.x) / distance(&start.x, &exact.x)
    };
    let [plain, augmented] = ["", "augmented=true"].map(off);
    assert!((plain - 0.2547).abs() < 1e-3, "{plain}");
    assert!((augmented - 0.0803).abs() < 1e-3, "{augmented}");
}

#[test]
fn bending_springs_are_springs() {
    let mut spec = Sheet::default().spec();
    let bending: Vec<_> = (0..3_usize)
        .map(|i| drape_oracle::scenes::spring(SpringEffect::Bending, (i, i + 2), 0.5, 1.0, 0.0))
        .collect();
    spec.springs.extend(bending);
    let (off, way) = from_newton("sweeps=100", &spec);
    assert!(off < 1e-11 && way > 0.01, "{off:e} of {way}");
}

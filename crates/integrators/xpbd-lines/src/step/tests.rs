//! Recurrences, laws, orders, and the numbers of the crate's docs.

use crate::XpbdLines;
use crate::settings::XpbdLinesSettings;
use drape_integrator::Integrator;
use drape_model::{
    DampingLaw, Effect, EffectKind, Part, SpringEffect, SpringLaw, State, System, Vec3,
};
use drape_oracle::checks::{self, H, Known, MASS, PARAMETERS, contact, rise};
use drape_oracle::laws::{Drift, spin};
use drape_oracle::order::position_error;
use drape_oracle::recurrence::{
    Multistep, Recurrence, backward_euler, factored_backward_euler, factored_bdf2, factored_start,
};
use drape_oracle::scenes::{
    Sheet, anchored, angular, build, particles, stiffening, stir, tension, uneven, waving,
};
use drape_oracle::{Random, Run, bits};
use nalgebra::{DMatrix, DVector, Vector2};

fn new(settings: &str) -> Box<dyn Integrator> {
    let pairs = settings.split(',').filter_map(|pair| pair.split_once('='));
    let settings = XpbdLinesSettings::from_pairs(pairs).unwrap_or_else(|error| panic!("{error}"));
    Box::new(XpbdLines::new(settings))
}

fn run(settings: &str, start: (System, State), h: f64) -> Run {
    Run::new(new(settings), start, h)
}

/// The recurrence of a substep after so many others of the same length.
fn rule(law: DampingLaw, is_second: bool, earlier: usize, theta: f64, eta: f64) -> Recurrence {
    match (law, is_second, earlier) {
        (DampingLaw::Full, _, 0) => factored_start(theta, eta).into(),
        (DampingLaw::Full, false, _) => factored_backward_euler(theta, eta).into(),
        (DampingLaw::Full, true, _) => factored_bdf2(1.0, theta, eta),
        (DampingLaw::Projected, true, 1..) => Multistep::bdf(&[1.0]).recurrence(theta, 0.0, eta),
        (DampingLaw::Projected, ..) => backward_euler(theta, eta).into(),
    }
}

/// A particle on a spring of rest length 0: along each axis the recurrence; with projected damping
/// along the axis of the spring.
#[test]
fn one_spring_moves_by_the_recurrence_of_its_damping() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for (order, substeps) in [1, 2].iter().flat_map(|o| [1, 4, 20].map(|n| (*o, n))) {
            for (theta, eta) in PARAMETERS {
                let (x, v) = match law {
                    DampingLaw::Full => (Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0)),
                    DampingLaw::Projected => (Vec3::x() * 0.8, Vec3::x() * -3.0),
                };
                let h = H / f64::from(substeps);
                let (k, c) = checks::coefficients(theta, eta, h);
                let mut spec = anchored(MASS, &[(SpringEffect::Tension, 0.0, k, c)], x, v);
                spec.damping = law;
                let mut run = run(&format!("substeps={substeps},order={order}"), build(&spec), H);
                let mut levels = [0, 1, 2].map(|axis| vec![Vector2::new(x[axis], h * v[axis])]);
                for step in 0..60 {
                    run.step();
                    for (axis, levels) in levels.iter_mut().enumerate() {
                        let mut largest = 1e-100_f64;
                        for part in 0..substeps {
                            let earlier = (step * substeps + part) as usize;
                            let rule = rule(law, order == 2, earlier, theta, eta);
                            largest = levels.iter().map(|y| y.norm()).fold(largest, f64::max);
                            levels.insert(0, rule.next(levels));
                            levels.truncate(2);
                        }
                        let found = Vector2::new(run.state.x[1][axis], h * run.state.v[1][axis]);
                        let off = (found - levels[0]).norm() / largest.max(levels[0].norm());
                        assert!(
                            off < 1e-11,
                            "{law:?} {order} θ={theta} η={eta} {substeps}, step {step}: {off:e}"
                        );
                    }
                }
            }
        }
    }
}

/// Ratios of steps from 1/2 to 2 are bridged by the formula for two unequal steps.
#[test]
fn steps_of_unequal_size_follow_the_formula_of_unequal_steps() {
    let (theta, eta) = (0.36, 0.06);
    let (k, c) = checks::coefficients(theta, eta, H);
    let springs = [(SpringEffect::Tension, 0.0, k, c)];
    let mut run = run("substeps=1", build(&anchored(MASS, &springs, Vec3::x(), Vec3::x())), H);
    let mut levels = vec![Vector2::new(1.0, 1.0)];
    let mut last: Option<f64> = None;
    for ratio in [1.0, 2.0, 1.5, 0.75, 3.0, 1.25, 0.625, 1.25, 0.75, 1.0] {
        let (theta, eta) = (theta * ratio * ratio, eta * ratio);
        let known: Vec<_> = levels.iter().map(|y| Vector2::new(y.x, ratio * H * y.y)).collect();
        let omega = last.map(|last| ratio / last).filter(|omega| (0.5..=2.0).contains(omega));
        let rule: Recurrence = match omega {
            None => factored_start(theta, eta).into(),
            Some(omega) => factored_bdf2(omega, theta, eta),
        };
        let next = rule.next(&known);
        run.step_by(ratio * H);
        let found = Vector2::new(run.state.x[1].x, run.state.v[1].x);
        let next = Vector2::new(next.x, next.y / (ratio * H));
        assert!((found - next).norm() < 1e-11 * next.norm(), "{ratio}: {found} {next}");
        levels.insert(0, next);
        levels.truncate(2);
        last = Some(ratio);
    }
}

/// A chain in space of particles and springs that differ, on a pin.
fn chain(count: usize, law: DampingLaw, damping: f64) -> (System, State) {
    let mut random = Random::new(7);
    let mut x = vec![Vec3::zeros()];
    for i in 1..count {
        x.push(x[i - 1] + Vec3::x() + random.vector() * 0.8);
    }
    let v: Vec<Vec3> = (0..count).map(|_| random.vector()).collect();
    let masses: Vec<f64> = (0..count).map(|_| random.between(0.5, 2.0)).collect();
    let mut spec = particles(&masses, &x, &v);
    spec.damping = law;
    spec.springs = (1..count)
        .map(|i| tension((i - 1, i), random.between(0.7, 1.4), random.between(1e3, 1e5), damping))
        .collect();
    build(&spec)
}

/// (L5) and (L6) on a line that kinks, by a dense solve.
#[test]
fn a_line_is_one_newton_step() {
    for damping in [0.0, 30.0] {
        let count = 9;
        let (system, start) = chain(count, DampingLaw::Projected, damping);
        let y: Vec<Vec3> = start.x.iter().zip(&start.v).map(|(x, v)| x + v * H).collect();
        let (mut list, mut rests) = (Vec::new(), Vec::new());
        for split in system.effects().filter_map(Effect::split) {
            split.visit_rest_lengths(&mut |_, _, rest| rests.push(rest));
            split.visit_weights(&mut |i, j, k, c| list.push((i, j, k * H * H, c * H)));
        }
        assert_eq!(list.len(), count - 1);
        let n = list.len();
        let gradients = DMatrix::from_fn(n, 3 * count, |s, column| {
            let (i, j, ..) = list[s];
            let u = (y[i] - y[j]).normalize();
            let sign = [(i, 1.0), (j, -1.0)].iter().find(|(p, _)| *p == column / 3).map(|p| p.1);
            sign.unwrap_or(0.0) * u[column % 3]
        });
        let weights = DMatrix::from_fn(3 * count, 3 * count, |a, b| {
            if a == b { 1.0 / system.mass()[a / 3] } else { 0.0 }
        });
        let coupling = &gradients * &weights * gradients.transpose();
        let matrix = DMatrix::from_fn(n, n, |s, t| {
            let unit = if s == t { 1.0 } else { 0.0 };
            unit + (list[s].2 + list[s].3) * coupling[(s, t)]
        });
        let right = DVector::from_fn(n, |s, _| {
            let (i, j, a, g) = list[s];
            let (d, apart) = (y[i] - y[j], (start.v[i] - start.v[j]) * H);
            -(a * (d.norm() - rests[s]) + g * d.normalize().dot(&apart))
        });
        let solved = matrix.lu().solve(&right).unwrap_or_else(|| panic!("regular"));
        let moved = weights * gradients.transpose() * solved;
        let mut run = run("substeps=1,order=1", (system, start), H);
        run.step();
        for (i, (found, y)) in run.state.x.iter().zip(&y).enumerate() {
            let expected = y + Vec3::new(moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]);
            assert!((found - expected).norm() < 1e-12, "{damping}, {i}: {found:?} {expected:?}");
        }
    }
}

/// The full damping of a line is solved at once, too: `(M + h L_c) v₊ = M v` where springs are limp.
#[test]
fn the_full_damping_of_a_line_is_one_solve() {
    let (mut system, start) = chain(9, DampingLaw::Full, 30.0);
    assert!(system.scale_stiffness(SpringEffect::Tension, 1e-20));
    let before = start.v.clone();
    let mut run = run("substeps=1,order=1", (system.clone(), start), H);
    run.step();
    let v = &run.state.v;
    let mut off: Vec<Vec3> = (0..v.len()).map(|i| (v[i] - before[i]) * system.mass()[i]).collect();
    for split in system.effects().filter_map(Effect::split) {
        split.visit_weights(&mut |i, j, _, c| {
            let pull = (v[i] - v[j]) * (c * H);
            off[i] += pull;
            off[j] -= pull;
        });
    }
    assert!(off.iter().all(|off| off.norm() < 1e-12), "{off:?}");
}

/// On a straight line nothing is left for a second sweep; a list of single springs needs hundreds.
#[test]
fn a_straight_line_is_solved_at_once_to_round_off() {
    let count = 40;
    let x: Vec<Vec3> = (0..count).map(|i| Vec3::x() * 1.1 * i as f64).collect();
    let mut spec = particles(&vec![1e-3; count], &x, &[]);
    spec.springs = (1..count).map(|i| tension((i - 1, i), 1.0, 1e5, 0.0)).collect();
    let [one, two] = ["substeps=1", "substeps=1,iterations=2"].map(|settings| {
        let mut run = run(settings, build(&spec), 0.01);
        run.step();
        run.state.x
    });
    let off = one.iter().zip(&two).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(off < 1e-11, "{off:e}");
    assert!((1.8..1.95).contains(&one[0].x), "the ends have come in: {}", one[0].x);
}

/// Stretched, compressed, fast, damped along the spring: the length after the sweep tells.
#[test]
fn a_sweep_multiplies_the_spin_by_the_length_over_the_predicted_one() {
    for (theta, length) in [0.01, 1.0, 1e4].iter().flat_map(|t| [0.6, 1.0, 2.5].map(|l| (t, l))) {
        for damping in [0.0, 3.0] {
            let velocities = [Vec3::new(3.0, -7.0, 2.0), Vec3::new(-1.0, 4.0, 8.0)];
            let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), Vec3::x() * length], &velocities);
            spec.damping = DampingLaw::Projected;
            spec.springs = vec![tension((0, 1), 1.0, 0.5 * theta * MASS / (H * H), damping)];
            let mut run = run("substeps=1,order=1", build(&spec), H);
            for step in 0..50 {
                let (d, v) = checks::pair(&run.state);
                run.step();
                let (after, v_after) = checks::pair(&run.state);
                let expected = d.cross(&v) * spin::xpbd((d + v * H).norm(), after.norm());
                let off = (after.cross(&v_after) - expected).norm();
                assert!(off < 1e-11, "θ={theta}, step {step}: {off:e}");
            }
        }
    }
}

#[test]
fn an_unpinned_sheet_falls_on_its_parabola_and_keeps_its_momentum() {
    for (settings, drift) in [
        ("substeps=1,order=1", Drift::NewVelocity),
        ("substeps=20,order=1", Drift::Substeps(20)),
        ("substeps=8,order=1,iterations=3", Drift::Substeps(8)),
        ("substeps=1", Drift::Bdf2AfterBackwardEuler),
    ] {
        checks::falls_freely(settings, new(settings), drift, 1e-11);
        for law in [DampingLaw::Full, DampingLaw::Projected] {
            let sheet = Sheet { tension: 1e6, shear: 1e5, damping: 8.0, law, ..Sheet::free() };
            let start = uneven(stir(sheet.build(), 0.1, 3.0));
            let drift = checks::momentum_drift(new(settings), start, 0.004);
            assert!(drift < 1e-14, "{law:?}, {settings}: momentum drifts by {drift:e}");
        }
    }
}

/// Observed order over the last halvings.
fn order(known: &Known, settings: &str) -> f64 {
    known.order(|| new(settings), &[40, 80, 160]).order
}

/// A sheet in motion in which no spring is stiff.
fn smooth(law: DampingLaw, damping: f64) -> Known {
    let sheet = Sheet { side: 6, tension: 1e3, shear: 1e2, damping, law, ..Sheet::default() };
    Known::new(waving(sheet.build()), 0.2)
}

/// Full damping knows what springs do, and costs no order; along the springs one sweep costs one.
#[test]
fn the_order_is_2_and_1_where_projected_damping_is_swept_once() {
    use DampingLaw::{Full, Projected};
    for (law, damping, settings, expected) in [
        (Full, 5.0, "substeps=4", 2.0),
        (Full, 0.0, "substeps=10", 2.0),
        (Full, 5.0, "substeps=4,iterations=2", 2.0),
        (Full, 5.0, "substeps=4,order=1", 1.0),
        (Projected, 0.0, "substeps=4", 2.0),
        (Projected, 5.0, "substeps=10", 1.0),
        (Projected, 5.0, "substeps=4,iterations=2", 2.0),
    ] {
        let found = order(&smooth(law, damping), settings);
        assert!((found - expected).abs() < 0.2, "{law:?}, {damping}, {settings}: {found}");
    }
}

/// Angles, hinges, springs of two slopes.
#[test]
fn other_constraints_have_the_order_too() {
    let sheet = Sheet { side: 5, shear: 0.0, damping: 0.0, ..Sheet::default() };
    let spec = angular(sheet.scene()).discretise().unwrap_or_else(|error| panic!("{error}"));
    let angles = Known::new(stir(build(&spec), 0.02, 0.5), 0.2);
    for (settings, expected) in [("substeps=4,order=1", 1.0), ("substeps=4", 2.0)] {
        let found = order(&angles, settings);
        assert!((found - expected).abs() < 0.2, "angles, {settings}: {found}");
    }
    let sheet = Sheet { side: 4, tension: 200.0, shear: 20.0, ..Sheet::default() };
    let slopes = Known::new(stir(build(&stiffening(sheet.spec(), 10.0)), 0.02, 0.5), 0.2);
    let found = order(&slopes, "substeps=10,order=1");
    assert!((found - 1.0).abs() < 0.2, "two slopes: {found}");
}

/// A damping that an explicit kick of a substep could not take by a factor of 1e4.
#[test]
fn heavy_damping_gains_no_energy() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for settings in ["substeps=1", "substeps=2,iterations=3", "substeps=3,order=1"] {
            let sheet =
                Sheet { side: 6, damping: 1e6, law, gravity: Vec3::zeros(), ..Sheet::default() };
            let found = rise(new(settings), stir(sheet.build(), 0.02, 1.0), 1.0);
            assert!(found <= 0.0, "{law:?}, {settings}: {found} J");
        }
    }
}

/// Particles end on the outside of what they meet, and friction holds them.
#[test]
fn no_particle_ends_inside_an_obstacle_and_friction_holds_without_creep() {
    for settings in ["substeps=20", "substeps=1", "substeps=2,iterations=5", "substeps=5,order=1"] {
        contact::nothing_sinks_or_creeps(settings, || new(settings));
    }
}

/// What changes between steps is taken over; a new integrator steps alike. The families change
/// their order where another effect becomes the stiffest.
#[test]
fn changes_of_the_system_are_followed() {
    let sheet = Sheet { side: 6, shear: 500.0, ..Sheet::default() };
    type Change = fn(&mut System) -> bool;
    let changes: [Change; 5] = [
        |system| system.scale_stiffness(EffectKind::Tension, 3.0),
        |system| system.scale_stiffness(EffectKind::Shear, 30.0),
        |system| system.scale_damping(EffectKind::Shear, 0.5),
        |system| system.set_mass(&vec![2e-3; 36]),
        |system| system.set_pinned(17, true) && system.set_pinned(0, false),
    ];
    for settings in ["substeps=3", "substeps=3,order=1,iterations=2"] {
        for change in changes {
            let mut kept = run(settings, stir(sheet.build(), 0.0, 1.0), 0.004);
            kept.steps(3);
            assert!(change(&mut kept.system));
            let mut fresh = kept.fresh(new(settings));
            kept.steps(2);
            fresh.steps(2);
            assert_eq!(bits(&kept.state), bits(&fresh.state), "{settings}");
        }
    }
}

/// A sheet of `side` × `side` particles on two pins: the same cloth for every `side`, by its
/// stiffness over mass at 20 × 20.
fn hanging(side: u32, tension: f64, damping: f64) -> Sheet {
    let tension = tension * (f64::from(side) / 20.0).powi(2);
    Sheet { side, tension, shear: 0.1 * tension, damping, ..Sheet::default() }
}

/// What the energies of [`hanging`] are divided by, since each particle has 1 g.
fn share(side: u32) -> f64 {
    (f64::from(side) / 20.0).powi(2)
}

/// The same motion by leapfrog at 0.4 of its limit: states after 0.3 s and 1 s.
fn leapfrog((system, start): &(System, State), stiffness: f64) -> [Vec<Vec3>; 2] {
    let limit = 2.0 / (8.0 * 1.1 * stiffness).sqrt();
    let (mut state, mut force) = (start.clone(), vec![Vec3::zeros(); start.len()]);
    let mut kick = |state: &mut State, h: f64| {
        let all = system.effects().map(|effect| (effect, Part::All));
        system.write_forces(all, state.level(), &mut force);
        for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
            state.v[i] += force[i] * (h / system.mass()[i]);
        }
    };
    [0.3, 0.7].map(|span| {
        let steps = (span / (0.4 * limit)).ceil();
        let h = span / steps;
        for _ in 0..steps as usize {
            kick(&mut state, 0.5 * h);
            for i in 0..state.len() {
                state.x[i] += state.v[i] * h;
            }
            kick(&mut state, 0.5 * h);
        }
        state.x.clone()
    })
}

/// Rows of the frontier that take seconds: rises over 2 s in J.
#[test]
fn the_energy_of_a_stiff_sheet_stays_where_the_docs_say() {
    for (tension, damping, settings, low, high) in [
        (1e8, 40.0, "substeps=20", -1.0, 0.0),
        (1e8, 40.0, "substeps=5", 0.0, 0.06),
        (1e10, 40.0, "substeps=20", 0.0, 0.078),
    ] {
        let found = rise(new(settings), Sheet::hanging(tension, damping).build(), 2.0);
        assert!((low..=high).contains(&found), "{tension:e}, {damping}, {settings}: {found} J");
    }
}

/// Bending springs of a hundredth of the stiffness are lines of their own.
#[test]
fn bending_springs_set_no_energy_free() {
    let mut scene = Sheet::hanging(1e8, 40.0).scene();
    scene.effects.bending = Some(SpringLaw {
        stiffness_over_mass_per_s2: Some(1e6),
        damping_over_mass_per_s: Some(4.0),
        ..SpringLaw::default()
    });
    let spec = scene.discretise().unwrap_or_else(|error| panic!("{error}"));
    let found = rise(new("substeps=20"), build(&spec), 1.0);
    assert!(found <= 0.0, "{found} J");
}

/// The tables in the crate's docs.
#[test]
#[ignore = "takes minutes"]
#[allow(clippy::print_stderr, reason = "it measures; nothing is asserted")]
fn the_frontier() {
    for (side, tension) in [(20, 1e8), (20, 1e10), (40, 1e8), (40, 1e10)] {
        for damping in [40.0, 0.0] {
            let start = hanging(side, tension, damping).build();
            let exact = (side == 20).then(|| leapfrog(&start, tension));
            for settings in [
                "substeps=5",
                "substeps=10",
                "substeps=15",
                "substeps=20",
                "substeps=20,order=1",
                "substeps=30",
                "substeps=40",
                "substeps=100",
            ] {
                let found = rise(new(settings), start.clone(), 2.0) / share(side);
                let error = |steps: usize, exact: &[Vec3]| {
                    let mut run = run(settings, start.clone(), 0.01);
                    run.steps(steps);
                    position_error(&start.0, &start.1.x, exact, &run.state.x)
                };
                let errors =
                    exact.as_ref().map(|exact| (error(30, &exact[0]), error(100, &exact[1])));
                eprintln!("{side} {tension:e} {damping} {settings}: {found:.2e} J, {errors:?}");
            }
        }
    }
}

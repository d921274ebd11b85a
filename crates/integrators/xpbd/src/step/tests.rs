//! Recurrences, laws, orders, and the numbers of the crate's docs.

use crate::Xpbd;
use crate::settings::XpbdSettings;
use drape_integrator::{
    ContactSet, ImplicitStage, Integrator, PhaseClock, Stage, StageSettings, StepReport,
};
use drape_model::{DampingLaw, Effect, EffectKind, SpringEffect, State, System, Vec3};
use drape_oracle::checks::{self, H, Known, MASS, PARAMETERS, contact, rise};
use drape_oracle::laws::{Drift, spin};
use drape_oracle::recurrence::{Multistep, bdf, xpbd};
use drape_oracle::scenes::{
    GRAVITY, Sheet, anchored, angular, build, particles, pin, stiffening, stir, tension, uneven,
    waving,
};
use drape_oracle::{Run, apart, bits};
use drape_solvers::Constraints;
use nalgebra::Vector2;
use std::num::NonZero;

fn new(settings: &str) -> Box<dyn Integrator> {
    let pairs = settings.split(',').filter_map(|pair| pair.split_once('='));
    let settings = XpbdSettings::from_pairs(pairs).unwrap_or_else(|error| panic!("{error}"));
    Box::new(Xpbd::new(settings))
}

fn run(settings: &str, start: (System, State), h: f64) -> Run {
    Run::new(new(settings), start, h)
}

/// A particle on a spring of rest length 0: along each axis, with full damping, the recurrence.
#[test]
fn one_spring_moves_by_backward_euler_in_every_substep() {
    for ((theta, eta), substeps) in PARAMETERS.iter().flat_map(|p| [1, 4, 20].map(|n| (*p, n))) {
        let integrator = new(&format!("substeps={substeps}"));
        let (case, start) = ((theta, eta, substeps), checks::oscillator(theta, eta));
        let matrix = xpbd(theta, eta, substeps);
        checks::follows(case, integrator, start, &[1.0], 1e-12, |_| matrix);
    }
}

/// Order 2 is two-step backward differentiation, after a first step of backward Euler.
#[test]
fn with_order_2_one_spring_moves_by_bdf2() {
    for (theta, eta) in PARAMETERS {
        let (k, c) = checks::coefficients(theta, eta, H);
        let springs = [(SpringEffect::Tension, 0.0, k, c)];
        let spec = anchored(MASS, &springs, Vec3::x(), Vec3::x() * 3.0);
        let mut run = run("substeps=1,order=2", build(&spec), H);
        let first = xpbd(theta, eta, 1) * Vector2::new(1.0, 3.0 * H);
        let mut levels = vec![first, Vector2::new(1.0, 3.0 * H)];
        run.step();
        for step in 0..100 {
            run.step();
            let next = bdf(2, theta, eta).next(&levels);
            let found = Vector2::new(run.state.x[1].x, H * run.state.v[1].x);
            let off = (found - next).norm() / levels[0].norm().max(next.norm());
            assert!(off < 1e-12, "θ={theta} η={eta}, step {step}: {off:e}");
            levels = vec![next, levels[0]];
        }
    }
}

/// Ratios of steps from 1/2 to 2 are bridged by the formula for two unequal steps.
#[test]
fn with_order_2_steps_of_unequal_size_follow_the_formula_of_unequal_steps() {
    let ((theta, eta), start) = ((0.36, 0.06), Vector2::new(1.0, 3.0));
    let (k, c) = checks::coefficients(theta, eta, H);
    let springs = [(SpringEffect::Tension, 0.0, k, c)];
    let spec = anchored(MASS, &springs, Vec3::x(), Vec3::x() * 3.0);
    let mut run = run("substeps=1,order=2", build(&spec), H);
    let at = |ratio: f64, y: &Vector2<f64>| Vector2::new(y.x, ratio * H * y.y);
    let mut levels = vec![start];
    let mut last = None;
    for ratio in [1.0, 2.0, 1.5, 0.75, 1.25, 1.25, 0.625, 1.25, 0.75, 1.0] {
        let (theta, eta) = (theta * ratio * ratio, eta * ratio);
        let known: Vec<_> = levels.iter().map(|y| at(ratio, y)).collect();
        let next = match last {
            None => xpbd(theta, eta, 1) * known[0],
            Some(last) => Multistep::bdf(&[last / ratio]).recurrence(theta, 0.0, eta).next(&known),
        };
        run.step_by(ratio * H);
        let found = Vector2::new(run.state.x[1].x, run.state.v[1].x);
        let next = Vector2::new(next.x, next.y / (ratio * H));
        assert!((found - next).norm() < 1e-11 * next.norm(), "{ratio}: {found} {next}");
        levels.insert(0, next);
        levels.truncate(2);
        last = Some(ratio);
    }
}

/// Against an independent program.
#[test]
fn the_spin_of_two_particles_decays_as_computed_elsewhere() {
    for (theta, substeps, spin, angle) in [
        (1.0, 1, 0.9624226828, 1.96170949),
        (1.0, 10, 0.9960257727, 1.99602433),
        (100.0, 1, 0.9624252684, 1.96164710),
        (100.0, 10, 0.9960258131, 1.99601731),
    ] {
        let found = checks::turn(new(&format!("substeps={substeps}")), theta);
        assert!((found.spin - spin).abs() < 1e-10, "θ={theta}, {substeps}: {found:?}");
        assert!((found.angle - angle).abs() < 1e-8, "θ={theta}, {substeps}: {found:?}");
        assert_eq!(found.momentum, 0.0, "θ={theta}, {substeps}");
    }
}

/// Stretched, compressed, fast; with damping along the spring the length after the sweep tells.
#[test]
fn a_sweep_multiplies_the_spin_by_the_length_over_the_predicted_one() {
    for (law, damping) in [(DampingLaw::Projected, 3.0), (DampingLaw::Full, 0.0)] {
        for (theta, length) in [0.01, 1.0, 1e4].iter().flat_map(|t| [0.6, 1.0, 2.5].map(|l| (t, l)))
        {
            let velocities = [Vec3::new(3.0, -7.0, 2.0), Vec3::new(-1.0, 4.0, 8.0)];
            let mut spec = particles(&[MASS; 2], &[Vec3::zeros(), Vec3::x() * length], &velocities);
            spec.damping = law;
            spec.springs = vec![tension((0, 1), 1.0, 0.5 * theta * MASS / (H * H), damping)];
            let mut run = run("substeps=1", build(&spec), H);
            for step in 0..50 {
                let (d, v) = checks::pair(&run.state);
                run.step();
                let (after, v_after) = checks::pair(&run.state);
                let expected = d.cross(&v) * spin::xpbd((d + v * H).norm(), after.norm());
                let off = (after.cross(&v_after) - expected).norm();
                assert!(off < 1e-11, "{law:?}, θ={theta}, step {step}: {off:e}");
            }
        }
    }
}

#[test]
fn an_unpinned_sheet_falls_on_its_parabola_and_keeps_its_momentum() {
    for (settings, drift) in [
        ("substeps=1", Drift::NewVelocity),
        ("substeps=20", Drift::Substeps(20)),
        ("substeps=8,iterations=3,sweep=coloured", Drift::Substeps(8)),
        ("substeps=1,order=2", Drift::Bdf2AfterBackwardEuler),
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

/// One step, and twenty, of four particles on two springs with projected damping: the positions
/// that the solver `SolverXPBD` of Newton 1.8 computes in single precision (`iterations` 1 and 4;
/// it adds up all corrections of a sweep, which is the same where no springs share a particle).
#[test]
fn disjoint_springs_move_as_in_the_public_code_of_newton() {
    let x = [
        Vec3::zeros(),
        Vec3::new(1.2, 0.1, -0.2),
        Vec3::new(3.0, 0.0, 0.0),
        Vec3::new(3.3, 0.7, 0.2),
    ];
    let v = [
        Vec3::new(0.1, -0.2, 0.3),
        Vec3::new(-0.5, 0.4, 0.1),
        Vec3::y(),
        Vec3::new(0.3, 0.0, -1.0),
    ];
    let row = |values: [f64; 12]| {
        let mut list = values.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2]));
        [(); 4].map(|()| list.next().unwrap_or_default())
    };
    #[rustfmt::skip]
    let expected = [
        (0.0, 1, 1, row([
            4.99559660e-03, -1.64528214e-03, 1.34302815e-03,
            1.18700886e+00, 1.03290565e-01, -1.98629066e-01,
            2.99436665e+00, -2.82852631e-03, -4.51349281e-03,
            3.33116698e+00, 7.64142632e-01, 2.06681475e-01,
        ])),
        (2.0, 1, 1, row([
            4.4215238e-03, -1.6962467e-03, 1.4401493e-03, 1.1881570e+00, 1.0339250e-01, -1.9882330e-01,
            2.9945362e+00, -2.4424084e-03, -4.4071702e-03, 3.3303192e+00, 7.6221204e-01, 2.0614986e-01,
        ])),
        (2.0, 4, 1, row([
            4.4215219e-03, -1.6962468e-03, 1.4401495e-03, 1.1881570e+00, 1.0339250e-01, -1.9882330e-01,
            2.9945362e+00, -2.4424128e-03, -4.4071716e-03, 3.3303192e+00, 7.6221210e-01, 2.0614988e-01,
        ])),
        (2.0, 1, 20, row([
            0.07051931, -0.04347413, -0.15088332, 0.99896383, 0.1869485, -0.3762631,
            2.9832308, 0.15534653, -0.22108662, 3.4438593, 0.92326754, -0.1306272,
        ])),
    ];
    for (damping, iterations, steps, expected) in expected {
        let mut spec = particles(&[0.5, 0.25, 1.0, 0.2], &x, &v);
        spec.damping = DampingLaw::Projected;
        spec.effects.gravity = drape_oracle::scenes::gravity();
        spec.springs =
            vec![tension((0, 1), 1.0, 100.0, damping), tension((2, 3), 0.9, 4000.0, damping)];
        let settings = format!("substeps=1,iterations={iterations}");
        let mut run = run(&settings, build(&spec), 0.01);
        run.steps(steps);
        let off = apart(&run.state.x, &expected);
        let allowed = if steps == 1 { 5e-7 } else { 2e-5 };
        assert!(off < allowed, "c = {damping}, {settings}, {steps} steps: {off:e} m");
    }
}

/// The sweep as its formulas say, spring by spring, from what the effects of the system tell. It
/// also counts how many springs it met.
fn by_the_book(system: &System, start: &State, h: f64, iterations: usize) -> (Vec<Vec3>, usize) {
    let mut way: Vec<Vec3> = (start.v.iter().zip(system.pinned()))
        .map(|(v, pinned)| if *pinned { Vec3::zeros() } else { v * h })
        .collect();
    let w: Vec<f64> = (system.mass().iter().zip(system.pinned()))
        .map(|(m, pinned)| if *pinned { 0.0 } else { 1.0 / m })
        .collect();
    let mut springs = Vec::new();
    for split in system.effects().filter_map(Effect::split) {
        let (mut weights, mut rests) = (Vec::new(), Vec::new());
        split.visit_weights(&mut |i, j, k, c| weights.push((i, j, k, c)));
        split.visit_rest_lengths(&mut |_, _, rest| rests.push(rest));
        let along = split.has_damping_remainder();
        springs.extend(weights.into_iter().zip(rests).map(|(spring, rest)| (spring, rest, along)));
    }
    let mut multipliers = vec![(0.0, Vec3::zeros()); springs.len()];
    for _ in 0..iterations {
        for (((i, j, k, c), rest, along), multiplier) in springs.iter().zip(&mut multipliers) {
            let (i, j, (lambda, brake)) = (*i, *j, *multiplier);
            let (a, g, w_sum) = (k * h * h, c * h, w[i] + w[j]);
            let r = way[i] - way[j];
            let d = start.x[i] - start.x[j] + r;
            let impulse = if *along {
                let (length, u) = (d.norm(), d / d.norm());
                let step = -(lambda + a * (length - rest) + g * u.dot(&r)) // (X4)
                    * (1.0 / (1.0 + (a + g) * w_sum));
                multiplier.0 += step;
                u * step
            } else {
                let pass = 1.0 / (1.0 + g * w_sum);
                let damping = -(brake + r * g) * pass;
                let d = d + damping * w_sum;
                let (length, u) = (d.norm(), d / d.norm());
                let step = -(lambda + a * (length - rest)) * (1.0 / (1.0 + a * w_sum * pass)); // (X5)
                let impulse = damping + u * (pass * step);
                *multiplier = (lambda + step, brake + (impulse - u * step));
                impulse
            };
            way[i] += impulse * w[i];
            way[j] -= impulse * w[j];
        }
    }
    (start.x.iter().zip(way).map(|(x, way)| x + way).collect(), springs.len())
}

#[test]
fn a_step_has_the_bits_of_the_formulas_written_out() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let sheet = Sheet { side: 7, tension: 1e5, shear: 1e4, law, ..Sheet::default() };
        let sheet = Sheet { gravity: Vec3::zeros(), ..sheet };
        let (system, start) = uneven(stir(sheet.build(), 0.02, 1.0));
        for iterations in [1, 3] {
            let (expected, springs) = by_the_book(&system, &start, 0.004, iterations);
            assert_eq!(springs, 4 * 7 * 6 - 2 * 6 * 7 + 2 * 6 * 6);
            let settings = format!("substeps=1,iterations={iterations}");
            let mut run = run(&settings, (system.clone(), start.clone()), 0.004);
            run.step();
            assert_eq!(run.state.x, expected, "{law:?}, {iterations}");
        }
    }
}

#[test]
fn coloured_sweeps_have_the_same_bits_with_one_thread_and_with_three() {
    let sheet = Sheet { side: 190, tension: 1e5, shear: 0.0, ..Sheet::default() };
    let start = stir(sheet.build(), 1e-3, 0.1);
    let [one, three] = [1, 3].map(|threads| {
        let (mut system, state) = start.clone();
        system.set_threads(NonZero::new(threads).unwrap_or(NonZero::<usize>::MIN));
        let mut run = run("substeps=2,iterations=2,sweep=coloured", (system, state), 1e-3);
        run.step();
        bits(&run.state)
    });
    assert!(one == three);
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

/// One sweep leaves an error of `O(h²)` in the force of a spring, but one of `O(h)` in the damping.
#[test]
fn the_order_is_1_and_with_bdf2_2_where_damping_is_swept_twice() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        for (damping, settings, expected) in [
            (5.0, "substeps=1", 1.0),
            (5.0, "substeps=10", 1.0),
            (5.0, "substeps=10,iterations=5,sweep=coloured", 1.0),
            (0.0, "substeps=10,order=2", 2.0),
            (5.0, "substeps=10,order=2", 1.0),
            (5.0, "substeps=10,order=2,iterations=2", 2.0),
        ] {
            let found = order(&smooth(law, damping), settings);
            assert!((found - expected).abs() < 0.15, "{law:?}, {damping}, {settings}: {found}");
        }
    }
}

/// Angles, hinges, springs of two slopes.
#[test]
fn other_constraints_have_the_order_too() {
    let sheet = Sheet { side: 5, shear: 0.0, damping: 0.0, ..Sheet::default() };
    let spec = angular(sheet.scene()).discretise().unwrap_or_else(|error| panic!("{error}"));
    let angles = Known::new(stir(build(&spec), 0.02, 0.5), 0.2);
    for (settings, expected) in
        [("substeps=4", 1.0), ("substeps=4,sweep=coloured", 1.0), ("substeps=4,order=2", 2.0)]
    {
        let found = order(&angles, settings);
        assert!((found - expected).abs() < 0.15, "angles, {settings}: {found}");
    }
    let sheet = Sheet { side: 4, tension: 200.0, shear: 20.0, ..Sheet::default() };
    let slopes = Known::new(stir(build(&stiffening(sheet.spec(), 10.0)), 0.02, 0.5), 0.2);
    let found = order(&slopes, "substeps=10");
    assert!((found - 1.0).abs() < 0.2, "two slopes: {found}");
}

/// A spring of two slopes is, piece by piece, a linear spring with another rest length.
#[test]
fn a_piece_of_a_curve_is_a_spring_of_its_own() {
    let spec = |pieces: bool| {
        let mut spec = particles(&[1.0; 2], &[Vec3::zeros(), Vec3::x() * 1.2], &[]);
        // From 10 % of strain on ten times as stiff: T = 10 + 1000 (L − 1.1), tensionless at 1.09.
        let (rest, k) = if pieces { (1.0, 100.0) } else { (1.09, 1000.0) };
        spec.springs = vec![tension((0, 1), rest, k, 0.0)];
        if pieces {
            let piece = |up_to_strain, stiffness_n_per_m| drape_model::PieceSpec {
                up_to_strain,
                stiffness_n_per_m,
            };
            spec.springs[0].pieces = vec![piece(Some(0.1), 100.0), piece(None, 1000.0)].into();
        }
        build(&spec)
    };
    let [curve, line] = [true, false].map(|pieces| {
        let mut run = run("substeps=1", spec(pieces), 0.01);
        run.step();
        run.state.x[1].x
    });
    assert!(curve < 1.2 && (curve - line).abs() < 1e-14, "{curve}, {line}");
}

/// Where the exact step of backward Euler ends, m.
fn backward_euler(system: &System, from: &State, h: f64) -> Vec<Vec3> {
    let how = StageSettings { residual: 1e-12, ..StageSettings::default() };
    let input = Stage {
        tau: h.into(),
        end: from.t + h,
        from: (&from.x, &from.v),
        lagged: from.level(),
        velocity: &from.v,
    };
    let (mut contacts, mut free) = (ContactSet::new(system), Constraints::free(system.len()));
    let (mut clock, mut report) = (PhaseClock::off(), StepReport::default());
    let mut stage = ImplicitStage::new(system).unwrap_or_else(|error| panic!("{error}"));
    stage
        .solve(system, input, &from.v, &mut contacts, &mut free, how, &mut clock, &mut report)
        .unwrap_or_else(|error| panic!("{error}"));
    stage.positions().to_vec()
}

/// Distance from the step of backward Euler over that of the prediction.
fn left_over(system: &System, from: &State, settings: &str, h: f64) -> f64 {
    let solved = backward_euler(system, from, h);
    let mut y = from.x.clone();
    for i in (0..y.len()).filter(|&i| !system.pinned()[i]) {
        y[i] += from.v[i] * h + GRAVITY * (h * h);
    }
    let mut run = run(settings, (system.clone(), from.clone()), h);
    run.step();
    let norm = |a: &[Vec3]| a.iter().zip(&solved).map(|(a, b)| (a - b).norm_squared()).sum::<f64>();
    (norm(&run.state.x) / norm(&y)).sqrt()
}

/// Sweeps converge, but not to the step of backward Euler: what they have done in old directions
/// stays. The difference vanishes with the substep.
#[test]
fn converged_xpbd_is_not_backward_euler() {
    let sheet = Sheet { side: 8, tension: 1e4, shear: 1e3, damping: 0.0, ..Sheet::default() };
    let (system, start) = stir(sheet.build(), 0.02, 1.0);
    let left = |h: f64, count: u32| {
        left_over(&system, &start, &format!("substeps=1,iterations={count}"), h)
    };
    let [few, many, more] = [1, 100, 400].map(|count| left(0.01, count));
    assert!(few > 0.2 && many > 0.01 && (many - more).abs() < 1e-6, "{few} {many} {more}");
    let shorter = left(0.001, 100);
    assert!(shorter < 0.15 * many, "{shorter} of {many}");
}

/// Sweeps that stop early set energy free; substeps end that, sweeps hardly.
#[test]
fn too_few_substeps_gain_energy() {
    for (tension, damping, settings, low, high) in [
        (1e6, 0.0, "substeps=1", 100.0, 150.0),
        (1e6, 0.0, "substeps=1,iterations=20", 0.2, 0.4),
        (1e6, 0.0, "substeps=10", 0.05, 0.1),
        (1e6, 40.0, "substeps=10", 0.004, 0.012),
        (1e6, 40.0, "substeps=20", -1.0, 0.0),
        (1e8, 40.0, "substeps=20", 0.25, 0.4),
        (1e8, 40.0, "substeps=50", 0.01, 0.03),
    ] {
        let seconds = if tension < 1e7 { 2.0 } else { 0.5 };
        let found = rise(new(settings), Sheet::hanging(tension, damping).build(), seconds);
        assert!((low..=high).contains(&found), "{tension:e}, {damping}, {settings}: {found} J");
    }
}

/// A damping that an explicit kick of a substep could not take by a factor of 1e4.
#[test]
fn heavy_full_damping_gains_no_energy() {
    for settings in ["substeps=1", "substeps=2,iterations=3", "substeps=3,order=2"] {
        let sheet = Sheet { side: 6, damping: 1e6, gravity: Vec3::zeros(), ..Sheet::default() };
        let found = rise(new(settings), stir(sheet.build(), 0.02, 1.0), 1.0);
        assert!(found <= 0.0, "{settings}: {found} J");
    }
}

/// Particles end on the outside of what they meet, and friction holds them.
#[test]
fn no_particle_ends_inside_an_obstacle_and_friction_holds_without_creep() {
    for settings in ["substeps=20", "substeps=1", "substeps=2,iterations=5", "substeps=5,order=2"] {
        contact::nothing_sinks_or_creeps(settings, || new(settings));
    }
}

/// What changes between steps is taken over; a new integrator steps alike.
#[test]
fn changes_of_the_system_are_followed() {
    let sheet = Sheet { side: 6, shear: 500.0, ..Sheet::default() };
    type Change = fn(&mut System) -> bool;
    let changes: [Change; 4] = [
        |system| system.scale_stiffness(EffectKind::Tension, 3.0),
        |system| system.scale_damping(EffectKind::Shear, 0.5),
        |system| system.set_mass(&vec![2e-3; 36]),
        |system| system.set_pinned(17, true) && system.set_pinned(0, false),
    ];
    for settings in ["substeps=3", "substeps=3,order=2,sweep=coloured,iterations=2"] {
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

/// Two equal springs pull a particle apart. The second one sees what the first has done, so a sweep
/// does nothing where the particle is `β C/(2 − β)` off the middle, with the mean stretch `C` and
/// `β = θ/(1+θ)`. More sweeps end that.
#[test]
fn springs_that_pull_against_each_other_rest_off_the_middle_after_one_sweep() {
    let x = [Vec3::zeros(), Vec3::x() * 2.0, Vec3::x()];
    let mut spec = particles(&[1.0; 3], &x, &[]);
    spec.pins = vec![pin(0), pin(1)];
    spec.springs = vec![tension((0, 2), 0.5, 1e3, 0.0), tension((1, 2), 0.5, 1e3, 0.0)];
    let off = |settings: &str, h: f64| {
        let mut run = run(settings, build(&spec), h);
        run.steps(200);
        assert_eq!([run.state.x[0], run.state.x[1]], [x[0], x[1]]);
        run.state.x[2].x - 1.0
    };
    let beta = 2.5 / 3.5;
    let expected = 0.5 * beta / (2.0 - beta);
    let found = off("substeps=1", 0.05);
    assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    assert!(off("substeps=1,iterations=100", 0.05).abs() < 1e-9);
}

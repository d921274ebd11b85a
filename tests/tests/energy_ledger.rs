//! The energy ledger of every method: its terms add up to the change of the total energy, and each
//! is what it says.

use drape_integrator::EnergyLedger;
use drape_model::{
    AirSpec, AngularLaw, DampingLaw, DragSpec, Effect, GustSpec, KeyframeSpec, Level, ObstacleSpec,
    State, System, Vec3, WindSpec,
};
use drape_tests::{
    METHODS, Run, Sheet, assert_covers, build, floor, gravity, is_adaptive, name, particles,
    prepared, seconds, stiffening, takes, uneven,
};

const H: f64 = 0.004;
/// Error of the sum over the sum of the terms' magnitudes.
const CLOSED: f64 = 1e-8;

/// Methods of several steps, whose energy depends on steps before, and of several stages or
/// substeps, whose forces have no single level.
const UNATTRIBUTED: [&str; 16] = [
    "adams-bashforth2",
    "bdf2",
    "imex-sbdf2",
    "imex-cnab2",
    "imex-mcnab2",
    "imex-cnlf",
    "dirk",
    "generalized-alpha",
    "imex-rk",
    "rosenbrock",
    "rkc",
    "srkn4",
    "multirate",
    "xpbd",
    "xpbd-lines",
    // Of one step: its force is a mean over the linearised motion, which belongs to no effect.
    "exponential",
];
/// Its steps may be divided, and the ledger of a divided one is not kept.
const DIVIDED: &str = "leapfrog:step=auto";

/// Gives the free particles velocities without a pattern, and masses that differ where `differ`
/// says so.
fn stir((system, mut state): (System, State), differ: bool) -> (System, State) {
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        let a = i as f64;
        state.v[i] = Vec3::new(a.sin(), (2.0 * a).cos(), (3.0 * a).sin() - 0.5) * 0.5;
    }
    if differ { uneven((system, state)) } else { (system, state) }
}

/// A sheet that falls on a sphere just below it.
fn on_a_sphere(law: DampingLaw) -> (System, State) {
    let mut spec = Sheet { law, pinned: false, ..Sheet::default() }.spec();
    let (center_m, radius_m) = ([0.05, 0.02, -0.41], 0.4);
    spec.obstacles.push(ObstacleSpec::sphere(center_m, radius_m, 0.3));
    build(&spec)
}

/// A sheet with a pin on a path, over a rough sphere on another.
fn led(law: DampingLaw) -> (System, State) {
    let mut spec = Sheet { law, ..Sheet::default() }.spec();
    let frame = |time_s, offset_m| KeyframeSpec { time_s, offset_m };
    spec.pins[0].path = vec![frame(0.06, [0.1, -0.1, 0.05]), frame(0.1, [0.1, -0.1, 0.0])];
    spec.obstacles.push(ObstacleSpec::Sphere {
        center_m: [0.05, 0.02, -0.41],
        radius_m: 0.4,
        restitution: 0.3,
        friction: 0.4,
        path: vec![frame(1.0, [0.3, 0.0, 0.8])],
    });
    build(&spec)
}

/// A sheet that resists shear and bending by its angles, in a wind.
fn in_a_wind(gusty: bool) -> (System, State) {
    let mut scene = Sheet { shear: 0.0, ..Sheet::default() }.scene();
    let law = |stiffness_n_m| Some(AngularLaw { stiffness_n_m });
    let gust = GustSpec { amplitude_m_s: [0.0, 1.0, 4.0], period_s: 0.05, seed: 3, start_s: 0.0 };
    scene.effects.shear_angle = law(2e-3);
    scene.effects.bending_angle = law(2e-4);
    scene.effects.bending_hinge = law(2e-4);
    scene.effects.air = Some(AirSpec {
        drag: DragSpec::Quadratic { coefficient: 1.0, density_kg_m3: 1.2 },
        wind: Some(WindSpec { velocity_m_s: [1.0, 0.0, 3.0], gust: gusty.then_some(gust) }),
    });
    build(&scene.discretise().expect("valid"))
}

/// The scenes in which every ledger must close.
fn scenes() -> Vec<(&'static str, (System, State))> {
    let undamped = Sheet { damping: 0.0, ..Sheet::default() };
    let projected = Sheet { law: DampingLaw::Projected, ..Sheet::default() };
    let free = Sheet { pinned: false, ..Sheet::default() };
    let two_slopes = build(&stiffening(Sheet::default().spec(), 10.0));
    vec![
        ("two slopes", stir(two_slopes, true)),
        ("damped", stir(Sheet::default().build(), false)),
        ("undamped, unequal masses", stir(undamped.build(), true)),
        ("projected damping", stir(projected.build(), false)),
        ("free, unequal masses", stir(free.build(), true)),
        ("on a sphere", stir(on_a_sphere(DampingLaw::Full), false)),
        ("on a sphere, projected damping", stir(on_a_sphere(DampingLaw::Projected), true)),
        ("led, rough", stir(led(DampingLaw::Full), false)),
        ("led, rough, projected damping", stir(led(DampingLaw::Projected), true)),
    ]
}

/// Those with forces that no method splits.
fn scenes_of_angles_and_air() -> [(&'static str, (System, State)); 2] {
    [
        ("angles and wind", stir(in_a_wind(false), true)),
        ("angles and gusts", stir(in_a_wind(true), false)),
    ]
}

/// One step, its ledger and the change of the total energy.
fn step(run: &mut Run) -> (State, Option<EnergyLedger>, f64) {
    let (before, energy) = (run.state.clone(), run.energy());
    run.step();
    let ledger = run.integrator.ledger(&run.system, &before, &run.state, seconds(run.h));
    (before, ledger, run.energy() - energy)
}

fn is_without(id: &str) -> bool {
    UNATTRIBUTED.contains(&name(id)) || id == DIVIDED || is_adaptive(id)
}

#[test]
fn every_method_has_a_ledger_or_says_why_not() {
    let exceptions = UNATTRIBUTED.map(|id| (id, "the energy depends on levels before the last"));
    assert_covers("ledger", METHODS.into_iter().filter(|id| !is_without(id)), &exceptions);
}

#[test]
fn the_terms_add_up_at_every_step_of_every_method_on_every_scene() {
    let mut worst: f64 = 0.0;
    for id in METHODS.into_iter().filter(|id| !is_without(id)) {
        for (name, start) in scenes().into_iter().chain(scenes_of_angles_and_air()) {
            if !takes(id, &start.0) {
                continue;
            }
            let mut run = prepared(id, start, H);
            for n in 0..40 {
                let (_, ledger, change) = step(&mut run);
                let ledger = ledger.unwrap_or_else(|| panic!("{id}, {name}: no ledger"));
                // A method that keeps the energy has terms as small as the round-off of the energy.
                let round_off = 1e-13 * run.system.kinetic_energy(&run.state.v);
                let defect = (ledger.sum() - change).abs();
                assert!(
                    defect <= CLOSED * ledger.magnitude() + round_off,
                    "{id}, {name}, step {n}: {defect:e}, {ledger:?}, {change:e}"
                );
                worst = worst.max(defect);
            }
        }
    }
    assert!(worst > 0.0, "round-off at least");
}

#[test]
fn no_term_can_be_left_out() {
    let mut seen = std::collections::BTreeSet::new();
    for id in METHODS.into_iter().filter(|id| !is_without(id)) {
        for (name, start) in scenes().into_iter().filter(|(_, (system, _))| takes(id, system)) {
            let mut run = prepared(id, start, H);
            for _ in 0..40 {
                let (_, Some(ledger), change) = step(&mut run) else { panic!("{id}: no ledger") };
                let EnergyLedger {
                    damping, inertia, impact, residual, constraint, correction, ..
                } = ledger;
                let gap = ledger.gap();
                let terms = [
                    ("damping", damping),
                    ("inertia", inertia),
                    ("impact", impact),
                    ("gap", gap),
                    ("residual", residual),
                    ("constraint", constraint),
                    ("correction", correction),
                ];
                for (term, value) in terms {
                    if value.abs() > 1e-6 * ledger.magnitude() {
                        let defect = (ledger.sum() - value - change).abs() / ledger.magnitude();
                        assert!(defect > CLOSED, "{id}, {name}: without {term}");
                        seen.insert(term);
                    }
                }
            }
        }
    }
    assert_eq!(seen.len(), 7, "every term counts somewhere: {seen:?}");
}

#[test]
fn methods_of_several_steps_and_divided_steps_have_no_ledger() {
    for id in METHODS.into_iter().filter(|id| is_without(id)) {
        let stiff = Sheet { tension: 1e6, ..Sheet::default() };
        let mut run = prepared(id, stir(stiff.build(), false), H);
        let (_, ledger, _) = step(&mut run);
        assert_eq!(ledger, None, "{id}");
    }
    let mut run = prepared(DIVIDED, stir(Sheet::default().build(), false), 1e-4);
    let (_, ledger, _) = step(&mut run);
    assert!(ledger.is_some(), "a step that needs no division");
}

/// `½‖a − b‖²_M`.
fn half_square(system: &System, a: &[Vec3], b: &[Vec3]) -> f64 {
    let rows = system.mass().iter().zip(a).zip(b);
    rows.map(|((m, a), b)| 0.5 * m * (a - b).norm_squared()).sum()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// `h v·f_damping(x, v)`.
fn damping_work(run: &Run, x: &[Vec3], v: &[Vec3]) -> f64 {
    let mut force = vec![Vec3::zeros(); v.len()];
    run.system.effects().for_each(|effect| {
        effect.add_damping_force(Level { t: 0.0, x, v }, &mut force);
    });
    force.iter().zip(v).map(|(f, v)| run.h * f.dot(v)).sum()
}

#[test]
fn inertia_and_damping_of_backward_euler_are_those_of_its_theory() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let mut run =
            prepared("backward-euler", stir(Sheet { law, ..Sheet::default() }.build(), true), H);
        for _ in 0..20 {
            let (before, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
            let lost = half_square(&run.system, &run.state.v, &before.v);
            assert!(near(ledger.inertia, -lost) && ledger.impact == 0.0);
            assert!(near(ledger.damping, damping_work(&run, &before.x, &run.state.v)));
            assert!(ledger.damping < 0.0 && ledger.constraint == 0.0 && ledger.correction == 0.0);
            assert!(ledger.residual.abs() < 1e-7 * ledger.magnitude(), "{ledger:?}");
        }
    }
}

#[test]
fn explicit_euler_gains_what_backward_euler_loses_by_inertia() {
    let mut run = prepared("explicit-euler", stir(Sheet::default().build(), false), H);
    for _ in 0..20 {
        let (before, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
        assert!(near(ledger.inertia, half_square(&run.system, &run.state.v, &before.v)));
        assert!(near(ledger.damping, damping_work(&run, &before.x, &before.v)));
        assert!(ledger.residual.abs() < 1e-14 * ledger.magnitude(), "nothing is solved");
        assert_eq!((ledger.constraint, ledger.correction), (0.0, 0.0));
    }
}

/// Theorem 1: the gap of the split springs never adds energy, be they stretched, squeezed or
/// turned.
#[test]
fn the_gap_of_imex_euler_is_never_positive_and_that_of_gravity_is_none() {
    let id = "imex-euler:implicit=springs,forcing_term=1e-13";
    for (name, start) in scenes() {
        for h in [0.002, 0.02, 0.2] {
            let mut run = prepared(id, start.clone(), h);
            for _ in 0..40 {
                let (_, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
                for (effect, gap) in &ledger.gaps {
                    let round_off = 1e-9 * ledger.magnitude();
                    assert!(*gap <= round_off, "{name}, h = {h}, {effect}: {gap:e}");
                    assert!(*effect != "gravity" || gap.abs() <= round_off, "{name}: {gap:e}");
                }
            }
        }
    }
}

#[test]
fn inertia_of_leapfrog_is_the_change_of_its_shadow() {
    let start = stir(Sheet { damping: 0.0, pinned: false, ..Sheet::default() }.build(), true);
    let mut run = prepared("leapfrog", start, H);
    // h²/8 ‖M⁻¹F‖²_M
    let shadow = |run: &Run| -> f64 {
        let mut force = vec![Vec3::zeros(); run.state.len()];
        run.system.forces(run.state.level(), &mut force);
        let square = force.iter().zip(run.system.mass()).map(|(f, m)| f.norm_squared() / m);
        H * H / 8.0 * square.sum::<f64>()
    };
    for _ in 0..20 {
        let at_start = shadow(&run);
        let (_, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
        assert!((ledger.inertia - (shadow(&run) - at_start)).abs() < 1e-9 * ledger.magnitude());
    }
}

#[test]
fn what_provot_corrects_is_the_difference_to_symplectic_euler() {
    let id = "provot:limit=1e-2";
    let mut run = prepared(id, stir(Sheet::default().build(), false), H);
    let mut corrected = 0;
    for _ in 0..20 {
        let start = (run.system.clone(), run.state.clone());
        let mut without = prepared("symplectic-euler", start, H);
        without.step();
        let (_, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
        let difference = run.energy() - without.energy();
        assert!((ledger.correction - difference).abs() < 1e-12, "{}", ledger.correction);
        corrected += usize::from(difference.abs() > 1e-6);
    }
    assert!(corrected > 5);
}

#[test]
fn desbrun_without_correction_has_the_ledger_of_imex_euler() {
    // With pins they differ in whether gravity is filtered.
    let free = || stir(Sheet { pinned: false, ..Sheet::default() }.build(), true);
    let mut desbrun = prepared("desbrun:torque=none", free(), H);
    let mut imex = prepared("imex-euler:implicit=springs,solver=cholesky", free(), H);
    for _ in 0..10 {
        let (_, Some(a), _) = step(&mut desbrun) else { panic!("no ledger") };
        let (_, Some(b), _) = step(&mut imex) else { panic!("no ledger") };
        for (a, b) in [(a.damping, b.damping), (a.inertia, b.inertia), (a.gap(), b.gap())] {
            assert!((a - b).abs() < 1e-9 * b.abs(), "{a:e}, {b:e}");
        }
    }
}

#[test]
fn a_loose_solve_and_an_incomplete_one_show_as_residual() {
    let share = |id: &str, tension: f64| -> f64 {
        let mut run =
            prepared(id, stir(Sheet { tension, ..Sheet::default() }.build(), false), 0.01);
        let shares = (0..10).map(|_| {
            let (_, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
            ledger.residual.abs() / ledger.magnitude()
        });
        shares.fold(0.0, f64::max)
    };
    let [tight, loose] =
        ["1e-12", "0.3"].map(|e| share(&format!("imex-euler:forcing_term={e}"), 1e6));
    assert!(tight < 1e-9 && loose > 1e-3, "{tight:e}, {loose:e}");
    let [one, many] = [1, 64].map(|sweeps| share(&format!("kang:sweeps={sweeps}"), 1e4));
    assert!(one > 0.01 && many < 0.1 * one, "{one:e}, {many:e}");
}

/// An inelastic impact takes the kinetic energy of the normal motion, which is no numerical
/// damping; a rebound leaves the square of the restitution of it.
#[test]
fn an_impact_is_told_from_numerical_damping() {
    let (mass, speed) = (2.0, 3.0);
    for restitution in [0.0, 0.5] {
        let mut spec = particles(&[mass], &[Vec3::zeros()], &[Vec3::new(1.0, 0.0, -speed)]);
        spec.obstacles.push(floor(restitution));
        for id in METHODS.into_iter().filter(|id| !is_without(id)) {
            let mut run = prepared(id, build(&spec), 1e-3);
            let (_, Some(ledger), change) = step(&mut run) else { panic!("{id}: no ledger") };
            let expected = -0.5 * mass * speed * speed * (1.0 - restitution * restitution);
            let kept = restitution == 0.0 || run.state.v[0].z > 0.0;
            assert!(kept && near(change, expected), "{id}: {change}");
            let physical = ledger.impact + ledger.constraint;
            assert!(near(physical, expected), "{id}: {ledger:?}");
            assert!(ledger.inertia.abs() < 1e-12, "{id}: {ledger:?}");
        }
    }
}

/// A sheet at rest on a table: weight and support do no work.
#[test]
fn rest_on_a_table_has_an_empty_ledger() {
    let mut spec = particles(&[1.0, 2.0], &[Vec3::zeros(), Vec3::x()], &[Vec3::zeros(); 2]);
    spec.effects.gravity = gravity();
    spec.obstacles.push(floor(0.0));
    for id in METHODS.into_iter().filter(|id| !is_without(id)) {
        let mut run = prepared(id, build(&spec), 0.01);
        for _ in 0..3 {
            let (_, Some(ledger), change) = step(&mut run) else { panic!("{id}: no ledger") };
            assert!(ledger.magnitude() < 1e-15 && change.abs() < 1e-15, "{id}: {ledger:?}");
        }
    }
}

/// Where nothing corrects anything, the correction is nothing.
#[test]
fn there_is_no_correction_without_contacts_or_a_method_that_corrects() {
    let corrects = ["provot", "desbrun"];
    for id in METHODS.into_iter().filter(|id| !is_without(id)) {
        if corrects.iter().any(|name| id.starts_with(name)) {
            continue;
        }
        let mut run = prepared(id, stir(Sheet::default().build(), true), H);
        for _ in 0..10 {
            let (_, Some(ledger), _) = step(&mut run) else { panic!("{id}: no ledger") };
            assert_eq!(ledger.correction, 0.0, "{id}");
        }
    }
}

/// What a pinned particle brings along is stopped before the step.
#[test]
fn a_pin_stops_what_moves_with_it() {
    for id in METHODS.into_iter().filter(|id| !is_without(id)) {
        let (system, mut state) = stir(Sheet::default().build(), false);
        let pinned = (0..state.len()).find(|&i| system.pinned()[i]).expect("one is pinned");
        state.v[pinned] = Vec3::new(3.0, 0.0, 4.0);
        let mut run = prepared(id, (system, state), H);
        let (_, Some(ledger), change) = step(&mut run) else { panic!("{id}: no ledger") };
        assert!((ledger.sum() - change).abs() < CLOSED * ledger.magnitude(), "{id}: {ledger:?}");
        let stopped = -0.5 * run.system.mass()[pinned] * 25.0;
        assert!(near(ledger.constraint, stopped), "{id}: {ledger:?}");
    }
}

#[test]
fn the_ledger_names_every_effect() {
    let mut run = prepared("backward-euler", stir(Sheet::default().build(), false), H);
    let names: Vec<_> = run.system.effects().map(Effect::name).collect();
    let (_, Some(ledger), _) = step(&mut run) else { panic!("no ledger") };
    assert_eq!(ledger.gaps.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names);
}

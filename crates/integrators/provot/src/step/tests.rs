//! Tests of Provot's method: the correction, its order and its effect on velocities.

use super::*;
use drape_integrator::{ElongationSettings, SweepOrder};
use drape_model::{DampingLaw, SystemSpec, Vec3};
use drape_oracle::scenes::{Sheet, build, floor, particles, pin, tension};
use drape_oracle::{Run, apart, bits};

fn prepared(settings: ProvotSettings, spec: &SystemSpec, h: f64) -> Run {
    Run::new(Box::new(Provot::new(settings)), build(spec), h)
}

fn limited(limit: f64) -> ProvotSettings {
    let elongation = ElongationSettings { limit, ..ElongationSettings::default() };
    ProvotSettings { elongation, ..ProvotSettings::default() }
}

/// A sheet that hangs from two corners; `tension` is the `k/m` of springs along warp and weft.
fn sheet(side: u32, tension: f64) -> SystemSpec {
    Sheet { side, tension, shear: 0.1 * tension, damping: 0.0, ..Sheet::default() }.spec()
}

/// Two particles with a spring of rest length 1, in motion.
fn pair(mass: [f64; 2], length: f64, stiffness: f64) -> SystemSpec {
    let x = [Vec3::zeros(), Vec3::new(0.0, 0.6, -0.8) * length];
    let v = [Vec3::new(0.5, -1.0, 0.0), Vec3::new(2.0, 1.0, -3.0)];
    let mut spec = particles(&mass, &x, &v);
    spec.springs = vec![tension((0, 1), 1.0, stiffness, 0.0)];
    spec
}

/// Symplectic Euler, written out.
fn symplectic_step(system: &System, state: &mut State, h: f64) {
    let mut force = vec![Vec3::zeros(); state.len()];
    system.forces(state.level(), &mut force);
    for i in (0..state.len()).filter(|&i| !system.pinned()[i]) {
        state.v[i] += force[i] * (h / system.mass()[i]);
        state.x[i] += state.v[i] * h;
    }
}

fn largest_elongation(system: &System, x: &[Vec3]) -> f64 {
    let mut largest = f64::MIN;
    for effect in system.effects().filter_map(|effect| effect.split()) {
        effect.visit_rest_lengths(&mut |i, j, rest| {
            largest = largest.max((x[i] - x[j]).norm() / rest - 1.0);
        });
    }
    largest
}

#[test]
fn while_no_spring_is_too_long_it_is_symplectic_euler_bit_for_bit() {
    for law in [DampingLaw::Full, DampingLaw::Projected] {
        let mut spec = sheet(5, 1e3);
        spec.damping = law;
        spec.springs.iter_mut().for_each(|spring| spring.damping_n_s_per_m = 0.002);
        let mut run = prepared(limited(10.0), &spec, 0.005);
        let mut expected = run.state.clone();
        for _ in 0..100 {
            let report = run.step();
            symplectic_step(&run.system, &mut expected, 0.005);
            expected.t += 0.005;
            assert_eq!(bits(&run.state), bits(&expected), "{law:?}");
            assert_eq!(report, StepReport { force_evaluations: 1, ..StepReport::default() });
        }
        assert!(largest_elongation(&run.system, &run.state.x) > 0.01);
    }
}

#[test]
fn a_pair_that_is_too_long_ends_at_the_limit_with_the_velocity_of_its_displacement() {
    for mass in [[1.0, 1.0], [0.5, 2.0]] {
        let spec = pair(mass, 2.0, 10.0);
        let mut run = prepared(ProvotSettings::default(), &spec, 0.01);
        let start = run.state.clone();
        let report = run.step();
        let [d, uncorrected] = [&run.state, &{
            let mut state = start.clone();
            symplectic_step(&run.system, &mut state, 0.01);
            state
        }]
        .map(|state| state.x[0] - state.x[1]);
        assert!((d.norm() - 1.1).abs() < 1e-15);
        assert!(d.cross(&uncorrected).norm() < 1e-14, "along the spring");
        let share = mass[0].max(mass[1]) / (mass[0] + mass[1]);
        assert!((report.correction - share * (uncorrected.norm() - 1.1)).abs() < 1e-14);
        for i in 0..2 {
            let velocity = (run.state.x[i] - start.x[i]) / 0.01;
            assert!((run.state.v[i] - velocity).norm() < 1e-13);
        }
    }
}

#[test]
fn with_positions_only_the_velocities_are_those_of_symplectic_euler() {
    let settings =
        ProvotSettings { velocity: VelocityUpdate::PositionsOnly, ..ProvotSettings::default() };
    let mut run = prepared(settings, &pair([0.5, 2.0], 2.0, 10.0), 0.01);
    let mut expected = run.state.clone();
    symplectic_step(&run.system, &mut expected, 0.01);
    let report = run.step();
    assert_eq!(run.state.v, expected.v);
    assert!(report.correction > 0.5 && run.state.x != expected.x);
}

#[test]
fn pinned_ends_do_not_move_and_two_leave_the_spring_as_it_is() {
    for pinned in [vec![0], vec![1], vec![0, 1]] {
        let mut spec = pair([0.5, 2.0], 2.0, 10.0);
        spec.pins = pinned.iter().map(|&i| pin(i)).collect();
        let mut run = prepared(ProvotSettings::default(), &spec, 0.01);
        let start = run.state.x.clone();
        let report = run.step();
        for &i in &pinned {
            assert_eq!(run.state.x[i], start[i]);
            assert_eq!(run.state.v[i], Vec3::zeros());
        }
        let length = (run.state.x[0] - run.state.x[1]).norm();
        let expected = if pinned.len() == 2 { 2.0 } else { 1.1 };
        assert!((length - expected).abs() < 1e-15, "{pinned:?}: {length}");
        assert_eq!(report.correction > 0.0, pinned.len() < 2);
    }
}

#[test]
fn the_result_depends_on_the_order_of_the_springs() {
    let end = |order, sweeps| {
        let settings = ProvotSettings {
            elongation: ElongationSettings { limit: 0.02, order, sweeps },
            ..ProvotSettings::default()
        };
        let mut run = prepared(settings, &sheet(6, 400.0), 0.005);
        run.steps(100);
        run.state.x
    };
    let forward = end(SweepOrder::Forward, 2);
    for order in [SweepOrder::Backward, SweepOrder::Alternating, SweepOrder::Shuffled] {
        let other = end(order, 2);
        assert!(apart(&forward, &other) > 1e-3, "{order:?}: {:e}", apart(&forward, &other));
    }
    assert_eq!(forward, end(SweepOrder::Forward, 2));
    assert_eq!(end(SweepOrder::Forward, 1), end(SweepOrder::Alternating, 1));
}

#[test]
fn more_sweeps_leave_less_elongation_on_a_hanging_sheet() {
    let elongations = [1, 3, 10, 100].map(|sweeps| {
        let settings = ProvotSettings {
            elongation: ElongationSettings { limit: 0.05, sweeps, ..ElongationSettings::default() },
            ..ProvotSettings::default()
        };
        let mut run = prepared(settings, &sheet(6, 400.0), 0.005);
        let mut largest: f64 = 0.0;
        for _ in 0..200 {
            run.step();
            largest = largest.max(largest_elongation(&run.system, &run.state.x));
        }
        largest
    });
    assert!(elongations.windows(2).all(|pair| pair[1] < pair[0]), "{elongations:?}");
    assert!(elongations[0] > 0.06 && elongations[3] < 0.0501, "{elongations:?}");
    let mut free = prepared(limited(10.0), &sheet(6, 400.0), 0.005);
    free.steps(60);
    assert!(largest_elongation(&free.system, &free.state.x) > 2.0 * elongations[0]);
}

/// Nothing is damped. The unit is the energy of the sheet's fall by its own length.
#[test]
fn energy_is_lost_with_corrected_velocities_and_gained_with_positions_only() {
    let change = |limit, velocity| {
        let settings = ProvotSettings {
            elongation: ElongationSettings { limit, ..ElongationSettings::default() },
            velocity,
        };
        let mut run = prepared(settings, &sheet(6, 400.0), 0.005);
        let start = run.energy();
        run.steps(200);
        let unit = 9.81 * run.system.mass().iter().sum::<f64>();
        (run.energy() - start) / unit
    };
    let symplectic = change(10.0, VelocityUpdate::Corrected);
    assert!(symplectic.abs() < 0.01, "{symplectic}");
    let lost = change(0.1, VelocityUpdate::Corrected);
    assert!((-0.2..-0.1).contains(&lost), "{lost}");
    let gained = change(0.1, VelocityUpdate::PositionsOnly);
    assert!(gained > 10.0, "{gained}");
}

/// The correction moves particles along the line of the new positions. The angular momentum over
/// the reduced mass is `d_n × d_{n+1}/h` with `v = (x_{n+1} − x_n)/h`, else `d_{n+1} × v`. It
/// shrinks as `d_{n+1}` does.
#[test]
fn angular_momentum_is_lost_by_the_factor_of_shortening() {
    for velocity in [VelocityUpdate::Corrected, VelocityUpdate::PositionsOnly] {
        let mut spec = pair([0.5, 2.0], 1.1, 10.0);
        spec.particles.velocity_m_s = vec![[3.0, 0.0, 0.0], [-3.0, 0.0, 0.0]];
        let settings = ProvotSettings { velocity, ..ProvotSettings::default() };
        let mut run = prepared(settings, &spec, 0.02);
        for _ in 0..20 {
            let spin = |state: &State| (state.x[0] - state.x[1]).cross(&(state.v[0] - state.v[1]));
            let before = spin(&run.state);
            let mut predicted = run.state.clone();
            symplectic_step(&run.system, &mut predicted, 0.02);
            let longer = (predicted.x[0] - predicted.x[1]).norm();
            let correction = run.step().correction;
            assert!(correction > 0.0 && longer > 1.1);
            let error = (spin(&run.state) - before * (1.1 / longer)).norm();
            assert!(error < 1e-13 * before.norm(), "{velocity:?}: {error:e}");
        }
    }
}

/// A correction of a particle in contact is no impact, and the next steps lead the particle out.
#[test]
fn a_correction_may_push_into_an_obstacle_and_the_next_steps_lead_out() {
    let x = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 0.0)];
    let mut spec = particles(&[1.0; 2], &x, &[Vec3::zeros(); 2]);
    spec.springs = vec![tension((0, 1), 0.9, 10.0, 0.0)];
    spec.pins = vec![pin(0)];
    spec.obstacles = vec![floor(1.0)];
    let mut run = prepared(limited(0.1), &spec, 0.01);
    run.step();
    assert!((run.state.x[1].z + 0.01).abs() < 1e-15, "pushed in by the limit of 0.99 m");
    assert_eq!(run.state.v[1].z, 0.0, "but not moving in");
    // Freed, the spring pulls it inwards, and the floor leads it out.
    assert!(run.system.set_pinned(0, false));
    let depth = |run: &Run| -run.state.x[1].z;
    let mut before = depth(&run);
    for _ in 0..200 {
        run.step();
        assert!(depth(&run) <= before.max(1e-9) + 1e-15, "{}", depth(&run));
        before = depth(&run);
    }
    assert!(before < 1e-9, "{before}");
}

#[test]
fn settings_are_read_and_wrong_ones_refused() {
    let default = ProvotSettings::from_pairs([]).expect("defaults");
    assert_eq!(default, ProvotSettings::default());
    let all =
        [("limit", "0.5"), ("sweeps", "7"), ("order", "shuffled"), ("velocity", "positions-only")];
    let expected = ProvotSettings {
        elongation: ElongationSettings { limit: 0.5, sweeps: 7, order: SweepOrder::Shuffled },
        velocity: VelocityUpdate::PositionsOnly,
    };
    assert_eq!(ProvotSettings::from_pairs(all).expect("valid"), expected);
    for pair in [
        ("limit", "0"),
        ("limit", "11"),
        ("sweeps", "0"),
        ("sweeps", "1001"),
        ("sweeps", "1.5"),
        ("order", "random"),
        ("velocity", "old"),
        ("tolerance", "1"),
    ] {
        assert!(ProvotSettings::from_pairs([pair]).is_err(), "{pair:?}");
    }
}

use super::*;
use crate::test_support::{GRAVITY, Run, floor, gravity, particles, pin, sheet, spring};
use drape_integrator::{ElongationSettings, Integrator, Setups, SweepOrder};
use drape_model::{DampingLaw, SystemSpec, Vec3};
use drape_oracle::laws::{Drift, free_fall};
use drape_oracle::recurrence::symplectic_euler;
use nalgebra::Vector2;

/// A power of two, so that `θ` and `η` are met exactly.
const H: f64 = 1.0 / 64.0;

fn with(settings: ProvotSettings) -> Provot {
    Provot::new(settings)
}

fn limited(limit: f64) -> Provot {
    with(ProvotSettings {
        elongation: ElongationSettings { limit, ..ElongationSettings::default() },
        ..ProvotSettings::default()
    })
}

/// Two particles with a spring of rest length 1, in motion.
fn pair(mass: [f64; 2], length: f64, stiffness: f64) -> SystemSpec {
    let x = [Vec3::zeros(), Vec3::new(0.0, 0.6, -0.8) * length];
    let v = [Vec3::new(0.5, -1.0, 0.0), Vec3::new(2.0, 1.0, -3.0)];
    let mut spec = particles(&mass, &x, &v);
    spec.springs = vec![spring((0, 1), 1.0, stiffness, 0.0)];
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

fn bits(state: &State) -> Vec<u64> {
    let vectors = state.x.iter().chain(&state.v);
    vectors.flat_map(|a| a.iter().copied()).chain([state.t]).map(f64::to_bits).collect()
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
        spec.springs.iter_mut().for_each(|spring| spring.damping_n_s_per_m = 0.02);
        let mut run = Run::new(limited(10.0), &spec, 0.005);
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

/// A spring of rest length 0 has no limit.
#[test]
fn an_anchored_spring_of_rest_length_zero_moves_by_the_recurrence() {
    let (mass, x, v) = (0.25, Vec3::new(1.0, -0.5, 0.75), Vec3::new(0.0, 40.0, 7.0));
    for (theta, eta) in [(0.36, 0.06), (100.0, 0.4), (100.0, 0.0), (1.0, 0.0)] {
        let mut spec = particles(&[mass; 2], &[Vec3::zeros(), x], &[Vec3::zeros(), v]);
        spec.pins = vec![pin(0)];
        spec.springs = vec![spring((0, 1), 0.0, theta * mass / (H * H), eta * mass / H)];
        let mut run = Run::new(Provot::default(), &spec, H);
        let mut exact = [0, 1, 2].map(|axis| Vector2::new(x[axis], H * v[axis]));
        for step in 0..100 {
            // Beyond, squares of an unstable solution overflow.
            if exact[0].norm() > 1e100 {
                assert!(step > 45);
                break;
            }
            run.step();
            let size = exact.iter().map(Vector2::norm).fold(0.0, f64::max);
            for (axis, exact) in exact.iter_mut().enumerate() {
                *exact = symplectic_euler(theta, eta) * *exact;
                let found = Vector2::new(run.state.x[1][axis], H * run.state.v[1][axis]);
                let error = (found - *exact).norm() / exact.norm().max(size);
                assert!(error < 1e-12, "{theta} {eta} step {step}: {error:e}");
            }
        }
    }
}

#[test]
fn free_fall_is_the_parabola_of_symplectic_euler() {
    let mut spec = sheet(4, 1e3);
    spec.pins.clear();
    let mut run = Run::new(limited(1e-4), &spec, 0.01);
    let start = run.state.x.clone();
    run.steps(50);
    for (x, &start) in run.state.x.iter().zip(&start) {
        let (expected, _) = free_fall(Drift::NewVelocity, start, Vec3::zeros(), GRAVITY, 0.01, 50);
        assert!((x - expected).norm() < 1e-12);
    }
}

#[test]
fn a_pair_that_is_too_long_ends_at_the_limit_with_the_velocity_of_its_displacement() {
    for mass in [[1.0, 1.0], [0.5, 2.0]] {
        let spec = pair(mass, 2.0, 10.0);
        let mut run = Run::new(Provot::default(), &spec, 0.01);
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
    let mut run = Run::new(with(settings), &pair([0.5, 2.0], 2.0, 10.0), 0.01);
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
        let mut run = Run::new(Provot::default(), &spec, 0.01);
        let start = run.state.x.clone();
        let report = run.step();
        for &i in &pinned {
            assert_eq!(run.state.x[i as usize], start[i as usize]);
            assert_eq!(run.state.v[i as usize], Vec3::zeros());
        }
        let length = (run.state.x[0] - run.state.x[1]).norm();
        let expected = if pinned.len() == 2 { 2.0 } else { 1.1 };
        assert!((length - expected).abs() < 1e-15, "{pinned:?}: {length}");
        assert_eq!(report.correction > 0.0, pinned.len() < 2);
    }
}

#[test]
fn the_result_depends_on_the_order_of_the_springs() {
    let run = |order, sweeps| {
        let settings = ProvotSettings {
            elongation: ElongationSettings { limit: 0.02, order, sweeps },
            ..ProvotSettings::default()
        };
        let mut run = Run::new(with(settings), &sheet(6, 400.0), 0.005);
        run.steps(100);
        run.state.x
    };
    let apart =
        |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let forward = run(SweepOrder::Forward, 2);
    for order in [SweepOrder::Backward, SweepOrder::Alternating, SweepOrder::Shuffled] {
        let other = run(order, 2);
        assert!(apart(&forward, &other) > 1e-3, "{order:?}: {:e}", apart(&forward, &other));
    }
    assert_eq!(forward, run(SweepOrder::Forward, 2));
    assert_eq!(run(SweepOrder::Forward, 1), run(SweepOrder::Alternating, 1));
}

#[test]
fn more_sweeps_leave_less_elongation_on_a_hanging_sheet() {
    let elongations = [1, 3, 10, 100].map(|sweeps| {
        let settings = ProvotSettings {
            elongation: ElongationSettings { limit: 0.05, sweeps, ..ElongationSettings::default() },
            ..ProvotSettings::default()
        };
        let mut run = Run::new(with(settings), &sheet(6, 400.0), 0.005);
        let mut largest: f64 = 0.0;
        for _ in 0..200 {
            run.step();
            largest = largest.max(largest_elongation(&run.system, &run.state.x));
        }
        largest
    });
    assert!(elongations.windows(2).all(|pair| pair[1] < pair[0]), "{elongations:?}");
    assert!(elongations[0] > 0.06 && elongations[3] < 0.0501, "{elongations:?}");
    let mut free = Run::new(limited(10.0), &sheet(6, 400.0), 0.005);
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
        let mut run = Run::new(with(settings), &sheet(6, 400.0), 0.005);
        let start = run.system.total_energy(&run.state);
        run.steps(200);
        let unit = 9.81 * run.system.mass().iter().sum::<f64>();
        (run.system.total_energy(&run.state) - start) / unit
    };
    let symplectic = change(10.0, VelocityUpdate::Corrected);
    assert!(symplectic.abs() < 0.01, "{symplectic}");
    let lost = change(0.1, VelocityUpdate::Corrected);
    assert!((-0.2..-0.1).contains(&lost), "{lost}");
    let gained = change(0.1, VelocityUpdate::PositionsOnly);
    assert!(gained > 10.0, "{gained}");
}

#[test]
fn momentum_is_conserved_with_unequal_masses_and_either_velocity() {
    for velocity in [VelocityUpdate::Corrected, VelocityUpdate::PositionsOnly] {
        let mut spec = sheet(5, 1e3);
        spec.pins.clear();
        spec.effects.gravity = None;
        for (i, mass) in spec.particles.mass_kg.iter_mut().enumerate() {
            *mass *= 1.0 + (i % 4) as f64;
        }
        for (i, v) in spec.particles.velocity_m_s.iter_mut().enumerate() {
            let i = i as f64;
            *v = [(3.0 * i).sin(), i.cos(), (2.0 * i).sin()];
        }
        let settings = ProvotSettings {
            elongation: ElongationSettings { limit: 0.02, ..ElongationSettings::default() },
            velocity,
        };
        let mut run = Run::new(with(settings), &spec, 0.005);
        let momentum = run.system.momentum(&run.state);
        let mut moved = 0.0;
        for _ in 0..100 {
            moved += run.step().correction;
        }
        assert!(moved > 0.05);
        let change = (run.system.momentum(&run.state) - momentum).norm();
        assert!(change < 1e-13, "{velocity:?}: {change:e}");
    }
}

/// What is moved stays on the line of the new positions. With `v = (x_{n+1} − x_n)/h` the angular momentum is
/// `d_n × d_{n+1}/h` times the reduced mass, else `d_{n+1} × v`: it shrinks as `d_{n+1}` does.
#[test]
fn angular_momentum_is_lost_by_the_factor_of_shortening() {
    for velocity in [VelocityUpdate::Corrected, VelocityUpdate::PositionsOnly] {
        let mut spec = pair([0.5, 2.0], 1.1, 10.0);
        spec.particles.velocity_m_s = vec![[3.0, 0.0, 0.0], [-3.0, 0.0, 0.0]];
        let settings = ProvotSettings { velocity, ..ProvotSettings::default() };
        let mut run = Run::new(with(settings), &spec, 0.02);
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

/// What pushes a particle in contact is no impact, and what it leaves inside is led out.
#[test]
fn a_correction_may_push_into_an_obstacle_and_the_next_steps_lead_out() {
    let x = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 0.0)];
    let mut spec = particles(&[1.0; 2], &x, &[Vec3::zeros(); 2]);
    spec.springs = vec![spring((0, 1), 0.9, 10.0, 0.0)];
    spec.pins = vec![pin(0)];
    spec.obstacles = vec![floor(1.0)];
    let mut run = Run::new(limited(0.1), &spec, 0.01);
    run.step();
    assert!((run.state.x[1].z + 0.01).abs() < 1e-15, "pushed in by the limit of 0.99 m");
    assert_eq!(run.state.v[1].z, 0.0, "but not moving in");
    // Freed, the spring pulls it inwards, and the floor leads it out.
    assert!(run.system.set_pinned(0, false));
    let depth = |run: &Run<Provot>| -run.state.x[1].z;
    let mut before = depth(&run);
    for _ in 0..200 {
        run.step();
        assert!(depth(&run) <= before.max(1e-9) + 1e-15, "{}", depth(&run));
        before = depth(&run);
    }
    assert!(before < 1e-9, "{before}");
}

#[test]
fn changes_of_mass_pins_stiffness_and_step_need_no_new_preparation() {
    let settings = ProvotSettings {
        elongation: ElongationSettings { limit: 0.02, ..ElongationSettings::default() },
        ..ProvotSettings::default()
    };
    let mut run = Run::new(with(settings), &sheet(5, 400.0), 0.005);
    run.steps(40);
    let heavier: Vec<f64> = run.system.mass().iter().map(|m| 3.0 * m).collect();
    assert!(run.system.set_mass(&heavier) && run.system.scale_stiffness("tension", 2.0));
    assert!(run.system.set_pinned(12, true) && run.system.set_pinned(0, false));
    run.h = 0.003;
    run.integrator.restart(&run.state);
    let (system, state) = (run.system.clone(), run.state.clone());
    let mut fresh = Run::of(with(settings), system, state, 0.003);
    for _ in 0..5 {
        let (a, b) = (run.step(), fresh.step());
        assert_eq!((bits(&run.state), a), (bits(&fresh.state), b));
        assert_eq!(a.setups, Setups::default());
        assert_eq!(run.state.v[12], Vec3::zeros());
    }
}

#[test]
fn a_blow_up_is_a_result() {
    let mut spec = sheet(4, 1e6);
    spec.effects.gravity = gravity();
    let settings = ProvotSettings {
        elongation: ElongationSettings { sweeps: 3, ..ElongationSettings::default() },
        ..ProvotSettings::default()
    };
    for velocity in [VelocityUpdate::Corrected, VelocityUpdate::PositionsOnly] {
        let mut run = Run::new(with(ProvotSettings { velocity, ..settings }), &spec, 10.0);
        run.steps(50);
        run.state.x[7].x = f64::NAN;
        run.steps(5);
        run.state.x[7].x = f64::INFINITY;
        run.steps(5);
        assert!(!run.state.is_finite());
    }
}

/// Shortly after a contact an impact is rest, for an integrator that knows of the contact.
#[test]
fn contacts_bounce_and_recover_as_they_do_without_a_limit_and_a_restart_forgets_them() {
    let mut spec = particles(&[2.0], &[Vec3::zeros()], &[Vec3::zeros()]);
    spec.obstacles = vec![floor(1.0)];
    let mut run = Run::new(Provot::default(), &spec, 1e-3);
    for (restarts, speed) in [(false, 0.0), (true, 3.0)] {
        run.steps(2);
        run.state.v[0].z = -3.0;
        if restarts {
            run.integrator.restart(&run.state);
        }
        run.step();
        assert_eq!(run.state.v[0].z, speed);
        (run.state.x[0].z, run.state.v[0].z) = (0.0, 0.0);
    }
    // Led out of the floor, a particle keeps nothing of that speed.
    run.state.x[0].z = -0.1;
    run.step();
    assert!(run.state.x[0].z > -0.1 && run.state.v[0].z == 0.0);
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

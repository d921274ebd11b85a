//! Spin of two particles, free fall, hanging chain: laws that hold at any amplitude.

use drape_model::{DampingLaw, SpringEffect, Vec3};
use drape_oracle::Random;
use drape_oracle::laws::{Drift, free_fall, hanging_chain, spin};
use drape_tests::{GRAVITY, Run, Sheet, build, gravity, particles, pin, spring};

const H: f64 = 1.0 / 64.0;

/// `θ`, `η`, `ℓ/L` before and after the step.
type Factor = fn(f64, f64, f64, f64) -> f64;

struct Case {
    id: &'static str,
    law: DampingLaw,
    theta: &'static [f64],
    factor: Factor,
    tolerance: f64,
}

const fn case(
    id: &'static str,
    law: DampingLaw,
    theta: &'static [f64],
    tolerance: f64,
    factor: Factor,
) -> Case {
    Case { id, law, theta, factor, tolerance }
}

const EXACT: f64 = 1e-12;
const NEWTON: f64 = 1e-9;
const SMALL: &[f64] = &[0.01, 0.3];
const ANY: &[f64] = &[0.01, 1.0, 100.0, 1e4, 1e8];
const UPDATED: &[f64] = &[0.01, 1.0, 50.0];
const CHOLESKY: &str = "imex-euler:solver=cholesky";
const NEWTONS: &str = "backward-euler:residual=1e-16,max_iterations=10000";
const ALGORITHM_1: &str = "imex-updated:forcing_term=1e-16,max_outer=100000,newton_above=1e300";

/// The factors of the spin, each with the damping that it holds for.
const SPINS: [Case; 11] = [
    case("explicit-euler", DampingLaw::Full, SMALL, EXACT, |theta, eta, before, _| {
        spin::explicit_euler(theta, eta, before)
    }),
    case("symplectic-euler", DampingLaw::Full, SMALL, EXACT, |_, eta, _, _| {
        spin::symplectic_euler(eta)
    }),
    case("symplectic-euler", DampingLaw::Projected, SMALL, EXACT, |_, _, _, _| {
        spin::symplectic_euler(0.0)
    }),
    case("symplectic-euler:damping=implicit", DampingLaw::Full, SMALL, EXACT, |_, eta, _, _| {
        spin::symplectic_euler_implicit_damping(eta)
    }),
    case("symplectic-euler:damping=implicit", DampingLaw::Projected, SMALL, EXACT, |_, _, _, _| {
        spin::symplectic_euler(0.0)
    }),
    case(NEWTONS, DampingLaw::Full, ANY, NEWTON, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    }),
    case(NEWTONS, DampingLaw::Projected, ANY, NEWTON, |theta, _, _, after| {
        spin::backward_euler(theta, 0.0, after)
    }),
    case(CHOLESKY, DampingLaw::Full, ANY, EXACT, |theta, eta, _, _| spin::imex_euler(theta, eta)),
    case("imex-euler:forcing_term=1e-14", DampingLaw::Full, ANY, EXACT, |theta, eta, _, _| {
        spin::imex_euler(theta, eta)
    }),
    case(CHOLESKY, DampingLaw::Projected, ANY, EXACT, |theta, eta, _, _| {
        spin::imex_euler_projected_damping(theta, eta)
    }),
    case(ALGORITHM_1, DampingLaw::Full, UPDATED, NEWTON, |theta, eta, _, after| {
        spin::backward_euler(theta, eta, after)
    }),
];

/// Stretched, compressed and fast: each step multiplies the angular momentum by the factor that
/// the method's formulas give, and leaves the momentum alone.
#[test]
fn two_particles_spin_as_the_law_of_each_method_says() {
    let mut random = Random::new(3);
    let (mass, rest) = (0.25, 0.5);
    for Case { id, law, theta, factor, tolerance } in &SPINS {
        for &theta in *theta {
            for eta in [0.0, 0.125] {
                let (k, c) = (0.5 * theta * mass / (H * H), 0.5 * eta * mass / H);
                for _ in 0..4 {
                    let d = random.vector().normalize() * (rest * random.between(0.1, 3.0));
                    let velocities = [random.vector() * 8.0, random.vector() * 8.0];
                    let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &velocities);
                    spec.damping = *law;
                    spec.springs = vec![spring(SpringEffect::Tension, (0, 1), rest, k, c)];
                    let mut run = Run::new(id, build(&spec), H);
                    let momentum = run.system.momentum(&run.state);
                    for step in 0..200 {
                        let relative = |run: &Run| {
                            let (x, v) = (&run.state.x, &run.state.v);
                            (x[1] - x[0], v[1] - v[0])
                        };
                        let (d, v) = relative(&run);
                        run.step();
                        let (d_after, v_after) = relative(&run);
                        let factor = factor(theta, eta, rest / d.norm(), rest / d_after.norm());
                        // What the terms of the step add up from.
                        let drift = run.system.momentum(&run.state).norm() / mass;
                        let speed =
                            drift + v.norm() + v_after.norm() + theta * (d.norm() + rest) / H;
                        let length = d.norm().max(d_after.norm());
                        let case = format!("{id}, {law:?}, θ={theta} η={eta}, step {step}");
                        let wrong = d_after.cross(&v_after) - d.cross(&v) * factor;
                        let relative = wrong.norm() / (length * speed);
                        assert!(relative < *tolerance, "{case}: spin off by {relative:e}");
                        let drift = run.system.momentum(&run.state) - momentum;
                        let relative = drift.norm() / (mass * speed);
                        assert!(relative < 1e-11, "{case}: momentum off by {relative:e}");
                    }
                }
            }
        }
    }
}

/// A factor of another method does not pass: the law of backward Euler is not that of IMEX Euler.
#[test]
fn the_laws_of_spin_tell_the_methods_apart() {
    let (theta, eta) = (1.0, 0.0);
    let factors = [
        spin::explicit_euler(theta, eta, 0.5),
        spin::symplectic_euler(eta),
        spin::backward_euler(theta, eta, 0.5),
        spin::imex_euler(theta, eta),
    ];
    for (i, a) in factors.iter().enumerate() {
        assert!(factors[..i].iter().all(|b| (a - b).abs() > 0.1), "{factors:?}");
    }
}

/// An unpinned sheet falls by the method's own parabola and feels no spring.
#[test]
fn a_free_sheet_falls_on_the_discrete_parabola() {
    // Explicit methods stay below their limits: round-off must not grow.
    let (soft, stiff) = (100.0, 1e6);
    let methods = [
        ("explicit-euler", soft, Drift::OldVelocity),
        ("symplectic-euler", soft, Drift::NewVelocity),
        ("symplectic-euler:damping=implicit", soft, Drift::NewVelocity),
        ("backward-euler", stiff, Drift::NewVelocity),
        ("imex-euler:forcing_term=1e-14", stiff, Drift::NewVelocity),
        ("imex-euler:solver=cholesky,implicit=springs", stiff, Drift::NewVelocity),
        ("imex-updated:forcing_term=1e-12", stiff, Drift::NewVelocity),
        ("imex-updated:safeguard=paper,forcing_term=1e-14", stiff, Drift::NewVelocity),
    ];
    let velocity = Vec3::new(1.0, -2.0, 3.0);
    for (id, tension, drift) in methods {
        // Widths of 1/8 m: the lengths of the springs are met exactly.
        let (shear, law) = (0.1 * tension, DampingLaw::Full);
        let sheet = Sheet { side: 9, tension, shear, damping: 4.0, law, pinned: false };
        let (system, mut state) = sheet.build();
        state.v.fill(velocity);
        let start = state.clone();
        let mut run = Run::new(id, (system, state), H);
        for steps in 1..=20 {
            run.step();
            let mut tension = vec![Vec3::zeros(); run.state.len()];
            for effect in run.system.effects().filter(|effect| effect.name() != "gravity") {
                effect.add_force(run.system.mass(), &run.state.x, &mut tension);
            }
            for i in 0..run.state.len() {
                let (x, v) = free_fall(drift, start.x[i], velocity, GRAVITY, H, steps);
                let errors = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
                assert!(errors < 1e-11, "{id}, step {steps}, particle {i}: {errors:e}");
                let force = tension[i].norm() / (run.system.mass()[i] * GRAVITY.norm());
                assert!(force < 1e-7, "{id}, step {steps}, particle {i}: {force:e} of its weight");
            }
        }
    }
}

/// A damped chain comes to rest with each spring stretched by the weight below it.
#[test]
fn a_hanging_chain_comes_to_rest_at_its_static_lengths() {
    const LINKS: usize = 8;
    let methods = [
        ("symplectic-euler", 1.0 / 512.0),
        ("symplectic-euler:damping=implicit", 1.0 / 512.0),
        ("backward-euler", 1.0 / 32.0),
        ("imex-euler:solver=cholesky", 1.0 / 32.0),
        ("imex-euler", 1.0 / 32.0),
        ("imex-updated:forcing_term=1e-9", 1.0 / 32.0),
    ];
    let masses: Vec<f64> = (0..LINKS).map(|j| 0.5 + 0.125 * j as f64).collect();
    let stiffness: Vec<f64> = (0..LINKS).map(|j| 1000.0 - 50.0 * j as f64).collect();
    let rest: Vec<f64> = (0..LINKS).map(|j| 0.25 + 0.03125 * (j % 3) as f64).collect();
    let mut positions = vec![Vec3::zeros()];
    for length in &rest {
        let last = positions[positions.len() - 1];
        positions.push(last - Vec3::z() * *length);
    }
    let all_masses: Vec<f64> = std::iter::once(1.0).chain(masses.iter().copied()).collect();
    let mut spec = particles(&all_masses, &positions, &[]);
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    spec.springs = (0..LINKS)
        .map(|j| spring(SpringEffect::Tension, (j, j + 1), rest[j], stiffness[j], 20.0))
        .collect();
    let expected = hanging_chain(&masses, &stiffness, &rest, GRAVITY.norm());
    for (id, h) in methods {
        let mut run = Run::new(id, build(&spec), h);
        for _ in 0..(64.0 / h) as usize {
            run.step();
        }
        for (j, expected) in expected.iter().enumerate() {
            let length = (run.state.x[j + 1] - run.state.x[j]).norm();
            assert!((length - expected).abs() < 1e-8, "{id}, spring {j}: {length}, not {expected}");
        }
    }
}

/// At rest the round-off of the positions alone keeps the residual above its tolerance. Newton's
/// method must see that and stop, not use up its iterations.
#[test]
fn newton_stops_where_round_off_ends_all_progress() {
    let (mass, rest) = (0.25, 0.5);
    let mut random = Random::new(9);
    for theta in [1e2, 1e4, 1e8] {
        for _ in 0..20 {
            let d = random.vector().normalize() * rest;
            let slow = [random.vector() * 1e-8, random.vector() * 1e-8];
            let mut spec = particles(&[mass; 2], &[Vec3::zeros(), d], &slow);
            let k = 0.5 * theta * mass / (H * H);
            spec.springs = vec![spring(SpringEffect::Tension, (0, 1), rest, k, 0.0)];
            let mut run = Run::new("backward-euler:residual=1e-16", build(&spec), H);
            for step in 0..20 {
                let report = run.step();
                assert!(report.newton_iterations < 10, "θ={theta}, step {step}: {report:?}");
            }
        }
    }
}

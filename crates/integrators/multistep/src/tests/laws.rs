//! Free fall, momentum, spin, hanging chain.

use super::{Run, STEPS, adams, all, bdf, build, gravity, particles, pin, spring, tetrahedron};
use crate::Steps;
use drape_model::{DampingLaw, SystemSpec, Vec3};
use drape_oracle::Random;
use drape_oracle::laws::{Drift, free_fall, hanging_chain, spin};

const H: f64 = 1.0 / 64.0;
const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);

/// Position and velocity under gravity after `n` steps. Means over levels are exact for a parabola: what
/// differs from it comes from the first step.
fn fallen(id: &str, steps: Steps, x: Vec3, v: Vec3, n: u32) -> (Vec3, Vec3) {
    let t = H * f64::from(n);
    let parabola = x + v * t + GRAVITY * (0.5 * t * t);
    let position = match (id, steps) {
        ("adams-bashforth2", Steps::One) => {
            return free_fall(Drift::OldVelocity, x, v, GRAVITY, H, n);
        }
        ("bdf2", Steps::One) => return free_fall(Drift::NewVelocity, x, v, GRAVITY, H, n),
        // Backward Euler falls ½ h² g too far; of that the old levels keep 1 + 1/3 + 1/9 + …
        ("bdf2", Steps::Two) => {
            parabola + GRAVITY * (0.75 * H * H * (1.0 - 3.0_f64.powi(-(n as i32))))
        }
        _ => parabola,
    };
    (position, v + GRAVITY * t)
}

#[test]
fn a_free_net_falls_on_the_parabola_of_the_method_and_feels_no_spring() {
    let velocity = Vec3::new(1.0, -2.0, 3.0);
    for (family, steps) in all() {
        let mut spec = tetrahedron(DampingLaw::Full);
        spec.pins.clear();
        spec.particles.velocity_m_s = vec![velocity.into(); 4];
        let (_, start) = build(&spec);
        for spring in &mut spec.springs {
            let (i, j) = (spring.i as usize, spring.j as usize);
            spring.rest_length_m = (start.x[i] - start.x[j]).norm();
        }
        let mut run = Run::new(family(steps), build(&spec), H);
        let id = run.integrator.method().id;
        for n in 1..=20 {
            run.step();
            for i in 0..4 {
                let (x, v) = fallen(id, steps, start.x[i], velocity, n);
                let error = (run.state.x[i] - x).norm() + (run.state.v[i] - v).norm();
                assert!(error < 1e-12, "{id}, {steps:?}, step {n}, particle {i}: {error:e}");
            }
        }
    }
}

/// Three free particles on three undamped springs, unequal masses.
fn triangle() -> SystemSpec {
    let position = [Vec3::zeros(), Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.3, 0.8, 0.2)];
    let velocity =
        [Vec3::new(0.3, -1.0, 0.5), Vec3::new(0.0, 2.0, 0.1), Vec3::new(-1.0, 0.2, -0.9)];
    let mut spec = particles(&[0.2, 0.5, 0.3], &position, &velocity);
    spec.springs = [(0, 1), (1, 2), (0, 2)].map(|pair| spring(pair, 0.7, 50.0, 0.0)).to_vec();
    spec
}

#[test]
fn momentum_is_conserved_and_angular_momentum_is_not() {
    for (family, steps) in all() {
        let mut run = Run::new(family(steps), build(&triangle()), H);
        let of =
            |run: &Run| (run.system.momentum(&run.state), run.system.angular_momentum(&run.state));
        let (momentum, angular) = of(&run);
        (0..100).for_each(|_| {
            run.step();
        });
        let case = format!("{}, {steps:?}", run.integrator.method().id);
        let drift = (of(&run).0 - momentum).norm();
        assert!(drift < 1e-13 * momentum.norm().max(1.0), "{case}: momentum off by {drift:e}");
        let drift = (of(&run).1 - angular).norm() / angular.norm();
        assert!(drift > 1e-5, "{case}: angular momentum kept to {drift:e}");
    }
}

/// With one step the methods obey the laws of spin of the two Euler methods, stretched or compressed.
#[test]
fn one_step_spins_as_explicit_and_as_backward_euler() {
    let (mass, rest) = (0.25, 0.5);
    let mut random = Random::new(3);
    for (theta, eta) in [(0.01, 0.0), (0.3, 0.125), (0.3, 0.0)] {
        let mut spec = particles(
            &[mass; 2],
            &[Vec3::zeros(), random.vector() * 0.6],
            &[random.vector(), random.vector()],
        );
        let (k, c) = (0.5 * theta * mass / (H * H), 0.5 * eta * mass / H);
        spec.springs = vec![spring((0, 1), rest, k, c)];
        for (family, explicit) in [(adams as super::Family, true), (bdf, false)] {
            let mut run = Run::new(family(Steps::One), build(&spec), H);
            for step in 0..100 {
                let relative = |run: &Run| {
                    let (x, v) = (&run.state.x, &run.state.v);
                    (x[1] - x[0], v[1] - v[0])
                };
                let (d, v) = relative(&run);
                run.step();
                let (d_after, v_after) = relative(&run);
                let factor = match explicit {
                    true => spin::explicit_euler(theta, eta, rest / d.norm()),
                    false => spin::backward_euler(theta, eta, rest / d_after.norm()),
                };
                let wrong = (d_after.cross(&v_after) - d.cross(&v) * factor).norm();
                let size = d.norm() * v.norm() + d_after.norm() * v_after.norm();
                assert!(wrong < 1e-12 * size.max(rest), "{explicit}, step {step}: {wrong:e}");
            }
        }
    }
}

/// Two free particles that turn about each other: the loss of spin falls with the order.
#[test]
fn the_error_of_the_spin_falls_with_the_number_of_steps() {
    let spec = {
        let (x, v) = ([Vec3::x() * -0.25, Vec3::x() * 0.25], [Vec3::y() * -1.0, Vec3::y()]);
        let mut spec = particles(&[0.25; 2], &x, &v);
        spec.springs = vec![spring((0, 1), 0.4, 10.0, 0.0)];
        spec
    };
    for (family, steps) in all() {
        let error = |count: u32| {
            let mut run = Run::new(family(steps), build(&spec), 1.0 / f64::from(count));
            let start = run.system.angular_momentum(&run.state).z;
            (0..count).for_each(|_| {
                run.step();
            });
            assert!(run.state.x.iter().all(|x| x.z == 0.0), "leaves the plane");
            (run.system.angular_momentum(&run.state).z / start - 1.0).abs()
        };
        let order = (error(200) / error(400)).log2();
        let least = steps.count() as f64 - 0.2;
        assert!(order > least, "{family:?}, {steps:?}: {order}");
    }
}

#[test]
fn a_hanging_chain_comes_to_rest_at_its_static_lengths() {
    const LINKS: u32 = 5;
    let masses: Vec<f64> = (0..LINKS).map(|j| 0.5 + 0.125 * f64::from(j)).collect();
    let stiffness: Vec<f64> = (0..LINKS).map(|j| 1000.0 - 50.0 * f64::from(j)).collect();
    let rest = vec![0.25; LINKS as usize];
    let positions: Vec<Vec3> = (0..=LINKS).map(|j| Vec3::z() * (-0.25 * f64::from(j))).collect();
    let all_masses: Vec<f64> = std::iter::once(1.0).chain(masses.iter().copied()).collect();
    let mut spec = particles(&all_masses, &positions, &[]);
    spec.pins = vec![pin(0)];
    spec.effects.gravity = gravity();
    let link = |j: u32| spring((j, j + 1), rest[j as usize], stiffness[j as usize], 20.0);
    spec.springs = (0..LINKS).map(link).collect();
    let expected = hanging_chain(&masses, &stiffness, &rest, 9.81);
    for steps in STEPS {
        for (integrator, h) in [(adams(steps), 1.0 / 1024.0), (bdf(steps), 1.0 / 32.0)] {
            let mut run = Run::new(integrator, build(&spec), h);
            for _ in 0..(32.0 / h) as usize {
                run.step();
            }
            for (j, expected) in expected.iter().enumerate() {
                let length = (run.state.x[j + 1] - run.state.x[j]).norm();
                let case = format!("{}, {steps:?}", run.integrator.method().id);
                assert!((length - expected).abs() < 1e-8, "{case}, spring {j}: {length}");
            }
        }
    }
}
